//! The path of a sample, one file per step.
//!
//! A [`Reading`] comes from the accelerometer every [`SAMPLE_PERIOD`]. Then, in this order:
//!
//! 1. [`calibration`] corrects offset, gain, cross axes and temperature drift of the unit;
//! 2. [`teach`] turns it into the frame of the machine, where a product can be taught one;
//! 3. [`low_pass`] or [`fir`] takes the vibration out of the vector, component by component. Filtering the angle instead would go
//!    wrong around 0/360 deg and turn vibration into a bias;
//! 4. [`definition`] makes angles of the vector;
//! 5. [`Angle`](crate::angle::Angle) rounds them to 0.01 deg;
//! 6. [`zero`] adds the zero offset.
//!
//! [`Inclinometer`] is calibration and [`low_pass`]; the others are functions and filters that each product composes as its manual
//! says. [`self_test`] judges the accelerometer itself.
//!
//! ```
//! use plumbline::measure::{Inclinometer, I32x3, ONE_G, Reading, definition, zero};
//!
//! let mut inclinometer = Inclinometer::default();
//! let reading = Reading {
//!     acceleration: I32x3 { x: 0, y: ONE_G / 2, z: ONE_G / 2 },
//!     angular_rate: I32x3 { x: 0, y: 0, z: 0 },
//!     temperature: 21_50,
//!     clipped: false,
//! };
//! let up = inclinometer.sample(&reading);
//! let angles = definition::perpendicular(up);
//! assert_eq!(zero::two_axis(angles.y.centidegrees(), -5_00), 40_00);
//! ```

pub mod calibration;
pub mod clipping;
pub mod definition;
pub mod fir;
pub mod low_pass;
mod low_pass_design;
pub mod self_test;
pub mod teach;
pub mod zero;

use crate::time::{Duration, millis};
pub use calibration::Calibration;
pub use clipping::Clipping;
pub use low_pass::LowPass;
pub use micromath::vector::I32x3;

/// The period of the internal sampling: 200 Hz, above the 160 Hz below which the critically damped filter would overshoot.
pub const SAMPLE_PERIOD: Duration = millis(5);

/// What the accelerometer (and gyroscope, where there is one) delivers for one sample.
#[derive(Clone, Copy, PartialEq, Debug, Default)]
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

/// `component` held within -2 g..2 g, the upper end not included: a range that ends at powers of two is one instruction.
pub(crate) const fn saturated(component: i32) -> i32 {
    const END: i32 = 2 * ONE_G;
    if component < -END {
        -END
    } else if component >= END {
        END - 1
    } else {
        component
    }
}

/// Calibration and low-pass.
#[derive(Clone, Debug, Default)]
pub struct Inclinometer {
    /// The calibration of the unit.
    pub calibration: Calibration,
    /// The digital filter.
    pub low_pass: LowPass,
}

impl Inclinometer {
    /// Not calibrated, the filter off.
    pub const INITIAL: Self = Self {
        calibration: Calibration::IDENTITY,
        low_pass: LowPass::new(),
    };

    /// Takes a reading in and returns the filtered up vector, 1 g = 2^28.
    pub fn sample(&mut self, reading: &Reading) -> I32x3 {
        let corrected = self
            .calibration
            .apply(reading.acceleration, reading.temperature);
        self.low_pass.step(corrected)
    }
}
