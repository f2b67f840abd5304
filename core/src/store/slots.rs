//! The two slots: finds the records, and keeps a slot erased.

mod device;
mod keeping;
mod saving;

use super::record;
use super::survey::{Found, Survey, WORD, survey};
use super::unit::Unit;
use super::usage::Usage;
use super::{Boot, Buffer, Owner, StoreError};
use crate::diagnosis::ResetCauses;
use crate::measure::Calibration;
use embedded_storage::nor_flash::NorFlash;
use saving::Save;

/// The room for records of the usage that a start leaves in the half of a slot, in bytes.
const RESERVE: usize = 4 * record::USAGE_SIZE;

/// The state of a slot.
#[derive(Clone, Copy, Debug)]
struct Slot {
    /// The end of the last word that is not blank.
    used: usize,
    /// It contains parameters.
    has_parameters: bool,
    /// It contains the records of the device.
    has_device: bool,
}

impl Slot {
    const BLANK: Self = Self {
        used: 0,
        has_parameters: false,
        has_device: false,
    };
}

/// The records of one device in a memory with two slots. The size of buffer `B` is the [`buffer_size`](super::buffer_size) of its
/// parameters; [`StoreOf`](crate::node::StoreOf) is the store for a node.
///
/// The memory implements [`NorFlash`] of the crate `embedded-storage` 0.3. Its `READ_SIZE` is 1, its `WRITE_SIZE` 1, 2 or 4. As the trait
/// says, it returns an error if a read goes beyond its end.
#[derive(Debug)]
pub struct Store<M, B> {
    memory: M,
    /// The size of a slot.
    size: usize,
    owner: Owner,
    slots: [Slot; 2],
    /// The slot with the newest parameters. It is never erased.
    home: usize,
    newest: Found,
    /// The device has a calibration.
    is_calibrated: bool,
    /// The length of the encoded identity of the device; 0: it has none.
    unit: usize,
    /// The usage of the device, with the saves and erases of this store.
    usage: Usage,
    /// The records of the device contain it.
    has_usage: bool,
    /// There was no save since the memory was scanned, so `newest` is the newest.
    is_current: bool,
    /// The size of the records of the device. They are always in the buffer; 0: there are none.
    device: usize,
    damaged: bool,
    sequence: u32,
    save: Option<Save>,
    /// The records of the calibration, the identity and the usage, then the record of the parameters.
    buffer: B,
}

impl<M: NorFlash, B: Buffer> Store<M, B> {
    /// Finds the records of `owner` in `memory`. Does not write.
    pub fn open(memory: M, owner: Owner) -> Self {
        let mut store = Self::new(memory, owner);
        store.scan();
        store
    }

    /// A store that must be [scanned](Self::scan) before its use. So a large store can be opened in place.
    pub fn new(memory: M, owner: Owner) -> Self {
        const {
            assert!(
                M::WRITE_SIZE <= WORD && WORD.is_multiple_of(M::WRITE_SIZE),
                "the store programs words of 4 bytes: `WRITE_SIZE` is 1, 2 or 4"
            );
            assert!(
                M::READ_SIZE == 1,
                "the store reads single bytes: `READ_SIZE` is 1"
            );
            assert!(
                B::SIZE >= super::buffer_size(0, B::USAGE),
                "the buffer has no room for a record: see `buffer_size` and `StoreOf`"
            );
        }
        Self {
            size: memory.capacity() / 2 / M::ERASE_SIZE * M::ERASE_SIZE,
            memory,
            owner,
            slots: const { [Slot::BLANK; 2] },
            home: 0,
            newest: const { Found::NONE },
            is_calibrated: false,
            unit: 0,
            usage: const { Usage::NONE },
            has_usage: false,
            is_current: false,
            device: 0,
            damaged: false,
            sequence: 0,
            save: None,
            buffer: B::ZERO,
        }
    }

    /// The contents of the memory when it was opened. Call it before the first save.
    pub fn boot(&mut self) -> Boot<'_> {
        let calibration = self.calibration().first_chunk();
        let calibration = calibration.and_then(Calibration::decode);
        let unit = Unit::decode(self.owner.image, self.identity());
        // Parameters of a newer firmware beyond the buffer are unknown.
        let place = self
            .buffer
            .as_mut()
            .get_mut(self.device..)
            .unwrap_or_default();
        let length = self.newest.length.min(place.len());
        let place = place.get_mut(..length);
        let parameters = place.filter(|_| self.newest.is_there()).and_then(|place| {
            let read = self.memory.read(self.newest.address as u32, place);
            read.is_ok().then_some(&*place)
        });
        Boot {
            parameters,
            calibration: calibration.unwrap_or(Calibration::IDENTITY),
            damaged: self.damaged,
            kept: 0,
            serial: self.owner.serial,
            unit,
            usage: self.usage,
            causes: ResetCauses::NONE,
            program: None,
        }
    }

    /// The owner of its records.
    pub fn owner(&self) -> Owner {
        self.owner
    }

    /// Ends the use of the store, for example to look at what it has written.
    pub fn into_memory(self) -> M {
        self.memory
    }

    /// Access to the memory for the driver.
    pub fn memory(&mut self) -> &mut M {
        &mut self.memory
    }

    /// Erases the spare slot in advance, if the other slot is more than half full. Call it at boot, before the node takes part in
    /// the bus. Then saves of at least half a slot need no erase. While the other slot is at most half full, the older records
    /// stay. A spare slot with nothing but an incomplete save is not erased.
    pub fn prepare(&mut self) {
        let (home, spare) = (self.slot(self.home), self.slot(self.spare()));
        // A start is followed by records of the usage.
        let reserve = if B::USAGE && self.has_usage {
            RESERVE
        } else {
            0
        };
        let roomy = home.used + reserve <= self.size / 2;
        // The next save copies the records of the device into its slot.
        let only_copy = spare.has_device && !home.has_device;
        // The damage is reported until the next save succeeds, which is written after it.
        let only_damaged = self.damaged && !spare.has_parameters && spare.used < self.size;
        if !roomy && !only_copy && !only_damaged && spare.used > 0 {
            // A failure is reported when the slot is needed and erased again.
            let _ = self.erase(self.spare());
        }
    }

    /// Finds the newest parameters, the records of the device, and the position for the next record. Does not write.
    pub fn scan(&mut self) {
        let first = self.survey(0);
        let second = self.survey(1);
        let in_second = if first.parameters.is_there() || second.parameters.is_there() {
            second.parameters.is_newer(&first.parameters)
        } else {
            second.has_newer_device(&first)
        };
        let (mut home, mut other) = if in_second {
            (second, first)
        } else {
            (first, second)
        };
        let newest = home.parameters;
        self.home = in_second.into();
        self.newest = newest;
        self.is_current = true;
        self.sequence = if newest.is_there() {
            newest.sequence
        } else {
            home.device_sequence
        };
        let mut place = home.calibration;
        for other in [newest.calibration, other.calibration] {
            if place.address == 0 {
                place = other;
            }
        }
        let identity = if home.unit.address > 0 {
            home.unit
        } else {
            other.unit
        };
        let usage = if home.usage > 0 {
            home.usage
        } else {
            other.usage
        };
        self.read_device(place, identity, usage);
        for survey in [&mut home, &mut other] {
            if B::USAGE && !self.has(survey.torn) {
                let [calibration, unit] = survey.torn;
                let torn = calibration.address.max(unit.address);
                survey.unusable = survey.unusable.max(torn);
            }
        }
        self.damaged = if newest.is_there() || B::USAGE && home.usage > 0 {
            // In the slot of the newest parameters, all data after them is newer. Data in the other slot is newer only if this
            // slot is full and the other one has only begun. A slot full of invalid data is an incomplete erase.
            let size = if newest.is_there() {
                record::parameters_size(newest.length)
            } else {
                B::SIZE - record::device_size(B::USAGE)
            };
            let full = home.used + size > self.size;
            let begun = !other.parameters.is_there() && other.used < self.size;
            home.unusable > newest.address || (full && begun && other.unusable > 0)
        } else {
            home.unusable > 0 || other.unusable > 0
        };
        // A slot can contain older ones.
        self.slots[0].has_device = self.is_device(&first);
        self.slots[1].has_device = self.is_device(&second);
        self.damaged |= newest.check != 0 && newest.check != self.check();
    }

    fn survey(&mut self, number: usize) -> Survey {
        let (start, size) = (self.start(number), self.size);
        let survey = survey::<B>(&mut self.memory, self.owner, start, size);
        *self.slot_mut(number) = Slot {
            used: survey.used,
            has_parameters: survey.parameters.is_there(),
            has_device: false,
        };
        survey
    }

    /// The slot that can be erased: the one without the newest parameters.
    fn spare(&self) -> usize {
        1 - self.home.min(1)
    }

    #[expect(
        clippy::indexing_slicing,
        reason = "modulo the length; a choice by `if` needs 50 bytes more"
    )]
    fn slot(&self, number: usize) -> Slot {
        self.slots[number % 2]
    }

    #[expect(clippy::indexing_slicing, reason = "modulo the length")]
    fn slot_mut(&mut self, number: usize) -> &mut Slot {
        &mut self.slots[number % 2]
    }

    fn start(&self, number: usize) -> usize {
        number * self.size
    }

    fn erase(&mut self, number: usize) -> Result<(), StoreError> {
        let start = self.start(number);
        let end = start + self.size;
        let erased = self.memory.erase(start as u32, end as u32);
        erased.map_err(|_| StoreError)?;
        if B::USAGE {
            self.usage.erases = self.usage.erases.saturating_add(1);
        }
        *self.slot_mut(number) = Slot::BLANK;
        Ok(())
    }
}
