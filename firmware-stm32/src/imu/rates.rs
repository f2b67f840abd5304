//! Judges the values of a gyroscope: leaves out a wrong one, and detects an axis that does not change.
//!
//! The fusion needs a rate at its time, so a value is not held until the next ones have come, as an acceleration is
//! ([`values`](super::values)). A value that is far from the straight line through the two before it is replaced by that line at once. The
//! next value decides: if it is near to the line again, the replaced one was an error between part and microcontroller. Otherwise the
//! difference is added to the next value, so the sum of the values, which is the rotation, stays right.
//!
//! Far is more than `FLOOR` and twice the largest distance from the line within the last 20 ms.

use super::repeats::Repeats;

/// A step of 160 counts, which rest and motion do not exceed: 5.6 deg/s in a value at 35 mdps per count. The noise is 3 counts.
const FLOOR: i32 = 160;

/// The number of values after a replaced one that are not replaced: 19 ms, in which a vibration becomes known. So its begin costs a value at
/// most.
const TRUSTED: u8 = 16;

/// The values of an axis.
#[derive(Clone, Copy, Debug)]
struct Axis {
    /// The last two values.
    earlier: i32,
    last: i32,
    /// What was left out of the last value.
    left_out: i32,
    /// The number of values that are used in any case.
    trusted: u8,
    /// The largest distance from the line. It decreases by a sixteenth with each value.
    distance: i32,
    repeats: Repeats,
}

impl Axis {
    const INITIAL: Self = Self {
        earlier: 0,
        last: 0,
        left_out: 0,
        trusted: 0,
        distance: 0,
        repeats: Repeats::INITIAL,
    };

    /// Takes the next value, and returns what is to be used instead of it.
    #[inline(never)]
    fn push(&mut self, value: i32) -> i32 {
        if self.repeats.is_initial() {
            (self.earlier, self.last) = (value, value);
        }
        let line = 2 * self.last - self.earlier;
        let distance = value - line;
        let is_far = distance.abs() > FLOOR + self.distance * 2;
        self.distance -= self.distance >> 4;
        self.trusted = self.trusted.saturating_sub(1);
        let left_out = core::mem::take(&mut self.left_out);
        if is_far && self.trusted == 0 {
            self.trusted = TRUSTED;
            self.left_out = distance;
            (self.earlier, self.last) = (self.last, line);
            return line;
        }
        let (mut used, mut largest) = (value, distance.abs());
        if is_far && left_out != 0 {
            // The value before was right.
            used += left_out;
            largest = largest.max(left_out.abs());
            self.last += left_out;
        }
        self.distance = self.distance.max(largest);
        (self.earlier, self.last) = (self.last, value);
        used
    }
}

/// The values of three axes, of 16 bits.
#[derive(Clone, Debug)]
pub struct Rates([Axis; 3]);

impl Rates {
    /// Before the first value.
    pub const INITIAL: Self = Self([Axis::INITIAL; 3]);

    /// Takes the next value, and replaces it by what is to be used. Returns true if an axis does not change.
    #[inline(never)]
    pub fn push(&mut self, value: &mut [i32; 3]) -> bool {
        let mut is_stuck = false;
        for (axis, value) in self.0.iter_mut().zip(value) {
            let used = axis.push(*value);
            is_stuck |= axis.repeats.push(*value);
            *value = used;
        }
        is_stuck
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    /// deg/s in a count, and the time between two values in s.
    const COUNT: f64 = 0.035;
    const PERIOD: f64 = 1.0 / 833.375;

    /// The values of X for the rates in deg/s by the time in s, with noise of 3 counts.
    fn values(rate: impl Fn(f64) -> f64) -> Vec<i32> {
        let mut random = 1_u64;
        let mut noise = || {
            let mut sum = -6.0;
            for _ in 0..12 {
                random ^= random << 13;
                random ^= random >> 7;
                random ^= random << 17;
                sum += (random >> 11) as f64 / (1_u64 << 53) as f64;
            }
            sum * 3.0
        };
        (0..10_000)
            .map(|number| (rate(f64::from(number) * PERIOD) / COUNT + noise()).round())
            .map(|count| count.clamp(-32768.0, 32767.0) as i32)
            .collect()
    }

    /// The largest error in deg of the sum of the used values.
    fn error(right: &[i32], received: &[i32]) -> f64 {
        let mut rates = Rates::INITIAL;
        let (mut sum, mut largest) = (0, 0);
        for (number, (right, received)) in right.iter().zip(received).enumerate() {
            let mut value = [*received, number as i32, -(number as i32)];
            assert!(!rates.push(&mut value), "no axis is stuck");
            sum += value[0] - right;
            largest = largest.max(sum.abs());
        }
        f64::from(largest) * COUNT * PERIOD
    }

    #[test]
    fn wrong_bit_turns_by_0_01_degrees_at_most_at_rest_and_in_a_swing() {
        for (amplitude, frequency) in [(0.0, 1.0), (200.0, 1.0), (900.0, 0.5)] {
            let right = values(|time| amplitude * (TAU * frequency * time).sin());
            let mut largest = 0.0_f64;
            for (place, bit) in (577..9_999).step_by(577).flat_map(|at| {
                let bits = 0..16;
                bits.map(move |bit| (at, bit))
            }) {
                let mut received = right.clone();
                received[place] = (right[place] as i16 ^ 1 << bit).into();
                largest = largest.max(error(&right, &received));
            }
            println!("{amplitude} deg/s, {frequency} Hz: {largest:.4} deg");
            assert!(largest <= 0.01, "{amplitude}, {frequency}: {largest}");
        }
    }

    /// It begins and ends twelve times.
    #[test]
    fn vibration_keeps_its_rotation_except_a_value_at_each_begin_from_150_hz_on() {
        for amplitude in [1.0, 10.0, 50.0, 200.0, 500.0] {
            for frequency in [3.0, 20.0, 77.0, 139.0, 208.0, 278.0, 400.0, 416.0] {
                let right = values(|time| {
                    let on = f64::from(u8::from(time % 1.0 < 0.5));
                    on * amplitude * (TAU * frequency * time).sin()
                });
                let mut rates = Rates::INITIAL;
                let mut sum = 0;
                for (number, right) in right.iter().enumerate() {
                    let mut value = [*right, number as i32, 0];
                    rates.push(&mut value);
                    sum += value[0] - right;
                }
                let turned = (f64::from(sum) * COUNT * PERIOD).abs();
                let limit = if frequency > 150.0 {
                    12.0 * amplitude * PERIOD
                } else {
                    1e-6
                };
                assert!(turned <= limit, "{amplitude}, {frequency} Hz: {turned}");
            }
        }
    }

    #[test]
    fn step_of_the_rate_is_used_with_the_next_value() {
        let mut rates = Rates::INITIAL;
        let mut used = |value| {
            let mut values = [value, 0, 0];
            rates.push(&mut values);
            values[0]
        };
        let steps = [0, 0, 5000, 5000, 5000].map(&mut used);
        assert_eq!(steps, [0, 0, 0, 10_000, 5000]);
    }
}
