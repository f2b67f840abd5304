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

/// What there is in one slot.
#[derive(Clone, Copy, Debug, Default)]
struct Survey {
    /// The place behind the last one that is not blank.
    used: usize,
    /// The last place that is neither blank nor whole.
    unusable: Option<usize>,
    /// The newest whole image: sequence number and place.
    newest: Option<(u32, usize)>,
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
    /// The newest whole image; its slot is never erased.
    newest: Option<Place>,
    /// Where the next image goes; behind the last place when the slot is full.
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
            newest: None,
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

    /// Erases ahead: call it at boot, before the node takes part in the bus. The spare slot is erased when the other one is more
    /// than half full, so that at least half a slot of saves never has to erase; until then the older images stay.
    pub fn prepare(&mut self) {
        let spare = self.spare();
        let roomy = self.next.index <= self.places() / 2;
        if self.next.slot != spare && !roomy && !self.blank(spare) {
            // A failure shows again, and is reported, when the slot is needed.
            let _ = self.erase(spare);
        }
    }

    /// Begins to save `payload`; carry it out with [`step`](Self::step). A save under way is given up.
    #[inline(never)] // measured and budgeted as a function
    pub fn save(&mut self, payload: &[u8]) {
        if let Some(given_up) = self.save.take()
            && given_up.state != State::Erase
        {
            self.pass(given_up.place);
        }
        let image = (payload.len() == self.payload)
            .then(|| image::encode(self.id, self.sequence.wrapping_add(1), payload))
            .flatten();
        let mut place = self.next;
        if place.index >= self.places() {
            place = Place {
                slot: self.spare(),
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
                self.newest = Some(save.place);
                self.pass(save.place);
                Some(Ok(()))
            }
            Err(StoreError) => {
                // A slot that could not be erased is erased next time; it is not programmed.
                if save.state != State::Erase {
                    self.pass(save.place);
                }
                Some(Err(StoreError))
            }
        }
    }

    /// The slot that may be erased: the one without the newest image.
    fn spare(&self) -> usize {
        1 - self.newest.unwrap_or(self.next).slot.min(1)
    }

    /// The next image goes behind `place`, unless that is still, or again, erased.
    fn pass(&mut self, place: Place) {
        let used = self.judge(place) != Content::Blank;
        let index = place.index + usize::from(used);
        self.next = Place { index, ..place };
    }

    /// Finds the newest whole image and the place for the next one.
    fn scan(&mut self) -> Loaded {
        let first = self.survey(0);
        let second = self.survey(1);
        let second_is_newer = match (first.newest, second.newest) {
            (Some((a, _)), Some((b, _))) => b.wrapping_sub(a) < 1 << 31,
            (first, _) => first.is_none(),
        };
        let (slot, own, other) = if second_is_newer && second.newest.is_some() {
            (1, second, first)
        } else {
            (0, first, second)
        };
        self.next = Place {
            slot,
            index: own.used,
        };
        let Some((sequence, index)) = own.newest else {
            return Loaded {
                payload: None,
                damaged: own.unusable.is_some() || other.unusable.is_some(),
            };
        };
        let place = Place { slot, index };
        self.newest = Some(place);
        self.sequence = sequence;
        // In its own slot everything behind the newest image is newer. The other slot is newer only when this one is full; then
        // it has just been begun. A slot full of debris is an erase that was cut off.
        let full = index + 1 >= self.places();
        let begun = full && other.newest.is_none() && other.used < self.places();
        let damaged = own.unusable.is_some_and(|unusable| unusable > index)
            || (begun && other.unusable.is_some());
        if begun && damaged {
            // Go on behind the damage, so that it is seen until the next save.
            self.next = Place {
                slot: 1 - slot,
                index: other.used,
            };
        }
        let payload = self
            .load(place)
            .and_then(|bytes| image::payload(&bytes, self.payload));
        Loaded { payload, damaged }
    }

    /// Looks through one slot.
    fn survey(&mut self, slot: usize) -> Survey {
        let mut survey = Survey::default();
        for index in 0..self.places() {
            match self.judge(Place { slot, index }) {
                Content::Blank => continue,
                Content::Unusable => survey.unusable = Some(index),
                Content::Whole(sequence) => {
                    let newer = |(best, _): (u32, usize)| sequence.wrapping_sub(best) < 1 << 31;
                    if survey.newest.is_none_or(newer) {
                        survey.newest = Some((sequence, index));
                    }
                }
            }
            survey.used = index + 1;
        }
        survey
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
