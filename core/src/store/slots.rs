//! The two slots: finding records and saving new ones.

mod device;

use super::record;
use super::survey::{Found, Survey, WORD, is_blank, read_word, survey};
use super::unit::Unit;
use super::{Boot, Owner, StoreError};
use crate::measure::Calibration;
use embedded_storage::nor_flash::NorFlash;

#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Stage {
    Erase,
    /// The bytes of the buffer before this offset are programmed.
    Program(usize),
}

/// A running save: writes the bytes `from..end` of the buffer to the end of `slot`.
#[derive(Clone, Copy, Debug)]
struct Save {
    slot: usize,
    stage: Stage,
    from: usize,
    end: usize,
}

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

/// The buffer of a [`Store`]: an array of bytes.
pub trait Buffer: Send + AsRef<[u8]> + AsMut<[u8]> + 'static {
    /// All bytes 0.
    const ZERO: Self;
    /// The number of bytes.
    const SIZE: usize;
}

impl<const N: usize> Buffer for [u8; N] {
    const ZERO: Self = [0; N];
    const SIZE: usize = N;
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
    /// The size of the records of the device. They are always in the buffer; 0: there are none.
    device: usize,
    damaged: bool,
    sequence: u32,
    save: Option<Save>,
    /// The record of the calibration, the record of the identity, then the record of the parameters.
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
                B::SIZE >= super::buffer_size(0),
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
        let roomy = home.used <= self.size / 2;
        // The next save copies the records of the device into its slot.
        let only_copy = spare.has_device && !home.has_device;
        // The damage is reported until the next save succeeds, which is written after it.
        let only_damaged = self.damaged && !spare.has_parameters && spare.used < self.size;
        if !roomy && !only_copy && !only_damaged && spare.used > 0 {
            // A failure is reported when the slot is needed and erased again.
            let _ = self.erase(self.spare());
        }
    }

    /// Begins to save parameters, which `encode` writes into a buffer. Call [`step`](Self::step) until the save has ended. A
    /// running save is aborted.
    pub fn save(&mut self, encode: impl FnOnce(&mut [u8]) -> Option<usize>) {
        self.give_up();
        self.save_after_device(encode);
    }

    /// True while a save is running.
    pub fn busy(&self) -> bool {
        self.save.is_some()
    }

    /// Performs one step of a save: programs four bytes, or erases a slot. Returns the result when the save has ended.
    pub fn step(&mut self) -> Option<Result<(), StoreError>> {
        let save = self.save?;
        let result = match save.stage {
            Stage::Erase => self.erase(save.slot).map(|()| save.from),
            Stage::Program(at) if at < save.end => self.program(&save, at).map(|()| at + WORD),
            Stage::Program(_) => {
                let result = self.verify(&save);
                if result.is_err() {
                    self.give_up();
                } else {
                    self.succeed(&save);
                }
                self.save = None;
                return Some(result);
            }
        };
        match result {
            Ok(at) => {
                let stage = Stage::Program(at);
                self.save = Some(Save { stage, ..save });
                None
            }
            Err(StoreError) => {
                self.give_up();
                Some(Err(StoreError))
            }
        }
    }

    fn save_after_device(&mut self, encode: impl FnOnce(&mut [u8]) -> Option<usize>) {
        let sequence = self.sequence.wrapping_add(1);
        let check = self.check();
        let place = self
            .buffer
            .as_mut()
            .get_mut(self.device..)
            .unwrap_or_default();
        let size = record::encode_parameters(place, self.owner, check, sequence, encode);
        // Parameters that do not fit cannot come from a node of this product. An empty save fails in `verify`.
        self.begin(size.map_or(0, |size| self.device + size));
    }

    /// Plans the save of the buffer up to `end`.
    fn begin(&mut self, end: usize) {
        // What is larger than a slot fails in `verify`.
        let end = if end <= self.size { end } else { 0 };
        let spare = self.spare();
        // After an incomplete save in the spare slot, the next save is written after the damaged data. So the damage stays
        // visible until a save succeeds.
        let (slot, stage) = if self.fits(self.home, end) {
            (self.home, None)
        } else if self.fits(spare, end) && !self.slot(spare).has_parameters {
            (spare, None)
        } else {
            (spare, Some(Stage::Erase))
        };
        let has_device = self.slot(slot).has_device && stage.is_none();
        let from = if has_device { self.device } else { 0 };
        self.save = Some(Save {
            slot,
            stage: stage.unwrap_or(Stage::Program(from)),
            from,
            end,
        });
    }

    /// Whether the buffer up to `end` fits into the free part of a slot. The records of the device are not counted if the slot
    /// contains them.
    fn fits(&self, number: usize, end: usize) -> bool {
        let slot = self.slot(number);
        let from = if slot.has_device { self.device } else { 0 };
        slot.used + end <= self.size + from
    }

    fn program(&mut self, save: &Save, at: usize) -> Result<(), StoreError> {
        let address = self.address(save) + at - save.from;
        let bytes = self.buffer.as_ref().get(at..at + WORD).ok_or(StoreError)?;
        let written = self.memory.write(address as u32, bytes);
        written.map_err(|_| StoreError)
    }

    /// Compares the saved bytes with the memory.
    fn verify(&mut self, save: &Save) -> Result<(), StoreError> {
        let address = self.address(save);
        let mut same = save.end > save.from;
        let mut at = save.from;
        while at < save.end {
            let word = read_word(&mut self.memory, address + at - save.from);
            let bytes = self
                .buffer
                .as_ref()
                .get(at..)
                .and_then(|rest| rest.first_chunk());
            same &= word.is_some() && word == bytes.map(|&bytes| u32::from_le_bytes(bytes));
            at += WORD;
        }
        if same { Ok(()) } else { Err(StoreError) }
    }

    fn succeed(&mut self, save: &Save) {
        let device = self.device;
        let slot = self.slot_mut(save.slot);
        slot.used += save.end - save.from;
        slot.has_parameters |= save.end > device;
        slot.has_device |= save.from == 0;
        self.home = save.slot;
        self.sequence = self.sequence.wrapping_add(1);
    }

    /// Ends a failed or aborted save. If it has programmed any bytes, the next save is written after them.
    fn give_up(&mut self) {
        let Some(save) = self.save.take() else {
            return;
        };
        let size = save.end.saturating_sub(save.from);
        let address = self.address(&save);
        if save.stage != Stage::Erase && !is_blank(&mut self.memory, address, size) {
            self.slot_mut(save.slot).used += size;
        }
    }

    /// The address of the next record in the slot of the save.
    fn address(&self, save: &Save) -> usize {
        self.start(save.slot) + self.slot(save.slot).used
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
        let (home, other) = if in_second {
            (&second, &first)
        } else {
            (&first, &second)
        };
        let newest = home.parameters;
        self.home = in_second.into();
        self.newest = newest;
        self.sequence = if newest.is_there() {
            newest.sequence
        } else {
            home.device_sequence
        };
        self.damaged = if newest.is_there() {
            // In the slot of the newest parameters, all data after them is newer. Data in the other slot is newer only if this
            // slot is full and the other one has only begun. A slot full of invalid data is an incomplete erase.
            let full = home.used + record::parameters_size(newest.length) > self.size;
            let begun = !other.parameters.is_there() && other.used < self.size;
            home.unusable > newest.address || (full && begun && other.unusable > 0)
        } else {
            home.unusable > 0 || other.unusable > 0
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
        self.read_device(place, identity);
        // A slot can contain older ones.
        self.slots[0].has_device = self.is_device(&first);
        self.slots[1].has_device = self.is_device(&second);
        self.damaged |= newest.check != 0 && newest.check != self.check();
    }

    fn survey(&mut self, number: usize) -> Survey {
        let (start, size) = (self.start(number), self.size);
        let survey = survey(&mut self.memory, self.owner, start, size);
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
        *self.slot_mut(number) = Slot::BLANK;
        Ok(())
    }
}
