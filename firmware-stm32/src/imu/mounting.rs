//! The orientation of the measuring element in the housing.

use plumbline::measure::I32x3;

/// The axis and direction of the part that correspond to an axis of the sensor.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Axis {
    /// +X of the part.
    X,
    /// +Y of the part.
    Y,
    /// +Z of the part.
    Z,
    /// -X of the part.
    NegativeX,
    /// -Y of the part.
    NegativeY,
    /// -Z of the part.
    NegativeZ,
}

/// The mounting of the part: X, Y and Z of the sensor as axes of the part. They must be right-handed.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Mounting(pub [Axis; 3]);

impl Mounting {
    /// The axes of the part are those of the sensor.
    pub const ALIGNED: Self = Self([Axis::X, Axis::Y, Axis::Z]);
}

/// The values along the axes of the sensor, each converted by `units`.
pub fn mounted(counts: I32x3, mounting: Mounting, units: impl Fn(i32) -> i32) -> I32x3 {
    let [x, y, z] = mounting.0;
    I32x3 {
        x: along(x, counts, &units),
        y: along(y, counts, &units),
        z: along(z, counts, &units),
    }
}

/// The value along one axis.
fn along(axis: Axis, counts: I32x3, units: &impl Fn(i32) -> i32) -> i32 {
    match axis {
        Axis::X => units(counts.x),
        Axis::Y => units(counts.y),
        Axis::Z => units(counts.z),
        Axis::NegativeX => -units(counts.x),
        Axis::NegativeY => -units(counts.y),
        Axis::NegativeZ => -units(counts.z),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn mounting_rotates_axes() {
        // The part is rotated by 90 deg about Z: its Y is X of the sensor, its X is -Y of the sensor.
        let mounting = Mounting([Axis::Y, Axis::NegativeX, Axis::Z]);
        let counts = I32x3 {
            x: 100,
            y: 200,
            z: 300,
        };
        let turned = mounted(counts, mounting, |count| count * 2);
        assert_eq!(turned.to_array(), [400, -200, 600]);
    }
}
