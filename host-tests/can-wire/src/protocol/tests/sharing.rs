//! Several controllers on one wire: arbitration, clock differences, other bit rates.

use super::*;
use crate::frame_length::arbitration;
use plumbline::can::extended;

#[test]
fn lowest_identifier_goes_first_without_errors() {
    let mut frames = [
        data(0x300, &[1]),
        Frame::remote(standard(0x300), 1).unwrap(),
        Frame::data(extended(0x300 << 18), &[1]).unwrap(),
        Frame::remote(extended(0x300 << 18), 1).unwrap(),
        data(0x301, &[]),
        data(0x2FF, &[]),
        data(0x000, &[]),
        Frame::data(extended(0x300 << 18 | 1), &[]).unwrap(),
    ];
    let mut wire = Wire::joined(frames.len() + 1);
    for (station, frame) in frames.iter().enumerate() {
        wire.send(station, *frame);
    }
    wire.run(2000 * BIT);
    frames.sort_by_key(arbitration);
    assert_eq!(wire.received(frames.len()), frames);
    for station in 0..=frames.len() {
        assert_eq!(wire.error(station), None);
        assert_eq!(wire.counters(station), (0, 0));
    }
    let losses: usize = (0..frames.len())
        .map(|s| wire.count(s, Event::LostArbitration))
        .sum();
    assert_eq!(losses, 7 + 6 + 5 + 4 + 3 + 2 + 1);
}

#[test]
fn equal_identifier_with_different_data_is_bit_error() {
    let mut wire = Wire::joined(3);
    wire.send(0, data(0x123, &[0x55]));
    wire.send(1, data(0x123, &[0x5D]));
    wire.run(60 * BIT);
    assert_eq!(wire.error(1), Some((ErrorCode::BitRecessive, true)));
    assert_eq!(wire.count(2, Event::Received(data(0x123, &[0x55]))), 0);
}

#[test]
fn stuff_error_in_arbitration_does_not_count_for_transmitter() {
    let mut wire = Wire::joined(1);
    // SOF and four zeros; then its recessive stuff bit is dominant on the wire.
    wire.send(0, data(0x00F, &[]));
    wire.force(5, 1, true);
    wire.run(7 * BIT);
    assert_eq!(wire.error(0), Some((ErrorCode::Stuff, true)));
    assert_eq!(wire.counters(0), (0, 0));
}

#[test]
fn third_bit_of_intermission_may_be_start_of_frame() {
    let mut wire = Wire::joined(2);
    let first = data(0x555, &[]);
    let bits = u64::from(crate::frame_length::frame_bits(&first));
    wire.send(0, first);
    wire.send(1, data(0x556, &[]));
    // The frame of the second controller, without its start of frame, follows that of the other one.
    wire.force(bits + 2, 1, true);
    let start = wire.now;
    wire.run(200 * BIT);
    assert_eq!(wire.received(0), [data(0x556, &[])]);
    assert_eq!(wire.bits(start + (bits + 2) * BIT, 12), "010101010110");
}

/// A clock with this deviation in millionths.
fn off_by(millionths: i64) -> BitTiming {
    let BitTiming { bit, sample, jump } = BitTiming::of(BitRate::K250);
    let scale =
        |time: Picoseconds| (time as i64 + time as i64 * millionths / 1_000_000) as Picoseconds;
    BitTiming {
        bit: scale(bit),
        sample: scale(sample),
        jump: scale(jump),
    }
}

#[test]
fn clocks_half_a_percent_off_stay_synchronized() {
    for millionths in [-5000, 5000] {
        let mut wire = Wire::default();
        wire.add(off_by(millionths), false);
        wire.add(off_by(-millionths), false);
        wire.run(2 * JOIN * BIT);
        for number in 0..100_u8 {
            let bytes = [number, 0x00, 0xFF, 0xF0, 0x87, number, 0xFF, 0x00];
            wire.send(
                usize::from(number % 2),
                data(0x100 + u16::from(number), &bytes),
            );
        }
        wire.run(100 * 140 * BIT);
        for station in 0..2 {
            assert_eq!(wire.received(station).len(), 50);
            assert_eq!(wire.error(station), None, "{millionths}");
        }
    }
}

#[test]
fn clocks_that_differ_too_much_cause_errors() {
    let mut wire = Wire::default();
    wire.add(off_by(30_000), false);
    wire.add(off_by(-30_000), false);
    wire.run(2 * JOIN * BIT);
    wire.send(0, data(0x100, &[0x00; 8]));
    wire.run(200 * BIT);
    assert!(wire.error(0).is_some());
}

#[test]
fn resynchronization_is_limited_to_jump_width() {
    let timing = BitTiming::of(BitRate::K250);
    let mut clock = BitClock::new(0, timing);
    clock.resynchronize(BIT / 2, false);
    assert_eq!(clock.start(), timing.jump, "late edge");
    let mut clock = BitClock::new(0, timing);
    clock.resynchronize(BIT / 2, true);
    assert_eq!(clock.start(), 0, "the edge of the transmitter itself");
    let mut clock = BitClock::new(BIT, timing);
    clock.resynchronize(BIT / 2, true);
    assert_eq!(clock.start(), BIT - timing.jump, "early edge");
    let mut clock = BitClock::new(BIT, timing);
    clock.resynchronize(BIT - 1, false);
    assert_eq!(clock.start(), BIT - 1, "a small early edge");
    assert!(!clock.takes_edge(), "one edge per bit");
}

#[test]
fn two_rates_on_one_wire_disturb_each_other_until_error_passive() {
    let mut wire = Wire::joined(2);
    wire.add(BitTiming::of(BitRate::K125), false);
    wire.run(2 * JOIN * BIT);
    wire.send(2, data(0x123, &[1, 2, 3]));
    for number in 0..20 {
        wire.send(0, data(0x200, &[number]));
    }
    wire.run(20_000 * BIT);
    // An error passive controller destroys no frames, so the two at the same rate succeed.
    assert!(wire.error(1).is_some(), "receivers are disturbed too");
    let loud = wire.state(2);
    assert!(
        matches!(loud, BusState::Passive | BusState::BusOff),
        "{loud:?}"
    );
    assert_eq!(wire.received(1).len(), 20);
}
