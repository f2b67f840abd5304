//! Angle definitions: the angles of a sensor from its up vector.
//!
//! `up` is the specific force in the coordinate frame of the housing. At rest it points away from the earth; a level 2-axis
//! sensor has up = (0, 0, 1). Only its direction has an effect, and all integer vectors are permitted. The error of each angle is
//! at most 1.5e-5 deg ([`ERROR`]), also at +-90 deg. The arc sine has no resolution there, so a tilt is always the arc tangent of
//! one component over the length of the other two.
//!
//! An angle that the vector does not determine is 0: the direction if there is no slope, Y of gimbal X at X = +-90 deg, and all
//! angles of the zero vector.
//!
//! With g = (-ux, uy, uz), the four pairs of angles of a 2-axis sensor are (ifm JN2101 manual 8):
//!
//! | definition        | longitudinal (X)               | lateral (Y)                    |
//! |-------------------|--------------------------------|--------------------------------|
//! | [`perpendicular`] | atan2(gx, sqrt(gy^2 + gz^2))   | atan2(gy, sqrt(gx^2 + gz^2))   |
//! | [`euler`]         | slope: atan2(sqrt(gx^2 + gy^2), gz) | direction: atan2(gx, -gy) mod 360 |
//! | [`gimbal_x`]      | as perpendicular               | atan2(gy, gz)                  |
//! | [`gimbal_y`]      | atan2(gx, gz)                  | as perpendicular               |
//!
//! If the housing is rotated about only one of its axes, perpendicular and gimbal angles are equal.

use super::I32x3;
use crate::angle::Angle;

/// The largest error of an angle compared with exact arithmetic on the same vector: 1.5e-5 deg. The tests check it.
pub const ERROR: Angle = Angle(178);

/// The perpendicular angles of a 2-axis sensor, each -90..=90 deg: the angles between gravity and the planes of the housing.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Perpendicular {
    /// X, longitudinal: relative to the YZ plane. A right-hand rotation about the Y axis (the X axis moves down) is positive.
    pub x: Angle,
    /// Y, lateral: relative to the XZ plane. A right-hand rotation about the X axis (the Y axis moves up) is positive.
    pub y: Angle,
}

/// The perpendicular angles of a 2-axis sensor. With g = (-ux, uy, uz), X = atan2(gx, sqrt(gy^2 + gz^2)), Y = atan2(gy, sqrt(gx^2
/// + gz^2)).
///
/// ```
/// use plumbline::measure::{I32x3, definition::perpendicular};
///
/// let level = perpendicular(I32x3 { x: 0, y: 0, z: 1000 });
/// assert_eq!((level.x.centidegrees(), level.y.centidegrees()), (0, 0));
/// let nose_down = perpendicular(I32x3 { x: -1000, y: 0, z: 1000 });
/// assert_eq!((nose_down.x.centidegrees(), nose_down.y.centidegrees()), (45_00, 0));
/// ```
pub fn perpendicular(up: I32x3) -> Perpendicular {
    let up = normalise(up);
    Perpendicular {
        x: -tilt(up.x, up.y, up.z),
        y: tilt(up.y, up.x, up.z),
    }
}

/// The Euler angles of a 2-axis sensor: amount and direction of the slope.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Euler {
    /// The slope, 0..=180 deg: between the Z axis and the vertical.
    pub slope: Angle,
    /// The direction of the slope, 0..360 deg: the rotation of the housing about its Z axis. 0 with the Y axis down, 90 deg with
    /// the X axis down. Without a slope it is undefined and set to 0.
    pub direction: Angle,
}

/// The Euler angles of a 2-axis sensor: slope = atan2(sqrt(gx^2 + gy^2), gz), direction = atan2(gx, -gy) mod 360 with
/// g = (-ux, uy, uz) (ifm JN2101 manual 8.2).
///
/// Close to level, the direction depends on the noise of the accelerometer.
///
/// ```
/// use plumbline::measure::{I32x3, definition::euler};
///
/// let nose_down = euler(I32x3 { x: -1000, y: 0, z: 1000 });
/// assert_eq!(nose_down.slope.centidegrees(), 45_00);
/// assert_eq!(nose_down.direction.centidegrees_unsigned(), 90_00);
/// ```
pub fn euler(up: I32x3) -> Euler {
    // 180 deg are added instead of negating both components, because -i32::MIN does not exist.
    let direction = if (up.x | up.y) == 0 {
        Angle::ZERO
    } else {
        Angle::atan2(up.x, up.y) + Angle::HALF
    };
    let up = normalise(up);
    let squares = square(up.x).wrapping_add(square(up.y));
    let acute = Angle::first_quadrant(half_square_root(squares), up.z.unsigned_abs() / 2);
    Euler {
        slope: if up.z < 0 { Angle::HALF - acute } else { acute },
        direction,
    }
}

/// The gimbal angles of a 2-axis sensor: two consecutive rotations from the level position to the present position.
///
/// In both orders, the first rotation is about a fixed axis and has a range of 360 deg. The second rotation is about an axis that
/// was rotated with the housing and has a range of +-90 deg.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Gimbal {
    /// X, longitudinal: the rotation about the Y axis.
    pub x: Angle,
    /// Y, lateral: the rotation about the X axis.
    pub y: Angle,
}

/// The gimbal angles X: X = atan2(gx, sqrt(gy^2 + gz^2)), -90..=90 deg, Y = atan2(gy, gz), -180..180 deg, with g = (-ux, uy, uz)
/// (ifm JN2101 manual 8.3). Pitch and roll of an aircraft whose longitudinal axis is X.
///
/// At X = +-90 deg, Y is undefined. Close to it, Y depends on the noise of the accelerometer.
///
/// ```
/// use plumbline::measure::{I32x3, definition::gimbal_x};
///
/// let on_its_back = gimbal_x(I32x3 { x: 0, y: 1, z: -1000 });
/// assert_eq!((on_its_back.x.centidegrees(), on_its_back.y.centidegrees()), (0, 179_94));
/// ```
pub fn gimbal_x(up: I32x3) -> Gimbal {
    let up = normalise(up);
    Gimbal {
        x: -tilt(up.x, up.y, up.z),
        y: Angle::atan2(up.y, up.z),
    }
}

/// The gimbal angles Y: X = atan2(gx, gz), -180..180 deg, Y = atan2(gy, sqrt(gx^2 + gz^2)), -90..=90 deg, with g = (-ux, uy, uz)
/// (ifm JN2101 manual 8.4): [`gimbal_x`] with the rotations in the other order.
///
/// At Y = +-90 deg, X is undefined. Close to it, X depends on the noise of the accelerometer.
///
/// ```
/// use plumbline::measure::{I32x3, definition::gimbal_y};
///
/// let nose_down = gimbal_y(I32x3 { x: -1000, y: 0, z: 1000 });
/// assert_eq!((nose_down.x.centidegrees(), nose_down.y.centidegrees()), (45_00, 0));
/// ```
pub fn gimbal_y(up: I32x3) -> Gimbal {
    let up = normalise(up);
    Gimbal {
        x: -Angle::atan2(up.x, up.z),
        y: tilt(up.y, up.x, up.z),
    }
}

/// The angle of a 1-axis sensor, 0..360 deg: atan2(ux, uy). 0 with the Y axis up; a right-hand rotation about the Z axis of the
/// housing is positive.
///
/// ```
/// use plumbline::measure::{I32x3, definition::rotation};
///
/// let up = I32x3 { x: -1000, y: 0, z: 0 };
/// assert_eq!(rotation(up).centidegrees_unsigned(), 270_00);
/// ```
pub fn rotation(up: I32x3) -> Angle {
    Angle::atan2(up.x, up.y)
}

/// The cross slope of a 1-axis sensor, -90..=90 deg: the angle of its Z axis above the horizontal, asin(uz) for a unit vector.
pub fn cross_slope(up: I32x3) -> Angle {
    let up = normalise(up);
    tilt(up.z, up.x, up.y)
}

/// `up`, shifted left as far as its largest component permits. Otherwise the square root of a small vector would be too coarse.
pub(super) fn normalise(up: I32x3) -> I32x3 {
    // x ^ (x >> 31) has a leading zero for each sign bit of x. Unlike the absolute value, it exists for all x.
    let bits = (up.x ^ (up.x >> 31)) | (up.y ^ (up.y >> 31)) | (up.z ^ (up.z >> 31));
    let shift = bits.leading_zeros().wrapping_sub(1);
    I32x3 {
        x: up.x.wrapping_shl(shift),
        y: up.y.wrapping_shl(shift),
        z: up.z.wrapping_shl(shift),
    }
}

/// atan(`along` / sqrt(`a`^2 + `b`^2)), -90..=90 deg.
fn tilt(along: i32, a: i32, b: i32) -> Angle {
    let squares = square(a).wrapping_add(square(b)); // at most 2^63
    // Half of both sides, because sqrt(2^63) can exceed 2^31, the maximum of the other side.
    let angle = Angle::first_quadrant(along.unsigned_abs() / 2, half_square_root(squares));
    if along < 0 { -angle } else { angle }
}

pub(super) fn square(value: i32) -> u64 {
    (i64::from(value) * i64::from(value)) as u64
}

/// sqrt(`square`) / 2, rounded down, for `square` up to 2^63; the relative error is below 6e-8.
fn half_square_root(square: u64) -> u32 {
    if square == 0 {
        return 0;
    }
    // The 32 leading bits, shifted by an even number: n = 2^30..2^32.
    let shift = square.leading_zeros() & !1;
    let n = (square.wrapping_shl(shift) >> 32) as u32;
    // A straight line within 3 % of the root, then one step of Heron's method. Its error is at most 4.5e-4 and never negative, so
    // half of that is subtracted.
    let line = ((n >> 16) * 11 / 16 + 22_500) | 1;
    let heron = (line + n / line) / 2;
    let root = (heron - heron / 4096) | 1;
    // The second step squares the error to 3e-8. Its correction has nine bits more than the root; n - root^2 has 23.
    let rest = n.wrapping_sub(root.wrapping_mul(root)) as i32;
    let fine = ((root << 10) as i32).wrapping_add((rest << 9) / root as i32);
    ((fine as u32) << 5).wrapping_shr(shift / 2)
}

#[cfg(test)]
mod tests;
