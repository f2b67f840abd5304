//! A file as a flash memory: killing and restarting the program is a power cycle.

use std::fs::{self, File, OpenOptions};
use std::io::{self, ErrorKind, Seek, SeekFrom, Write};
use std::ops::Range;
use std::path::{Path, PathBuf};

/// The file of a flash memory. It is opened for each change, so that it may be removed and created again.
#[derive(Debug)]
pub(super) struct FlashFile {
    path: PathBuf,
}

impl FlashFile {
    /// Reads the memory from `path`; None when the file does not exist or is empty. Missing bytes at the end of a truncated file
    /// read as erased.
    ///
    /// # Errors
    /// The file cannot be read, or is too long: such a file has another purpose and must not be overwritten.
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
            let what = format!("the file has {length} bytes, the memory of a sensor has {size}");
            return Err(io::Error::new(ErrorKind::InvalidData, what));
        }
        bytes.resize(size, 0xFF);
        Ok((file, Some(bytes)))
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
}

/// False for a file that was just created.
fn is_complete(file: &File, memory: &[u8]) -> io::Result<bool> {
    Ok(file.metadata()?.len() == memory.len() as u64)
}
