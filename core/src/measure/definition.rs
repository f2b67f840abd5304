//! Angle definitions: what the angles of a sensor are, given where up is.
//!
//! `up` is the specific force in the frame of the housing: at rest it points away from the earth, and a level 2-axis sensor has
//! up = (0, 0, 1). Only its direction counts; every vector of integers is allowed, and the zero vector has the angle 0. Each
//! angle is off by at most 1.5e-5 deg ([`ERROR`]), also at +-90 deg: an arc sine would be blind there, so a tilt is always the arc tangent of
//! one component over the length of the other two.

use super::I32x3;
use crate::angle::Angle;

/// The largest error of an angle against exact arithmetic on the same vector: 1.5e-5 deg. The tests hold it to this.
pub const ERROR: Angle = Angle(178);

/// The angles of a 2-axis sensor, each -90..=90 deg: of gravity against the planes of the housing.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Perpendicular {
    /// X, longitudinal: against the YZ plane, a right-hand turn about the Y axis (the X axis goes down) counts up.
    pub x: Angle,
    /// Y, lateral: against the XZ plane, a right-hand turn about the X axis (the Y axis goes up) counts up.
    pub y: Angle,
}

/// Both angles of a 2-axis sensor. With g = (-ux, uy, uz), X = atan2(gx, sqrt(gy^2 + gz^2)), Y = atan2(gy, sqrt(gx^2 + gz^2)).
///
/// ```
/// use plumbline::measure::{I32x3, definition::perpendicular};
///
/// let level = perpendicular(I32x3 { x: 0, y: 0, z: 1000 });
/// assert_eq!((level.x.centidegrees(), level.y.centidegrees()), (0, 0));
/// let nose_down = perpendicular(I32x3 { x: -1000, y: 0, z: 1000 });
/// assert_eq!((nose_down.x.centidegrees(), nose_down.y.centidegrees()), (45_00, 0));
/// ```
#[inline(never)] // measured and budgeted as a function
pub fn perpendicular(up: I32x3) -> Perpendicular {
    let up = normalise(up);
    Perpendicular {
        x: -tilt(up.x, up.y, up.z),
        y: tilt(up.y, up.x, up.z),
    }
}

/// The angle of a 1-axis sensor, a full turn: atan2(ux, uy), 0 with the Y axis up; a right-hand turn about the housing's Z axis
/// counts up.
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

/// The cross slope of a 1-axis sensor, -90..=90 deg: how far its Z axis is above the horizontal, asin(uz) for a unit vector.
pub fn cross_slope(up: I32x3) -> Angle {
    let up = normalise(up);
    tilt(up.z, up.x, up.y)
}

/// `up` shifted left as far as its largest component allows; small vectors would lose the angle in the square root.
fn normalise(up: I32x3) -> I32x3 {
    // x ^ (x >> 31) has a leading zero for each sign bit of x, and unlike the absolute value it exists for every x.
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
    // Half of both sides, because sqrt(2^63) may be more than the 2^31 that the other side has at most.
    let angle = Angle::first_quadrant(along.unsigned_abs() / 2, half_square_root(squares));
    if along < 0 { -angle } else { angle }
}

fn square(value: i32) -> u64 {
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
    // A straight line within 3 % of the root, then one step of Heron's method, which leaves at most 4.5e-4 and is never too
    // small: half of that is taken off.
    let line = ((n >> 16) * 11 / 16 + 22_500) | 1;
    let heron = (line + n / line) / 2;
    let root = (heron - heron / 4096) | 1;
    // The second step squares the error to 3e-8. Its correction has nine bits more than the root; n - root^2 has 23.
    let rest = n.wrapping_sub(root.wrapping_mul(root)) as i32;
    let fine = ((root << 10) as i32).wrapping_add((rest << 9) / root as i32);
    ((fine as u32) << 5).wrapping_shr(shift / 2)
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::f64::consts::TAU;
    use proptest::prelude::*;

    const fn vector(x: i32, y: i32, z: i32) -> I32x3 {
        I32x3 { x, y, z }
    }

    /// The angle in deg, -180..180.
    fn degrees(angle: Angle) -> f64 {
        f64::from(angle.0 as i32) * (360.0 / 4_294_967_296.0)
    }

    /// The definitions in f64, whose own error is below 1e-13 deg: X, Y, rotation, cross slope.
    fn truth(up: I32x3) -> [f64; 4] {
        let (x, y, z) = (f64::from(up.x), f64::from(up.y), f64::from(up.z));
        let (gx, gy, gz) = (-x, y, z);
        [
            gx.atan2(gy.hypot(gz)).to_degrees(),
            gy.atan2(gx.hypot(gz)).to_degrees(),
            x.atan2(y).to_degrees(),
            z.atan2(x.hypot(y)).to_degrees(),
        ]
    }

    /// Holds all angles of `up` to [`ERROR`].
    fn check(up: I32x3) {
        let Perpendicular { x, y } = perpendicular(up);
        let measured = [x, y, rotation(up), cross_slope(up)].map(degrees);
        for (measured, truth) in measured.into_iter().zip(truth(up)) {
            let difference = measured - truth;
            let error = (difference - (difference / 360.0).round() * 360.0).abs();
            assert!(
                error <= degrees(ERROR),
                "{up:?}: {measured} instead of {truth}"
            );
        }
    }

    #[test]
    fn the_stated_error_is_1_5e_5_deg() {
        assert!(degrees(ERROR) <= 1.5e-5);
    }

    #[test]
    fn the_axes_and_diagonals_are_exact() {
        let deg = |x, y| Perpendicular {
            x: Angle::from_centidegrees(x),
            y: Angle::from_centidegrees(y),
        };
        for m in [1, 1000, 1 << 28, i32::MAX] {
            assert_eq!(perpendicular(vector(0, 0, m)), deg(0, 0));
            assert_eq!(perpendicular(vector(0, 0, -m)), deg(0, 0));
            assert_eq!(perpendicular(vector(-m, 0, 0)), deg(90_00, 0));
            assert_eq!(perpendicular(vector(m, 0, 0)), deg(-90_00, 0));
            assert_eq!(perpendicular(vector(0, m, 0)), deg(0, 90_00));
            assert_eq!(perpendicular(vector(0, -m, 0)), deg(0, -90_00));
            assert_eq!(rotation(vector(0, m, 0)), Angle::ZERO);
            assert_eq!(rotation(vector(m, 0, 0)), Angle::QUARTER);
            assert_eq!(rotation(vector(0, -m, 0)), Angle::HALF);
            assert_eq!(rotation(vector(-m, 0, 0)), Angle::THREE_QUARTERS);
            assert_eq!(cross_slope(vector(m, 0, 0)), Angle::ZERO);
            assert_eq!(cross_slope(vector(0, 0, m)), Angle::QUARTER);
            assert_eq!(cross_slope(vector(0, 0, -m)), -Angle::QUARTER);
        }
        assert_eq!(perpendicular(vector(0, 0, 0)), deg(0, 0));
        assert_eq!(rotation(vector(0, 0, 0)), Angle::ZERO);
        assert_eq!(cross_slope(vector(0, 0, 0)), Angle::ZERO);
    }

    #[test]
    fn every_direction_of_the_sphere_keeps_to_the_error() {
        const PARALLELS: u32 = 1500;
        let radius = f64::from(1 << 28);
        for parallel in 0..=PARALLELS {
            // The golden angle between parallels keeps the meridians from lining up.
            let latitude = (f64::from(parallel) / f64::from(PARALLELS) - 0.5) * TAU / 2.0;
            for meridian in 0..1000 {
                let longitude =
                    f64::from(meridian) / 1000.0 * TAU + f64::from(parallel) * 2.399_963;
                check(vector(
                    (radius * latitude.cos() * longitude.cos()) as i32,
                    (radius * latitude.cos() * longitude.sin()) as i32,
                    (radius * latitude.sin()) as i32,
                ));
            }
        }
    }

    #[test]
    fn tilts_close_to_zero_and_to_ninety_degrees_keep_to_the_error() {
        for scale in [1 << 12, 1 << 20, 1 << 28, i32::MAX] {
            for exponent in 0..31 {
                for small in [(1 << exponent) - 1, 1 << exponent, 3 << exponent >> 1] {
                    for other in [0, 1, small] {
                        check(vector(scale, small, other));
                        check(vector(-scale, other, small));
                        check(vector(small, scale, other));
                        check(vector(other, -small, -scale));
                        check(vector(small, other, scale));
                    }
                }
            }
        }
    }

    #[test]
    fn small_vectors_are_exact_directions_too() {
        for x in -20..=20 {
            for y in -20..=20 {
                for z in -20..=20 {
                    check(vector(x, y, z));
                }
            }
        }
    }

    #[test]
    fn the_square_root_keeps_to_its_error() {
        for exponent in 0..=63 {
            for fraction in 0..4096u64 {
                let square = ((1u64 << exponent) + ((fraction << exponent) >> 12)).min(1 << 63);
                let root = (square as f64).sqrt() / 2.0;
                let error = f64::from(half_square_root(square)) - root;
                assert!(
                    error <= root * 6e-8 && error >= -1.0 - root * 6e-8,
                    "{square}"
                );
            }
        }
    }

    proptest! {
        #[test]
        fn random_vectors_keep_to_the_error(x: i32, y: i32, z: i32, shift in 0..24u32, which in 0..4usize) {
            check(vector(x, y, z));
            // One or two components much smaller than the others.
            check(match which {
                0 => vector(x >> shift, y, z),
                1 => vector(x, y >> shift, z),
                2 => vector(x, y, z >> shift),
                _ => vector(x >> shift, y >> shift, z),
            });
        }

        #[test]
        fn turning_about_z_turns_the_angle(step: u16) {
            // A housing that was turned right-handed by t sees the up vector turned by -t.
            let t = f64::from(step) / 65_536.0 * TAU;
            let up = vector((t.sin() * 2e8) as i32, (t.cos() * 2e8) as i32, 0);
            let error = Angle(u32::from(step) << 16) - rotation(up);
            prop_assert!(degrees(error).abs() < 2e-5);
        }
    }
}
