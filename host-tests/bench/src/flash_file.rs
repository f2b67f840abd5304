//! A file that stands for a flash memory, so that a program that is killed and started again is a power cycle.

use std::fs::{self, File, OpenOptions};
use std::io::{self, ErrorKind, Seek, SeekFrom, Write};
use std::ops::Range;
use std::path::{Path, PathBuf};

/// The file behind a flash memory. It is opened for each change, so that it may come and go.
#[derive(Debug)]
pub(super) struct FlashFile {
    path: PathBuf,
}

impl FlashFile {
    /// Reads the memory from `path`; None when there is no file yet or it is empty. What is missing at the end of a file that was
    /// cut off reads as erased.
    ///
    /// # Errors
    /// A file that cannot be read, or one that is too long: it is something else and must not be overwritten.
    pub(super) fn open(path: &Path, size: usize) -> io::Result<(Self, Option<Vec<u8>>)> {
        let file = Self {
            path: path.to_owned(),
        };
        let mut bytes = match fs::read(path) {
            Err(error) if error.kind() == ErrorKind::NotFound => return Ok((file, None)),
            bytes => bytes?,
        };
        if bytes.is_empty() {
            return Ok((file, None));
        }
        if bytes.len() > size {
            let length = bytes.len();
            let what = format!("it has {length} bytes, and a sensor's memory has {size}");
            return Err(io::Error::new(ErrorKind::InvalidData, what));
        }
        bytes.resize(size, 0xFF);
        Ok((file, Some(bytes)))
    }

    /// Writes what changed: `memory` is the whole memory after the change, `changed` the bytes that differ. Nothing else is
    /// touched, so that being killed in between leaves what a power cut leaves.
    pub(super) fn write(&self, memory: &[u8], changed: Range<usize>) -> io::Result<()> {
        let mut file = OpenOptions::new()
            .write(true)
            .create(true)
            .truncate(false)
            .open(&self.path)?;
        let range = if is_whole(&file, memory)? {
            changed
        } else {
            0..memory.len()
        };
        file.seek(SeekFrom::Start(range.start as u64))?;
        file.write_all(&memory[range])
    }
}

/// False for a file that was only just created.
fn is_whole(file: &File, memory: &[u8]) -> io::Result<bool> {
    Ok(file.metadata()?.len() == memory.len() as u64)
}
