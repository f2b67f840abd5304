//! `scan`: what it finds, how fast, and what a witness sees of it.

use super::rig::Rig;
use bench::{BusRate, NodeType};
use plumbline::can::{BitRate, Frame, standard};
use serde_json::{Value, json};

/// Runs a scan and returns its rows and its time in ms.
fn scan(rig: &mut Rig, arguments: &str) -> (Vec<Value>, u64) {
    let start = rig.bus.borrow().now();
    let rows = rig.json(&format!("scan {arguments}"));
    let time = rig.bus.borrow().now().ticks() - start.ticks();
    (rows.as_array().unwrap().clone(), time / 1000)
}

/// A wire with a rate; sensors that detect it have heard a frame, and are silent now.
fn silent(product: &str, rate: BitRate) -> Rig {
    let mut rig = Rig::new(BusRate::Wire);
    rig.attach(product, 5);
    let other = rig.bus.borrow_mut().adapter();
    rig.bus.borrow_mut().open(other, Some(rate), false);
    rig.bus
        .borrow_mut()
        .send(other, Frame::data(standard(0x7FF), &[]).unwrap());
    rig.run(3000);
    rig.bus.borrow_mut().remove(other);
    rig.listen(rate);
    rig.run(10);
    rig.witnessed();
    rig
}

#[test]
fn talking_sensor_is_found_at_every_rate_by_listening() {
    for rate in BitRate::ALL {
        let mut rig = silent("is2", rate);
        let name = rate.name().split(' ').next().unwrap().to_owned();
        let kbits = if rate == BitRate::M1 {
            "1000".to_owned()
        } else {
            name
        };
        rig.done(&format!(
            "--rate {kbits} set baud-rate={} cyclic-time=1s cyclic-mode=on --save",
            quoted(rate)
        ));
        rig.done(&format!("--rate {kbits} restart"));
        rig.run(200);
        let master = rig.bus.borrow_mut().adapter();
        // Somebody acknowledges, as on a bus that works.
        rig.bus.borrow_mut().open(master, Some(rate), false);
        rig.run(2000);
        rig.witnessed();
        let start = rig.bus.borrow().now();
        let ended = rig.tool("--json scan");
        let time = (rig.bus.borrow().now().ticks() - start.ticks()) / 1000;
        assert!(time < 13_000, "{rate:?} {time} ms");
        // Cyclic values tell nothing about their sender: it is not asked without a yes.
        assert_eq!(ended.code, 3, "{rate:?} {ended:?}");
        assert!(
            ended.notes.contains("nothing was sent"),
            "{rate:?} {ended:?}"
        );
        assert!(
            ended
                .notes
                .contains(&format!("listened at {} ", rate.name())),
            "{ended:?}"
        );
        let others: Vec<String> = rig
            .witnessed()
            .iter()
            .map(|frame| format!("{frame:?}"))
            .filter(|frame| !frame.starts_with("301#00"))
            .collect();
        assert_eq!(others, [""; 0], "{rate:?}");
        let (rows, _) = scan(&mut rig, "--active");
        assert_eq!(rows[0]["product"], "is2", "{rate:?}");
    }
}

fn quoted(rate: BitRate) -> String {
    // Codes of section 9.10.3.
    let code = match rate {
        BitRate::K10 => 1,
        BitRate::K20 => 2,
        BitRate::K50 => 3,
        BitRate::K62_5 => 10,
        BitRate::K100 => 4,
        BitRate::K125 => 5,
        BitRate::K250 => 6,
        BitRate::K500 => 7,
        BitRate::K800 => 8,
        BitRate::M1 => 9,
    };
    format!("raw:{code}")
}

#[test]
fn sensors_that_nobody_acknowledges_are_found_and_asked() {
    for (product, row) in [
        (
            "jn2101",
            json!({"rate": 125, "protocol": "canopen", "product": "jn2101", "address": "10", "serial": 5, "article": "JN2101", "firmware": "2.2.0"}),
        ),
        (
            "ims360",
            json!({"rate": 125, "protocol": "canopen", "product": "ims360", "address": "50", "serial": 5, "article": "IMS360", "firmware": "010000"}),
        ),
        (
            "tiltix080",
            json!({"rate": 125, "protocol": "devicenet", "product": "tiltix080", "address": "63", "serial": 5, "article": "TILTIX-080-2-D100-HE2-PM", "firmware": "1.1"}),
        ),
    ] {
        let mut rig = Rig::new(BusRate::Wire);
        rig.attach(product, 5);
        rig.run(200);
        let (rows, time) = scan(&mut rig, "");
        assert_eq!(rows, [row], "{product}");
        assert!(time < 13_000, "{product} {time} ms");
        assert!(rig.questions.is_empty(), "{product}");
    }
}

#[test]
fn silent_sensor_is_only_asked_after_a_yes() {
    let mut rig = silent("is2", BitRate::K250);
    let ended = rig.tool("--json scan");
    assert_eq!(ended.code, 3);
    assert_eq!(rig.questions.len(), 1);
    assert!(ended.notes.contains("nothing was sent"));
    assert_eq!(rig.witnessed(), []);
    rig.says_yes = true;
    let (rows, time) = scan(&mut rig, "");
    let row = json!({"rate": 250, "protocol": "fsc", "product": "is2", "address": "300", "serial": 5, "article": "PR-23054-30", "firmware": "3.44"});
    assert_eq!(rows, [row]);
    // 12.2 s of listening, the answer, and the other addresses at that rate.
    assert!(time < 22_000, "{time} ms");
}

#[test]
fn silent_sensor_is_found_at_every_rate_within_five_seconds_of_the_yes() {
    for (product, rates) in [
        ("is2", &BitRate::ALL[..]),
        ("is1d", &[BitRate::M1]),
        ("tiltix360", &[BitRate::K125]),
    ] {
        for rate in rates {
            let mut rig = silent(product, *rate);
            let out = rig.tool("--json --yes scan");
            let rows: Value = serde_json::from_str(&out.out)
                .unwrap_or_else(|error| panic!("{rate:?} {error} {out:?}"));
            assert_eq!(rows[0]["product"], product, "{rate:?}");
        }
    }
}

#[test]
fn fresh_sensor_that_detects_the_rate_is_found_by_asking() {
    let mut rig = Rig::new(BusRate::Wire);
    rig.attach("is2tk", 3);
    rig.run(100);
    let (rows, _) = scan(&mut rig, "--active");
    assert_eq!(
        (&rows[0]["product"], &rows[0]["rate"]),
        (&json!("is2tk"), &json!(250))
    );
}

#[test]
fn older_generation_with_same_article_is_told_by_its_version() {
    for (product, firmware) in [("is2", "3.44"), ("is2d", "1.03"), ("is1dm", "1.03")] {
        let mut rig = Rig::with(product);
        let (rows, _) = scan(&mut rig, "--active");
        assert_eq!(
            (&rows[0]["product"], &rows[0]["firmware"]),
            (&json!(product), &json!(firmware))
        );
    }
}

#[test]
fn two_sensors_on_one_bus_are_both_found() {
    let mut rig = Rig::new(BusRate::Fixed(BitRate::K125));
    rig.attach("jn2101", 11);
    rig.attach("ims360", 12);
    rig.run(500);
    let (rows, _) = scan(&mut rig, "--active");
    let mut serials: Vec<u64> = rows
        .iter()
        .map(|row| row["serial"].as_u64().unwrap())
        .collect();
    serials.sort_unstable();
    assert_eq!(serials, [11, 12]);
}

#[test]
fn node_with_another_node_id_is_found_by_asking_all() {
    let mut rig = Rig::with("jn2101");
    rig.done("node-id 99");
    rig.run(500);
    rig.witnessed();
    let (rows, _) = scan(&mut rig, "--active");
    assert_eq!(
        (&rows[0]["product"], &rows[0]["address"]),
        (&json!("jn2101"), &json!("99"))
    );
}

#[test]
fn node_without_node_id_is_found_by_fastscan() {
    let mut rig = Rig::with("ims360");
    // LSS: select, node-ID 255, store.
    let master = rig.bus.borrow_mut().adapter();
    rig.bus.borrow_mut().open(master, None, false);
    for bytes in [
        [4, 1, 0, 0, 0, 0, 0, 0],
        [0x11, 255, 0, 0, 0, 0, 0, 0],
        [0x17, 0, 0, 0, 0, 0, 0, 0],
    ] {
        rig.bus
            .borrow_mut()
            .send(master, Frame::data(standard(0x7E5), &bytes).unwrap());
        rig.run(500);
    }
    rig.bus
        .borrow_mut()
        .send(master, Frame::data(standard(0x000), &[0x82, 50]).unwrap());
    rig.run(500);
    rig.bus.borrow_mut().remove(master);
    let (rows, _) = scan(&mut rig, "--active --rate 125");
    assert_eq!(rows[0]["address"], "unconfigured");
    assert_eq!(
        (&rows[0]["serial"], &rows[0]["article"]),
        (&json!(1), &json!("vendor 195h, product code 1869Fh"))
    );
}

#[test]
fn foreign_traffic_is_not_disturbed_and_nothing_is_sent() {
    let mut rig = silent("is2", BitRate::K500);
    let foreign = rig.bus.borrow_mut().adapter();
    let other = rig.bus.borrow_mut().adapter();
    for id in [foreign, other] {
        rig.bus.borrow_mut().open(id, Some(BitRate::K500), false);
    }
    for place in 0..3000_u32 {
        let frame = Frame::data(standard(0x123), &place.to_le_bytes()).unwrap();
        rig.bus.borrow_mut().send(foreign, frame);
    }
    let ended = rig.tool("--json scan");
    assert_eq!(ended.code, 3, "{ended:?}");
    assert!(ended.notes.contains("nothing was sent"));
    let seen = rig.witnessed();
    assert!(
        seen.len() > 100
            && seen
                .iter()
                .all(|frame| format!("{frame:?}").starts_with("123#"))
    );
    assert_eq!(
        rig.bus.borrow().disturbed(bench::Source::Adapter(foreign)),
        0
    );
    assert_eq!(rig.questions.len(), 1, "{:?}", rig.questions);
}

#[test]
fn unknown_identifiers_are_found_after_power_cycle_and_by_search() {
    let mut rig = silent("is2", BitRate::K250);
    rig.done("--rate 250 set set-id=6A5h reply-id=6A6h baud-rate=raw:6 --save");
    let id = rig.first();
    rig.bus.borrow_mut().power_cycle(id);
    rig.run(200);
    // Nobody acknowledges its boot-up message, so it is repeated: listening finds it.
    let (rows, time) = scan(&mut rig, "");
    assert_eq!(
        (&rows[0]["product"], &rows[0]["address"]),
        (&json!("is2"), &json!("6A5"))
    );
    assert!(time < 3000, "{time} ms");
    // Now it is silent: only a search finds it.
    rig.run(100);
    let (rows, _) = scan(&mut rig, "--rate 250 --active --search");
    assert_eq!(
        (&rows[0]["product"], &rows[0]["address"]),
        (&json!("is2"), &json!("6A5"))
    );
}

#[test]
fn foreign_canopen_node_type_is_reported_without_product() {
    let mut rig = Rig::new(BusRate::Fixed(BitRate::K125));
    let node_type = NodeType::find("jn2101").unwrap();
    rig.attach_type(&node_type, 1);
    let heartbeat = rig.bus.borrow_mut().adapter();
    rig.bus
        .borrow_mut()
        .open(heartbeat, Some(BitRate::K125), false);
    for _ in 0..2000 {
        rig.bus
            .borrow_mut()
            .send(heartbeat, Frame::data(standard(0x722), &[5]).unwrap());
    }
    let (rows, _) = scan(&mut rig, "");
    let foreign = rows.iter().find(|row| row["address"] == "34").unwrap();
    assert_eq!(
        (&foreign["protocol"], &foreign["product"]),
        (&json!("canopen"), &json!(null))
    );
}

#[test]
fn sensor_with_unknown_identifiers_that_detects_the_rate_is_found_by_its_boot_up_message() {
    let mut rig = Rig::new(BusRate::Fixed(BitRate::K500));
    rig.attach("is1", 8);
    rig.done("--rate 500 set set-id=555h reply-id=556h --save");
    let id = rig.first();
    rig.bus.borrow_mut().power_cycle(id);
    rig.run(100);
    let (rows, _) = scan(&mut rig, "--rate 500 --active");
    assert_eq!(
        (&rows[0]["product"], &rows[0]["address"]),
        (&json!("is1"), &json!("555"))
    );
}
