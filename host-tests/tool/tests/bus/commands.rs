//! `set`, `save`, `load-factory`, `zero`, `restart`, `node-id`, `mac` and `raw`: what they change in the sensor.

use super::rig::{PRODUCTS, Rig};
use serde_json::json;

/// For each family a setting, its text after it was read back, and its factory text.
fn setting(product: &str) -> (&'static str, &'static str, &'static str) {
    match product {
        "jn2101" => ("heartbeat-interval-time=0.5s", "500 ms", "0 ms"),
        "ims360" => ("cut-off=2.5Hz", "2500 mHz", "2000 mHz"),
        "tiltix080" | "tiltix360" => ("slope-long16-preset-value=1.25deg", "1.25 deg", "0.00 deg"),
        _ => ("cyclic-time=0.1s", "100 ms", "250 ms"),
    }
}

#[test]
fn setting_of_every_product_is_kept_only_after_save() {
    for product in PRODUCTS {
        let (assignment, text, factory) = setting(product);
        let (name, _) = assignment.split_once('=').unwrap();
        let stores_itself = product.starts_with("tiltix");
        let mut rig = Rig::with(product);
        let device = rig.bus.borrow_mut().device(id(&rig)).name().to_owned();
        assert_eq!(device, product);
        assert!(
            rig.done(&format!("set {assignment}")).contains(text),
            "{product}"
        );
        if !stores_itself {
            rig.power_cycle(id(&rig));
            assert!(
                rig.done(&format!("get {name}")).contains(factory),
                "{product}"
            );
            rig.done(&format!("set {assignment} --save"));
        } else {
            rig.done("save");
        }
        rig.run(1500);
        rig.power_cycle(id(&rig));
        assert!(rig.done(&format!("get {name}")).contains(text), "{product}");
    }
}

/// The first sensor on the bus.
fn id(rig: &Rig) -> bench::DeviceId {
    rig.first()
}

#[test]
fn load_factory_of_every_product_restores_the_setting() {
    for product in PRODUCTS {
        let (assignment, _, factory) = setting(product);
        let (name, _) = assignment.split_once('=').unwrap();
        let mut rig = Rig::with(product);
        rig.done(&format!("set {assignment} --save"));
        rig.done("load-factory");
        rig.run(1500);
        rig.power_cycle(id(&rig));
        if product == "ims360" {
            // 1011h acts at one start; 1010h keeps it.
            rig.done("save");
        }
        assert!(
            rig.done(&format!("get {name}")).contains(factory),
            "{product}"
        );
    }
}

#[test]
fn zero_of_every_product_makes_the_angles_zero() {
    for product in PRODUCTS {
        let mut rig = Rig::with(product);
        let zeroed = rig.json("zero");
        let angles = zeroed["zero"].as_object().unwrap();
        assert!(!angles.is_empty(), "{product}");
        // The JN2101 takes over the zero point with the next sample.
        rig.run(50);
        for name in angles.keys() {
            let read = rig.json(&format!("get {name}"));
            let value = read[name]["value"].as_f64().unwrap();
            assert!(value.abs() < 0.02, "{product} {name} {value}");
        }
    }
}

#[test]
fn zero_of_one_axis_leaves_the_other() {
    for (product, x, y) in [
        ("is2", "angle-x", "angle-y"),
        ("ims360", "slope-long32", "slope-lateral32"),
        ("tiltix080", "slope-long16", "slope-lateral16"),
    ] {
        let mut rig = Rig::with(product);
        rig.done("zero y");
        let read = rig.json(&format!("get {x} {y}"));
        assert!(
            read[x]["value"].as_f64().unwrap().abs() > 4.0,
            "{product} {read}"
        );
        assert!(
            read[y]["value"].as_f64().unwrap().abs() < 0.02,
            "{product} {read}"
        );
    }
    assert_eq!(Rig::with("is1").fails("zero y"), (2, "no-axis".to_owned()));
    assert_eq!(
        Rig::with("jn2101").fails("zero x"),
        (2, "no-axis".to_owned())
    );
}

#[test]
fn one_axis_variant_of_ims360_has_no_second_axis_to_zero() {
    let mut rig = Rig::with("ims360");
    rig.done("set sensor-configuration=raw:0 --save");
    rig.done("restart");
    rig.run(500);
    rig.done("zero");
    assert_eq!(rig.fails("zero y"), (2, "no-axis".to_owned()));
}

#[test]
fn teach_is_offered_for_jn2101_only() {
    let mut rig = Rig::with("jn2101");
    rig.done("teach");
    assert_eq!(
        rig.json("get teach")["teach"]["value"],
        "relative measurement"
    );
    assert_eq!(
        Rig::with("is2").fails("teach"),
        (2, "not-offered".to_owned())
    );
}

#[test]
fn restart_of_every_product_boots_it_again() {
    for product in PRODUCTS {
        let mut rig = Rig::with(product);
        let before = rig.bus.borrow().device(id(&rig)).boots();
        rig.done("restart");
        rig.run(1500);
        // A reset of a CANopen node is no restart of the processor: its boot-up message shows it.
        let booted = rig.bus.borrow().device(id(&rig)).boots() > before
            || rig
                .witnessed()
                .iter()
                .any(|frame| format!("{frame:?}").ends_with("#00"));
        assert!(booted, "{product}");
    }
}

#[test]
fn node_id_is_written_stored_and_checked() {
    for (product, old) in [("jn2101", 10), ("ims360", 50)] {
        let mut rig = Rig::with(product);
        rig.done("node-id 33");
        assert_eq!(
            rig.fails(&format!("--node {old} get node-id")),
            (3, "no-answer".to_owned())
        );
        rig.power_cycle(id(&rig));
        assert_eq!(rig.json("--node 33 get node-id")["node-id"]["raw"], 33);
    }
}

#[test]
fn node_id_in_use_is_refused_and_changes_nothing() {
    let mut rig = Rig::with("jn2101");
    rig.attach("ims360", 2);
    rig.run(500);
    assert_eq!(
        rig.fails("--node 10 node-id 50"),
        (1, "address-in-use".to_owned())
    );
    assert_eq!(rig.json("--node 10 get node-id")["node-id"]["raw"], 10);
    assert_eq!(
        rig.fails("--node 50 node-id 127"),
        (2, "out-of-range".to_owned())
    );
}

#[test]
fn mac_id_is_written_stored_and_checked() {
    let mut rig = Rig::with("tiltix080");
    rig.done("mac 7");
    rig.run(1500);
    rig.power_cycle(id(&rig));
    assert_eq!(rig.json("--mac 7 get mac-id")["mac-id"]["raw"], 7);
    assert_eq!(
        rig.fails("--mac 63 get mac-id"),
        (3, "no-answer".to_owned())
    );
}

#[test]
fn identifiers_act_after_restart() {
    let mut rig = Rig::with("is2");
    let ended = rig.tool("set set-id=320h reply-id=00000361h --save");
    assert_eq!(ended.code, 0, "{ended:?}");
    assert!(
        ended.notes.contains("set-id acts after the next restart"),
        "{ended:?}"
    );
    assert_eq!(
        rig.json("get set-id")["set-id"],
        json!({"value": "320h", "unit": "", "raw": 0x320})
    );
    rig.done("restart");
    rig.run(100);
    let read = rig.json("--id 320 get reply-id");
    assert_eq!(read["reply-id"]["value"], "00000361h");
}

#[test]
fn group_is_written_in_one_request() {
    let mut rig = Rig::with("is2");
    rig.done("set filter=2.5Hz,butterworth");
    let writes: Vec<String> = rig
        .witnessed()
        .iter()
        .map(|frame| format!("{frame:?}"))
        .collect();
    let writes: Vec<&String> = writes
        .iter()
        .filter(|frame| frame.starts_with("300#27"))
        .collect();
    assert_eq!(writes, ["300#27C40901"]);
    // A single parameter of the code keeps the other one.
    rig.done("set filter-type=off");
    let read = rig.json("get filter");
    assert_eq!(
        (
            read["cut-off"]["raw"].as_u64(),
            read["filter-type"]["raw"].as_u64()
        ),
        (Some(2500), Some(0))
    );
}

#[test]
fn number_in_resolution_follows_resolution() {
    let mut rig = Rig::with("tiltix080");
    rig.done("set slope-long16-preset-value=12.3deg");
    rig.done("set resolution=0.1deg");
    let read = rig.json("get slope-long16-preset-value");
    assert_eq!(
        read["slope-long16-preset-value"],
        json!({"value": 12.3, "unit": "deg", "raw": 123})
    );
    rig.done("set slope-long16-preset-value=80deg");
    assert_eq!(
        rig.fails("set slope-long16-preset-value=80.1deg"),
        (2, "out-of-range".to_owned())
    );
    assert_eq!(
        rig.fails("set slope-long16-preset-value=1.25deg"),
        (2, "bad-value".to_owned())
    );
}

#[test]
fn programming_key_is_copied_from_sensor_to_sensor() {
    let mut from = Rig::with("jn2101");
    from.done("set filter=10Hz heating=off");
    let key = from.json("get programming-key")["programming-key"]["value"]
        .as_str()
        .unwrap()
        .to_owned();
    let mut to = Rig::with("jn2101");
    to.done(&format!("set programming-key={key}"));
    let read = to.json("get filter heating");
    assert_eq!(
        (
            read["filter"]["raw"].as_u64(),
            read["heating"]["value"].as_str()
        ),
        (Some(1), Some("off"))
    );
    assert_eq!(
        to.fails("set programming-key=D0UfZEgRKHAI5Ag0"),
        (1, "refused".to_owned())
    );
}

#[test]
fn raw_sends_one_request_of_the_protocol() {
    for (product, request, answer) in [
        ("is2", "--id 300 raw 10", "10 03 00 03 00 00"),
        ("jn2101", "--node 10 raw 1018:1", "00 69 66 6D"),
        ("tiltix080", "--mac 63 raw 0E010101", "62 01"),
    ] {
        let mut rig = Rig::with(product);
        let out = rig.done(&format!("--rate 250 {request}"));
        let expected = if product == "jn2101" {
            "00 69 66 6D"
        } else {
            answer
        };
        assert_eq!(out.trim(), expected, "{product}");
    }
}
