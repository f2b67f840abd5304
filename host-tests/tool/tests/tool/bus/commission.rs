//! `commission`: sensors as delivered on one bus, which a user switches on one after the other.

use super::rig::{Ended, Rig, file};
use bench::{Bus, BusRate, DeviceId};
use plumbline::can::{BitRate, standard};
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
        let tells = ended.notes.contains("goes on where it stopped");
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
fn fastscan_that_is_stopped_leaves_no_node_in_configuration_mode() {
    const RELEASE: [u8; 8] = [4, 0, 0, 0, 0, 0, 0, 0];
    let (mut rig, ids) = rig(BusRate::Fixed(BitRate::K125), &[("ims360", 7)]);
    let text = "[[sensor]]\nname = \"one\"\nproduct = \"ims360\"\nfind = \"fastscan\"\nparameters.node-id = 61\n";
    let plan = plan(&mut rig, "stopped", text);
    let mut bus = rig.bus.borrow_mut();
    let now = bus.now();
    bus.device_mut(ids[0]).power_on(now);
    drop(bus);
    rig.run(2000);
    rig.stop = Some(60);
    rig.witnessed();
    let ended = commission(&mut rig, &plan, "");
    assert_ne!(ended.code, 0, "{ended:?}");
    let seen = rig.witnessed().into_iter();
    let mut masters = seen.filter(|frame| frame.can_id() == standard(0x7E5).into());
    let last = masters.next_back().expect("a request of fastscan");
    assert!(masters.count() > 3, "{ended:?}");
    assert_eq!(last.bytes(), RELEASE);
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
fn sensor_that_stays_on_is_not_taken_for_one_that_is_off() {
    let (mut rig, ids) = rig(BusRate::Fixed(BitRate::K125), &[("jn2101", 7)]);
    let plan = plan(&mut rig, "stays", &format!("alone = true\n{PAIR}"));
    switch_on(&mut rig, &ids, false);
    let ended = commission(&mut rig, &plan, "");
    assert_eq!(ended.code, 2, "{ended:?}");
    assert!(ended.notes.contains("left still answers"), "{ended:?}");
}

#[test]
fn fastscan_finds_equal_sensors_that_are_on_together() {
    let devices = [("ims360", 7), ("ims360", 8), ("ims360", 9)];
    let (mut rig, ids) = rig(BusRate::Fixed(BitRate::K125), &devices);
    let text = |name: &str, node: u8| {
        format!(
            "[[sensor]]\nname = \"{name}\"\nproduct = \"ims360\"\nfind = \"fastscan\"\nparameters.node-id = {node}\n"
        )
    };
    let first = text("one", 61);
    let plan = plan(&mut rig, "fastscan", &first);
    for id in &ids {
        let mut bus = rig.bus.borrow_mut();
        let now = bus.now();
        bus.device_mut(*id).power_on(now);
    }
    // The adapter fails after fastscan, and at other places before and after it.
    for cut in [20, 150, 160, 170] {
        rig.cut = Some(cut);
        let ended = commission(&mut rig, &plan, "");
        assert!([0, 4].contains(&ended.code), "{cut}: {ended:?}");
    }
    rig.cut = None;
    assert_eq!(sensors(&commission(&mut rig, &plan, "--json")).len(), 1);
    // The two others come later, beside the first one.
    let all = format!("{first}{}{}", text("two", 62), text("three", 63));
    fs::write(&plan, all).expect("a file");
    let ended = commission(&mut rig, &plan, "--json");
    let rows = sensors(&ended);
    assert_eq!(rows.len(), 3, "{rows:?}");
    for (row, node) in rows.iter().zip(61..) {
        assert!(
            row.ends_with(&format!(" node-ID {node} 125 kbit/s")),
            "{rows:?}"
        );
    }
    for id in &ids {
        rig.bus.borrow_mut().power_cycle(*id);
    }
    rig.run(1000);
    let mut serials = Vec::new();
    for node in 61..64 {
        let own = rig.json(&format!(
            "--rate 125 --node {node} get identity-object-serial-number"
        ));
        serials.push(own["identity-object-serial-number"]["value"].as_u64());
    }
    serials.sort();
    assert_eq!(serials, [Some(7), Some(8), Some(9)]);
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
