//! The key sequence and FLASH_CR of both chips. [`Control`] has the bits of a chip.

use super::{FlashInterface, f103, f446};
use crate::chip::Chip;
use crate::io::AccessError;
use crate::timebase::Picoseconds;
use crate::violation::Violations;

const KEY1: u32 = 0x4567_0123;
const KEY2: u32 = 0xCDEF_89AB;

/// FLASH_CR.PG.
pub(super) const PROGRAM: u32 = 1 << 0;
/// FLASH_CR.PER of the STM32F103, FLASH_CR.SER of the STM32F446.
pub(super) const ERASE: u32 = 1 << 1;
/// FLASH_CR.MER.
pub(super) const MASS_ERASE: u32 = 1 << 2;

/// The state of the key sequence (PM0075, section 2.3.1).
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Keys {
    Locked,
    First,
    Unlocked,
    /// A wrong key: locked until the next reset.
    LockedUntilReset,
}

/// Bits that must not be written as 1.
#[derive(Debug)]
pub(super) enum Bits {
    /// Each of these bits must be 0.
    Any(u32),
    /// These bits must not all be 1.
    All(u32),
}

impl Bits {
    fn are_in(&self, value: u32) -> bool {
        match *self {
            Self::Any(bits) => value & bits != 0,
            Self::All(bits) => value & bits == bits,
        }
    }
}

/// The bits of FLASH_CR of a chip.
#[derive(Debug)]
pub(super) struct Control {
    /// The bits that keep the value that is written.
    pub writable: u32,
    /// The bit that starts an erase (STRT).
    pub start: u32,
    /// The bit that locks the register (LOCK).
    pub lock: u32,
    /// The bits whose write is a violation, each with the reason.
    pub forbidden: &'static [(Bits, &'static str)],
    /// The reason of the violation when STRT is written without PER or SER.
    pub start_without_erase: &'static str,
}

impl FlashInterface {
    const fn control(&self) -> &'static Control {
        match self.chip {
            Chip::F103 => &f103::CONTROL,
            Chip::F446 => &f446::CONTROL,
        }
    }

    pub(super) fn write_key(
        &mut self,
        value: u32,
        violations: &mut Violations,
    ) -> Result<(), AccessError> {
        violations.check(
            self.stale,
            "FLASH_ACR",
            "the data cache is not reset after an erase",
        );
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

    pub(super) fn read_cr(&self) -> u32 {
        match self.keys {
            Keys::Unlocked => self.cr,
            _ if !self.lock_reads => self.cr,
            _ => self.cr | self.control().lock,
        }
    }

    pub(super) fn write_cr(&mut self, now: Picoseconds, value: u32, violations: &mut Violations) {
        const NAME: &str = "FLASH_CR";
        if self.keys != Keys::Unlocked {
            violations.add(NAME, "written while it is locked");
            return;
        }
        if self.busy_until.is_some() {
            violations.add(NAME, "written while the flash is busy");
            return;
        }
        let control = self.control();
        for (bits, reason) in control.forbidden {
            violations.check(bits.are_in(value), NAME, reason);
        }
        self.cr = value & control.writable;
        if value & control.start != 0 {
            if self.cr & ERASE == 0 {
                violations.add(NAME, control.start_without_erase);
            } else {
                self.erase(now, violations);
            }
        }
        if value & control.lock != 0 {
            self.keys = Keys::Locked;
        }
    }

    /// Erases the page or sector that the registers select.
    fn erase(&mut self, now: Picoseconds, violations: &mut Violations) {
        match self.chip {
            Chip::F103 => self.erase_f103(now, violations),
            Chip::F446 => self.erase_f446(now, violations),
        }
    }
}
