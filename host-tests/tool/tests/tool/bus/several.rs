//! `scan` on a bus with several sensors.

use super::bit_rate::wired;
use super::rig::{Rig, file};
use super::scan::scan;
use bench::{Bus, BusRate, DeviceId};
use plumbline::can::{BitRate, Frame, standard};
use plumbline::time::{after, millis};
use serde_json::Value;
use std::rc::Rc;

/// Protocol, product and address of each row, sorted.
fn found(rows: &[Value]) -> Vec<String> {
    let text = |value: &Value| value.as_str().unwrap_or("-").to_owned();
    let mut rows: Vec<String> = rows
        .iter()
        .map(|row| ["protocol", "product", "address"].map(|name| text(&row[name])))
        .map(|row| row.join(" "))
        .collect();
    rows.sort();
    rows
}

/// Two sensors on a wire at 125 kbit/s. The first one has been set alone.
pub fn pair(first: &str, settings: &[&str], second: &str) -> (Rig, [DeviceId; 2]) {
    let mut rig = wired(first, BitRate::K125);
    for command in settings {
        rig.done(&format!("--rate 125 {command}"));
    }
    let one = rig.first();
    rig.bus.borrow_mut().power_cycle(one);
    rig.run(2500);
    let two = rig.attach(second, 8);
    rig.run(2500);
    rig.bus.borrow_mut().assist(false);
    rig.says_yes = false;
    rig.questions.clear();
    rig.witnessed();
    (rig, [one, two])
}

/// The identifiers of a GEMAC sensor next to a sensor with identifiers as delivered.
const MOVED: [&str; 2] = [
    "--id 300 rate 125",
    "--id 300 set set-id=310h reply-id=311h --save",
];

#[test]
fn two_boot_ups_are_both_found_by_listening() {
    let (mut rig, ids) = pair("is2", &MOVED, "is1");
    rig.says_yes = true;
    rig.done("--rate 125 --id 300 rate 125");
    rig.says_yes = false;
    rig.questions.clear();
    rig.bus.borrow_mut().assist(false);
    // Each sensor acknowledges the other one, so the messages come only twice.
    for gap in [0, 300] {
        let on = after(rig.bus.borrow().now(), millis(2000));
        rig.power_cycle_at(on, ids[0]);
        rig.power_cycle_at(after(on, millis(gap)), ids[1]);
        let (rows, _) = scan(&mut rig, "--rate 125");
        assert_eq!(found(&rows), ["fsc is1 300", "fsc is2 310"], "{gap}");
        assert!(rig.questions.is_empty(), "{:?}", rig.questions);
    }
}

#[test]
fn two_heartbeats_are_both_found_by_listening() {
    let (mut rig, _) = pair(
        "jn2101",
        &["--node 10 set heartbeat-interval-time=1s --save"],
        "ims360",
    );
    rig.done("--rate 125 --node 50 set producer-heartbeat-time=700ms");
    let (rows, time) = scan(&mut rig, "");
    assert_eq!(found(&rows), ["canopen ims360 50", "canopen jn2101 10"]);
    assert!(rig.questions.is_empty() && time < 13_000, "{time} ms");
}

#[test]
fn gemac_and_canopen_on_one_bus_are_both_found() {
    let (mut rig, _) = pair("is2", &["--id 300 rate 125"], "jn2101");
    let (rows, _) = scan(&mut rig, "--active");
    assert_eq!(found(&rows), ["canopen jn2101 10", "fsc is2 300"]);
    // Both talk: cyclic values and a heartbeat.
    rig.done("--rate 125 --id 300 set cyclic-mode=on");
    rig.done("--rate 125 --node 10 set heartbeat-interval-time=500ms");
    rig.says_yes = true;
    let (rows, _) = scan(&mut rig, "");
    assert_eq!(found(&rows), ["canopen jn2101 10", "fsc is2 300"]);
}

#[test]
fn two_silent_gemac_sensors_are_found_by_a_search() {
    let (mut rig, _) = pair("is2", &MOVED, "is1");
    let (rows, _) = scan(&mut rig, "--rate 125 --active --search");
    assert_eq!(found(&rows), ["fsc is1 300", "fsc is2 310"]);
}

#[test]
fn two_sensors_with_the_same_identifiers_are_listed_and_none_is_chosen() {
    for rate in [BitRate::K10, BitRate::K250, BitRate::M1] {
        let mut rig = Rig::new(BusRate::Fixed(rate));
        for serial in [21, 22] {
            rig.attach("is2", serial);
        }
        let kbits = super::bit_rate::kbits(rate);
        rig.run(200);
        let ended = rig.tool(&format!("--rate {kbits} scan --active"));
        assert_eq!(ended.code, 0, "{ended:?}");
        for text in ["2 sensors answer at identifier 300h", "21", "22", "alone"] {
            assert!(ended.notes.contains(text), "{rate:?} {ended:?}");
        }
        for command in ["--id 300 zero --save", "--id 300 set filter=1Hz", "get"] {
            rig.witnessed();
            assert_eq!(
                rig.fails(&format!("--rate {kbits} {command}")),
                (2, "several-sensors".to_owned()),
                "{rate:?} {command}"
            );
            let seen = rig.witnessed();
            let mut texts = seen.iter().map(|frame| format!("{frame:?}"));
            assert!(
                !texts.any(|frame| frame.starts_with("300#2") || frame.starts_with("300#5")),
                "{command}"
            );
        }
    }
}

#[test]
fn two_sensors_with_the_same_node_id_are_told() {
    let mut rig = Rig::new(BusRate::Fixed(BitRate::K125));
    for serial in [21, 22] {
        rig.attach("jn2101", serial);
    }
    rig.run(200);
    let ended = rig.tool("--rate 125 scan --active");
    assert_eq!(ended.code, 0, "{ended:?}");
    for text in ["2 sensors answer at node-ID 10", "21", "22", "node-id"] {
        assert!(ended.notes.contains(text), "{ended:?}");
    }
}

/// Both would take the settings, and the answers of both would be read as those of one.
#[test]
fn no_command_acts_on_two_sensors_with_the_same_node_id() {
    for (product, node, serials) in [("jn2101", 10, [21, 22]), ("ims360", 50, [21, 22])] {
        let mut rig = Rig::new(BusRate::Fixed(BitRate::K125));
        rig.says_yes = true;
        rig.attach(product, serials[0]);
        rig.run(200);
        let path = file(&format!("twins-{product}.toml"));
        let path = path.display().to_string();
        rig.done(&format!("--rate 125 --node {node} replace read {path}"));
        // A request to one of them can come a little later than to the other one.
        rig.attach(product, serials[1]);
        rig.run(203);
        for command in [
            "zero",
            "save",
            "load-factory",
            "node-id 12",
            "rate 250",
            "get",
            "backup twins-other.toml",
            &format!("diff {path}"),
            &format!("restore {path}"),
            &format!("replace write {path}"),
        ] {
            rig.witnessed();
            let ended = rig.tool(&format!("--rate 125 --node {node} {command}"));
            assert_eq!(ended.code, 2, "{product} {command} {ended:?}");
            let told = format!("2 sensors answer at node-ID {node}");
            assert!(ended.notes.contains(&told), "{product} {command} {ended:?}");
            // Uploads only: no other service of SDO, no NMT command, no LSS.
            for frame in rig.witnessed() {
                let id = frame.can_id();
                let is_write =
                    matches!(frame.bytes().first().map(|code| code >> 5), Some(0 | 1 | 6));
                let is_reading = id != standard(0x600 + node).into() || !is_write;
                let is_nmt = id == standard(0).into() || id == standard(0x7E5).into();
                assert!(is_reading && !is_nmt, "{product} {command} {frame:?}");
            }
        }
    }
}

/// The second one of two sensors with one MAC ID is silent after its duplicate MAC ID check, so only the messages of the check tell it.
#[test]
fn two_sensors_with_the_same_mac_id_are_told_when_they_are_switched_on() {
    for is_together in [false, true] {
        let mut rig = Rig::new(BusRate::Fixed(BitRate::K125));
        let other = rig.bus.borrow_mut().adapter();
        rig.bus.borrow_mut().open(other, Some(BitRate::K125), false);
        let first = rig.attach("tiltix080", 21);
        rig.run(3000);
        let second = rig.attach("tiltix080", 22);
        rig.run(3000);
        let on = rig.later(500);
        rig.power_cycle_at(on, second);
        if is_together {
            rig.power_cycle_at(on, first);
        }
        let ended = rig.tool("--rate 125 scan");
        let told = "2 sensors have MAC ID 63, with the serial numbers ";
        for text in [told, "21", "22", "red network LED", "plumbline mac"] {
            assert!(ended.notes.contains(text), "{is_together} {text} {ended:?}");
        }
        assert_eq!(ended.notes.matches(told).count(), 1, "{ended:?}");
        let rows = ended.out.matches("address 63").count();
        assert!(rows <= 2, "{ended:?}");
    }
}

/// J1939-81: the address claims settle it, so both answer at an address of their own.
#[test]
fn two_sensors_with_the_same_preferred_address_of_j1939_are_both_found() {
    let mut rig = super::j1939::network("");
    rig.attach("ims360", 2);
    rig.run(2000);
    for command in ["raw 3100:1=01", "save", "restart"] {
        rig.done(&format!("--node 50 {command}"));
    }
    rig.run(1000);
    let rows = rig.json("--rate 250 scan");
    let rows = rows.as_array().expect("rows").iter();
    let mut told: Vec<(&str, u64)> = rows
        .map(|row| {
            (
                row["address"].as_str().unwrap(),
                row["serial"].as_u64().unwrap(),
            )
        })
        .collect();
    told.sort_unstable();
    assert_eq!(told, [("128", 1), ("129", 2)]);
    let several = (2, "several-sensors".to_owned());
    assert_eq!(rig.fails("--rate 250 zero"), several);
}

/// A frame of 8 bytes that begins with the code for the serial number.
fn like_a_serial_number(id: u16, number: u8) -> Frame {
    let bytes = [4, 0, number, 0x22, 0x33, 0x44, 0x55, 0x66];
    Frame::data(standard(id), &bytes).unwrap()
}

#[test]
fn frames_of_another_device_that_begin_with_04h_are_no_second_sensor() {
    for cycle in [5, 10, 20] {
        let mut rig = Rig::with("is2");
        rig.cyclic = Some((cycle, like_a_serial_number(0x123, 7)));
        for command in ["get cyclic-time", "zero", "set filter=1Hz"] {
            let ended = rig.tool(&format!("--rate 250 --id 300 {command}"));
            assert_eq!(ended.code, 0, "{cycle} {command} {ended:?}");
            assert!(ended.notes.contains("serial 1,"), "{ended:?}");
        }
        let ended = rig.tool("--rate 250 scan --active");
        assert!(!ended.notes.contains("sensors answer"), "{ended:?}");
    }
}

#[test]
fn serial_number_that_is_not_repeated_is_no_second_sensor() {
    // Another device sends a counter with the Reply-Parameter-ID.
    let mut rig = Rig::with("is2");
    let other = rig.bus.borrow_mut().adapter();
    rig.bus.borrow_mut().open(other, None, false);
    for number in 0..40 {
        let at = rig.later(u32::from(number) * 10);
        let frame = like_a_serial_number(0x301, number);
        let happens = move |bus: &mut Bus| bus.send(other, frame);
        rig.events.push((at, Rc::new(happens)));
    }
    let ended = rig.tool("--rate 250 --id 300 get cyclic-time");
    assert_eq!(ended.code, 0, "{ended:?}");
    assert!(ended.notes.contains("is2, serial 1,"), "{ended:?}");
}
