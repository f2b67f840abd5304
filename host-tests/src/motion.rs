//! What a simulated device is mounted on.

use plumbline::measure::Reading;
use plumbline::time::Instant;

/// A source of readings.
pub trait Motion {
    /// What the accelerometer delivers at `now`; time never runs backwards.
    fn reading(&mut self, now: Instant) -> Reading;
}
