//! The Kalman filter of the core against double precision (`vectors/generate_fusion.py`).

use plumbline::angle::Angle;
use plumbline::measure::definition::{cross_slope, perpendicular, rotation};
use plumbline::measure::fusion::{Fusion, Noise};
use plumbline::measure::{I32x3, ONE_G, mean_rate};
use std::collections::BTreeMap;

const VECTORS: &str = include_str!("../../vectors/fusion.csv");

/// The resolution of the accelerations in the vectors, 2^-14 g.
const ACCELERATION_COUNT: i32 = ONE_G >> 14;
/// 1/64 deg/s in 2^-16 deg/s.
const RATE_COUNT: i32 = 1 << 10;

/// The largest permitted difference from double precision, in deg.
const LIMIT: f64 = 0.02;

/// A row of the vectors.
struct Row {
    axes: u8,
    q: f64,
    acceleration: I32x3,
    rate: I32x3,
    /// The expected angles in deg.
    angles: [f64; 2],
}

/// The rows of each scene.
fn scenes() -> BTreeMap<&'static str, Vec<Row>> {
    let mut scenes = BTreeMap::<_, Vec<_>>::new();
    for line in VECTORS.lines().skip(1) {
        let fields: Vec<&str> = line.split(',').collect();
        let number = |place: usize| fields[place].parse::<f64>().unwrap();
        let vector = |first: usize, unit: i32| {
            let [x, y, z] = [0, 1, 2].map(|place| number(first + place) as i32 * unit);
            I32x3 { x, y, z }
        };
        scenes.entry(fields[0]).or_default().push(Row {
            axes: number(1) as u8,
            q: number(2),
            acceleration: vector(3, ACCELERATION_COUNT),
            rate: vector(6, RATE_COUNT),
            angles: [number(9), number(10)],
        });
    }
    scenes
}

/// The noise parameter of this power of ten.
fn power_of_ten(value: f64) -> Noise {
    Noise::new(1, value.log10().round() as i8)
}

/// The difference of an angle and a number of degrees, in deg.
fn difference(angle: Angle, degrees: f64) -> f64 {
    let difference = f64::from(angle.0) * 360.0 / 4_294_967_296.0 - degrees;
    (difference - (difference / 360.0).round() * 360.0).abs()
}

#[test]
fn filter_matches_double_precision_in_every_scene() {
    let scenes = scenes();
    let names: Vec<_> = scenes.keys().copied().collect();
    assert_eq!(
        names,
        ["digging", "shaking", "slewing", "swivel", "travelling"]
    );
    for (name, rows) in scenes {
        let mut fusion = Fusion::<{ mean_rate::ACCELERATION_AGE }>::new();
        fusion.tune(power_of_ten(rows[0].q), power_of_ten(10.0));
        let mut largest = 0.0_f64;
        for (n, row) in rows.iter().enumerate() {
            let up = fusion.step(row.acceleration, row.rate, true);
            let angles = match row.axes {
                1 => [rotation(up), cross_slope(up)],
                _ => [perpendicular(up).x, perpendicular(up).y],
            };
            for (angle, exact) in angles.into_iter().zip(row.angles) {
                let error = difference(angle, exact);
                assert!(error <= LIMIT, "{name}, sample {n}: {error} deg");
                largest = largest.max(error);
            }
        }
        println!("{name}: {largest:.6} deg");
    }
}
