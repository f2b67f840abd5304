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
//! the last use, and the program did not end by itself, or if the end of the newest file is damaged, many numbers are left out.
//!
//! While the disk is full, new records are lost, each with its number: the next one begins a file.

mod read;
mod record;
mod unsynced;

use crate::error::{BrokerError, Error, FileError};
pub use read::Cursor;
use record::{encoded, valid};
use std::collections::VecDeque;
use std::fs::{self, File, OpenOptions, TryLockError};
use std::io::{self, ErrorKind, Read, Seek, Write};
use std::path::{Path, PathBuf};
use unsynced::ACKNOWLEDGED;
pub use unsynced::Unsynced;

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
    /// Files that were completed since the last [`unsynced`](Self::unsynced).
    completed: Vec<File>,
    lost: Lost,
    lock: File,
}

/// What was lost since the last question.
#[derive(Clone, Copy, PartialEq, Eq, Default, Debug)]
pub struct Lost {
    /// Records, because all files together were too long.
    pub limit: u64,
    /// Records, because the disk is full.
    pub disk: u64,
    /// Records are lost because a file is damaged.
    pub is_damaged: bool,
}

/// Whether there can be space later.
pub fn is_full(error: &io::Error) -> bool {
    matches!(
        error.kind(),
        ErrorKind::StorageFull | ErrorKind::QuotaExceeded | ErrorKind::FileTooLarge
    )
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
            completed: Vec::new(),
            lost: Lost::default(),
            lock,
        };
        let mut is_cut = false;
        for first in firsts {
            let path = queue.path(first);
            let (count, length) = valid(&path).map_err(failed)?;
            // What comes after damaged bytes has no number.
            let file = OpenOptions::new().write(true).open(&path).map_err(failed)?;
            is_cut = file.metadata().map_err(failed)?.len() > length;
            queue.lost.is_damaged |= is_cut;
            file.set_len(length).map_err(failed)?;
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
        queue.begin(start.trim(), is_cut).map_err(failed)?;
        queue.clear();
        Ok(queue)
    }

    /// Takes the folder over from its last user. `is_cut`: the end of the newest file was damaged.
    fn begin(&mut self, start: &str, is_cut: bool) -> io::Result<()> {
        let mut last = String::new();
        self.lock.read_to_string(&mut last)?;
        let is_same = last == start && start != UNKNOWN;
        if is_cut || !last.is_empty() && last != ENDED && !is_same {
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

    /// Writes the text of the lock in place, which needs no space on a full disk.
    fn mark(&mut self, text: &str) -> io::Result<()> {
        self.lock.rewind()?;
        self.lock.write_all(text.as_bytes())?;
        self.lock.set_len(text.len() as u64)?;
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

    /// What was lost since the last call.
    pub fn take_lost(&mut self) -> Lost {
        std::mem::take(&mut self.lost)
    }

    /// Adds a record with these bytes. On a full disk the oldest file makes room; if there is no other one, this record is lost.
    ///
    /// # Errors
    /// The file cannot be written, for another reason.
    pub fn push(&mut self, bytes: &[u8]) -> Result<(), Error> {
        let record = encoded(bytes);
        loop {
            match self.append(&record) {
                Ok(()) => break,
                Err(error) if !is_full(&error) => {
                    let name = self.folder.display().to_string();
                    return Err(FileError::FolderUnwritten(name, error.to_string()).into());
                }
                Err(_) if self.segments.len() > 1 => self.lost.disk += self.lose_oldest(),
                Err(_) => {
                    self.lost.disk += 1;
                    self.complete();
                    break;
                }
            }
        }
        self.next += 1;
        while self.segments.len() > 1 && self.length() > self.limit {
            self.lost.limit += self.lose_oldest();
        }
        Ok(())
    }

    /// The next record begins a new file.
    fn complete(&mut self) {
        let Some(writer) = self.writer.take() else {
            return;
        };
        match self.segments.pop_back() {
            Some(own) if own.count == 0 => {
                // The next start would take it for one without records.
                let _ = fs::remove_file(self.path(own.first));
            }
            last => {
                self.segments.extend(last);
                self.completed.push(writer);
            }
        }
    }

    fn length(&self) -> u64 {
        self.segments.iter().map(|own| own.length).sum()
    }

    /// Goes on with a new file.
    fn follow(&mut self) -> io::Result<()> {
        self.complete();
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
            // Without a part of a record. If this fails, the next start leaves the part out.
            let place = io::SeekFrom::Start(last.length);
            let _ = writer
                .set_len(last.length)
                .and_then(|()| writer.seek(place));
            return Err(error);
        }
        last.count += 1;
        last.length += record.len() as u64;
        Ok(())
    }

    /// Deletes the oldest file. Returns the number of its records that wait.
    fn lose_oldest(&mut self) -> u64 {
        let Some(oldest) = self.segments.pop_front() else {
            return 0;
        };
        // The next start would read it again.
        let _ = fs::remove_file(self.path(oldest.first));
        let first = self.segments.front().map_or(self.next, |own| own.first);
        let lost = oldest.waiting(self.acknowledged);
        self.acknowledged = self.acknowledged.max(first);
        lost
    }

    /// All records before this number are acknowledged.
    pub fn acknowledge(&mut self, before: u64) {
        self.acknowledged = self.acknowledged.max(before.min(self.next));
        if self.waiting() == 0 {
            self.acknowledged = self.next;
        }
    }

    /// Deletes the files whose records are all acknowledged, by the number that is on the disk: it must not begin again without files.
    fn clear(&mut self) {
        let is_done = self.kept == self.next;
        let last_is_long = self.segments.back().is_some_and(|own| own.length > 0);
        while let Some(first) = self.segments.front().map(|own| own.first) {
            let end = self.segments.get(1).map(|own| own.first);
            let is_over = match end {
                Some(end) => end <= self.kept,
                None => is_done && last_is_long && self.is_due(),
            };
            if !is_over {
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

    /// What is not on the disk yet. [`synced`](Self::synced) follows when it is written.
    ///
    /// # Errors
    /// The computer has too many open files.
    pub fn unsynced(&mut self) -> io::Result<Unsynced> {
        let writer = self.writer.as_ref().map(File::try_clone).transpose()?;
        let files = self.completed.drain(..).chain(writer).collect();
        Ok(Unsynced {
            files,
            folder: self.folder.clone(),
            acknowledged: self.acknowledged,
            is_new: self.kept != self.acknowledged,
        })
    }

    /// This is on the disk.
    pub fn synced(&mut self, written: &Unsynced) {
        self.kept = written.acknowledged;
        self.clear();
    }

    /// Brings everything to the disk.
    ///
    /// # Errors
    /// A file cannot be written.
    pub fn sync(&mut self) -> io::Result<()> {
        let unsynced = self.unsynced()?;
        unsynced.write()?;
        self.synced(&unsynced);
        Ok(())
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
