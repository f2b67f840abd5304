//! A microcontroller's flash memory: two pages as on the STM32F103 or two sectors as on the STM32F446, with a fuse that cuts the
//! power and with faults.
//!
//! The rules of the real memory apply. The STM32F103 is programmed in half-words, and only an erased half-word can be programmed,
//! except to 0000h (reference manual RM0008/PM0075: PGERR). On the STM32F446 a unit of one to eight bytes can be programmed again:
//! then its bits can only change to 0 (RM0390, section 3.6). A memory is erased in pages. A power cut leaves an operation
//! incomplete.

mod faults;
mod file;
mod geometry;
mod operations;
#[cfg(test)]
mod tests;

use embedded_storage::nor_flash::{NorFlashError, NorFlashErrorKind};
use faults::Fuse;
use file::{FlashFile, first_bytes};
pub use geometry::{Geometry, PAGE_SIZE};
use std::io;
use std::path::Path;

/// The reason for a failed operation.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum FlashError {
    /// The power is off, or was cut during an operation.
    PowerCut,
    /// A half-word that is not erased cannot be programmed to anything but 0000h (STM32F103).
    NotErased,
    /// The memory is faulty, or its file cannot be written.
    Broken,
    /// Out of bounds, or not aligned.
    Address(NorFlashErrorKind),
}

impl NorFlashError for FlashError {
    fn kind(&self) -> NorFlashErrorKind {
        match self {
            Self::Address(kind) => *kind,
            _ => NorFlashErrorKind::Other,
        }
    }
}

/// The operations that failed because of the file.
#[derive(Default, Debug)]
struct Unwritten {
    /// Why the file cannot be written; None: the last operation has written it.
    why: Option<String>,
    /// The number of these operations.
    count: u64,
}

/// Pages or sectors of flash, for example those with the records of a node. Operations can fail, and the power can be cut at any byte.
#[derive(Debug)]
pub struct Flash {
    geometry: Geometry,
    bytes: Vec<u8>,
    file: Option<FlashFile>,
    unwritten: Unwritten,
    fuse: Option<Fuse>,
    cut: bool,
    fail_writes: bool,
    fail_erases: bool,
    worn: Vec<usize>,
    programmed: u64,
    erased: u64,
    operations: u64,
    last: Option<usize>,
    random: u64,
}

impl Default for Flash {
    /// An erased memory of the STM32F103.
    fn default() -> Self {
        Self::blank(Geometry::STM32F103)
    }
}

impl Flash {
    /// A memory of the STM32F103 with this content.
    ///
    /// # Panics
    /// When the size is not that of the memory.
    pub fn new(bytes: Vec<u8>) -> Self {
        Self::with_content(Geometry::STM32F103, bytes)
    }

    /// A memory in which nothing was programmed: all bytes are FFh.
    pub fn blank(geometry: Geometry) -> Self {
        Self::with_content(geometry, vec![0xFF; geometry.size()])
    }

    /// A memory with this content.
    ///
    /// # Panics
    /// When the size is not that of the memory.
    pub fn with_content(geometry: Geometry, bytes: Vec<u8>) -> Self {
        assert_eq!(bytes.len(), geometry.size(), "{geometry:?}");
        Self {
            geometry,
            bytes,
            file: None,
            unwritten: Unwritten::default(),
            fuse: None,
            cut: false,
            fail_writes: false,
            fail_erases: false,
            worn: Vec::new(),
            programmed: 0,
            erased: 0,
            operations: 0,
            last: None,
            random: 0x9E37_79B9_7F4A_7C15,
        }
    }

    /// A memory in a file: erased when the file does not exist yet; every change is written to the file. While the file cannot be
    /// written, programming and erasing fail.
    ///
    /// # Errors
    /// The file exists but cannot be read, is not a regular file ([`io::ErrorKind::InvalidInput`]), is in use by another program
    /// ([`io::ErrorKind::ResourceBusy`]), or is longer than the memory or has another purpose ([`io::ErrorKind::InvalidData`]).
    pub fn in_file(geometry: Geometry, path: &Path) -> io::Result<Self> {
        let (file, bytes) = FlashFile::open(path, geometry.size())?;
        let bytes = bytes.unwrap_or_else(|| vec![0xFF; geometry.size()]);
        Ok(Self {
            file: Some(file),
            ..Self::with_content(geometry, bytes)
        })
    }

    /// A memory with the first bytes of a file that cannot be used for this reason. Programming and erasing fail, and the file is not
    /// changed.
    pub fn unusable(geometry: Geometry, path: &Path, why: String) -> Self {
        let size = geometry.size();
        let file = crate::file::open(path).map_err(io::Error::from);
        let bytes = file.and_then(|file| first_bytes(&file, size));
        let mut bytes = bytes.unwrap_or_default();
        bytes.resize(size, 0xFF);
        Self {
            fail_writes: true,
            fail_erases: true,
            unwritten: Unwritten {
                why: Some(why),
                count: 0,
            },
            ..Self::with_content(geometry, bytes)
        }
    }

    /// Number and size of the pages, and the unit of programming.
    pub fn geometry(&self) -> Geometry {
        self.geometry
    }

    /// The content of the memory.
    pub fn bytes(&self) -> &[u8] {
        &self.bytes
    }

    /// The number of bytes that were programmed since the start, as a measure of wear.
    pub fn programmed(&self) -> u64 {
        self.programmed
    }

    /// The number of pages that were erased since the start.
    pub fn erased(&self) -> u64 {
        self.erased
    }

    /// The number of units that were programmed and pages that were erased since the start, with those in which the power was cut.
    pub fn operations(&self) -> u64 {
        self.operations
    }

    /// Why the file of the memory cannot be written, as a sentence; None: there is no file, or it was written last.
    pub fn unwritten(&self) -> Option<&str> {
        self.unwritten.why.as_deref()
    }

    /// The number of operations that have failed since the start because the file could not be written.
    pub fn unwritten_operations(&self) -> u64 {
        self.unwritten.count
    }

    /// An operation of a memory that fails.
    fn broken(&mut self) -> FlashError {
        self.unwritten.count += u64::from(self.unwritten.why.is_some());
        FlashError::Broken
    }

    /// Changes bytes in the memory and in the file; in neither when the file cannot be written.
    fn put(&mut self, at: usize, bytes: &[u8]) -> Result<(), FlashError> {
        let range = at..at + bytes.len();
        if let Some(file) = &self.file {
            let mut after = self.bytes.clone();
            after[range.clone()].copy_from_slice(bytes);
            let written = file.write(&after, range.clone());
            self.unwritten.why = written.err().map(|error| file.unwritten(&error));
            if self.unwritten.why.is_some() {
                return Err(self.broken());
            }
        }
        self.bytes[range].copy_from_slice(bytes);
        Ok(())
    }

    fn powered(&self) -> Result<(), FlashError> {
        if self.cut {
            return Err(FlashError::PowerCut);
        }
        Ok(())
    }
}
