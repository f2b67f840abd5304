//! Where readings come from.

use plumbline::measure::Reading;
use plumbline::time::Instant;

/// What moves (or does not move) a sensor on the bench: the source of its readings.
pub trait Motion {
    /// The reading at `now`; called every [`SAMPLE_PERIOD`](plumbline::measure::SAMPLE_PERIOD), with rising times.
    fn reading(&mut self, now: Instant) -> Reading;
}

/// A sensor that always reads the same.
impl Motion for Reading {
    fn reading(&mut self, _: Instant) -> Reading {
        *self
    }
}
