//! Adapters that join a bus on which a sensor repeats a frame without acknowledge, and adapters that leave.

use bench::script::*;
use bench::{AdapterId, Bus, BusRate, DeviceId, Source};
use plumbline::can::{BitRate, Frame};
use plumbline::node::BusState;
use plumbline::time::{Duration, after};

/// An attempt to send the boot-up message `101#FF00` at 250 kbit/s, in microseconds: 57 bits up to the ACK slot, 14 of error frame,
/// 3 of intermission and 8 of suspend transmission.
const ATTEMPT: u64 = (57 + 14 + 3 + 8) * 4;

const AT_250K: BusRate = BusRate::Fixed(BitRate::K250);

/// A bus with node 1 that repeats its boot-up message; it is error passive.
fn unacknowledged(rate: BusRate) -> (Bus, DeviceId) {
    let mut bus = Bus::new(rate);
    let device = bus.attach(device(&FIXED, 1));
    bus.run_until(ms(20));
    assert_eq!(bus.device(device).error_counters(), Some((128, 0)));
    (bus, device)
}

/// Opens an adapter and sends a request at the same time, this many microseconds after 20 ms. Returns the frames that the adapter
/// has received 5 ms later.
fn open_with_request(bus: &mut Bus, phase: u64) -> (AdapterId, Vec<Frame>) {
    bus.run_until(us(20_000 + phase));
    let adapter = bus.adapter();
    bus.open(adapter, None, false);
    bus.send(adapter, frame(0x201, &[command::ECHO, 7]));
    bus.run_until(ms(25));
    let received = bus.take_received(adapter).into_iter();
    (adapter, received.map(|(_, frame)| frame).collect())
}

/// The boot-up message and the reply to the request.
fn expected() -> [Frame; 2] {
    [frame(0x101, &[0xFF, 0]), frame(0x301, &[command::ECHO, 7])]
}

#[test]
fn request_sent_while_adapter_opens_is_answered() {
    for rate in [BusRate::Follow, AT_250K] {
        for phase in 0..ATTEMPT {
            let (mut bus, device) = unacknowledged(rate);
            let (adapter, received) = open_with_request(&mut bus, phase);
            assert_eq!(received, expected(), "{rate:?}, {phase} us");
            // Two frames have been acknowledged, and the adapter has caused no error.
            let counters = bus.device(device).error_counters();
            assert_eq!(counters, Some((126, 0)), "{rate:?}, {phase} us");
            assert_eq!(bus.device(device).bus_state(), Some(BusState::Warning));
            assert_eq!(bus.disturbed(Source::Adapter(adapter)), 0);
        }
    }
}

/// On a real wire the request may start within the error frame of the sensor, which does not receive it then. The assistant must
/// not acknowledge it.
#[test]
fn request_that_sensor_does_not_receive_is_repeated_on_real_wire() {
    let mut disturbed = 0;
    for phase in 0..ATTEMPT {
        let (mut bus, _) = unacknowledged(BusRate::Wire);
        bus.assist(true);
        let (adapter, received) = open_with_request(&mut bus, phase);
        assert_eq!(received, expected(), "{phase} us");
        disturbed += bus.disturbed(Source::Adapter(adapter));
    }
    assert!(disturbed > 0, "no request started within an error frame");
}

/// The bus skips attempts that are all alike, but not in steps that are shorter than an attempt.
#[test]
fn skipped_attempts_are_like_computed_ones() {
    for end in (60_000..60_000 + 2 * ATTEMPT).step_by(7) {
        let [skipped, computed] = [end, 50].map(|step| {
            let mut bus = Bus::new(AT_250K);
            let device = bus.attach(device(&FIXED, 1));
            while bus.now() < us(end) {
                let next = after(bus.now(), Duration::from_ticks(step));
                bus.run_until(next.min(us(end)));
            }
            let protocol = bus.device(device).protocol().expect("it is on");
            let start = protocol.frame_start();
            let disturbed = bus.disturbed(Source::Device(device));
            let adapter = bus.adapter();
            bus.open(adapter, None, false);
            bus.run_until(us(end + 2000));
            let counters = bus.device(device).error_counters();
            (start, disturbed, bus.take_received(adapter), counters)
        });
        assert_eq!(skipped, computed, "{end} us");
        let (_, disturbed, received, _) = skipped;
        assert_eq!(received.len(), 1, "{end} us");
        assert!(disturbed > 50_000 / ATTEMPT, "{disturbed}");
    }
}
