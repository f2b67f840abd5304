//! Whether the acceleration is a valid measurement, for all products alike.

use super::I32x3;
use super::clipping::Clipping;
use super::overturned::Overturned;
use super::plausibility::Plausibility;

/// What is known of the accelerometer.
#[derive(Clone, Copy, Debug, Default)]
pub struct Validity {
    clipping: Clipping,
    plausibility: Plausibility,
    /// The last sample is up to date.
    is_current: bool,
    clips: bool,
    is_defective: bool,
    overturned: Overturned,
    is_overturned: bool,
}

impl Validity {
    /// Before the first sample: no fault, but nothing valid. All its bits are 0.
    pub const INITIAL: Self = Self {
        clipping: Clipping::NONE,
        plausibility: Plausibility::INITIAL,
        is_current: false,
        clips: false,
        is_defective: false,
        overturned: Overturned::INITIAL,
        is_overturned: false,
    };

    /// Processes a sample: the calibrated acceleration before all filters, and whether an axis was at the limit of its range.
    pub fn step(&mut self, acceleration: I32x3, clipped: bool) {
        self.is_current = true;
        self.clips = self.clipping.step(clipped);
        self.is_defective = self.plausibility.step(acceleration);
        self.is_overturned = self.overturned.step(acceleration, self.plausibility.mean());
    }

    /// Handles missing samples: the acceleration is not valid until samples come again.
    pub fn stale(&mut self) {
        self.is_current = false;
        self.is_defective = true;
        self.plausibility.restart();
        self.overturned.restart();
    }

    /// The mean acceleration is 1 g within 0.05 g: there is no long acceleration besides gravity.
    pub fn is_one_g(&self) -> bool {
        self.plausibility.is_one_g()
    }

    /// An axis has been at the limit of its range for longer than 100 ms.
    pub fn clips(&self) -> bool {
        self.clips
    }

    /// The accelerometer gives no samples, or samples that are not those of a working one.
    pub fn is_defective(&self) -> bool {
        self.is_defective
    }

    /// The sensor has been on its back for 100 ms. A sensor of two axes is then out of its range.
    pub fn is_overturned(&self) -> bool {
        self.is_overturned
    }

    /// The present angle is measured, so it may become a zero point or a reference.
    pub fn is_valid(&self) -> bool {
        self.is_current && !self.is_defective && !self.clipping.is_recent()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::measure::{ONE_G, RANGE};

    const LEVEL: I32x3 = I32x3 {
        x: 0,
        y: 0,
        z: ONE_G,
    };
    const NOTHING: I32x3 = I32x3 { x: 0, y: 0, z: 0 };

    /// Clips, is defective, is valid.
    fn of(validity: &Validity) -> [bool; 3] {
        [
            validity.clips(),
            validity.is_defective(),
            validity.is_valid(),
        ]
    }

    #[test]
    fn nothing_is_valid_before_the_first_sample() {
        assert_eq!(of(&Validity::INITIAL), [false, false, false]);
    }

    #[test]
    fn only_a_current_plausible_sample_without_clipping_is_valid() {
        let mut validity = Validity::INITIAL;
        validity.step(LEVEL, false);
        assert_eq!(of(&validity), [false, false, true]);
        validity.step(LEVEL, true);
        assert_eq!(of(&validity), [false, false, false], "one clipped sample");
        for _ in 0..20 {
            validity.step(LEVEL, true);
        }
        assert_eq!(of(&validity), [true, false, false]);
        for _ in 0..20 {
            validity.step(LEVEL, false);
        }
        assert_eq!(of(&validity), [false, false, true]);
        validity.stale();
        assert_eq!(of(&validity), [false, true, false]);
        validity.step(NOTHING, false);
        assert_eq!(of(&validity), [false, true, false]);
        validity.stale();
        validity.step(LEVEL, false);
        assert_eq!(of(&validity), [false, false, true]);
    }

    #[test]
    fn shock_does_not_turn_the_sensor_over() {
        let along_z = |z| I32x3 { x: 0, y: 0, z };
        // Level, then on its back. 8 g for 20 ms, twice a second.
        let mut validity = Validity::INITIAL;
        for (gravity, shock, expected) in [(ONE_G, -RANGE, false), (-ONE_G, RANGE - 1, true)] {
            (0..100).for_each(|_| validity.step(along_z(gravity), false));
            for n in 0..1000 {
                let z = if n % 100 < 96 { gravity } else { shock };
                validity.step(along_z(z), false);
                assert_eq!(validity.is_overturned(), expected, "sample {n}");
            }
        }
    }

    #[test]
    fn validity_reports_overturned_sensor_after_100_ms() {
        let along_z = |z| I32x3 { x: 0, y: 0, z };
        let mut validity = Validity::INITIAL;
        (0..100).for_each(|_| validity.step(along_z(ONE_G), false));
        for n in 1..=20 {
            validity.step(along_z(-ONE_G), false);
            assert_eq!(validity.is_overturned(), n == 20, "sample {n}");
        }
        // No delay at power-up and after missing samples.
        validity.stale();
        validity.step(along_z(ONE_G), false);
        assert!(!validity.is_overturned());
    }
}
