//! The CAN identifiers of the predefined master/slave connection set.
//!
//! ```text
//!  bit       10    9    8    7    6    5    4    3    2    1    0
//!  group 1    0  | message, 4 bits  |      MAC ID of the source       |
//!  group 2    1    0  |       MAC ID of the slave       |   message   |
//! ```
//!
//! Groups 3 and 4 (600h and above) are not used.

use crate::can::CanId;

/// The highest MAC ID. All bits of the field are 1.
pub const MAC_MAX: u8 = 63;

/// The lowest identifier of group 2.
const GROUP_2: u16 = 0x400;

/// A message of group 1 that the slave sends.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Group1 {
    /// Values after a change, or cyclically.
    ChangeOrCyclic = 0x0D,
    /// The answer to a poll command.
    PollResponse = 0x0F,
}

impl Group1 {
    /// The identifier of the slave with this MAC ID.
    pub const fn id(self, mac: u8) -> u16 {
        (self as u16) << 6 | (mac & MAC_MAX) as u16
    }
}

/// The numbers of the messages of group 2: the lowest three bits of the identifier.
pub mod group_2 {
    /// The master acknowledges a COS or cyclic message.
    pub const ACKNOWLEDGE: u16 = 2;
    /// An explicit response, or a response of the unconnected port.
    pub const RESPONSE: u16 = 3;
    /// An explicit request of the master.
    pub const REQUEST: u16 = 4;
    /// A poll command of the master.
    pub const POLL: u16 = 5;
    /// A request to the unconnected port (Group 2 Only).
    pub const UNCONNECTED: u16 = 6;
    /// A request or response of the duplicate MAC ID check.
    pub const DUPLICATE_CHECK: u16 = 7;
}

/// The identifier of a [message of group 2](group_2) of the slave with this MAC ID.
pub const fn group_2_id(mac: u8, message: u16) -> u16 {
    GROUP_2 | ((mac & MAC_MAX) as u16) << 3 | message & 7
}

/// The message of group 2 of the slave with this MAC ID. Another identifier gives a number above 7.
pub(super) const fn message_of(id: CanId, mac: u8) -> u32 {
    id.bits() ^ group_2_id(mac, 0) as u32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn identifiers_are_those_of_the_tables() {
        assert_eq!(Group1::ChangeOrCyclic.id(3), 0x343);
        assert_eq!(Group1::ChangeOrCyclic.id(63), 0x37F);
        assert_eq!(Group1::PollResponse.id(3), 0x3C3);
        assert_eq!(Group1::PollResponse.id(63), 0x3FF);
        let messages = [
            (group_2::ACKNOWLEDGE, 0x41A, 0x5FA),
            (group_2::RESPONSE, 0x41B, 0x5FB),
            (group_2::REQUEST, 0x41C, 0x5FC),
            (group_2::POLL, 0x41D, 0x5FD),
            (group_2::UNCONNECTED, 0x41E, 0x5FE),
            (group_2::DUPLICATE_CHECK, 0x41F, 0x5FF),
        ];
        for (message, id_of_3, id_of_63) in messages {
            assert_eq!(group_2_id(3, message), id_of_3);
            assert_eq!(group_2_id(63, message), id_of_63);
        }
    }

    #[test]
    fn message_is_found_only_for_own_mac_id_and_11_bits() {
        for mac in 0..=MAC_MAX {
            for id in 0..0x800 {
                let message = message_of(CanId::standard(id), mac);
                let own = id & 0x7F8 == group_2_id(mac, 0);
                assert_eq!(message < 8, own, "{id:X} {mac}");
                assert!(!own || message == u32::from(id & 7));
                assert!(message_of(CanId::extended(id.into()), mac) > 7);
            }
        }
    }
}
