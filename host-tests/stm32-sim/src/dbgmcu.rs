//! Debug support (RM0008, section 31.16): what stops while a debugger halts the processor.
//!
//! Only the debugger can read DBGMCU_IDCODE and DBGMCU_CR; a program reads 0 (errata ES0340, "Debug registers cannot be read by user
//! software"). A power-on reset clears DBGMCU_CR, a system reset does not.

use super::io::AccessError;

/// The first address.
pub const BASE: u32 = 0xE004_2000;

// DBGMCU_CR.
const WATCHDOG_STOPS: u32 = 1 << 8;
const TIM3_STOPS: u32 = 1 << 12;

/// DBGMCU_CR.
#[derive(Clone, Copy, Debug, Default)]
pub struct Dbgmcu {
    control: u32,
}

impl Dbgmcu {
    /// True if the watchdog stops while the processor is halted.
    pub fn stops_watchdog(&self) -> bool {
        self.control & WATCHDOG_STOPS != 0
    }

    /// True if TIM3 stops while the processor is halted, and its outputs are disabled.
    pub fn stops_tim3(&self) -> bool {
        self.control & TIM3_STOPS != 0
    }

    /// Reads the register at `offset`.
    pub fn read(&self, offset: u32) -> Result<u32, AccessError> {
        match offset {
            0x00 | 0x04 => Ok(0),
            _ => Err(AccessError::Unmapped),
        }
    }

    /// Writes the register at `offset`.
    pub fn write(&mut self, offset: u32, value: u32) -> Result<(), AccessError> {
        match offset {
            0x00 => Err(AccessError::Refused("DBGMCU_IDCODE is read-only")),
            0x04 => {
                self.control = value;
                Ok(())
            }
            _ => Err(AccessError::Unmapped),
        }
    }
}
