//! The NAME of a node (SAE J1939-81, 4.1.1).
//!
//! ```text
//!  bit 63   62..60   59..56    55..49    48       47..40     39..35     34..32     31..21         20..0
//!     +-----+--------+---------+---------+--------+----------+----------+----------+--------------+----------+
//!     | AAC | group  | system  | vehicle | 0      | function | function | ECU      | manufacturer | identity |
//!     |     |        | instance| system  |        |          | instance | instance | code         | number   |
//!     +-----+--------+---------+---------+--------+----------+----------+----------+--------------+----------+
//! ```
//!
//! AAC is arbitrary address capable. In a frame the least significant byte is first. The numerically lower NAME has priority.

use crate::param::Setting;

/// The NAME of a node, 64 bits.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub struct Name(pub u64);

/// The arbitrary address capable bit.
const ARBITRARY: u64 = 1 << 63;

/// The number of bits of the identity number.
const IDENTITY: u32 = 21;

/// The place and the number of bits of each field of [`Name::new`].
pub(super) const FIELDS: [(u32, u32); 8] = [
    (63, 1),
    (60, 3),
    (56, 4),
    (49, 7),
    (40, 8),
    (35, 5),
    (32, 3),
    (21, 11),
];

impl Name {
    /// The NAME with these fields: arbitrary address capable, industry group, vehicle system instance, vehicle system, function,
    /// function instance, ECU instance, manufacturer code. Surplus bits are ignored. The identity number is that of a serial
    /// number.
    pub fn new(fields: [u32; 8], serial: u32) -> Self {
        let mut name = u64::from(identity_number(serial));
        for (field, (place, bits)) in fields.into_iter().zip(FIELDS) {
            let mask = (1 << bits) - 1;
            name |= u64::from(field & mask) << place;
        }
        Self(name)
    }

    /// The NAME in the eight bytes of a frame.
    pub const fn from_bytes(bytes: [u8; 8]) -> Self {
        Self(u64::from_le_bytes(bytes))
    }

    /// The eight bytes in a frame.
    pub const fn to_bytes(self) -> [u8; 8] {
        self.0.to_le_bytes()
    }

    /// Whether the node takes another address if it loses one.
    pub const fn is_arbitrary(self) -> bool {
        self.0 & ARBITRARY != 0
    }
}

/// Constant fields of a NAME, in the order of [`Name::new`].
pub const fn constants(fields: [u32; 8]) -> [Setting; 8] {
    let [a, b, c, d, e, f, g, h] = fields;
    [
        Setting::Constant(a),
        Setting::Constant(b),
        Setting::Constant(c),
        Setting::Constant(d),
        Setting::Constant(e),
        Setting::Constant(f),
        Setting::Constant(g),
        Setting::Constant(h),
    ]
}

/// The identity number of a device: the low 21 bits of its serial number.
pub const fn identity_number(serial: u32) -> u32 {
    serial & ((1 << IDENTITY) - 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn name_has_its_fields_at_their_bits() {
        let name = Name::new([1, 0, 0, 0, 145, 0, 0, 2047], 1);
        let bytes = [0x01, 0x00, 0xE0, 0xFF, 0x00, 0x91, 0x00, 0x80];
        assert_eq!(name.to_bytes(), bytes);
        assert_eq!(Name::from_bytes(bytes), name);
        // Each field with its highest value, one after the other.
        let highest = [1, 7, 15, 127, 255, 31, 7, 2047];
        for (place, value) in highest.into_iter().enumerate() {
            let mut fields = [0; 8];
            fields[place] = value;
            let (low, bits) = FIELDS[place];
            let expected = ((1_u64 << bits) - 1) << low;
            assert_eq!(Name::new(fields, 0).0, expected);
        }
        let all = Name::new(highest, u32::MAX).0;
        assert_eq!(!all, 1 << 48, "the reserved bit");
    }

    #[test]
    fn identity_number_has_21_bits() {
        assert_eq!(identity_number(0x0403_0201), 0x0003_0201);
        assert_eq!(Name::new([0; 8], 0xFFFF_FFFF).0, 0x001F_FFFF);
    }

    #[test]
    fn arbitrary_address_capable_name_loses_to_one_with_a_fixed_address() {
        let arbitrary = Name::new([1, 0, 0, 0, 0, 0, 0, 0], 1);
        let fixed = Name::new([0, 7, 15, 127, 255, 31, 7, 2047], 2);
        assert!(fixed < arbitrary);
        assert!(arbitrary.is_arbitrary() && !fixed.is_arbitrary());
    }
}
