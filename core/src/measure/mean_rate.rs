//! The angular rate of a sample: the mean of the rate of the gyroscope since the previous sample.
//!
//! A filter integrates the rate, so the mean multiplied by the sampling period must be the rotation. The gyroscope has the clock and
//! the data rate of the accelerometer, and a sample of the [`Resampler`] lies between two values. The rotation up to a sample is the
//! sum of the values minus the part after the sample. A value counts from half a period before its time to half a period after it.
//!
//! The mean ends at the time of the sample, so it has no delay. The acceleration of the same reading is older by [`ACCELERATION_AGE`]. A
//! filter that combines both must correct this.
//!
//! ```
//! use plumbline::measure::{I32x3, mean_rate::MeanRate, resampler::Resampler};
//!
//! let mut resampler = Resampler::<i32, 0>::new();
//! resampler.start(833_000);
//! let mut rate = MeanRate::<0>::new();
//! let mut means = (0..853).filter_map(|_| {
//!     rate.push([0, 0, 90 << 16]);
//!     resampler.push([0; 3])?;
//!     rate.take(&resampler)
//! });
//! let about_90 = |mean: I32x3| (mean.z - (90 << 16)).abs() < 600;
//! // The first mean begins within the first period.
//! means.next();
//! assert!(means.all(about_90));
//! ```

use super::I32x3;
use super::resampler::{Component, PERIOD, Resampler};

/// The mean of the values of a gyroscope between two samples. A mean has `FRACTION` more fractional bits than a value: at most 14 for
/// values of 16 bits, 0 for values of 28 bits.
#[derive(Clone, Debug)]
pub struct MeanRate<const FRACTION: u32> {
    /// The sum of all values, modulo 2^64.
    sum: [i64; 3],
    newest: [i32; 3],
    /// The sum up to the last sample, multiplied by 2^PERIOD, modulo 2^64.
    last: [i64; 3],
    /// There was a value since the last sample.
    fresh: bool,
    /// `last` is the sum of a sample, so a mean can be calculated.
    started: bool,
}

impl<const FRACTION: u32> MeanRate<FRACTION> {
    /// The state before the first value.
    pub const fn new() -> Self {
        Self {
            sum: [0; 3],
            newest: [0; 3],
            last: [0; 3],
            fresh: false,
            started: false,
        }
    }

    /// Takes the next value of the gyroscope.
    pub fn push(&mut self, value: [i32; 3]) {
        for (sum, value) in self.sum.iter_mut().zip(value) {
            *sum = sum.wrapping_add(value.into());
        }
        self.newest = value;
        self.fresh = true;
    }

    /// The mean since the last call. Call it after each output of the resampler. None if there was no value since the last call, and
    /// at the first call.
    pub fn take<V: Component<WEIGHTS>, const BITS: u32, const WEIGHTS: usize>(
        &mut self,
        resampler: &Resampler<V, BITS, WEIGHTS>,
    ) -> Option<I32x3> {
        let after = resampler.since_output().wrapping_add(HALF);
        // The reciprocal of the sampling period, as a fraction of 2^32.
        let scale = u32::MAX.checked_div(resampler.interval()).unwrap_or(0);
        let mut means = [0; 3];
        for (((mean, sum), newest), last) in means
            .iter_mut()
            .zip(self.sum)
            .zip(self.newest)
            .zip(&mut self.last)
        {
            let rest = i64::from(newest).wrapping_mul(after.into());
            let now = (sum << PERIOD).wrapping_sub(rest);
            let turned = now.wrapping_sub(*last);
            *last = now;
            *mean = (turned.wrapping_mul(scale.into()) >> const { 32 - FRACTION }) as i32;
        }
        let [x, y, z] = means;
        let is_valid = self.started && self.fresh;
        self.started = self.fresh;
        self.fresh = false;
        is_valid.then_some(I32x3 { x, y, z })
    }
}

/// The age of the acceleration of a reading at the end of its mean rate, in us: the delay of the resampler, which is nine values of the
/// accelerometer at 833.375 Hz. An error of 5 % of its clock changes it by 0.54 ms.
pub const ACCELERATION_AGE: u32 = 10_799;

/// Half a period of the gyroscope.
const HALF: i32 = 1 << (PERIOD - 1);

impl<const FRACTION: u32> Default for MeanRate<FRACTION> {
    fn default() -> Self {
        Self::new()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    /// The data rate in mHz and in Hz.
    const DATA_RATE: u32 = 833_375;
    const HZ: f64 = DATA_RATE as f64 / 1000.0;

    /// The number of a rate of 1 deg/s.
    const UNIT: f64 = 65_536.0;

    /// The means of the rate `rate`, in deg/s by the time in s, with the time of each sample. Both sensors have this data rate, and the
    /// accelerometer states it with an error in permille.
    fn means(seconds: f64, rate: impl Fn(f64) -> f64, error: f64) -> Vec<(f64, f64)> {
        let mut resampler = Resampler::<i32, 0>::new();
        resampler.start((f64::from(DATA_RATE) * (1.0 + error / 1000.0)) as u32);
        let mut mean = MeanRate::<0>::new();
        let mut found = Vec::new();
        for number in 0..(seconds * HZ) as u32 {
            let time = f64::from(number) / HZ;
            mean.push([(rate(time) * UNIT).round() as i32, 0, 0]);
            if resampler.push([0; 3]).is_some() {
                let behind = f64::from(resampler.since_output()) / 65_536.0 / HZ;
                if let Some(value) = mean.take(&resampler) {
                    found.push((time - behind, f64::from(value.x) / UNIT));
                }
            }
        }
        found
    }

    #[test]
    fn constant_rate_is_its_mean() {
        for rate in [-1000.0, -0.1, 0.0, 0.5, 1000.0] {
            let means = means(1.0, |_| rate, 0.0);
            assert_eq!(means.len(), 195);
            for (time, mean) in means {
                let error = (mean - rate).abs();
                assert!(error <= rate.abs() * 1e-4 + 1e-4, "{time}: {mean}");
            }
        }
    }

    /// -45 to +45 deg within 0.3 s, at 471 deg/s at most: at each sample, the sum of the means is the angle.
    #[test]
    fn sum_of_means_is_the_rotation() {
        let angle = |time: f64| {
            let part = ((time - 0.5) / 0.3).clamp(0.0, 1.0);
            -45.0 * (PI * part).cos()
        };
        let step = 1e-6;
        let rate = |time: f64| (angle(time + step) - angle(time - step)) / (2.0 * step);
        for error in [-1.5, 0.0, 1.5] {
            let mut sum = -45.0;
            for (time, mean) in means(1.0, rate, error) {
                sum += mean * 0.005 * (1.0 + error / 1000.0);
                let wrong = sum - angle(time);
                assert!(wrong.abs() < 0.03, "{time}: {wrong}");
            }
        }
    }

    /// The acceleration of a ramp is older by its age. The interpolation of the resampler is wrong by 11 us at most, 0.007 deg at 600 deg/s.
    #[test]
    fn acceleration_is_older_by_the_stated_age() {
        const SLOPE: f64 = (1 << 26) as f64;
        let mut resampler = Resampler::<i32, 0>::new();
        resampler.start(DATA_RATE);
        for number in 0..2000 {
            let time = f64::from(number) / HZ;
            if let Some(output) = resampler.push([(time * SLOPE) as i32, 0, 0]) {
                let behind = f64::from(resampler.since_output()) / 65_536.0 / HZ;
                let age = time - behind - f64::from(output.x) / SLOPE;
                let error = age * 1e6 - f64::from(ACCELERATION_AGE);
                assert!(error.abs() < 11.0, "{error} us");
            }
        }
    }

    #[test]
    fn first_sample_and_sample_without_values_have_no_mean() {
        let mut resampler = Resampler::<i32, 0>::new();
        resampler.start(DATA_RATE);
        let mut mean = MeanRate::<0>::new();
        let mut results = Vec::new();
        for number in 0..60 {
            // The gyroscope pauses.
            if !(30..40).contains(&number) {
                mean.push([655_360; 3]);
            }
            if resampler.push([0; 3]).is_some() {
                results.push(mean.take(&resampler).is_some());
            }
        }
        assert_eq!(
            results,
            [
                false, true, true, true, false, false, true, true, true, true
            ]
        );
    }

    #[test]
    fn fraction_bits_extend_the_mean() {
        let mut resampler = Resampler::<i32, 0>::new();
        resampler.start(DATA_RATE);
        let mut mean = MeanRate::<14>::new();
        let mut last = None;
        for _ in 0..60 {
            mean.push([i16::MAX.into(), i16::MIN.into(), 1]);
            if resampler.push([0; 3]).is_some() {
                last = mean.take(&resampler);
            }
        }
        let last: [i32; 3] = last.map(|it: I32x3| it.to_array()).unwrap();
        for (mean, value) in last.into_iter().zip([32_767, -32_768, 1]) {
            let error = f64::from(mean) / 16_384.0 - f64::from(value);
            assert!(
                error.abs() <= f64::from(value).abs() * 1e-4 + 1e-4,
                "{mean}"
            );
        }
    }
}
