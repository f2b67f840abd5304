//! Plausibility of the accelerometer: a dead, disconnected or wrong accelerometer does not measure 1 g.
//!
//! The vector passes a low-pass of 2 Hz, and then its length must be 0.6 to 1.5 g. A low-pass of the length instead would alarm under
//! vibration: the length of a vector that vibrates is longer than 1 g in the mean. A narrower window would alarm on a crane at sea.

use super::definition::square;
use super::{I32x3, ONE_G};
use core::ops::RangeInclusive;

/// The shortest plausible vector, squared: 0.6 g.
const SHORTEST: u64 = (ONE_G as u64 * 3 / 5).pow(2);

/// The longest plausible vector, squared: 1.5 g.
const LONGEST: u64 = (ONE_G as u64 * 3 / 2).pow(2);

/// The number of samples for which the length must contradict the fault until the fault changes: 0.5 s.
const DELAY: u8 = 100;

/// The number of samples in the time constant of the low-pass, 80 ms: 2.05 Hz at 200 Hz.
const SMOOTHING: u8 = 16;

/// The number of fractional bits of the mean.
const FRACTION: u32 = 16;

/// The number of fractional bits of the gain of the low-pass. A product with a difference of two inputs has at most 61 bits.
const GAIN_BITS: u32 = 12;

/// Detects a dead or wrong accelerometer.
///
/// The first sample sets the fault without delay, so a sensor with a dead accelerometer is never reported as level. Until the low-pass has
/// settled, the mean is that of all samples, and a fault of the first samples ends when the mean is plausible. Under vibration, the first
/// sample alone can be implausible.
#[derive(Clone, Copy, Debug, Default)]
pub struct Plausibility {
    /// The output of the low-pass. Valid if there was a sample.
    mean: [i64; 3],
    /// The number of samples, at most those in the time constant of the low-pass.
    samples: u8,
    fault: bool,
    /// The number of consecutive samples that contradict `fault`.
    contrary: u8,
}

impl Plausibility {
    /// No sample yet. All its bits are 0.
    pub const INITIAL: Self = Self {
        mean: [0; 3],
        samples: 0,
        fault: false,
        contrary: 0,
    };

    /// Processes a calibrated acceleration (1 g = 2^26); call it once per [`SAMPLE_PERIOD`](super::SAMPLE_PERIOD). Returns true while the
    /// accelerometer has a fault.
    pub fn step(&mut self, acceleration: I32x3) -> bool {
        let input = acceleration
            .to_array()
            .map(|component| i64::from(component) << FRACTION);
        let settled = self.samples >= SMOOTHING;
        // Multiplied by the reciprocal: a division of 64 bits is slow.
        let gain = (1 << GAIN_BITS) / (u32::from(self.samples.min(SMOOTHING - 1)) + 1);
        for (mean, input) in self.mean.iter_mut().zip(input) {
            *mean += ((input - *mean) * i64::from(gain)) >> GAIN_BITS;
        }
        if !settled {
            self.samples += 1;
        }
        let outside = self.is_outside();
        if outside == self.fault {
            self.contrary = 0;
        } else {
            self.contrary += 1;
            let at_once = self.samples == 1 || self.fault && !settled;
            if at_once || self.contrary >= DELAY {
                self.fault = outside;
                self.contrary = 0;
            }
        }
        self.fault
    }

    /// The output of the low-pass.
    pub fn mean(&self) -> I32x3 {
        let [x, y, z] = self.mean.map(|component| (component >> FRACTION) as i32);
        I32x3 { x, y, z }
    }

    /// The next sample is judged at once: after missing samples.
    pub fn restart(&mut self) {
        self.samples = 0;
    }

    /// Whether the mean is 1 g within 0.05 g.
    pub fn is_one_g(&self) -> bool {
        const ENDS: RangeInclusive<u64> =
            (ONE_G as u64 * 19 / 20).pow(2)..=(ONE_G as u64 * 21 / 20).pow(2);
        ENDS.contains(&self.square())
    }

    /// Whether the mean is too short or too long.
    fn is_outside(&self) -> bool {
        !(SHORTEST..=LONGEST).contains(&self.square())
    }

    /// The square of the length of the mean.
    fn square(&self) -> u64 {
        let [x, y, z] = self.mean().to_array().map(square);
        x + y + z
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::measure::RANGE;
    use core::f64::consts::TAU;

    fn along(x: f64, y: f64, z: f64) -> I32x3 {
        let [x, y, z] = [x, y, z].map(|g| (g * f64::from(ONE_G)) as i32);
        I32x3 { x, y, z }
    }

    /// The number of samples until the fault is `expected`, with this acceleration in g.
    fn samples_until(judge: &mut Plausibility, expected: bool, z: f64) -> usize {
        let change = (1..1000).find(|_| judge.step(along(0.0, 0.0, z)) == expected);
        change.expect("a change within 5 s")
    }

    #[test]
    fn first_sample_is_judged_at_once() {
        for (g, fault) in [
            (0.0, true),
            (0.59, true),
            (0.61, false),
            (1.0, false),
            (1.49, false),
            (1.51, true),
            (8.0, true),
        ] {
            for direction in [[1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.6, 0.0, -0.8]] {
                let [x, y, z] = direction.map(|part: f64| part * g);
                let mut judge = Plausibility::INITIAL;
                assert_eq!(judge.step(along(x, y, z)), fault, "{g} {direction:?}");
            }
        }
    }

    #[test]
    fn mean_within_a_twentieth_of_1_g_is_1_g() {
        let mut judge = Plausibility::INITIAL;
        for (z, is_one_g) in [
            (0.949, false),
            (0.951, true),
            (-1.049, true),
            (-1.051, false),
        ] {
            judge.restart();
            judge.step(along(0.0, 0.0, z));
            assert_eq!(judge.is_one_g(), is_one_g, "{z}");
        }
        // A vibration of 0.5 g passes.
        judge.restart();
        for n in 0..400 {
            judge.step(along(
                0.0,
                0.0,
                1.0 + 0.5 * (TAU * 30.0 * f64::from(n) * 0.005).sin(),
            ));
        }
        assert!(judge.is_one_g());
    }

    #[test]
    fn fault_begins_and_ends_after_half_a_second() {
        let mut judge = Plausibility::INITIAL;
        assert!(!judge.step(along(0.0, 0.0, 1.0)));
        // The low-pass needs 40 ms from 1 g to 0.6 g, and the same from 0 g to 0.6 g plus 35 ms.
        assert!((100..=110).contains(&samples_until(&mut judge, true, 0.0)));
        assert!((100..=120).contains(&samples_until(&mut judge, false, 1.0)));
        judge.step(along(0.0, 0.0, 1.0));
        assert!((100..=110).contains(&samples_until(&mut judge, true, 2.0)));
    }

    /// 1.8 g at 20 Hz from power-up, from each phase.
    #[test]
    fn fault_of_a_first_sample_under_vibration_ends_within_40_ms() {
        for phase in 0..64 {
            let mut judge = Plausibility::INITIAL;
            for n in 0..400 {
                let turns = f64::from(phase) / 64.0 + 20.0 * 0.005 * f64::from(n);
                let fault = judge.step(along(0.0, 0.0, 1.0 + 1.8 * (TAU * turns).sin()));
                assert!(!fault || n < 8, "phase {phase}, sample {n}");
            }
        }
        // A dead or wrong accelerometer keeps its fault.
        for g in [0.0, 0.55, 1.6] {
            let mut judge = Plausibility::INITIAL;
            for n in 0..400 {
                let noise = if n % 2 == 0 { 0.04 } else { -0.04 };
                assert!(judge.step(along(0.0, 0.0, g + noise)), "{g} {n}");
            }
        }
    }

    #[test]
    fn shorter_deviation_is_no_fault() {
        let mut judge = Plausibility::INITIAL;
        judge.step(along(0.0, 0.0, 1.0));
        for _ in 0..10 {
            // 0.4 s without gravity, then 0.4 s with it
            for n in 0..160 {
                let g = if n < 80 { 0.0 } else { 1.0 };
                assert!(!judge.step(along(0.0, 0.0, g)), "sample {n}");
            }
        }
    }

    #[test]
    fn vibration_shock_and_swell_are_no_fault() {
        let hammer = |t: f64| 1.0 + 1.8 * (TAU * 20.0 * t).sin();
        let shock = |t: f64| if t % 0.5 < 0.02 { 4.0 } else { 1.0 };
        let swell = |t: f64| 1.0 + 0.25 * (TAU * 0.1 * t).sin();
        for (name, force) in [
            ("hammer", &hammer as &dyn Fn(f64) -> f64),
            ("shock", &shock),
            ("swell", &swell),
        ] {
            let mut judge = Plausibility::INITIAL;
            judge.step(along(0.0, 0.0, 1.0));
            for n in 0..6000 {
                let along_z = along(0.0, 0.0, force(f64::from(n) * 0.005));
                assert!(!judge.step(along_z), "{name} {n}");
            }
        }
    }

    #[test]
    fn restart_judges_the_next_sample_at_once() {
        let mut judge = Plausibility::INITIAL;
        assert!(!judge.step(along(0.0, 0.0, 1.0)));
        judge.restart();
        assert!(judge.step(along(0.0, 0.0, 0.0)));
        judge.restart();
        assert!(!judge.step(along(0.0, 0.0, 1.0)));
    }

    #[test]
    fn extreme_integers_do_not_overflow() {
        let mut judge = Plausibility::INITIAL;
        for n in 0..400 {
            let end = if n % 3 == 0 { -RANGE } else { RANGE - 1 };
            assert!(
                judge.step(I32x3 {
                    x: end,
                    y: end,
                    z: end
                }) || n > 0
            );
        }
    }
}
