//! `scan` and the other commands on a bus with foreign devices: a witness sees that nothing is sent to them.

use super::cyclic::texts;
use super::rig::Rig;
use super::scan::silent;
use bench::{Bus, BusRate, NodeType};
use plumbline::can::{BitRate, CanId, Frame, extended, standard};
use serde_json::{Value, json};
use std::rc::Rc;

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
fn foreign_frames_that_look_like_sensors_are_not_asked() {
    for frames in [
        // J1939 fills with FFh; the bytes 2 to 5 would be SYNC, NMT, and an identifier of a drive.
        vec![(0x123, vec![0xFF, 1, 0x80, 0, 0, 0, 0xFF, 0xFF]); 700],
        vec![(0x123, vec![0xFF, 1, 0, 0, 0, 0, 0xFF, 0xFF]); 2],
        [
            vec![(0x124, vec![1])],
            vec![(0x123, vec![0xFF, 1, 6, 2, 0, 0, 0xFF, 0xFF]); 700],
        ]
        .concat(),
        vec![(0x123, vec![0xFF, 1, 6, 2, 0, 0, 0xFF, 0xFF])],
        // RPDO4 of CANopen node 7 is the duplicate MAC ID check of node 32.
        vec![(0x507, vec![0x00, 1, 2, 3, 4, 5, 6])],
        // The same with a heartbeat of CANopen.
        [
            vec![(0x507, vec![0x80, 1, 2, 3, 4, 5, 6]); 100],
            vec![(0x707, vec![5]); 5],
            vec![(0x607, vec![0x40, 0, 0x10, 0, 0, 0, 0, 0]); 5],
        ]
        .concat(),
    ] {
        for command in ["scan", "get", "--rate 250 get"] {
            let mut rig = silent("is2", BitRate::K250);
            let (foreign, other) = {
                let mut bus = rig.bus.borrow_mut();
                (bus.adapter(), bus.adapter())
            };
            for id in [foreign, other] {
                rig.bus.borrow_mut().open(id, Some(BitRate::K250), false);
            }
            // The first frame comes while the tool listens.
            for (id, bytes) in &frames {
                let frame = Frame::data(standard(*id), bytes).unwrap();
                rig.bus.borrow_mut().send(foreign, frame);
            }
            rig.tool(command);
            let is_foreign = |frame: &Frame| {
                frames.iter().any(|(id, bytes)| {
                    frame.can_id() == CanId::standard(*id) && frame.bytes() == bytes
                })
            };
            let own: Vec<Frame> = rig
                .witnessed()
                .into_iter()
                .filter(|frame| !is_foreign(frame))
                .collect();
            assert_eq!(own, [], "{command} {:?}", frames[0]);
        }
    }
}

#[test]
fn only_the_protocol_of_the_bus_is_asked() {
    let mut rig = Rig::with("jn2101");
    rig.done("set heartbeat-interval-time=100ms");
    let other = rig.bus.borrow_mut().adapter();
    rig.bus.borrow_mut().open(other, None, false);
    rig.witnessed();
    rig.done("scan --active --rate 250");
    let foreign: Vec<String> = rig
        .witnessed()
        .iter()
        .filter(|frame| !matches!(frame.can_id().bits(), 0x581..=0x67F | 0x70A | 0x7E4 | 0x7E5))
        .map(|frame| format!("{frame:?}"))
        .collect();
    assert_eq!(foreign, [""; 0]);
}

#[test]
fn bus_with_traffic_is_asked_at_other_addresses_only_after_a_yes() {
    for says_yes in [false, true] {
        let mut rig = Rig::with("jn2101");
        rig.done("set heartbeat-interval-time=100ms");
        rig.says_yes = says_yes;
        rig.witnessed();
        rig.done("scan --active --rate 250");
        let is_other =
            |frame: &&Frame| !matches!(frame.can_id().bits(), 0x08A | 0x58A | 0x60A | 0x70A);
        let frames = rig.witnessed();
        let others: Vec<&Frame> = frames.iter().filter(is_other).collect();
        assert_eq!(!others.is_empty(), says_yes, "{others:?}");
    }
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
    let rows = rig.json("scan");
    let rows = rows.as_array().unwrap();
    let foreign = rows.iter().find(|row| row["address"] == "34").unwrap();
    assert_eq!(
        (&foreign["protocol"], &foreign["product"]),
        (&json!("canopen"), &json!(null))
    );
}

#[test]
fn cyclic_frame_that_looks_like_a_boot_up_message_is_not_asked_by_any_command() {
    // Its bytes 2 to 5 are the identifier 206h of another device.
    let frame = Frame::data(standard(0x123), &[0xFF, 1, 6, 2, 0, 0, 0xFF, 0xFF]).unwrap();
    for command in [
        "--rate 250 --id 304 get",
        "--rate 250 --node 9 get",
        "--rate 250 get",
        "--rate 250 --product is2 get",
    ] {
        for cycle in [40, 90] {
            let mut rig = silent("is2", BitRate::K250);
            rig.cyclic = Some((cycle, frame));
            rig.tool(command);
            let seen = rig.witnessed();
            let count = seen.iter().filter(|own| **own == frame).count();
            assert!(count > 5, "{command} {count}");
            let asked = seen
                .iter()
                .filter(|own| own.can_id() == CanId::standard(0x206));
            assert_eq!(asked.count(), 0, "{command} {cycle}");
        }
    }
}

#[test]
fn named_product_of_another_protocol_than_the_bus_is_asked_after_a_yes() {
    let heartbeat = Frame::data(standard(0x722), &[5]).unwrap();
    let mut rig = silent("is2", BitRate::K250);
    rig.cyclic = Some((100, heartbeat));
    assert_eq!(
        rig.fails("--rate 250 --product is2 get serial-number"),
        (2, "no-address".to_owned())
    );
    assert_eq!(rig.questions.len(), 1);
    rig.says_yes = true;
    let read = rig.json("--rate 250 --product is2 get serial-number");
    assert_eq!(read["serial-number"]["raw"], 5);
    // Its identifier is used by another device.
    rig.cyclic = Some((100, Frame::data(standard(0x300), &[5]).unwrap()));
    assert_eq!(
        rig.fails("--rate 250 --product is2 get serial-number"),
        (2, "no-address".to_owned())
    );
}

/// Another device sends frames with a cycle in ms for 5 s while the tool runs; `frame` takes the count.
fn device(rig: &mut Rig, cycle: u32, frame: impl Fn(u8) -> Frame) {
    let id = rig.bus.borrow_mut().adapter();
    let rate = Some(BitRate::K250);
    rig.bus.borrow_mut().open(id, rate, false);
    for place in 0..5000 / cycle {
        let frame = frame(place as u8);
        let happens = move |bus: &mut Bus| bus.send(id, frame);
        rig.events
            .push((rig.later(place * cycle), Rc::new(happens)));
    }
    rig.events.sort_by_key(|(at, _)| *at);
}

/// A frame with a counter in the place of the counter of cyclic mode.
fn counted(id: u16, counter: u8) -> Frame {
    Frame::data(standard(id), &[0, 0, 0, 0, 0, 0, counter, 0]).unwrap()
}

#[test]
fn group_of_j1939_with_a_counter_is_no_gemac_sensor() {
    let mut rig = Rig::new(BusRate::Fixed(BitRate::K250));
    device(&mut rig, 900, |counter| {
        Frame::data(extended(0x18FF_1234), &[0, 10, 0, 0, 0, 0, counter, 0]).unwrap()
    });
    assert_eq!(
        rig.fails("--rate 250 scan"),
        (3, "nothing-found".to_owned())
    );
}

#[test]
fn tpdo_with_a_counter_is_no_gemac_sensor() {
    let mut rig = Rig::new(BusRate::Fixed(BitRate::K250));
    device(&mut rig, 500, |_| {
        Frame::data(standard(0x705), &[5]).unwrap()
    });
    device(&mut rig, 100, |counter| counted(0x185, counter));
    let rows = rig.json("--rate 250 scan");
    let addresses: Vec<(&Value, &Value)> = rows
        .as_array()
        .unwrap()
        .iter()
        .map(|row| (&row["protocol"], &row["address"]))
        .collect();
    assert_eq!(addresses, [(&json!("canopen"), &json!("5"))]);
}

#[test]
fn silent_node_is_found_beside_a_device_with_a_counter() {
    for command in ["scan --active", "scan"] {
        let mut rig = Rig::with("jn2101");
        device(&mut rig, 100, |counter| counted(0x2F0, counter));
        let rows = rig.json(&format!("--rate 250 {command}"));
        let rows = rows.as_array().unwrap();
        assert!(
            rows.iter().any(|row| row["product"] == "jn2101"),
            "{rows:?}"
        );
        // The row of the other device is only likely.
        assert!(
            rows.iter()
                .all(|row| row["product"] == "jn2101" || row["likely"] == true),
            "{rows:?}"
        );
    }
}

#[test]
fn machine_with_identifiers_of_tpdos_is_no_canopen_sensor() {
    let mut rig = Rig::new(BusRate::Fixed(BitRate::K250));
    for id in [0x1F0, 0x2E1, 0x493] {
        device(&mut rig, 100, |_| {
            Frame::data(standard(id), &[1, 2]).unwrap()
        });
    }
    assert_eq!(
        rig.fails("--rate 250 scan"),
        (3, "nothing-found".to_owned())
    );
}

#[test]
fn address_that_is_only_likely_is_asked_twice_at_most() {
    // A TPDO, and cyclic values with the identifier as delivered: nobody answers.
    for (id, first, request) in [(0x1F0, 1, "670#"), (0x301, 0, "300#")] {
        let mut rig = Rig::new(BusRate::Fixed(BitRate::K250));
        device(&mut rig, 100, |counter| {
            Frame::data(standard(id), &[first, 0, 0, 0, 0, 0, counter, 0]).unwrap()
        });
        // Nobody is asked at other addresses.
        rig.says_yes = true;
        rig.yes_to = Some("Send requests to it?");
        let rows = rig.json("--rate 250 scan");
        assert_eq!(rows.as_array().map(Vec::len), Some(1), "{rows}");
        let seen = texts(&rig.witnessed());
        let asked = seen.iter().filter(|frame| frame.starts_with(request));
        assert_eq!(asked.count(), 2, "{id:X} {seen:?}");
    }
}

#[test]
fn frame_of_another_device_in_the_form_of_a_reply_is_ignored() {
    // The first byte is the code of the question for the article.
    let like = |counter| Frame::data(standard(0x080), &[3, counter, 1, 2, 3, 4, 5, 6]).unwrap();
    let mut rig = Rig::with("is2");
    device(&mut rig, 1, like);
    let read = rig.json("--rate 250 --id 300 get cyclic-time");
    assert_eq!(read["cyclic-time"]["value"], 250, "{read}");
    let mut rig = Rig::new(BusRate::Fixed(BitRate::K250));
    device(&mut rig, 1, like);
    let nobody = rig.fails("--rate 250 --id 300 get cyclic-time");
    assert_eq!(nobody, (3, "no-answer".to_owned()));
}
