//! The IMS360 in J1939: the same commands, with its parameters in Proprietary A.

use super::cyclic::texts;
use super::files::file;
use super::rig::Rig;
use bench::BusRate;
use plumbline::can::{BitRate, Frame, extended};
use serde_json::json;

/// A bus at 250 kbit/s with an IMS360 in J1939, and another node that acknowledges.
pub fn network(settings: &str) -> Rig {
    let mut rig = Rig::with("ims360");
    let other = rig.bus.borrow_mut().adapter();
    rig.bus.borrow_mut().open(other, None, false);
    if !settings.is_empty() {
        rig.done(&format!("--node 50 set {settings}"));
    }
    rig.done("--node 50 raw 3100:1=01");
    rig.done("--node 50 save");
    rig.done("--node 50 restart");
    rig.run(1000);
    rig.witnessed();
    rig
}

/// The frames with this source address.
fn sent_by(rig: &mut Rig, source: &str) -> Vec<String> {
    let frames = texts(&rig.witnessed());
    let own = frames.into_iter().filter(|frame| &frame[6..8] == source);
    own.collect()
}

#[test]
fn scan_names_the_sensor_from_its_process_data() {
    let mut rig = network("");
    let rows = rig.json("--rate 250 scan");
    let row = json!({"rate": 250, "protocol": "j1939", "product": "ims360", "address": "128", "serial": 1, "article": "IMS360", "firmware": "010000"});
    assert_eq!(rows, json!([row]));
    assert!(rig.questions.is_empty());
    // Nothing but requests, its claim, and the transport of the answers is sent; no 11-bit frame, and nothing proprietary.
    let seen = texts(&rig.witnessed());
    assert!(
        seen.iter().all(|frame| frame.find('#') == Some(8)),
        "{seen:?}"
    );
    assert!(
        !seen.iter().any(|frame| frame.starts_with("18EF")),
        "{seen:?}"
    );
    let claims = seen.iter().filter(|frame| frame.starts_with("18EEFFF9#"));
    assert_eq!(claims.count(), 1, "{seen:?}");
}

#[test]
fn sensor_without_process_data_is_found_by_its_diagnostic_message() {
    let mut rig = network("transmission-rate-ssi2=raw:0");
    let rows = rig.json("--rate 250 scan");
    assert_eq!(
        (&rows[0]["product"], &rows[0]["address"]),
        (&json!("ims360"), &json!("128"))
    );
    assert!(rig.questions.is_empty());
    let read = rig.json("get preferred-address");
    assert_eq!(read["preferred-address"]["raw"], 128);
}

#[test]
fn parameters_are_read_set_and_stored() {
    let mut rig = network("");
    let address = "--address 128";
    rig.done(&format!(
        "{address} set cut-off=2.5Hz filter-type=butterworth --save"
    ));
    let seen = sent_by(&mut rig, "F9");
    let writes = seen.iter().filter(|frame| frame.starts_with("18EF80F9#2"));
    assert!(writes.count() >= 3, "{seen:?}");
    rig.power_cycle(rig.first());
    let read = rig.json(&format!("{address} get filter"));
    assert_eq!(read["cut-off"]["raw"], 2500);
    assert_eq!(
        rig.fails(&format!("{address} set cut-off=30Hz")).1,
        "out-of-range"
    );
    assert_eq!(
        rig.fails(&format!("{address} raw 3100:1=03")),
        (1, "refused".to_owned())
    );
    assert_eq!(rig.fails("--address 129 get"), (3, "no-answer".to_owned()));
    assert_eq!(
        rig.fails("--address 254 get"),
        (2, "out-of-range".to_owned())
    );
    // Without an address it is found by listening.
    assert_eq!(rig.json("get cut-off")["cut-off"]["raw"], 2500);
}

#[test]
fn zero_restart_and_factory_values_work_as_in_canopen() {
    let mut rig = network("");
    rig.done("--address 128 zero --save");
    rig.witnessed();
    rig.done("--address 128 restart");
    rig.run(1000);
    let seen = texts(&rig.witnessed());
    let mut after_reset = seen
        .iter()
        .skip_while(|frame| !frame.starts_with("18EF80F9#2F102001"));
    assert!(after_reset.next().is_some(), "{seen:?}");
    assert!(
        after_reset.any(|frame| frame.starts_with("18EEFF80#")),
        "{seen:?}"
    );
    let read = rig.json("--address 128 get slope-long32");
    let angle = read["slope-long32"]["value"].as_f64().unwrap();
    assert!(angle.abs() < 0.02, "{read}");
    // The factory value of the protocol is CANopen.
    rig.done("--address 128 load-factory");
    rig.run(1000);
    rig.done("--rate 125 --node 50 get node-id");
}

#[test]
fn backup_is_restored_to_another_sensor() {
    let (one, two) = (file("j1939-1.toml"), file("j1939-2.toml"));
    let mut rig = network("cut-off=2.5Hz");
    rig.done("--address 128 set filter-type=butterworth zero-x=1.25deg tpdo2-cob-id=2B3h --save");
    rig.done(&format!("--address 128 backup {}", one.display()));
    let mut rig = network("");
    let restored = rig.json(&format!("--address 128 restore {}", one.display()));
    assert!(restored.as_object().unwrap().len() >= 3, "{restored}");
    assert_eq!(
        rig.json(&format!("--address 128 diff {}", one.display())),
        json!({})
    );
    rig.power_cycle(rig.first());
    rig.done(&format!("--address 128 backup {}", two.display()));
    let [one, two] = [one, two].map(|path| std::fs::read_to_string(path).unwrap());
    assert_eq!(one, two);
}

#[test]
fn address_is_shown_commanded_and_stored() {
    let mut rig = network("");
    let shown = rig.json("--address 128 address");
    assert_eq!(
        shown,
        json!({"address": 128, "preferred": 128, "name": "80009100FFE00001", "arbitrary": true})
    );
    rig.witnessed();
    rig.done("--address 128 address 160");
    let seen = sent_by(&mut rig, "F9");
    // Commanded Address, a message of nine bytes to all.
    for frame in [
        "1CECFFF9#20090002FFD8FE00",
        "1CEBFFF9#010100E0FF009100",
        "1CEBFFF9#0280A0FFFFFFFFFF",
    ] {
        assert!(seen.iter().any(|own| own == frame), "{frame} {seen:?}");
    }
    rig.power_cycle(rig.first());
    let shown = rig.json("--address 160 address");
    assert_eq!(
        (&shown["address"], &shown["preferred"]),
        (&json!(160), &json!(160))
    );
    assert_eq!(
        rig.fails("--address 160 address 254"),
        (2, "out-of-range".to_owned())
    );
    assert_eq!(
        Rig::with("is2").fails("address"),
        (2, "not-offered".to_owned())
    );
}

#[test]
fn sensor_that_does_not_obey_commanded_address_gets_the_parameter_and_a_restart() {
    let mut rig = network("");
    // The last packet of Commanded Address does not arrive.
    rig.lost = |frame| format!("{frame:?}").starts_with("1CEBFFF9#02");
    rig.done("--address 128 address 160");
    let seen = texts(&rig.witnessed());
    assert!(
        !seen.iter().any(|frame| frame.starts_with("1CEBFFF9#02")),
        "{seen:?}"
    );
    // Object 2102h, then "save", then the claim after the restart.
    let place = |start: &str| seen.iter().position(|frame| frame.starts_with(start));
    let written = place("18EF80F9#2F022100A0").expect("the parameter is written");
    let stored = place("18EF80F9#2310100173617665").expect("it is stored");
    let claimed = place("18EEFFA0#").expect("it has restarted");
    assert!(written < stored && stored < claimed, "{seen:?}");
    rig.power_cycle(rig.first());
    let shown = rig.json("--address 160 address");
    assert_eq!(
        (&shown["address"], &shown["preferred"]),
        (&json!(160), &json!(160))
    );
}

#[test]
fn address_in_use_is_refused_and_changes_nothing() {
    let mut rig = network("");
    // Another node claims 160 whenever it is asked: here all the time.
    let claim = Frame::data(extended(0x18EE_FFA0), &[5, 0, 0, 0, 0, 0, 0, 0]).unwrap();
    rig.cyclic = Some((40, claim));
    assert_eq!(
        rig.fails("--address 128 address 160"),
        (1, "address-in-use".to_owned())
    );
    assert_eq!(
        rig.fails("--address 128 set preferred-address=160"),
        (1, "address-in-use".to_owned())
    );
    let shown = rig.json("--address 128 address");
    assert_eq!(
        (&shown["address"], &shown["preferred"]),
        (&json!(128), &json!(128))
    );
}

#[test]
fn bit_rate_is_changed_without_layer_setting_services() {
    let mut rig = network("");
    rig.done("--address 128 rate 500");
    let seen = texts(&rig.witnessed());
    assert!(
        seen.iter().all(|frame| frame.find('#') == Some(8)),
        "{seen:?}"
    );
    let read = rig.json("--rate 500 --address 128 get baud-rate");
    assert_eq!(read["baud-rate"]["raw"], 500_000);
}

#[test]
fn angles_are_those_of_the_broadcast_group() {
    let mut rig = network("");
    rig.done("--address 128 get slope-long32");
    rig.witnessed();
    let out = rig.done("--json --address 128 watch --every 50 --seconds 1");
    let lines: Vec<&str> = out.lines().collect();
    assert!((20..=21).contains(&lines.len()), "{}", lines.len());
    let sample: serde_json::Value = serde_json::from_str(lines[10]).unwrap();
    let read = rig.json("--address 128 get slope-long32 slope-lateral32");
    for name in ["slope-long32", "slope-lateral32"] {
        let (sampled, read) = (&sample[name], &read[name]["value"]);
        let error = sampled.as_f64().unwrap() - read.as_f64().unwrap();
        assert!(error.abs() < 0.02, "{name} {sampled} {read}");
        assert!(read.as_f64().unwrap().abs() > 1.0, "{name} {read}");
    }
}

#[test]
fn angles_that_nobody_broadcasts_are_requested() {
    let path = file("j1939.csv");
    let mut rig = network("transmission-rate-ssi2=raw:0");
    rig.done(&format!(
        "--address 128 record {} --every 50 --seconds 1",
        path.display()
    ));
    let text = std::fs::read_to_string(&path).unwrap();
    let mut lines = text.lines();
    assert_eq!(
        lines.next(),
        Some("time_s,slope-long32_deg,slope-lateral32_deg")
    );
    assert!((20..=21).contains(&lines.count()), "{text}");
    let seen = sent_by(&mut rig, "F9");
    let requests = seen.iter().filter(|frame| *frame == "18EA80F9#29F000");
    assert!(requests.count() >= 20, "{seen:?}");
}

#[test]
fn raw_requests_a_group_or_an_object() {
    let mut rig = network("");
    let out = rig.done("--rate 250 --address 128 raw FEEB");
    assert_eq!(
        out.trim(),
        "50 6C 75 6D 62 6C 69 6E 65 2A 49 4D 53 33 36 30 2A 31 2A 2A"
    );
    let out = rig.done("--rate 250 --address 128 raw 1018:4");
    assert_eq!(out.trim(), "01 00 00 00");
    assert_eq!(
        rig.fails("--rate 250 --address 128 raw FEEE"),
        (1, "refused".to_owned())
    );
    assert_eq!(
        rig.fails("--rate 250 --address 128 raw 40000"),
        (2, "bad-request".to_owned())
    );
}

#[test]
fn foreign_node_is_named_and_gets_no_proprietary_frame() {
    let mut rig = Rig::new(BusRate::Fixed(BitRate::K250));
    rig.says_yes = true;
    let other = rig.bus.borrow_mut().adapter();
    rig.bus.borrow_mut().open(other, Some(BitRate::K250), false);
    let claim = Frame::data(extended(0x18EE_FF00), &[1, 0, 0x60, 0, 0, 0, 0, 0]).unwrap();
    rig.cyclic = Some((200, claim));
    rig.witnessed();
    let rows = rig.json("--rate 250 scan");
    assert_eq!(
        rows,
        json!([{"rate": 250, "protocol": "j1939", "product": null, "address": "0", "serial": null, "article": "manufacturer 3, function 0", "firmware": null}])
    );
    assert_eq!(rig.fails("--rate 250 get").1, "unknown-product");
    let seen = texts(&rig.witnessed());
    assert!(
        !seen.iter().any(|frame| frame.starts_with("18EF")),
        "{seen:?}"
    );
}

#[test]
fn broadcast_has_the_rate_of_the_samples_meanwhile() {
    let mut rig = network("");
    let out = rig.done("--json --address 128 watch --every 40 --cyclic --seconds 2");
    assert!(
        (48..=51).contains(&out.lines().count()),
        "{}",
        out.lines().count()
    );
    let seen = texts(&rig.witnessed());
    let groups = seen.iter().filter(|frame| frame.starts_with("0CF02980#"));
    assert!(groups.count() < 250, "the rate was 10 ms before");
    let read = rig.json("--address 128 get transmission-rate-ssi2");
    assert_eq!(read["transmission-rate-ssi2"]["raw"], 10);
    assert_eq!(
        rig.fails("--address 128 watch --every 5 --cyclic --seconds 1"),
        (2, "out-of-range".to_owned())
    );
}

#[test]
fn record_without_a_sample_leaves_the_file_as_it_was() {
    let mut rig = network("");
    let (new, old) = (file("record-new.csv"), file("record-old.csv"));
    std::fs::write(&old, "mine").unwrap();
    for path in [&new, &old] {
        let path = path.display();
        let failed = rig.fails(&format!(
            "--address 128 record {path} --every 5 --cyclic --seconds 1"
        ));
        assert_eq!(failed, (2, "out-of-range".to_owned()));
    }
    assert!(!new.exists());
    assert_eq!(std::fs::read_to_string(&old).unwrap(), "mine");
}

#[test]
fn broadcast_rate_is_put_back_after_ctrl_c() {
    let mut is_changed = false;
    for looks in (1..).step_by(7) {
        let mut rig = network("");
        rig.stop = Some(looks);
        let ended = rig.tool("--json --address 128 watch --every 40 --cyclic --seconds 0.4");
        rig.stop = None;
        let seen = sent_by(&mut rig, "F9");
        is_changed |= seen.iter().any(|frame| frame.starts_with("18EF80F9#2"));
        let read = rig.json("--address 128 get transmission-rate-ssi2");
        let raw = &read["transmission-rate-ssi2"]["raw"];
        assert_eq!(raw, 10, "{looks} {ended:?}");
        if ended.code == 0 && ended.out.lines().count() >= 9 {
            assert!(looks > 20 && is_changed, "{looks}");
            break;
        }
    }
}
