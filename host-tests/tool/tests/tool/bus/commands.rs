//! `set`, `save`, `load-factory`, `restart`, `node-id`, `mac` and `raw`: what they change in the sensor.

use super::rig::{PRODUCTS, Rig};
use plumbline::can::{Frame, standard};
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
        assert!(
            rig.done(&format!("get {name}")).contains(factory),
            "{product}"
        );
    }
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
fn command_that_can_move_the_sensor_tells_the_line_that_finds_it() {
    for (product, before, command, line) in [
        (
            "is2",
            "",
            "restart",
            "now: plumbline --port bench --rate 250 --id 300 get",
        ),
        (
            "is2",
            "set set-id=320h reply-id=361h --save",
            "restart",
            "now: plumbline --port bench --rate 250 --id 320 get",
        ),
        (
            "is2",
            "",
            "rate 500",
            "now: plumbline --port bench --rate 500 --id 300 get",
        ),
        (
            "jn2101",
            "",
            "node-id 33",
            "now: plumbline --port bench --rate 250 --node 33 get",
        ),
        (
            "jn2101",
            "set node-id=34 --save",
            "restart",
            "now: plumbline --port bench --rate 125 --node 34 get",
        ),
        (
            "tiltix080",
            "",
            "mac 7",
            "now: plumbline --port bench --rate 250 --mac 7 get",
        ),
        (
            "tiltix080",
            "",
            "set mac-id=7",
            "now: plumbline --port bench --rate 250 --mac 7 get",
        ),
        (
            "tiltix080",
            "",
            "load-factory",
            "now: plumbline --port bench --rate 125 --mac 63 get",
        ),
        (
            "jn2101",
            "",
            "set node-id=34 --save",
            "after its next restart: plumbline --port bench --rate 125 --node 34 get",
        ),
        (
            "ims360",
            "node-id 33",
            "--node 33 load-factory",
            "now: plumbline --port bench --rate 125 --node 50 get",
        ),
    ] {
        let mut rig = Rig::with(product);
        if !before.is_empty() {
            rig.done(before);
        }
        let ended = rig.tool(command);
        assert_eq!(ended.code, 0, "{command}: {ended:?}");
        assert!(ended.notes.contains(line), "{command}: {ended:?}");
    }
}

#[test]
fn restore_tells_the_line_that_finds_the_sensor_after_its_restart() {
    let path = super::rig::file("moved.toml");
    let mut rig = Rig::with("is2");
    rig.done(&format!("backup {}", path.display()));
    rig.done(&format!(
        "set set-id=320h reply-id=361h --file {}",
        path.display()
    ));
    let ended = rig.tool(&format!("restore {}", path.display()));
    let line = "after its next restart: plumbline --port bench --rate 250 --id 320 get";
    assert!(ended.notes.contains(line), "{ended:?}");
    let ended = rig.tool(&format!("restore {}", path.display()));
    assert_eq!(ended.code, 0, "{ended:?}");
    assert!(ended.notes.contains("--id 320 get"), "{ended:?}");
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
fn number_has_the_resolution_of_the_same_command() {
    for (product, name) in [
        ("tiltix080", "slope-long16-preset-value"),
        ("tiltix360", "slope-long16-preset-value"),
    ] {
        for order in ["resolution=0.1deg NAME=5deg", "NAME=5deg resolution=0.1deg"] {
            let mut rig = Rig::with(product);
            let ended = rig.json(&format!("set {}", order.replace("NAME", name)));
            let expected = json!({"value": 5, "unit": "deg", "raw": 50});
            assert_eq!(ended[name]["raw"], expected["raw"], "{product} {order}");
            let read = rig.json(&format!("get {name}"));
            assert_eq!(read[name]["value"].as_f64(), Some(5.0), "{product} {order}");
        }
    }
}

#[test]
fn name_that_is_given_twice_is_refused() {
    let mut rig = Rig::with("is2");
    assert_eq!(
        rig.fails("set cyclic-time=100ms cyclic-t=200ms"),
        (2, "given-twice".to_owned())
    );
    assert_eq!(rig.json("get cyclic-time")["cyclic-time"]["raw"], 250);
}

#[test]
fn node_id_of_a_node_that_does_not_answer_is_in_use() {
    let mut rig = Rig::with("jn2101");
    let other = rig.bus.borrow_mut().adapter();
    rig.bus.borrow_mut().open(other, None, false);
    for _ in 0..3000 {
        let heartbeat = Frame::data(standard(0x721), &[4]).unwrap();
        rig.bus.borrow_mut().send(other, heartbeat);
    }
    assert_eq!(
        rig.fails("--node 10 node-id 33"),
        (1, "address-in-use".to_owned())
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
