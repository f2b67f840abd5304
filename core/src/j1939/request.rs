//! Request and acknowledgement (SAE J1939-21, 5.4.2 and 5.4.4).
//!
//! ```text
//!  18EA<dst><src>  byte 0                3            request for a group
//!                       +----------------+
//!                       | PGN            |            more bytes are ignored
//!                       +----------------+
//!
//!  18E8FF<src>     byte 0         1                4           5                8
//!                       +---------+----------------+-----------+----------------+
//!                       | control | FF FF FF       | requester | PGN            |
//!                       +---------+----------------+-----------+----------------+
//!
//!  control  1: the group is not supported, 3: it cannot be sent now
//! ```

use super::identifier::{ACKNOWLEDGEMENT, GLOBAL, Identifier, Pgn, REQUEST, pgn_bytes, pgn_of};
use crate::can::Frame;

/// The control byte of an acknowledgement.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
#[repr(u8)]
pub enum Control {
    /// Negative acknowledgement: the group is not supported.
    Negative = 1,
    /// Cannot respond: the node is busy.
    Busy = 3,
}

/// The requested group; None if the data is too short.
pub fn requested(data: &[u8]) -> Option<Pgn> {
    data.first_chunk().map(|pgn| pgn_of(*pgn))
}

/// A request for `pgn` to a node, or to all nodes.
pub fn request(pgn: Pgn, destination: u8, source: u8) -> Frame {
    let [low, middle, high] = pgn_bytes(pgn);
    let id = Identifier::new(REQUEST, destination, source).can_id();
    Frame::of(id, [low, middle, high, 0, 0, 0, 0, 0], 3)
}

/// The group that an acknowledgement to `requester` refuses; None if it is positive, or to another node.
pub fn refused(data: &[u8], requester: u8) -> Option<Pgn> {
    match *data {
        [control, _, _, _, own, a, b, c] if control > 0 && own == requester => {
            Some(pgn_of([a, b, c]))
        }
        _ => None,
    }
}

/// The answer to a request for `pgn` by the node with the address `requester`.
pub fn acknowledgement(control: Control, pgn: Pgn, requester: u8, source: u8) -> Frame {
    let [low, middle, high] = pgn_bytes(pgn);
    let bytes = [
        control as u8,
        0xFF,
        0xFF,
        0xFF,
        requester,
        low,
        middle,
        high,
    ];
    Identifier::new(ACKNOWLEDGEMENT, GLOBAL, source).frame(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn request_has_at_least_three_bytes() {
        assert_eq!(requested(&[0xEB, 0xFE, 0x00]), Some(65_259));
        assert_eq!(requested(&[0xEB, 0xFE, 0x00, 1, 2]), Some(65_259));
        assert_eq!(requested(&[0xEB, 0xFE]), None);
    }

    #[test]
    fn acknowledgement_names_requester_and_group() {
        let text = |control| std::format!("{:?}", acknowledgement(control, 0xFEEE, 0x21, 0x80));
        assert_eq!(text(Control::Negative), "18E8FF80#01FFFFFF21EEFE00");
        assert_eq!(text(Control::Busy), "18E8FF80#03FFFFFF21EEFE00");
        let frame = acknowledgement(Control::Busy, 0xFEEE, 0x21, 0x80);
        assert_eq!(refused(frame.bytes(), 0x21), Some(0xFEEE));
        assert_eq!(refused(frame.bytes(), 0x22), None);
        let positive = [0, 0xFF, 0xFF, 0xFF, 0x21, 0xEE, 0xFE, 0x00];
        assert_eq!(refused(&positive, 0x21), None);
    }

    #[test]
    fn request_is_sent_with_priority_6() {
        let text = |destination| std::format!("{:?}", request(0xFEEB, destination, 0x21));
        assert_eq!(text(0x80), "18EA8021#EBFE00");
        assert_eq!(text(GLOBAL), "18EAFF21#EBFE00");
    }
}
