//! Tests of the angle definitions: all directions compared with the formulas in f64, the table of the JN2101 manual, and the
//! vectors that do not determine an angle.

use super::*;
use crate::measure::ONE_G;
use crate::sweep::every;
use core::f64::consts::TAU;
use proptest::prelude::*;

const fn vector(x: i32, y: i32, z: i32) -> I32x3 {
    I32x3 { x, y, z }
}

/// The angle in deg, -180..180.
fn degrees(angle: Angle) -> f64 {
    f64::from(angle.0 as i32) * (360.0 / 4_294_967_296.0)
}

/// The definitions in f64 in the order of [`measured`]. The error of f64 is below 1e-13 deg.
fn truth(up: I32x3) -> [f64; 10] {
    let (x, y, z) = (f64::from(up.x), f64::from(up.y), f64::from(up.z));
    let (gx, gy, gz) = (-x, y, z);
    [
        gx.atan2(gy.hypot(gz)).to_degrees(),
        gy.atan2(gx.hypot(gz)).to_degrees(),
        x.atan2(y).to_degrees(),
        z.atan2(x.hypot(y)).to_degrees(),
        gx.hypot(gy).atan2(gz).to_degrees(),
        // Zeros in f64 have signs, which would change the direction if there is no slope.
        if x == 0.0 && y == 0.0 {
            0.0
        } else {
            gx.atan2(-gy).to_degrees()
        },
        gx.atan2(gy.hypot(gz)).to_degrees(),
        gy.atan2(gz).to_degrees(),
        if x == 0.0 && z == 0.0 {
            0.0
        } else {
            gx.atan2(gz).to_degrees()
        },
        gy.atan2(gx.hypot(gz)).to_degrees(),
    ]
}

/// X, Y, rotation, cross slope, slope, direction, X and Y of gimbal X, X and Y of gimbal Y.
fn measured(up: I32x3) -> [Angle; 10] {
    let Perpendicular { x, y } = perpendicular(up);
    let Euler { slope, direction } = euler(up);
    let (by_x, by_y) = (gimbal_x(up), gimbal_y(up));
    let (rotation, cross_slope) = (rotation(up), cross_slope(up));
    [
        x,
        y,
        rotation,
        cross_slope,
        slope,
        direction,
        by_x.x,
        by_x.y,
        by_y.x,
        by_y.y,
    ]
}

/// Checks all angles of `up` against [`ERROR`].
fn check(up: I32x3) {
    for (measured, truth) in measured(up).map(degrees).into_iter().zip(truth(up)) {
        let difference = measured - truth;
        let error = (difference - (difference / 360.0).round() * 360.0).abs();
        assert!(
            error <= degrees(ERROR),
            "{up:?}: {measured} instead of {truth}"
        );
    }
}

#[test]
fn stated_error_is_1_5e_5_deg() {
    assert!(degrees(ERROR) <= 1.5e-5);
}

#[test]
fn angles_on_axes_and_diagonals_are_exact() {
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
fn all_definitions_on_axes_and_diagonals_are_exact() {
    let deg = Angle::from_centidegrees;
    let euler_of = |slope, direction| Euler {
        slope: deg(slope),
        direction: deg(direction),
    };
    let gimbal = |x, y| Gimbal {
        x: deg(x),
        y: deg(y),
    };
    for m in [1, 1000, 1 << 28, i32::MAX] {
        assert_eq!(euler(vector(0, 0, m)), euler_of(0, 0));
        assert_eq!(euler(vector(0, 0, -m)), euler_of(18_000, 0));
        assert_eq!(euler(vector(0, -m, 0)), euler_of(90_00, 0));
        assert_eq!(euler(vector(-m, 0, 0)), euler_of(90_00, 90_00));
        assert_eq!(euler(vector(0, m, 0)), euler_of(90_00, 18_000));
        assert_eq!(euler(vector(m, 0, 0)), euler_of(90_00, 27_000));
        assert_eq!(euler(vector(m, m, 0)), euler_of(90_00, 22_500));
        assert_eq!(gimbal_x(vector(-m, 0, m)).y, Angle::ZERO);
        assert_eq!(gimbal_x(vector(0, m, m)), gimbal(0, 45_00));
        assert_eq!(gimbal_x(vector(0, m, -m)), gimbal(0, 13_500));
        assert_eq!(gimbal_x(vector(0, -m, -m)), gimbal(0, -13_500));
        assert_eq!(gimbal_y(vector(-m, 0, m)), gimbal(45_00, 0));
        assert_eq!(gimbal_y(vector(-m, 0, -m)), gimbal(13_500, 0));
        assert_eq!(gimbal_y(vector(0, m, m)).x, Angle::ZERO);
    }
    // The smallest integer has no opposite.
    let m = i32::MIN;
    assert_eq!(euler(vector(m, m, 0)), euler_of(90_00, 45_00));
    assert_eq!(gimbal_x(vector(m, 0, 0)), gimbal(90_00, 0));
    assert_eq!(gimbal_y(vector(m, 0, m)), gimbal(13_500, 0));
}

#[test]
fn undetermined_angle_is_zero() {
    for m in [1, 1000, 1 << 28, i32::MAX] {
        assert_eq!(euler(vector(0, 0, m)).direction, Angle::ZERO);
        assert_eq!(euler(vector(0, 0, -m)).direction, Angle::ZERO);
        assert_eq!(gimbal_x(vector(m, 0, 0)).y, Angle::ZERO);
        assert_eq!(gimbal_x(vector(-m, 0, 0)).y, Angle::ZERO);
        assert_eq!(gimbal_y(vector(0, m, 0)).x, Angle::ZERO);
        assert_eq!(gimbal_y(vector(0, -m, 0)).x, Angle::ZERO);
    }
    assert_eq!(measured(vector(0, 0, 0)), [Angle::ZERO; 10]);
}

/// JN2101 manual 8.5: an excavator whose Y axis points forward drives on a slope of 30 deg and turns. The angles are printed in
/// integer degrees, truncated towards zero. In the level position the direction is "undefined"; positions 4 and 5 are equal.
#[test]
fn excavator_example_of_manual_gives_its_angles() {
    // Slope and direction, then X and Y of perpendicular, gimbal X and gimbal Y.
    let table = [
        (0.0, 0.0, [0, 0], [0, 0], [0, 0]),
        (30.0, 0.0, [0, -30], [0, -30], [0, -30]),
        (30.0, 45.0, [20, -20], [20, -22], [22, -20]),
        (30.0, 90.0, [30, 0], [30, 0], [30, 0]),
        (30.0, 180.0, [0, 30], [0, 30], [0, 30]),
    ];
    for (slope, direction, perpendicular_angles, by_x, by_y) in table {
        let (s, d): (f64, f64) = (f64::to_radians(slope), f64::to_radians(direction));
        let g = [s.sin() * d.sin(), -s.sin() * d.cos(), s.cos()];
        let [gx, gy, gz] = g.map(|v| (v * f64::from(ONE_G)).round() as i32);
        let up = vector(-gx, gy, gz);
        let near = |angle: Angle, truth: f64| (degrees(angle) - truth).abs() < 2e-5;
        assert!(near(euler(up).slope, slope));
        if slope > 0.0 {
            let turned = euler(up).direction - Angle::from_centidegrees((direction * 100.0) as i32);
            assert!(near(turned, 0.0));
        }
        // Integer degrees, truncated; 30 deg can become 29.99999.
        let whole = |angle: Angle| (f64::from(angle.millidegrees()) / 1000.0).trunc() as i32;
        let p = perpendicular(up);
        assert_eq!([whole(p.x), whole(p.y)], perpendicular_angles);
        let x = gimbal_x(up);
        assert_eq!([whole(x.x), whole(x.y)], by_x);
        let y = gimbal_y(up);
        assert_eq!([whole(y.x), whole(y.y)], by_y);
    }
}

/// The rotations of the manual as matrices: about one axis of the level housing, then about the other axis of the rotated one
/// (8.3 and 8.4). The vertical in the coordinate frame of the housing then has exactly these angles.
#[test]
fn gimbal_angles_match_rotations_of_manual() {
    for long in (-85..=85).step_by(5) {
        for lateral in (-85..=85).step_by(5) {
            let (p, q): (f64, f64) = (
                f64::from(long).to_radians(),
                f64::from(lateral).to_radians(),
            );
            let fixed = |v: [f64; 3]| {
                let [x, y, z] = v.map(|v| (v * f64::from(ONE_G)).round() as i32);
                vector(x, y, z)
            };
            // The up vector in a housing rotated about Y by p, then about its own X by q; and in the other order.
            let first_y = fixed([-p.sin(), p.cos() * q.sin(), p.cos() * q.cos()]);
            let first_x = fixed([-p.sin() * q.cos(), q.sin(), p.cos() * q.cos()]);
            for (angles, order) in [(gimbal_x(first_y), "X"), (gimbal_y(first_x), "Y")] {
                let (x, y) = (degrees(angles.x), degrees(angles.y));
                let error = (x - f64::from(long))
                    .abs()
                    .max((y - f64::from(lateral)).abs());
                // The vector is rounded to 2^-26, and at 85 deg this error is eleven times larger.
                assert!(error < 2e-5, "gimbal {order} {long} {lateral}: {x} {y}");
            }
        }
    }
}

#[test]
fn all_directions_of_sphere_are_within_error() {
    const PARALLELS: u32 = 1500;
    let radius = f64::from(ONE_G);
    for parallel in (0..=PARALLELS).step_by(every(12)) {
        // The golden angle between parallels avoids points on common meridians.
        let latitude = (f64::from(parallel) / f64::from(PARALLELS) - 0.5) * TAU / 2.0;
        for meridian in 0..1000 {
            let longitude = f64::from(meridian) / 1000.0 * TAU + f64::from(parallel) * 2.399_963;
            check(vector(
                (radius * latitude.cos() * longitude.cos()) as i32,
                (radius * latitude.cos() * longitude.sin()) as i32,
                (radius * latitude.sin()) as i32,
            ));
        }
    }
}

#[test]
fn tilts_close_to_0_and_90_degrees_are_within_error() {
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
fn small_vectors_are_within_error() {
    for x in -20..=20 {
        for y in -20..=20 {
            for z in -20..=20 {
                check(vector(x, y, z));
            }
        }
    }
}

#[test]
fn square_root_is_within_its_error() {
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
    fn random_vectors_are_within_error(x: i32, y: i32, z: i32, shift in 0..24u32, which in 0..4usize) {
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
    fn rotation_about_z_changes_angle_by_same_amount(step: u16) {
        // In a housing with a right-hand rotation by t, the up vector is rotated by -t.
        let t = f64::from(step) / 65_536.0 * TAU;
        let up = vector((t.sin() * 2e8) as i32, (t.cos() * 2e8) as i32, 0);
        let error = Angle(u32::from(step) << 16) - rotation(up);
        prop_assert!(degrees(error).abs() < 2e-5);
    }
}
