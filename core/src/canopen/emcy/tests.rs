//! The tests of the parent module.

use super::*;

const BITS: [FaultBit; 8] = {
    let mut bits = [FaultBit::RESERVED; 8];
    let range = Faults::X.and(Faults::Y);
    bits[0] = fault("Range", Cause::Application(range), 0x9000, 0);
    bits[3] = fault("Memory", Cause::Memory, 0x5000, 1 << 4);
    bits
};
const FAULTS: &[Fault; 8] = &faults(&BITS);
const MEMORY: u8 = bits_of(&BITS, Cause::Memory);

fn at(us: u64) -> Instant {
    Instant::from_ticks(us)
}

/// Sets the faults of the application and queues all messages.
fn set<H: History>(emergency: &mut Emergency<H>, faults: Faults) {
    let causes = causes(&BITS);
    emergency.want(caused(causes, Faults(u16::MAX)), caused(causes, faults));
    while emergency.announce_next() {}
}

#[test]
fn fault_sends_error_when_it_begins_and_reset_when_it_ends() {
    let mut emergency = Emergency::<Deque<u32, 4>>::INITIAL;
    emergency.start(FAULTS);
    set(&mut emergency, Faults::Y);
    set(&mut emergency, Faults::Y);
    assert_eq!(MEMORY, 1 << 3);
    emergency.update(MEMORY, MEMORY);
    set(&mut emergency, Faults::WARM_UP);
    let messages: std::vec::Vec<_> = std::iter::from_fn(|| emergency.take(at(0))).collect();
    assert_eq!(
        messages,
        [
            [0x00, 0x90, 0x01, 0x01, 0, 0, 0, 0],
            [0x00, 0x50, 0x11, 0x09, 0, 0, 0, 0],
            [0x00, 0x00, 0x11, 0x08, 0, 0, 0, 0],
        ]
    );
    assert_eq!(emergency.count(), 2);
    assert_eq!(emergency.entry(1), 0x0911_5000);
    assert_eq!(emergency.entry(2), 0x0101_9000);
    assert_eq!(emergency.entry(3), 0);
    assert_eq!(emergency.register(), 0x11);
}

#[test]
fn full_history_drops_oldest_error() {
    let mut emergency = Emergency::<Deque<u32, 2>>::INITIAL;
    emergency.start(FAULTS);
    emergency.event(MEMORY);
    set(&mut emergency, Faults::X);
    emergency.event(MEMORY);
    assert_eq!(emergency.count(), 2);
    assert_eq!(
        (emergency.entry(1), emergency.entry(2)),
        (0x0911_5000, 0x0101_9000)
    );
    emergency.clear_history();
    assert_eq!(emergency.count(), 0);
    assert_eq!(emergency.active(), 1);
}

#[test]
fn inhibit_time_delays_next_message() {
    let mut emergency = Emergency::<Deque<u32, 2>>::INITIAL;
    emergency.start(FAULTS);
    emergency.configure(10);
    emergency.event(MEMORY);
    assert!(emergency.is_due(at(0)));
    assert!(emergency.take(at(0)).is_some());
    assert!(!emergency.is_due(at(999)));
    assert_eq!(emergency.deadline().time(), Some(at(1000)));
    assert!(emergency.is_due(at(1000)));
}
