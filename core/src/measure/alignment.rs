//! The acceleration and the angular rate of a reading at the same time.
//!
//! The acceleration of a reading is older than its angular rate by the delay of the [`resampler`](super::resampler), nine periods of
//! the accelerometer or 10.8 ms: 0.16 of a sampling period more than two. A filter that combines both would be late by this delay,
//! which is 5 deg at 471 deg/s. So the filter gets the rate with the same delay, and its result is rotated by the rate since then:
//!
//! ```text
//!  angular rate of the samples, k is the newest   |  k-3  |  k-2  |  k-1  |   k   |
//!  time of the acceleration of sample k                         ^ 2.16 periods before the end of k
//!  delayed rate: the period that ends there             |<------>|
//!  rotation from there to the end of k                          |<------------->|
//! ```
//!
//! The delay is outside of the loop of the filter, so the filter stays stable with every gain.
//!
//! ```
//! use plumbline::measure::{I32x3, ONE_G, alignment::Alignment};
//!
//! let mut alignment = Alignment::INITIAL;
//! let rate = I32x3 { x: 0, y: 0, z: 100 << 16 };
//! for _ in 0..4 {
//!     let delayed = alignment.delay(rate);
//!     // Here the filter takes the acceleration and the delayed rate. It returns the up vector of 10.8 ms ago.
//!     let up = alignment.lead(I32x3 { x: ONE_G, y: 0, z: 0 });
//!     assert!(up.y < 0 && delayed.z <= rate.z);
//! }
//! assert_eq!(alignment.delay(rate), rate);
//! ```

use super::I32x3;

/// The delay of the acceleration is two sampling periods and this part of a period, as a fraction of 2^16: 9 values at 833.375 Hz are
/// 2.1599 periods of 5 ms. An error of 5 % of the clock changes the delay by 0.5 ms.
const PART: i64 = 10_479;

/// A rate in 2^-16 deg/s as rotation in a sampling period of 5 ms, in 2^-31 rad, as a fraction of 2^16: 0.005 s * pi / 180 * 2^31.
const ROTATION: i64 = 187_402;

/// The rates of the last samples.
#[derive(Clone, Debug, Default)]
pub struct Alignment {
    /// The newest first.
    rates: [[i32; 3]; 4],
}

impl Alignment {
    /// At rest.
    pub const INITIAL: Self = Self { rates: [[0; 3]; 4] };

    /// Takes the mean rate of the newest sampling period. Returns that of the period that ends at the time of the acceleration.
    pub fn delay(&mut self, rate: I32x3) -> I32x3 {
        let [newest, before, third, _] = self.rates;
        self.rates = [rate.to_array(), newest, before, third];
        let [_, _, later, earlier] = self.rates;
        each(|axis| {
            let (later, earlier) = (axis(later), axis(earlier));
            later.wrapping_add(part(earlier.wrapping_sub(later)))
        })
    }

    /// `vector` at the time of the acceleration, as it is at the time of the newest rate. It does not move in space, so the rotation
    /// of the sensor moves it in the opposite direction. The error of a rotation by 6 deg is 0.01 deg.
    pub fn lead(&self, vector: I32x3) -> I32x3 {
        let [newest, before, part_of, _] = self.rates;
        let rotation = each(|axis| {
            let rate = axis(newest)
                .wrapping_add(axis(before))
                .wrapping_add(part(axis(part_of)));
            ((i64::from(rate) * ROTATION) >> 16) as i32
        });
        let first = cross(vector, rotation);
        let second = cross(first, rotation);
        let sum = |vector: i32, first: i32, second: i32| {
            vector.wrapping_add(first).wrapping_add(second >> 1)
        };
        I32x3 {
            x: sum(vector.x, first.x, second.x),
            y: sum(vector.y, first.y, second.y),
            z: sum(vector.z, first.z, second.z),
        }
    }
}

/// A vector from the value of each axis.
fn each(value: impl Fn(fn([i32; 3]) -> i32) -> i32) -> I32x3 {
    I32x3 {
        x: value(|[x, _, _]| x),
        y: value(|[_, y, _]| y),
        z: value(|[_, _, z]| z),
    }
}

/// [`PART`] of a rate.
fn part(rate: i32) -> i32 {
    ((i64::from(rate) * PART) >> 16) as i32
}

/// The product of a vector and a rotation in 2^-31 rad.
fn cross(a: I32x3, b: I32x3) -> I32x3 {
    let component = |a1: i32, b2: i32, a2: i32, b1: i32| {
        let product = i64::from(a1) * i64::from(b2);
        (product.wrapping_sub(i64::from(a2) * i64::from(b1)) >> 31) as i32
    };
    I32x3 {
        x: component(a.y, b.z, a.z, b.y),
        y: component(a.z, b.x, a.x, b.z),
        z: component(a.x, b.y, a.y, b.x),
    }
}

#[cfg(test)]
mod tests {
    use super::super::ONE_G;
    use super::super::mean_rate::MeanRate;
    use super::super::resampler::Resampler;
    use super::*;
    use std::f64::consts::PI;

    const HZ: f64 = 833.375;

    /// The sensor turns about X from -45 to +45 deg within 0.3 s, at 471 deg/s at most. The acceleration is gravity alone. Without
    /// correction the error is 5 deg.
    #[test]
    fn leading_vector_has_no_delay() {
        let angle = |time: f64| {
            let part = ((time - 0.5) / 0.3).clamp(0.0, 1.0);
            (-45.0 * (PI * part).cos()).to_radians()
        };
        let mut resampler = Resampler::<i32, 0>::new();
        resampler.start(833_375);
        let (mut mean, mut alignment) = (MeanRate::<0>::new(), Alignment::INITIAL);
        let (mut worst, mut uncorrected) = (0.0_f64, 0.0_f64);
        for number in 0..(HZ as u32) {
            let time = f64::from(number) / HZ;
            let rate = (angle(time + 1e-6) - angle(time - 1e-6)) / 2e-6;
            mean.push([(rate.to_degrees() * 65_536.0) as i32, 0, 0]);
            // A rotation about +X turns the up vector of the sensor from +Z to +Y.
            let up = [0.0, angle(time).sin(), angle(time).cos()];
            let Some(up) = resampler.push(up.map(|it| (it * f64::from(ONE_G)) as i32)) else {
                continue;
            };
            let behind = f64::from(resampler.since_output()) / 65_536.0 / HZ;
            let Some(rate) = mean.take(&resampler) else {
                continue;
            };
            let of = |up: I32x3| f64::from(up.y).atan2(f64::from(up.z));
            let error = |up: I32x3| (of(up) - angle(time - behind)).to_degrees().abs();
            alignment.delay(rate);
            uncorrected = uncorrected.max(error(up));
            worst = worst.max(error(alignment.lead(up)));
        }
        assert!(uncorrected > 4.5, "{uncorrected}");
        assert!(worst < 0.15, "{worst}");
    }

    /// The delayed rate, integrated, is the rotation of the acceleration.
    #[test]
    fn delayed_rate_is_that_of_the_acceleration() {
        let mut alignment = Alignment::INITIAL;
        let axis = |x| I32x3 { x, y: -x, z: 0 };
        let delayed = [0, 65_536, 0, 0, 0, 0].map(|rate| alignment.delay(axis(rate)).x);
        // 2.16 periods later: 0.84 in one period, 0.16 in the next one.
        assert_eq!(delayed, [0, 0, 0, 65_536 - 10_479, 10_479, 0]);
    }

    #[test]
    fn lead_rotates_opposite_to_the_sensor() {
        let mut alignment = Alignment::INITIAL;
        for _ in 0..4 {
            alignment.delay(I32x3 {
                x: 0,
                y: 0,
                z: 500 << 16,
            });
        }
        let up = alignment.lead(I32x3 {
            x: ONE_G,
            y: 0,
            z: 0,
        });
        let turned = f64::from(up.y).atan2(f64::from(up.x)).to_degrees();
        // 500 deg/s for 10.8 ms.
        assert!((turned + 5.4).abs() < 0.01, "{turned}");
        assert_eq!(up.z, 0);
    }

    #[test]
    fn any_rate_is_taken() {
        let mut alignment = Alignment::INITIAL;
        for rate in [i32::MIN, i32::MAX, 0, i32::MIN] {
            let rate = I32x3 {
                x: rate,
                y: i32::MAX,
                z: i32::MIN,
            };
            alignment.delay(rate);
            alignment.lead(I32x3 {
                x: i32::MIN,
                y: i32::MIN,
                z: i32::MAX,
            });
        }
    }
}
