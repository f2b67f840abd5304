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

/// Bit 29 of a COB-ID: the identifier has 29 bits.
pub const BIT_29: u32 = 1 << 29;
/// Bits 31 to 29: the flags.
const FLAGS: u32 = DISABLED | BIT_30 | BIT_29;
/// A bit that no 11-bit identifier has. In the stored form of a COB-ID: the identifier is not the default.
const OWN: u32 = 1 << 11;

/// The COB-ID on the bus for its stored form, which is `base` of [`stored`], or the identifier with a mark.
pub(super) const fn on_bus(stored: u32, node_id: u8) -> u32 {
    if stored & (OWN | BIT_29) == 0 {
        stored + node_id as u32
    } else if stored & BIT_29 == 0 {
        stored & !OWN
    } else {
        stored
    }
}

/// The stored form of a COB-ID: its default is `base` plus the node-ID and follows the node-ID. Another identifier stays.
pub(super) const fn stored(cob_id: u32, base: u32, node_id: u8) -> u32 {
    let base = base & !FLAGS;
    if cob_id & !(FLAGS & !BIT_29) == base + node_id as u32 {
        cob_id & FLAGS | base
    } else if cob_id & BIT_29 == 0 {
        cob_id | OWN
    } else {
        cob_id
    }
}

/// Whether a COB-ID can be that of a TPDO: 11 bits, and free unless the TPDO is disabled.
pub const fn fits_tpdo(cob_id: u32) -> bool {
    cob_id & !(DISABLED | BIT_30) < 0x800 && (cob_id & DISABLED != 0 || PDO.contain(cob_id))
}

/// Whether a COB-ID can be that of the EMCY: without bit 30, and free unless the EMCY is disabled or its identifier has 29 bits.
pub const fn fits_emergency(cob_id: u32) -> bool {
    if cob_id & BIT_29 == 0 {
        cob_id & BIT_30 == 0 && fits_tpdo(cob_id)
    } else {
        cob_id & BIT_30 == 0
    }
}

/// Whether two COB-IDs of one service have the same identifier.
pub(super) const fn is_same(one: u32, other: u32) -> bool {
    (one ^ other) & !(DISABLED | BIT_30) == 0
}

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
    fn default_cob_id_follows_node_id_and_other_one_stays() {
        for flags in [0, DISABLED, BIT_30, DISABLED | BIT_30] {
            let form = stored(flags | 0x2B2, 0x8000_0280, 50);
            assert_eq!(form, flags | 0x280);
            assert_eq!(on_bus(form, 7), flags | 0x287);
            for id in [0x000, 0x1B2, 0x280, 0x7FF] {
                let form = stored(flags | id, 0x8000_0280, 50);
                assert_eq!(on_bus(form, 7), flags | id, "{id:03X}h");
            }
        }
        for id in [0, 0xB2, 0x800, 0x1FFF_FFFF] {
            let form = stored(BIT_29 | id, 0x80, 50);
            assert_eq!(on_bus(form, 7), BIT_29 | id, "{id:08X}h");
        }
    }

    #[test]
    fn tpdo_has_free_identifier_of_11_bits() {
        assert!(fits_tpdo(0x1B2) && fits_tpdo(BIT_30 | 0x1B2));
        assert!(!fits_tpdo(0x180) && fits_tpdo(DISABLED | 0x180));
        assert!(!fits_tpdo(DISABLED | BIT_29 | 0x1B2) && !fits_tpdo(DISABLED | 0x800));
    }

    #[test]
    fn emergency_has_free_identifier_of_11_or_any_of_29_bits() {
        assert!(fits_emergency(0xB2) && fits_emergency(BIT_29));
        assert!(!fits_emergency(0x80) && fits_emergency(DISABLED | 0x80));
        assert!(!fits_emergency(BIT_30 | 0xB2) && !fits_emergency(BIT_29 | BIT_30));
        assert!(!fits_emergency(DISABLED | 0x800));
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
