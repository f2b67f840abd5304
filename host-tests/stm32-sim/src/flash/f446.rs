//! The flash interface of the STM32F446 (RM0390, chapter 3): programming by bytes, half-words or words, erasing by sectors.
//!
//! | offset | register | |
//! |---|---|---|
//! | 00h | FLASH_ACR | wait states, prefetch, caches |
//! | 04h | FLASH_KEYR | keys that unlock FLASH_CR |
//! | 08h | FLASH_OPTKEYR | keys that unlock the option bytes: accepted, option bytes are not modelled |
//! | 0Ch | FLASH_SR | BSY, PGSERR, PGPERR, PGAERR, EOP |
//! | 10h | FLASH_CR | PG, SER, SNB, PSIZE, STRT, LOCK |
//! | 14h | FLASH_OPTCR | option bytes: no protection, brown-out level 3 |
//!
//! In this model the processor is stalled for the complete operation, even if the chip could take its instructions from the instruction
//! cache.

use super::FlashInterface;
use super::control::{Bits, Control, ERASE, MASS_ERASE, PROGRAM};
use crate::io::{AccessError, Width};
use crate::timebase::Picoseconds;
use crate::violation::Violations;

// FLASH_ACR.
pub(super) const LATENCY: u32 = 0xF;
pub(super) const PREFETCH: u32 = 1 << 8;
const INSTRUCTION_CACHE: u32 = 1 << 9;
const DATA_CACHE: u32 = 1 << 10;
/// A cache's reset bit is two places above its enable bit.
const CACHE_RESET_SHIFT: u32 = 2;
const CACHES: u32 = INSTRUCTION_CACHE | DATA_CACHE;
const ACR_WRITABLE: u32 = LATENCY | PREFETCH | CACHES | CACHES << CACHE_RESET_SHIFT;

// FLASH_SR.
const END_OF_OPERATION: u32 = 1 << 0;
const PARALLELISM_ERROR: u32 = 1 << 6;
const SEQUENCE_ERROR: u32 = 1 << 7;
const ERRORS: u32 = 0x1F2;
const BUSY: u32 = 1 << 16;

// FLASH_CR.
const SECTOR: u32 = 0xF << 3;
const SIZE_SHIFT: u32 = 8;
const SIZE: u32 = 0b11 << SIZE_SHIFT;
const START: u32 = 1 << 16;
const INTERRUPTS: u32 = 1 << 24 | 1 << 25;
const LOCK: u32 = 1 << 31;
const WRITABLE: u32 = PROGRAM | ERASE | SECTOR | SIZE;

pub(super) const CONTROL: Control = Control {
    writable: WRITABLE,
    start: START,
    lock: LOCK,
    forbidden: &[
        (
            Bits::Any(!(WRITABLE | MASS_ERASE | START | INTERRUPTS | LOCK)),
            "changes reserved bits",
        ),
        (Bits::Any(INTERRUPTS), "interrupt not modelled"),
        (Bits::Any(MASS_ERASE), "mass erase"),
        (Bits::All(PROGRAM | ERASE), "PG and SER together"),
        (
            Bits::All(SIZE),
            "PSIZE: 64 bits need an external programming voltage",
        ),
    ],
    start_without_erase: "STRT without SER",
};

/// FLASH_OPTCR of a part without protection, locked, with brown-out level 3 as in the README. The value of a new part is 0FFFAAEDh.
const OPTION_CONTROL: u32 = 0x0FFF_AAE1;

/// The addresses of the sectors (RM0390, table 5).
const SECTORS: [u32; 8] = [
    0x0800_0000,
    0x0800_4000,
    0x0800_8000,
    0x0800_C000,
    0x0801_0000,
    0x0802_0000,
    0x0804_0000,
    0x0806_0000,
];

impl FlashInterface {
    /// Reads a register that is not the same on both chips.
    pub(super) fn read_f446(&self, offset: u32) -> Result<u32, AccessError> {
        let when = |on: bool, bits: u32| if on { bits } else { 0 };
        Ok(match offset {
            0x00 => self.acr,
            0x0C => self.errors | when(self.busy_until.is_some(), BUSY),
            0x14 => OPTION_CONTROL,
            _ => return Err(AccessError::Unmapped),
        })
    }

    /// Writes a register that is not the same on both chips.
    pub(super) fn write_f446(
        &mut self,
        offset: u32,
        value: u32,
        violations: &mut Violations,
    ) -> Result<(), AccessError> {
        match offset {
            0x00 => self.write_caches(value, violations),
            // EOP is never set, because its interrupt is not modelled.
            0x0C => self.errors &= !(value & (ERRORS | END_OF_OPERATION)),
            0x14 => violations.add("FLASH_OPTCR", "option bytes"),
            _ => return Err(AccessError::Unmapped),
        }
        Ok(())
    }

    /// Writes FLASH_ACR. A cache can be reset only while it is disabled.
    fn write_caches(&mut self, value: u32, violations: &mut Violations) {
        for enable in [INSTRUCTION_CACHE, DATA_CACHE] {
            violations.check(
                value & enable << CACHE_RESET_SHIFT != 0 && (value | self.acr) & enable != 0,
                "FLASH_ACR",
                "a cache is reset while it is enabled",
            );
        }
        self.acr = value & ACR_WRITABLE;
        if self.acr & DATA_CACHE << CACHE_RESET_SHIFT != 0 {
            self.stale = false;
        }
    }

    /// FLASH_CR.PSIZE: 0, 1, 2 for bytes, half-words, words.
    pub(super) fn parallelism_f446(&self) -> usize {
        ((self.cr & SIZE) >> SIZE_SHIFT).min(2) as usize
    }

    /// Erases the sector of FLASH_CR.SNB.
    pub(super) fn erase_f446(&mut self, now: Picoseconds, violations: &mut Violations) {
        let sector = (self.cr & SECTOR) >> 3;
        let address = SECTORS.get(sector as usize);
        if address.is_some_and(|address| self.erase_page(now, *address, violations)) {
            self.stale = self.acr & DATA_CACHE != 0;
        } else {
            violations.add("FLASH_CR", "a sector of the program is erased");
        }
    }

    /// A write of the processor to the flash memory. Errors are flags, not bus errors (RM0390, section 3.5).
    pub(super) fn program_f446(
        &mut self,
        now: Picoseconds,
        address: u32,
        width: Width,
        value: u32,
        violations: &mut Violations,
    ) {
        let place = || format!("flash {address:08X}h");
        if self.busy_until.is_some() {
            violations.add(place(), "written while the flash is busy");
            return;
        }
        if self.cr & PROGRAM == 0 {
            violations.add(place(), "written without FLASH_CR.PG");
            self.errors |= SEQUENCE_ERROR;
            return;
        }
        let units = [Width::Byte, Width::HalfWord, Width::Word];
        let unit = units[self.parallelism()];
        if width != unit {
            violations.add(
                place(),
                "written by another width than that of FLASH_CR.PSIZE",
            );
            self.errors |= PARALLELISM_ERROR;
            return;
        }
        let new = value.to_le_bytes();
        let changes = |(new, held): (&u8, &u8)| new & !held != 0;
        let has_risen = self.area(address).is_some_and(|(memory, at)| {
            let held = &memory.bytes()[at..at + width.bytes()];
            new.iter().zip(held).any(changes)
        });
        violations.check_at(has_risen, place, "a bit is programmed from 0 to 1");
        // `NotErased` is not possible, because this memory can be programmed again.
        let _ = self.program_unit(now, address, width, value, violations);
    }
}

#[cfg(test)]
mod tests;
