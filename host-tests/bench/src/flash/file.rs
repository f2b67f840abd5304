//! A file as a flash memory: killing and restarting the program is a power cycle.

use super::Geometry;
use crate::file;
use std::fs::{File, OpenOptions};
use std::io::{self, ErrorKind, Read, Seek, SeekFrom, Write};
use std::ops::Range;
use std::path::{Path, PathBuf};

/// The file of a flash memory. It is opened for each change, so that it may be removed and created again.
#[derive(Debug)]
pub(super) struct FlashFile {
    path: PathBuf,
    /// Keeps the file locked, if it existed when it was opened.
    _lock: Option<File>,
}

impl FlashFile {
    /// Reads the memory from `path`; None when the file does not exist or is empty. Missing bytes at the end of a truncated file
    /// read as erased. The file is locked until the memory is dropped.
    ///
    /// # Errors
    /// The file cannot be read, is not a regular file ([`ErrorKind::InvalidInput`]), is in use by another program
    /// ([`ErrorKind::ResourceBusy`]), or is too long or
    /// does not begin like a memory ([`ErrorKind::InvalidData`]): such a file has another purpose and must not be overwritten.
    pub(super) fn open(path: &Path, size: usize) -> io::Result<(Self, Option<Vec<u8>>)> {
        let mut own = Self {
            path: path.to_owned(),
            _lock: None,
        };
        let opened = match file::open(path).map_err(io::Error::from) {
            Err(error) if error.kind() == ErrorKind::NotFound => return Ok((own, None)),
            opened => opened?,
        };
        // On Windows a lock would also refuse the writes of this program.
        #[cfg(unix)]
        match opened.try_lock() {
            Ok(()) => {}
            Err(std::fs::TryLockError::WouldBlock) => {
                let what = "another program uses it";
                return Err(io::Error::new(ErrorKind::ResourceBusy, what));
            }
            // Not every file can be locked.
            Err(std::fs::TryLockError::Error(_)) => {}
        }
        let mut bytes = first_bytes(&opened, size + 1)?;
        if bytes.len() > size {
            let what =
                format!("the file is longer than the {size} bytes of the memory of a sensor");
            return Err(io::Error::new(ErrorKind::InvalidData, what));
        }
        if is_foreign(&bytes) {
            let what = "the file is not the memory of a sensor";
            return Err(io::Error::new(ErrorKind::InvalidData, what));
        }
        own._lock = Some(opened);
        if bytes.is_empty() {
            return Ok((own, None));
        }
        bytes.resize(size, 0xFF);
        Ok((own, Some(bytes)))
    }

    /// Writes a change: `memory` is the complete memory after the change, `changed` the range of changed bytes. Only that range
    /// is written, so that killing the program leaves the same content as a power cut.
    pub(super) fn write(&self, memory: &[u8], changed: Range<usize>) -> io::Result<()> {
        let mut file = OpenOptions::new()
            .write(true)
            .create(true)
            .truncate(false)
            .open(&self.path)?;
        let range = if is_complete(&file, memory)? {
            changed
        } else {
            0..memory.len()
        };
        file.seek(SeekFrom::Start(range.start as u64))?;
        file.write_all(&memory[range])
    }

    /// Says that the file cannot be written.
    pub(super) fn unwritten(&self, why: &io::Error) -> String {
        format!("cannot write the store {}: {why}", self.path.display())
    }
}

/// Whether a file has another purpose: its length is that of no memory, and it begins neither with a record nor erased.
fn is_foreign(bytes: &[u8]) -> bool {
    let memory = Geometry::of_file(bytes.len() as u64);
    let is_complete = memory.is_some_and(|memory| memory.size() == bytes.len());
    let begins = matches!(bytes, [] | [0xFF, ..] | [b'P'] | [b'P', 1, ..]);
    !is_complete && !begins
}

/// False for a file that was just created.
fn is_complete(file: &File, memory: &[u8]) -> io::Result<bool> {
    Ok(file.metadata()?.len() == memory.len() as u64)
}

/// The first bytes of a file, `most` at most: a file can be endless.
pub(super) fn first_bytes(file: &File, most: usize) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    file.take(most as u64).read_to_end(&mut bytes)?;
    Ok(bytes)
}
