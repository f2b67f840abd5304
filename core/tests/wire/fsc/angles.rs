//! The angles of the GEMAC sensors for attitudes of the whole sphere, vibration and motion (manual 9.1, 9.2, 9.5.2 and 9.9.1).

use crate::tester::canopen::in_g;
use crate::tester::fsc::*;
use crate::tester::gemac::*;
use plumbline::fsc::Product;
use plumbline::model::gemac::is1::{self, OneAxis};
use plumbline::model::gemac::is2::{self, TwoAxes};
use std::f64::consts::{PI, TAU};

/// The up vector of a 1-axis sensor at this angle, with this cross slope, in deg (G18).
fn one_axis_up(angle: f64, cross: f64) -> [f64; 3] {
    let ((sa, ca), (sc, cc)) = (angle.to_radians().sin_cos(), cross.to_radians().sin_cos());
    [sa * cc, ca * cc, sc]
}

/// The up vector of a 2-axis sensor with these perpendicular angles in deg (G19).
fn two_axis_up(x: f64, y: f64) -> [f64; 3] {
    let [x, y] = [x, y].map(|angle| angle.to_radians().sin());
    [-x, y, (1.0 - x * x - y * y).sqrt()]
}

/// The angles of an up vector in deg (G18, G19).
fn exact(axes: usize, [x, y, z]: [f64; 3]) -> Vec<f64> {
    if axes == 1 {
        return vec![x.atan2(y).to_degrees()];
    }
    let gx = -x;
    vec![
        gx.atan2(y.hypot(z)).to_degrees(),
        y.atan2(gx.hypot(z)).to_degrees(),
    ]
}

/// The angles in a reply in deg: unsigned of 1 axis, signed of 2 axes (9.9.1).
fn angles(reply: &[u8]) -> Vec<f64> {
    let bytes = |at: usize| [reply[at], reply[at + 1]];
    match reply.len() {
        4 => vec![f64::from(u16::from_le_bytes(bytes(2))) / 100.0],
        _ => [2, 4]
            .map(|at| f64::from(i16::from_le_bytes(bytes(at))) / 100.0)
            .to_vec(),
    }
}

/// The difference of two angles on the circle, in deg.
fn difference(one: f64, other: f64) -> f64 {
    ((one - other + 180.0).rem_euclid(360.0) - 180.0).abs()
}

fn polled<P: Product>(tester: &mut FscTester<P>) -> Vec<f64> {
    angles(&tester.ask(&[0x00]))
}

/// The angles after each of these vectors, one sample each.
fn follow<P: Product>(
    tester: &mut FscTester<P>,
    vectors: impl Iterator<Item = [f64; 3]>,
) -> Vec<f64> {
    vectors
        .map(|vector| {
            tester.hold(in_g(vector), 1);
            polled(tester)[0]
        })
        .collect()
}

/// The resolution is 0.01 deg, and the error of the calculation 1.5e-5 deg.
#[test]
fn angles_of_the_whole_sphere_are_within_half_a_digit() {
    fn check<P: Product>(sheet: &'static Sheet) {
        let mut tester = sheet.online::<P>().tester;
        tester.ask(&[0x27, 0xA8, 0x61, 0]);
        // Fibonacci's spiral.
        for n in 0..150 {
            let z = 1.0 - f64::from(2 * n + 1) / 150.0;
            let radius = (1.0 - z * z).sqrt();
            let (sine, cosine) = (PI * (3.0 - 5_f64.sqrt()) * f64::from(n)).sin_cos();
            let up = [radius * cosine, radius * sine, z];
            tester.hold(in_g(up), 300);
            let shown = polled(&mut tester);
            let exact = exact(sheet.axes(), up);
            assert_eq!(shown.len(), exact.len());
            for (shown, exact) in shown.iter().zip(exact) {
                assert!(
                    difference(*shown, exact) < 0.005_02,
                    "{up:?}: {shown} {exact}"
                );
            }
        }
    }
    each_product!(check);
}

#[test]
fn angles_of_one_axis_are_0_to_359_99_degrees() {
    let mut tester = online::<OneAxis>(&is1::BP_CL);
    for (angle, cross, shown) in [
        (10.65, 0.0, 1065),
        (0.0, 0.0, 0),
        (359.99, 0.0, 35_999),
        (359.996, 0.0, 0),
        (180.0, 20.0, 18_000),
        (270.0, -30.0, 27_000),
        (90.0, 44.0, 9000),
    ] {
        tester.hold(in_g(one_axis_up(angle, cross)), 2000);
        let reply = tester.ask(&[0x00]);
        assert_eq!(reply[2..], u16::to_le_bytes(shown), "{angle} {cross}");
    }
}

#[test]
fn angles_of_two_axes_are_signed() {
    let mut tester = online::<TwoAxes>(&is2::BP_CL);
    for (x, y) in [
        (12.34, -5.67),
        (-12.34, 5.67),
        (60.0, 20.0),
        (-80.0, 0.0),
        (0.0, 80.0),
        (0.0, -80.0),
        (-0.01, 0.01),
    ] {
        tester.hold(in_g(two_axis_up(x, y)), 2000);
        assert_eq!(polled(&mut tester), [x, y]);
    }
}

/// SensorError (bit 4), or SensorErrorX and SensorErrorY (bits 4 and 5), while an angle is beyond its limit (G18, G19).
#[test]
fn sensor_errors_are_set_beyond_the_limits() {
    const ONE_AXIS: &[(f64, f64, u8)] = &[
        (0.0, 0.0, 0),
        (123.0, 44.9, 0),
        (123.0, -44.9, 0),
        (0.0, 45.1, 0x10),
        (300.0, -45.1, 0x10),
        (300.0, 70.0, 0x10),
        (90.0, 0.0, 0),
        (180.0, 0.0, 0),
        (270.0, 44.9, 0),
    ];
    const TWO_AXES: &[(f64, f64, u8)] = &[
        (0.0, 0.0, 0),
        (84.9, 0.0, 0),
        (-84.9, 0.0, 0),
        (0.0, 84.9, 0),
        (0.0, -84.9, 0),
        (85.1, 0.0, 0x10),
        (-85.1, 0.0, 0x10),
        (0.0, 85.1, 0x20),
        (0.0, -85.1, 0x20),
        (45.0, 44.0, 0),
    ];
    fn check<P: Product>(sheet: &'static Sheet) {
        let mut tester = sheet.online::<P>().tester;
        tester.ask(&[0x27, 0xA8, 0x61, 0]);
        let poses = [ONE_AXIS, TWO_AXES][sheet.axes() - 1];
        for (first, second, errors) in poses {
            let up = [one_axis_up, two_axis_up][sheet.axes() - 1](*first, *second);
            tester.hold(in_g(up), 300);
            for request in [0x00, 0x02, 0xFF] {
                let status = tester.ask(&[request])[1];
                assert_eq!(status & 0x30, *errors, "{first} {second}");
            }
        }
    }
    each_product!(check);
}

/// The limit of the basic line is 80 deg (table 1).
#[test]
fn limit_of_the_basic_line_is_80_degrees() {
    for article in [&is2::MA_BL, &is2::BP_BL, &is2::SP_BL, &is2::SP_BL_10] {
        let mut tester = online::<TwoAxes>(article);
        for (x, y, errors) in [
            (79.9, 0.0, 0),
            (-80.1, 0.0, 0x10),
            (0.0, -79.9, 0),
            (0.0, 80.1, 0x20),
        ] {
            tester.hold(in_g(two_axis_up(x, y)), 2000);
            assert_eq!(tester.ask(&[0x02])[1] & 0x30, errors, "{x} {y}");
        }
    }
}

/// The measured angle is judged, not the reported one (G24).
#[test]
fn zero_offset_does_not_change_sensor_errors() {
    let mut tester = online::<TwoAxes>(&is2::BP_CL);
    for (measured, offset, reported, errors) in
        [(80.0, 9000, 90.0, 0), (87.0, -8700_i16, 0.0, 0x10)]
    {
        tester.hold(in_g(two_axis_up(measured, 0.0)), 2000);
        let [low, high] = offset.to_le_bytes();
        assert_eq!(tester.ask(&[0x28, low, high])[1] & 0x30, errors);
        assert_eq!(tester.ask(&[0x02])[1] & 0x30, errors);
        assert_eq!(polled(&mut tester), [reported, 0.0]);
    }
}

/// The acceleration is filtered, not the angle: 0.5 g of 20 Hz do not shift an angle of 45 deg.
#[test]
fn vibration_does_not_shift_the_angle() {
    fn check<P: Product>(up: [f64; 3], tester: impl Fn() -> FscTester<P>) {
        for axis in 0..3 {
            let mut tester = tester();
            let vectors = (0..800).map(|n| {
                let mut vector = up;
                vector[axis] += 0.5 * (TAU * 20.0 * 0.005 * f64::from(n)).sin();
                vector
            });
            let settled = &follow(&mut tester, vectors)[500..];
            let mean = settled.iter().sum::<f64>() / settled.len() as f64;
            assert!((mean - 45.0).abs() < 0.01, "axis {axis}: {mean}");
            for angle in settled {
                assert!((angle - 45.0).abs() < 0.0301, "axis {axis}: {angle}");
            }
        }
    }
    check(one_axis_up(45.0, 0.0), is1);
    check(two_axis_up(45.0, 0.0), is2);
}

/// An angle that was filtered as a number would be 180 deg here.
#[test]
fn noise_at_0_degrees_is_averaged_on_the_circle() {
    let mut tester = is1();
    let noise = (0..1400).map(|n| one_axis_up([-0.3, 0.29][n % 2], 0.0));
    for angle in &follow(&mut tester, noise)[200..] {
        assert!(difference(*angle, 0.0) < 0.02, "{angle}");
    }
}

#[test]
fn turn_through_0_degrees_has_no_jump() {
    for offset in [0, 18_000, 35_999_u16] {
        let mut tester = is1();
        tester.hold(in_g(one_axis_up(355.0, 0.0)), 2000);
        let [low, high] = offset.to_le_bytes();
        tester.ask(&[0x28, low, high]);
        // 10 deg/s for 2 s, then at rest.
        let turn = (0..1400).map(|n| one_axis_up(355.0 + 0.05 * f64::from(n.min(400)), 0.0));
        let shown = follow(&mut tester, turn);
        for step in shown.windows(2) {
            assert!(difference(step[1], step[0]) < 0.0701, "{step:?}");
        }
        let end = 15.0 + f64::from(offset) / 100.0;
        assert!(difference(shown[1399], end) < 0.0001, "{}", shown[1399]);
    }
}

/// A zero offset only shifts the angle; the sum is limited to +-90 deg (G7).
#[test]
fn zero_offset_shifts_and_limits_a_moving_angle() {
    let curve = |offset: i16| {
        let mut tester = is2();
        tester.hold(in_g(two_axis_up(-70.0, 0.0)), 2000);
        let [low, high] = offset.to_le_bytes();
        tester.ask(&[0x28, low, high]);
        follow(&mut tester, (0..600).map(|_| two_axis_up(70.0, 0.0)))
    };
    let plain = curve(0);
    assert_eq!(plain[599], 70.0);
    assert!(plain.iter().any(|angle| angle.abs() < 5.0));
    for offset in [4000, -9000] {
        for (shown, plain) in curve(offset).into_iter().zip(&plain) {
            let sum = plain + f64::from(offset) / 100.0;
            assert!(
                (shown - sum.clamp(-90.0, 90.0)).abs() < 1e-9,
                "{shown} {sum}"
            );
        }
    }
}
