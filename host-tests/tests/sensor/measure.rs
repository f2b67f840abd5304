//! The measurement path of the core against reference vectors that were computed independently (`vectors/generate.py`).

use plumbline::angle::Angle;
use plumbline::measure::calibration::OFFSET_ONE_G;
use plumbline::measure::definition::{self, cross_slope, perpendicular, rotation};
use plumbline::measure::low_pass::{Kind, LowPass};
use plumbline::measure::output_filter::OutputFilter;
use plumbline::measure::{Calibration, I32x3, Inclinometer, ONE_G, RANGE, Reading, zero};
use std::collections::BTreeMap;
use std::f64::consts::PI;

/// The rows of a vector file below its header.
fn rows(name: &str) -> Vec<Vec<String>> {
    let path = format!("{}/vectors/{name}", env!("CARGO_MANIFEST_DIR"));
    let text = std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{path}: {error}"));
    let rows: Vec<Vec<String>> = text
        .lines()
        .skip(1)
        .map(|line| line.split(',').map(str::to_owned).collect())
        .collect();
    assert!(!rows.is_empty(), "{path} is empty");
    rows
}

fn number<T: std::str::FromStr<Err: std::fmt::Debug>>(field: &str) -> T {
    field.parse().unwrap()
}

/// The unit of an `Angle` in deg.
const UNIT: f64 = 360.0 / 4_294_967_296.0;

/// The difference of an angle and a number of degrees, in deg.
fn difference(angle: Angle, degrees: f64) -> f64 {
    let difference = f64::from(angle.0) * UNIT - degrees;
    (difference - (difference / 360.0).round() * 360.0).abs()
}

fn along_x(x: i32) -> I32x3 {
    I32x3 { x, y: 0, z: 0 }
}

/// Rows of a filter file, grouped by kind and cut-off: the columns after those two.
fn by_filter(name: &str) -> BTreeMap<(String, u16), Vec<(f64, f64)>> {
    let mut groups = BTreeMap::<_, Vec<_>>::new();
    for row in rows(name) {
        let [kind, cutoff, at, value] = &row[..] else {
            panic!("{name}: {row:?}")
        };
        let group = groups.entry((kind.clone(), number(cutoff))).or_default();
        group.push((number(at), number(value)));
    }
    groups
}

/// A filter of a vector file's kind and cut-off, settled at 0.
fn filter(kind: &str, cutoff: u16) -> LowPass {
    let kind = match kind {
        "butterworth" => Kind::Butterworth,
        "critical" => Kind::CriticallyDamped,
        other => panic!("{other}"),
    };
    let mut filter = LowPass::new();
    filter.tune(kind, cutoff).unwrap();
    filter.step(along_x(0));
    filter
}

#[test]
fn arc_tangents_are_within_the_documented_error() {
    for row in rows("atan2.csv") {
        let (y, x) = (number(&row[0]), number(&row[1]));
        let error = difference(Angle::atan2(y, x), number(&row[2]));
        assert!(
            error <= f64::from(Angle::ATAN2_ERROR.0) * UNIT,
            "atan2({y}, {x}): {error:e} deg"
        );
    }
}

#[test]
fn one_axis_and_two_axis_angles_are_within_the_documented_error() {
    for row in rows("angles.csv") {
        let up = I32x3 {
            x: number(&row[0]),
            y: number(&row[1]),
            z: number(&row[2]),
        };
        let two_axis = perpendicular(up);
        let angles = [two_axis.x, two_axis.y, rotation(up), cross_slope(up)];
        for (angle, exact) in angles.into_iter().zip(&row[3..]) {
            let error = difference(angle, number(exact));
            assert!(
                error <= f64::from(definition::ERROR.0) * UNIT,
                "{row:?}: {error:e} deg"
            );
        }
    }
}

#[test]
fn step_responses_match_the_exact_filter() {
    for ((kind, cutoff), response) in by_filter("steps.csv") {
        let mut filter = filter(&kind, cutoff);
        let mut sample = 0;
        for (n, value) in response {
            let mut output = 0;
            while f64::from(sample) <= n {
                output = filter.step(along_x(ONE_G)).x;
                sample += 1;
            }
            let error = f64::from(output) / f64::from(ONE_G) - value;
            assert!(
                error.abs() < 1e-6,
                "{kind} {cutoff} mHz, sample {n}: {error:e}"
            );
        }
    }
}

/// The oldest entry of the moving average counts with its mean: with both filters, up to 0.3 deg of a step of 100 deg.
#[test]
fn recursive_filter_and_moving_average_match_the_exact_filters() {
    let step = Angle((100.0 / UNIT) as u32);
    let (mut filter, mut settings) = (OutputFilter::<1>::INITIAL, (0, 0));
    for row in rows("output_filter.csv") {
        let (weight, size, reading) = (number(&row[0]), number(&row[1]), number::<u32>(&row[2]));
        if settings != (weight, size) {
            settings = (weight, size);
            filter = OutputFilter::INITIAL;
            filter.tune(weight, size);
            // 50 readings have a whole number of program cycles.
            for _ in 0..50 {
                filter.step([Angle::ZERO]);
            }
        }
        let [output] = filter.step([step]);
        let limit = if weight == 0 || size == 0 { 2e-5 } else { 0.3 };
        let error = difference(output, number(&row[3]));
        assert!(error < limit, "{weight}, {size}, {reading}: {error:e} deg");
    }
}

#[test]
fn butterworth_overshoot_matches_the_ideal_filter() {
    for row in rows("overshoot.csv") {
        let cutoff: u16 = number(&row[0]);
        let mut filter = filter("butterworth", cutoff);
        let samples = 10 * 200_000 / u32::from(cutoff);
        let highest = (0..samples).map(|_| filter.step(along_x(ONE_G)).x).max();
        let overshoot = f64::from(highest.unwrap()) / f64::from(ONE_G) - 1.0;
        let error = overshoot - number::<f64>(&row[1]);
        assert!(error.abs() < 1e-6, "{cutoff} mHz: {overshoot}");
    }
}

#[test]
fn frequency_responses_are_within_a_thousandth_of_a_db() {
    const IMPULSE: i32 = RANGE - 1;
    for ((kind, cutoff), response) in by_filter("responses.csv") {
        // The Fourier transform of the response to the largest impulse, at each frequency of the file.
        let mut filter = filter(&kind, cutoff);
        let samples = 20 * 200_000 / u32::from(cutoff);
        let impulse: Vec<f64> = (0..samples)
            .map(|n| filter.step(along_x(if n == 0 { IMPULSE } else { 0 })).x)
            .map(|output| f64::from(output) / f64::from(IMPULSE))
            .collect();
        for (frequency, db) in response {
            let turn = 2.0 * PI * frequency / 200.0;
            let (mut real, mut imaginary) = (0.0, 0.0);
            for (n, value) in impulse.iter().enumerate() {
                let (sin, cos) = (turn * n as f64).sin_cos();
                real += value * cos;
                imaginary -= value * sin;
            }
            let magnitude = real.hypot(imaginary);
            let at = format!("{kind} {cutoff} mHz at {frequency} Hz: {magnitude}");
            if db > -3.02 {
                assert!((20.0 * magnitude.log10() - db).abs() < 1e-3, "{at}");
            } else {
                assert!((magnitude - 10f64.powf(db / 20.0)).abs() < 2e-6, "{at}");
            }
        }
    }
}

#[test]
fn sample_passes_through_all_steps_of_the_path() {
    // Nose down by 30.00 deg. The accelerometer has an offset of 0.1 g in z and, 5 K above 25 degC, drifts by 5 times
    // 0.6 mg in x (10066 * 2^-24 g/K), which is an error of 0.17 deg without calibration.
    let offset = ONE_G / 10;
    let drift = ONE_G / 1000 * 3;
    let mut inclinometer = Inclinometer {
        calibration: Calibration::new([0, 0, OFFSET_ONE_G / 10], [[0; 3]; 3], [10_066, 0, 0])
            .unwrap(),
        ..Default::default()
    };
    inclinometer
        .low_pass
        .tune(Kind::CriticallyDamped, 2_000)
        .unwrap();
    let g = f64::from(ONE_G);
    let reading = |degrees: f64| Reading {
        acceleration: I32x3 {
            x: (-degrees.to_radians().sin() * g) as i32 + drift,
            y: 0,
            z: (degrees.to_radians().cos() * g) as i32 + offset,
        },
        angular_rate: along_x(0),
        temperature: 3_000,
        clipped: false,
    };
    let mut x = |degrees| {
        let up = inclinometer.sample(&reading(degrees));
        perpendicular(up).x.centidegrees()
    };
    assert_eq!(x(30.0), 3_000);
    // Back to level: the filter delays the angle, then it is 0.
    assert!((2_900..=3_000).contains(&x(0.0)));
    for _ in 0..400 {
        x(0.0);
    }
    assert_eq!(x(0.0), 0);
    assert_eq!(zero::two_axis(x(0.0), zero::two_axis_auto(125)), -125);
}
