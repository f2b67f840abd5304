//! A 2-axis sensor that lies on its back: its angles are those of a level sensor, but its inclination is beyond the range.

use super::{I32x3, ONE_G};

/// The Z component of the up vector above which the sensor does not lie on its back any more: 0.02 g, 1.15 deg.
const UPRIGHT: i32 = ONE_G / 50;

/// Whether the sensor lies on its back.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct Overturned(bool);

impl Overturned {
    /// Not on its back.
    pub const INITIAL: Self = Self(false);

    /// Processes an up vector, which must be filtered: a shock does not turn the sensor over. Returns true from a negative Z component on until it is above 0.02 g.
    pub fn step(&mut self, up: I32x3) -> bool {
        let least = if self.0 { UPRIGHT + 1 } else { 0 };
        self.0 = up.z < least;
        self.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
            assert_eq!(overturned.step(I32x3 { x: 7, y: 8, z }), expected, "{z}");
        }
    }
}
