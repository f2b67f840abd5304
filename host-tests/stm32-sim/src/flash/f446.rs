//! The flash interface of the STM32F446 (RM0390, chapter 3): programming by bytes, half-words or words, erasing by sectors.
//!
//! | offset | register | |
//! |---|---|---|
//! | 00h | FLASH_ACR | wait states, prefetch, caches |
//! | 04h | FLASH_KEYR | keys that unlock FLASH_CR |
//! | 08h | FLASH_OPTKEYR | keys that unlock the option bytes: accepted, option bytes are not modelled |
//! | 0Ch | FLASH_SR | BSY, PGSERR, PGPERR, PGAERR, EOP |
//! | 10h | FLASH_CR | PG, SER, SNB, PSIZE, STRT, LOCK |
//! | 14h | FLASH_OPTCR | option bytes of a new part: no protection |
//!
//! The processor is stalled for the whole operation, also where it could take its instructions from the instruction cache.

use super::{FlashInterface, Keys, LOCK_REASON};
use crate::io::{AccessError, Width};
use crate::timebase::{MICROSECOND, Picoseconds};
use crate::violation::Violations;

/// The time to program a unit (DS10693, flash memory programming: typical 16 us, at most 100 us).
const PROGRAM_TIME: Picoseconds = 16 * MICROSECOND;

/// The time to erase a sector of 16 KiB by bytes, half-words, words (DS10693: typical; at most twice as long).
const ERASE_TIMES: [Picoseconds; 3] = [
    400_000 * MICROSECOND,
    300_000 * MICROSECOND,
    250_000 * MICROSECOND,
];

// FLASH_ACR.
pub(super) const LATENCY: u32 = 0xF;
pub(super) const PREFETCH: u32 = 1 << 8;
const INSTRUCTION_CACHE: u32 = 1 << 9;
const DATA_CACHE: u32 = 1 << 10;
const INSTRUCTION_CACHE_RESET: u32 = 1 << 11;
const DATA_CACHE_RESET: u32 = 1 << 12;
const ACR_WRITABLE: u32 = LATENCY
    | PREFETCH
    | INSTRUCTION_CACHE
    | DATA_CACHE
    | INSTRUCTION_CACHE_RESET
    | DATA_CACHE_RESET;

// FLASH_SR.
const END_OF_OPERATION: u32 = 1 << 0;
const PARALLELISM_ERROR: u32 = 1 << 6;
const SEQUENCE_ERROR: u32 = 1 << 7;
const ERRORS: u32 = 0x1F2;
const BUSY: u32 = 1 << 16;

// FLASH_CR.
const PROGRAM: u32 = 1 << 0;
const SECTOR_ERASE: u32 = 1 << 1;
const MASS_ERASE: u32 = 1 << 2;
const SECTOR: u32 = 0xF << 3;
const SIZE: u32 = 0b11 << 8;
const START: u32 = 1 << 16;
const END_INTERRUPT: u32 = 1 << 24;
const ERROR_INTERRUPT: u32 = 1 << 25;
const LOCK: u32 = 1 << 31;
const KNOWN: u32 = PROGRAM
    | SECTOR_ERASE
    | MASS_ERASE
    | SECTOR
    | SIZE
    | START
    | END_INTERRUPT
    | ERROR_INTERRUPT
    | LOCK;

/// FLASH_OPTCR of a part without protection, locked.
const OPTION_CONTROL: u32 = 0x0FFF_AAED;

/// The size of sectors 0 to 3.
const SMALL_SECTOR: u32 = 16 * 1024;

impl FlashInterface {
    pub(super) fn read_f446(&self, offset: u32) -> Result<u32, AccessError> {
        let when = |on: bool, bits: u32| if on { bits } else { 0 };
        Ok(match offset {
            0x00 => self.acr,
            // Write-only registers.
            0x04 | 0x08 => 0,
            0x0C => self.errors | when(self.busy_until.is_some(), BUSY),
            0x10 => self.cr | when(self.keys != Keys::Unlocked, LOCK),
            0x14 => OPTION_CONTROL,
            _ => return Err(AccessError::Unmapped),
        })
    }

    pub(super) fn write_f446(
        &mut self,
        now: Picoseconds,
        offset: u32,
        value: u32,
        violations: &mut Violations,
    ) -> Result<(), AccessError> {
        match offset {
            0x00 => self.write_caches(value, violations),
            0x04 => {
                violations.check(
                    self.stale,
                    "FLASH_ACR",
                    "the data cache is not reset after an erase",
                );
                return self.write_key(value, violations);
            }
            0x08 => {}
            // EOP is never set, because its interrupt is not modelled.
            0x0C => self.errors &= !(value & (ERRORS | END_OF_OPERATION)),
            0x10 => self.write_cr_f446(now, value, violations),
            0x14 => {
                violations.add("FLASH_OPTCR", "option bytes");
            }
            _ => return Err(AccessError::Unmapped),
        }
        Ok(())
    }

    /// FLASH_ACR: a cache is reset while it is disabled.
    fn write_caches(&mut self, value: u32, violations: &mut Violations) {
        for (reset, enable) in [
            (INSTRUCTION_CACHE_RESET, INSTRUCTION_CACHE),
            (DATA_CACHE_RESET, DATA_CACHE),
        ] {
            violations.check(
                value & reset != 0 && (value | self.acr) & enable != 0,
                "FLASH_ACR",
                "a cache is reset while it is enabled",
            );
        }
        self.acr = value & ACR_WRITABLE;
        if self.acr & DATA_CACHE_RESET != 0 {
            self.stale = false;
        }
    }

    fn write_cr_f446(&mut self, now: Picoseconds, value: u32, violations: &mut Violations) {
        const NAME: &str = "FLASH_CR";
        if self.keys != Keys::Unlocked {
            violations.add(NAME, LOCK_REASON);
            return;
        }
        if self.busy_until.is_some() {
            violations.add(NAME, "written while the flash is busy");
            return;
        }
        violations.check(value & !KNOWN != 0, NAME, "changes reserved bits");
        violations.check(
            value & (END_INTERRUPT | ERROR_INTERRUPT) != 0,
            NAME,
            "interrupt not modelled",
        );
        violations.check(value & MASS_ERASE != 0, NAME, "mass erase");
        violations.check(
            value & PROGRAM != 0 && value & SECTOR_ERASE != 0,
            NAME,
            "PG and SER together",
        );
        violations.check(
            value & SIZE == SIZE,
            NAME,
            "PSIZE: 64 bits need an external programming voltage",
        );
        self.cr = value & (PROGRAM | SECTOR_ERASE | SECTOR | SIZE);
        if value & START != 0 {
            self.erase_sector(now, violations);
        }
        if value & LOCK != 0 {
            self.keys = Keys::Locked;
        }
    }

    fn erase_sector(&mut self, now: Picoseconds, violations: &mut Violations) {
        if self.cr & SECTOR_ERASE == 0 {
            violations.add("FLASH_CR", "STRT without SER");
            return;
        }
        let sector = (self.cr & SECTOR) >> 3;
        let address = 0x0800_0000 + sector * SMALL_SECTOR;
        // Sectors 2 and 3 are the parameters; the others are larger or contain the program.
        match self.offset_in_parameters(address) {
            Some(offset) => {
                let time = ERASE_TIMES[(self.cr >> 8 & 0b11).min(2) as usize];
                self.stale = self.acr & DATA_CACHE != 0;
                self.erase_page(now, offset, time, violations);
            }
            None => violations.add("FLASH_CR", "a sector of the program is erased"),
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
        let unit = match self.cr & SIZE {
            0x000 => Width::Byte,
            0x100 => Width::HalfWord,
            _ => Width::Word,
        };
        if width != unit {
            violations.add(
                place(),
                "written by another width than that of FLASH_CR.PSIZE",
            );
            self.errors |= PARALLELISM_ERROR;
            return;
        }
        let held = self.offset_in_parameters(address).map(|at| {
            let bytes = &self.parameters.bytes()[at..at + width.bytes()];
            let bytes = bytes.iter().rev();
            bytes.fold(0, |word, byte| word << 8 | u32::from(*byte))
        });
        violations.check_at(
            held.is_some_and(|held| value & !held != 0),
            place,
            "a bit is programmed from 0 to 1",
        );
        // Memory that can be programmed again reports no error here.
        let _ = self.program_unit(now, address, width, value, PROGRAM_TIME, violations);
    }
}

#[cfg(test)]
mod tests;
