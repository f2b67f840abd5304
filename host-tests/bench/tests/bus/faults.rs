//! Faults on the simulated wire and device: bus errors, bus-off, power loss, a slow node.

use bench::script::*;
use bench::{AdapterId, Bus, BusRate, DeviceId, Source};
use plumbline::can::BitRate;
use plumbline::node::{BusEvent, BusState};
use plumbline::time::Instant;

/// A bus with node 1 and an open adapter, after the boot-up frame.
fn booted() -> (Bus, DeviceId, AdapterId) {
    let mut bus = Bus::new(BusRate::Fixed(BitRate::K250));
    let device = bus.attach(device(&FIXED, 1));
    let adapter = bus.adapter();
    bus.open(adapter, None, false);
    bus.run_until(ms(1));
    assert_eq!(bus.take_received(adapter).len(), 1, "the boot-up frame");
    bus.take_log();
    (bus, device, adapter)
}

/// The time at which the node got this input.
fn reported_at(serial: u32, entry: Entry) -> Instant {
    let journal = journal(serial);
    let found = journal.iter().find(|(_, one)| *one == entry);
    found
        .unwrap_or_else(|| panic!("{entry:?} in {journal:?}"))
        .0
}

#[test]
fn thirty_two_corrupted_transmissions_cause_bus_off_and_recovery_takes_1408_bits() {
    let (mut bus, device, plc) = booted();
    bus.corrupt(32, Some(Source::Device(device)));
    bus.send(plc, frame(0x201, &[command::ECHO]));
    bus.run_until(ms(100));
    assert_eq!(
        states(1),
        [
            BusState::Warning,
            BusState::Passive,
            BusState::BusOff,
            BusState::Active
        ]
    );
    let errors = journal(1)
        .into_iter()
        .filter(|(_, entry)| *entry == Entry::Event(BusEvent::Error))
        .count();
    assert_eq!(errors, 32);
    let off = reported_at(1, Entry::Event(BusEvent::State(BusState::BusOff)));
    let back = reported_at(1, Entry::Event(BusEvent::State(BusState::Active)));
    // First come the six bits of the error flag of the other participant.
    assert_eq!((back - off).ticks(), (6 + 128 * 11) * 4);
    // Then the frame in the mailbox is sent: 56 bits.
    assert_eq!(bus.device(device).error_counters(), Some((0, 0)));
    let received = bus.take_received(plc);
    let reply = frame(0x301, &[command::ECHO]);
    assert_eq!(received, [(us(back.ticks() + 56 * 4), reply)]);
}

#[test]
fn thirty_one_corrupted_transmissions_do_not_cause_bus_off() {
    let (mut bus, device, plc) = booted();
    bus.corrupt(31, Some(Source::Device(device)));
    bus.send(plc, frame(0x201, &[command::ECHO]));
    bus.run_until(ms(100));
    assert_eq!(bus.device(device).error_counters(), Some((31 * 8 - 1, 0)));
    assert_eq!(bus.device(device).bus_state(), Some(BusState::Passive));
    assert_eq!(bus.take_received(plc).len(), 1);
}

#[test]
fn error_passive_sender_ignores_missing_acknowledge_and_suspends_transmission() {
    let (mut bus, device, plc) = booted();
    bus.corrupt(31, Some(Source::Device(device)));
    bus.send(plc, frame(0x201, &[command::ECHO]));
    bus.run_until(ms(100));
    bus.take_log();
    bus.send(plc, frame(0x201, &[command::BURST, 3]));
    bus.run_until(us(100_020));
    bus.drop_acknowledges(10);
    bus.run_until(ms(200));
    // Ten attempts without acknowledge do not count; the three successful frames count 1 each.
    assert_eq!(bus.device(device).error_counters(), Some((247 - 3, 0)));
    let log = bus.take_log();
    let frames: Vec<_> = log.iter().map(|logged| logged.frame).collect();
    let burst = [0, 1, 2].map(|number| frame(0x101, &[number]));
    assert_eq!(frames[1..], burst);
    // 55 bits for 101#01, 56 for 101#02, 3 of intermission, 8 of suspend transmission (ISO 11898-1).
    for (pair, bits) in log[1..].windows(2).zip([55, 56]) {
        let gap = (pair[1].at - pair[0].at).ticks();
        assert_eq!(gap, (bits + 3 + 8) * 4);
    }
}

#[test]
fn device_joining_during_frame_does_not_receive_it() {
    let (mut bus, one, plc) = booted();
    let (late, detecting) = (bus.adapter(), bus.attach(device(&DETECTING, 2)));
    bus.device_mut(detecting).power_off(ms(1));
    bus.run_until(ms(2));
    bus.send(plc, frame(0x201, &[command::ECHO]));
    bus.run_until(us(2000 + 20 * 4));
    bus.open(late, None, false);
    bus.power_cycle(one);
    bus.power_cycle(detecting);
    // 55 bits and the intermission.
    bus.run_until(us(2000 + 58 * 4 - 1));
    assert_eq!(bus.take_log().len(), 1);
    assert!(bus.take_received(late).is_empty());
    assert!(journal(1).is_empty());
    assert!(journal(2).is_empty(), "not even an error");
    bus.run_until(ms(10));
    assert_eq!(
        bus.take_received(late).len(),
        1,
        "the boot-up frame after it"
    );
}

#[test]
fn bus_off_device_neither_receives_nor_acknowledges() {
    let (mut bus, one, plc) = booted();
    let two = bus.attach(device(&FIXED, 2));
    bus.run_until(ms(2));
    bus.corrupt(32, Some(Source::Device(one)));
    bus.send(plc, frame(0x201, &[command::ECHO]));
    while bus.device(one).bus_state() != Some(BusState::BusOff) {
        let next = bus.next_event().unwrap();
        bus.run_until(next);
    }
    bus.take_log();
    bus.send(plc, frame(0x201, &[command::ECHO]));
    bus.send(plc, frame(0x202, &[command::ECHO]));
    let sent = bus.now();
    while bus.queued(plc) > 0 {
        let next = bus.next_event().unwrap();
        bus.run_until(next);
    }
    bus.close(plc);
    bus.run_until(us(sent.ticks() + 1400 * 4));
    let heard = journal(1)
        .iter()
        .filter(|(_, entry)| matches!(entry, Entry::Frame(_)))
        .count();
    assert_eq!(heard, 1);
    // Node 2 has seen 32 errors and two valid frames, and gets no acknowledge for its reply.
    assert_eq!(bus.device(two).error_counters(), Some((128, 30)));
}

#[test]
fn receivers_count_errors_and_successes() {
    let (mut bus, device, plc) = booted();
    bus.corrupt(3, Some(Source::Adapter(plc)));
    bus.send(plc, frame(0x7FF, &[]));
    bus.run_until(ms(10));
    // Three times 1, minus 1 for the valid frame.
    assert_eq!(bus.device(device).error_counters(), Some((0, 2)));
    assert_eq!(bus.take_log().len(), 1);
    bus.corrupt(200, None);
    bus.send(plc, frame(0x7FF, &[]));
    bus.run_until(ms(100));
    assert_eq!(states(1)[..2], [BusState::Warning, BusState::Passive]);
    // From above 127, one success sets the counter to between 119 and 127 (ISO 11898-1).
    let (_, receive) = bus.device(device).error_counters().unwrap();
    assert!((119..=127).contains(&receive), "{receive}");
}

#[test]
fn lost_acknowledge_repeats_frame() {
    let (mut bus, device, plc) = booted();
    bus.send(plc, frame(0x201, &[command::ECHO]));
    bus.run_until(us(1010));
    bus.drop_acknowledges(1);
    bus.run_until(ms(10));
    assert_eq!(bus.device(device).error_counters(), Some((7, 0)));
    let log = bus.take_log();
    assert_eq!(log.len(), 2);
    // The poll, the attempt up to the ACK slot with its error frame, the reply. The adapter has acknowledged; it sees the error
    // flag one bit later and ends its own one bit later.
    let bits = 55 + 3 + (56 - 8 + 14 + 1) + 3 + 56;
    assert_eq!(log[1].at, us(1000 + bits * 4));
}

#[test]
fn noise_destroys_frame_or_causes_error_on_idle_wire() {
    let (mut bus, device, plc) = booted();
    bus.noise(ms(2));
    bus.run_until(ms(3));
    assert_eq!(bus.device(device).error_counters(), Some((0, 1)));
    // The sixth dominant bit is a stuff error.
    assert_eq!(
        journal(1),
        [(us(2000 + 6 * 4), Entry::Event(BusEvent::Error))]
    );
    // During a frame: the sender repeats it after the disturbance, at most two error flags, a delimiter and the intermission.
    bus.send(plc, frame(0x201, &[command::ECHO]));
    bus.noise(us(3100));
    bus.run_until(us(3100 + (6 + 6 + 6 + 8 + 3 + 55) * 4));
    assert_eq!(bus.take_log().len(), 1);
    assert_eq!(bus.device(device).error_counters(), Some((0, 1)));
}

#[test]
fn full_receive_queue_overruns() {
    let (mut bus, _, plc) = booted();
    bus.send(plc, frame(0x201, &[command::PAUSE, 100]));
    for number in 0..40 {
        bus.send(plc, frame(0x201, &[command::ECHO, number]));
    }
    bus.run_until(ms(500));
    let overruns = journal(1)
        .iter()
        .filter(|(_, entry)| *entry == Entry::Event(BusEvent::Overrun))
        .count();
    assert_eq!(overruns, 8);
    let replies = bus.take_received(plc);
    assert_eq!(replies.len(), 32);
    assert_eq!(replies[31].1, frame(0x301, &[command::ECHO, 31]));
}

#[test]
fn samples_come_every_five_milliseconds() {
    let (mut bus, device, _) = booted();
    bus.run_until(ms(1000));
    let expected: Vec<Instant> = (0..=200).map(|count| ms(5 * count)).collect();
    assert_eq!(samples(1), expected);
    bus.power_cycle(device);
    bus.run_until(ms(1001));
    assert_eq!(samples(1).last(), Some(&ms(1000)));
}

#[test]
fn save_takes_flash_time_and_survives_restart() {
    let (mut bus, device, plc) = booted();
    bus.send(plc, frame(0x201, &[command::SAVE, 7]));
    bus.send(plc, frame(0x201, &[command::RESTART]));
    bus.run_until(ms(100));
    let asked = reported_at(1, Entry::Frame(frame(0x201, &[command::SAVE, 7])));
    let stored = reported_at(1, Entry::Stored(Ok(())));
    // 10 bytes of header, 40 of payload, 2 of padding, 4 of CRC, at 52 us for a half-word.
    assert_eq!((stored - asked).ticks(), 28 * 52);
    assert_eq!(bus.device(device).boots(), 2);
    let received: Vec<_> = bus.take_received(plc).into_iter().map(|(_, f)| f).collect();
    assert!(received.contains(&frame(0x301, &[0])), "{received:?}");
    assert!(
        received.contains(&frame(0x301, &[])),
        "the reply is sent before the restart"
    );
    assert_eq!(received.last(), Some(&frame(0x101, &[7, 0])));
}

#[test]
fn restart_wait_is_limited() {
    let (mut bus, device, plc) = booted();
    bus.send(plc, frame(0x201, &[command::RESTART]));
    while bus.queued(plc) > 0 {
        let next = bus.next_event().unwrap();
        bus.run_until(next);
    }
    bus.close(plc);
    bus.run_until(ms(100));
    assert_eq!(bus.device(device).boots(), 1);
    bus.run_until(ms(110));
    assert_eq!(bus.device(device).boots(), 2);
}

#[test]
fn faulty_memory_is_reported() {
    let (mut bus, device, plc) = booted();
    bus.device_mut(device).flash().fail_writes(true);
    bus.send(plc, frame(0x201, &[command::SAVE, 7]));
    bus.run_until(ms(100));
    let (_, reply) = bus.take_received(plc)[0];
    assert_eq!(reply, frame(0x301, &[0xFF]));
}

#[test]
fn power_cut_during_save_switches_device_off() {
    let (mut bus, device, plc) = booted();
    bus.device_mut(device).flash().cut_in_byte_after(20);
    bus.send(plc, frame(0x201, &[command::SAVE, 7]));
    bus.run_until(ms(100));
    assert!(!bus.device(device).is_on());
    assert_eq!(bus.device(device).bus_state(), None);
    bus.power_cycle(device);
    bus.run_until(ms(200));
    assert_eq!(
        bus.take_received(plc).last().unwrap().1,
        frame(0x101, &[0xFF, 1])
    );
    bus.send(plc, frame(0x201, &[command::SAVE, 8]));
    bus.run_until(ms(300));
    bus.power_cycle(device);
    bus.run_until(ms(400));
    assert_eq!(
        bus.take_received(plc).last().unwrap().1,
        frame(0x101, &[8, 0])
    );
}

#[test]
fn power_loss_during_frame_aborts_frame() {
    let (mut bus, one, plc) = booted();
    let two = bus.attach(device(&FIXED, 2));
    bus.run_until(ms(2));
    bus.take_log();
    bus.send(plc, frame(0x201, &[command::ECHO]));
    bus.run_until(us(2000 + (55 + 3 + 20) * 4));
    bus.device_mut(one).power_off(us(2000 + (55 + 3 + 20) * 4));
    bus.run_until(ms(10));
    let frames: Vec<_> = bus.take_log().iter().map(|logged| logged.frame).collect();
    assert_eq!(frames, [frame(0x201, &[command::ECHO])]);
    assert_eq!(bus.device(two).error_counters(), Some((0, 1)));
    assert!(!bus.device(one).leds().run);
}

#[test]
#[should_panic(expected = "does not become idle")]
fn endless_poll_panics() {
    let mut bus = Bus::new(BusRate::Follow);
    bus.attach(device(&ENDLESS, 1));
    bus.run_until(ms(1));
}
