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

use super::identifier::{ACKNOWLEDGEMENT, GLOBAL, Identifier, Pgn, pgn_bytes, pgn_of};
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
    }
}
