//! The angles and raw values from a reading (manual 5 and 7.2.28 to 7.2.47): calibration, low-pass or Kalman filter, angle, offset.

use super::Ims360Product;
use super::parameters::{FILTER_KINDS, has_two_axes, id};
use crate::angle::Angle;
use crate::measure::fusion::{Fusion, Noise};
use crate::measure::low_pass::Kind;
use crate::measure::mean_rate::ACCELERATION_AGE;
use crate::measure::{Calibration, I32x3, LowPass, ONE_G, Reading, Validity, definition};
use crate::param::{ParameterId, Parameters, meaning};

/// 360 deg in 0.01 deg.
const TURN: i32 = 36_000;

/// The mean acceleration must be 1 g for this number of samples before the filter estimates the offset of the gyroscope: 2 s. When an
/// inclined sensor vibrates, its acceleration is 1 g in one half of the period. An estimate in this half only would be wrong.
const STEADY: u16 = 400;

/// The path of a sample.
pub(super) struct Measuring {
    calibration: Calibration,
    validity: Validity,
    /// The samples since the mean acceleration was not 1 g, at most [`STEADY`].
    steady: u16,
    low_pass: LowPass,
    fusion: Fusion<{ ACCELERATION_AGE }>,
    /// The Kalman filter is selected (3110h:02).
    fuses: bool,
    /// The variant in force has two axes.
    two_axes: bool,
    offsets: [i32; 2],
    /// The filtered up vector; None before the first sample.
    up: Option<I32x3>,
    /// The angles without offset, not rounded.
    fine: [Angle; 2],
    /// The calibrated acceleration, before all filters.
    force: I32x3,
    /// The calibrated angular rate, before all filters.
    rate: I32x3,
}

impl Measuring {
    /// The state before calibration and configuration.
    pub const INITIAL: Self = Self {
        calibration: Calibration::IDENTITY,
        validity: Validity::INITIAL,
        steady: 0,
        low_pass: LowPass::new(),
        fusion: Fusion::new(),
        fuses: false,
        two_axes: false,
        offsets: [0; 2],
        up: None,
        fine: [Angle::ZERO; 2],
        force: I32x3 { x: 0, y: 0, z: 0 },
        rate: I32x3 { x: 0, y: 0, z: 0 },
    };

    /// Sets the calibration of the device.
    pub fn calibrate(&mut self, calibration: Calibration) {
        self.calibration = calibration;
    }

    /// Applies the parameters and updates the angles.
    pub fn configure(&mut self, parameters: &Parameters<Ims360Product>) {
        let kind = meaning(&FILTER_KINDS, parameters.get(id::FILTER_TYPE)).unwrap_or(Kind::Off);
        // The permitted values are always valid for the filter.
        let _ = self.low_pass.tune(kind, parameters.get(id::CUT_OFF) as u16);
        self.fusion
            .tune(noise(parameters, id::Q), noise(parameters, id::R));
        let fuses = parameters.get(id::FUSION) != 0;
        // The angle continues without a step (3110h:02).
        if let Some(up) = self.up.filter(|_| fuses != self.fuses) {
            if fuses {
                self.fusion.settle(up);
            } else {
                self.low_pass.restart(up);
            }
        }
        self.fuses = fuses;
        self.two_axes = has_two_axes(parameters);
        self.offsets = [id::ZERO_X, id::ZERO_Y].map(|id| parameters.get(id) as i32);
        self.update();
    }

    /// Processes a reading: calibration, filter and angles.
    pub fn sample(&mut self, reading: &Reading) {
        self.force = self
            .calibration
            .apply(reading.acceleration, reading.temperature);
        self.rate = self
            .calibration
            .apply_to_rate(reading.angular_rate, reading.temperature);
        self.validity.step(self.force, reading.clipped);
        self.steady = if self.validity.is_one_g() {
            (self.steady + 1).min(STEADY)
        } else {
            0
        };
        self.up = Some(if self.fuses {
            let is_steady = self.steady == STEADY;
            self.fusion.step(self.force, self.rate, is_steady)
        } else {
            self.low_pass.step(self.force)
        });
        self.update();
    }

    /// Samples are missing for so long that nothing valid is measured.
    pub fn invalidate(&mut self) {
        self.validity.stale();
        self.low_pass.forget();
        self.interrupt();
    }

    /// Samples are missing. The angles keep their values until the next sample.
    pub fn interrupt(&mut self) {
        self.fusion.skip();
    }

    fn update(&mut self) {
        let Some(up) = self.up else { return };
        self.fine = if self.two_axes {
            let angles = definition::perpendicular(up);
            [angles.x, angles.y]
        } else {
            [definition::rotation(up), Angle::ZERO]
        };
    }

    /// Whether the variant in force has two axes.
    pub fn has_two_axes(&self) -> bool {
        self.two_axes
    }

    /// Detects a dead or wrong accelerometer.
    pub fn validity(&self) -> &Validity {
        &self.validity
    }

    /// Whether there was a sample.
    pub fn has_measured(&self) -> bool {
        self.up.is_some()
    }

    /// The angles without offset, not rounded.
    pub fn fine(&self) -> [Angle; 2] {
        self.fine
    }

    /// The angles with their offsets, in 0.01 deg: 1-axis modulo 360 deg, 2-axis limited to 32 bits.
    pub fn angles(&self) -> [i32; 2] {
        let [x, y] = measured(self.fine, self.two_axes);
        let [offset_x, offset_y] = self.offsets;
        if self.two_axes {
            [x.saturating_add(offset_x), y.saturating_add(offset_y)]
        } else {
            [(x + offset_x.rem_euclid(TURN)).rem_euclid(TURN), 0]
        }
    }

    /// The calibrated specific force in 0.001 g.
    pub fn force(&self) -> [i32; 3] {
        scaled::<{ ONE_G.ilog2() }>(self.force, 1000)
    }

    /// The angular rate in 1 / `units` deg/s.
    pub fn rate(&self, units: i64) -> [i32; 3] {
        scaled::<16>(self.rate, units)
    }
}

/// Angles in 0.01 deg: 1-axis 0 to 359.99 deg, 2-axis with a sign.
pub fn measured(fine: [Angle; 2], two_axes: bool) -> [i32; 2] {
    if two_axes {
        fine.map(Angle::centidegrees)
    } else {
        let [angle, _] = fine;
        [angle.centidegrees_unsigned().into(), 0]
    }
}

/// A noise parameter of the Kalman filter (3112h): mantissa * 10^exponent.
fn noise(parameters: &Parameters<Ims360Product>, ids: [ParameterId; 2]) -> Noise {
    let [mantissa, exponent] = ids.map(|id| parameters.get(id) as i8);
    Noise::new(mantissa, exponent)
}

/// A vector in units of which 1 / 2^`BITS` is 1 in the result divided by `units`; rounded to nearest, halves away from zero.
fn scaled<const BITS: u32>(vector: I32x3, units: i64) -> [i32; 3] {
    vector.to_array().map(|component| {
        let product = i64::from(component) * units;
        let half = (1 << (BITS - 1)) - i64::from(product < 0);
        ((product + half) >> BITS) as i32
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::measure::SAMPLE_PERIOD;
    use core::f64::consts::TAU;

    /// The mean angle in deg over the last 20 s of a vibration along X. Before, the sensor is at rest for `rest` seconds, and vibrates for
    /// 40 s.
    fn mean_angle(rest: u32, tilt: f64, amplitude: f64, frequency: f64) -> f64 {
        const LAST: u32 = 4000;
        let first = rest * 200;
        let samples = first + 12_000;
        let mut parameters = Parameters::<Ims360Product>::factory();
        parameters.set(id::FUSION, 1);
        let mut measuring = Measuring::INITIAL;
        measuring.configure(&parameters);
        let mut sum = 0;
        for sample in 0..samples {
            let vibrating = f64::from(sample.saturating_sub(first));
            let time = vibrating * SAMPLE_PERIOD.ticks() as f64 / 1e6;
            let vibration = amplitude * (TAU * frequency * time).sin();
            let [x, z] = [vibration - tilt.to_radians().sin(), tilt.to_radians().cos()];
            measuring.sample(&Reading {
                acceleration: I32x3 {
                    x: (x * f64::from(ONE_G)) as i32,
                    y: 0,
                    z: (z * f64::from(ONE_G)) as i32,
                },
                temperature: 2500,
                ..Reading::default()
            });
            if sample >= samples - LAST {
                sum += measuring.angles()[0];
            }
        }
        f64::from(sum) / f64::from(LAST) / 100.0
    }

    #[test]
    fn mean_angle_of_an_inclined_sensor_is_correct_under_vibration() {
        for (rest, tilt, amplitude, frequency) in [
            (0, 5.0, 0.5, 3.0),
            (0, 10.0, 0.5, 3.0),
            (0, 20.0, 0.3, 1.5),
            (0, 20.0, 0.5, 6.0),
            (0, -30.0, 0.3, 3.0),
            (0, 10.0, 0.3, 0.5),
            (0, 10.0, 0.3, 0.3),
            (0, 20.0, 0.2, 0.2),
            (30, 10.0, 0.5, 3.0),
            (30, 20.0, 0.3, 1.5),
            (30, 5.0, 0.4, 0.5),
            (30, 10.0, 0.3, 0.3),
            (30, 0.0, 0.4, 0.3),
        ] {
            let error = mean_angle(rest, tilt, amplitude, frequency) - tilt;
            assert!(
                error.abs() < 0.15,
                "after {rest} s: {tilt} deg, {amplitude} g, {frequency} Hz: {error}"
            );
        }
    }
}
