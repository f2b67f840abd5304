//! The Kalman filter of the accelerometer and the gyroscope (SIKO IMS360 manual 5.1.4, "sensor fusion").
//!
//! The gyroscope measures each rotation without delay, but its zero point drifts. The accelerometer measures the direction of
//! gravity without drift, but also each other acceleration of the machine. The filter rotates its up vector by the angular rate
//! and corrects it towards the acceleration by a constant gain, that of the steady state of the Kalman filter. It estimates the
//! zero point of the gyroscope (the bias) too. In each step, with the acceleration a and the rotation w in radians:
//!
//! ```text
//! up   = R(w - bias) up                      the prediction; R is an exact rotation
//! bias = bias + K^2 / 4 (up x a)             critically damped
//! up   = up + K (a - up)                     the correction
//! K    = 2 / (1 + sqrt(1 + 4 R / Q))         R and Q of one step, see `gain`
//! ```
//!
//! At the start the gain is 2 / (n + 1) at the n-th sample until it meets K: the mean of all samples, in which sample n has the weight n. A
//! start with the first sample alone would show its vibration as an inclination for many time constants. The filter estimates the bias only
//! after this start, and only while the mean acceleration is 1 g. When the mean leaves 1 g, the filter discards the estimate of the last 4
//! to 8 s, because the acceleration can begin before its mean leaves 1 g. A single sample is never weighted by its own length: this would
//! rectify a vibration along gravity. After a gap, the filter continues with the last direction.
//!
//! | Q, at R = 10 | K | time constant of the correction | vibration of 0.5 g at 3 Hz |
//! |---|---|---|---|
//! | 0.01 | 1.3 % | 0.4 s | 2.7 deg rms |
//! | 0.001 | 0.40 % | 1.3 s | 0.86 deg rms |
//! | 0.0001 | 0.13 % | 4.0 s | 0.27 deg rms |
//!
//! The acceleration is older than the angular rate by [`ACCELERATION_AGE`](super::mean_rate::ACCELERATION_AGE), because the
//! [`resampler`](super::resampler) delays it. It is first rotated forward by the rotation in this time, so the output has the time
//! of the angular rate.
//!
//! Numeric formats: vectors 1 g = 2^26 (Q26), the up vector with 32 more fractional bits; rotations in radians, Q31. The
//! components of the acceleration are limited to +-8 g, so the length of the up vector is at most 14 g: all sums fit.

mod gain;
mod rotation;

pub use gain::Noise;

use super::{I32x3, SAMPLE_PERIOD, saturated};
use gain::gain;
use rotation::{Vector, cross, rotated};

/// The delay of the angle in us, from the motion to the start of a frame, as [`PATH_DELAY`](super::PATH_DELAY). Measured on a ramp: 5.5 ms
/// with a sensor built for the PC, 6.9 ms with the image.
pub const LAG: u32 = 6_300;

/// The angular rate is limited to +-4096 deg/s: 0.36 rad in a sample period.
const RATE_LIMIT: i32 = 4096 << 16;

/// The rotation in a sample period at an angular rate of 1 (2^-16 deg/s), in radians, Q60.
const RADIANS: i64 = {
    // pi / 180 in Q64
    const DEGREE: u128 = 321_956_420_358_983_230;
    ((DEGREE * SAMPLE_PERIOD.ticks() as u128 / 1_000_000) >> 20) as i64
};

/// The number of rotations that are kept: the largest delay of the acceleration in sample periods.
const KEPT: usize = 3;

/// The number of samples that the filter assumes for an up vector from another filter, or from before a gap: 0.5 s.
const GIVEN: u32 = 100;

/// The filter keeps a copy of the bias after this number of estimates: 4 s.
const TRIAL: u16 = 800;

/// The rotation in the delay of the acceleration is limited to 1/2 rad about each axis, Q31: 2300 deg/s for 12 ms.
const FORWARD_LIMIT: i64 = 1 << 30;

/// The bias about each axis is limited to +-2^-12 rad in a sample period, 2.8 deg/s: more than that of a gyroscope without fault
/// (ISM330DHCX: typically 1 deg/s). Otherwise a long centripetal acceleration would cause a larger bias.
const BIAS_LIMIT: i64 = 1 << 59;

/// The Kalman filter. `DELAY` is the age of the acceleration in us, compared with the angular rate: 0 to 3 sample periods.
///
/// It starts with its first accelerations, without bias.
///
/// ```
/// use plumbline::measure::fusion::{Fusion, Noise};
/// use plumbline::measure::{I32x3, ONE_G};
///
/// let mut fusion = Fusion::<0>::new();
/// fusion.tune(Noise::new(1, -3), Noise::new(1, 1)); // Q = 0.001, R = 10
/// let (level, still) = (I32x3 { x: 0, y: 0, z: ONE_G }, I32x3 { x: 0, y: 0, z: 0 });
/// assert_eq!(fusion.step(level, still, true), level);
/// ```
#[derive(Clone, Debug)]
pub struct Fusion<const DELAY: u32> {
    /// The gain K of the Kalman filter, Q31.
    gain: i32,
    /// K^2 / 4, Q44, below 2^-13. A higher gain would estimate the bias from vibration.
    bias_gain: i32,
    /// The number of samples in the up vector, until 2 / (n + 1) meets K; 0: it is not valid.
    samples: u32,
    /// The up vector, Q58, with an offset of 1/2 in Q26, so its upper half is rounded to nearest.
    up: [i64; 3],
    /// The rotation in a sample period that the gyroscope measures at rest, in radians, Q71.
    bias: [i64; 3],
    /// Copies of the bias: 4 to 8 s old, and 0 to 4 s old, in time of estimation.
    earlier: [[i64; 3]; 2],
    /// The number of estimates since the newest copy of the bias.
    estimated: u16,
    /// The last rotations without bias, the newest first, in radians, Q31.
    rotations: [Vector; KEPT],
}

impl<const DELAY: u32> Fusion<DELAY> {
    /// The weights of the last rotations for the rotation in the delay, Q16.
    const WEIGHTS: [i32; KEPT] = {
        assert!(DELAY as u64 <= KEPT as u64 * SAMPLE_PERIOD.ticks());
        [weight(DELAY, 0), weight(DELAY, 1), weight(DELAY, 2)]
    };

    /// A filter that is not started. Call [`tune`](Self::tune) before the first step. All its bits are 0.
    pub const fn new() -> Self {
        Self {
            gain: 0,
            bias_gain: 0,
            samples: 0,
            up: [0; 3],
            bias: [0; 3],
            earlier: [[0; 3]; 2],
            estimated: 0,
            rotations: [[0; 3]; KEPT],
        }
    }

    /// Sets the noise of the system state transition, `q`, and of the measurement, `r` (object 3112h). Only their ratio has an
    /// effect. With a smaller `q` the gyroscope has more influence. The output continues without a step.
    pub fn tune(&mut self, q: Noise, r: Noise) {
        let before = self.gain.unsigned_abs();
        let gain = gain(q, r);
        self.gain = gain as i32;
        let square = u64::from(gain) * u64::from(gain); // Q62
        self.bias_gain = (square >> 20).min(i32::MAX as u64) as i32;
        // With a smaller gain, the filter goes on from the number of samples that the present vector has.
        let limit = u32::MAX.checked_div(before).unwrap_or(u32::MAX);
        self.samples = self.samples.min(limit);
    }

    /// Goes on after missing samples. The rotations before the gap have ended. The sensor may have turned in the gap, so the up vector
    /// counts as a limited number of samples.
    pub fn skip(&mut self) {
        self.samples = self.samples.min(GIVEN);
        self.rotations = [[0; 3]; KEPT];
    }

    /// Continues from the up vector `up`, 1 g = 2^26, limited to +-8 g.
    pub fn settle(&mut self, up: I32x3) {
        self.samples = GIVEN;
        self.place(limited(up));
        self.skip();
    }

    fn place(&mut self, up: Vector) {
        self.up = up.map(|component| (i64::from(component) << 32) | (1 << 31));
    }

    /// Processes one sample; call it once per [`SAMPLE_PERIOD`]. Returns the up vector at the time of the angular rate, 1 g =
    /// 2^26, rounded to nearest. Its length is about 1 g and at most 14 g; only its direction has a meaning.
    ///
    /// - `acceleration`: calibrated, not filtered, 1 g = 2^26, limited to +-8 g, `DELAY` older than the angular rate;
    /// - `rate`: the mean angular rate in the sample period that ends now, 1 deg/s = 2^16, limited to +-4096 deg/s. A value at the
    ///   end of the period instead would give a lag of half a period;
    /// - `is_one_g`: the mean acceleration is about 1 g, so the bias can be estimated. If not, the filter restores the copy of the bias
    ///   that is 4 to 8 s old.
    pub fn step(&mut self, acceleration: I32x3, rate: I32x3, is_one_g: bool) -> I32x3 {
        let acceleration = limited(acceleration);
        if self.samples == 0 {
            self.place(acceleration);
        }
        let gain = self.present_gain();
        let learns = is_one_g && gain == self.gain;
        let rotation = self.rotation(rate);
        let [newest, second, _] = self.rotations;
        self.rotations = [rotation, newest, second];

        let predicted = rotated(&mut self.up, rotation);
        let measured = self.forward(acceleration);

        let errors = cross(predicted, measured);
        for (bias, error) in self.bias.iter_mut().zip(errors).filter(|_| learns) {
            // The product of two vectors of 14 g fits Q23. A change in Q71 is limited to more than the whole range of the bias.
            let error = ((error >> 28) + 1) >> 1;
            let change = i64::from(self.bias_gain) * error;
            let change = change.clamp(-BIAS_LIMIT / 4, BIAS_LIMIT / 4) << 4;
            *bias = (*bias + change).clamp(-BIAS_LIMIT, BIAS_LIMIT);
        }
        self.keep_bias(is_one_g, learns);
        for ((up, predicted), measured) in self.up.iter_mut().zip(predicted).zip(measured) {
            let difference = i64::from(measured) - i64::from(predicted);
            *up += (i64::from(gain) * difference) << 1;
        }
        let [x, y, z] = self.up.map(|component| (component >> 32) as i32);
        I32x3 { x, y, z }
    }

    /// Keeps a copy of the bias after each [`TRIAL`]. When the mean acceleration is not 1 g, restores the older copy.
    fn keep_bias(&mut self, is_one_g: bool, learns: bool) {
        let [oldest, newest] = self.earlier;
        if !is_one_g {
            self.bias = oldest;
            self.earlier = [oldest; 2];
            self.estimated = 0;
        } else if learns {
            self.estimated += 1;
            if self.estimated >= TRIAL {
                self.earlier = [newest, self.bias];
                self.estimated = 0;
            }
        }
    }

    /// The gain of the next sample, which is counted, Q31.
    fn present_gain(&mut self) -> i32 {
        // 2 / (n + 1) for the n-th sample, in Q31
        let start = u32::MAX.checked_div(self.samples.saturating_add(2));
        let start = start.unwrap_or(0) as i32;
        if start <= self.gain {
            return self.gain;
        }
        self.samples = self.samples.saturating_add(1);
        start
    }

    /// The rotation in the last sample period, without bias, in radians, Q31.
    fn rotation(&self, rate: I32x3) -> Vector {
        let mut rotation = rate.to_array();
        for (component, bias) in rotation.iter_mut().zip(self.bias) {
            let rate = (*component).clamp(-RATE_LIMIT, RATE_LIMIT);
            let measured = (i64::from(rate) * RADIANS) >> 29;
            *component = measured.wrapping_sub(bias >> 40) as i32;
        }
        rotation
    }

    /// The acceleration in the direction that it has now, after the rotation in the delay.
    fn forward(&self, acceleration: Vector) -> Vector {
        if DELAY == 0 {
            return acceleration;
        }
        let mut sum = [1 << 15; 3];
        for (rotation, weight) in self.rotations.iter().zip(Self::WEIGHTS) {
            for (sum, component) in sum.iter_mut().zip(rotation) {
                *sum += i64::from(weight) * i64::from(*component);
            }
        }
        let sum = sum.map(|sum| (sum >> 16).clamp(-FORWARD_LIMIT, FORWARD_LIMIT) as i32);
        let mut state = acceleration.map(|component| (i64::from(component) << 32) | (1 << 31));
        rotated(&mut state, sum)
    }
}

/// The part of the sample period `index` (0 is the newest one) that is within `delay` (us), Q16.
const fn weight(delay: u32, index: u64) -> i32 {
    let period = SAMPLE_PERIOD.ticks();
    let covered = (delay as u64).saturating_sub(index * period);
    let covered = if covered > period { period } else { covered };
    ((covered << 16) / period) as i32
}

/// `vector` with each component limited to -8 g..8 g.
fn limited(vector: I32x3) -> Vector {
    vector.to_array().map(saturated)
}

impl<const DELAY: u32> Default for Fusion<DELAY> {
    fn default() -> Self {
        Self::new()
    }
}

#[cfg(test)]
mod tests;
