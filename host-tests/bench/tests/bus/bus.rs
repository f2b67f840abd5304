//! The simulated wire: frame times, arbitration, acknowledge, a bus that follows its sensor.

use bench::script::{self, *};
use bench::{Bus, BusRate, Source};
use can_wire::frame_length::frame_bits;
use plumbline::can::{BitRate, Frame, extended, standard};
use plumbline::node::{BusEvent, BusMode, BusState};

const AT_250K: BusRate = BusRate::Fixed(BitRate::K250);

/// `101#FF00`, the boot-up frame of node 1 with a blank memory, in bits without intermission.
const BOOT_UP_BITS: u64 = 65;

/// The recessive bits that a controller waits for when it joins.
const JOIN_BITS: u64 = 11;

/// A bus with node 1 and an open adapter, after the boot-up frame.
fn booted(rate: BusRate) -> (Bus, bench::DeviceId, bench::AdapterId) {
    let mut bus = Bus::new(rate);
    let device = bus.attach(device(&FIXED, 1));
    let adapter = bus.adapter();
    bus.open(adapter, None, false);
    bus.run_until(ms(1));
    assert_eq!(bus.take_received(adapter).len(), 1, "the boot-up frame");
    bus.take_log();
    (bus, device, adapter)
}

fn frames(bus: &mut Bus) -> Vec<Frame> {
    bus.take_log().iter().map(|logged| logged.frame).collect()
}

#[test]
fn thousand_frames_take_exact_bit_times_at_each_rate() {
    for rate in BitRate::ALL {
        let mut bus = Bus::new(BusRate::Fixed(rate));
        let (sender, receiver) = (bus.adapter(), bus.adapter());
        bus.open(sender, Some(rate), false);
        bus.open(receiver, None, true);
        // They join after 11 recessive bits.
        bus.run_until(us(2007));
        // 47 bits, and 3 of intermission in between.
        for _ in 0..1000 {
            bus.send(sender, Frame::remote(standard(0x7FF), 4).unwrap());
        }
        bus.run_until(ms(10_000));
        let received = bus.take_received(receiver);
        assert_eq!(received.len(), 1000);
        let bits = 1000 * 50 - 3;
        let end = 2007 + u64::div_ceil(bits * 1_000_000, rate.bits_per_second().into());
        assert_eq!(received[999].0, us(end), "{rate:?}");
        let first = 2007 + u64::div_ceil(47 * 1_000_000, rate.bits_per_second().into());
        assert_eq!(received[0].0, us(first), "{rate:?}");
        assert!(bus.take_received(sender).is_empty(), "its own frames");
    }
}

#[test]
fn lowest_identifier_goes_first() {
    let mut bus = Bus::new(AT_250K);
    let data = |id| Frame::data(id, &[1]).unwrap();
    let waiting = [
        data(standard(0x301)),
        data(extended(0x300 << 18)),
        Frame::remote(standard(0x300), 1).unwrap(),
        data(standard(0x300)),
        Frame::remote(extended(0x300 << 18), 0).unwrap(),
        data(standard(0x2FF)),
    ];
    for frame in waiting {
        let adapter = bus.adapter();
        bus.open(adapter, None, false);
        bus.send(adapter, frame);
    }
    bus.run_until(ms(10));
    let order = [5, 3, 2, 1, 4, 0].map(|index: usize| waiting[index]);
    assert_eq!(frames(&mut bus), order);
}

#[test]
fn lower_identifier_waits_for_end_of_current_frame() {
    let mut bus = Bus::new(AT_250K);
    let (a, b, c) = (bus.adapter(), bus.adapter(), bus.adapter());
    for adapter in [a, b, c] {
        bus.open(adapter, None, false);
    }
    bus.run_until(us(100));
    bus.send(a, frame(0x7FF, &[]));
    bus.run_until(us(120));
    bus.send(b, frame(0x300, &[]));
    bus.run_until(us(140));
    bus.send(c, frame(0x080, &[]));
    bus.run_until(ms(10));
    let ids = [0x7FF, 0x080, 0x300].map(|id| frame(id, &[]));
    assert_eq!(frames(&mut bus), ids);
}

#[test]
fn two_adapters_flooding_the_bus_both_get_replies() {
    let (mut bus, _, plc) = booted(AT_250K);
    let tester = bus.adapter();
    bus.open(tester, None, false);
    for _ in 0..500 {
        bus.send(plc, frame(0x201, &[command::ECHO, 1]));
        bus.send(tester, frame(0x201, &[command::ECHO, 2]));
    }
    bus.run_until(ms(2000));
    let log = bus.take_log();
    assert_eq!(log.len(), 2000);
    for byte in [1, 2] {
        let reply = frame(0x301, &[command::ECHO, byte]);
        assert_eq!(
            log.iter().filter(|logged| logged.frame == reply).count(),
            500
        );
    }
}

#[test]
fn equal_frames_of_two_adapters_are_sent_twice_but_merge_on_real_wire() {
    for (rate, frames) in [(AT_250K, 2), (BusRate::Wire, 1)] {
        let mut bus = Bus::new(rate);
        let all = [bus.adapter(), bus.adapter(), bus.adapter()];
        for adapter in all {
            bus.open(adapter, None, false);
        }
        bus.send(all[0], frame(0x300, &[0]));
        bus.send(all[1], frame(0x300, &[0]));
        bus.run_until(ms(10));
        assert_eq!(bus.take_received(all[2]).len(), frames, "{rate:?}");
        assert_eq!(bus.queued(all[0]) + bus.queued(all[1]), 0);
    }
}

#[test]
fn thousand_queued_polls_get_thousand_replies() {
    let (mut bus, _, plc) = booted(AT_250K);
    // The poll has a higher priority than the reply.
    for _ in 0..1000 {
        bus.send(plc, frame(0x201, &[command::ECHO]));
    }
    bus.run_until(ms(2000));
    let log = bus.take_log();
    assert_eq!(log.len(), 2000);
    for pair in log.chunks(2) {
        assert_eq!(pair[0].frame, frame(0x201, &[command::ECHO]));
        assert_eq!(pair[0].source, Source::Adapter(plc));
        assert_eq!(pair[1].frame, frame(0x301, &[command::ECHO]));
    }
    // 55 and 56 bits with 3 bits after each, without a gap, from 1 ms on.
    assert_eq!(log[1999].at, us(1000 + (1000 * (55 + 56 + 6) - 3) * 4));
}

#[test]
fn unacknowledged_frame_repeats_until_adapter_opens() {
    let mut bus = Bus::new(AT_250K);
    let device = bus.attach(device(&FIXED, 1));
    let (listener, tester) = (bus.adapter(), bus.adapter());
    bus.open(listener, None, true);
    bus.run_until(ms(1000));
    assert!(bus.take_log().is_empty());
    // Sixteen attempts of 8 each, then the counter does not change (ISO 11898-1: error passive, no dominant bit in the flag).
    assert_eq!(bus.device(device).error_counters(), Some((128, 0)));
    assert_eq!(states(1), [BusState::Warning, BusState::Passive]);
    assert!(bus.device(device).leds().error);
    // An attempt ends with the ACK slot, 8 bits before the end of the frame; then 14 bits of error frame and the intermission.
    let attempt = BOOT_UP_BITS - 8 + 14 + 3;
    let passive = journal(1)
        .into_iter()
        .find(|(_, entry)| *entry == Entry::Event(BusEvent::State(BusState::Passive)))
        .unwrap();
    assert_eq!(
        passive.0,
        us((JOIN_BITS + 15 * attempt + BOOT_UP_BITS - 8) * 4)
    );

    bus.open(tester, None, false);
    bus.run_until(ms(2000));
    let received = bus.take_received(tester);
    let (at, boot_up) = received[0];
    assert_eq!((boot_up, received.len()), (frame(0x101, &[0xFF, 0]), 1));
    // The adapter joins during an attempt; the next one, after suspend transmission, succeeds.
    let latest = 1_000_000 + (attempt + 8 + BOOT_UP_BITS) * 4;
    assert!((1_000_000..latest).contains(&at.ticks()), "{at}");
    // In listen-only mode every attempt looks valid once the error flags of the sender are passive.
    let heard = bus.take_received(listener);
    assert!(heard[0].0 > passive.0, "{heard:?}");
    assert_eq!(heard.last(), received.last());
    assert_eq!(bus.device(device).error_counters(), Some((127, 0)));
    assert_eq!(states(1)[2..], [BusState::Warning]);
}

#[test]
fn two_devices_acknowledge_each_other() {
    let mut bus = Bus::new(AT_250K);
    let one = bus.attach(device(&FIXED, 1));
    let two = bus.attach(device(&FIXED, 2));
    bus.run_until(ms(100));
    let boot_ups = [frame(0x101, &[0xFF, 0]), frame(0x102, &[0xFF, 0])];
    assert_eq!(frames(&mut bus), boot_ups);
    for id in [one, two] {
        assert_eq!(bus.device(id).error_counters(), Some((0, 0)));
    }
    let plc = bus.adapter();
    bus.open(plc, None, false);
    bus.send(plc, frame(0x202, &[command::ECHO, 2]));
    bus.send(plc, frame(0x201, &[command::ECHO, 1]));
    bus.run_until(ms(200));
    let replies: Vec<Frame> = bus.take_received(plc).into_iter().map(|(_, f)| f).collect();
    assert_eq!(
        replies,
        [
            frame(0x302, &[command::ECHO, 2]),
            frame(0x301, &[command::ECHO, 1])
        ]
    );
    // The acceptance filters reject the frames of the other device.
    let heard = |serial| {
        journal(serial)
            .into_iter()
            .filter(|(_, entry)| matches!(entry, Entry::Frame(_)))
            .count()
    };
    assert_eq!((heard(1), heard(2)), (1, 1));
}

#[test]
fn following_bus_first_frame_sets_250_kbit() {
    let mut bus = Bus::new(BusRate::Follow);
    let device = bus.attach(device(&DETECTING, 1));
    let client = bus.adapter();
    bus.open(client, Some(BitRate::M1), false);
    bus.run_until(ms(50));
    assert_eq!(bus.device(device).mode(), Some(BusMode::Listen));
    bus.send(client, frame(0x7FF, &[]));
    bus.run_until(ms(100));
    assert_eq!(bus.device(device).mode(), Some(BusMode::Normal));
    assert_eq!(bus.device(device).rate(), Some(BitRate::K250));
    assert_eq!(bus.rate(), BitRate::K250);
    assert_eq!(
        frames(&mut bus),
        [frame(0x7FF, &[]), frame(0x101, &[0xFF, 0])]
    );
}

#[test]
fn following_bus_takes_rate_of_device() {
    let (mut bus, device, client) = booted(BusRate::Follow);
    let index = BitRate::ALL.iter().position(|rate| *rate == BitRate::K20);
    bus.send(client, frame(0x201, &[command::RATE, index.unwrap() as u8]));
    bus.run_until(ms(10));
    assert_eq!(bus.device(device).rate(), Some(BitRate::K20));
    bus.send(client, frame(0x201, &[command::ECHO]));
    bus.run_until(ms(20));
    let log = bus.take_log();
    assert_eq!(log[2].frame, frame(0x301, &[command::ECHO]));
    assert_eq!(log[2].at, us(10_000 + (55 + 3 + 56) * 50));
}

#[test]
fn adapter_at_other_rate_is_not_connected() {
    let (mut bus, device, good) = booted(AT_250K);
    let detecting = bus.attach(script::device(&DETECTING, 2));
    let wrong = bus.adapter();
    bus.open(wrong, Some(BitRate::K500), false);
    bus.run_until(ms(2));
    bus.send(wrong, frame(0x201, &[command::ECHO]));
    bus.run_until(ms(10));
    assert!(bus.take_log().is_empty());
    assert!(bus.take_received(good).is_empty());
    assert_eq!(journal(2), []);
    assert_eq!(bus.device(detecting).rate(), Some(BitRate::K10));
    // It neither receives nor acknowledges.
    bus.send(good, frame(0x201, &[command::ECHO]));
    bus.run_until(ms(20));
    assert_eq!(bus.take_received(good).len(), 1);
    assert!(bus.take_received(wrong).is_empty());
    // With the correct adapter closed and the detecting device off, there is no acknowledge.
    bus.take_log();
    bus.close(good);
    let now = bus.now();
    bus.device_mut(detecting).power_off(now);
    bus.power_cycle(device);
    bus.run_until(ms(30));
    assert!(bus.take_log().is_empty());
}

#[test]
fn closed_adapter_drops_queued_and_keeps_received_frames() {
    let (mut bus, _, plc) = booted(AT_250K);
    bus.send(plc, frame(0x201, &[command::ECHO]));
    bus.run_until(ms(10));
    bus.send(plc, frame(0x201, &[command::ECHO]));
    bus.close(plc);
    assert_eq!(bus.queued(plc), 0);
    bus.send(plc, frame(0x201, &[command::ECHO]));
    bus.run_until(ms(20));
    assert_eq!(bus.take_received(plc).len(), 1);
    bus.remove(plc);
    bus.send(plc, frame(0x201, &[command::ECHO]));
    bus.run_until(ms(30));
    assert!(bus.take_received(plc).is_empty());
    assert_eq!(bus.take_log().len(), 2);
}

#[test]
fn run_until_stops_at_requested_time() {
    let mut bus = Bus::new(AT_250K);
    assert_eq!(bus.next_event(), None);
    bus.run_until(us(123));
    assert_eq!(bus.now(), us(123));
    let adapter = bus.adapter();
    bus.open(adapter, None, false);
    bus.run_until(us(200));
    bus.send(adapter, frame(0x7FF, &[]));
    assert_eq!(bus.next_event(), Some(us(200)));
    bus.run_until(us(200));
    let bits = u64::from(frame_bits(&frame(0x7FF, &[])));
    let end = us(200 + bits * 4);
    bus.run_until(us(end.ticks() - 1));
    assert!(bus.take_log().is_empty());
    bus.run_until(end);
    let logged = bus.take_log()[0];
    assert_eq!((logged.start, logged.at), (200_000_000, end));
    // After the intermission there is no further event.
    bus.run_until(ms(1));
    assert_eq!(bus.next_event(), None);
}

#[test]
fn opened_adapter_receives_all_later_frames() {
    let mut bus = Bus::new(AT_250K);
    let (first, second) = (bus.adapter(), bus.adapter());
    bus.open(first, None, false);
    bus.run_until(ms(1));
    bus.open(second, None, false);
    bus.send(first, frame(0x7FF, &[1]));
    bus.run_until(ms(2));
    let received = bus.take_received(second);
    assert_eq!(received.len(), 1);
    assert_eq!(received[0].1, frame(0x7FF, &[1]));
}
