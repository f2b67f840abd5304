//! Two slots of flash that hold the images, oldest to newest, appended until a slot is full.
//!
//! ```text
//!            place 0     place 1     place 2          ...
//!   slot 0  | image 7   | image 8   | image 9   | (full)
//!   slot 1  | image 10  | erased    | erased    |          <- the next image goes to place 1
//! ```
//!
//! A slot is half of the memory. The newest image is never touched: the next one goes to the next erased place, and when the
//! slot is full to the start of the other one, which is erased ahead at boot ([`Store::prepare`]) because erasing stalls the
//! processor. Only what could be newer than the newest whole image counts as damage; older debris does not.

use super::image::{self, Content, IMAGE_MAX, Image};
use super::{ImageId, PAYLOAD_MAX, Payload, StoreError};
use embedded_storage::nor_flash::NorFlash;

/// Bytes programmed in one [`Store::step`].
const STEP: usize = 4;

/// What was found in memory at boot.
#[derive(Clone, PartialEq, Eq, Debug, Default)]
pub struct Loaded {
    /// The payload of the newest whole image; None: use the factory values.
    pub payload: Option<Payload>,
    /// Something newer than that is damaged, or nothing is whole although the memory is not blank.
    pub damaged: bool,
}

/// A place for one image.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
struct Place {
    slot: usize,
    index: usize,
}

/// A save under way.
#[derive(Debug)]
struct Save {
    image: Image,
    place: Place,
    state: State,
}

#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum State {
    Erase,
    /// Bytes programmed so far.
    Program(usize),
    Verify,
}

/// The images of one model in a memory of two slots.
#[derive(Debug)]
pub struct Store<M> {
    memory: M,
    id: ImageId,
    payload: usize,
    next: Place,
    sequence: u32,
    save: Option<Save>,
}

impl<M: NorFlash> Store<M> {
    /// Looks through `memory` for images of `id` with payloads of `payload` bytes (at most [`PAYLOAD_MAX`]) and returns the
    /// newest whole one. Nothing is written.
    pub fn open(memory: M, id: ImageId, payload: usize) -> (Self, Loaded) {
        const {
            assert!(M::WRITE_SIZE <= STEP && STEP.is_multiple_of(M::WRITE_SIZE));
            assert!(M::READ_SIZE == 1);
        }
        let payload = payload.min(PAYLOAD_MAX);
        let next = Place { slot: 0, index: 0 };
        let mut store = Self {
            memory,
            id,
            payload,
            next,
            sequence: 0,
            save: None,
        };
        let loaded = store.scan();
        (store, loaded)
    }

    /// Gives the memory back.
    pub fn into_memory(self) -> M {
        self.memory
    }

    /// Access to the memory, for a driver that has its own business with it.
    pub fn memory(&mut self) -> &mut M {
        &mut self.memory
    }

    /// Erases ahead: call it at boot, before the node takes part in the bus. The other slot is erased when the current one is
    /// more than half full, so that at least half a slot of saves never has to erase; until then the older images stay.
    pub fn prepare(&mut self) {
        let other = 1 - self.next.slot.min(1);
        let full = self.next.index >= self.places();
        let roomy = !full && self.next.index <= self.places() / 2;
        if !roomy && !self.blank(other) {
            // A failure shows again, and is reported, when the slot is needed.
            let _ = self.erase(other);
        }
    }

    /// Begins to save `payload`; carry it out with [`step`](Self::step). A save under way is given up.
    pub fn save(&mut self, payload: &[u8]) {
        let image = (payload.len() == self.payload)
            .then(|| image::encode(self.id, self.sequence.wrapping_add(1), payload))
            .flatten();
        let mut place = self.next;
        if place.index >= self.places() {
            place = Place {
                slot: 1 - place.slot.min(1),
                index: 0,
            };
        }
        let state = if place.index == 0 && !self.blank(place.slot) {
            State::Erase
        } else {
            State::Program(0)
        };
        // A payload of the wrong size cannot come from a model; the empty image fails to verify.
        let image = image.unwrap_or_default();
        self.save = Some(Save {
            image,
            place,
            state,
        });
    }

    /// True while a save is under way.
    pub fn busy(&self) -> bool {
        self.save.is_some()
    }

    /// Carries a save one small step further: four bytes, or one erase. Returns the result when the save has ended.
    pub fn step(&mut self) -> Option<Result<(), StoreError>> {
        let mut save = self.save.take()?;
        let outcome = match save.state {
            State::Erase => self
                .erase(save.place.slot)
                .map(|()| Some(State::Program(0))),
            State::Program(at) => self.program(&save, at).map(Some),
            State::Verify => self.verify(&save).map(|()| None),
        };
        match outcome {
            Ok(Some(state)) => {
                save.state = state;
                self.save = Some(save);
                None
            }
            Ok(None) => {
                self.sequence = self.sequence.wrapping_add(1);
                self.next = Place {
                    index: save.place.index + 1,
                    ..save.place
                };
                Some(Ok(()))
            }
            Err(StoreError) => {
                // The place is spoilt, if it was programmed at all: the next save takes the one after it. The slot must not
                // change over to one that could not be erased.
                if save.state != State::Erase {
                    self.next = Place {
                        index: save.place.index + 1,
                        ..save.place
                    };
                }
                Some(Err(StoreError))
            }
        }
    }

    /// Finds the newest whole image and the place for the next one.
    fn scan(&mut self) -> Loaded {
        let places = self.places();
        // For each slot: the place after the last one that is not blank, and the last one that is unusable.
        let mut used = [0; 2];
        let mut unusable = [None; 2];
        let mut newest: Option<(u32, Place)> = None;
        let slots = used.iter_mut().zip(unusable.iter_mut()).enumerate();
        for (slot, (used, unusable)) in slots {
            for index in 0..places {
                let place = Place { slot, index };
                match self.judge(place) {
                    Content::Blank => continue,
                    Content::Unusable => *unusable = Some(index),
                    Content::Whole(sequence) => {
                        if newest.is_none_or(|(best, _)| sequence.wrapping_sub(best) < 1 << 31) {
                            newest = Some((sequence, place));
                        }
                    }
                }
                *used = index + 1;
            }
        }
        let [used0, used1] = used;
        let [unusable0, unusable1] = unusable;
        let Some((sequence, place)) = newest else {
            let index = if self.tail_blank(0, used0) {
                used0
            } else {
                places
            };
            self.next = Place { slot: 0, index };
            return Loaded {
                payload: None,
                damaged: unusable0.is_some() || unusable1.is_some(),
            };
        };
        let (used, here, there) = if place.slot == 0 {
            (used0, unusable0, unusable1)
        } else {
            (used1, unusable1, unusable0)
        };
        // In its own slot everything behind the newest image is newer; the other slot is newer only when this one is full.
        let full = place.index + 1 >= places;
        let damaged = here.is_some_and(|index| index > place.index) || (full && there.is_some());
        let index = if self.tail_blank(place.slot, used) {
            used
        } else {
            places
        };
        self.next = Place {
            slot: place.slot,
            index,
        };
        self.sequence = sequence;
        let payload = self
            .load(place)
            .and_then(|bytes| image::payload(&bytes, self.payload));
        Loaded { payload, damaged }
    }

    /// Places for images in one slot.
    fn places(&self) -> usize {
        self.slot_size().checked_div(self.place_size()).unwrap_or(0)
    }

    fn slot_size(&self) -> usize {
        self.memory.capacity() / 2 / M::ERASE_SIZE * M::ERASE_SIZE
    }

    fn place_size(&self) -> usize {
        image::image_size(self.payload)
    }

    fn address(&self, place: Place) -> u32 {
        (place.slot * self.slot_size() + place.index * self.place_size()) as u32
    }

    /// The bytes of a place; None when they cannot be read.
    fn load(&mut self, place: Place) -> Option<Image> {
        let mut bytes = Image::new();
        bytes.resize(self.place_size().min(IMAGE_MAX), 0).ok()?;
        let address = self.address(place);
        self.memory.read(address, &mut bytes).ok()?;
        Some(bytes)
    }

    fn judge(&mut self, place: Place) -> Content {
        let Some(bytes) = self.load(place) else {
            return Content::Unusable;
        };
        image::judge(&bytes, self.id, self.payload)
    }

    /// True when every place from `index` on is blank.
    fn tail_blank(&mut self, slot: usize, index: usize) -> bool {
        (index..self.places()).all(|index| self.judge(Place { slot, index }) == Content::Blank)
    }

    /// True when the whole slot is erased, also the rest behind the last place.
    fn blank(&mut self, slot: usize) -> bool {
        let start = slot * self.slot_size();
        (start..start + self.slot_size())
            .step_by(STEP)
            .all(|address| {
                let mut bytes = [0; STEP];
                self.memory.read(address as u32, &mut bytes).is_ok() && bytes == [0xFF; STEP]
            })
    }

    fn erase(&mut self, slot: usize) -> Result<(), StoreError> {
        let start = slot * self.slot_size();
        let end = start + self.slot_size();
        self.memory
            .erase(start as u32, end as u32)
            .map_err(|_| StoreError)
    }

    /// Programs the next bytes of the image and says what comes then.
    fn program(&mut self, save: &Save, at: usize) -> Result<State, StoreError> {
        let Some(bytes) = save.image.get(at..at + STEP) else {
            return Ok(State::Verify);
        };
        let address = self.address(save.place) as usize + at;
        self.memory
            .write(address as u32, bytes)
            .map_err(|_| StoreError)?;
        Ok(State::Program(at + STEP))
    }

    fn verify(&mut self, save: &Save) -> Result<(), StoreError> {
        match self.load(save.place) {
            Some(bytes) if bytes == save.image => Ok(()),
            _ => Err(StoreError),
        }
    }
}
