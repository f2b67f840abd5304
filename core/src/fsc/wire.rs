//! The bytes of requests and replies (tables 13 and 23).
//!
//! ```text
//!            byte 0   1        2      3      4      5      6      7
//!  request   FSC      D0       D1     D2     D3     D4     D5     D6
//!  reply     FSC      status   D1     D2     D3     D4     D5     D6
//! ```
//!
//! All numbers are little-endian. A CAN identifier is the 32-bit number of a [`CanId`]: bit 31 is the format (1 = 29 bit), the
//! identifier is right-aligned, the bits between them are 0.

use crate::can::{CanId, Frame};
use crate::param::Ranges;

const EXTENDED: u32 = 1 << 31;

/// The permitted numbers of a CAN identifier.
pub const IDENTIFIERS: Ranges = Ranges {
    text: "11 or 29 bit",
    ignored_bits: 0,
    ranges: &[(0, 0x7FF), (EXTENDED, EXTENDED | 0x1FFF_FFFF)],
};

/// A reply: the echoed code, the status byte and up to six bytes of data.
#[derive(Clone, Copy, Debug)]
pub(super) struct Reply {
    /// The bytes of the frame, and four more, so that a 32-bit number can be written at each position.
    bytes: [u8; 12],
    length: usize,
}

impl Reply {
    /// A reply with code and status byte. [`append`](Self::append) adds the data.
    pub fn new(fsc: u8, status: u8) -> Self {
        Self {
            bytes: [fsc, status, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0],
            length: 2,
        }
    }

    /// Appends the low `size` bytes (1, 2 or 4) of `value`. The fields of a reply fit into a frame: this is checked at compile
    /// time.
    pub fn append(&mut self, value: u32, size: u8) {
        self.put(value);
        self.length += usize::from(size);
    }

    /// Writes four bytes after the last field.
    fn put(&mut self, value: u32) {
        let start = self.length & 7;
        if let Some(place) = self.bytes.get_mut(start..start + 4) {
            place.copy_from_slice(&value.to_le_bytes());
        }
    }

    /// The frame on the wire.
    pub fn frame(mut self, id: CanId) -> Frame {
        if self.length < 8 {
            // Clears the upper bytes of the last value.
            self.put(0);
        }
        let [a, b, c, d, e, f, g, h, ..] = self.bytes;
        let data = u64::from_le_bytes([a, b, c, d, e, f, g, h]);
        Frame::word(id, data, self.length as u8)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn identifiers_match_table_23() {
        for id in [0, 0x300, 0x7FF, 0x8000_0000, 0x9FFF_FFFF] {
            assert!(IDENTIFIERS.contain(id));
            assert_eq!(CanId::from_bits(id).bits(), id);
        }
        // The manual's example: 61h 03h 00h 80h is 361h in 29-bit format.
        let example = u32::from_le_bytes([0x61, 3, 0, 0x80]);
        assert!(IDENTIFIERS.contain(example));
        assert_eq!(CanId::from_bits(example), CanId::extended(0x361));
        for bit in 11..31 {
            assert!(!IDENTIFIERS.contain(0x300 | 1 << bit), "bit {bit}");
        }
        assert!(!IDENTIFIERS.contain(EXTENDED | 1 << 29));
        assert!(!IDENTIFIERS.contain(EXTENDED | 1 << 30));
    }

    fn reply(fsc: u8, status: u8, numbers: &[(u32, u8)]) -> Reply {
        let mut reply = Reply::new(fsc, status);
        for (value, size) in numbers {
            reply.append(*value, *size);
        }
        reply
    }

    #[test]
    fn reply_data_begins_at_byte_2() {
        let reply = reply(0x17, 3, &[(2000, 2), (2, 1)]);
        let frame = reply.frame(CanId::standard(0x301));
        assert_eq!(frame.bytes(), [0x17, 3, 0xD0, 0x07, 2]);
    }

    #[test]
    fn reply_contains_low_bytes_of_value() {
        for size in [1, 2, 4] {
            let reply = reply(0xFF, 0x80, &[(u32::MAX, size), (0x0201, 2)]);
            let frame = reply.frame(CanId::standard(0x301));
            let size = usize::from(size);
            assert_eq!(frame.bytes()[..2], [0xFF, 0x80]);
            assert!(frame.bytes()[2..2 + size].iter().all(|&byte| byte == 0xFF));
            assert_eq!(frame.bytes()[2 + size..], [1, 2]);
        }
    }
}
