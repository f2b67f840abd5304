//! The number of bits of a frame on the wire, and which of two frames wins arbitration (ISO 11898-1, CAN 2.0 A and B).
//!
//! ```text
//!  11 bit:  SOF | ID 11 | RTR | IDE=0 | r0 | DLC 4 | data 0..64 | CRC 15 | del | ACK | del | EOF 7 | intermission 3
//!  29 bit:  SOF | ID 11 | SRR=1 | IDE=1 | ID 18 | RTR | r1 | r0 | DLC 4 | data | CRC 15 | ...
//!           \______________________ stuffed, the CRC included ______________________/
//! ```
//!
//! A zero is dominant. After five equal bits the transmitter inserts a bit of the other value, which counts for the next five.

use embedded_can::Id;
use plumbline::can::Frame;

/// The bits between two frames, after the end of frame.
pub const INTERMISSION: u32 = 3;

/// The bits after the CRC sequence: CRC delimiter, ACK slot, ACK delimiter, end of frame.
const TAIL: u32 = 1 + 1 + 1 + END_OF_FRAME;

/// The recessive bits that end a frame.
const END_OF_FRAME: u32 = 7;

/// The length of a frame in bits from the start of frame to the end of frame, with stuff bits, without intermission.
pub fn frame_bits(frame: &Frame) -> u32 {
    let mut bits = header_and_data(frame);
    let crc = crc15(&bits);
    push(&mut bits, crc.into(), 15);
    bits.len() as u32 + stuff_bits(&bits) + TAIL
}

/// The arbitration field as sent on the wire, first bit as MSB: of two frames that start together, the smaller number wins.
///
/// The two bits after the base identifier are RTR and IDE = 0 in a standard frame, SRR = 1 and IDE = 1 in an extended frame. So
/// with the same 11 bits standard wins over extended, and with the same identifier a data frame wins over a remote frame.
pub fn arbitration(frame: &Frame) -> u32 {
    let remote = u32::from(frame.is_remote());
    match frame.id() {
        Id::Standard(id) => u32::from(id.as_raw()) << 21 | remote << 20,
        Id::Extended(id) => {
            let (base, extension) = (id.as_raw() >> 18, id.as_raw() & 0x3_FFFF);
            base << 21 | 0b11 << 19 | extension << 1 | remote
        }
    }
}

/// The bits from the start of frame to the last data bit, not stuffed.
fn header_and_data(frame: &Frame) -> Vec<bool> {
    let mut bits = vec![false];
    let remote = u32::from(frame.is_remote());
    match frame.id() {
        Id::Standard(id) => {
            push(&mut bits, id.as_raw().into(), 11);
            push(&mut bits, remote << 2, 3);
        }
        Id::Extended(id) => {
            push(&mut bits, id.as_raw() >> 18, 11);
            push(&mut bits, 0b11, 2);
            push(&mut bits, id.as_raw(), 18);
            push(&mut bits, remote << 2, 3);
        }
    }
    push(&mut bits, frame.dlc() as u32, 4);
    for byte in frame.bytes() {
        push(&mut bits, u32::from(*byte), 8);
    }
    bits
}

/// Appends the low `count` bits of `value`, the highest first.
fn push(bits: &mut Vec<bool>, value: u32, count: u32) {
    bits.extend((0..count).rev().map(|bit| value >> bit & 1 == 1));
}

/// CRC-15/CAN of a bit sequence: x^15 + x^14 + x^10 + x^8 + x^7 + x^4 + x^3 + 1, initial value 0.
fn crc15(bits: &[bool]) -> u16 {
    bits.iter().fold(0, |crc, &bit| {
        let next = bit ^ (crc >> 14 & 1 == 1);
        (crc << 1 & 0x7FFF) ^ if next { 0x4599 } else { 0 }
    })
}

/// The number of stuff bits that a transmitter inserts into this sequence.
fn stuff_bits(bits: &[bool]) -> u32 {
    let mut stuffed = 0;
    let mut run = (true, 0);
    for &bit in bits {
        run = if bit == run.0 {
            (bit, run.1 + 1)
        } else {
            (bit, 1)
        };
        if run.1 == 5 {
            stuffed += 1;
            run = (!bit, 1);
        }
    }
    stuffed
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::text::frame;
    use plumbline::can::{extended, standard};

    #[test]
    fn crc_is_crc_15_can() {
        // The check value in the catalogue of parametrised CRC algorithms: CRC-15/CAN of the text "123456789".
        let mut bits = Vec::new();
        for byte in b"123456789" {
            push(&mut bits, u32::from(*byte), 8);
        }
        assert_eq!(crc15(&bits), 0x059E);
    }

    #[test]
    fn stuff_bit_counts_for_next_five() {
        let count = |text: &str| {
            let bits: Vec<bool> = text.chars().map(|bit| bit == '1').collect();
            stuff_bits(&bits)
        };
        assert_eq!(count("0000"), 0);
        assert_eq!(count("00000"), 1);
        // The worst case: after the first five bits, every four bits need a stuff bit.
        assert_eq!(count("0000011110000"), 3);
        assert_eq!(count("00000000"), 1);
        assert_eq!(count("0000000000"), 2);
        assert_eq!(count("1010101010"), 0);
    }

    /// Calculated by a second implementation: bits as text, CRC by long division, stuffing by searching the stuffed text.
    #[test]
    fn frames_have_expected_length() {
        let lengths = [
            ("000#", 50),
            ("000#0000000000000000", 124),
            ("7FF#FFFFFFFFFFFFFFFF", 123),
            ("555#AAAAAAAAAAAAAAAA", 109),
            ("301#FF02", 65),
            ("7FF#R4", 47),
            ("700#00", 55),
            ("080#", 48),
            ("123#00CA22FF5566AADF", 112),
            ("000#3E0077E0F067FE00", 126),
            ("00000000#0000000000000000", 147),
            ("1FFFFFFF#FFFFFFFFFFFFFFFF", 146),
            ("15555555#", 65),
            ("18EA0012#00EE00", 94),
            ("1FFFFFFF#R", 71),
            ("1F0387BE#3C1F0FF80F8787E0", 151),
        ];
        for (text, bits) in lengths {
            assert_eq!(frame_bits(&frame(text)), bits, "{text}");
        }
    }

    /// The known limits (Davis, Burns, Bril, Lukkien: "Controller Area Network (CAN) schedulability analysis", 2007): with n data
    /// bytes, g = 34 or 54 bits that can be stuffed, and 13 that cannot, a frame with its intermission has at most
    /// g + 8 n + 13 + (g + 8 n - 1) / 4 bits; that is 135 and 160 bits for 8 bytes.
    #[test]
    fn frame_lengths_are_within_limits_of_standard() {
        let mut random = 1_u64;
        for _ in 0..100_000 {
            random = random
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            let bytes = (random ^ random >> 29).to_le_bytes();
            let length = (random >> 60) as usize % 9;
            let (id, g) = if random >> 59 & 1 == 0 {
                (standard((random >> 40) as u16), 34)
            } else {
                (extended((random >> 30) as u32), 54)
            };
            // Long runs of equal bits, which random bytes rarely have.
            let data = bytes.map(|byte| [0x00, 0xFF, 0xF0, 0x87, byte][usize::from(byte) % 5]);
            let frame = Frame::data(id, &data[..length]).unwrap();
            let bits = frame_bits(&frame) + INTERMISSION;
            let stuffed = g + 8 * length as u32;
            assert!(bits >= stuffed + 13, "{frame:?}: {bits}");
            assert!(
                bits <= stuffed + 13 + (stuffed - 1) / 4,
                "{frame:?}: {bits}"
            );
        }
    }

    #[test]
    fn arbitration_follows_bits_on_the_wire() {
        // Highest priority first.
        let order = [
            "000#",
            "000#R",
            "00000000#",
            "00000000#R",
            "00000001#",
            "001#",
            "300#",
            "300#R",
            "0C000000#",
            "0C000000#R",
            "0FFFFFFF#",
            "7FF#",
            "7FF#R",
            "1FFFFFFF#",
            "1FFFFFFF#R",
        ];
        let order: Vec<u32> = order.map(|text| arbitration(&frame(text))).into();
        assert!(order.is_sorted_by(|a, b| a < b), "{order:X?}");
    }
}
