//! `doctor`: a bus without a fault, and each fault.

use super::rig::Rig;
use super::rig::run::Ended;
use super::talking::cyclic;
use bench::{Bus, BusRate};
use plumbline::can::{BitRate, Frame, standard};
use plumbline::time::{after, millis};
use serde_json::Value;
use std::rc::Rc;

/// Runs the tool; the exit code, the codes of the findings, the document.
fn examined(rig: &mut Rig, arguments: &str) -> (u8, Vec<String>, Value) {
    let ended = rig.tool(&format!("--json doctor {arguments}"));
    let document: Value = serde_json::from_str(&ended.out).unwrap_or_else(|error| {
        panic!("{error}: {ended:?}");
    });
    let findings = document["findings"].as_array().expect("findings").iter();
    let codes = findings.map(|finding| {
        let message = finding["message"].as_str().expect("a message");
        assert!(message.len() > 40, "the next step: {message}");
        finding["code"].as_str().expect("a code").to_owned()
    });
    (ended.code, codes.collect(), document)
}

/// A sensor with 250 kbit/s that sends each second, and a master that acknowledges.
fn healthy() -> Rig {
    cyclic("is2", BitRate::K250, "")
}

/// Lets a disturbance happen each `pause` ms for 6 s.
fn disturb(rig: &mut Rig, pause: u32, happens: impl Fn(&mut Bus) + 'static) {
    let happens = Rc::new(happens);
    for time in (0..12_000 / pause).map(|place| place * pause) {
        rig.events.push((rig.later(time), happens.clone()));
    }
}

#[test]
fn doctor_of_a_healthy_bus_finds_no_fault_and_sends_nothing() {
    for arguments in ["", "--rate 250"] {
        let mut rig = healthy();
        let (code, findings, document) = examined(&mut rig, arguments);
        assert_eq!((code, findings), (0, vec![]), "{document}");
        assert_eq!(document["rate"], 250);
        assert_eq!(document["errors"], 0);
        assert_eq!(document["identifiers"][0]["id"], "301h", "{document}");
        let load = document["load"].as_f64().expect("a load");
        assert!((0.01..0.2).contains(&load), "{document}");
    }
    let mut rig = healthy();
    let ended = rig.tool("doctor");
    for part in ["no fault was found", "250 kbit/s, 5 s"] {
        assert!(ended.out.contains(part), "{ended:?}");
    }
    assert!(ended.notes.contains("nothing was sent"), "{ended:?}");
}

#[test]
fn doctor_names_the_bit_rate_of_the_bus_if_another_one_is_given() {
    let (code, findings, document) = examined(&mut healthy(), "--rate 125");
    assert_eq!((code, &findings[..]), (1, &["wrong-rate".to_owned()][..]));
    assert_eq!(document["rate"], 250);
}

#[test]
fn doctor_sees_that_nobody_acknowledges_the_only_sender() {
    let mut rig = Rig::new(BusRate::Fixed(BitRate::K125));
    rig.attach("jn2101", 1);
    let (code, findings, document) = examined(&mut rig, "");
    assert_eq!(code, 1);
    assert_eq!(findings, ["nobody-acknowledges"], "{document}");
}

#[test]
fn doctor_of_a_silent_bus_says_so_and_with_active_asks() {
    let mut rig = Rig::new(BusRate::Fixed(BitRate::K250));
    let (code, findings, document) = examined(&mut rig, "");
    assert_eq!((code, &findings[..]), (1, &["silent".to_owned()][..]));
    assert_eq!(
        (&document["rate"], &document["seconds"]),
        (&Value::Null, &5.0.into())
    );
    // No node is there.
    rig.bus.borrow_mut().assist(false);
    let (code, findings, document) = examined(&mut rig, "--rate 250 --active");
    assert_eq!(code, 1);
    assert_eq!(findings, ["nobody-acknowledges"], "{document}");
    rig.attach("is2", 1);
    let (code, findings, document) = examined(&mut rig, "--rate 250 --active");
    assert_eq!((code, findings), (0, vec![]), "{document}");
    let sensor = document["sensors"][0].as_str().expect("a sensor");
    assert!(sensor.contains("is2, serial 1"), "{document}");
}

#[test]
fn silent_sensor_at_an_address_of_its_own_is_asked_if_the_user_gives_it() {
    let mut rig = Rig::new(BusRate::Fixed(BitRate::K125));
    rig.attach("jn2101", 1);
    assert_eq!(rig.tool("--rate 125 --node 10 node-id 11").code, 0);
    let (code, findings, document) = examined(&mut rig, "--rate 125 --node 11 --active");
    assert_eq!((code, findings), (0, vec![]), "{document}");
    let sensor = document["sensors"][0].as_str().expect("a sensor");
    assert!(sensor.contains("node-ID 11"), "{document}");
    assert_eq!(rig.fails("doctor --rate 125 --node 300").0, 2);
}

#[test]
fn doctor_finds_two_sensors_with_the_same_identifiers() {
    let mut rig = Rig::new(BusRate::Fixed(BitRate::K250));
    rig.attach("is2", 1);
    rig.attach("is2", 2);
    let (code, findings, document) = examined(&mut rig, "--rate 250 --active");
    assert_eq!(code, 1, "{document}");
    assert_eq!(findings, ["duplicate-address"], "{document}");
}

#[test]
fn errors_without_a_frame_are_reported_with_and_without_a_bit_rate() {
    for arguments in ["", "--rate 250", "--active"] {
        let mut rig = Rig::new(BusRate::Fixed(BitRate::K250));
        for place in 0..60 {
            let sends = |bus: &mut Bus| {
                let id = bus.adapter();
                bus.open(id, Some(BitRate::K250), false);
                bus.corrupt(u32::MAX, None);
                bus.send(id, Frame::data(standard(0x123), &[1]).expect("a frame"));
                bus.run_until(after(bus.now(), millis(2)));
                bus.remove(id);
            };
            rig.events.push((rig.later(place * 500), Rc::new(sends)));
        }
        let (code, findings, document) = examined(&mut rig, arguments);
        assert_eq!(code, 1);
        assert_eq!(findings, ["only-errors"], "{arguments}: {document}");
    }
}

#[test]
fn errors_of_all_identifiers_show_a_missing_terminator() {
    let mut rig = healthy();
    rig.cyclic = Some((20, Frame::data(standard(0x123), &[1, 2]).expect("a frame")));
    disturb(&mut rig, 130, |bus| bus.corrupt(1, None));
    let (code, findings, document) = examined(&mut rig, "--rate 250");
    assert_eq!(code, 1);
    assert_eq!(findings, ["probable-missing-terminator"], "{document}");
    assert!(document["errors"].as_u64() > Some(20), "{document}");
}

#[test]
fn errors_of_one_identifier_show_its_sender() {
    let mut rig = healthy();
    rig.cyclic = Some((100, Frame::data(standard(0x123), &[1, 2]).expect("a frame")));
    let device = bench::Source::Device(rig.first());
    disturb(&mut rig, 500, move |bus| bus.corrupt(3, Some(device)));
    let (code, findings, document) = examined(&mut rig, "--rate 250");
    assert_eq!(code, 1);
    assert_eq!(findings, ["errors-of-one-identifier"], "{document}");
    let message = document["findings"][0]["message"].as_str().expect("a text");
    assert!(message.contains("301h"), "{message}");
}

#[test]
fn two_senders_of_one_identifier_are_found_by_their_intervals() {
    let mut rig = healthy();
    for place in 0..12 {
        for (offset, data) in [(0, 5), (300, 5)] {
            let frame = Frame::data(standard(0x70A), &[data]).expect("a frame");
            let sends = move |bus: &mut Bus| {
                let id = bus.adapter();
                bus.open(id, Some(BitRate::K250), false);
                bus.send(id, frame);
                bus.run_until(after(bus.now(), millis(2)));
                bus.remove(id);
            };
            let at = rig.later(place * 1000 + offset);
            rig.events.push((at, Rc::new(sends)));
        }
    }
    let (code, findings, document) = examined(&mut rig, "--rate 250 --seconds 10");
    assert_eq!(code, 1);
    assert_eq!(findings, ["duplicate-identifier"], "{document}");
}

#[test]
fn high_load_is_a_finding() {
    let mut rig = healthy();
    rig.cyclic = Some((
        1,
        Frame::data(standard(0x123), &[0x55; 8]).expect("a frame"),
    ));
    disturb(&mut rig, 1, |bus| {
        let frame = Frame::data(standard(0x124), &[0x55; 8]).expect("a frame");
        let id = bus.adapter();
        bus.open(id, Some(BitRate::K250), false);
        bus.send(id, frame);
        bus.run_until(after(bus.now(), millis(1)));
        bus.remove(id);
    });
    let (code, findings, document) = examined(&mut rig, "--rate 250 --seconds 1");
    assert_eq!(code, 1, "{document}");
    assert_eq!(findings, ["high-load"], "{document}");
}

#[test]
fn doctor_refuses_a_wrong_time_and_ends_with_the_adapter() {
    let code = |ended: Ended| ended.code;
    assert_eq!(code(healthy().tool("doctor --seconds -1")), 2);
    let mut rig = healthy();
    rig.cut = Some(0);
    assert_eq!(rig.fails("doctor").0, 4);
    let mut rig = healthy();
    rig.stop = Some(2);
    assert_eq!(code(rig.tool("doctor --rate 250")), 130);
}
