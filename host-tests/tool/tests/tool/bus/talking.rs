//! `scan` finds sensors that talk by listening alone, at any rate and with any identifier.

use super::bit_rate::kbits;
use super::cyclic::devicenet::{POLL, own};
use super::cyclic::{send, texts};
use super::rig::Rig;
use super::rig::run::Ended;
use super::scan::silent;
use plumbline::can::{BitRate, Frame, standard};
use plumbline::time::{Instant, after, millis};
use serde_json::{Value, json};

/// The milliseconds from one time to another.
fn passed(from: Instant, to: Instant) -> u64 {
    to.ticks().saturating_sub(from.ticks()) / 1000
}

/// Runs a scan. The tool must have sent nothing: the witness has seen only frames that begin with one of these texts.
#[track_caller]
fn listened(rig: &mut Rig, own: &[&str]) -> (Ended, u64) {
    rig.witnessed();
    let start = rig.bus.borrow().now();
    let ended = rig.tool("--json scan");
    let time = passed(start, rig.bus.borrow().now());
    assert!(ended.notes.contains("nothing was sent"), "{ended:?}");
    let mut others = texts(&rig.witnessed());
    others.retain(|frame| !own.iter().any(|own| frame.starts_with(own)));
    assert_eq!(others, [""; 0], "{ended:?}");
    (ended, time)
}

fn rows(ended: &Ended) -> Vec<Value> {
    assert_eq!(ended.code, 0, "{ended:?}");
    serde_json::from_str(&ended.out).expect("rows")
}

/// A sensor in cyclic mode with 1 s at this rate, and another node that acknowledges.
pub fn cyclic(product: &str, rate: BitRate, settings: &str) -> Rig {
    let mut rig = silent(product, rate);
    let rate_text = kbits(rate);
    rig.done(&format!(
        "--rate {rate_text} --id 300 set {settings} cyclic-time=1s cyclic-mode=on --save"
    ));
    rig.says_yes = true;
    rig.done(&format!("--rate {rate_text} --id 300 rate {rate_text}"));
    rig.says_yes = false;
    let id = rig.first();
    let master = rig.bus.borrow_mut().adapter();
    rig.bus.borrow_mut().open(master, Some(rate), false);
    rig.bus.borrow_mut().power_cycle(id);
    rig.run(2300);
    rig.questions.clear();
    rig
}

#[test]
fn talking_sensor_is_found_at_every_rate_by_listening() {
    for rate in BitRate::ALL {
        let mut rig = cyclic("is2", rate, "");
        let (ended, time) = listened(&mut rig, &["301#00"]);
        let number: Value = serde_json::from_str(&kbits(rate)).unwrap();
        let row = json!({"rate": number, "protocol": "fsc", "product": null, "address": null, "serial": null, "article": null, "heard": "GEMAC, 2 angles at 301h", "firmware": null});
        assert_eq!(rows(&ended), [row], "{rate:?}");
        assert!(time < 13_000, "{rate:?} {time} ms");
        // The sensor possibly has its identifiers as delivered.
        assert_eq!(rig.questions.len(), 1, "{:?}", rig.questions);
        assert!(rig.questions[0].contains("(fsc, 300)"), "{rate:?}");
        rig.says_yes = true;
        let rows = rig.json("scan");
        assert_eq!(rows.as_array().map(Vec::len), Some(1), "{rows}");
        assert_eq!(
            (&rows[0]["product"], &rows[0]["address"]),
            (&json!("is2"), &json!("300")),
            "{rate:?}"
        );
    }
}

#[test]
fn cyclic_sensor_with_other_identifiers_has_no_address_in_its_row_before_a_request() {
    for (reply, shown) in [("6A6h", "6A6"), ("12345678h", "12345678")] {
        let settings = format!("set-id=6A5h reply-id={reply}");
        let mut rig = cyclic_with_ids("is1", BitRate::K125, &settings);
        let (ended, _) = listened(&mut rig, &[&format!("{shown}#00")]);
        let row = &rows(&ended)[0];
        assert_eq!(
            (&row["address"], &row["heard"]),
            (&json!(null), &json!(format!("GEMAC, 1 angle at {shown}h")))
        );
        assert_eq!(row["likely"], true);
        assert_eq!(rig.questions.len(), 1, "for more sensors");
        let text = rig.done("scan");
        assert!(text.contains("--rate 125 scan --search"), "{text}");
        rig.says_yes = true;
        rig.witnessed();
        let rows = rig.json("scan --search");
        let rows = rows.as_array().unwrap();
        assert_eq!(rows.len(), 1, "the answer takes the place: {rows:?}");
        assert_eq!(
            (&rows[0]["product"], &rows[0]["address"]),
            (&json!("is1"), &json!("6A5"))
        );
        // The form of its data alone does not show the protocol of the bus.
        let seen = texts(&rig.witnessed());
        assert!(seen.iter().any(|frame| frame.starts_with("60A#4000")));
    }
}

/// The same with identifiers that act after the restart.
fn cyclic_with_ids(product: &str, rate: BitRate, settings: &str) -> Rig {
    let mut rig = silent(product, rate);
    let rate_text = kbits(rate);
    rig.says_yes = true;
    rig.done(&format!("--rate {rate_text} --id 300 rate {rate_text}"));
    rig.says_yes = false;
    rig.done(&format!(
        "--rate {rate_text} --id 300 set cyclic-time=200ms cyclic-mode=on {settings} --save"
    ));
    let master = rig.bus.borrow_mut().adapter();
    rig.bus.borrow_mut().open(master, Some(rate), false);
    let id = rig.first();
    rig.bus.borrow_mut().power_cycle(id);
    rig.run(2000);
    rig.questions.clear();
    rig
}

#[test]
fn slave_of_another_master_is_found_by_its_io_messages_and_never_asked() {
    let mut rig = Rig::with("tiltix080");
    own(&mut rig);
    rig.cyclic = Some((200, Frame::data(standard(POLL), &[]).unwrap()));
    for says_yes in [false, true] {
        rig.says_yes = says_yes;
        let (ended, _) = listened(&mut rig, &["5FD#", "3FF#"]);
        let row = json!({"rate": 250, "protocol": "devicenet", "product": null, "address": "63", "serial": null, "article": null, "heard": "I/O of another master", "firmware": null});
        assert_eq!(rows(&ended), [row]);
        assert!(rig.questions.is_empty(), "{:?}", rig.questions);
    }
    let text = rig.done("scan");
    assert!(text.contains("--mac 63 --product NAME watch"), "{text}");
    // The same if the tool asks all nodes.
    rig.witnessed();
    rig.done("scan --active");
    let seen = texts(&rig.witnessed());
    assert!(seen.iter().any(|frame| frame.starts_with("5F6#")));
    let asked = ["5FE#", "5FC#"];
    assert!(
        !seen
            .iter()
            .any(|frame| asked.iter().any(|own| frame.starts_with(own)))
    );
}

#[test]
fn cyclic_messages_of_devicenet_without_a_master_are_likely_a_slave() {
    let mut rig = Rig::with("tiltix080");
    send(
        &mut rig,
        &[
            (0x5FE, &[0x0A, 0x4B, 3, 1, 0x61, 0x0A]),
            (0x5FC, &[0x0A, 0x10, 5, 1, 9, 0, 0]),
            (0x5FC, &[0x0A, 0x10, 5, 4, 9, 50, 0]),
        ],
    );
    rig.says_yes = false;
    let (ended, _) = listened(&mut rig, &["37F#"]);
    let rows = rows(&ended);
    assert_eq!(
        (
            rows.len(),
            &rows[0]["protocol"],
            &rows[0]["address"],
            &rows[0]["heard"]
        ),
        (
            1,
            &json!("devicenet"),
            &json!("63"),
            &json!("likely, by its I/O messages")
        )
    );
    assert_eq!(rows[0]["likely"], true);
    assert_eq!(rig.questions.len(), 1, "for more sensors");
}

#[test]
fn node_that_only_sends_a_tpdo_is_likely_one_and_asked_after_a_yes() {
    let mut rig = Rig::with("jn2101");
    rig.done("--node 10 set tpdo1-transmission-type=254 tpdo1-event-timer=500ms");
    send(&mut rig, &[(0, &[1, 10])]);
    rig.says_yes = false;
    rig.questions.clear();
    let (ended, _) = listened(&mut rig, &["18A#"]);
    let row = json!({"rate": 250, "protocol": "canopen", "product": null, "address": "10", "serial": null, "article": null, "heard": "likely, by a TPDO (18Ah)", "firmware": null, "likely": true});
    assert_eq!(rows(&ended), [row]);
    assert!(rig.questions[0].contains("(canopen, 10)"));
    assert_eq!(rig.questions.len(), 2, "{:?}", rig.questions);
    rig.says_yes = true;
    rig.questions.clear();
    let rows = rig.json("scan");
    assert_eq!(rows[0]["product"], "jn2101");
    assert_eq!(rig.questions.len(), 1, "it is found: {:?}", rig.questions);
}

#[test]
fn traffic_without_a_sensor_is_named_with_rate_and_identifiers() {
    let mut rig = silent("is2", BitRate::K125);
    let other = rig.bus.borrow_mut().adapter();
    rig.bus.borrow_mut().open(other, Some(BitRate::K125), false);
    rig.cyclic = Some((100, Frame::data(standard(0x123), &[1, 2]).unwrap()));
    assert_eq!(rig.fails("scan"), (3, "nothing-found".to_owned()));
    let ended = rig.tool("scan");
    assert!(
        ended
            .notes
            .contains("traffic at 125 kbit/s (123h), no sensor recognised: switch"),
        "{ended:?}"
    );
    assert!(!ended.notes.contains("wiring"), "{ended:?}");
    rig.cyclic = None;
    let ended = rig.tool("scan");
    assert!(ended.notes.contains("check power, wiring"), "{ended:?}");
}

#[test]
fn sensor_with_unknown_identifiers_is_found_within_three_seconds_of_its_start() {
    for (rate, times) in [
        (BitRate::K10, [500, 9000]),
        (BitRate::K125, [3000, 11_500]),
        (BitRate::K250, [500, 6000]),
        (BitRate::M1, [9000, 11_500]),
    ] {
        let mut rig = silent("is2", rate);
        let rate_text = kbits(rate);
        rig.says_yes = true;
        rig.done(&format!("--rate {rate_text} --id 300 rate {rate_text}"));
        rig.says_yes = false;
        rig.done(&format!(
            "--rate {rate_text} --id 300 set set-id=6A5h reply-id=6A6h --save"
        ));
        rig.questions.clear();
        let id = rig.first();
        for time in times {
            rig.run(1000);
            rig.witnessed();
            let on = after(rig.bus.borrow().now(), millis(time));
            rig.power_cycle_at(on, id);
            let ended = rig.tool("scan");
            let row = ended.out.lines().next().unwrap_or_default();
            assert!(
                row.contains("is2  address 6A5  serial 5"),
                "{rate:?} {time} {ended:?}"
            );
            let found = passed(on, ended.times[0]);
            assert!(found < 3000, "{rate:?} {time}: {found} ms");
            let start = ended.notes.lines().next().unwrap_or_default();
            assert!(start.contains("switch the sensor off and on"), "{start}");
            // The first frames are its own.
            let seen = texts(&rig.witnessed());
            assert!(seen.len() > 10 && seen[..10].iter().all(|own| own.starts_with("6A6#FF")));
            assert!(rig.questions.is_empty());
        }
    }
}

#[test]
fn sensor_that_others_acknowledge_is_found_at_a_single_rate_when_it_is_switched_on() {
    // Its boot-up message comes only twice.
    for time in [200, 5000, 9000] {
        let mut rig = silent("is2", BitRate::K250);
        rig.says_yes = true;
        rig.done("--rate 250 --id 300 rate 250");
        rig.says_yes = false;
        let other = rig.bus.borrow_mut().adapter();
        rig.bus.borrow_mut().open(other, Some(BitRate::K250), false);
        let on = after(rig.bus.borrow().now(), millis(time));
        rig.power_cycle_at(on, rig.first());
        rig.questions.clear();
        let ended = rig.tool("--rate 250 scan");
        assert!(ended.out.contains("is2  address 300"), "{time} {ended:?}");
        assert!(passed(on, ended.times[0]) < 3000, "{time}");
        assert!(rig.questions.is_empty());
    }
}

#[test]
fn rate_of_an_interface_is_in_the_rows() {
    let mut rig = Rig::with("jn2101");
    rig.done("node-id 10");
    rig.interface = Some(BitRate::K250);
    rig.done("--node 10 set heartbeat-interval-time=200ms");
    let rows = rig.json("scan");
    assert_eq!(
        (&rows[0]["rate"], &rows[0]["product"]),
        (&json!(250), &json!("jn2101"))
    );
    let text = rig.tool("scan");
    assert!(text.out.starts_with("250 kbit/s  canopen"), "{text:?}");
    assert!(
        text.out.contains("plumbline --rate 250 --node 10 get"),
        "{text:?}"
    );
    assert!(text.notes.contains("frames at 250 kbit/s"), "{text:?}");
}
