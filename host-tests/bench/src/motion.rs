//! The source of readings.

use plumbline::measure::Reading;
use plumbline::time::Instant;

/// The motion of a sensor on the bench: the source of its readings.
pub trait Motion {
    /// The reading at `now`; called at the data rate of the accelerometer, with increasing times.
    fn reading(&mut self, now: Instant) -> Reading;
}

/// A sensor with a constant reading.
impl Motion for Reading {
    fn reading(&mut self, _: Instant) -> Reading {
        *self
    }
}
