//! The flash of the program and the page of the boot record, as on the Blue Pill.

use crate::flash::{Flash, Geometry, PAGE_SIZE};
use plumbline::update::header::{PLACE, SIZE, crc};
use plumbline::update::layout::BLUEPILL;
use plumbline::update::record;
use plumbline::update::{Program, Record, Slot, SlotError};

/// The place of the boot record.
const RECORD: usize = (BLUEPILL.record - BLUEPILL.start) as usize;

/// The slot and the boot record behind it.
pub(super) struct Pages(pub(super) Flash);

impl Pages {
    pub(super) fn blank() -> Self {
        Self(Flash::blank(Geometry {
            pages: RECORD / PAGE_SIZE + 1,
            page_size: PAGE_SIZE,
            once_only: true,
        }))
    }

    /// Loads the program of an image file, as a probe does.
    pub(super) fn load(&mut self, file: &[u8]) {
        let (header, body) = file.split_at(SIZE);
        let (before, rest) = body.split_at(PLACE);
        let contents = [before, header, &rest[SIZE..]].concat();
        self.program(0, &contents).expect("an erased flash");
        let program = Program::of(self).committed(self);
        assert!(program.header().is_some(), "the file is not a program");
    }

    fn record_page(&self) -> &[u8] {
        &self.0.bytes()[RECORD..]
    }

    /// The newest boot record.
    pub(super) fn newest_record(&self) -> Option<Record> {
        record::newest(self.record_page(), crc)
    }

    /// Stores a boot record, unless it is the newest one.
    pub(super) fn keep(&mut self, record: &Record) -> Result<(), SlotError> {
        if self.newest_record().as_ref() == Some(record) {
            return Ok(());
        }
        let place = match record::next_place(self.record_page()) {
            Some(place) => place,
            None => {
                self.erase(RECORD / PAGE_SIZE)?;
                0
            }
        };
        self.program(RECORD + place, record.bytes())
    }
}

impl Slot for Pages {
    const PAGE: usize = PAGE_SIZE;
    const SIZE: usize = BLUEPILL.size;

    fn bytes(&self) -> &[u8] {
        &self.0.bytes()[..BLUEPILL.size]
    }

    fn erase(&mut self, page: usize) -> Result<(), SlotError> {
        let erased = self.0.erase_page_at(page * PAGE_SIZE);
        erased.map_err(|_| SlotError)
    }

    fn program(&mut self, place: usize, bytes: &[u8]) -> Result<(), SlotError> {
        for (place, unit) in (place..).step_by(2).zip(bytes.chunks(2)) {
            let programmed = self.0.program_unit(place, unit);
            programmed.map_err(|_| SlotError)?;
        }
        match self.0.bytes()[place..].starts_with(bytes) {
            true => Ok(()),
            false => Err(SlotError),
        }
    }
}
