//! The operations of the flash and their times.

use crate::chip::Chip;
use crate::io::Width;
use crate::timebase::{MICROSECOND, Picoseconds};

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
    pub(super) const fn typical(chip: Chip) -> Self {
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
