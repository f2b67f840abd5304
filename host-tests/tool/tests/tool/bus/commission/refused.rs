//! What is refused, and then changes nothing.

use super::{PAIR, commission, plan, rig, sensors, switch_on};
use bench::BusRate;
use plumbline::can::BitRate;
use serde_json::Value;
use std::fs;

#[test]
fn sensor_whose_zero_is_not_confirmed_stays_as_it_was() {
    let (mut rig, ids) = rig(BusRate::Fixed(BitRate::K125), &[("jn2101", 7)]);
    let plan = plan(&mut rig, "unconfirmed", PAIR);
    switch_on(&mut rig, &ids, false);
    rig.yes_to = Some("none of the questions");
    let ended = commission(&mut rig, &plan, "");
    assert_ne!(ended.code, 0, "{ended:?}");
    assert!(ended.notes.contains("nothing has changed"), "{ended:?}");
    assert_eq!(
        rig.json("--rate 125 --node 10 get node-id")["node-id"]["value"],
        10
    );
    assert_eq!(rig.json("--rate 125 --node 10 label")["label"], Value::Null);
}

#[test]
fn wrong_plan_is_refused_before_a_frame_is_sent() {
    let (mut rig, ids) = rig(BusRate::Fixed(BitRate::K125), &[("jn2101", 7)]);
    switch_on(&mut rig, &ids, false);
    let text = PAIR.replace("node-id = 12", "node-id = 1200");
    let plan = plan(&mut rig, "wrong", &text);
    let ended = commission(&mut rig, &plan, "");
    assert_eq!(ended.code, 2, "{ended:?}");
    assert!(ended.notes.contains("plan.toml line 9: 1200"), "{ended:?}");
    let missing = plan.with_file_name("no-such.toml");
    let ended = commission(&mut rig, &missing, "");
    assert!(
        ended.code == 4 && ended.notes.contains("takes a plan"),
        "{ended:?}"
    );
    let state = plan.with_extension("state.toml");
    fs::write(&plan, PAIR).expect("a file");
    fs::write(&state, "nonsense").expect("a file");
    let ended = commission(&mut rig, &plan, "");
    assert!(
        ended.code == 2 && ended.notes.contains("plan.state.toml"),
        "{ended:?}"
    );
    assert_eq!(rig.witnessed(), []);
}

#[test]
fn other_serial_number_of_a_finished_sensor_is_refused() {
    let (mut rig, ids) = rig(BusRate::Fixed(BitRate::K125), &[("jn2101", 7)]);
    let text = "[[sensor]]\nname = \"left\"\nproduct = \"jn2101\"\nparameters.node-id = 11\n";
    let plan = plan(&mut rig, "finished", text);
    switch_on(&mut rig, &ids, false);
    assert_eq!(sensors(&commission(&mut rig, &plan, "--json")).len(), 1);
    for (serial, code) in [(7, 0), (8, 2)] {
        let text = text.replace("parameters", &format!("serial = {serial}\nparameters"));
        fs::write(&plan, text).expect("a file");
        let ended = commission(&mut rig, &plan, "");
        assert_eq!(ended.code, code, "{serial}: {ended:?}");
        assert_eq!(ended.notes.contains("was changed"), code > 0, "{ended:?}");
    }
}

#[test]
fn sensor_that_is_not_in_the_plan_is_not_changed() {
    let (mut rig, ids) = rig(BusRate::Fixed(BitRate::K125), &[("jn2101", 9)]);
    let text =
        "[[sensor]]\nname = \"left\"\nproduct = \"jn2101\"\nserial = 7\nparameters.node-id = 11\n";
    let plan = plan(&mut rig, "foreign", text);
    switch_on(&mut rig, &ids, false);
    let ended = commission(&mut rig, &plan, "");
    assert_eq!(ended.code, 1, "{ended:?}");
    assert!(ended.notes.contains("serial 9"), "{ended:?}");
    assert_eq!(rig.json("--rate 125 get node-id")["node-id"]["value"], 10);
}

#[test]
fn equal_sensors_that_are_on_together_are_refused() {
    let (mut rig, ids) = rig(
        BusRate::Fixed(BitRate::K125),
        &[("jn2101", 7), ("jn2101", 8)],
    );
    let plan = plan(&mut rig, "twins", PAIR);
    for id in ids {
        let mut bus = rig.bus.borrow_mut();
        let now = bus.now();
        bus.device_mut(id).power_on(now);
    }
    let ended = commission(&mut rig, &plan, "");
    assert_eq!(ended.code, 2, "{ended:?}");
    assert!(ended.notes.contains("7 and 8"), "{ended:?}");
    assert!(!plan.with_extension("state.toml").exists(), "{ended:?}");
}

#[test]
fn sensor_that_stays_on_is_not_taken_for_one_that_is_off() {
    let (mut rig, ids) = rig(BusRate::Fixed(BitRate::K125), &[("jn2101", 7)]);
    let plan = plan(&mut rig, "stays", &format!("alone = true\n{PAIR}"));
    switch_on(&mut rig, &ids, false);
    let ended = commission(&mut rig, &plan, "");
    assert_eq!(ended.code, 2, "{ended:?}");
    assert!(ended.notes.contains("left still answers"), "{ended:?}");
}
