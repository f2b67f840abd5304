//! Tests of the teach-in against the manual's definition, in f64.

use super::*;
use crate::angle::Angle;
use crate::measure::definition::{euler, gimbal_x, perpendicular};
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

/// The rows Xb, Yb, Zb of the manual's definition, of any vector that stands for the vertical.
fn rows(vertical: [f64; 3]) -> [[f64; 3]; 3] {
    let z = unit(vertical);
    let [zx, zy, zz] = z;
    let x = unit([1.0 - zx * zx, -zx * zy, -zx * zz]);
    [x, cross(z, x), z]
}

/// `v` in the frame that `reference` teaches, by definition.
fn exact(reference: I32x3, v: I32x3) -> [f64; 3] {
    rows(float(reference)).map(|row| dot(row, float(v)))
}

/// In deg, -180..180.
fn degrees(angle: Angle) -> f64 {
    f64::from(angle.0 as i32) * (360.0 / 4_294_967_296.0)
}

fn perpendicular_of([x, y, z]: [f64; 3]) -> [f64; 2] {
    [(-x).atan2(y.hypot(z)), y.atan2(x.hypot(z))].map(f64::to_degrees)
}

/// Teaches `reference` and holds the perpendicular angles of `v` to the stated error; false when the teach-in is refused.
fn check(reference: I32x3, v: I32x3) -> bool {
    let Some(teach) = Teach::new(reference) else {
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

/// Directions all over the sphere, of 1 g.
fn directions(count: u32) -> impl Iterator<Item = I32x3> {
    (0..count).map(move |i| {
        let z = 1.0 - (f64::from(i) + 0.5) / f64::from(count) * 2.0;
        let (sine, cosine) = (f64::from(i) * 2.399_963_229_7).sin_cos();
        let radius = (1.0 - z * z).sqrt();
        fixed([radius * cosine, radius * sine, z])
    })
}

#[test]
fn angles_after_teach_in_keep_to_the_stated_error() {
    let mut taught = 0;
    for reference in directions(1000) {
        for v in directions(300) {
            taught += u32::from(check(reference, v));
        }
    }
    // Two caps of 5 deg are 0.4 % of the sphere.
    assert!(taught >= 295_000, "{taught}");
}

#[test]
fn the_matrix_is_the_one_of_the_definition() {
    for reference in directions(5000) {
        let Some(teach) = Teach::new(reference) else {
            continue;
        };
        // What the sensor's axes become are the columns.
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
fn the_reference_itself_becomes_level() {
    for reference in directions(20_000) {
        let Some(teach) = Teach::new(reference) else {
            continue;
        };
        let I32x3 { x, y, z } = teach.apply(reference);
        assert!(x.abs() <= 16 && y.abs() <= 16, "{reference:?}: {x} {y}");
        assert!((z - ONE_G).abs() <= 32, "{reference:?}: {z}");
    }
}

/// The manual's angles are of g = (-ux, uy, uz). Teaching g by the definition and then taking the angles is the same as teaching u.
#[test]
fn teaching_the_gravity_vector_of_the_angle_definitions_is_the_same() {
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

/// JN2101 manual 9.5: a sensor that is mounted askew, and a workpiece that is turned by 30 deg about its own Y axis. The printed
/// "without teach" angles do not belong together (they are 34.55 deg apart); with the turn of the text, they are -13.2/-29.3
/// before and -43.20/-21.50 after.
#[test]
fn the_example_of_the_manual_as_its_text_has_it() {
    // The up vector of perpendicular angles: its components are sines.
    let up = |x: f64, y: f64| {
        let (x, y) = (-x.to_radians().sin(), y.to_radians().sin());
        fixed([x, y, (1.0 - x * x - y * y).sqrt()])
    };
    let teach = Teach::new(up(-13.2, -29.3)).unwrap();
    let level = perpendicular(teach.apply(up(-13.2, -29.3)));
    assert_eq!((level.x.centidegrees(), level.y.centidegrees()), (0, 0));
    let turned = perpendicular(teach.apply(up(-43.20, -21.50)));
    // The angles are given in 0.01 deg.
    assert!((degrees(turned.x) + 30.0).abs() < 0.02);
    assert!(degrees(turned.y).abs() < 0.02);
}

#[test]
fn an_upright_x_axis_is_refused_from_5_degrees_on() {
    for sign in [1.0, -1.0] {
        for turn in 0..360 {
            let (sine, cosine) = f64::from(turn).to_radians().sin_cos();
            let tilted = |degrees: f64| {
                let (s, c) = degrees.to_radians().sin_cos();
                Teach::new(fixed([sign * c, s * sine, s * cosine]))
            };
            assert_eq!(tilted(0.0), None);
            assert_eq!(tilted(4.9999), None);
            assert!(tilted(5.0001).is_some());
        }
    }
    assert_eq!(Teach::new(I32x3 { x: 0, y: 0, z: 0 }), None);
    assert_eq!(
        f64::from(LEAST_COSINE),
        (5f64.to_radians().sin() * 2f64.powi(30)).round()
    );
}

#[test]
fn only_the_direction_of_the_reference_counts() {
    let teach = |x, y, z| Teach::new(I32x3 { x, y, z }).unwrap();
    assert_eq!(teach(1, 2, 3), teach(1 << 28, 2 << 28, 3 << 28));
    assert_eq!(teach(0, 0, 1), Teach::IDENTITY);
    assert_eq!(teach(0, 0, i32::MAX), Teach::IDENTITY);
    assert_eq!(teach(0, 0, i32::MIN), teach(0, 0, -1));
}

#[test]
fn a_sensor_upside_down_is_turned_about_its_x_axis() {
    let teach = Teach::new(I32x3 {
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
fn the_default_changes_nothing() {
    let teach = Teach::default();
    for v in directions(1000) {
        assert_eq!(teach.apply(v), v);
    }
    let out_of_range = I32x3 {
        x: i32::MIN,
        y: i32::MAX,
        z: 0,
    };
    let held = I32x3 {
        x: -4 * ONE_G,
        y: 4 * ONE_G,
        z: 0,
    };
    assert_eq!(teach.apply(out_of_range), held);
}

#[test]
fn other_angle_definitions_follow() {
    // The sensor is mounted with a roll of 20 deg, and the machine pitches by 30 deg.
    let (roll, pitch) = (20f64.to_radians(), 30f64.to_radians());
    let teach = Teach::new(fixed([0.0, roll.sin(), roll.cos()])).unwrap();
    let machine = [-pitch.sin(), 0.0, pitch.cos()];
    let sensor = fixed([machine[0], machine[2] * roll.sin(), machine[2] * roll.cos()]);
    let up = teach.apply(sensor);
    assert!((degrees(gimbal_x(up).x) - 30.0).abs() < 3e-5);
    assert!(degrees(gimbal_x(up).y).abs() < 3e-5);
    assert!((degrees(euler(up).slope) - 30.0).abs() < 3e-5);
    assert!((degrees(euler(up).direction) - 90.0).abs() < 6e-5);
}

#[test]
fn the_image_is_laid_out_as_the_byte_map_says() {
    let quarter = [
        0, 0, 0, 0x40, 0, 0, 0, 0, // a roll of 90 deg
        0, 0, 0, 0, 0, 0, 0, 0x40, // no pitch
    ];
    let teach = Teach::new(I32x3 { x: 0, y: 5, z: 0 }).unwrap();
    assert_eq!(teach.encode(), quarter);
    assert_eq!(Teach::decode(&quarter), Some(teach));
    let mut pitched = Teach::IDENTITY.encode();
    pitched[8..].copy_from_slice(&[0x9A, 0x99, 0x99, 0xD9, 0x33, 0x33, 0x33, 0x33]);
    let Turn { sine, cosine } = Teach::decode(&pitched).unwrap().pitch;
    let q30 = 2f64.powi(30);
    assert!((f64::from(sine) / q30 + 0.6).abs() < 1e-9);
    assert!((f64::from(cosine) / q30 - 0.8).abs() < 1e-9);
}

#[test]
fn an_image_that_is_no_frame_is_refused() {
    let image = |values: [i32; 4]| {
        let mut bytes = [0; SIZE];
        for (place, value) in bytes.chunks_exact_mut(4).zip(values) {
            place.copy_from_slice(&value.to_le_bytes());
        }
        Teach::decode(&bytes)
    };
    assert!(image([0, ONE, 0, ONE]).is_some());
    assert!(image([0, -ONE, 0, ONE]).is_some());
    assert_eq!(Teach::decode(&[0xFF; SIZE]), None);
    assert_eq!(Teach::decode(&[0; SIZE]), None);
    assert_eq!(image([i32::MIN; 4]), None);
    assert_eq!(image([0, ONE, 0, -ONE]), None);
    assert_eq!(image([0, ONE, ONE, 0]), None);
    // 2^-22 in the length is 2^-21 in the square.
    assert!(image([0, ONE + 255, 0, ONE]).is_some());
    assert!(image([0, ONE - 255, 0, ONE]).is_some());
    assert_eq!(image([0, ONE + 257, 0, ONE]), None);
    assert_eq!(image([0, ONE, 0, ONE - 257]), None);
    let cosine = LEAST_COSINE;
    let sine = (2f64.powi(60) - f64::from(cosine).powi(2)).sqrt() as i32;
    assert!(image([0, ONE, sine, cosine]).is_some());
    assert_eq!(image([0, ONE, sine, cosine - 1]), None);
}

/// What the store may hand back at worst: turns at the ends of the tolerance.
#[test]
fn frames_at_the_ends_of_the_tolerance_keep_to_the_error_too() {
    let exact = fixed([0.6, 0.48, 0.64]);
    let taught = Teach::new(exact).unwrap();
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
        let stored = Teach::decode(&bytes).unwrap();
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
    fn any_pair_of_vectors_keeps_to_the_error(
        reference: [i32; 3],
        shift in 0..24u32,
        v in prop::array::uniform3(-4 * ONE_G..=4 * ONE_G),
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
    fn what_is_encoded_is_decoded(x: i32, y: i32, z: i32, shift in 0..31u32) {
        for up in [I32x3 { x, y, z }, I32x3 { x: x >> shift, y: y >> shift, z: z >> shift }] {
            if let Some(teach) = Teach::new(up) {
                prop_assert_eq!(Teach::decode(&teach.encode()), Some(teach));
            }
        }
    }
}
