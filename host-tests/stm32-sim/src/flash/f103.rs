//! The flash interface of the STM32F103 (PM0075, chapters 2 and 3): programming by half-words, erasing by pages.
//!
//! | offset | register | |
//! |---|---|---|
//! | 00h | FLASH_ACR | wait states, prefetch buffer |
//! | 04h | FLASH_KEYR | keys that unlock FLASH_CR |
//! | 08h | FLASH_OPTKEYR | keys that unlock the option bytes: accepted, option bytes are not modelled |
//! | 0Ch | FLASH_SR | BSY, PGERR, WRPRTERR, EOP |
//! | 10h | FLASH_CR | PG, PER, MER, STRT, LOCK |
//! | 14h | FLASH_AR | address of the page to erase |
//! | 1Ch, 20h | FLASH_OBR, FLASH_WRPR | option bytes of a new part: no protection |

use super::FlashInterface;
use super::control::{Bits, Control, ERASE, MASS_ERASE, PROGRAM};
use crate::io::{AccessError, Width};
use crate::timebase::Picoseconds;
use crate::violation::Violations;
use bench::FlashError;

// FLASH_ACR.
pub(super) const LATENCY: u32 = 0b111;
pub(super) const PREFETCH: u32 = 1 << 4;
const ACR_WRITABLE: u32 = LATENCY | 1 << 3 | PREFETCH;
/// PRFTBS has the value of PRFTBE.
const PREFETCH_STATUS_SHIFT: u32 = 1;

// FLASH_SR.
const BUSY: u32 = 1 << 0;
const PROGRAMMING_ERROR: u32 = 1 << 2;
const END_OF_OPERATION: u32 = 1 << 5;

// FLASH_CR.
const OPTION_BYTES: u32 = 0b11 << 4;
const START: u32 = 1 << 6;
const LOCK: u32 = 1 << 7;
const OPTION_WRITE_ENABLE: u32 = 1 << 9;
const INTERRUPTS: u32 = 1 << 10 | 1 << 12;

pub(super) const CONTROL: Control = Control {
    writable: PROGRAM | ERASE,
    start: START,
    lock: LOCK,
    forbidden: &[
        (
            Bits::Any(OPTION_BYTES | OPTION_WRITE_ENABLE | MASS_ERASE),
            "option bytes or mass erase",
        ),
        (Bits::Any(INTERRUPTS), "interrupt not modelled"),
        (Bits::All(PROGRAM | ERASE), "PG and PER together"),
    ],
    start_without_erase: "STRT without PER",
};

/// FLASH_OBR and FLASH_WRPR of a part without protection.
const OPTION_BYTE_REGISTER: u32 = 0x03FF_FFFC;
const WRITE_PROTECTION_REGISTER: u32 = 0xFFFF_FFFF;

impl FlashInterface {
    /// Reads a register that is not the same on both chips.
    pub(super) fn read_f103(&self, offset: u32) -> Result<u32, AccessError> {
        let when = |on: bool, bits: u32| if on { bits } else { 0 };
        let busy = self.busy_until.is_some();
        Ok(match offset {
            0x00 => self.acr | (self.acr & PREFETCH) << PREFETCH_STATUS_SHIFT,
            0x0C => self.errors | when(busy, BUSY) | when(self.ended, END_OF_OPERATION),
            0x14 => self.ar,
            0x1C => OPTION_BYTE_REGISTER,
            0x20 => WRITE_PROTECTION_REGISTER,
            _ => return Err(AccessError::Unmapped),
        })
    }

    /// Writes a register that is not the same on both chips.
    pub(super) fn write_f103(
        &mut self,
        offset: u32,
        value: u32,
        violations: &mut Violations,
    ) -> Result<(), AccessError> {
        match offset {
            0x00 => self.acr = value & ACR_WRITABLE,
            0x0C => {
                self.errors &= !value;
                self.ended &= value & END_OF_OPERATION == 0;
            }
            0x14 if self.busy_until.is_some() => {
                violations.add("FLASH_AR", "written while the flash is busy");
            }
            0x14 => self.ar = value,
            0x1C | 0x20 => return Err(AccessError::Refused("FLASH_OBR, FLASH_WRPR: read-only")),
            _ => return Err(AccessError::Unmapped),
        }
        Ok(())
    }

    /// A write of the processor to the flash memory. Errors of the sequence are bus errors.
    pub(super) fn program_f103(
        &mut self,
        now: Picoseconds,
        address: u32,
        width: Width,
        value: u32,
        violations: &mut Violations,
    ) -> Result<(), AccessError> {
        if width != Width::HalfWord || !address.is_multiple_of(2) {
            return Err(AccessError::Refused(
                "flash: can be programmed by half-words only (bus error)",
            ));
        }
        if self.cr & PROGRAM == 0 {
            return Err(AccessError::Refused("flash: written without FLASH_CR.PG"));
        }
        if self.busy_until.is_some() {
            return Err(AccessError::Refused("flash: written while it is busy"));
        }
        if self.program_unit(now, address, width, value, violations) == Err(FlashError::NotErased) {
            self.errors |= PROGRAMMING_ERROR;
        }
        Ok(())
    }

    /// Erases the page at FLASH_AR.
    pub(super) fn erase_f103(&mut self, now: Picoseconds, violations: &mut Violations) {
        let is_erased = self.erase_page(now, self.ar, violations);
        violations.check(!is_erased, "FLASH_AR", "a page of the program is erased");
    }
}

#[cfg(test)]
mod tests;
