//! Tests of the teach-in, compared with the definition of the manual in f64.

use super::*;
use crate::angle::Angle;
use crate::measure::ONE_G;
use crate::measure::definition::{euler, gimbal_x, perpendicular};
use crate::sweep::every;
use proptest::prelude::*;

const G: f64 = ONE_G as f64;

fn fixed(v: [f64; 3]) -> I32x3 {
    let [x, y, z] = v.map(|component| (component * G).round() as i32);
    I32x3 { x, y, z }
}

fn float(v: I32x3) -> [f64; 3] {
    v.to_array().map(f64::from)
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a.into_iter().zip(b).map(|(a, b)| a * b).sum()
}

fn unit(v: [f64; 3]) -> [f64; 3] {
    let length = dot(v, v).sqrt();
    v.map(|component| component / length)
}

fn cross([ax, ay, az]: [f64; 3], [bx, by, bz]: [f64; 3]) -> [f64; 3] {
    [ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx]
}

/// The rows Xb, Yb, Zb of the definition of the manual for any vertical vector.
fn rows(vertical: [f64; 3]) -> [[f64; 3]; 3] {
    let z = unit(vertical);
    let [zx, zy, zz] = z;
    let x = unit([1.0 - zx * zx, -zx * zy, -zx * zz]);
    [x, cross(z, x), z]
}

/// `v` in the reference frame of `reference`, by definition.
fn exact(reference: I32x3, v: I32x3) -> [f64; 3] {
    rows(float(reference)).map(|row| dot(row, float(v)))
}

/// The angle in deg, -180..180.
fn degrees(angle: Angle) -> f64 {
    f64::from(angle.0 as i32) * (360.0 / 4_294_967_296.0)
}

fn perpendicular_of([x, y, z]: [f64; 3]) -> [f64; 2] {
    [(-x).atan2(y.hypot(z)), y.atan2(x.hypot(z))].map(f64::to_degrees)
}

/// Teaches `reference` and checks the perpendicular angles of `v` against the stated error. Returns false if the teach-in is
/// refused.
fn check(reference: I32x3, v: I32x3) -> bool {
    let Some(teach) = ReferenceFrame::new(reference) else {
        return false;
    };
    let measured = perpendicular(teach.apply(v));
    let truth = perpendicular_of(exact(reference, v));
    for (measured, truth) in [measured.x, measured.y].into_iter().zip(truth) {
        let error = (degrees(measured) - truth).abs();
        assert!(error <= 3e-5, "{reference:?} {v:?}: {error:e} deg");
    }
    true
}

/// Directions over the complete sphere, of 1 g.
fn directions(count: u32) -> impl Iterator<Item = I32x3> {
    (0..count).map(move |i| {
        let z = 1.0 - (f64::from(i) + 0.5) / f64::from(count) * 2.0;
        let (sine, cosine) = (f64::from(i) * 2.399_963_229_7).sin_cos();
        let radius = (1.0 - z * z).sqrt();
        fixed([radius * cosine, radius * sine, z])
    })
}

#[test]
fn angles_after_teach_in_are_within_stated_error() {
    let mut taught = 0;
    let mut all = 0;
    for reference in directions(1000).step_by(every(10)) {
        for v in directions(300) {
            taught += u32::from(check(reference, v));
            all += 1;
        }
    }
    // Two caps of 5 deg are 0.4 % of the sphere.
    assert!(taught * 100 >= all * 98, "{taught} of {all}");
}

#[test]
fn matrix_matches_definition() {
    for reference in directions(5000) {
        let Some(teach) = ReferenceFrame::new(reference) else {
            continue;
        };
        // The columns are the images of the axes of the sensor.
        let columns = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]
            .map(|axis| float(teach.apply(fixed(axis))));
        for (row, exact) in rows(float(reference)).into_iter().enumerate() {
            for (column, exact) in columns.iter().zip(exact) {
                let error = column[row] / G - exact;
                assert!(error.abs() < 1e-7, "{reference:?}: {error:e}");
            }
        }
    }
}

#[test]
fn reference_after_teach_in_is_level() {
    for reference in directions(20_000) {
        let Some(teach) = ReferenceFrame::new(reference) else {
            continue;
        };
        let I32x3 { x, y, z } = teach.apply(reference);
        assert!(x.abs() <= 16 && y.abs() <= 16, "{reference:?}: {x} {y}");
        assert!((z - ONE_G).abs() <= 32, "{reference:?}: {z}");
    }
}

/// The angles of the manual are those of g = (-ux, uy, uz). Teaching g by the definition and then calculating the angles is the
/// same as teaching u.
#[test]
fn teach_in_with_gravity_vector_gives_same_angles() {
    let mirrored = |[x, y, z]: [f64; 3]| [-x, y, z];
    for reference in directions(200) {
        for v in directions(50) {
            let by_up = exact(reference, v);
            let by_gravity =
                rows(mirrored(float(reference))).map(|row| dot(row, mirrored(float(v))));
            for (a, b) in by_up.into_iter().zip(mirrored(by_gravity)) {
                assert!((a - b).abs() < 1e-5);
            }
        }
    }
}

/// JN2101 manual 9.5: a sensor that is mounted at an angle, and a workpiece that is rotated by 30 deg about its Y axis. The
/// printed "without teach" angles are not consistent (they are 34.55 deg apart). With the rotation of the text, they are
/// -13.2/-29.3 before and -43.20/-21.50 after.
#[test]
fn example_of_manual_text_gives_its_angles() {
    // The components of the up vector are the sines of the perpendicular angles.
    let up = |x: f64, y: f64| {
        let (x, y) = (-x.to_radians().sin(), y.to_radians().sin());
        fixed([x, y, (1.0 - x * x - y * y).sqrt()])
    };
    let teach = ReferenceFrame::new(up(-13.2, -29.3)).unwrap();
    let level = perpendicular(teach.apply(up(-13.2, -29.3)));
    assert_eq!((level.x.centidegrees(), level.y.centidegrees()), (0, 0));
    let turned = perpendicular(teach.apply(up(-43.20, -21.50)));
    // The angles are given in 0.01 deg.
    assert!((degrees(turned.x) + 30.0).abs() < 0.02);
    assert!(degrees(turned.y).abs() < 0.02);
}

#[test]
fn x_axis_within_5_degrees_of_vertical_is_refused() {
    for sign in [1.0, -1.0] {
        for turn in 0..360 {
            let (sine, cosine) = f64::from(turn).to_radians().sin_cos();
            let tilted = |degrees: f64| {
                let (s, c) = degrees.to_radians().sin_cos();
                ReferenceFrame::new(fixed([sign * c, s * sine, s * cosine]))
            };
            assert_eq!(tilted(0.0), None);
            assert_eq!(tilted(4.9999), None);
            assert!(tilted(5.0001).is_some());
        }
    }
    assert_eq!(ReferenceFrame::new(I32x3 { x: 0, y: 0, z: 0 }), None);
    assert_eq!(
        f64::from(LEAST_COSINE),
        (5f64.to_radians().sin() * 2f64.powi(30)).round()
    );
}

#[test]
fn length_of_reference_has_no_effect() {
    let teach = |x, y, z| ReferenceFrame::new(I32x3 { x, y, z }).unwrap();
    assert_eq!(teach(1, 2, 3), teach(1 << 28, 2 << 28, 3 << 28));
    assert_eq!(teach(0, 0, 1), ReferenceFrame::IDENTITY);
    assert_eq!(teach(0, 0, i32::MAX), ReferenceFrame::IDENTITY);
    assert_eq!(teach(0, 0, i32::MIN), teach(0, 0, -1));
}

#[test]
fn sensor_upside_down_is_rotated_about_x_axis() {
    let teach = ReferenceFrame::new(I32x3 {
        x: 0,
        y: 0,
        z: -ONE_G,
    })
    .unwrap();
    let v = I32x3 {
        x: 1,
        y: 2,
        z: -ONE_G,
    };
    assert_eq!(
        teach.apply(v),
        I32x3 {
            x: 1,
            y: -2,
            z: ONE_G
        }
    );
}

#[test]
fn default_changes_nothing() {
    let teach = ReferenceFrame::default();
    for v in directions(1000) {
        assert_eq!(teach.apply(v), v);
    }
    let out_of_range = I32x3 {
        x: i32::MIN,
        y: i32::MAX,
        z: 0,
    };
    let held = I32x3 {
        x: -2 * RANGE,
        y: 2 * RANGE,
        z: 0,
    };
    assert_eq!(teach.apply(out_of_range), held);
}

#[test]
fn gimbal_and_euler_angles_use_reference_frame() {
    // The sensor is mounted with a roll of 20 deg, and the machine pitches by 30 deg.
    let (roll, pitch) = (20f64.to_radians(), 30f64.to_radians());
    let teach = ReferenceFrame::new(fixed([0.0, roll.sin(), roll.cos()])).unwrap();
    let machine = [-pitch.sin(), 0.0, pitch.cos()];
    let sensor = fixed([machine[0], machine[2] * roll.sin(), machine[2] * roll.cos()]);
    let up = teach.apply(sensor);
    assert!((degrees(gimbal_x(up).x) - 30.0).abs() < 3e-5);
    assert!(degrees(gimbal_x(up).y).abs() < 3e-5);
    assert!((degrees(euler(up).slope) - 30.0).abs() < 3e-5);
    assert!((degrees(euler(up).direction) - 90.0).abs() < 6e-5);
}

#[test]
fn quotient_is_rounded_to_nearest() {
    for (part, whole, q30) in [
        (1, 3, 357_913_941), // 357913941.33
        (2, 3, 715_827_883), // 715827882.67
        (-2, 3, -715_827_883),
        (1, 7, 153_391_689), // 153391689.14
        (6, 7, 920_350_135), // 920350134.86
        (3, 3, ONE),
        (-3, 3, -ONE),
    ] {
        assert_eq!(quotient(part, whole), q30, "{part} / {whole}");
    }
}

#[test]
fn image_matches_byte_map() {
    let quarter = [
        0, 0, 0, 0x40, 0, 0, 0, 0, // a roll of 90 deg
        0, 0, 0, 0, 0, 0, 0, 0x40, // no pitch
    ];
    let teach = ReferenceFrame::new(I32x3 { x: 0, y: 5, z: 0 }).unwrap();
    assert_eq!(teach.encode(), quarter);
    assert_eq!(ReferenceFrame::decode(&quarter), Some(teach));
    let mut pitched = ReferenceFrame::IDENTITY.encode();
    pitched[8..].copy_from_slice(&[0x9A, 0x99, 0x99, 0xD9, 0x33, 0x33, 0x33, 0x33]);
    let Turn { sine, cosine } = ReferenceFrame::decode(&pitched).unwrap().pitch;
    let q30 = 2f64.powi(30);
    assert!((f64::from(sine) / q30 + 0.6).abs() < 1e-9);
    assert!((f64::from(cosine) / q30 - 0.8).abs() < 1e-9);
}

#[test]
fn image_without_valid_frame_is_refused() {
    let image = |values: [i32; 4]| {
        let mut bytes = [0; SIZE];
        for (place, value) in bytes.chunks_exact_mut(4).zip(values) {
            place.copy_from_slice(&value.to_le_bytes());
        }
        ReferenceFrame::decode(&bytes)
    };
    assert!(image([0, ONE, 0, ONE]).is_some());
    assert!(image([0, -ONE, 0, ONE]).is_some());
    assert_eq!(ReferenceFrame::decode(&[0xFF; SIZE]), None);
    assert_eq!(ReferenceFrame::decode(&[0; SIZE]), None);
    assert_eq!(image([i32::MIN; 4]), None);
    assert_eq!(image([0, ONE, 0, -ONE]), None);
    assert_eq!(image([0, ONE, ONE, 0]), None);
    // An error of 2^-22 in the length is 2^-21 in the square.
    assert!(image([0, ONE + 255, 0, ONE]).is_some());
    assert!(image([0, ONE - 255, 0, ONE]).is_some());
    assert_eq!(image([0, ONE + 257, 0, ONE]), None);
    assert_eq!(image([0, ONE, 0, ONE - 257]), None);
    let cosine = LEAST_COSINE;
    let sine = (2f64.powi(60) - f64::from(cosine).powi(2)).sqrt() as i32;
    assert!(image([0, ONE, sine, cosine]).is_some());
    assert_eq!(image([0, ONE, sine, cosine - 1]), None);
}

/// The worst case that `decode` accepts: rotations at the limits of the tolerance.
#[test]
fn frames_at_limits_of_tolerance_are_within_error() {
    let exact = fixed([0.6, 0.48, 0.64]);
    let taught = ReferenceFrame::new(exact).unwrap();
    let longer = |value: i32, by: f64| (f64::from(value) * (1.0 + by)).round() as i32;
    for (roll, pitch) in [(2.3e-7, -2.3e-7), (-2.3e-7, 2.3e-7)] {
        let mut bytes = taught.encode();
        let values = [
            longer(taught.roll.sine, roll),
            longer(taught.roll.cosine, roll),
            longer(taught.pitch.sine, pitch),
            longer(taught.pitch.cosine, pitch),
        ];
        for (place, value) in bytes.chunks_exact_mut(4).zip(values) {
            place.copy_from_slice(&value.to_le_bytes());
        }
        let stored = ReferenceFrame::decode(&bytes).unwrap();
        for v in directions(5000) {
            let measured = perpendicular(stored.apply(v));
            let truth = perpendicular_of(self::exact(exact, v));
            assert!((degrees(measured.x) - truth[0]).abs() <= 3e-5);
            assert!((degrees(measured.y) - truth[1]).abs() <= 3e-5);
        }
    }
}

proptest! {
    #[test]
    fn any_pair_of_vectors_is_within_error(
        reference: [i32; 3],
        shift in 0..24u32,
        v in prop::array::uniform3(-2 * RANGE..=2 * RANGE),
    ) {
        let [x, y, z] = reference;
        let [vx, vy, vz] = v;
        let v = I32x3 { x: vx, y: vy, z: vz };
        prop_assume!(float(v).iter().map(|c| c * c).sum::<f64>().sqrt() >= G / 2.0);
        check(I32x3 { x, y, z }, v);
        check(I32x3 { x: x >> shift, y, z: z >> shift }, v);
        check(I32x3 { x: x >> shift, y: y >> shift, z: z >> shift }, v);
    }

    #[test]
    fn teach_is_unchanged_after_encode_and_decode(x: i32, y: i32, z: i32, shift in 0..31u32) {
        for up in [I32x3 { x, y, z }, I32x3 { x: x >> shift, y: y >> shift, z: z >> shift }] {
            if let Some(teach) = ReferenceFrame::new(up) {
                prop_assert_eq!(ReferenceFrame::decode(&teach.encode()), Some(teach));
            }
        }
    }
}
