use super::*;
use crate::master::devicenet::explicit::Slave;
use crate::master::fsc::request::Sensor;
use crate::master::{Ca, canopen};
use plumbline::can::{CanId, Frame, extended, standard};
use plumbline::time::Instant;

fn frame(id: u16, bytes: &[u8]) -> Frame {
    Frame::data(standard(id), bytes).unwrap()
}

/// The frames, 10 ms one after the other.
fn timed(frames: &[Frame]) -> Vec<(Instant, Frame)> {
    let times = (0..).map(|place| Instant::from_ticks(10_000 * place));
    times.zip(frames.iter().copied()).collect()
}

fn addresses(frames: &[Frame]) -> Vec<(&'static str, String)> {
    let sightings = sightings(&timed(frames));
    sightings
        .iter()
        .map(|sighting| sighting.row.address())
        .map(|(protocol, address)| (protocol, address.unwrap_or_default()))
        .collect()
}

/// The targets that are asked without a yes.
fn asked(frames: &[Frame]) -> Vec<Target> {
    asked_at(&timed(frames))
}

fn asked_at(frames: &Frames) -> Vec<Target> {
    let sightings = sightings(frames);
    let sure = sightings.iter().filter(|sighting| sighting.is_sure);
    sure.filter_map(|sighting| sighting.target).collect()
}

const BOOT_UP: [u8; 8] = [0xFF, 3, 0x20, 3, 0, 0, 0x44, 3];

#[test]
fn boot_up_message_counts_only_twice() {
    let message = frame(0x321, &BOOT_UP);
    assert_eq!(addresses(&[message]), []);
    assert_eq!(addresses(&[message, message]), [("fsc", "320".to_owned())]);
    // Bits between the format and the identifier are not permitted.
    let other = frame(0x321, &[0xFF, 3, 0x20, 3, 1, 0, 0x44, 3]);
    assert_eq!(addresses(&[other, other]), []);
}

#[test]
fn nodes_of_all_protocols_are_recognised() {
    let claim = Frame::data(extended(0x18EE_FF80), &[0, 0, 0x40, 0x1F, 0, 0, 0, 0x80]).unwrap();
    let frames = [
        frame(0x70A, &[0]),
        frame(0x77F, &[0x7F]),
        frame(0x5FF, &[0, 0x62, 0x01, 1, 2, 3, 4]),
        claim,
        // None of these is a sign.
        frame(0x700, &[0]),
        frame(0x70B, &[1]),
        frame(0x70C, &[0, 0]),
        frame(0x181, &[1, 2, 3, 4]),
        frame(0x5FE, &[0, 0x62, 0x01, 1, 2, 3, 4]),
        frame(0x5F7, &[1, 0x62, 0x01, 1, 2, 3, 4]),
        Frame::remote(standard(0x70D), 1).unwrap(),
    ];
    let expected = [
        ("canopen", "10"),
        ("canopen", "127"),
        ("devicenet", "63"),
        ("j1939", "128"),
    ];
    let found = addresses(&frames);
    let found: Vec<(&str, &str)> = found
        .iter()
        .map(|(protocol, address)| (*protocol, address.as_str()))
        .collect();
    assert_eq!(found, expected);
    let serials: Vec<String> = sightings(&timed(&frames))
        .iter()
        .map(|sighting| sighting.row.json(None)["serial"].to_string())
        .collect();
    assert_eq!(serials[2], 0x0403_0201.to_string());
}

#[test]
fn process_data_and_diagnosis_show_a_j1939_node() {
    let frame = |id: u32| Frame::data(extended(id), &[0, 0xFF, 0, 0, 0, 0, 0xFF, 0xFF]).unwrap();
    let (ssi2, diagnosis) = (frame(0x0CF0_2980), frame(0x18FE_CA80));
    assert_eq!(asked(&[ssi2]), []);
    assert_eq!(asked(&[ssi2, ssi2]), [Target::J1939(Ca(0x80))]);
    assert_eq!(asked(&[diagnosis]), [Target::J1939(Ca(0x80))]);
    // Its claim, which tells the maker, takes the place of the process data.
    let claim = frame(0x18EE_FF80);
    assert_eq!(asked(&[ssi2, ssi2, claim]), [Target::J1939(Ca(0x80))]);
    assert_eq!(
        addresses(&[ssi2, ssi2, claim]),
        [("j1939", "128".to_owned())]
    );
    // Cannot claim, another group, another protocol.
    for id in [0x18EE_FFFE, 0x18FE_CB80, 0x1AFE_CA80] {
        assert_eq!(addresses(&[frame(id); 3]), [], "{id:X}");
    }
}

#[test]
fn node_that_another_master_talks_to_is_not_asked() {
    let boot = frame(0x70A, &[0]);
    assert_eq!(asked(&[boot]), [Target::Canopen(canopen::Node(10))]);
    assert_eq!(asked(&[boot, frame(0x60A, &[0x40])]), []);
    assert_eq!(asked(&[boot, frame(0x58A, &[0x43])]), []);
    let message = frame(0x321, &BOOT_UP);
    assert_eq!(asked(&[message, message]).len(), 1);
    assert_eq!(asked(&[message, message, frame(0x320, &[0])]), []);
    let check = frame(0x40F, &[0, 0x62, 1, 1, 2, 3, 4]);
    let (first, second) = (Instant::from_ticks(0), Instant::from_ticks(1_000_000));
    let checks = [(first, check), (second, check)];
    assert_eq!(asked_at(&checks), [Target::Devicenet(Slave { mac: 1 })]);
    for id in [0x40B, 0x40C, 0x40E] {
        let other = [checks[0], checks[1], (second, frame(id, &[1]))];
        assert_eq!(asked_at(&other), [], "{id:X}");
    }
}

#[test]
fn boot_up_message_is_certain_if_sent_exactly_twice_or_by_a_lone_node() {
    let message = frame(0x321, &BOOT_UP);
    let other = frame(0x123, &[]);
    assert_eq!(asked(&[message, message, other]).len(), 1);
    assert_eq!(asked(&[message, message, message]).len(), 1, "alone");
    assert_eq!(asked(&[message, message, message, other]), []);
    // Constant data once a second comes twice while the tool listens.
    let later = [
        (Instant::from_ticks(0), message),
        (Instant::from_ticks(500_000), other),
        (Instant::from_ticks(1_000_000), message),
    ];
    assert!(sightings(&later).iter().all(|sighting| !sighting.is_sure));
}

#[test]
fn identifiers_of_management_are_never_asked() {
    for (low, high) in [(0x00, 0), (0x80, 0), (0xE4, 7), (0xE5, 7)] {
        let message = frame(0x321, &[0xFF, 3, low, high, 0, 0, 0x44, 3]);
        assert_eq!(asked(&[message, message]), [], "{high:X}{low:02X}");
    }
}

#[test]
fn duplicate_check_is_sure_exactly_twice_in_a_second_or_alone_and_without_other_protocols() {
    // TPDO data of CANopen node 7 can look like it: RPDO4 is 507h.
    let check = frame(0x507, &[0, 1, 2, 3, 4, 5, 6]);
    assert_eq!(asked(&[check]), []);
    assert_eq!(asked(&[check, check, check]).len(), 1, "alone");
    let at = |frames: &[(u64, Frame)]| -> Vec<(Instant, Frame)> {
        let frames = frames.iter();
        let frames = frames.map(|(time, frame)| (Instant::from_ticks(time * 1000), *frame));
        frames.collect()
    };
    let other = (300, frame(0x123, &[]));
    let pair = [(0, check), other, (1000, check)];
    assert_eq!(asked_at(&at(&pair)).len(), 1);
    // Constant data of a cyclic frame.
    for cycle in [100, 550, 1150] {
        let cyclic = [(0, check), other, (cycle, check)];
        assert_eq!(asked_at(&at(&cyclic)), [], "{cycle}");
    }
    let often = [(0, check), other, (500, check), (1000, check)];
    assert_eq!(asked_at(&at(&often)), []);
    // One frame of DeviceNet can look like a heartbeat of CANopen, and one of CANopen like a check of DeviceNet.
    let heartbeat = frame(0x707, &[5]);
    let both = [(0, check), (1000, check), (1001, heartbeat)];
    assert_eq!(asked_at(&at(&both)), []);
    let twice = [(0, check), (1, heartbeat), (1000, check), (1001, heartbeat)];
    assert_eq!(asked_at(&at(&twice)), [Target::Canopen(canopen::Node(7))]);
    let claim = Frame::data(extended(0x18EE_FF80), &[0; 8]).unwrap();
    let with_claim = [(0, check), (1, claim), (1000, check)];
    assert_eq!(asked_at(&at(&with_claim)), [Target::J1939(Ca(0x80))]);
}

/// The addresses that are asked after a yes.
fn asked_after_a_yes(frames: &[Frame]) -> Vec<Target> {
    let sightings = sightings(&timed(frames));
    let unsure = sightings.iter().filter(|sighting| !sighting.is_sure);
    unsure.filter_map(|sighting| sighting.target).collect()
}

#[test]
fn node_that_is_known_by_process_data_is_asked_only_after_a_yes() {
    let cyclic = |id, counter| frame(id, &[0, 1, 0, 0, 0, 0, counter, 0]);
    let delivered = [cyclic(0x301, 1), cyclic(0x301, 2)];
    assert_eq!(asked(&delivered), []);
    let sensor = Sensor {
        request: CanId::standard(0x300),
        reply: Some(CanId::standard(0x301)),
    };
    assert_eq!(asked_after_a_yes(&delivered), [Target::Fsc(sensor)]);
    assert_eq!(protocol(&sightings(&timed(&delivered))), Some("fsc"));
    // A master polls it, or it has other identifiers.
    let polled = [delivered[0], frame(0x300, &[0]), delivered[1]];
    assert_eq!(asked_after_a_yes(&polled), []);
    let moved = [cyclic(0x303, 1), cyclic(0x303, 2)];
    assert_eq!(asked_after_a_yes(&moved), []);
    assert_eq!(addresses(&moved), [("fsc", String::new())]);
    assert_eq!(protocol(&sightings(&timed(&moved))), None);
    let pdos = [frame(0x18A, &[1, 2]); 2];
    assert_eq!(
        (asked(&pdos), asked_after_a_yes(&pdos)),
        (vec![], vec![Target::Canopen(canopen::Node(10))])
    );
    assert_eq!(protocol(&sightings(&timed(&pdos))), None);
    let io = [frame(0x42D, &[]), frame(0x3C5, &[1, 2])];
    let io = [io, io].concat();
    assert_eq!((asked(&io), asked_after_a_yes(&io)), (vec![], vec![]));
    assert_eq!(protocol(&sightings(&timed(&io))), Some("devicenet"));
}

#[test]
fn node_that_tells_its_address_is_not_seen_again_by_its_process_data() {
    let pdo = frame(0x18A, &[1, 2]);
    let ten = ("canopen", "10".to_owned());
    let eleven = ("canopen", "11".to_owned());
    let frames = [frame(0x70A, &[5]), pdo, pdo];
    assert_eq!(addresses(&frames), vec![ten.clone()]);
    let frames = [frame(0x70B, &[5]), pdo, pdo];
    assert_eq!(addresses(&frames), [eleven, ten]);
    let message = frame(0x321, &BOOT_UP);
    let cyclic = |counter| frame(0x321, &[0, 1, 0, 0, 0, 0, counter, 0]);
    let frames = [message, message, cyclic(1), cyclic(2)];
    assert_eq!(addresses(&frames), [("fsc", "320".to_owned())]);
    // One bus has one protocol: a heartbeat excludes DeviceNet.
    let io = [frame(0x42D, &[]), frame(0x3C5, &[1, 2])];
    let frames = [&io[..], &io, &[frame(0x70A, &[5])]].concat();
    assert!(
        addresses(&frames)
            .iter()
            .all(|(protocol, _)| *protocol == "canopen")
    );
}

#[test]
fn tpdo_with_a_counter_beside_a_heartbeat_is_no_gemac_sensor() {
    let tpdo = |counter| frame(0x185, &[0, 0, 0, 0, 0, 0, counter, 0]);
    let mut frames = vec![frame(0x705, &[5])];
    frames.extend((0..9).map(tpdo));
    assert_eq!(addresses(&frames), [("canopen", "5".to_owned())]);
}
