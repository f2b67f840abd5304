//! `commission`: sensors as delivered on one bus, which a user switches on one after the other.

mod fastscan;
mod refused;

use super::rig::run::Ended;
use super::rig::{Rig, file};
use bench::{Bus, BusRate, DeviceId};
use plumbline::can::BitRate;
use plumbline::time::{after, millis};
use serde_json::Value;
use std::fs;
use std::path::{Path, PathBuf};
use std::rc::Rc;

/// The time for each sensor, in ms.
const TURN: u32 = 60_000;

/// A bus with sensors that are off.
fn rig(rate: BusRate, sensors: &[(&str, u32)]) -> (Rig, Vec<DeviceId>) {
    let mut rig = Rig::new(rate);
    rig.says_yes = true;
    let mut ids = Vec::new();
    for (product, serial) in sensors {
        let id = rig.attach(product, *serial);
        let mut bus = rig.bus.borrow_mut();
        let now = bus.now();
        bus.device_mut(id).power_off(now);
        drop(bus);
        ids.push(id);
    }
    (rig, ids)
}

/// Switches sensors on while the tool runs, each in its turn. If they are alone, the one before is switched off.
fn switch_on(rig: &mut Rig, ids: &[DeviceId], alone: bool) {
    for (turn, id) in (0..).zip(ids.iter().copied()) {
        let at = rig.later(1000 + turn * TURN);
        let on = move |bus: &mut Bus| {
            let now = bus.now();
            bus.device_mut(id).power_on(now);
        };
        let off = move |bus: &mut Bus| {
            let now = bus.now();
            bus.device_mut(id).power_off(now);
        };
        rig.events.push((at, Rc::new(on)));
        if alone {
            rig.events
                .push((after(at, millis(TURN - 5000)), Rc::new(off)));
        }
    }
}

/// A plan in a folder of its own, which also has the state and the names.
fn plan(rig: &mut Rig, name: &str, text: &str) -> PathBuf {
    let folder = file("commission").join(name);
    let _ = fs::remove_dir_all(&folder);
    fs::create_dir_all(&folder).expect("a folder");
    rig.config = Some(folder.clone());
    let path = folder.join("plan.toml");
    fs::write(&path, text).expect("a file");
    path
}

fn commission(rig: &mut Rig, plan: &Path, more: &str) -> Ended {
    rig.tool(&format!("{more} commission {}", plan.display()))
}

/// The sensors in the document.
#[track_caller]
fn sensors(ended: &Ended) -> Vec<String> {
    assert_eq!(ended.code, 0, "{ended:?}");
    let document: Value =
        serde_json::from_str(&ended.out).unwrap_or_else(|why| panic!("{why}: {ended:?}"));
    let rows = document["sensors"].as_array().expect("sensors").iter();
    let text = |row: &Value, name: &str| row[name].as_str().unwrap_or("-").to_owned();
    rows.map(|row| {
        let (name, serial) = (text(row, "name"), &row["serial"]);
        format!(
            "{name} {serial} {} {}",
            text(row, "address"),
            text(row, "rate")
        )
    })
    .collect()
}

const PAIR: &str = "[[sensor]]\nname = \"left\"\nproduct = \"jn2101\"\nzero = true\n\
    parameters.node-id = 11\n\
    [[sensor]]\nname = \"right\"\nproduct = \"jn2101\"\nparameters.node-id = 12\n";

#[test]
fn equal_sensors_of_two_products_get_the_settings_of_a_plan_in_turn() {
    // The serial number of the sensor of another maker is one that is done.
    let devices = [("jn2101", 7), ("jn2101", 8), ("is2", 7)];
    let (mut rig, ids) = rig(BusRate::Fixed(BitRate::K125), &devices);
    let text = format!(
        "{PAIR}[[sensor]]\nname = \"boom\"\nproduct = \"is2\"\n[sensor.parameters]\ncyclic-time = \"250 ms\"\n"
    );
    let plan = plan(&mut rig, "equal", &text);
    switch_on(&mut rig, &ids, false);
    let ended = commission(&mut rig, &plan, "--json");
    assert_eq!(
        sensors(&ended),
        [
            "left 7 node-ID 11 125 kbit/s",
            "right 8 node-ID 12 125 kbit/s",
            "boom 7 identifier 300h 125 kbit/s"
        ]
    );
    assert!(
        ended
            .notes
            .contains("switch on the next sensor: boom (is2)"),
        "{}",
        ended.notes
    );
    let zero = rig.questions.iter().filter(|own| own.contains("zero"));
    assert_eq!(zero.count(), 1, "{:?}", rig.questions);
    // All of it is stored.
    for id in &ids {
        rig.bus.borrow_mut().power_cycle(*id);
    }
    rig.run(1000);
    let angle = rig.json("--rate 125 --node 11 get slope-long32")["slope-long32"]["value"].clone();
    assert!(angle.as_f64().is_some_and(|own| own.abs() < 0.1), "{angle}");
    let cycle = rig.json("--rate 125 --id 300 get cyclic-time")["cyclic-time"]["value"].clone();
    assert_eq!(cycle, 250);
    assert_eq!(rig.json("--rate 125 --node 12 label")["label"], "right");
    // Everything is done, so nobody is asked again.
    rig.witnessed();
    assert_eq!(
        sensors(&commission(&mut rig, &plan, "--json --rate 125")).len(),
        3
    );
    assert_eq!(rig.witnessed(), []);
}

#[test]
fn serial_number_selects_the_sensor_of_the_plan() {
    let (mut rig, ids) = rig(
        BusRate::Fixed(BitRate::K125),
        &[("jn2101", 8), ("jn2101", 7)],
    );
    let text = PAIR.replace("zero = true", "serial = 7");
    let plan = plan(&mut rig, "serial", &text);
    switch_on(&mut rig, &ids, false);
    let ended = commission(&mut rig, &plan, "--json");
    let expected = [
        "left 7 node-ID 11 125 kbit/s",
        "right 8 node-ID 12 125 kbit/s",
    ];
    assert_eq!(sensors(&ended), expected);
}

#[test]
fn interrupted_commissioning_continues() {
    let (mut rig, ids) = rig(
        BusRate::Fixed(BitRate::K125),
        &[("jn2101", 7), ("jn2101", 8)],
    );
    let plan = plan(&mut rig, "resume", PAIR);
    switch_on(&mut rig, &ids[..1], false);
    rig.cut = Some(5);
    let mut codes = Vec::new();
    // The adapter fails in each place once.
    for _ in 0..40 {
        let ended = rig.tool(&format!("commission {} --wait 5", plan.display()));
        codes.push(ended.code);
        let has_state = plan.with_extension("state.toml").exists();
        let tells = ended.notes.contains("continues where it stopped");
        assert_eq!(tells, has_state, "{ended:?}");
        rig.cut = rig.cut.map(|cut| cut + 5);
        if ended.code == 3 {
            break;
        }
    }
    // The first one is done, and the second one is not there.
    assert_eq!(codes.pop(), Some(3), "{codes:?}");
    assert!(
        codes.len() > 3 && codes.iter().all(|code| *code == 4),
        "{codes:?}"
    );
    rig.cut = None;
    switch_on(&mut rig, &ids[1..], false);
    let ended = commission(&mut rig, &plan, "--json");
    let expected = [
        "left 7 node-ID 11 125 kbit/s",
        "right 8 node-ID 12 125 kbit/s",
    ];
    assert_eq!(sensors(&ended), expected);
}

#[test]
fn sensor_of_another_product_at_the_same_address_can_come_first() {
    let devices = [("is2", 8), ("is1", 7)];
    let (mut rig, ids) = rig(BusRate::Fixed(BitRate::K250), &devices);
    let sensor = |name: &str, digit: u8| {
        format!(
            "[[sensor]]\nname = \"{name}\"\nproduct = \"{name}\"\n[sensor.parameters]\n\
            set-id = \"31{digit}h\"\nreply-id = \"32{digit}h\"\nbaud-rate = \"250 kbit/s\"\n"
        )
    };
    let text = sensor("is1", 0) + &sensor("is2", 2);
    let plan = plan(&mut rig, "products", &text);
    switch_on(&mut rig, &ids, false);
    let ended = commission(&mut rig, &plan, "--json");
    let expected = [
        "is1 7 identifier 310h 250 kbit/s",
        "is2 8 identifier 312h 250 kbit/s",
    ];
    assert_eq!(sensors(&ended), expected);
}

#[test]
fn sensors_that_are_alone_can_have_equal_addresses_and_another_rate() {
    let (mut rig, ids) = rig(BusRate::Wire, &[("jn2101", 7), ("jn2101", 8)]);
    rig.bus.borrow_mut().assist(true);
    let text = "alone = true\n[[sensor]]\nname = \"one\"\nproduct = \"jn2101\"\nparameters.baud-rate = \"250 kbit/s\"\n\
        [[sensor]]\nname = \"two\"\nproduct = \"jn2101\"\nparameters.baud-rate = \"250 kbit/s\"\n";
    let plan = plan(&mut rig, "alone", text);
    switch_on(&mut rig, &ids, true);
    let ended = commission(&mut rig, &plan, "--json");
    let expected = ["one 7 node-ID 10 250 kbit/s", "two 8 node-ID 10 250 kbit/s"];
    assert_eq!(sensors(&ended), expected);
    assert!(ended.notes.contains("switch one off"), "{}", ended.notes);
}

#[test]
fn sensor_that_has_its_new_bit_rate_already_is_found_again() {
    for (product, find) in [("jn2101", ""), ("ims360", "find = \"fastscan\"\n")] {
        let (mut rig, ids) = rig(BusRate::Wire, &[(product, 7)]);
        rig.bus.borrow_mut().assist(true);
        let text = format!(
            "alone = true\n[[sensor]]\nname = \"one\"\nproduct = \"{product}\"\n{find}\
            [sensor.parameters]\nbaud-rate = \"250 kbit/s\"\nnode-id = 11\n"
        );
        let plan = plan(&mut rig, &format!("rate-{product}"), &text);
        let mut bus = rig.bus.borrow_mut();
        let now = bus.now();
        bus.device_mut(ids[0]).power_on(now);
        drop(bus);
        let mut cut = 0;
        // The adapter fails in many places.
        let ended = loop {
            cut += 6;
            rig.cut = Some(cut);
            let ended = rig.tool(&format!("--json commission {} --wait 5", plan.display()));
            if ended.code != 4 {
                break ended;
            }
        };
        assert_eq!(sensors(&ended), ["one 7 node-ID 11 250 kbit/s"]);
    }
}

#[test]
fn sensor_of_each_protocol_is_commissioned() {
    for (product, setting) in [
        ("is2", "cyclic-time = \"300 ms\""),
        ("is1d", "set-id = \"310h\"\nreply-id = \"311h\""),
        ("ims360", "node-id = 60"),
        (
            "ims360",
            "can-protocol = \"j1939\"\npreferred-address = 140",
        ),
        ("tiltix080", "mac-id = 7"),
    ] {
        let (mut rig, ids) = rig(BusRate::Follow, &[(product, 5)]);
        let text = format!(
            "[[sensor]]\nname = \"only\"\nproduct = \"{product}\"\nzero = true\n[sensor.parameters]\n{setting}\n"
        );
        let plan = plan(&mut rig, product, &text);
        switch_on(&mut rig, &ids, false);
        let report = plan.with_file_name("report.txt");
        let ended = commission(&mut rig, &plan, "");
        assert_eq!(ended.code, 0, "{product}: {ended:?}");
        let again = rig.tool(&format!(
            "commission {} --report {}",
            plan.display(),
            report.display()
        ));
        assert_eq!(again.code, 0, "{product}: {again:?}");
        let report = fs::read_to_string(&report).expect("a report");
        let count = match setting.lines().count() {
            1 => "1 setting",
            _ => "2 settings",
        };
        let stored = format!("; {count} stored and compared, zero (");
        assert!(report.contains(&stored), "{report}");
        assert!(
            report.starts_with(&format!("only  {product}, serial 5, ")),
            "{report}"
        );
    }
}
