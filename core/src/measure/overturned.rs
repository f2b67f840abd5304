//! A 2-axis sensor that lies on its back: its angles are those of a level sensor, but its inclination is beyond the range.

use super::{I32x3, ONE_G};

/// The sensor no longer lies on its back when the Z component of the mean up vector is above this value: 0.02 g, 1.15 deg.
const UPRIGHT: i32 = ONE_G / 50;

/// The result changes after this number of consecutive samples that contradict it: 100 ms, longer than a shock.
const DELAY: u8 = 20;

/// Whether the sensor lies on its back.
///
/// The first sample sets the result without delay, so a sensor that starts on its back is never reported as level.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct Overturned {
    has_sample: bool,
    is_overturned: bool,
    /// The number of consecutive samples that contradict `is_overturned`.
    contrary: u8,
}

impl Overturned {
    /// No sample yet. All its bits are 0.
    pub const INITIAL: Self = Self {
        has_sample: false,
        is_overturned: false,
        contrary: 0,
    };

    /// Processes a sample: the up vector, and its mean from the low-pass of [`Plausibility`](super::plausibility::Plausibility). The result
    /// becomes true when a Z component has been negative for 100 ms. It becomes false when the Z component of the mean has been above 0.02
    /// g for 100 ms.
    ///
    /// The mean alone would be late when the sensor turns over, and the up vector alone would change its sign under vibration. A shock of 8 g
    /// for 20 ms keeps the mean negative for less than 100 ms.
    pub fn step(&mut self, up: I32x3, mean: I32x3) -> bool {
        let contradicts = if self.is_overturned {
            mean.z > UPRIGHT
        } else {
            up.z < 0 || mean.z < 0
        };
        self.contrary = if contradicts { self.contrary + 1 } else { 0 };
        if contradicts && (self.contrary >= DELAY || !self.has_sample) {
            self.is_overturned = !self.is_overturned;
            self.contrary = 0;
        }
        self.has_sample = true;
        self.is_overturned
    }

    /// The next sample sets the result without delay. Call it after missing samples.
    pub fn restart(&mut self) {
        *self = Self::INITIAL;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn along_z(z: i32) -> I32x3 {
        I32x3 { x: 7, y: 8, z }
    }

    #[test]
    fn sensor_is_overturned_below_0_and_upright_above_0_02_g() {
        let mut overturned = Overturned::INITIAL;
        for (z, expected) in [
            (ONE_G, false),
            (0, false),
            (-1, true),
            (-ONE_G, true),
            (0, true),
            (UPRIGHT, true),
            (UPRIGHT + 1, false),
            (0, false),
            (i32::MIN, true),
            (i32::MAX, false),
        ] {
            let mut judged = false;
            for _ in 0..20 {
                judged = overturned.step(along_z(z), along_z(z));
            }
            assert_eq!(judged, expected, "{z}");
        }
    }

    #[test]
    fn first_sample_sets_result_immediately_and_later_samples_after_100_ms() {
        let mut overturned = Overturned::INITIAL;
        assert!(overturned.step(along_z(-1), along_z(-1)));
        for (z, expected) in [(ONE_G, false), (-ONE_G, true), (ONE_G, false)] {
            for sample in 1..20 {
                let judged = overturned.step(along_z(z), along_z(z));
                assert_eq!(judged, !expected, "{sample}");
            }
            assert_eq!(overturned.step(along_z(z), along_z(z)), expected);
        }
        overturned.restart();
        assert!(overturned.step(along_z(-1), along_z(-1)), "missing samples");
    }

    #[test]
    fn negative_mean_under_vibration_is_overturned() {
        let [below, above] = [-ONE_G, ONE_G].map(along_z);
        let mut overturned = Overturned::INITIAL;
        overturned.step(above, above);
        // The sensor turns over: the mean follows. Then it vibrates.
        for sample in 1..20 {
            let mean = if sample < 11 { above } else { below };
            let up = if sample < 12 || sample % 2 == 0 {
                below
            } else {
                above
            };
            assert!(!overturned.step(up, mean), "{sample}");
        }
        assert!(overturned.step(above, below));
        for _ in 0..100 {
            assert!(overturned.step(above, below), "shocks");
        }
    }
}
