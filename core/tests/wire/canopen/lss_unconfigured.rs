//! A node without a node-ID: it serves only LSS, a master finds it by fastscan, and it boots when the master has given it a
//! node-ID.

use super::lss::{CONFIGURATION, WAITING, with_number};
use crate::tester::canopen::frame;
use crate::tester::gauge::{self, Gauge, power_up};
use crate::tester::{SERIAL, Tester, leds};
use plumbline::store::Unit;
use proptest::prelude::*;

const NOTHING: [&str; 0] = [];
const FOUND: &str = "7E4#4F00000000000000";
const BEGIN: &str = "7E5#5100000000800000";

/// A gauge with this serial number whose node-ID a master has taken away.
fn unconfigured(serial: u32) -> Tester<Gauge> {
    let mut t = power_up(serial, None);
    assert_eq!(t.sent_text(), ["732#00"]);
    for (request, sent) in [
        (CONFIGURATION, &[][..]),
        ("7E5#11FF000000000000", &["7E4#1100000000000000"]),
        (WAITING, &[]),
        ("000#8200", &[]),
    ] {
        assert_eq!(t.exchange(request), sent, "{request}");
    }
    t
}

/// A fastscan request.
fn scan(number: u32, bit: u8, place: u8, next: u8) -> String {
    let [a, b, c, d] = number.to_le_bytes();
    format!("7E5#51{a:02X}{b:02X}{c:02X}{d:02X}{bit:02X}{place:02X}{next:02X}")
}

/// Hands a frame to all nodes. Returns true if one of them has answered; all answers are equal.
fn ask(nodes: &mut [Tester<Gauge>], request: &str) -> bool {
    let sent: Vec<_> = nodes.iter_mut().flat_map(|t| t.exchange(request)).collect();
    assert!(sent.iter().all(|answer| answer == FOUND), "{sent:?}");
    !sent.is_empty()
}

/// Finds the identity of one of the nodes as the master does (CiA 305): bit by bit from the highest.
fn fastscan(nodes: &mut [Tester<Gauge>]) -> Option<[u32; 4]> {
    if !ask(nodes, BEGIN) {
        return None;
    }
    let mut identity = [0; 4];
    for place in 0..4 {
        let mut number = 0;
        for bit in (0..32).rev() {
            if !ask(nodes, &scan(number, bit, place, place)) {
                number |= 1 << bit;
            }
        }
        assert!(ask(nodes, &scan(number, 0, place, (place + 1) % 4)));
        identity[usize::from(place)] = number;
    }
    Some(identity)
}

#[test]
fn node_without_node_id_sends_no_boot_up_message_and_serves_only_lss() {
    let mut t = unconfigured(SERIAL);
    assert_eq!(t.wait(1000), []);
    for ignored in [
        "000#0100",
        "000#8100",
        "000#8200",
        "080#",
        "6FF#4000100000000000",
        "632#4000100000000000",
        "7FF#R1",
        "732#R1",
        "1B2#R",
        "27F#R",
    ] {
        assert_eq!(t.exchange(ignored), NOTHING, "{ignored}");
        assert!(!t.accepts(frame(ignored).id()), "{ignored}");
    }
    assert_eq!(t.wait(1000), []);
    assert!(t.accepts(frame(CONFIGURATION).id()));
    assert_eq!(t.exchange("7E5#4C00000000000000"), ["7E4#5000000000000000"]);
    t.send(CONFIGURATION);
    assert_eq!(t.exchange("7E5#5E00000000000000"), ["7E4#5EFF000000000000"]);
    assert_eq!(t.exchange("7E5#4C00000000000000"), ["7E4#5000000000000000"]);
}

#[test]
fn node_boots_when_it_leaves_configuration_with_a_node_id() {
    let mut t = unconfigured(SERIAL);
    t.send(CONFIGURATION);
    assert_eq!(t.exchange(WAITING), NOTHING, "still without a node-ID");
    t.send(CONFIGURATION);
    assert_eq!(t.exchange("7E5#110A000000000000"), ["7E4#1100000000000000"]);
    assert_eq!(t.exchange("7E5#4C00000000000000"), NOTHING, "10 is pending");
    assert_eq!(t.exchange(WAITING), ["70A#00"]);
    t.node_id = 10;
    assert_eq!(t.read(0x2002, 0), Ok(10));
    assert_eq!(t.read(0x1800, 1), Ok(0x18A));
    t.send("000#010A");
    assert_eq!(t.exchange("080#"), ["18A#FEFF"]);
    assert_eq!(t.leds, leds(true, false));
}

#[test]
fn stored_node_id_255_stays_after_power_cycle() {
    let mut t = unconfigured(SERIAL);
    t.send(CONFIGURATION);
    assert_eq!(t.exchange("7E5#1700000000000000"), ["7E4#1700000000000000"]);
    t.power_cycle();
    assert_eq!(t.wait(1000), []);
    assert_eq!(t.exchange(BEGIN), [FOUND]);
    // Without a store, the stored node-ID comes back.
    let mut t = unconfigured(SERIAL);
    t.power_cycle();
    assert_eq!(t.sent_text(), ["732#00"]);
}

#[test]
fn unconfigured_node_activates_a_bit_rate_without_boot_up_message() {
    let mut t = unconfigured(SERIAL);
    t.send(CONFIGURATION);
    assert_eq!(t.exchange("7E5#1300000000000000"), ["7E4#1300000000000000"]);
    assert_eq!(t.exchange("7E5#150A000000000000"), NOTHING);
    assert_eq!(t.exchange(BEGIN), NOTHING);
    assert_eq!(t.wait(30), []);
    assert_eq!(t.exchange("7E5#5E00000000000000"), ["7E4#5EFF000000000000"]);
}

#[test]
fn leds_flicker_in_turn_without_node_id() {
    let mut t = unconfigured(SERIAL);
    t.wait(75);
    for _ in 0..5 {
        assert_eq!(t.leds, leds(true, false));
        t.wait(50);
        assert_eq!(t.leds, leds(false, true));
        t.wait(50);
    }
    t.send(CONFIGURATION);
    assert_eq!(t.leds, leds(true, false), "the pattern continues");
}

#[test]
fn nodes_with_the_same_node_id_are_told_apart_by_fastscan() {
    let serials = [SERIAL, SERIAL ^ 1, 0, u32::MAX];
    let mut nodes: Vec<_> = serials.map(unconfigured).into_iter().collect();
    for node_id in 1..=4 {
        let identity = fastscan(&mut nodes).unwrap();
        assert_eq!(identity[..3], gauge::IDENTITY);
        let request = format!("7E5#11{node_id:02X}000000000000");
        let mut booted = Vec::new();
        for (t, serial) in nodes.iter_mut().zip(serials) {
            let is_found = serial == identity[3];
            let answers = t.exchange(&request);
            assert_eq!(answers.len(), usize::from(is_found), "{serial:X}");
            booted.extend(t.exchange(WAITING));
        }
        assert_eq!(booted, [format!("{:03X}#00", 0x700 + node_id)]);
    }
    assert_eq!(fastscan(&mut nodes), None, "all have a node-ID");
}

#[test]
fn fastscan_finds_the_identity_of_the_unit() {
    let mut t = unconfigured(SERIAL);
    t.send(CONFIGURATION);
    assert_eq!(t.exchange("7E5#1700000000000000"), ["7E4#1700000000000000"]);
    t.unit = Unit {
        vendor: Some(0x195),
        product_code: Some(u32::MAX),
        revision: Some(0),
        serial: Some(77),
        ..Unit::NONE
    };
    t.power_cycle();
    assert_eq!(t.sent_text(), NOTHING);
    assert_eq!(fastscan(&mut [t]), Some([0x195, u32::MAX, 0, 77]));
}

#[test]
fn fastscan_answers_only_requests_for_the_present_place() {
    let mut t = unconfigured(SERIAL);
    let [vendor, product, ..] = gauge::IDENTITY;
    assert_eq!(t.exchange(BEGIN), [FOUND]);
    for (request, answers) in [
        (scan(product, 0, 1, 2), false),
        (scan(SERIAL, 0, 3, 0), false),
        (scan(vendor ^ 1, 0, 0, 1), false),
        (scan(vendor ^ 1, 1, 0, 0), true),
        (scan(vendor, 32, 0, 0), false),
        (scan(vendor, 0, 0, 4), false),
        (scan(vendor, 0, 0, 1), true),
        // Repeated.
        (scan(vendor, 0, 0, 1), false),
        (scan(product, 0, 1, 2), true),
        (BEGIN.to_string(), true),
        (scan(product, 0, 1, 2), false),
        (scan(vendor, 31, 0, 0), true),
    ] {
        assert_eq!(!t.exchange(&request).is_empty(), answers, "{request}");
    }
    assert_eq!(t.exchange("7E5#5E00000000000000"), NOTHING, "waiting");
    t.send(CONFIGURATION);
    assert_eq!(t.exchange(BEGIN), NOTHING, "not in the configuration state");
}

#[test]
fn selective_switch_configures_node_without_node_id() {
    let mut t = unconfigured(SERIAL);
    let [vendor, product, revision] = gauge::IDENTITY;
    let numbers = [vendor, product, revision, SERIAL];
    let sent: Vec<_> = (0x40..)
        .zip(numbers)
        .flat_map(|(command, number)| t.exchange(&with_number(command, number)))
        .collect();
    assert_eq!(sent, ["7E4#4400000000000000"]);
    assert_eq!(t.exchange("7E5#1121000000000000"), ["7E4#1100000000000000"]);
    assert_eq!(t.exchange(WAITING), ["721#00"]);
}

proptest! {
    /// Any LSS frames, with SDO and NMT between them: at most one answer to each, and the master still brings the node back.
    #[test]
    fn random_lss_frames_have_at_most_one_answer_and_node_stays_reachable(
        frames in prop::collection::vec(
            (prop::sample::select(vec![
                0x04_u8, 0x11, 0x13, 0x15, 0x17, 0x40, 0x41, 0x42, 0x43, 0x46, 0x47, 0x48, 0x49, 0x4A, 0x4B, 0x4C, 0x51, 0x5A,
                0x5D, 0x5E, 0x77,
            ]), any::<[u8; 7]>(), 0..3_u8, 0..20_u64),
            0..80,
        ),
    ) {
        let mut t = power_up(SERIAL, None);
        t.sent();
        for (command, data, mode, wait) in frames {
            let mut bytes = vec![command];
            // Small numbers reach more states.
            bytes.extend(data.map(|byte| if mode == 0 { byte } else { byte % 3 }));
            let id = if mode == 2 { 0x7E5 } else { [0x7E5, 0x632, 0x000][usize::from(data[0] % 3)] };
            let frame = plumbline::can::Frame::data(plumbline::can::standard(id), &bytes).unwrap();
            t.receive(frame);
            // The boot-up message or an emergency message may follow.
            prop_assert!(t.sent().len() <= 3);
            t.wait(wait);
        }
        t.wait(2 * 65_536);
        t.send(CONFIGURATION);
        t.send("7E5#1105000000000000");
        t.send(WAITING);
        t.sent();
        t.send("000#8200");
        prop_assert_eq!(t.sent_text(), ["705#00"]);
    }
}
