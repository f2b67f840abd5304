//! The flash memory interface (PM0075, chapters 2 and 3): keys, programming by half-words, erasing by pages. That of the STM32F446,
//! which programs by other units and erases by sectors, has other registers: `flash/f446.rs`.
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
//!
//! The two parameter pages are the bench's [`Flash`], with its fuse and faults. The pages of the program cannot be changed: an
//! attempt is a violation.

mod f446;

use super::chip::Chip;
use super::cortex_m::timing::FlashTiming;
use super::io::{AccessError, Width};
use super::pwr::{PROGRAMMING_MIN, Supply};
use super::timebase::{MICROSECOND, Picoseconds};
use super::violation::Violations;
use bench::{Flash, FlashError};

/// The times of the operations of a part.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Times {
    /// To program a half-word.
    pub program: Picoseconds,
    /// To erase a page.
    pub erase: Picoseconds,
}

impl Times {
    /// The shortest times (DS5319, flash memory characteristics).
    pub const SHORTEST: Self = Self::of(40_000_000, 20);
    /// The typical time to program, and the middle of the range to erase.
    pub const TYPICAL: Self = Self::of(52_500_000, 30);
    /// The longest times.
    pub const LONGEST: Self = Self::of(70_000_000, 40);

    /// Those of a usual part. On the STM32F446 (DS10693) PSIZE determines the time to erase; this one is for words.
    const fn typical(chip: Chip) -> Self {
        match chip {
            Chip::F103 => Self::TYPICAL,
            Chip::F446 => Self::of(16_000_000, 250),
        }
    }

    const fn of(program: Picoseconds, erase_ms: u64) -> Self {
        Self {
            program,
            erase: erase_ms * 1000 * MICROSECOND,
        }
    }
}

const KEY1: u32 = 0x4567_0123;
const KEY2: u32 = 0xCDEF_89AB;

// FLASH_ACR.
const LATENCY: u32 = 0b111;
const PREFETCH: u32 = 1 << 4;
const ACR_WRITABLE: u32 = LATENCY | 1 << 3 | PREFETCH;
/// PRFTBS has the value of PRFTBE.
const PREFETCH_STATUS_SHIFT: u32 = 1;

// FLASH_SR. WRPRTERR is never set, because no page is protected.
const BUSY: u32 = 1 << 0;
const PROGRAMMING_ERROR: u32 = 1 << 2;
const END_OF_OPERATION: u32 = 1 << 5;

// FLASH_CR.
const PROGRAM: u32 = 1 << 0;
const PAGE_ERASE: u32 = 1 << 1;
const MASS_ERASE: u32 = 1 << 2;
const OPTION_BYTES: u32 = 0b11 << 4;
const START: u32 = 1 << 6;
const LOCK: u32 = 1 << 7;
const OPTION_WRITE_ENABLE: u32 = 1 << 9;
const INTERRUPTS: u32 = 1 << 10 | 1 << 12;

/// FLASH_OBR and FLASH_WRPR of a part without protection.
const OPTION_BYTE_REGISTER: u32 = 0x03FF_FFFC;
const WRITE_PROTECTION_REGISTER: u32 = 0xFFFF_FFFF;

/// An operation of the flash. The machine changes the memory of the processor accordingly and stalls the processor, which fetches
/// its instructions from flash, for [`duration`](Self::duration).
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Work {
    /// Programs a unit.
    Program {
        /// The address.
        address: u32,
        /// The size of the unit.
        width: Width,
        /// The resulting content: worn-out bits stay 1.
        value: u32,
        /// The duration.
        duration: Picoseconds,
    },
    /// Erases a page or sector.
    Erase {
        /// Its first address.
        page: u32,
        /// Its size in bytes.
        size: usize,
        /// The duration.
        duration: Picoseconds,
    },
    /// An attempt that fails: the memory is faulty and does not change.
    Failed {
        /// The duration of the attempt.
        duration: Picoseconds,
    },
}

impl Work {
    /// The duration of the operation.
    pub fn duration(self) -> Picoseconds {
        match self {
            Self::Program { duration, .. }
            | Self::Erase { duration, .. }
            | Self::Failed { duration } => duration,
        }
    }
}

const LOCK_REASON: &str = "written while it is locked";

/// The state of the key sequence (PM0075, section 2.3.1).
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Keys {
    Locked,
    First,
    Unlocked,
    /// A wrong key: locked until the next reset.
    LockedUntilReset,
}

/// The flash interface and the parameter pages.
#[derive(Debug)]
pub struct FlashInterface {
    chip: Chip,
    parameters: Flash,
    acr: u32,
    cr: u32,
    ar: u32,
    errors: u32,
    ended: bool,
    /// The data cache of the STM32F446 can contain erased data.
    stale: bool,
    keys: Keys,
    busy_until: Option<Picoseconds>,
    work: Option<Work>,
    supply: Supply,
    times: Times,
}

impl FlashInterface {
    /// After power-on, with these parameter pages.
    ///
    /// # Panics
    /// When the memory is that of another microcontroller.
    pub fn new(chip: Chip, parameters: Flash) -> Self {
        let geometry = chip.facts().geometry;
        assert_eq!(parameters.geometry(), geometry, "the memory of the chip");
        Self {
            chip,
            parameters,
            acr: match chip {
                Chip::F103 => PREFETCH,
                Chip::F446 => 0,
            },
            cr: 0,
            ar: 0,
            errors: 0,
            ended: false,
            stale: false,
            keys: Keys::Locked,
            busy_until: None,
            work: None,
            supply: Supply::default(),
            times: Times::typical(chip),
        }
    }

    /// A reset; the memory stays.
    pub fn reset(&mut self) {
        let mut memory = Flash::blank(self.parameters.geometry());
        std::mem::swap(&mut memory, &mut self.parameters);
        *self = Self {
            times: self.times,
            ..Self::new(self.chip, memory)
        };
    }

    /// The parameter pages.
    pub fn parameters(&self) -> &Flash {
        &self.parameters
    }

    /// The parameter pages, to set their fuse and faults.
    pub fn parameters_mut(&mut self) -> &mut Flash {
        &mut self.parameters
    }

    /// True when the fuse of the parameter pages has blown: the machine switches the power off.
    pub fn power_is_cut(&self) -> bool {
        self.parameters.is_cut()
    }

    /// Sets the times of this part.
    pub fn set_times(&mut self, times: Times) {
        self.times = times;
    }

    /// True during an operation, at the time of the last access.
    pub fn is_busy(&self) -> bool {
        self.busy_until.is_some()
    }

    /// Sets the supply of the next operation.
    pub fn set_supply(&mut self, supply: Supply) {
        self.supply = supply;
    }

    /// An operation that needs this time begins now. If the supply becomes too low before its end, it is a violation, and the
    /// operation is cut off.
    fn check_supply(
        &mut self,
        now: Picoseconds,
        duration: Picoseconds,
        violations: &mut Violations,
    ) {
        if self.supply.lowest(now, now + duration) < PROGRAMMING_MIN {
            violations.add(
                "flash",
                "the supply is too low before the end of an operation",
            );
            self.parameters.cut_in_operation_after(0, now);
        }
    }

    /// The operation that the flash has started since the last call.
    pub fn take_work(&mut self) -> Option<Work> {
        self.work.take()
    }

    /// Wait states and prefetch buffer.
    pub fn timing(&self) -> FlashTiming {
        let (latency, prefetch) = match self.chip {
            Chip::F103 => (LATENCY, PREFETCH),
            Chip::F446 => (f446::LATENCY, f446::PREFETCH),
        };
        FlashTiming {
            wait_states: (self.acr & latency) as u8,
            prefetch: self.acr & prefetch != 0,
        }
    }

    /// Records a violation if there are fewer wait states than SYSCLK (in Hz) requires (PM0075, FLASH_ACR.LATENCY; RM0390, table 6,
    /// at 2.7 V and more).
    pub fn check_wait_states(&self, sysclk: u32, violations: &mut Violations) {
        let (step, field) = match self.chip {
            Chip::F103 => (24_000_000, LATENCY),
            Chip::F446 => (30_000_000, f446::LATENCY),
        };
        let needed = sysclk.div_ceil(step) - 1;
        violations.check(
            self.acr & field < needed,
            "FLASH_ACR",
            "too few wait states for this SYSCLK",
        );
    }

    /// Reads the register at `offset`.
    pub fn read(&mut self, now: Picoseconds, offset: u32) -> Result<u32, AccessError> {
        self.settle(now);
        if self.chip == Chip::F446 {
            return self.read_f446(offset);
        }
        let when = |on: bool, bits: u32| if on { bits } else { 0 };
        let busy = self.busy_until.is_some();
        Ok(match offset {
            0x00 => self.acr | (self.acr & PREFETCH) << PREFETCH_STATUS_SHIFT,
            // Write-only registers.
            0x04 | 0x08 => 0,
            0x0C => self.errors | when(busy, BUSY) | when(self.ended, END_OF_OPERATION),
            0x10 => self.cr | when(self.keys != Keys::Unlocked, LOCK),
            0x14 => self.ar,
            0x1C => OPTION_BYTE_REGISTER,
            0x20 => WRITE_PROTECTION_REGISTER,
            _ => return Err(AccessError::Unmapped),
        })
    }

    /// Writes the register at `offset`.
    pub fn write(
        &mut self,
        now: Picoseconds,
        offset: u32,
        value: u32,
        violations: &mut Violations,
    ) -> Result<(), AccessError> {
        self.settle(now);
        if self.chip == Chip::F446 {
            return self.write_f446(now, offset, value, violations);
        }
        match offset {
            0x00 => self.acr = value & ACR_WRITABLE,
            0x04 => return self.write_key(value, violations),
            0x08 => {}
            0x0C => {
                self.errors &= !value;
                self.ended &= value & END_OF_OPERATION == 0;
            }
            0x10 => self.write_cr(now, value, violations),
            0x14 if self.busy_until.is_some() => {
                violations.add("FLASH_AR", "written while the flash is busy");
            }
            0x14 => self.ar = value,
            0x1C | 0x20 => return Err(AccessError::Refused("FLASH_OBR, FLASH_WRPR: read-only")),
            _ => return Err(AccessError::Unmapped),
        }
        Ok(())
    }

    /// A write of the processor to the flash memory.
    pub fn program(
        &mut self,
        now: Picoseconds,
        address: u32,
        width: Width,
        value: u32,
        violations: &mut Violations,
    ) -> Result<(), AccessError> {
        self.settle(now);
        if self.chip == Chip::F446 {
            self.program_f446(now, address, width, value, violations);
            return Ok(());
        }
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
        if self.program_unit(now, address, width, value, self.times.program, violations)
            == Err(FlashError::NotErased)
        {
            self.errors |= PROGRAMMING_ERROR;
        }
        Ok(())
    }

    /// Programs a unit of the parameters and makes the flash busy, unless the memory does not permit it.
    fn program_unit(
        &mut self,
        now: Picoseconds,
        address: u32,
        width: Width,
        value: u32,
        duration: Picoseconds,
        violations: &mut Violations,
    ) -> Result<(), FlashError> {
        let Some(at) = self.offset_in_parameters(address) else {
            violations.add(
                format!("flash {address:08X}h"),
                "a page of the program is programmed",
            );
            return Ok(());
        };
        self.check_supply(now, duration, violations);
        let length = width.bytes();
        let value = &value.to_le_bytes()[..length];
        let result = self.parameters.program_unit(at, value);
        if result == Err(FlashError::NotErased) {
            return result;
        }
        let held = self.parameters.bytes()[at..at + length].iter().rev();
        let work = Work::Program {
            address,
            width,
            value: held.fold(0, |word, byte| word << 8 | u32::from(*byte)),
            duration,
        };
        self.begin(now, result, work);
        Ok(())
    }

    /// Erases the page of the parameters at an offset.
    fn erase_page(
        &mut self,
        now: Picoseconds,
        offset: usize,
        duration: Picoseconds,
        violations: &mut Violations,
    ) {
        self.check_supply(now, duration, violations);
        let size = self.parameters.geometry().page_size;
        let start = offset / size * size;
        let result = self.parameters.erase_page_at(start);
        let work = Work::Erase {
            page: self.chip.facts().parameters.start + start as u32,
            size,
            duration,
        };
        self.begin(now, result, work);
    }

    /// The offset of an address in the parameter pages.
    fn offset_in_parameters(&self, address: u32) -> Option<usize> {
        let parameters = &self.chip.facts().parameters;
        let offset = address.checked_sub(parameters.start)?;
        parameters.contains(&address).then_some(offset as usize)
    }

    fn write_key(&mut self, value: u32, violations: &mut Violations) -> Result<(), AccessError> {
        self.keys = match (self.keys, value) {
            (Keys::Locked, KEY1) => Keys::First,
            (Keys::First, KEY2) => Keys::Unlocked,
            (Keys::Unlocked, _) => {
                violations.add("FLASH_KEYR", "written while it is unlocked");
                Keys::Unlocked
            }
            _ => Keys::LockedUntilReset,
        };
        match self.keys {
            Keys::LockedUntilReset => Err(AccessError::Refused(
                "FLASH_KEYR: wrong key, locked until the next reset (bus error)",
            )),
            _ => Ok(()),
        }
    }

    fn write_cr(&mut self, now: Picoseconds, value: u32, violations: &mut Violations) {
        if self.keys != Keys::Unlocked {
            violations.add("FLASH_CR", LOCK_REASON);
            return;
        }
        if self.busy_until.is_some() {
            violations.add("FLASH_CR", "written while the flash is busy");
            return;
        }
        violations.check(
            value & (OPTION_BYTES | OPTION_WRITE_ENABLE | MASS_ERASE) != 0,
            "FLASH_CR",
            "option bytes or mass erase",
        );
        violations.check(
            value & INTERRUPTS != 0,
            "FLASH_CR",
            "interrupt not modelled",
        );
        violations.check(
            value & PROGRAM != 0 && value & PAGE_ERASE != 0,
            "FLASH_CR",
            "PG and PER together",
        );
        self.cr = value & (PROGRAM | PAGE_ERASE);
        if value & START != 0 {
            self.erase(now, violations);
        }
        if value & LOCK != 0 {
            self.keys = Keys::Locked;
        }
    }

    fn erase(&mut self, now: Picoseconds, violations: &mut Violations) {
        if self.cr & PAGE_ERASE == 0 {
            violations.add("FLASH_CR", "STRT without PER");
            return;
        }
        match self.offset_in_parameters(self.ar) {
            Some(offset) => self.erase_page(now, offset, self.times.erase, violations),
            None => violations.add("FLASH_AR", "a page of the program is erased"),
        }
    }

    /// Makes the flash busy from now on. Faulty memory reports no error.
    fn begin(&mut self, now: Picoseconds, result: Result<(), FlashError>, work: Work) {
        let work = match result {
            Ok(()) => work,
            Err(_) => Work::Failed {
                duration: work.duration(),
            },
        };
        self.work = Some(work);
        self.busy_until = Some(now + work.duration());
    }

    fn settle(&mut self, now: Picoseconds) {
        if self.busy_until.take_if(|end| *end <= now).is_some() {
            self.ended = true;
        }
    }
}

#[cfg(test)]
mod tests;
