//! Frames on the wire: their bits, their length, the time at which they are valid.

use super::*;
use crate::frame_length::frame_bits;
use plumbline::can::extended;

#[test]
fn known_frame_has_expected_bits() {
    // From a second implementation: bits as text, CRC by long division, stuffing by searching the stuffed text. SOF, identifier
    // with its stuff bit, RTR, IDE, r0, DLC, data, CRC, delimiter, ACK, delimiter, end of frame, intermission.
    let mut wire = Wire::joined(2);
    let start = wire.now;
    wire.send(0, data(0x123, &[0xAA]));
    wire.run(100 * BIT);
    let expected = "000100100011000001011010101001000111110101101011111111111";
    assert_eq!(wire.bits(start, expected.len() as u64), expected);
}

/// `000#`: only zeros, with a stuff bit after each run of five.
#[test]
fn frame_of_zeros_is_stuffed() {
    let mut wire = Wire::joined(2);
    let start = wire.now;
    wire.send(0, data(0, &[]));
    wire.run(100 * BIT);
    // 19 zeros of header, 15 zeros of CRC: 34. A recessive bit follows the first five and every further five, because no stuff
    // bit is next to another.
    let expected = "000001".repeat(6) + "0000" + "1" + "0" + "1" + "1111111" + "111";
    assert_eq!(wire.bits(start, expected.len() as u64), expected);
}

#[test]
fn every_frame_takes_expected_bits_and_is_received() {
    let mut random = 1_u64;
    for round in 0..2000 {
        random = random
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        let bytes = (random ^ random >> 29)
            .to_le_bytes()
            .map(|byte| [0x00, 0xFF, 0xF0, 0x87, byte][usize::from(byte) % 5]);
        let length = round % 9;
        let id = if random >> 59 & 1 == 0 {
            standard((random >> 40) as u16)
        } else {
            extended((random >> 30) as u32)
        };
        let frame = if random >> 58 & 3 == 0 {
            Frame::remote(id, length).unwrap()
        } else {
            Frame::data(id, &bytes[..length]).unwrap()
        };
        let mut wire = Wire::joined(2);
        let start = wire.now;
        wire.send(0, frame);
        wire.run(200 * BIT);
        assert_eq!(wire.received(1), [frame]);
        // The sample point is at 7/8 of the last bit for the transmitter, and of the last bit but one for the receiver.
        let end = start + u64::from(frame_bits(&frame)) * BIT - BIT / 8;
        assert_eq!(
            wire.stations[0].events.last(),
            Some(&(end, Event::Transmitted)),
            "{frame:?}"
        );
        assert_eq!(
            wire.stations[1].events.last(),
            Some(&(end - BIT, Event::Received(frame)))
        );
    }
}

#[test]
fn next_frame_starts_after_three_bits() {
    let mut wire = Wire::joined(2);
    let start = wire.now;
    for _ in 0..10 {
        wire.send(0, Frame::remote(standard(0x7FF), 4).unwrap());
    }
    wire.run(600 * BIT);
    let ends: Vec<_> = wire.stations[0]
        .events
        .iter()
        .filter(|(_, event)| *event == Event::Transmitted)
        .map(|(at, _)| at - start + BIT / 8)
        .collect();
    let expected: Vec<_> = (0..10).map(|n| (47 + 50 * n) * BIT).collect();
    assert_eq!(ends, expected);
}

#[test]
fn dlc_above_eight_means_eight() {
    for code in 9..16_u32 {
        let (mut stuffed, bytes) = (Incoming::default(), [1, 2, 3, 4, 5, 6, 7, 8]);
        let mut bits = vec![false];
        let mut push = |value: u32, count: u32| {
            bits.extend((0..count).rev().map(|bit| value >> bit & 1 == 1));
        };
        push(0x123, 11);
        push(0, 3);
        push(code, 4);
        bytes.iter().for_each(|byte| push(*byte, 8));
        // The CRC has no effect on the fields.
        push(0, 15);
        for bit in bits {
            while stuffed.stuff_is_due() {
                let wire = stuffed_bit(&stuffed);
                stuffed.push(wire).unwrap();
            }
            stuffed.push(bit).unwrap();
        }
        assert_eq!(
            stuffed.frame(),
            Frame::data(standard(0x123), &bytes.map(|byte| byte as u8))
        );
    }
}

/// The stuff bit that is due; a transmitter must send it.
fn stuffed_bit(seen: &Incoming) -> bool {
    Outgoing::new(&data(0, &[])).next(seen)
}

#[test]
fn silent_controller_receives_without_driving_the_wire() {
    let mut wire = Wire::joined(1);
    let silent = wire.add(BitTiming::of(BitRate::K250), true);
    wire.run(JOIN * BIT);
    wire.forget();
    wire.send(silent, data(1, &[]));
    wire.run(100 * BIT);
    assert!(wire.changes.is_empty(), "a silent controller does not send");
    wire.send(0, data(0x123, &[]));
    wire.run(100 * BIT);
    assert_eq!(
        wire.received(silent),
        [],
        "not acknowledged, so never complete"
    );
    assert_eq!(wire.error(0), Some((ErrorCode::Acknowledgment, true)));
    let other = wire.add(BitTiming::of(BitRate::K250), false);
    wire.run(5000 * BIT);
    assert_eq!(wire.received(silent), [data(0x123, &[])]);
    assert_eq!(wire.received(other), [data(0x123, &[])]);
}

#[test]
fn joining_controller_waits_for_eleven_recessive_bits() {
    let mut wire = Wire::joined(2);
    wire.send(0, data(0x555, &[0x55; 8]));
    wire.run(20 * BIT);
    let late = wire.add(BitTiming::of(BitRate::K250), false);
    wire.run(200 * BIT);
    let frame = u64::from(frame_bits(&data(0x555, &[0x55; 8])));
    // The ACK slot is the last dominant bit, 8 bits before the end, so the eleventh recessive bit is the last of the
    // intermission.
    let joined = JOIN * BIT + (frame + 3) * BIT - BIT / 8;
    assert_eq!(wire.stations[late].events, [(joined, Event::Joined)]);
}

#[test]
fn idle_wire_has_no_events() {
    let wire = Wire::joined(5);
    assert_eq!(wire.next(), None);
}
