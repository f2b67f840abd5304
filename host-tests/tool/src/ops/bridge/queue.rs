//! The records that wait for the broker, in files of a folder: they survive a restart of the program and of the computer.
//!
//! ```text
//! 00000000000000000001.records    the records from number 1 on
//! 00000000000000031234.records    those from number 31234 on
//! acknowledged                    the first number that the broker has not acknowledged, as text
//! lock                            locked by the program that uses the folder; its text is the start of the computer, or `ended`
//! ```
//!
//! A record is its length and its CRC-32 (both 32 bits, little endian), and its bytes. Its number is its place. A file whose records are all
//! acknowledged is deleted. If all files together are too long, the oldest one is deleted, and its records are lost.
//!
//! A power cut can lose records that the broker has already, so their numbers must not be used again: if the computer has started anew since
//! the last use, and the program did not end by itself, many numbers are left out.

mod record;

use crate::error::{BrokerError, Error, FileError};
use record::{encoded, record, valid};
use std::collections::VecDeque;
use std::fs::{self, File, OpenOptions, TryLockError};
use std::io::{self, BufReader, Read, Seek, Write};
use std::path::{Path, PathBuf};

/// The length from which on a file is followed by another one.
const FILE_LENGTH: u64 = 4 << 20;

/// The numbers that are left out after a power cut: more than a bus has samples in the time that is not on the disk.
const LEFT_OUT: u64 = 100_000;

/// The text of the lock after a program has ended by itself.
const ENDED: &str = "ended";

/// Linux tells the start of the computer here. Elsewhere each program that has not ended by itself counts as a power cut.
const START: &str = "/proc/sys/kernel/random/boot_id";

/// The text of the lock if the start is not known.
const UNKNOWN: &str = "unknown";

/// The extension of the files with records.
const EXTENSION: &str = "records";

/// The name of the file with the first number that is not acknowledged.
const ACKNOWLEDGED: &str = "acknowledged";

/// A file with records.
struct Segment {
    /// The number of its first record.
    first: u64,
    count: u64,
    length: u64,
}

impl Segment {
    /// Its records from this number on.
    fn waiting(&self, acknowledged: u64) -> u64 {
        (self.first + self.count).saturating_sub(acknowledged.max(self.first))
    }
}

/// The records that wait.
pub struct Queue {
    folder: PathBuf,
    /// The oldest one first. The last one is written.
    segments: VecDeque<Segment>,
    writer: Option<File>,
    /// The number of the next record.
    next: u64,
    /// The first number that is not acknowledged, and what the file says.
    acknowledged: u64,
    kept: u64,
    /// The maximum length of all files.
    limit: u64,
    /// The records that were lost since the last question.
    lost: u64,
    lock: File,
}

/// The place of a reader; a new one is at the first record that is not acknowledged.
#[derive(Default)]
pub struct Cursor {
    /// The number of the next record.
    pub next: u64,
    /// The file with the place, and the number of its first record.
    file: Option<(u64, BufReader<File>)>,
}

impl Queue {
    /// Opens the folder, or makes it. Records of an earlier program that are damaged are left out.
    ///
    /// # Errors
    /// The folder cannot be read or written, or another program uses it.
    pub fn open(folder: &Path, limit: u64) -> Result<Self, Error> {
        let name = || folder.display().to_string();
        let failed = |error: io::Error| FileError::FolderUnwritten(name(), error.to_string());
        fs::create_dir_all(folder).map_err(failed)?;
        let mut options = OpenOptions::new();
        let options = options.read(true).write(true).create(true).truncate(false);
        let lock = options.open(folder.join("lock")).map_err(failed)?;
        lock.try_lock().map_err(|error| match error {
            TryLockError::WouldBlock => Error::from(BrokerError::BufferInUse(name())),
            TryLockError::Error(error) => failed(error).into(),
        })?;
        let mut firsts: Vec<u64> = Vec::new();
        for entry in fs::read_dir(folder).map_err(failed)? {
            let path = entry.map_err(failed)?.path();
            let stem = path.file_stem().and_then(|stem| stem.to_str());
            let first = stem.and_then(|stem| stem.parse::<u64>().ok());
            firsts.extend(first.filter(|_| path.extension().is_some_and(|own| own == EXTENSION)));
        }
        firsts.sort_unstable();
        let kept = fs::read_to_string(folder.join(ACKNOWLEDGED)).unwrap_or_default();
        let kept = kept.trim().parse().unwrap_or(0);
        let mut queue = Self {
            folder: folder.to_owned(),
            segments: VecDeque::new(),
            writer: None,
            next: kept.max(1),
            acknowledged: kept.max(1),
            kept,
            limit,
            lost: 0,
            lock,
        };
        for first in firsts {
            let path = queue.path(first);
            let (count, length) = valid(&path).map_err(failed)?;
            // What comes after damaged bytes has no number.
            let file = OpenOptions::new().write(true).open(&path);
            file.and_then(|file| file.set_len(length)).map_err(failed)?;
            queue.segments.push_back(Segment {
                first,
                count,
                length,
            });
            queue.next = queue.next.max(first + count);
        }
        let oldest = queue.segments.front().map_or(queue.next, |own| own.first);
        queue.acknowledged = queue.acknowledged.max(oldest).min(queue.next);
        let start = fs::read_to_string(START).unwrap_or_else(|_| UNKNOWN.to_owned());
        queue.begin(start.trim()).map_err(failed)?;
        queue.clear();
        Ok(queue)
    }

    /// Takes the folder over from its last user.
    fn begin(&mut self, start: &str) -> io::Result<()> {
        let mut last = String::new();
        self.lock.read_to_string(&mut last)?;
        let is_same = last == start && start != UNKNOWN;
        if !last.is_empty() && last != ENDED && !is_same {
            let waits = self.waiting() > 0;
            self.next += LEFT_OUT;
            if !waits {
                self.acknowledged = self.next;
            }
            // The start after this one must know it too, even if no record follows.
            self.follow()?;
            self.sync()?;
        }
        self.mark(start)
    }

    fn mark(&mut self, text: &str) -> io::Result<()> {
        self.lock.set_len(0)?;
        self.lock.rewind()?;
        self.lock.write_all(text.as_bytes())?;
        self.lock.sync_all()
    }

    /// The program ends by itself: everything is on the disk.
    ///
    /// # Errors
    /// A file cannot be written.
    pub fn end(&mut self) -> io::Result<()> {
        self.sync()?;
        self.mark(ENDED)
    }

    fn path(&self, first: u64) -> PathBuf {
        self.folder.join(format!("{first:020}.{EXTENSION}"))
    }

    /// The number of the next record.
    pub fn next(&self) -> u64 {
        self.next
    }

    /// The records that wait for an acknowledgement.
    pub fn waiting(&self) -> u64 {
        let each = self.segments.iter();
        each.map(|own| own.waiting(self.acknowledged)).sum()
    }

    /// The records that were lost since the last call, because the files were too long or the disk is full.
    pub fn take_lost(&mut self) -> u64 {
        std::mem::take(&mut self.lost)
    }

    /// Adds a record with these bytes.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn push(&mut self, bytes: &[u8]) -> Result<(), Error> {
        let record = encoded(bytes);
        loop {
            match self.append(&record) {
                Ok(()) => break,
                // A disk that is full has room again without the oldest records.
                Err(_) if self.segments.len() > 1 => self.lose_oldest(),
                Err(error) => {
                    let name = self.folder.display().to_string();
                    return Err(FileError::FolderUnwritten(name, error.to_string()).into());
                }
            }
        }
        self.next += 1;
        while self.segments.len() > 1 && self.length() > self.limit {
            self.lose_oldest();
        }
        Ok(())
    }

    fn length(&self) -> u64 {
        self.segments.iter().map(|own| own.length).sum()
    }

    /// Goes on with a new file.
    fn follow(&mut self) -> io::Result<()> {
        self.sync()?;
        let first = self.next;
        self.writer = Some(File::create(self.path(first))?);
        // The file of an earlier program with no valid record has the same name.
        self.segments.retain(|own| own.first != first);
        self.segments.push_back(Segment {
            first,
            count: 0,
            length: 0,
        });
        Ok(())
    }

    fn append(&mut self, record: &[u8]) -> io::Result<()> {
        let is_full = |own: &Segment| own.length >= FILE_LENGTH.min(self.limit / 2);
        if self.writer.is_none() || self.segments.back().is_none_or(is_full) {
            self.follow()?;
        }
        let (Some(writer), Some(last)) = (&mut self.writer, self.segments.back_mut()) else {
            return Ok(());
        };
        if let Err(error) = writer.write_all(record) {
            writer.set_len(last.length)?;
            writer.seek(io::SeekFrom::End(0))?;
            return Err(error);
        }
        last.count += 1;
        last.length += record.len() as u64;
        Ok(())
    }

    fn lose_oldest(&mut self) {
        let Some(oldest) = self.segments.pop_front() else {
            return;
        };
        // The next start would read it again.
        let _ = fs::remove_file(self.path(oldest.first));
        let first = self.segments.front().map_or(self.next, |own| own.first);
        self.lost += oldest.waiting(self.acknowledged);
        self.acknowledged = self.acknowledged.max(first);
    }

    /// The next records of a reader, with their numbers.
    ///
    /// # Errors
    /// A file cannot be read.
    pub fn read(&mut self, cursor: &mut Cursor, most: usize) -> io::Result<Vec<(u64, Vec<u8>)>> {
        let mut records = Vec::new();
        cursor.next = cursor.next.max(self.acknowledged);
        while records.len() < most && cursor.next < self.next {
            let place = self
                .segments
                .partition_point(|own| own.first <= cursor.next);
            let Some(first) = place.checked_sub(1).map(|place| self.segments[place].first) else {
                // The records before the oldest file are lost.
                cursor.next = self.segments.front().map_or(self.next, |own| own.first);
                continue;
            };
            if cursor.file.as_ref().is_none_or(|(own, _)| *own != first) {
                let mut file = BufReader::new(File::open(self.path(first))?);
                for _ in first..cursor.next {
                    record(&mut file)?;
                }
                cursor.file = Some((first, file));
            }
            let read = cursor.file.as_mut().map(|(_, file)| record(file));
            match read.transpose()?.flatten() {
                Some(bytes) => {
                    records.push((cursor.next, bytes));
                    cursor.next += 1;
                }
                // The rest of the file was damaged.
                None => {
                    let following = self.segments.get(place).map(|own| own.first);
                    cursor.next = following.unwrap_or(self.next);
                }
            }
        }
        Ok(records)
    }

    /// All records before this number are acknowledged.
    pub fn acknowledge(&mut self, before: u64) {
        self.acknowledged = self.acknowledged.max(before.min(self.next));
        self.clear();
    }

    /// Deletes the files whose records are all acknowledged.
    fn clear(&mut self) {
        let is_done = self.acknowledged == self.next;
        let last_is_long = self.segments.back().is_some_and(|own| own.length > 0);
        while let Some(first) = self.segments.front().map(|own| own.first) {
            let end = self.segments.get(1).map(|own| own.first);
            let is_over = match end {
                Some(end) => end <= self.acknowledged,
                None => is_done && last_is_long && self.is_due(),
            };
            // The number must not begin again without files.
            if !is_over || self.keep().is_err() {
                break;
            }
            let path = self.path(first);
            self.segments.pop_front();
            if self.segments.is_empty() {
                self.writer = None;
            }
            // The next start deletes it.
            let _ = fs::remove_file(path);
        }
    }

    /// A file of acknowledged records is deleted before it is long, as soon as it would be written to the disk often.
    fn is_due(&self) -> bool {
        self.writer.is_none() || self.length() > FILE_LENGTH / 16
    }

    /// Writes the first number that is not acknowledged.
    fn keep(&mut self) -> io::Result<()> {
        if self.kept == self.acknowledged {
            return Ok(());
        }
        let new = self.folder.join("acknowledged.new");
        let mut file = File::create(&new)?;
        writeln!(file, "{}", self.acknowledged)?;
        file.sync_all()?;
        fs::rename(new, self.folder.join(ACKNOWLEDGED))?;
        self.kept = self.acknowledged;
        Ok(())
    }

    /// Brings everything to the disk.
    ///
    /// # Errors
    /// A file cannot be written.
    pub fn sync(&mut self) -> io::Result<()> {
        if let Some(writer) = &self.writer {
            writer.sync_data()?;
        }
        self.keep()
    }
}

impl Drop for Queue {
    fn drop(&mut self) {
        // A program that is just being started by this one has a copy of the file, which would keep the lock for a moment.
        let _ = self.lock.unlock();
    }
}

#[cfg(test)]
mod tests;
