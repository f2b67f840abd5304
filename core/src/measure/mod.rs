//! The path of a sample, one file per step.

use crate::time::{Duration, millis};
pub use micromath::vector::I32x3;

/// The period of the internal sampling: 200 Hz, above the 160 Hz below which the critically damped filter would overshoot.
pub const SAMPLE_PERIOD: Duration = millis(5);

/// What the accelerometer (and gyroscope, where there is one) delivers for one sample.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Reading {
    /// Specific force in the sensor's frame, 1 g = 2^28 ([`ONE_G`]); at rest it points up. Range +-2 g.
    pub acceleration: I32x3,
    /// Angular rate about the same axes, right-handed, 1 deg/s = 2^16; zero without a gyroscope.
    pub angular_rate: I32x3,
    /// Temperature of the part, in 0.01 degC.
    pub temperature: i16,
    /// An axis of the accelerometer was at the end of its range.
    pub clipped: bool,
}

/// 1 g in a [`Reading`].
pub const ONE_G: i32 = 1 << 28;
