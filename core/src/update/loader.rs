//! Takes an image file in pieces and programs it.
//!
//! The first page of the body stays in RAM until all other pages are in the flash: without it there is no program. The flash of the present
//! program is not changed until the header has been checked.

use super::failure::{Failure, Status};
use super::header::{COMMIT, Device, Header, PAGE, PLACE, SIZE, first_page_parts};
use super::lms::Signature;
use super::slot::{Program, Slot};

#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Stage {
    /// No download: a clear command must come first.
    Closed,
    /// The first page is not complete: nothing is erased.
    Heading,
    /// The header is good: the program is being replaced.
    Loading,
}

/// The number of bytes that are programmed at once.
const PIECE: usize = 256;

/// A download.
#[derive(Clone, Debug)]
pub struct Loader {
    stage: Stage,
    status: Status,
    /// A lower version is permitted in the next download.
    downgrade: bool,
    /// The number of bytes of the file so far.
    received: usize,
    /// The length of the signature in the file in bytes.
    signed: usize,
    /// The length of the body.
    length: usize,
    /// The first page of the body, with the header.
    first: [u8; PAGE],
    signature: [u8; Signature::SIGNATURE],
    /// A part of the body that is not programmed yet.
    rest: [u8; PIECE],
}

impl Default for Loader {
    fn default() -> Self {
        Self::new()
    }
}

impl Loader {
    /// Before a download.
    pub const fn new() -> Self {
        Self {
            stage: Stage::Closed,
            status: Status::Good,
            downgrade: false,
            received: 0,
            signed: 0,
            length: 0,
            first: [0; PAGE],
            signature: [0; _],
            rest: [0; PIECE],
        }
    }

    /// The result of the last download.
    pub const fn status(&self) -> Status {
        self.status
    }

    /// Whether a download has begun and is not complete.
    pub fn is_open(&self) -> bool {
        self.stage != Stage::Closed
    }

    /// Whether a file can begin: a clear command came, and no byte since.
    pub fn is_cleared(&self) -> bool {
        self.stage == Stage::Heading && self.received == 0
    }

    /// Forgets a download that is not complete, and begins a new one. The flash is not changed.
    pub fn clear(&mut self) {
        self.stage = Stage::Heading;
        self.status = Status::Good;
        self.received = 0;
    }

    /// Permits a lower version in the next download.
    pub fn permit_downgrade(&mut self) {
        self.downgrade = true;
    }

    /// Takes the next bytes of the file. `program` is that of the sensor; it becomes [that of another slot](Slot::other) before the flash is
    /// changed.
    pub fn take<S: Slot>(
        &mut self,
        slot: &mut S,
        device: &Device,
        program: &mut Program,
        bytes: &[u8],
    ) -> Result<(), Failure> {
        let result = bytes.iter().try_for_each(|byte| {
            let place = self.received;
            self.received += 1;
            match (self.stage, place.checked_sub(self.before::<S>())) {
                (Stage::Closed, _) => Err(Failure::NotCleared),
                (Stage::Heading, None) => {
                    self.take_header::<S>(place, *byte);
                    Ok(())
                }
                (Stage::Heading, Some(place)) => {
                    self.take_first(slot, device, program, place, *byte)
                }
                (Stage::Loading, place) => self.take_rest(slot, place.unwrap_or(0), *byte),
            }
        });
        self.note(result)
    }

    /// Ends a download: all bytes of the file were taken. `program` becomes the new one.
    pub fn finish<S: Slot>(&mut self, slot: &mut S, program: &mut Program) -> Result<(), Failure> {
        let result = self.complete(slot);
        if let Ok(new) = result {
            *program = new;
            self.stage = Stage::Closed;
            self.downgrade = false;
        }
        self.note(result.map(|_| ()))
    }

    fn note(&mut self, result: Result<(), Failure>) -> Result<(), Failure> {
        if let Err(failure) = result {
            self.stage = Stage::Closed;
            self.status = failure.status();
        }
        result
    }

    /// Takes a byte of the header or of the signature.
    fn take_header<S: Slot>(&mut self, place: usize, byte: u8) {
        match place.checked_sub(SIZE) {
            Some(place) => put(&mut self.signature, place, byte),
            None => put(&mut self.first, PLACE + place, byte),
        }
        if S::SIGNATURES && place + 1 == SIZE {
            self.signed = self.header().map_or(0, |header| header.signature());
        }
    }

    /// The number of bytes in the file before the body.
    fn before<S: Slot>(&self) -> usize {
        match S::SIGNATURES {
            true => SIZE + self.signed,
            false => SIZE,
        }
    }

    /// The header in the first page.
    fn header(&self) -> Result<Header, Failure> {
        let bytes = self.first.get(PLACE..).and_then(<[u8]>::first_chunk);
        bytes.and_then(Header::parse).ok_or(Failure::Format)
    }

    /// Takes a byte of the first page. The header is in its place already.
    fn take_first<S: Slot>(
        &mut self,
        slot: &mut S,
        device: &Device,
        program: &mut Program,
        place: usize,
        byte: u8,
    ) -> Result<(), Failure> {
        if !(PLACE..PLACE + SIZE).contains(&place) {
            put(&mut self.first, place, byte);
        }
        if place + 1 < PAGE {
            return Ok(());
        }
        let header = self.header()?;
        let present = program.header().map(|present| present.version());
        let present = present.filter(|_| !self.downgrade);
        let first_page = slot.crc(&first_page_parts(&self.first));
        header.check(first_page, device, S::SIZE, present)?;
        let signature = self.signature.get(..self.signed);
        if let Some(key) = slot.key()
            && !signature.is_some_and(|it| key.verifies(header.bytes(), it))
        {
            return Err(Failure::Unsigned);
        }
        self.length = header.length();
        self.stage = Stage::Loading;
        *program = slot.other();
        // Without its first half-word, the header is never valid again, also if the power is cut during the erase.
        slot.program(PLACE, &[0, 0])?;
        Ok(slot.erase(0)?)
    }

    fn take_rest<S: Slot>(&mut self, slot: &mut S, place: usize, byte: u8) -> Result<(), Failure> {
        if place >= self.length {
            return Err(Failure::Length);
        }
        if place.is_multiple_of(S::PAGE) {
            slot.erase(place / S::PAGE)?;
        }
        put(&mut self.rest, place % PIECE, byte);
        self.program_rest(slot, place + 1)
    }

    /// Programs the bytes before `end` that are not programmed yet, if a piece or the body ends there.
    fn program_rest<S: Slot>(&mut self, slot: &mut S, end: usize) -> Result<(), Failure> {
        let start = (end - 1) / PIECE * PIECE;
        let bytes = self.rest.get(..end - start).unwrap_or_default();
        if bytes.len() == PIECE || end == self.length {
            slot.program(start, bytes)?;
        }
        Ok(())
    }

    fn complete<S: Slot>(&mut self, slot: &mut S) -> Result<Program, Failure> {
        match self.stage {
            Stage::Closed => return Err(Failure::NotCleared),
            Stage::Loading if self.received == self.before::<S>() + self.length => {}
            Stage::Heading | Stage::Loading => return Err(Failure::Length),
        }
        let (before, rest) = self.first.split_at(COMMIT);
        slot.program(0, before)?;
        slot.program(COMMIT + 2, rest.get(2..).unwrap_or_default())?;
        match Program::of(slot) {
            program @ Program::Uncommitted(_) => Ok(program.complete(slot)?),
            Program::None | Program::Complete(_) => Err(Failure::Data),
        }
    }
}

fn put(bytes: &mut [u8], place: usize, byte: u8) {
    if let Some(to) = bytes.get_mut(place) {
        *to = byte;
    }
}

#[cfg(test)]
mod tests;
