//! The FIFO of the ADXL355: 96 entries of 20 bits. Bit 0 marks an X, bit 1 an entry that was read from an empty FIFO.

use crate::timebase::{MICROSECOND, Picoseconds};
use std::collections::VecDeque;

/// The number of entries.
const CAPACITY: usize = 96;

/// The time between two axes of a value.
const AXIS: Picoseconds = 20 * MICROSECOND;

#[derive(Clone, Debug, Default)]
pub(super) struct Fifo {
    /// The entries with the time from which they are visible.
    entries: VecDeque<(Picoseconds, [u8; 3])>,
    overrun: bool,
    /// The number of lost values.
    pub(super) lost: u32,
    /// The entry that is read, and the number of its bytes that have been read.
    reading: Option<([u8; 3], usize)>,
}

impl Fifo {
    /// The left-justified bytes of a value from `now` on.
    pub(super) fn push(&mut self, now: Picoseconds, axes: [[u8; 3]; 3]) {
        if self.entries.len() + 3 > CAPACITY {
            self.overrun = true;
            self.lost += 1;
            self.entries.drain(..3);
        }
        for (axis, [high, middle, low]) in axes.into_iter().enumerate() {
            let entry = [high, middle, low | u8::from(axis == 0)];
            self.entries.push_back((now + axis as u64 * AXIS, entry));
        }
    }

    /// FIFO_ENTRIES.
    pub(super) fn entries(&self, now: Picoseconds) -> u8 {
        let visible = self.entries.iter().filter(|(time, _)| *time <= now);
        visible.count() as u8
    }

    /// FIFO_OVR, which a read of STATUS clears.
    pub(super) fn take_overrun(&mut self) -> bool {
        std::mem::take(&mut self.overrun)
    }

    /// The next byte.
    pub(super) fn read(&mut self, now: Picoseconds) -> u8 {
        let (entry, place) = self.reading.take().unwrap_or_else(|| {
            let visible = self.entries.front().is_some_and(|(time, _)| *time <= now);
            let entry = visible.then(|| self.entries.pop_front()).flatten();
            (entry.map_or([0, 0, 0b10], |(_, entry)| entry), 0)
        });
        self.reading = (place < 2).then_some((entry, place + 1));
        entry[place]
    }

    /// The chip select is released: a part of an entry is lost.
    pub(super) fn end_transfer(&mut self) {
        self.reading = None;
    }

    /// Loses the oldest entry: the order of the axes is wrong from now on.
    #[cfg(test)]
    pub(super) fn lose(&mut self) {
        self.entries.pop_front();
    }
}
