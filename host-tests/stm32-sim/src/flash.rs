//! The flash memory interface with the parameter pages. The registers are those of the chip: `f103.rs`, `f446.rs`.
//!
//! The two parameter pages are the bench's [`Flash`], with its fuse and faults, and also the pages that a bootloader can change, if the
//! image has one. The other pages of the program cannot be changed: an attempt is a violation.

mod control;
mod f103;
mod f446;
mod operation;

use super::board::Board;
use super::chip::Chip;
use super::cortex_m::timing::FlashTiming;
use super::io::{AccessError, Width};
use super::pwr::Supply;
use super::silicon::Silicon;
use super::timebase::Picoseconds;
use super::violation::Violations;
use bench::{Flash, FlashError, Geometry};
use control::Keys;
pub use operation::{Times, Work};

// The registers that both chips have in common, by their offset.
const KEYR: u32 = 0x04;
const OPTKEYR: u32 = 0x08;
const SR: u32 = 0x0C;
const CR: u32 = 0x10;

/// WRPRTERR of FLASH_SR (STM32F446: WRPERR).
const PROTECTION_ERROR: u32 = 1 << 4;

/// The flash interface and the parameter pages.
#[derive(Debug)]
pub struct FlashInterface {
    board: Board,
    chip: Chip,
    parameters: Flash,
    /// The pages that a bootloader can change.
    slot: Option<Flash>,
    acr: u32,
    cr: u32,
    ar: u32,
    errors: u32,
    ended: bool,
    /// The data cache of the STM32F446 can contain data from before an erase.
    stale: bool,
    keys: Keys,
    busy_until: Option<Picoseconds>,
    /// No barrier has followed the store that has started the last operation.
    unfenced: bool,
    work: Option<Work>,
    supply: Supply,
    /// The supply in mV below which the microcontroller is reset.
    reset_level: u32,
    times: Times,
    /// Whether FLASH_CR.LOCK can be read; on some clones it reads 0.
    lock_reads: bool,
    /// The memory has the wait states of FLASH_ACR.
    waits: bool,
    /// The option bytes protect the parameter pages against writes.
    protected: bool,
}

impl FlashInterface {
    /// After power-on, with these parameter pages.
    ///
    /// # Panics
    /// When the memory is that of another microcontroller.
    pub fn new(board: Board, parameters: Flash) -> Self {
        let chip = board.chip();
        let geometry = chip.facts().geometry;
        assert_eq!(parameters.geometry(), geometry, "the memory of the chip");
        Self {
            board,
            chip,
            parameters,
            slot: None,
            acr: match chip {
                Chip::F103 => f103::PREFETCH,
                Chip::F446 => 0,
            },
            cr: 0,
            ar: 0,
            errors: 0,
            ended: false,
            stale: false,
            keys: Keys::Locked,
            busy_until: None,
            unfenced: false,
            work: None,
            supply: Supply::default(),
            reset_level: 0,
            times: Times::typical(chip),
            lock_reads: true,
            waits: true,
            protected: false,
        }
    }

    /// Selects the behaviour in which chips differ.
    pub fn set_silicon(&mut self, silicon: &Silicon) {
        (self.lock_reads, self.waits) = (silicon.lock_reads, silicon.waits);
    }

    /// A reset; the memory stays.
    pub fn reset(&mut self) {
        let mut memory = Flash::blank(self.parameters.geometry());
        std::mem::swap(&mut memory, &mut self.parameters);
        *self = Self {
            slot: self.slot.take(),
            times: self.times,
            lock_reads: self.lock_reads,
            waits: self.waits,
            protected: self.protected,
            ..Self::new(self.board, memory)
        };
    }

    /// Sets or clears the write protection of the parameter pages in the option bytes.
    pub fn protect_parameters(&mut self, protected: bool) {
        self.protected = protected;
    }

    /// Refuses an operation on a protected page (PM0075, 2.4.2; RM0390, 3.6.4): it has no effect but its error flag.
    fn is_refused(&mut self, address: u32) -> bool {
        let refused = self.protected && self.board.facts().parameters.contains(&address);
        if refused {
            self.errors |= PROTECTION_ERROR;
        }
        refused
    }

    /// The memory with the records of the firmware.
    pub fn parameters(&self) -> &Flash {
        &self.parameters
    }

    /// The parameter pages, to set their fuse and faults.
    pub fn parameters_mut(&mut self) -> &mut Flash {
        &mut self.parameters
    }

    /// From now on a bootloader can change the pages of its program and of its record, which have this content.
    ///
    /// # Panics
    /// When the content is not that of whole pages.
    pub fn open_slot(&mut self, content: Vec<u8>) {
        let page_size = self.chip.facts().slot_page;
        let geometry = Geometry {
            pages: content.len() / page_size,
            page_size,
            ..self.parameters.geometry()
        };
        self.slot = Some(Flash::with_content(geometry, content));
    }

    /// The pages that a bootloader can change.
    pub fn slot(&self) -> Option<&Flash> {
        self.slot.as_ref()
    }

    /// The pages that a bootloader can change, to set their fuse and faults.
    pub fn slot_mut(&mut self) -> Option<&mut Flash> {
        self.slot.as_mut()
    }

    /// True when the fuse of some pages has blown: the machine switches the power off.
    pub fn power_is_cut(&self) -> bool {
        self.parameters.is_cut() || self.slot.as_ref().is_some_and(Flash::is_cut)
    }

    /// Sets the times of this part.
    pub fn set_times(&mut self, times: Times) {
        self.times = times;
    }

    /// True during an operation, at the time of the last access.
    pub fn is_busy(&self) -> bool {
        self.busy_until.is_some()
    }

    /// The processor executes a barrier.
    pub fn barrier(&mut self) {
        self.unfenced = false;
    }

    /// Sets the supply of the next operation, and the voltage in mV below which the microcontroller is reset.
    pub fn set_supply(&mut self, supply: Supply, reset_level: u32) {
        (self.supply, self.reset_level) = (supply, reset_level);
    }

    /// Checks the supply for an operation that begins now and takes this time. If the supply falls below the limit for the width of the
    /// operation, or below the level of the reset, before the operation ends, this is a violation, and the operation is cut off.
    fn check_supply(
        &mut self,
        now: Picoseconds,
        duration: Picoseconds,
        violations: &mut Violations,
    ) {
        let limit = self.chip.facts().supply.programming[self.parallelism()];
        if self.supply.lowest(now, now + duration) < limit.max(self.reset_level) {
            let reason = if self.supply.at(now) < limit {
                "the supply is too low for an operation of this width"
            } else {
                "the supply is too low before the end of an operation"
            };
            violations.add("flash", reason);
            self.parameters.cut_in_operation_after(0, now);
            if let Some(slot) = &mut self.slot {
                slot.cut_in_operation_after(0, now);
            }
        }
    }

    /// The operation that the flash has started since the last call.
    pub fn take_work(&mut self) -> Option<Work> {
        self.work.take()
    }

    /// Wait states and prefetch buffer.
    pub fn timing(&self) -> FlashTiming {
        let (latency, prefetch) = match self.chip {
            Chip::F103 => (f103::LATENCY, f103::PREFETCH),
            Chip::F446 => (f446::LATENCY, f446::PREFETCH),
        };
        FlashTiming {
            wait_states: if self.waits {
                (self.acr & latency) as u8
            } else {
                0
            },
            prefetch: self.acr & prefetch != 0,
        }
    }

    /// Records a violation if there are fewer wait states than SYSCLK (in Hz) requires (PM0075, FLASH_ACR.LATENCY; RM0390, table 6,
    /// at 2.7 V and more).
    pub fn check_wait_states(&self, sysclk: u32, violations: &mut Violations) {
        let (step, field) = match self.chip {
            Chip::F103 => (24_000_000, f103::LATENCY),
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
    pub fn read(
        &mut self,
        now: Picoseconds,
        offset: u32,
        violations: &mut Violations,
    ) -> Result<u32, AccessError> {
        self.settle(now);
        // ES096: BSY is set one cycle after the store, which can still be in the write buffer.
        violations.check(
            offset == SR && std::mem::take(&mut self.unfenced),
            "FLASH_SR",
            "read without a barrier after the store that starts an operation: BSY may not be set yet",
        );
        match (offset, self.chip) {
            // Write-only registers.
            (KEYR | OPTKEYR, _) => Ok(0),
            (CR, _) => Ok(self.read_cr()),
            (_, Chip::F103) => self.read_f103(offset),
            (_, Chip::F446) => self.read_f446(offset),
        }
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
        match (offset, self.chip) {
            (KEYR, _) => return self.write_key(value, violations),
            (OPTKEYR, _) => {}
            (CR, _) => self.write_cr(now, value, violations),
            (_, Chip::F103) => return self.write_f103(offset, value, violations),
            (_, Chip::F446) => return self.write_f446(offset, value, violations),
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
        match self.chip {
            Chip::F103 => self.program_f103(now, address, width, value, violations),
            Chip::F446 => {
                self.program_f446(now, address, width, value, violations);
                Ok(())
            }
        }
    }

    /// Programs a unit of the parameters and makes the flash busy, unless the memory does not permit it.
    fn program_unit(
        &mut self,
        now: Picoseconds,
        address: u32,
        width: Width,
        value: u32,
        violations: &mut Violations,
    ) -> Result<(), FlashError> {
        if self.area(address).is_none() {
            violations.add(
                format!("flash {address:08X}h"),
                "a page of the program is programmed",
            );
            return Ok(());
        }
        if self.is_refused(address) {
            return Ok(());
        }
        let duration = self.times.program;
        self.check_supply(now, duration, violations);
        let Some((memory, at)) = self.area(address) else {
            return Ok(());
        };
        let value = &value.to_le_bytes()[..width.bytes()];
        let result = memory.program_unit(at, value);
        if result == Err(FlashError::NotErased) {
            return result;
        }
        let held = memory.bytes()[at..at + width.bytes()].iter().rev();
        let work = Work::Program {
            address,
            width,
            value: held.fold(0, |word, byte| word << 8 | u32::from(*byte)),
            duration,
        };
        self.begin(now, result, work);
        Ok(())
    }

    /// Erases the page at an address. False if it cannot be changed.
    fn erase_page(&mut self, now: Picoseconds, address: u32, violations: &mut Violations) -> bool {
        if self.area(address).is_none() {
            return false;
        }
        if self.is_refused(address) {
            return true;
        }
        let times = match self.board.facts().parameters.contains(&address) {
            true => self.times.erase,
            false => self.times.erase_of_slot,
        };
        let duration = times[self.parallelism()];
        self.check_supply(now, duration, violations);
        let Some((memory, at)) = self.area(address) else {
            return false;
        };
        let size = memory.geometry().page_size;
        let place = at % size;
        let result = memory.erase_page_at(at - place);
        let work = Work::Erase {
            page: address - place as u32,
            size,
            duration,
        };
        self.begin(now, result, work);
        true
    }

    /// The pages that contain an address and can be changed, and its offset in them.
    fn area(&mut self, address: u32) -> Option<(&mut Flash, usize)> {
        let facts = self.board.facts();
        let parameters = (Some(&mut self.parameters), facts.parameters.clone());
        let slot = (self.slot.as_mut(), facts.slot.clone());
        let areas = [parameters, slot].into_iter();
        let mut areas = areas.filter(|(_, range)| range.contains(&address));
        areas.find_map(|(memory, range)| Some((memory?, (address - range.start) as usize)))
    }

    /// The width of an operation: 0, 1, 2 for bytes, half-words, words.
    fn parallelism(&self) -> usize {
        match self.chip {
            Chip::F103 => 1,
            Chip::F446 => self.parallelism_f446(),
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
        self.unfenced = true;
        self.busy_until = Some(now + work.duration());
    }

    fn settle(&mut self, now: Picoseconds) {
        if self.busy_until.take_if(|end| *end <= now).is_some() {
            self.ended = true;
        }
    }
}
