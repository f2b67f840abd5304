//! The path of a sample, one file per step.
//!
//! 1. [`resampler`] converts the values of the accelerometer, which has its own clock, to a [`Reading`] every [`SAMPLE_PERIOD`]. A
//!    driver does this, so that the following filters do not depend on the accelerometer;
//! 2. [`calibration`] corrects offset, gain, cross-axis errors and temperature drift of the device;
//! 3. [`low_pass`] or [`fir`] filters vibration out of each component of the vector. Filtering the angle instead would give wrong
//!    results near 0/360 deg and a bias under vibration. Instead, [`fusion`] combines the acceleration with the angular rate;
//! 4. [`teach`] rotates the vector into the reference frame of the machine, if the product has teach-in;
//! 5. [`definition`] calculates the angles of the vector;
//! 6. [`output_filter`] smooths the angles, if the manual defines a filter on the output (TILTIX);
//! 7. [`Angle`](crate::angle::Angle) rounds them to the resolution of the product, for example 0.01 deg;
//! 8. [`zero`] adds the zero offset. GEMAC products add it to the rounded angle, the JN2101 subtracts it before the rounding.
//!
//! What is filtered where, from the sensing element to the angle:
//!
//! | stage | rate | pass band | stop band |
//! |---|---|---|---|
//! | analog filter and converter of the accelerometer | 833 Hz, +-5 % | up to half of the rate | frequencies above 416 Hz |
//! | [`resampler`] | 833 Hz to 200 Hz | 25 Hz within 0.03 dB | 160 to 416 Hz 40 dB, 185 to 416 Hz 60 dB |
//! | [`low_pass`], GEMAC | 200 Hz | the cut-off frequency of the setting, or 20 Hz | order 8, or order 2 |
//! | [`output_filter`], TILTIX | 200 Hz | weight and size of the setting, in cycles of 1428 Hz | |
//! | [`fir`], JN2101 | 200 Hz | the cut-off frequency of the setting | 40 dB from 3.2 times the cut-off frequency on |
//!
//! An accelerometer with a data rate of 1000 Hz has a resampler with the same bands.
//!
//! A vibration of 0.3 g at each frequency from 8 to 400 Hz changes the angle behind a Butterworth filter of 2 Hz by at most 0.02
//! deg, and each cut-off frequency is within 0.15 %, with an error of the clock of the accelerometer of up to 5 %. Tests show this
//! on a PC and of the flashed image.
//!
//! [`Inclinometer`] combines calibration and [`low_pass`]. Each product combines the other functions and filters as its manual
//! requires. [`validity`] judges the calibrated acceleration: [`clipping`], [`plausibility`], and [`overturned`], a sensor on its back.
//! [`self_test`] checks the accelerometer, [`supply`] the supply voltage.
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
pub mod fusion;
pub mod low_pass;
mod low_pass_design;
pub mod mean_rate;
pub mod output_filter;
pub mod overturned;
pub mod plausibility;
pub mod resampler;
pub mod self_test;
pub mod supply;
pub mod teach;
pub mod validity;
pub mod zero;

use crate::time::{Duration, millis};
pub use calibration::Calibration;
pub use low_pass::LowPass;
pub use micromath::vector::I32x3;
pub use validity::Validity;

/// The sampling period: 200 Hz. Below 160 Hz the critically damped filter would overshoot.
pub const SAMPLE_PERIOD: Duration = millis(5);

/// The delay of an angle without filter, in us: from the motion to the start of a frame that asks for it at any time. It has the delays
/// of the accelerometer and of the [`resampler`], and half a sampling period. Measured on a ramp: 16.5 ms with a sensor built for the
/// PC, 16.9 ms with the image, 0.4 ms more or less with an error of 5 % of the clock of the accelerometer.
pub const PATH_DELAY: u32 = 16_700;

/// One sample of the accelerometer, and of the gyroscope if there is one.
#[derive(Clone, Copy, PartialEq, Debug, Default)]
pub struct Reading {
    /// Specific force in the coordinate frame of the sensor, 1 g = 2^26 ([`ONE_G`]). At rest it points up. Range +-8 g ([`RANGE`]).
    pub acceleration: I32x3,
    /// Mean angular rate since the previous sample about the same axes, right-handed, 1 deg/s = 2^16; zero without a gyroscope.
    pub angular_rate: I32x3,
    /// Temperature of the accelerometer, in 0.01 degC.
    pub temperature: i16,
    /// An axis of the accelerometer was at the limit of its range.
    pub clipped: bool,
}

/// 1 g in the unit of [`Reading::acceleration`].
pub const ONE_G: i32 = 1 << 26;

/// The range of the accelerometer in each axis, +-8 g: a shock of 6 g does not clip. The filters that overshoot have a margin of a
/// factor of 4 to the end of 32 bits.
pub const RANGE: i32 = 8 * ONE_G;

/// `component` limited to -8 g..8 g, without the upper limit. Limits that are powers of two need only one instruction.
pub(crate) const fn saturated(component: i32) -> i32 {
    if component < -RANGE {
        -RANGE
    } else if component >= RANGE {
        RANGE - 1
    } else {
        component
    }
}

/// Calibration, validity of the acceleration, and low-pass.
#[derive(Clone, Debug, Default)]
pub struct Inclinometer {
    /// The calibration of the device.
    pub calibration: Calibration,
    /// The validity of the calibrated acceleration: samples, clipping, length and position on the back.
    pub validity: Validity,
    /// The filter that the user can set, before the angles are calculated.
    pub low_pass: LowPass,
}

impl Inclinometer {
    /// The identity as calibration, no filter, and no valid sample yet.
    pub const INITIAL: Self = Self {
        calibration: Calibration::IDENTITY,
        validity: Validity::INITIAL,
        low_pass: LowPass::new(),
    };

    /// Processes a reading. Returns the filtered up vector, 1 g = 2^26.
    pub fn sample(&mut self, reading: &Reading) -> I32x3 {
        let corrected = self
            .calibration
            .apply(reading.acceleration, reading.temperature);
        self.validity.step(corrected, reading.clipped);
        self.low_pass.step(corrected)
    }

    /// Handles missing samples: nothing is valid until samples come again, and these begin the filter anew.
    pub fn stale(&mut self) {
        self.validity.stale();
        self.low_pass.forget();
    }
}
