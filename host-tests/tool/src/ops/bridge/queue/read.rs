//! Reads records again.

use super::Queue;
use super::record::record;
use std::fs::File;
use std::io::{self, BufReader};

/// The place of a reader; a new one is at the first record that is not acknowledged.
#[derive(Default)]
pub struct Cursor {
    /// The number of the next record.
    pub next: u64,
    /// The file with the place, and the number of its first record.
    file: Option<(u64, BufReader<File>)>,
}

impl Queue {
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
            let following = self.segments.get(place).map_or(self.next, |own| own.first);
            let own = place
                .checked_sub(1)
                .and_then(|place| self.segments.get(place));
            let Some(first) = own
                .filter(|own| cursor.next < own.first + own.count)
                .map(|own| own.first)
            else {
                // The records before the following file are lost.
                cursor.next = following;
                continue;
            };
            if cursor.file.as_ref().is_none_or(|(own, _)| *own != first) {
                cursor.file = match File::open(self.path(first)) {
                    // Somebody has deleted it.
                    Err(error) if error.kind() == io::ErrorKind::NotFound => None,
                    file => {
                        let mut file = BufReader::new(file?);
                        for _ in first..cursor.next {
                            record(&mut file)?;
                        }
                        Some((first, file))
                    }
                };
            }
            let read = cursor.file.as_mut().map(|(_, file)| record(file));
            match read.transpose()?.flatten() {
                Some(bytes) => {
                    records.push((cursor.next, bytes));
                    cursor.next += 1;
                }
                // The rest of the file is damaged, or the file is missing.
                None => {
                    self.lost.is_damaged = true;
                    if place == self.segments.len() {
                        self.complete();
                    }
                    if let Some(own) = self.segments.get_mut(place - 1) {
                        own.count = cursor.next - own.first;
                    }
                    cursor.file = None;
                }
            }
        }
        Ok(records)
    }
}
