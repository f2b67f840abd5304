//! The layout of a frame in a mailbox (RM0008, 24.9.3): the same four words for transmit and receive.
//!
//! | Word | Bits | Content |
//! |---|---|---|
//! | 0 | 31..21, 31..3 | standard or extended identifier |
//! | | 2, 1, 0 | IDE: extended; RTR: remote; TXRQ: transmit request (transmit mailboxes only) |
//! | 1 | 31..16, 15..8, 3..0 | time stamp, filter match index (receive mailboxes only), data length code |
//! | 2, 3 | | data bytes 0 to 3 and 4 to 7, the first one in the low byte |

use embedded_can::Id;
use plumbline::can::{Frame, extended, standard};

/// The words of a mailbox.
pub(super) type Words = [u32; 4];

/// TIxR.IDE, RIxR.IDE: the identifier is extended.
const EXTENDED: u32 = 1 << 2;
/// TIxR.RTR, RIxR.RTR: a remote frame.
const REMOTE: u32 = 1 << 1;

/// The frame in a mailbox. A DLC of 9 to 15 means 8 bytes.
pub(super) fn frame([identifier, length, low, high]: &Words) -> Frame {
    let id = if identifier & EXTENDED == 0 {
        standard((identifier >> 21) as u16)
    } else {
        extended(identifier >> 3)
    };
    let length = (length & 0xF).min(8) as usize;
    let frame = if identifier & REMOTE == 0 {
        let data = (u64::from(*high) << 32 | u64::from(*low)).to_le_bytes();
        Frame::data(id, &data[..length])
    } else {
        Frame::remote(id, length)
    };
    frame.expect("at most 8 bytes")
}

/// The mailbox words of a received frame, with the filter match index and the DLC in place of 8. The time stamp is 0: time-triggered
/// communication is off.
pub(super) fn words(frame: &Frame, match_index: u8, long_length: u32) -> Words {
    let mut data = [0; 8];
    data[..frame.bytes().len()].copy_from_slice(frame.bytes());
    let data = u64::from_le_bytes(data);
    let length = match frame.dlc() {
        8 => long_length,
        short => short as u32,
    };
    [
        identifier(frame),
        u32::from(match_index) << 8 | length,
        data as u32,
        (data >> 32) as u32,
    ]
}

/// The identifier word of a frame.
pub(super) fn identifier(frame: &Frame) -> u32 {
    let remote = if frame.is_remote() { REMOTE } else { 0 };
    match frame.id() {
        Id::Standard(id) => u32::from(id.as_raw()) << 21 | remote,
        Id::Extended(id) => id.as_raw() << 3 | EXTENDED | remote,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frame_has_mailbox_layout_of_manual() {
        let data = Frame::data(standard(0x7A5), &[1, 2, 3, 4, 5]).unwrap();
        assert_eq!(words(&data, 7, 8), [0x7A5 << 21, 0x0705, 0x0403_0201, 0x05]);
        let remote = Frame::remote(extended(0x1ABC_DEF3), 8).unwrap();
        let [identifier, length, ..] = words(&remote, 0, 15);
        assert_eq!((identifier, length), (0x1ABC_DEF3 << 3 | 0b110, 15));
    }

    #[test]
    fn frame_survives_mailbox_round_trip() {
        for original in [
            Frame::data(standard(0x123), &[]).unwrap(),
            Frame::data(extended(0x1FFF_FFFF), &[8, 7, 6, 5, 4, 3, 2, 1]).unwrap(),
            Frame::remote(standard(0x7FF), 3).unwrap(),
            Frame::remote(extended(0), 0).unwrap(),
        ] {
            assert_eq!(frame(&words(&original, 0, 15)), original);
        }
    }

    #[test]
    fn dlc_above_8_means_8_bytes() {
        for code in 8..16 {
            assert_eq!(frame(&[0, code, 0, 0]).bytes().len(), 8);
            assert_eq!(frame(&[REMOTE, code, 0, 0]).dlc(), 8);
        }
    }

    #[test]
    fn standard_identifier_ignores_extension_bits() {
        assert_eq!(
            frame(&[0x123 << 21 | 0x1F_FFF8, 0, 0, 0]).id(),
            standard(0x123)
        );
    }
}
