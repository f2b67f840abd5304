//! The phases of a message against saves that erase a page.

use super::{ERASING, STEP};
use can_wire::protocol::Picoseconds;
use std::collections::VecDeque;

/// Steps of the coarse and of the middle sweep of a save that erases, in us: while a page is erased, the time of the answer falls by
/// as much as the message is later.
const COARSE: u64 = 500;
const MIDDLE: u64 = 20;

/// The phases of saves that erase: coarse over the whole save, then twice finer around the worst one.
#[derive(Default)]
pub struct Erases {
    left: VecDeque<u64>,
    sweeps: usize,
    phase: u64,
    worst: (Picoseconds, u64),
}

impl Erases {
    /// The time of the answer at the present phase.
    pub fn note(&mut self, time: Picoseconds) {
        self.worst = self.worst.max((time, self.phase));
    }
}

impl Iterator for Erases {
    type Item = u64;

    fn next(&mut self) -> Option<u64> {
        let around = |width: u64| self.worst.1.saturating_sub(width)..self.worst.1 + width;
        if self.left.is_empty() {
            self.left = match self.sweeps {
                0 => (0..ERASING).step_by(COARSE as usize).collect(),
                1 => around(COARSE).step_by(MIDDLE as usize).collect(),
                2 => around(MIDDLE).step_by(STEP as usize).collect(),
                _ => return None,
            };
            self.sweeps += 1;
        }
        self.phase = self.left.pop_front()?;
        Some(self.phase)
    }
}
