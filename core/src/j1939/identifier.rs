//! The 29-bit identifier (SAE J1939-21, 5.2).
//!
//! ```text
//!  bit 28        25    24    23                16 15                 8 7                  0
//!     +----------+-----+-----+--------------------+--------------------+--------------------+
//!     | priority | EDP | DP  | PF                 | PS                 | source address     |
//!     +----------+-----+-----+--------------------+--------------------+--------------------+
//!
//!  PF 0..239    PS is the destination (255: all), and not a part of the PGN
//!  PF 240..255  PS is the low byte of the PGN, and the destination is all
//! ```
//!
//! The extended data page bit (EDP) is always 0: with 1, the frame belongs to ISO 15765-3.

use crate::can::{CanId, Frame};

/// A parameter group number, 18 bits.
pub type Pgn = u32;

/// Proprietary A: a message of the maker to one node.
pub const PROPRIETARY_A: Pgn = 0x0EF00;
/// The request for the message of a parameter group.
pub const REQUEST: Pgn = 0x0EA00;
/// The positive or negative acknowledgement of a request or a command.
pub const ACKNOWLEDGEMENT: Pgn = 0x0E800;
/// Transport protocol, data transfer (TP.DT).
pub const TRANSPORT_DATA: Pgn = 0x0EB00;
/// Transport protocol, connection management (TP.CM).
pub const TRANSPORT_CONTROL: Pgn = 0x0EC00;
/// Address claimed, and cannot claim.
pub const ADDRESS_CLAIMED: Pgn = 0x0EE00;
/// The command to a node to take another address.
pub const COMMANDED_ADDRESS: Pgn = 0x0FED8;
/// Active diagnostic trouble codes (DM1).
pub const ACTIVE_CODES: Pgn = 0x0FECA;
/// The software version as a text, on request.
pub const SOFTWARE_IDENTIFICATION: Pgn = 0x0FEDA;
/// Make, model, serial number and unit number as a text, on request.
pub const COMPONENT_IDENTIFICATION: Pgn = 0x0FEEB;
/// Part number, serial number, location and type of the ECU as a text, on request.
pub const ECU_IDENTIFICATION: Pgn = 0x0FDC5;

/// The destination of a frame to all nodes.
pub const GLOBAL: u8 = 255;
/// The largest address of a node.
pub const LAST_ADDRESS: u8 = 253;
/// The source address of a node without address.
pub const NO_ADDRESS: u8 = 254;

/// The default priority of all groups except process data and transport protocol.
pub const PRIORITY: u8 = 6;

/// The first PF of the groups that are always sent to all nodes.
const FIRST_BROADCAST: u8 = 240;

/// The bit of an identifier that must be 0: extended data page.
pub const EXTENDED_DATA_PAGE: u32 = 1 << 25;

/// The parts of an identifier.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Identifier {
    /// The priority, 0 (highest) to 7.
    pub priority: u8,
    /// The parameter group number. Its lowest byte is 0 if the message has a destination.
    pub pgn: Pgn,
    /// The address of the receiver, or [`GLOBAL`].
    pub destination: u8,
    /// The address of the sender.
    pub source: u8,
}

impl Identifier {
    /// The identifier of a group of [`PRIORITY`]. A group with a PF of 240 or more ignores the destination.
    pub const fn new(pgn: Pgn, destination: u8, source: u8) -> Self {
        Self {
            priority: PRIORITY,
            pgn,
            destination,
            source,
        }
    }

    /// The same with this priority, 0 to 7.
    pub const fn with_priority(self, priority: u8) -> Self {
        Self {
            priority: priority & 7,
            ..self
        }
    }

    /// The parts of the identifier of a frame; None for another frame than a data frame of J1939.
    pub const fn of(frame: &Frame) -> Option<Self> {
        let bits = frame.can_id().bits();
        let is_extended = bits & 1 << 31 != 0;
        if !is_extended || frame.is_remote() || bits & EXTENDED_DATA_PAGE != 0 {
            return None;
        }
        let [source, specific, format, _] = bits.to_le_bytes();
        let page = bits >> 8 & 0x3_FF00;
        let (pgn, destination) = if format < FIRST_BROADCAST {
            (page, specific)
        } else {
            (page | specific as u32, GLOBAL)
        };
        Some(Self {
            priority: (bits >> 26 & 7) as u8,
            pgn,
            destination,
            source,
        })
    }

    /// The identifier of 29 bits.
    pub const fn can_id(self) -> CanId {
        let [specific, format, ..] = self.pgn.to_le_bytes();
        let specific = if format < FIRST_BROADCAST {
            self.destination
        } else {
            specific
        };
        let page = self.pgn & 0x3_FF00 | specific as u32;
        CanId::extended((self.priority as u32) << 26 | page << 8 | self.source as u32)
    }

    /// A frame with these eight bytes.
    pub fn frame(self, bytes: [u8; 8]) -> Frame {
        Frame::word(self.can_id(), u64::from_le_bytes(bytes), 8)
    }
}

/// The three bytes of a PGN in the data of a frame, least significant first.
pub const fn pgn_bytes(pgn: Pgn) -> [u8; 3] {
    let [low, middle, high, _] = pgn.to_le_bytes();
    [low, middle, high]
}

/// The PGN in three bytes of data.
pub const fn pgn_of([low, middle, high]: [u8; 3]) -> Pgn {
    u32::from_le_bytes([low, middle, high, 0])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::can::{extended, standard};

    fn parsed(id: u32) -> Option<Identifier> {
        Identifier::of(&Frame::data(extended(id), &[]).unwrap())
    }

    #[test]
    fn addressed_group_has_its_destination_in_the_identifier() {
        let id = Identifier::new(PROPRIETARY_A, 0x21, 0x80);
        assert_eq!(id.can_id(), CanId::extended(0x18EF_2180));
        assert_eq!(parsed(0x18EF_2180), Some(id));
        let request = parsed(0x0CEA_FF21).unwrap();
        assert_eq!((request.pgn, request.priority), (REQUEST, 3));
        assert_eq!((request.destination, request.source), (GLOBAL, 0x21));
    }

    #[test]
    fn broadcast_group_has_its_low_byte_in_the_identifier() {
        let id = Identifier::new(61_481, 0x21, 0x80).with_priority(3);
        assert_eq!(id.can_id(), CanId::extended(0x0CF0_2980));
        let expected = Identifier {
            destination: GLOBAL,
            ..id
        };
        assert_eq!(parsed(0x0CF0_2980), Some(expected));
        assert_eq!(parsed(0x18FD_C580).unwrap().pgn, ECU_IDENTIFICATION);
    }

    #[test]
    fn data_page_is_a_part_of_the_group() {
        let id = parsed(0x19EF_2180).unwrap();
        assert_eq!(id.pgn, 0x1_EF00);
        assert_eq!(id.can_id(), CanId::extended(0x19EF_2180));
    }

    #[test]
    fn frames_of_other_protocols_have_no_parts() {
        assert_eq!(parsed(0x1AEF_2180), None, "extended data page");
        let remote = Frame::remote(extended(0x18EF_2180), 8).unwrap();
        assert_eq!(Identifier::of(&remote), None);
        let short = Frame::data(standard(0x721), &[]).unwrap();
        assert_eq!(Identifier::of(&short), None);
    }

    #[test]
    fn group_number_in_data_is_little_endian() {
        assert_eq!(pgn_bytes(ADDRESS_CLAIMED), [0x00, 0xEE, 0x00]);
        assert_eq!(pgn_of([0xEB, 0xFE, 0x00]), COMPONENT_IDENTIFICATION);
    }
}
