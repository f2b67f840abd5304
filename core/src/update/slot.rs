//! The flash of the program.

use super::header::{COMMIT, Header, PLACE, SIZE, body_parts, crc, first_page_parts};
use super::lms::PublicKey;

/// The flash operation failed, or the flash does not contain what was programmed.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct SlotError;

/// The flash of the program, behind the bootloader.
pub trait Slot {
    /// The size of a page in bytes, the smallest part that can be erased: at least [`PAGE`](super::header::PAGE).
    const PAGE: usize;
    /// The size of the slot in bytes.
    const SIZE: usize;
    /// Whether image files with a signature are taken.
    const SIGNATURES: bool = false;

    /// The program that the sensor still has while a download replaces the contents of this slot: the one in another slot.
    fn other(&self) -> Program {
        Program::None
    }

    /// The contents.
    fn bytes(&self) -> &[u8];

    /// Erases the page with this number.
    fn erase(&mut self, page: usize) -> Result<(), SlotError>;

    /// Programs bytes, and compares them. Place and length are multiples of 2. The place is erased; but a half-word of 0000h can be
    /// programmed over any other.
    fn program(&mut self, place: usize, bytes: &[u8]) -> Result<(), SlotError>;

    /// The key that must have signed each image. None: images without a signature are taken.
    fn key(&self) -> Option<&PublicKey> {
        None
    }

    /// The [CRC](crc()) of these parts. A board has a unit for it.
    fn crc(&self, parts: &[&[u8]]) -> u32 {
        crc(parts)
    }
}

/// The program in a slot.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Program {
    /// There is no complete program.
    None,
    /// It can be started.
    Complete(Header),
    /// All but its commit is there: the power was cut during the commit, or just before it.
    Uncommitted(Header),
}

impl Program {
    /// The program in a slot. Its whole CRC is compared. With a key, the SHA-256 of a program without its commit must be that of its header,
    /// which is signed: other programs with the same CRC can be made.
    pub fn of(slot: &impl Slot) -> Self {
        let bytes = slot.bytes();
        let header = bytes.get(PLACE..).and_then(<[u8]>::first_chunk::<SIZE>);
        let Some(header) = header.and_then(Header::parse) else {
            return Self::None;
        };
        let Some(body) = bytes.get(..header.length()) else {
            return Self::None;
        };
        let is_intact = slot.crc(&first_page_parts(body)) == header.first_page()
            && slot.crc(&body_parts(body)) == header.body();
        match bytes.get(COMMIT..COMMIT + 2) {
            _ if !is_intact => Self::None,
            Some([0, 0]) => Self::Complete(header),
            _ if slot.key().is_some() && !header.is_of(body) => Self::None,
            _ => Self::Uncommitted(header),
        }
    }

    /// The program after a start: an uncommitted one is completed. If the flash fails, it must be loaded again.
    pub fn committed(self, slot: &mut impl Slot) -> Self {
        self.complete(slot).unwrap_or(Self::None)
    }

    /// Its header, if it is complete.
    pub fn header(&self) -> Option<&Header> {
        match self {
            Self::Complete(header) => Some(header),
            Self::None | Self::Uncommitted(_) => None,
        }
    }

    /// Commits an uncommitted program. Returns the program that can be started.
    pub(super) fn complete(self, slot: &mut impl Slot) -> Result<Self, SlotError> {
        match self {
            Self::Uncommitted(header) => {
                slot.program(COMMIT, &[0, 0])?;
                Ok(Self::Complete(header))
            }
            _ => Ok(self),
        }
    }
}
