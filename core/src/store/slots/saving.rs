//! A save: its place, its steps, and its end.

use super::{Buffer, Store};
use crate::store::survey::{WORD, is_blank, read_word};
use crate::store::{StoreError, record};
use embedded_storage::nor_flash::NorFlash;

#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Stage {
    Erase,
    /// The bytes of the buffer before this offset are programmed.
    Program(usize),
}

/// A running save: writes the bytes `from..end` of the buffer to the end of `slot`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Save {
    pub slot: usize,
    pub stage: Stage,
    pub from: usize,
    pub end: usize,
    /// The first word is programmed last. So a usage that was not completed is no damage.
    pub first_last: bool,
}

impl<M: NorFlash, B: Buffer> Store<M, B> {
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
            Stage::Program(at) if B::USAGE && save.first_last && at == save.end => {
                self.program(&save, save.from).map(|()| at + WORD)
            }
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

    pub(super) fn save_after_device(&mut self, encode: impl FnOnce(&mut [u8]) -> Option<usize>) {
        self.is_current = false;
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
    pub(super) fn begin(&mut self, end: usize) {
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
            first_last: false,
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
        let has_parameters = save.end > self.device;
        // A copy of the newest parameters is no save.
        let is_save = has_parameters && !save.first_last;
        if B::USAGE {
            self.usage.saves = self.usage.saves.saturating_add(is_save.into());
        }
        let slot = self.slot_mut(save.slot);
        slot.used += save.end - save.from;
        slot.has_parameters |= has_parameters;
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
            // An aborted copy of the parameters can be valid: the next save is newer.
            if B::USAGE {
                self.sequence = self.sequence.wrapping_add(1);
            }
        }
    }

    /// The address of the next record in the slot of the save.
    fn address(&self, save: &Save) -> usize {
        self.start(save.slot) + self.slot(save.slot).used
    }
}
