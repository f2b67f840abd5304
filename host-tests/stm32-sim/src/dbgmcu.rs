//! Debug support (RM0008, section 31.16) for a program that runs without a debugger. Only the debugger can read DBGMCU_IDCODE and
//! DBGMCU_CR; a program reads 0 (errata ES0340, "Debug registers cannot be read by user software"). Writes have no effect either:
//! they only select what stops while a debugger halts the processor.

use super::io::AccessError;

/// The first address.
pub const BASE: u32 = 0xE004_2000;

/// Reads the register at `offset`.
pub fn read(offset: u32) -> Result<u32, AccessError> {
    match offset {
        0x00 | 0x04 => Ok(0),
        _ => Err(AccessError::Unmapped),
    }
}

/// Writes the register at `offset`.
pub fn write(offset: u32) -> Result<(), AccessError> {
    match offset {
        0x00 => Err(AccessError::Refused("DBGMCU_IDCODE is read-only")),
        0x04 => Ok(()),
        _ => Err(AccessError::Unmapped),
    }
}
