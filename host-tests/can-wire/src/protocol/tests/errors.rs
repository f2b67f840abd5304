//! Errors and fault confinement: the code of each error, its effect on the counters, and the states that follow.

use super::*;
use crate::frame_length::frame_bits;

/// Its header has no stuff bit, so its bits are easy to count. SOF, 11 identifier, RTR, IDE, r0, 4 DLC, 64 data, 15 CRC.
fn plain() -> Frame {
    data(0x555, &[0x55; 8])
}

/// The first bit after the CRC sequence.
fn crc_delimiter() -> u64 {
    u64::from(frame_bits(&plain())) - 10
}

/// Sends [`plain`] from controller 0 to controller 1 with the wire forced for some bits of the first attempt.
fn disturbed(first: u64, count: u64, dominant: bool) -> Wire {
    let mut wire = Wire::joined(2);
    wire.send(0, plain());
    wire.force(first, count, dominant);
    wire.run(300 * BIT);
    wire
}

#[test]
fn each_kind_of_error_has_its_code() {
    let stuffed = |index: u64| crc_delimiter() - index;
    let cases = [
        // A dominant data bit that is recessive on the wire: the transmitter sees a bit error.
        (19, 1, false, Some((ErrorCode::BitDominant, true)), None),
        // A recessive data bit that is dominant.
        (20, 1, true, Some((ErrorCode::BitRecessive, true)), None),
        // The CRC delimiter.
        (
            stuffed(0),
            1,
            true,
            Some((ErrorCode::BitRecessive, true)),
            Some((ErrorCode::Form, false)),
        ),
        // The ACK slot.
        (
            stuffed(0) + 1,
            1,
            false,
            Some((ErrorCode::Acknowledgment, true)),
            Some((ErrorCode::BitDominant, false)),
        ),
        // The ACK delimiter.
        (
            stuffed(0) + 2,
            1,
            true,
            Some((ErrorCode::BitRecessive, true)),
            Some((ErrorCode::Form, false)),
        ),
        // The first bit of the end of frame.
        (
            stuffed(0) + 3,
            1,
            true,
            Some((ErrorCode::BitRecessive, true)),
            Some((ErrorCode::Form, false)),
        ),
    ];
    for (first, count, dominant, transmitter, receiver) in cases {
        let wire = disturbed(first, count, dominant);
        assert_eq!(wire.error(0), transmitter, "bit {first}");
        if receiver.is_some() {
            assert_eq!(wire.error(1), receiver, "bit {first}");
        }
        // One error, one repetition, then success: 8 and 1 for the error, minus 1 each for the success.
        assert_eq!(wire.count(0, Event::Transmitted), 1, "bit {first}");
        assert_eq!(wire.received(1), [plain()], "bit {first}");
        assert_eq!(wire.counters(0), (7, 0), "bit {first}");
        assert_eq!(wire.counters(1).0, 0, "bit {first}");
    }
}

#[test]
fn error_flag_is_stuff_error_for_other_controllers() {
    let mut wire = disturbed(19, 1, false);
    assert_eq!(wire.error(1), Some((ErrorCode::Stuff, false)));
    // The receiver detects the error in the transmitter's flag and sends its own flag, so that the wire is dominant for longer
    // than six bits. The transmitter waits for its end. The receiver's flag ends last; it counts 1, then minus 1 for the success.
    assert_eq!(wire.counters(1), (0, 0));
    wire.forget();
    wire.run(100 * BIT);
    assert_eq!(wire.next(), None);
}

#[test]
fn receiver_sends_crc_error_flag_after_ack_delimiter() {
    // The disturbed bits must be those that the transmitter sends, so the test sends a frame with a wrong CRC bit by bit.
    let mut wire = Wire::joined(1);
    let mut bits = wire_bits(&plain());
    let last = bits.len() - 1;
    // The last CRC bit, where the change makes no run of six.
    bits[last] = !bits[last];
    play(&mut wire, &bits);
    let start = wire.now;
    wire.run((bits.len() as u64 + 30) * BIT);
    assert_eq!(wire.error(0), Some((ErrorCode::Crc, false)));
    assert_eq!(wire.counters(0), (0, 1));
    // No acknowledge; the flag begins at the first bit of the end of frame.
    let after = start + bits.len() as u64 * BIT;
    assert_eq!(wire.bits(after, 12), "111000000111");
}

/// The bits of a frame from SOF to CRC on the wire; true is recessive.
fn wire_bits(frame: &Frame) -> Vec<bool> {
    let (outgoing, mut seen) = (Outgoing::new(frame), Incoming::default());
    let mut bits = Vec::new();
    while !seen.is_complete() {
        let bit = outgoing.next(&seen);
        seen.push(bit).unwrap();
        bits.push(bit);
    }
    bits
}

fn play(wire: &mut Wire, bits: &[bool]) {
    for (index, bit) in bits.iter().enumerate() {
        if !bit {
            wire.force(index as u64, 1, true);
        }
    }
}

#[test]
fn unacknowledged_frame_repeats_without_limit_while_error_passive() {
    let mut wire = Wire::joined(1);
    wire.send(0, plain());
    // Up to the ACK slot, error flag 6, delimiter 8, intermission 3.
    let attempt = crc_delimiter() + 2 + 6 + 8 + 3;
    wire.run(16 * attempt * BIT);
    assert_eq!(wire.counters(0), (128, 0));
    assert_eq!(wire.count(0, Event::Started), 16);
    wire.run(100 * (attempt + 8) * BIT);
    // A missing acknowledge does not count while error passive; each attempt waits 8 bits longer.
    assert_eq!(wire.counters(0), (128, 0));
    assert_eq!(wire.count(0, Event::Started), 16 + 100);
    assert_eq!(wire.state(0), BusState::Passive);
}

#[test]
fn dominant_bit_in_passive_flag_counts_missing_acknowledge() {
    let mut wire = Wire::joined(1);
    wire.send(0, plain());
    let attempt = crc_delimiter() + 2 + 6 + 8 + 3;
    wire.run(16 * attempt * BIT);
    // The next attempt follows suspend transmission; a dominant bit in the passive flag.
    wire.force(8 + crc_delimiter() + 2 + 2, 1, true);
    wire.run((attempt + 8) * BIT);
    assert_eq!(wire.counters(0), (136, 0));
}

#[test]
fn thirty_two_failed_transmissions_cause_bus_off_and_recovery_takes_128_times_11_bits() {
    let mut wire = Wire::joined(2);
    wire.send(0, plain());
    // The second data bit, which is recessive, is disturbed in each attempt.
    let mut tries = 0;
    while wire.state(0) != BusState::BusOff {
        let before = wire.count(0, Event::Started);
        while wire.count(0, Event::Started) == before {
            let next = wire.next().unwrap();
            wire.run(next + 1 - wire.now);
        }
        tries += 1;
        wire.forced.clear();
        wire.force(20, 1, true);
        wire.run(22 * BIT);
    }
    assert_eq!(tries, 32);
    assert_eq!(wire.counters(0).0, 255);
    // It does not recover without a request.
    wire.run(3000 * BIT);
    assert_eq!(wire.count(0, Event::Recovered), 0);
    assert_eq!(wire.next(), None, "no event is due");
    let asked = wire.now;
    wire.stations[0].protocol.recover(asked);
    wire.run(1410 * BIT);
    let (at, _) = *wire.stations[0]
        .events
        .iter()
        .find(|(_, event)| *event == Event::Recovered)
        .unwrap();
    let bits = (at - asked).div_ceil(BIT);
    assert_eq!(bits, 128 * 11);
    wire.run(200 * BIT);
    assert_eq!(wire.counters(0), (0, 0));
    assert_eq!(
        wire.count(0, Event::Transmitted),
        1,
        "the frame is still queued"
    );
}

#[test]
fn dominant_bit_restarts_count_of_eleven_recessive_bits() {
    let mut wire = Wire::joined(1);
    let protocol = &mut wire.stations[0].protocol;
    protocol.confinement = bus_off();
    let now = wire.now;
    protocol.join(now, BitTiming::of(BitRate::K250), false);
    protocol.recover(now);
    // In the fifth bit.
    wire.force(4, 1, true);
    wire.run(2000 * BIT);
    let (at, event) = wire.stations[0].events[0];
    assert_eq!(event, Event::Recovered);
    assert_eq!((at - now).div_ceil(BIT), 5 + 128 * 11);
}

fn bus_off() -> Confinement {
    let mut confinement = Confinement::default();
    (0..32).for_each(|_| confinement.error(confinement::Role::Transmitter));
    assert!(confinement.is_bus_off());
    confinement
}

#[test]
fn error_passive_transmitter_suspends_transmission_for_eight_bits() {
    let mut wire = Wire::joined(2);
    // So far above the limit that a success does not make it error active again.
    for _ in 0..20 {
        let confinement = &mut wire.stations[0].protocol.confinement;
        confinement.error(confinement::Role::Transmitter);
    }
    assert_eq!(wire.state(0), BusState::Passive);
    wire.send(0, plain());
    wire.send(0, plain());
    let start = wire.now;
    wire.run(300 * BIT);
    let starts: Vec<_> = wire.stations[0]
        .events
        .iter()
        .filter(|(_, event)| *event == Event::Started)
        .collect();
    let gap = starts[1].0 - starts[0].0;
    assert_eq!(starts[0].0, start);
    assert_eq!(gap, (u64::from(frame_bits(&plain())) + 3 + 8) * BIT);
}

#[test]
fn error_passive_receiver_destroys_no_frame() {
    let mut wire = Wire::joined(3);
    for _ in 0..128 {
        wire.stations[2]
            .protocol
            .confinement
            .error(confinement::Role::Receiver);
    }
    assert_eq!(wire.state(2), BusState::Passive);
    // Only the third controller sees errors: the test sets it to another bit rate.
    let timing = BitTiming::of(BitRate::K125);
    let now = wire.now;
    wire.stations[2].protocol.join(now, timing, false);
    wire.run(100 * BIT);
    wire.forget();
    wire.send(0, plain());
    wire.run(200 * BIT);
    assert!(wire.error(2).is_some());
    assert_eq!(wire.received(1), [plain()]);
    assert_eq!(wire.error(1), None);
    assert_eq!(wire.counters(0), (0, 0));
}

#[test]
fn success_sets_receive_counter_above_127_below_128() {
    let mut wire = Wire::joined(2);
    for _ in 0..200 {
        wire.stations[1]
            .protocol
            .confinement
            .error(confinement::Role::Receiver);
    }
    wire.send(0, plain());
    wire.run(200 * BIT);
    assert!((119..=127).contains(&wire.counters(1).1));
}

#[test]
fn states_change_at_96_128_and_256() {
    let mut confinement = Confinement::default();
    let mut states = Vec::new();
    for _ in 0..32 {
        confinement.error(confinement::Role::Transmitter);
        states.push(confinement.state());
    }
    let first = |state| {
        states
            .iter()
            .position(|one| *one == state)
            .map(|at| (at + 1) * 8)
    };
    assert_eq!(first(BusState::Warning), Some(96));
    assert_eq!(first(BusState::Passive), Some(128));
    assert_eq!(first(BusState::BusOff), Some(256));
}

#[test]
fn dominant_wire_counts_eight_every_eight_bits() {
    let mut wire = Wire::joined(1);
    // As a receiver: the sixth dominant bit, counted from SOF, is a stuff error; then six bits of flag, one more dominant bit,
    // and every eight after it.
    wire.force(0, 6 + 6, true);
    wire.run(12 * BIT);
    assert_eq!(wire.counters(0), (0, 1));
    let mut expected = Vec::new();
    let mut seen = Vec::new();
    for bit in 1..=24_u16 {
        wire.force(0, 1, true);
        wire.run(BIT);
        seen.push(wire.counters(0).1);
        expected.push(1 + 8 + 8 * (bit / 8));
    }
    assert_eq!(seen, expected);
}

#[test]
fn dominant_bit_in_intermission_causes_overload_frame() {
    let mut wire = Wire::joined(2);
    let bits = u64::from(frame_bits(&plain()));
    wire.send(0, plain());
    wire.send(0, plain());
    // The first bit of the intermission.
    wire.force(bits, 1, true);
    let start = wire.now;
    wire.run(300 * BIT);
    // Six bits of flag, eight of delimiter, three of intermission, then the next frame.
    assert_eq!(wire.bits(start + bits * BIT, 19), "0000000111111111110");
    assert_eq!(wire.received(1).len(), 2);
    assert_eq!(wire.error(0), None);
    assert_eq!(wire.counters(1), (0, 0));
}

#[test]
fn dominant_last_bit_is_error_for_transmitter_and_overload_for_receiver() {
    let bits = u64::from(frame_bits(&plain()));
    let wire = disturbed(bits - 1, 1, true);
    assert_eq!(wire.error(0), Some((ErrorCode::BitRecessive, true)));
    assert_eq!(wire.error(1), None);
    // The frame was already valid for the receiver: the known case of a frame received twice.
    assert_eq!(wire.received(1), [plain(), plain()]);
}
