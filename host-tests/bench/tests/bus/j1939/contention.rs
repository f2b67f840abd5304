//! Nodes with the same preferred address that are switched on at the same time.

use crate::j1939::network::{
    NO_ADDRESS, Network, Objects, PREFERRED, answers, claimed, frame, is_error_passive, memory,
    name,
};
use bench::Source;
use plumbline::can::Frame;
use std::collections::BTreeSet;

/// The rate of SSI2 is 100 ms: 20 nodes with 10 ms exceed 125 kbit/s.
const SLOW: Objects = &[(0x2104, 1, &[100, 0])];

/// SSI2 every 100 ms, and a NAME that is not arbitrary address capable.
const FIXED: Objects = &[(0x2104, 1, &[100, 0]), (0x2106, 1, &[0])];

/// All nodes get distinct addresses within this time, in ms.
const SETTLED: u32 = 3000;

/// The frames of the sensors, without the cyclic frames and without the trouble code of the collisions.
fn contending(frames: &[bench::Logged]) -> Vec<String> {
    let mut sent = answers(frames);
    sent.retain(|text| !is_error_passive(text));
    sent
}

/// Starts the nodes, and checks that each gets an address of its own and sends.
fn settle(serials: &[u32], objects: Objects) -> Network {
    let mut network = Network::new(serials, objects);
    network.wait(SETTLED);
    network.check();
    let addresses: Vec<u8> = network.addresses().into_iter().flatten().collect();
    let distinct: BTreeSet<_> = addresses.iter().collect();
    assert_eq!(distinct.len(), serials.len(), "{addresses:02X?}");
    let expected = PREFERRED..PREFERRED + serials.len() as u8;
    assert!(
        distinct.into_iter().all(|one| expected.contains(one)),
        "{addresses:02X?}"
    );
    // Address of the lowest NAME.
    let lowest = serials
        .iter()
        .enumerate()
        .min_by_key(|(_, serial)| name(**serial));
    let (first, _) = lowest.expect("a node");
    assert_eq!(addresses[first], PREFERRED, "{addresses:02X?}");
    // Nobody contends any more, and each sends its process data and DM1.
    let frames = network.wait(2000);
    network.check();
    assert_eq!(contending(&frames), [""; 0]);
    for (place, count) in network.active(&frames).into_iter().enumerate() {
        assert!((20..=24).contains(&count), "{place}: {count}");
    }
    network
}

/// Their claims have the same identifier and different data, and begin in the same bit.
#[test]
fn claims_that_collide_are_not_repeated_until_a_random_delay_ends() {
    for serials in [[1, 2], [2, 1], [0x1F_FFFF, 0], [305_419_896, 7]] {
        let mut network = settle(&serials, SLOW);
        for sensor in network.sensors.clone() {
            let errors = network.bus.disturbed(Source::Device(sensor));
            assert!((1..=2).contains(&errors), "{errors}");
        }
        let passive = |one: &&bench::Logged| is_error_passive(&format!("{:?}", one.frame));
        assert_eq!(network.log.iter().filter(passive).count(), 0);
        network.log.clear();
    }
}

#[test]
fn two_nodes_get_distinct_addresses() {
    settle(&[1, 2], SLOW);
    settle(&[2, 1], SLOW);
    // The lowest and the highest identity number.
    settle(&[0x1F_FFFF, 0], SLOW);
}

#[test]
fn five_nodes_get_distinct_addresses() {
    settle(&[305_419_896, 7, 4_000_000_000, 65_536, 1_000_001], SLOW);
}

#[test]
fn twenty_nodes_get_distinct_addresses() {
    let serials: Vec<u32> = (1..=20).map(|number| number * 1_234_567).collect();
    settle(&serials, SLOW);
}

#[test]
fn twenty_nodes_with_consecutive_identity_numbers_get_distinct_addresses() {
    let serials: Vec<u32> = (0..20).rev().map(|number| 1000 + number).collect();
    settle(&serials, SLOW);
}

#[test]
fn node_that_cannot_take_another_address_is_silent() {
    let mut network = Network::new(&[3, 1, 2], FIXED);
    network.wait(SETTLED);
    network.check();
    let addresses = network.addresses();
    assert_eq!(
        addresses,
        [Some(NO_ADDRESS), Some(PREFERRED), Some(NO_ADDRESS)]
    );
    let losers = |one: &&bench::Logged| claimed(&one.frame) == Some(NO_ADDRESS);
    assert_eq!(network.log.iter().filter(losers).count(), 2, "once each");
    let frames = network.wait(2000);
    let [one, winner, other] = network.active(&frames)[..] else {
        panic!("three nodes");
    };
    assert!(
        one == 0 && other == 0 && winner >= 20,
        "{one} {winner} {other}"
    );
    // A request for the claim is answered by all, for other groups by the winner.
    let sent = network.send("18EAFF21#00EE00", 400);
    let mut claims: Vec<_> = sent.iter().filter_map(|one| claimed(&one.frame)).collect();
    claims.sort_unstable();
    assert_eq!(claims, [PREFERRED, NO_ADDRESS, NO_ADDRESS]);
    let sent = answers(&network.send("18EAFF21#DAFE00", 50));
    assert_eq!(sent.len(), 1, "{sent:?}");
    network.check();
}

#[test]
fn equal_names_do_not_block_the_bus() {
    // Identity numbers have 21 bits.
    let mut network = Network::new(&[1, 1 + (1 << 21), 2], SLOW);
    network.wait(SETTLED);
    let mut addresses: Vec<u8> = network.addresses().into_iter().flatten().collect();
    addresses.sort_unstable();
    assert_eq!(addresses, [PREFERRED, PREFERRED, PREFERRED + 1]);
    network.wait(3000);
    let claims = network
        .log
        .iter()
        .filter(|one| claimed(&one.frame).is_some());
    assert!(claims.count() <= 10, "they do not answer each other");
    // A third one with this NAME comes later.
    let late = memory(1 + (2 << 21), SLOW);
    network.attach(1 + (2 << 21), late);
    let frames = network.wait(1000);
    let claims = frames.iter().filter(|one| claimed(&one.frame).is_some());
    assert_eq!(claims.count(), 1);
}

#[test]
fn nodes_that_restart_repeatedly_get_distinct_addresses_each_time() {
    let serials: Vec<u32> = (1..=5).collect();
    let mut network = settle(&serials, SLOW);
    // Each start at another time, also within the 250 ms of others.
    let mut state = 1_u32;
    for _ in 0..40 {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        let sensor = network.sensors[(state >> 16) as usize % serials.len()];
        network.bus.power_cycle(sensor);
        // A sensor that starts again knows nothing of its last address.
        network.wait(state >> 24);
    }
    network.log.clear();
    for sensor in network.sensors.clone() {
        network.bus.power_cycle(sensor);
    }
    network.wait(SETTLED);
    network.check();
    let addresses: BTreeSet<_> = network.addresses().into_iter().flatten().collect();
    assert_eq!(addresses.len(), serials.len(), "{addresses:02X?}");
    let frames = network.wait(2000);
    assert_eq!(contending(&frames), [""; 0]);
    assert!(network.active(&frames).iter().all(|count| *count >= 20));
}

#[test]
fn late_node_with_a_lower_name_takes_the_address() {
    let mut network = settle(&[5, 6], SLOW);
    let late = memory(1, SLOW);
    let newest = network.attach(1, late);
    network.wait(SETTLED);
    network.check();
    assert_eq!(network.addresses()[2], Some(PREFERRED));
    let addresses: BTreeSet<_> = network.addresses().into_iter().flatten().collect();
    assert_eq!(addresses.len(), 3, "{addresses:02X?}");
    // All nodes hear the claims, so each node changes its address at most once.
    let moved = network
        .log
        .iter()
        .filter(|one| one.source != Source::Device(newest));
    let claims = moved.filter(|one| claimed(&one.frame).is_some());
    assert!(claims.count() <= 6);
}

#[test]
fn requested_claims_of_all_nodes_have_their_names() {
    let serials = [9, 8, 7, 6, 5];
    let mut network = settle(&serials, SLOW);
    let sent = network.send("18EAFFFE#00EE00", 50);
    let names: BTreeSet<u64> = sent
        .iter()
        .filter(|one| claimed(&one.frame).is_some())
        .map(|one| u64::from_le_bytes(Frame::bytes(&one.frame).try_into().expect("8 bytes")))
        .collect();
    assert_eq!(names, serials.iter().map(|serial| name(*serial)).collect());
}

#[test]
fn claim_that_waits_for_the_bus_is_withdrawn_when_the_address_is_lost() {
    let mut network = Network::new(&[], &[]);
    let stored = memory(2, SLOW);
    network.bus.give_way(false);
    // Frames with a higher priority follow each other, one of them a claim of 80h with the lowest NAME.
    let filler = "00FF0021#0102030405060708";
    let frames = [
        &[filler; 10][..],
        &["00EEFF80#0000000000000000"],
        &[filler; 5],
    ]
    .concat();
    for text in &frames {
        network.bus.send(network.tester, frame(text));
    }
    network.attach(2, stored);
    let log = network.wait(200);
    let sent = log.iter().map(|one| format!("{:?}", one.frame));
    let sent: Vec<_> = sent.filter(|text| text != filler).collect();
    assert_eq!(sent, [frames[10], "18EEFF81#0200E0FF00910080"]);
}

#[test]
fn silence_starts_again_after_contention_and_after_commanded_address() {
    let mut network = Network::new(&[7], SLOW);
    let claim = format!("{PREFERRED:02X}#0700E0FF00910080");
    while network.wait(1).is_empty() {}
    network.wait(200);
    let mut frames = network.send("18EEFF80#FFFFFFFFFFFFFFFF", 300);
    assert_eq!(answers(&frames), [format!("18EEFF{claim}")]);
    // Commanded Address with the present address.
    for text in [
        "1CECFF21#20090002FFD8FE00",
        "1CEBFF21#010700E0FF009100",
        "1CEBFF21#028080FFFFFFFFFF",
    ] {
        network.check();
        network.log.clear();
        frames = network.send(text, 5);
    }
    frames.extend(network.wait(400));
    assert_eq!(answers(&frames), [format!("18EEFF{claim}")]);
    assert!(network.active(&frames)[0] > 0);
    network.check();
}
