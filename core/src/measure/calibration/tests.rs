//! Tests of the calibration: image, ranges, corrections.

use super::*;
use crate::measure::RANGE;
use proptest::prelude::*;

#[test]
fn calibration_returns_the_numbers_that_it_was_made_of() {
    let numbers = (
        [10, -20, 30],
        [[1, -2, 3], [-4, 5, -6], [7, -8, 9]],
        [4, -5, 6],
    );
    let (offset, deviation, drift) = numbers;
    let calibration = Calibration::new(offset, deviation, drift).unwrap();
    assert_eq!(calibration.numbers(), numbers);
}

const fn vector(x: i32, y: i32, z: i32) -> I32x3 {
    I32x3 { x, y, z }
}

#[test]
fn identity_changes_nothing() {
    for v in [1 - RANGE, -1, 0, 1, 12_345, ONE_G, RANGE - 1] {
        for temperature in [i16::MIN, -4000, 0, 2500, i16::MAX] {
            let a = vector(v, -v, v / 2);
            assert_eq!(Calibration::IDENTITY.apply(a, temperature), a);
        }
    }
}

#[test]
fn image_matches_byte_map() {
    let calibration = Calibration::new(
        [0x0102_0304, -2, 3],
        [[0x0102, 2, 3], [4, 5, 6], [7, 8, -9]],
        [0x0A0B, 11, -12],
    )
    .unwrap();
    let calibration = calibration
        .with_zero_rate([0x0304, -2, 5], [0x0506, 6, -7])
        .unwrap();
    let bytes = [
        4, 3, 2, 1, 0xFE, 0xFF, 0xFF, 0xFF, 3, 0, 0, 0, // offset
        2, 1, 2, 0, 3, 0, 4, 0, 5, 0, 6, 0, 7, 0, 8, 0, 0xF7, 0xFF, // D
        0x0B, 0x0A, 11, 0, 0xF4, 0xFF, // drift
        4, 3, 0xFE, 0xFF, 5, 0, // zero
        6, 5, 6, 0, 0xF9, 0xFF, // zero_drift
        1,    // part
    ];
    let calibration = calibration.of(Part::Adxl355);
    assert_eq!(calibration.encode(), bytes);
    assert_eq!(Calibration::decode(&bytes), Some(calibration));
    assert_eq!(calibration.part(), Part::Adxl355);
    assert_eq!(Calibration::IDENTITY.encode(), [0; SIZE]);
}

#[test]
fn calibration_of_an_unknown_part_is_refused() {
    let mut bytes = Calibration::IDENTITY.encode();
    bytes[SIZE - 1] = 2;
    assert_eq!(Calibration::decode(&bytes), None);
}

#[test]
fn number_just_outside_its_range_is_refused() {
    // The position of each number in the image, its limit and its size.
    let offsets = (0..3).map(|i| (4 * i, 67_108_864i32, 4));
    let deviations = (0..9).map(|i| (12 + 2 * i, 26_214, 2));
    let drifts = (0..3).map(|i| (30 + 2 * i, 16_777, 2));
    let zeros = (0..3).map(|i| (36 + 2 * i, 30_720, 2));
    let zero_drifts = (0..3).map(|i| (42 + 2 * i, 31_457, 2));
    let numbers = offsets.chain(deviations).chain(drifts);
    for (at, limit, width) in numbers.chain(zeros).chain(zero_drifts) {
        let with = |value: i32| {
            let mut bytes = [0; SIZE];
            bytes[at..at + width].copy_from_slice(&value.to_le_bytes()[..width]);
            Calibration::decode(&bytes)
        };
        assert!(with(limit).is_some() && with(-limit).is_some(), "byte {at}");
        assert!(
            with(limit + 1).is_none() && with(-limit - 1).is_none(),
            "byte {at}"
        );
    }
    let mut bytes = [0xFF; SIZE];
    bytes[SIZE - 1] = 0;
    assert_eq!(Calibration::decode(&bytes).map(|c| c.offset), Some([-1; 3]));
}

#[test]
fn offset_gain_cross_axis_and_drift_are_corrected() {
    // 10 mg, gain +1 %, 0.01 of y onto x, 0.1 mg/K
    let (mg, percent, drift) = (ONE_G / 1000, 2621, 1678);
    let c = Calibration::new(
        [OFFSET_ONE_G / 100, 0, 0],
        [[percent, percent, 0], [0; 3], [0; 3]],
        [drift, 0, 0],
    )
    .unwrap();
    let near = |value: i32, mg_expected: f64| {
        let g = f64::from(value) / f64::from(ONE_G) * 1000.0;
        assert!((g - mg_expected).abs() < 0.01, "{g} mg");
    };
    near(c.apply(vector(510 * mg, 0, 0), 2500).x, 505.0);
    near(c.apply(vector(510 * mg, 1000 * mg, 0), 2500).x, 515.0);
    // 30 K warmer: 3 mg of drift; 65 K colder: -6.5 mg
    near(c.apply(vector(513 * mg, 0, 0), 5500).x, 505.0);
    near(
        c.apply(vector(510 * mg - 6 * mg - mg / 2, 0, 0), -4000).x,
        505.0,
    );
    assert_eq!(c.apply(vector(0, 7, -7), 2500).y, 7);
}

#[test]
fn zero_rate_and_its_drift_are_corrected() {
    // 0.5 deg/s, 0.01 deg/s/K
    let c = Calibration::IDENTITY
        .with_zero_rate([2048, -2048, 0], [10_486, 0, -10_486])
        .unwrap();
    let near = |value: i32, expected: f64| {
        let rate = f64::from(value) / 65_536.0;
        assert!((rate - expected).abs() < 1e-4, "{rate} deg/s");
    };
    for (temperature, [x, y, z]) in [
        (25_00, [1.5, 2.5, 2.0]),
        (55_00, [1.2, 2.5, 2.3]),
        (-40_00, [2.15, 2.5, 1.35]),
    ] {
        let rate = c.apply_to_rate(vector(2 << 16, 2 << 16, 2 << 16), temperature);
        near(rate.x, x);
        near(rate.y, y);
        near(rate.z, z);
    }
    let ends = vector(i32::MIN, i32::MAX, i32::MIN);
    let rate = c.apply_to_rate(ends, 25_00);
    assert_eq!((rate.x, rate.y), (i32::MIN, i32::MAX));
}

#[test]
fn result_saturates_at_8_g() {
    let c = Calibration::new([-OFFSET_LIMIT; 3], [[DEVIATION_LIMIT; 3]; 3], [0; 3]).unwrap();
    let end = RANGE;
    assert_eq!(
        c.apply(vector(i32::MAX, i32::MAX, i32::MAX), 2500),
        vector(end - 1, end - 1, end - 1)
    );
    let c = Calibration::new([OFFSET_LIMIT; 3], [[DEVIATION_LIMIT; 3]; 3], [0; 3]).unwrap();
    assert_eq!(
        c.apply(vector(i32::MIN, i32::MIN, i32::MIN), 2500),
        vector(-end, -end, -end)
    );
}

#[test]
fn six_position_measurement_gives_calibration() {
    // A device with errors, the formulas of the module documentation, then the corrected readings.
    let gain = [
        [1.02, 0.01, -0.005],
        [-0.02, 0.97, 0.015],
        [0.01, -0.01, 1.05],
    ];
    let bias = [0.03, -0.05, 0.08];
    let raw = |u: [f64; 3]| -> [f64; 3] {
        core::array::from_fn(|i| (0..3).map(|j| gain[i][j] * u[j]).sum::<f64>() + bias[i])
    };
    let side =
        |axis: usize, sign: f64| raw(core::array::from_fn(|i| if i == axis { sign } else { 0.0 }));
    let mut offset = [0.0; 3];
    let mut s = [[0.0; 3]; 3];
    for axis in 0..3 {
        let (p, n) = (side(axis, 1.0), side(axis, -1.0));
        for (i, (offset, row)) in offset.iter_mut().zip(&mut s).enumerate() {
            *offset += (p[i] + n[i]) / 6.0;
            row[axis] = (p[i] - n[i]) / 2.0;
        }
    }
    // The inverse by Cramer's rule.
    let minor = |i: usize, j: usize| {
        let (a, b, c, d) = ((i + 1) % 3, (i + 2) % 3, (j + 1) % 3, (j + 2) % 3);
        s[a][c] * s[b][d] - s[a][d] * s[b][c]
    };
    let determinant: f64 = (0..3).map(|j| s[0][j] * minor(0, j)).sum();
    let deviation = core::array::from_fn(|i| {
        core::array::from_fn(|j| {
            let identity = if i == j { 1.0 } else { 0.0 };
            ((minor(j, i) / determinant - identity) * 262_144.0).round() as i16
        })
    });
    let fixed = |v: f64| (v * f64::from(ONE_G)).round() as i32;
    let offset = offset.map(|v| (v * f64::from(OFFSET_ONE_G)).round() as i32);
    let c = Calibration::new(offset, deviation, [0; 3]).unwrap();
    for u in [[0.0, 0.0, 1.0], [0.6, -0.8, 0.0], [0.36, 0.48, -0.8]] {
        let [x, y, z] = raw(u).map(fixed);
        let corrected = c.apply(vector(x, y, z), 2500);
        for (got, want) in [corrected.x, corrected.y, corrected.z].into_iter().zip(u) {
            // Three coefficients, each rounded to 2^-18.
            assert!((f64::from(got) / f64::from(ONE_G) - want).abs() < 6e-6);
        }
    }
}

fn calibrations() -> impl Strategy<Value = Calibration> {
    let offset = -OFFSET_LIMIT..=OFFSET_LIMIT;
    let deviation = -DEVIATION_LIMIT..=DEVIATION_LIMIT;
    let drift = -DRIFT_LIMIT..=DRIFT_LIMIT;
    (
        prop::array::uniform3(offset),
        prop::array::uniform3(prop::array::uniform3(deviation)),
        prop::array::uniform3(drift),
        prop::array::uniform3(-ZERO_LIMIT..=ZERO_LIMIT),
        prop::array::uniform3(-ZERO_DRIFT_LIMIT..=ZERO_DRIFT_LIMIT),
    )
        .prop_map(|(o, d, t, zero, zero_drift)| {
            let calibration = Calibration::new(o, d, t).unwrap();
            calibration.with_zero_rate(zero, zero_drift).unwrap()
        })
}

proptest! {
    #[test]
    fn calibration_is_unchanged_after_encode_and_decode(c in calibrations()) {
        prop_assert_eq!(Calibration::decode(&c.encode()), Some(c));
    }

    #[test]
    fn result_is_rounded_formula(c in calibrations(), a: [i32; 3], temperature: i16) {
        let got = c.apply(vector(a[0], a[1], a[2]), temperature);
        let end = f64::from(RANGE);
        let kelvin = f64::from(temperature.clamp(-5500, 12500)) / 100.0 - 25.0;
        let d: [f64; 3] = core::array::from_fn(|i| {
            f64::from(a[i]).clamp(-end, end - 1.0) - f64::from(c.offset[i]) / 4.0 - f64::from(c.drift[i]) * 4.0 * kelvin
        });
        for (i, got) in [got.x, got.y, got.z].into_iter().enumerate() {
            let sum: f64 = (0..3).map(|j| f64::from(c.deviation[i][j]) / 262_144.0 * d[j]).sum();
            // Half a unit for each of two roundings; the matrix scales the first one.
            prop_assert!((f64::from(got) - (d[i] + sum).clamp(-end, end - 1.0)).abs() <= 1.2);
        }
    }
}
