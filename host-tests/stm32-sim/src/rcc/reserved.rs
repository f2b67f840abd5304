//! The reserved bits of the registers with many of them.

use crate::violation::Violations;

// Reserved on all STM32F103.
pub(super) const CFGR: u32 = 0xF880_0000;
pub(super) const APB1: u32 = 0xC501_3600;
pub(super) const APB2: u32 = 0xFFC7_0002;
pub(super) const AHB: u32 = 0xFFFF_FAA8;

/// The bits of a write that are not reserved; a reserved bit that is set is a violation.
pub(super) fn defined(
    register: &'static str,
    value: u32,
    reserved: u32,
    violations: &mut Violations,
) -> u32 {
    violations.check(value & reserved != 0, register, "reserved bits are written");
    value & !reserved
}
