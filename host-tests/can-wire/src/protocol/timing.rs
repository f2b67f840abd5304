//! When a controller begins and samples its bits, and how edges on the wire shift them (ISO 11898-1, bit timing).

use super::{BitTiming, Picoseconds};

/// The bit clock of one controller.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub(super) struct BitClock {
    timing: BitTiming,
    /// The start of the bit that is sampled next; in the future once the previous bit has been sampled.
    start: Picoseconds,
    /// The level at the last sample point.
    dominant: bool,
    /// There is only one synchronization between two sample points.
    synchronized: bool,
}

impl BitClock {
    /// A clock whose first bit starts now, on a wire that is assumed to be recessive.
    pub(super) fn new(now: Picoseconds, timing: BitTiming) -> Self {
        Self {
            timing,
            start: now,
            dominant: false,
            synchronized: false,
        }
    }

    /// The next bits have this timing.
    pub(super) fn retime(&mut self, timing: BitTiming) {
        self.timing = timing;
    }

    pub(super) fn timing(&self) -> BitTiming {
        self.timing
    }

    /// The start of the bit that is sampled next.
    pub(super) fn start(&self) -> Picoseconds {
        self.start
    }

    pub(super) fn sample(&self) -> Picoseconds {
        self.start + self.timing.sample
    }

    /// Starts the next bit now: the wire has been idle, so there is no edge to synchronize to.
    pub(super) fn restart(&mut self, now: Picoseconds) {
        self.start = self.start.max(now);
    }

    /// Advances until the next sample point is later than `now`.
    pub(super) fn catch_up(&mut self, now: Picoseconds) {
        if self.sample() <= now {
            let bits = (now - self.sample()) / self.timing.bit + 1;
            self.start += bits * self.timing.bit;
        }
    }

    /// Moves the next bit this much later.
    pub(super) fn delay(&mut self, time: Picoseconds) {
        self.start += time;
    }

    /// Continues with the next bit after a sample.
    pub(super) fn sampled(&mut self, dominant: bool) {
        self.start += self.timing.bit;
        self.dominant = dominant;
        self.synchronized = false;
    }

    /// True when an edge to dominant may synchronize: after a recessive sample, once per bit.
    pub(super) fn takes_edge(&self) -> bool {
        !self.dominant && !self.synchronized
    }

    /// Hard synchronization: the bit starts with this edge.
    pub(super) fn synchronize(&mut self, now: Picoseconds) {
        self.start = now;
        self.synchronized = true;
    }

    /// Shifts the sample point according to the edge, by the jump width at most. A controller that sends a dominant bit ignores a
    /// late edge: it is its own edge, delayed.
    pub(super) fn resynchronize(&mut self, now: Picoseconds, sends_dominant: bool) {
        let jump = self.timing.jump;
        if now < self.start {
            self.start -= jump.min(self.start - now);
        } else if !sends_dominant {
            self.start += jump.min(now - self.start);
        }
        self.synchronized = true;
    }
}
