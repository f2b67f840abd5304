//! What moves a sensor: the source of its readings.

use crate::fault::Fault;
use plumbline::measure::Reading;
use plumbline::time::Instant;

/// The usual supply of a sensor, in mV.
pub const NOMINAL_SUPPLY: u16 = 24_000;

/// The motion of a sensor on the bench, and its supply: the source of its readings.
pub trait Motion {
    /// The reading at `now`; called at the data rate of the accelerometer, with increasing times.
    fn reading(&mut self, now: Instant) -> Reading;

    /// The supply of the sensor at `now`, in mV.
    fn supply(&mut self, now: Instant) -> u16 {
        let _ = now;
        NOMINAL_SUPPLY
    }

    /// The fault of the accelerometer at `now`. [`reading`](Self::reading) has the effect of [`Fault::Zero`], the accelerometer that
    /// of the others.
    fn fault(&self, now: Instant) -> Option<Fault> {
        let _ = now;
        None
    }
}

/// A sensor with a constant reading.
impl Motion for Reading {
    fn reading(&mut self, _: Instant) -> Reading {
        *self
    }
}

/// A constant reading at a constant supply in mV.
impl Motion for (Reading, u16) {
    fn reading(&mut self, _: Instant) -> Reading {
        self.0
    }

    fn supply(&mut self, _: Instant) -> u16 {
        self.1
    }
}
