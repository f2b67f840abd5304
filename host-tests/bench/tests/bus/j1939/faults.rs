//! Bus-off, a bus without another node, disturbed claims and restarts.

use crate::j1939::network::{Network, Objects, answers, claimed, is_error_passive, memory};
use bench::{Logged, Source};
use plumbline::can::BitRate;
use plumbline::node::BusState;
use plumbline::time::{after, millis};

/// SSI2 every 100 ms, recovery from bus-off.
const RECOVERING: Objects = &[(0x2104, 1, &[100, 0]), (0x3100, 2, &[1])];

/// SSI2 every 100 ms, no recovery from bus-off.
const STAYING: Objects = &[(0x2104, 1, &[100, 0]), (0x3100, 2, &[0])];

/// The claim of the sensor with the serial number 7.
const CLAIM: &str = "18EEFF80#0700E0FF00910080";

/// Disturbs the frames of a sensor until it is bus-off.
fn switch_off(network: &mut Network, place: usize) {
    let sensor = network.sensors[place];
    network.bus.corrupt(32, Some(Source::Device(sensor)));
    for _ in 0..2000 {
        if network.bus.device(sensor).bus_state() == Some(BusState::BusOff) {
            return;
        }
        network.wait(1);
    }
    panic!("the sensor is not bus-off");
}

#[test]
fn address_is_claimed_again_after_bus_off() {
    let mut network = Network::new(&[7], RECOVERING);
    network.wait(500);
    network.send("18EA8021#EBFE00", 20);
    switch_off(&mut network, 0);
    network.log.clear();
    let frames = network.wait(1000);
    network.check();
    let sent = answers(&frames);
    assert_eq!(sent, [CLAIM], "the connection has ended");
    // 250 ms later the process data begins, and only once.
    let mut own = frames
        .iter()
        .filter(|one| matches!(one.source, Source::Device(_)));
    let claim = own.next().expect("the claim");
    assert_eq!(format!("{:?}", claim.frame), CLAIM);
    let next = own.next().expect("DM1");
    let silence = next.at.ticks() - claim.at.ticks();
    assert!((250_000..253_000).contains(&silence), "{silence} us");
    assert!((7..=10).contains(&own.count()));
}

#[test]
fn bus_off_without_recovery_is_left_by_a_restart_only() {
    let mut network = Network::new(&[7], STAYING);
    // Another node acknowledges the request.
    let other = network.bus.adapter();
    network.bus.open(other, Some(BitRate::K125), false);
    network.wait(500);
    switch_off(&mut network, 0);
    assert_eq!(network.wait(3000).len(), 0);
    assert_eq!(answers(&network.send("18EAFF21#00EE00", 100)), [""; 0]);
    let sensor = network.sensors[0];
    network.bus.power_cycle(sensor);
    assert_eq!(answers(&network.wait(500)), [CLAIM]);
}

#[test]
fn restart_by_parameter_leaves_bus_off_without_recovery() {
    let mut network = Network::new(&[7], STAYING);
    network.wait(500);
    // The reply is disturbed. The restart is 100 ms after it.
    network.send("18EF8021#2F10200101000000", 1);
    let sensor = network.sensors[0];
    network.bus.corrupt(32, Some(Source::Device(sensor)));
    network.wait(80);
    let state = network.bus.device(sensor).bus_state();
    assert_eq!(state, Some(BusState::BusOff));
    let frames = network.wait(1000);
    assert_eq!(answers(&frames), [CLAIM]);
    assert!(network.active(&frames)[0] >= 5);
    assert_eq!(network.bus.device(sensor).boots(), 1);
}

#[test]
fn lower_name_keeps_the_address_claimed_during_bus_off() {
    for (late, addresses) in [(9, [0x80, 0x81]), (3, [0x81, 0x80])] {
        let mut network = Network::new(&[7], RECOVERING);
        network.wait(500);
        let memory = memory(late, RECOVERING);
        switch_off(&mut network, 0);
        network.attach(late, memory);
        network.log.clear();
        network.wait(1500);
        network.check();
        assert_eq!(network.addresses(), addresses.map(Some), "{late}");
        let frames = network.wait(1000);
        assert!(network.active(&frames).into_iter().all(|count| count >= 10));
    }
}

#[test]
fn bus_off_while_claiming_repeats_the_claim() {
    let mut network = Network::new(&[7], RECOVERING);
    network
        .bus
        .corrupt(32, Some(Source::Device(network.sensors[0])));
    // A failed claim is sent again after up to 153 ms.
    assert_eq!(answers(&network.wait(6000)), [CLAIM]);
    network.check();
    assert_eq!(network.addresses(), [Some(0x80)]);
}

#[test]
fn lone_node_has_its_address_250_ms_after_the_first_acknowledge() {
    let mut network = Network::new(&[], &[]);
    network.bus.close(network.tester);
    let stored = memory(7, RECOVERING);
    network.attach(7, stored);
    assert_eq!(network.wait(5000).len(), 0);
    network.bus.open(network.tester, Some(BitRate::K125), false);
    let begin = network.bus.now();
    let frames = network.wait(400);
    assert_eq!(answers(&frames), [CLAIM]);
    let first = frames.iter().find(|one| claimed(&one.frame).is_none());
    let first = first.expect("DM1").at;
    assert!(first > after(begin, millis(250)), "{first:?}");
    network.check();
}

#[test]
fn lone_node_queues_only_the_newest_dm1() {
    let mut network = Network::new(&[7], RECOVERING);
    network.wait(500);
    network.bus.close(network.tester);
    network.wait(10_000);
    network.bus.open(network.tester, Some(BitRate::K125), false);
    let frames = network.wait(900);
    let codes = |one: &&Logged| format!("{:?}", one.frame).starts_with("18FECA80#");
    // The one in the mailbox, the newest one in the queue, and one for the change.
    assert!((1..=3).contains(&frames.iter().filter(codes).count()));
}

#[test]
fn disturbed_claim_is_repeated() {
    for count in [1, 5, 20] {
        let mut network = Network::new(&[7, 8, 9], RECOVERING);
        network.bus.corrupt(count, None);
        network.wait(2000);
        network.check();
        let mut addresses = network.addresses();
        addresses.sort_unstable();
        assert_eq!(addresses, [0x80, 0x81, 0x82].map(Some), "{count}");
    }
}

#[test]
fn node_keeps_its_address_after_an_interruption_of_the_bus() {
    let mut network = Network::new(&[7, 8], RECOVERING);
    network.wait(500);
    for _ in 0..5 {
        network.bus.hold_dominant(millis(20));
        network.wait(500);
    }
    network.log.clear();
    let frames = network.send("18EAFF21#00EE00", 1500);
    let mut sources: Vec<_> = frames
        .iter()
        .filter_map(|one| claimed(&one.frame))
        .collect();
    sources.sort_unstable();
    assert_eq!(sources, [0x80, 0x81]);
    assert!(network.active(&frames).into_iter().all(|count| count >= 15));
}

#[test]
fn restart_by_parameter_claims_again_and_disturbs_no_other_node() {
    let mut network = Network::new(&[7, 8, 9], RECOVERING);
    network.wait(600);
    for round in 0..10 {
        let addresses = network.addresses();
        let place = round % 3;
        let address = addresses[place].expect("an address");
        let frames = network.send(&format!("18EF{address:02X}21#2F10200101000000"), 600);
        let mut sent = answers(&frames);
        sent.retain(|text| !is_error_passive(text));
        assert_eq!(sent[0], format!("18EF21{address:02X}#6010200100000000"));
        // It begins at 80h; each holder of an address with a lower NAME defends it once.
        let claims = sent[1..].iter().filter(|text| text.starts_with("18EEFF"));
        assert_eq!(claims.count(), sent.len() - 1, "{sent:?}");
        assert!(sent[1].starts_with("18EEFF80#"), "{sent:?}");
        let mut now = network.addresses();
        now.sort_unstable();
        assert_eq!(now, [0x80, 0x81, 0x82].map(Some), "{round}");
    }
}

#[test]
fn frames_with_11_bits_have_no_effect_and_no_answer() {
    let mut network = Network::new(&[7], RECOVERING);
    network.wait(500);
    let sensor = network.sensors[0];
    for text in [
        "000#8132",
        "000#8200",
        "632#4000100000000000",
        "632#2F10200101000000",
        "080#",
        "7E5#0401000000000000",
        "7E5#5E00000000000000",
    ] {
        network
            .bus
            .send(network.tester, crate::j1939::network::frame(text));
        network.bus.run_until(after(network.bus.now(), millis(100)));
        let log = network.bus.take_log();
        let own: Vec<_> = log
            .into_iter()
            .filter(|one| one.source == Source::Device(sensor))
            .collect();
        assert_eq!(answers(&own), [""; 0], "{text}");
    }
    assert_eq!(network.bus.device(sensor).boots(), 1);
    let sent = answers(&network.send("18EAFF21#00EE00", 50));
    assert_eq!(sent, [CLAIM]);
}
