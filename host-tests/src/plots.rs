//! The plots of the fusion of accelerometer and gyroscope: what the low-pass filter and the Kalman filter make of a motion.
//!
//! Figures 3 and 4 of the manual of the SIKO IMS360, and three motions of a machine. The program `plots` writes them. The filters
//! are those of the core, and the acceleration has the age that it has in the sensor.

mod chart;
mod motions;

use chart::{Chart, Line};
use motions::{MOTIONS, Motion};
use plumbline::measure::definition::perpendicular;
use plumbline::measure::fusion::{Fusion, Noise};
use plumbline::measure::low_pass::{Kind, LowPass};
use plumbline::measure::mean_rate::ACCELERATION_AGE;
use plumbline::measure::{I32x3, ONE_G, SAMPLE_PERIOD};
use std::path::{Path, PathBuf};

/// The folder of the plots, beside the model.
pub fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../core/src/model/ims360/plots")
}

/// A plot as a file.
pub struct Plot {
    /// The name of its file.
    pub file: String,
    /// The content of the file, an SVG document.
    pub svg: String,
}

/// The plots of all motions.
pub fn plots() -> Vec<Plot> {
    let plot = |motion: &Motion| Plot {
        file: format!("{}.svg", motion.name),
        svg: plot(motion),
    };
    MOTIONS.iter().map(plot).collect()
}

/// The sample period in s.
const PERIOD: f64 = SAMPLE_PERIOD.ticks() as f64 / 1e6;

/// The bias of the gyroscope about each axis, in deg/s.
const BIAS: [f64; 3] = [0.3, 0.5, -0.4];

/// The time in s at rest before the plot, in which the filter estimates the bias.
const REST: f64 = 60.0;

/// The time in s between two points of a plot.
const STEP: f64 = 0.01;

/// The angles of a motion in deg, at the times in s.
struct Angles {
    times: Vec<f64>,
    truth: Vec<f64>,
    low_pass: Vec<f64>,
    fusion: Vec<f64>,
}

/// Filters the motion with a critically damped filter of 3 Hz, and with R = 10, Q = 0.001 (manual 5.1.4.1).
fn angles(motion: &Motion) -> Angles {
    let mut low_pass = LowPass::new();
    low_pass
        .tune(Kind::CriticallyDamped, 3_000)
        .expect("3 Hz is permitted");
    let mut fusion = Fusion::<ACCELERATION_AGE>::new();
    fusion.tune(Noise::new(1, -3), Noise::new(1, 1));

    let mut angles = Angles {
        times: Vec::new(),
        truth: Vec::new(),
        low_pass: Vec::new(),
        fusion: Vec::new(),
    };
    let samples = (motion.seconds / PERIOD).round() as i32;
    let rest = (REST / PERIOD).round() as i32;
    for n in -rest..=samples {
        let now = f64::from(n) * PERIOD;
        let force = motion.force(now - f64::from(ACCELERATION_AGE) / 1e6);
        let rate = motion.mean_rate(now, PERIOD);
        let rate = [0, 1, 2].map(|axis| rate[axis] + BIAS[axis]);
        let acceleration = integers(force, ONE_G.into());
        let slow = low_pass.step(acceleration);
        let fast = fusion.step(acceleration, integers(rate, 65_536.0), true);
        if n >= 0 && n % (STEP / PERIOD).round() as i32 == 0 {
            let degrees = |up| f64::from(perpendicular(up).x.millidegrees()) / 1000.0;
            angles.times.push(now);
            angles.truth.push((motion.angle)(now));
            angles.low_pass.push(degrees(slow));
            angles.fusion.push(degrees(fast));
        }
    }
    angles
}

fn integers(vector: [f64; 3], unit: f64) -> I32x3 {
    let [x, y, z] = vector.map(|component| (component * unit).round() as i32);
    I32x3 { x, y, z }
}

/// The largest difference of two lines.
fn largest_error(line: &[f64], truth: &[f64]) -> f64 {
    let errors = line.iter().zip(truth).map(|(a, b)| (a - b).abs());
    errors.fold(0.0, f64::max)
}

fn plot(motion: &Motion) -> String {
    let Angles {
        times,
        truth,
        low_pass,
        fusion,
    } = angles(motion);
    let label = |name: &str, line: &[f64]| {
        format!("{name}: error up to {:.1} deg", largest_error(line, &truth))
    };
    let lines = [
        Line {
            label: label("low-pass, critically damped, 3 Hz", &low_pass),
            style: "stroke=\"#d55e00\" stroke-width=\"1.6\"",
            values: &low_pass,
        },
        Line {
            label: label("Kalman filter, R = 10, Q = 0.001", &fusion),
            style: "stroke=\"#0072b2\" stroke-width=\"2.4\"",
            values: &fusion,
        },
        Line {
            label: "true angle".to_owned(),
            style: "stroke=\"#000\" stroke-width=\"1.4\" stroke-dasharray=\"2 4\"",
            values: &truth,
        },
    ];
    Chart {
        title: motion.title,
        x: "time / s",
        y: "longitudinal angle / deg",
        times: &times,
        lines: &lines,
    }
    .svg()
}
