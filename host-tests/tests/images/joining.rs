//! An adapter that opens while the image repeats a frame without acknowledge.

use crate::rig::*;
use bench::{Bus, BusRate, Source};
use plumbline::node::BusState;
use plumbline::time::{Duration, Instant, after};
use stm32_sim::Microcontroller;

/// An attempt of the JN2101 to send its heartbeat `70A#7F` at 125 kbit/s, in microseconds: the frame up to the ACK slot, error
/// frame, intermission and suspend transmission.
const ATTEMPT: u64 = (49 + 14 + 3 + 8) * 8;

#[test]
fn request_sent_while_adapter_opens_is_answered() {
    let mut bus = Bus::new(BusRate::Follow);
    let sensor = bus.attach(microcontroller("jn2101", blank()));
    // The boot-up message waits; later the heartbeat does.
    bus.run_until(Instant::from_ticks(300_000));
    let heartbeat = data(0x60A, &[0x2B, 0x17, 0x10, 0, 10, 0, 0, 0]);
    let request = data(0x60A, &[0x40, 0, 0x10, 0, 0, 0, 0, 0]);
    let reply = data(0x58A, &[0x43, 0, 0x10, 0, 0x9A, 0x01, 0x04, 0]);
    for phase in (0..ATTEMPT).step_by(16) {
        let pause = Duration::from_ticks(30_000 + phase);
        bus.run_until(after(bus.now(), pause));
        assert_eq!(bus.device(sensor).bus_state(), Some(BusState::Passive));
        let adapter = bus.adapter();
        bus.open(adapter, None, false);
        bus.send(adapter, request);
        bus.send(adapter, heartbeat);
        bus.run_until(after(bus.now(), ms(20)));
        let received = bus.take_received(adapter);
        let is_reply = |(_, frame): &&(_, _)| *frame == reply;
        assert_eq!(
            received.iter().filter(is_reply).count(),
            1,
            "{phase} us: {received:?}"
        );
        assert_eq!(bus.disturbed(Source::Adapter(adapter)), 0);
        // The heartbeat goes on, so the error counter soon falls below the limit.
        bus.run_until(after(bus.now(), ms(80)));
        assert_eq!(bus.device(sensor).bus_state(), Some(BusState::Warning));
        bus.remove(adapter);
    }
    let chip = Microcontroller::of(bus.device(sensor)).expect("a simulated microcontroller");
    check(chip);
}
