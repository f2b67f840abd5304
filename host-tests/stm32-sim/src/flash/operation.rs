//! The operations of the flash and their times.

use crate::chip::Chip;
use crate::io::Width;
use crate::timebase::{MICROSECOND, Picoseconds};

/// The times of the operations of a part.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Times {
    /// The time to program a unit.
    pub program: Picoseconds,
    /// The time to erase a parameter page by bytes, half-words, words. On the STM32F103 all three are equal.
    pub erase: [Picoseconds; 3],
    /// The same for a page that a bootloader can change.
    pub erase_of_slot: [Picoseconds; 3],
}

impl Times {
    /// The shortest times of a chip; where its datasheet has none, the typical ones.
    pub const fn shortest(chip: Chip) -> Self {
        chip.facts().flash_times[0]
    }

    /// The typical times of a chip; where its datasheet has none, the middle of the range.
    pub const fn typical(chip: Chip) -> Self {
        chip.facts().flash_times[1]
    }

    /// The longest times of a chip.
    pub const fn longest(chip: Chip) -> Self {
        chip.facts().flash_times[2]
    }

    /// From `program` in nanoseconds, `erase` and `erase_of_slot` in milliseconds.
    pub(crate) const fn of(program: u64, erase: [u64; 3], erase_of_slot: [u64; 3]) -> Self {
        Self {
            program: program * 1000,
            erase: milliseconds(erase),
            erase_of_slot: milliseconds(erase_of_slot),
        }
    }
}

const fn milliseconds([bytes, half_words, words]: [u64; 3]) -> [Picoseconds; 3] {
    const MILLISECOND: Picoseconds = 1000 * MICROSECOND;
    [
        bytes * MILLISECOND,
        half_words * MILLISECOND,
        words * MILLISECOND,
    ]
}

/// An operation of the flash. The machine changes the memory of the processor accordingly and stalls the processor, which fetches
/// its instructions from flash, for [`duration`](Self::duration).
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Work {
    /// Programs one unit of 8, 16 or 32 bits.
    Program {
        /// The first address of the unit.
        address: u32,
        /// The size of the unit.
        width: Width,
        /// The resulting content: worn-out bits stay 1.
        value: u32,
        /// The time that the operation takes.
        duration: Picoseconds,
    },
    /// Erases a page or sector.
    Erase {
        /// The first address of the page.
        page: u32,
        /// The size of the page in bytes.
        size: usize,
        /// The time that the operation takes.
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
