//! The identifiers of the CANopen services (CiA 301, 7.3.3 and 7.3.5), and the flags of a COB-ID.
//!
//! ```text
//!  NMT        000h        command, node-ID
//!  SYNC       080h        (counter)
//!  EMCY       080h + id   error code (2), error register, manufacturer's field (5)
//!  TPDO       180h + id   mapped objects in order
//!  SDO        580h + id   server to client;  600h + id client to server
//!  guarding   700h + id   state (remote frame: request); boot-up is state 0
//!  LSS        7E4h        node to master;  7E5h master to node (CiA 305)
//! ```

use crate::param::Ranges;

/// The identifier of NMT commands.
pub const NMT: u16 = 0x000;
/// The identifier of emergency messages, for node 0.
pub const EMCY: u16 = 0x080;
/// The identifier of the SYNC of a product without 1005h.
pub const SYNC_DEFAULT: u16 = 0x080;
/// The identifier of SDO replies, for node 0.
pub const SDO_REPLY: u16 = 0x580;
/// The identifier of SDO requests, for node 0.
pub const SDO_REQUEST: u16 = 0x600;
/// The identifier of boot-up, heartbeat and guarding, for node 0.
pub const ERROR_CONTROL: u16 = 0x700;
/// The identifier of LSS answers.
pub const LSS_REPLY: u16 = 0x7E4;
/// The identifier of LSS requests.
pub const LSS_REQUEST: u16 = 0x7E5;

/// Bit 31 of the COB-ID of a PDO or EMCY: the service is disabled.
pub const DISABLED: u32 = 1 << 31;
/// Bit 30 of the COB-ID of a TPDO: the TPDO does not answer remote frames. Bit 30 of the COB-ID of the SYNC: the device is the
/// SYNC producer.
pub const BIT_30: u32 = 1 << 30;

/// The permitted identifiers of a SYNC: those that are not restricted by CiA 301, table 81. Bit 31 has no meaning. Bit 30 (SYNC
/// producer) and bit 29 (29-bit format) must be 0.
pub const SYNC: Ranges = Ranges {
    text: "11-bit identifier that is free",
    ignored_bits: 1,
    ranges: &[
        (0x080, 0x100),
        (0x181, 0x580),
        (0x600, 0x600),
        (0x680, 0x6DF),
        (0x700, 0x700),
    ],
};

/// The permitted identifiers of a PDO or EMCY: those of [`SYNC`] except 080h. Bits 31 and 30 are flags.
pub const PDO: Ranges = Ranges {
    text: "11-bit identifier that is free",
    ignored_bits: 2,
    ranges: &[
        (0x081, 0x100),
        (0x181, 0x580),
        (0x600, 0x600),
        (0x680, 0x6DF),
        (0x700, 0x700),
    ],
};

/// The 11-bit identifier of a COB-ID; None if the service is disabled, or if the identifier is not permitted for a PDO or EMCY.
pub const fn in_use(cob_id: u32) -> Option<u16> {
    if cob_id & DISABLED == 0 && PDO.contain(cob_id) {
        Some((cob_id & 0x7FF) as u16)
    } else {
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn in_use_below_081h_is_none() {
        for id in 0..0x081 {
            assert_eq!(in_use(id), None, "{id:03X}h");
        }
        assert_eq!(in_use(0x081), Some(0x081));
        assert_eq!(in_use(0x18A), Some(0x18A));
        assert_eq!(in_use(0x18A | BIT_30), Some(0x18A));
        assert_eq!(in_use(0x18A | DISABLED), None);
    }

    #[test]
    fn identifiers_of_fixed_services_are_not_free() {
        for id in [
            0x000, 0x001, 0x07F, 0x101, 0x180, 0x581, 0x5FF, 0x601, 0x67F,
        ] {
            assert!(!PDO.contain(id) && !SYNC.contain(id), "{id:03X}h");
        }
        for id in [0x6E0, 0x6FF, 0x701, 0x7FF, 0x800, 1 << 29 | 0x18A] {
            assert!(!PDO.contain(id) && !SYNC.contain(id), "{id:03X}h");
        }
        assert!(SYNC.contain(0x080) && !PDO.contain(0x080));
        assert!(SYNC.contain(DISABLED | 0x080) && !SYNC.contain(BIT_30 | 0x080));
    }
}
