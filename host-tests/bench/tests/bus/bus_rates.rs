//! Bit rates on the simulated wire: detection, a device at another rate, a real wire.

use bench::script::*;
use bench::{Bus, BusRate, Source};
use plumbline::can::BitRate;
use plumbline::node::{BitTime, BusEvent, BusMode, BusState};

#[test]
fn detecting_device_measures_rate_of_traffic() {
    let mut bus = Bus::new(BusRate::Fixed(BitRate::K125));
    let device = bus.attach(device(&DETECTING, 1));
    let (plc, other) = (bus.adapter(), bus.adapter());
    bus.open(plc, Some(BitRate::K125), false);
    bus.open(other, None, false);
    bus.run_until(ms(1));
    for count in 1..=20 {
        bus.send(plc, frame(0x300, &[0x00, 0xFF, count]));
        bus.run_until(ms(10 * u64::from(count)));
    }
    assert_eq!(bus.device(device).mode(), Some(BusMode::Normal));
    assert_eq!(bus.device(device).rate(), Some(BitRate::K125));
    let entries: Vec<Entry> = journal(1).into_iter().map(|(_, entry)| entry).collect();
    // It listens at 10 kbit/s, measures the first frame, and receives the second one.
    let measured = Entry::Event(BusEvent::BitTime(BitTime::of(BitRate::K125)));
    assert_eq!(entries.iter().filter(|one| **one == measured).count(), 1);
    let received = frame(0x300, &[0x00, 0xFF, 2]);
    assert_eq!(entries.last(), Some(&Entry::Frame(received)));
    assert_eq!(bus.take_received(plc).len(), 1, "its boot-up frame");
    for adapter in [plc, other] {
        assert_eq!(bus.disturbed(Source::Adapter(adapter)), 0);
    }
}

#[test]
fn device_at_other_rate_neither_receives_nor_disturbs() {
    let mut bus = Bus::new(BusRate::Fixed(BitRate::K500));
    let device = bus.attach(device(&FIXED, 1));
    let (a, b) = (bus.adapter(), bus.adapter());
    bus.open(a, Some(BitRate::K500), false);
    bus.open(b, None, false);
    bus.run_until(ms(1));
    bus.send(a, frame(0x201, &[command::ECHO]));
    bus.run_until(ms(100));
    assert_eq!(bus.take_received(b).len(), 1);
    assert!(bus.take_received(a).is_empty());
    for adapter in [a, b] {
        assert_eq!(bus.disturbed(Source::Adapter(adapter)), 0);
    }
    // Its boot-up frame gets no acknowledge.
    let frames = journal(1)
        .into_iter()
        .filter(|(_, entry)| matches!(entry, Entry::Frame(_)));
    assert_eq!(frames.count(), 0);
    assert_eq!(bus.device(device).error_counters(), Some((128, 0)));
}

#[test]
fn device_at_other_rate_disturbs_all_on_real_wire() {
    let mut bus = Bus::new(BusRate::Wire);
    let device = bus.attach(device(&FIXED, 1));
    let (a, b) = (bus.adapter(), bus.adapter());
    bus.open(a, Some(BitRate::K500), false);
    bus.open(b, Some(BitRate::K500), false);
    for count in 0..100 {
        bus.send(a, frame(0x123, &[0x00, 0xFF, count]));
    }
    bus.run_until(ms(1000));
    assert!(bus.disturbed(Source::Adapter(b)) > 0);
    let state = bus.device(device).bus_state().unwrap();
    assert_ne!(state, BusState::Active);
    // An error passive device disturbs no other participant.
    assert_eq!(bus.take_received(b).len(), 100);
}

#[test]
fn assistant_is_off_on_real_wire_unless_requested() {
    let mut bus = Bus::new(BusRate::Wire);
    let lone = bus.adapter();
    bus.open(lone, Some(BitRate::K500), false);
    bus.send(lone, frame(0x123, &[]));
    bus.run_until(ms(100));
    assert_eq!(bus.queued(lone), 1);
    assert!(bus.disturbed(Source::Adapter(lone)) > 100);
    // The assistant has the rate of the first device, or 250 kbit/s.
    let other = bus.adapter();
    bus.open(other, Some(BitRate::K500), false);
    bus.run_until(ms(200));
    assert_eq!(bus.queued(lone), 0);
    bus.assist(true);
    bus.close(other);
    bus.open(lone, None, false);
    bus.send(lone, frame(0x123, &[]));
    bus.run_until(ms(300));
    assert_eq!(bus.queued(lone), 0);
}
