//! The bytes of requests and replies (tables 13 and 23).
//!
//! ```text
//!            byte 0   1        2      3      4      5      6      7
//!  request   FSC      D0       D1     D2     D3     D4     D5     D6
//!  reply     FSC      status   D1     D2     D3     D4     D5     D6
//! ```
//!
//! All numbers are little-endian. A CAN identifier is a 32-bit number: bit 31 is the format (1 = 29 bit), the identifier is
//! right-aligned, the bits between are zero.

use crate::can::{Frame, extended, standard};
use embedded_can::Id;

const EXTENDED: u32 = 1 << 31;

/// The identifier that `value` stands for; None when a bit between the format bit and the identifier is set.
pub fn identifier(value: u32) -> Option<Id> {
    if value & EXTENDED == 0 {
        (value <= 0x7FF).then(|| standard(value as u16))
    } else {
        let id = value & !EXTENDED;
        (id <= 0x1FFF_FFFF).then(|| extended(id))
    }
}

/// A reply: the echoed code, the status byte and up to six bytes of data.
#[derive(Clone, Copy, Debug)]
pub(super) struct Reply {
    /// The bytes as a little-endian number: to append to it is a shift.
    bytes: u64,
    length: u8,
}

impl Reply {
    /// A reply without data.
    pub fn new(fsc: u8, status: u8) -> Self {
        Self {
            bytes: u16::from_le_bytes([fsc, status]).into(),
            length: 2,
        }
    }

    /// Appends the low `size` bytes (1 to 4) of `value`; what does not fit into the frame is left out.
    pub fn with(self, value: u32, size: u8) -> Self {
        let length = self.length.saturating_add(size);
        if length > 8 {
            return self;
        }
        let unused = 32_u32.saturating_sub(8 * u32::from(size));
        let value = u64::from(value.wrapping_shl(unused).wrapping_shr(unused));
        Self {
            bytes: self.bytes | value.wrapping_shl(8 * u32::from(self.length)),
            length,
        }
    }

    /// The frame on the wire.
    pub fn frame(&self, id: Id) -> Frame {
        Frame::of(id, self.bytes.to_le_bytes(), self.length)
    }
}

/// The little-endian number in the first `size` bytes of `data`; None when there are fewer.
pub(super) fn number(data: &[u8], size: u8) -> Option<u32> {
    let mut bytes = [0; 4];
    for (to, from) in bytes.iter_mut().zip(data.get(..size.into())?) {
        *to = *from;
    }
    Some(u32::from_le_bytes(bytes))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn identifiers_are_read_as_table_23_says() {
        assert_eq!(identifier(0x300), Some(standard(0x300)));
        assert_eq!(identifier(0x7FF), Some(standard(0x7FF)));
        // The manual's example: 61h 03h 00h 80h is 361h in 29-bit format.
        assert_eq!(
            identifier(u32::from_le_bytes([0x61, 3, 0, 0x80])),
            Some(extended(0x361))
        );
        assert_eq!(identifier(0x9FFF_FFFF), Some(extended(0x1FFF_FFFF)));
        for bit in 11..31 {
            assert_eq!(
                identifier(0x300 | 1 << bit),
                None,
                "11-bit identifier with bit {bit}"
            );
        }
        assert_eq!(identifier(EXTENDED | 1 << 29), None);
        assert_eq!(identifier(EXTENDED | 1 << 30), None);
    }

    #[test]
    fn a_reply_is_filled_from_byte_2_on() {
        let reply = Reply::new(0x17, 3).with(2000, 2).with(2, 1);
        let frame = reply.frame(standard(0x301));
        assert_eq!(frame.bytes(), [0x17, 3, 0xD0, 0x07, 2]);
    }

    #[test]
    fn only_the_low_bytes_of_a_value_are_taken() {
        for size in 1..=4 {
            let reply = Reply::new(0xFF, 0x80).with(u32::MAX, size).with(0x0201, 2);
            let frame = reply.frame(standard(0x301));
            let size = usize::from(size);
            assert_eq!(frame.bytes()[..2], [0xFF, 0x80]);
            assert!(frame.bytes()[2..2 + size].iter().all(|&byte| byte == 0xFF));
            assert_eq!(frame.bytes()[2 + size..], [1, 2]);
        }
    }

    #[test]
    fn what_does_not_fit_is_left_out() {
        let full = Reply::new(1, 2).with(0x0605_0403, 4).with(0x0807, 2);
        let frame = full.with(9, 1).frame(standard(0x301));
        assert_eq!(frame.bytes(), [1, 2, 3, 4, 5, 6, 7, 8]);
    }

    #[test]
    fn a_number_needs_all_its_bytes() {
        assert_eq!(number(&[0xFA, 0, 9], 2), Some(250));
        assert_eq!(number(&[0xFA], 2), None);
        assert_eq!(number(&[], 1), None);
    }
}
