//! Tests of the filter on motions: lag, error, bias, vibration, and the effect of Q and R. The host tests compare it with double
//! precision.

use super::*;
use crate::angle::Angle;
use crate::measure::definition::{perpendicular, rotation};
use crate::measure::{ONE_G, mean_rate};
use core::f64::consts::{PI, TAU};

mod gaps;
mod stability;

/// The sample period in s.
const PERIOD: f64 = SAMPLE_PERIOD.ticks() as f64 / 1e6;

/// The age of the acceleration in the devices, in us.
const DELAY: u32 = mean_rate::ACCELERATION_AGE;

/// R = 10.
const R: Noise = Noise::new(1, 1);
/// Q = 0.01, 0.001 (factory setting), 0.0001.
const Q: [Noise; 3] = [Noise::new(1, -2), Noise::new(1, -3), Noise::new(1, -4)];

/// The variants of the sensor.
#[derive(Clone, Copy, PartialEq, Debug)]
enum Axes {
    /// 1 axis: rotation about Z, 0 to 360 deg.
    One,
    /// 2 axes: rotation about Y, +-90 deg.
    Two,
}

impl Axes {
    /// The up vector in g at `angle` (rad).
    fn up(self, angle: f64) -> [f64; 3] {
        let (sin, cos) = angle.sin_cos();
        match self {
            Self::One => [sin, cos, 0.0],
            Self::Two => [-sin, 0.0, cos],
        }
    }

    /// The vector of an angular rate about the axis of the motion.
    fn rate(self, rate: f64) -> [f64; 3] {
        match self {
            Self::One => [0.0, 0.0, rate],
            Self::Two => [0.0, rate, 0.0],
        }
    }

    /// The angle that the sensor calculates of an up vector.
    fn angle(self, up: I32x3) -> Angle {
        match self {
            Self::One => rotation(up),
            Self::Two => perpendicular(up).x,
        }
    }
}

/// A motion about one axis.
struct Motion<'a> {
    axes: Axes,
    /// The angle in deg at a time in s.
    angle: &'a dyn Fn(f64) -> f64,
    /// The acceleration in g in the fixed frame (along the horizontal, up), without gravity, at a time in s.
    acceleration: &'a dyn Fn(f64) -> [f64; 2],
    /// The bias of the gyroscope in deg/s.
    bias: f64,
}

/// A sample of the output.
#[derive(Clone, Copy, Debug)]
struct Output {
    /// The true angle in deg.
    truth: f64,
    /// The angular rate in deg/s.
    rate: f64,
    /// The error of the angle in deg.
    error: f64,
}

fn integers(vector: [f64; 3], unit: f64) -> I32x3 {
    let [x, y, z] = vector.map(|component| (component * unit).round() as i32);
    I32x3 { x, y, z }
}

impl Motion<'_> {
    /// A level 2-axis sensor at rest, without bias of the gyroscope.
    const REST: Motion<'static> = Motion {
        axes: Axes::Two,
        angle: &|_| 0.0,
        acceleration: &|_| [0.0; 2],
        bias: 0.0,
    };

    /// The specific force in g in the frame of the sensor.
    fn force(&self, time: f64) -> [f64; 3] {
        let angle = (self.angle)(time).to_radians();
        let [along, up] = (self.acceleration)(time);
        let vertical = self.axes.up(angle);
        let horizontal = self.axes.up(angle - PI / 2.0);
        core::array::from_fn(|i| vertical[i] * (1.0 + up) + horizontal[i] * along)
    }

    /// Runs `fusion` for `seconds`, and returns an output for each sample.
    fn run<const DELAY: u32>(&self, fusion: &mut Fusion<DELAY>, seconds: f64) -> Vec<Output> {
        let samples = (seconds / PERIOD).round() as i32;
        let outputs = (0..samples).map(|n| {
            let now = f64::from(n) * PERIOD;
            let force = self.force(now - f64::from(DELAY) / 1e6);
            let truth = (self.angle)(now);
            let rate = (truth - (self.angle)(now - PERIOD)) / PERIOD;
            let up = fusion.step(
                integers(force, ONE_G.into()),
                integers(self.axes.rate(rate + self.bias), 65_536.0),
                true,
            );
            let degrees = f64::from(self.axes.angle(up).0) * 360.0 / 4_294_967_296.0;
            let error = degrees - truth;
            let error = error - (error / 360.0).round() * 360.0;
            Output { truth, rate, error }
        });
        outputs.collect()
    }
}

fn tuned<const DELAY: u32>(q: Noise, r: Noise) -> Fusion<DELAY> {
    let mut fusion = Fusion::new();
    fusion.tune(q, r);
    fusion
}

/// From -45 deg to 45 deg within 0.3 s, beginning at 10 s, with a continuous acceleration.
fn swing(time: f64) -> f64 {
    let part = ((time - 10.0) / 0.3).clamp(0.0, 1.0);
    -45.0 + 90.0 * (part - (TAU * part).sin() / TAU)
}

/// The time in s by which the output is late (least squares).
fn lag(outputs: &[Output]) -> f64 {
    let product: f64 = outputs.iter().map(|o| o.error * o.rate).sum();
    let square: f64 = outputs.iter().map(|o| o.rate * o.rate).sum();
    -product / square
}

fn largest(outputs: &[Output]) -> f64 {
    outputs.iter().map(|o| o.error.abs()).fold(0.0, f64::max)
}

fn rms(outputs: &[Output]) -> f64 {
    let sum: f64 = outputs.iter().map(|o| o.error * o.error).sum();
    (sum / outputs.len() as f64).sqrt()
}

#[test]
fn output_follows_fast_swing_without_lag() {
    for axes in [Axes::One, Axes::Two] {
        for q in Q {
            let motion = Motion {
                axes,
                angle: &swing,
                bias: 0.5,
                ..Motion::REST
            };
            // The bias is known after 10 s at the factory setting.
            let outputs = motion.run(&mut tuned::<DELAY>(q, R), 12.0);
            assert!((outputs[2399].truth - 45.0).abs() < 1e-9);
            let swing = &outputs[1990..];
            assert!(lag(swing).abs() < 0.005, "{axes:?} {q:?}: {} s", lag(swing));
            if q == Q[1] {
                assert!(lag(swing).abs() < 0.000_5, "{axes:?}: {} s", lag(swing));
                assert!(largest(swing) < 0.3, "{axes:?}: {} deg", largest(swing));
            }
        }
    }
}

#[test]
fn swing_directly_after_start_has_small_error() {
    let early = |time| swing(time + 9.9);
    let motion = Motion {
        angle: &early,
        bias: 0.5,
        ..Motion::REST
    };
    let outputs = motion.run(&mut tuned::<DELAY>(Q[1], R), 0.5);
    assert!(lag(&outputs).abs() < 0.005);
    assert!(largest(&outputs) < 0.3, "{} deg", largest(&outputs));
}

#[test]
fn one_axis_output_follows_several_turns_through_360_degrees() {
    let turns = |time: f64| 10.0 * time * time;
    let motion = Motion {
        axes: Axes::One,
        angle: &turns,
        ..Motion::REST
    };
    let outputs = motion.run(&mut tuned::<DELAY>(Q[1], R), 20.0);
    assert!(outputs[3999].truth > 10.0 * 360.0);
    assert!(largest(&outputs) < 0.05, "{} deg", largest(&outputs));
}

#[test]
fn bias_of_the_gyroscope_has_no_effect_after_60_seconds() {
    for axes in [Axes::One, Axes::Two] {
        for bias in [0.5, -0.5] {
            let motion = Motion {
                axes,
                angle: &|_| 30.0,
                bias,
                ..Motion::REST
            };
            // With the smallest Q, the bias is estimated from 8 s on.
            for (q, limit) in [(Q[0], 1e-4), (Q[1], 1e-3), (Q[2], 0.03)] {
                let outputs = motion.run(&mut tuned::<DELAY>(q, R), 65.0);
                let late = largest(&outputs[12_000..]);
                assert!(late < limit, "{axes:?} {q:?}: {late} deg");
            }
        }
    }
}

#[test]
fn bias_is_estimated_only_after_the_start_and_at_1_g() {
    let still = I32x3 { x: 0, y: 0, z: 0 };
    // The gyroscope turns by 0.5 deg/s, the acceleration does not.
    let turning = integers([0.0, 0.5, 0.0], 65_536.0);
    let level = I32x3 {
        x: 0,
        y: 0,
        z: ONE_G,
    };
    for (is_one_g, seconds, learns) in
        [(true, 2.0, false), (false, 60.0, false), (true, 60.0, true)]
    {
        let mut fusion = tuned::<DELAY>(Q[1], R);
        for _ in 0..(seconds / PERIOD) as u32 {
            fusion.step(level, turning, is_one_g);
        }
        // Without a rotation, a bias turns the vector.
        let before = perpendicular(fusion.step(level, still, is_one_g)).x;
        let after = perpendicular(fusion.step(level, still, is_one_g)).x;
        let turned = f64::from((after - before).millidegrees());
        assert_eq!(
            turned.abs() > 1.0 && before.millidegrees().abs() < 5,
            learns,
            "{seconds} s: {before:?} {turned}"
        );
    }
}

/// The worst error of the mean over one period, of the periods that begin at these times in s or later.
fn worst_means(outputs: &[Output], period: usize, from: [f64; 3]) -> [f64; 3] {
    from.map(|from| {
        let late = &outputs[(from / PERIOD) as usize..];
        let means = late.windows(period).map(|window| {
            let sum: f64 = window.iter().map(|output| output.error).sum();
            (sum / period as f64).abs()
        });
        means.fold(0.0, f64::max)
    })
}

#[test]
fn vibration_from_power_up_is_averaged_out() {
    for (frequency, period, limits) in [(3.0, 67, [0.8, 0.35, 0.05]), (1.0, 200, [6.7, 3.4, 0.35])]
    {
        let mut worst = [0.0_f64; 3];
        for phase in 0..16 {
            let phase = f64::from(phase) / 16.0;
            for axes in [Axes::One, Axes::Two] {
                let shake = |time: f64| [0.5 * (TAU * (frequency * time + phase)).sin(), 0.0];
                let motion = Motion {
                    axes,
                    angle: &|_| 20.0,
                    acceleration: &shake,
                    bias: 0.0,
                };
                let outputs = motion.run(&mut tuned::<DELAY>(Q[2], R), 8.0);
                let means = worst_means(&outputs, period, [0.5, 1.0, 3.0]);
                for (worst, mean) in worst.iter_mut().zip(means) {
                    *worst = worst.max(mean);
                }
            }
        }
        println!("{frequency} Hz: {worst:.3?} deg");
        for (worst, limit) in worst.into_iter().zip(limits) {
            assert!(
                worst <= limit,
                "{frequency} Hz: {worst} deg, limit {limit} deg"
            );
        }
    }
}

#[test]
fn smaller_gain_goes_on_from_the_samples_of_the_larger_one() {
    let shake = |time: f64| [0.5 * (TAU * 3.0 * time).sin(), 0.0];
    let motion = Motion {
        acceleration: &shake,
        ..Motion::REST
    };
    let mut fusion = tuned::<DELAY>(Q[0], R);
    // At this time, the angle is far off.
    motion.run(&mut fusion, 5.08);
    fusion.tune(Q[2], R);
    let outputs = motion.run(&mut fusion, 5.0);
    let [_, _, late] = worst_means(&outputs, 67, [0.5, 1.0, 2.0]);
    // With the small gain alone it would be 2.3 deg.
    assert!(late < 1.0, "{late} deg");
}

/// 0.2 g for 3 s, as a machine that speeds up: the error meanwhile, and on the other side afterwards.
#[test]
fn constant_acceleration_leaves_the_stated_error() {
    let drive = |time: f64| {
        [
            if (20.0..23.0).contains(&time) {
                0.2
            } else {
                0.0
            },
            0.0,
        ]
    };
    let motion = Motion {
        acceleration: &drive,
        ..Motion::REST
    };
    for (q, during, after) in [(Q[0], 13.0, 1.5), (Q[1], 12.5, 0.8), (Q[2], 7.0, 0.3)] {
        let outputs = motion.run(&mut tuned::<DELAY>(q, R), 60.0);
        let signed = |part: &[Output]| {
            let errors = part.iter().map(|output| output.error);
            errors.fold((0.0_f64, 0.0_f64), |(low, high), error| {
                (low.min(error), high.max(error))
            })
        };
        let (low, high) = signed(&outputs);
        println!("{q:?}: {low:.2} to {high:.2} deg");
        assert!(
            high.max(-low) <= during && high.min(-low) <= after,
            "{q:?}: {low} {high}"
        );
    }
}

#[test]
fn vibration_of_half_a_g_at_3_hz_causes_less_than_1_deg_rms() {
    for axes in [Axes::One, Axes::Two] {
        for angle in [0.0, 45.0, -45.0] {
            let shake = |time: f64| [0.5 * (TAU * 3.0 * time).sin(), 0.0];
            let motion = Motion {
                axes,
                angle: &|_| angle,
                acceleration: &shake,
                bias: 0.0,
            };
            let outputs = motion.run(&mut tuned::<DELAY>(Q[1], R), 40.0);
            let late = rms(&outputs[4000..]);
            assert!(
                (0.5..1.0).contains(&late),
                "{axes:?} {angle}: {late} deg rms"
            );
        }
    }
}

#[test]
fn smaller_q_attenuates_vibration_more() {
    let shake = |time: f64| {
        [
            0.3 * (TAU * 3.0 * time).sin(),
            0.2 * (TAU * 5.0 * time).sin(),
        ]
    };
    let motion = Motion {
        acceleration: &shake,
        ..Motion::REST
    };
    let mut last = f64::INFINITY;
    for exponent in (-5..=2).rev() {
        for mantissa in [9, 5, 3, 2, 1] {
            let q = Noise::new(mantissa, exponent);
            // Without the transient of the start
            let error = rms(&motion.run(&mut tuned::<0>(q, R), 20.0)[2000..]);
            assert!(error < last, "{q:?}: {error} {last}");
            last = error;
        }
    }
}

#[test]
fn smaller_q_gives_the_bias_more_effect() {
    let motion = Motion {
        bias: 0.5,
        ..Motion::REST
    };
    let errors = Q.map(|q| largest(&motion.run(&mut tuned::<DELAY>(q, R), 30.0)));
    assert!(errors[0] < errors[1] && errors[1] < errors[2], "{errors:?}");
}

#[test]
fn equal_quotients_have_equal_outputs() {
    let shake = |time: f64| [0.4 * (TAU * 2.0 * time).sin(), 0.1];
    let motion = Motion {
        angle: &swing,
        acceleration: &shake,
        bias: 0.3,
        ..Motion::REST
    };
    let errors = |q, r| {
        let outputs = motion.run(&mut tuned::<DELAY>(q, r), 12.0);
        outputs.iter().map(|o| o.error).collect::<Vec<_>>()
    };
    let factory = errors(Q[1], R);
    for (q, r) in [
        (Noise::new(1, -10), Noise::new(1, -6)),
        (Noise::new(1, 6), Noise::new(1, 10)),
        (Noise::new(5, -4), Noise::new(5, 0)),
        (Noise::new(100, -6), Noise::new(10, -1)),
    ] {
        assert_eq!(errors(q, r), factory, "{q:?} {r:?}");
    }
}

#[test]
fn new_setting_causes_no_step() {
    let shake = |time: f64| [0.3 * (TAU * time).sin(), 0.0];
    let motion = Motion {
        acceleration: &shake,
        ..Motion::REST
    };
    let mut fusion = tuned::<0>(Q[2], R);
    let before = motion.run(&mut fusion, 10.0);
    fusion.tune(Q[0], R);
    let after = motion.run(&mut fusion, 10.0);
    // The correction of one sample is at most K times the error of the acceleration.
    let step = after[0].error - before[1999].error;
    assert!(step.abs() < 0.05, "{step} deg");
}

#[test]
fn settled_filter_continues_from_the_given_vector() {
    let mut fusion = tuned::<DELAY>(Q[1], R);
    let tilted = I32x3 {
        x: ONE_G / 2,
        y: 0,
        z: ONE_G,
    };
    fusion.settle(tilted);
    let level = I32x3 {
        x: 0,
        y: 0,
        z: ONE_G,
    };
    let up = fusion.step(level, I32x3 { x: 0, y: 0, z: 0 }, true);
    let step = perpendicular(up).x - perpendicular(tilted).x;
    // 2 % of the difference.
    assert!(step.millidegrees().abs() < 600, "{step:?}");
}

#[test]
fn acceleration_is_not_rotated_without_delay() {
    let wobble = |time: f64| 30.0 * (TAU * time).sin();
    let motion = Motion {
        angle: &wobble,
        ..Motion::REST
    };
    // Large gain: the output is nearly the acceleration.
    let fast = Noise::new(127, 10);
    assert!(largest(&motion.run(&mut tuned::<0>(fast, R), 5.0)) < 1e-3);
    // The rotations before the start are not known.
    let outputs = motion.run(&mut tuned::<DELAY>(fast, R), 5.0);
    let late = largest(&outputs[KEPT..]);
    assert!(late < 0.05, "{late} deg");
}
