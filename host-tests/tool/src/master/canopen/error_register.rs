//! The error register (CiA 301, object 1001h).

use crate::sheet::Address;

/// The object with the error register.
pub const ADDRESS: Address = Address::Object {
    index: 0x1001,
    sub: 0,
};

/// The bits from bit 0.
const NAMES: [&str; 8] = [
    "generic error",
    "current",
    "voltage",
    "temperature",
    "communication error",
    "device profile error",
    "reserved bit 6",
    "manufacturer-specific error",
];

/// The names of the bits that are set.
pub fn names(register: u32) -> impl Iterator<Item = &'static str> {
    let bits = NAMES.into_iter().enumerate();
    bits.filter(move |(place, _)| register >> place & 1 != 0)
        .map(|(_, name)| name)
}
