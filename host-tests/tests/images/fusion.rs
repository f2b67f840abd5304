//! The Kalman filter of the flashed IMS360, with the clocks of the accelerometer and of the gyroscope: the figures of the tests of the core
//! (`core/src/measure/fusion/tests.rs`).

use crate::rig::ims360::{HEARTBEAT, TPDO1};
use crate::rig::*;
use bench::motion::Motion;
use plumbline::can::standard;
use plumbline::measure::{I32x3, ONE_G, Reading};
use plumbline::time::Instant;
use std::f64::consts::TAU;

/// 1 deg/s in the unit of a reading.
const UNIT: f64 = 65_536.0;

/// A second in picoseconds.
const SECOND: f64 = 1e12;

/// A rotation about Y by an angle in deg, with a horizontal vibration along X in g and an offset of the gyroscope in deg/s.
#[derive(Clone, Copy)]
pub struct Rotation {
    /// By the time in s.
    pub angle: fn(f64) -> f64,
    pub vibration: fn(f64) -> f64,
    pub offset: f64,
}

impl Rotation {
    /// The angular rate in deg/s.
    fn rate(self, time: f64) -> f64 {
        ((self.angle)(time + 1e-6) - (self.angle)(time - 1e-6)) / 2e-6
    }
}

impl Motion for Rotation {
    fn reading(&mut self, now: Instant) -> Reading {
        let time = now.ticks() as f64 / 1e6;
        let (sine, cosine) = (self.angle)(time).to_radians().sin_cos();
        let along = (self.vibration)(time);
        let force = [-sine + along * cosine, 0.0, cosine + along * sine];
        let [x, y, z] = force.map(|part| (part * f64::from(ONE_G)).round() as i32);
        let rate = ((self.rate(time) + self.offset) * UNIT).round() as i32;
        Reading {
            acceleration: I32x3 { x, y, z },
            angular_rate: I32x3 {
                x: 0,
                y: rate,
                z: 0,
            },
            temperature: 2500,
            clipped: false,
        }
    }
}

/// A sensor with the Kalman filter in operational. It sends TPDO 1 when a value changes.
fn fusing(motion: Rotation, clock: f64) -> Rig {
    let mut rig = configured(motion, clock);
    rig.nmt(1);
    rig
}

/// As [`fusing`], in pre-operational.
fn configured(motion: Rotation, clock: f64) -> Rig {
    let mut rig = Rig::ims360_with(Box::new(motion), clock);
    rig.download(0x3110, 2, [1]);
    rig.download(0x1800, 2, [255]);
    rig
}

/// The longitudinal angles in deg that the sensor has sent since the last call, with the times in s at which their frames began.
fn angles(rig: &mut Rig) -> Vec<(f64, f64)> {
    let sent = rig.sent().into_iter().map(|logged| {
        assert_eq!(logged.frame.id(), standard(TPDO1));
        let &[a, b, c, d, ..] = logged.frame.bytes() else {
            panic!("{:?}", logged.frame)
        };
        let angle = i32::from_le_bytes([a, b, c, d]);
        (logged.start as f64 / SECOND, f64::from(angle) / 100.0)
    });
    sent.collect()
}

/// The start of the swing in s, when the offset of the gyroscope is known, and its duration.
const START: f64 = 10.0;
const SWING: f64 = 0.3;

/// From -45 deg to 45 deg within 0.3 s (figure 3 of the manual), with a continuous acceleration, at 600 deg/s at most.
fn swing(time: f64) -> f64 {
    let part = ((time - START) / SWING).clamp(0.0, 1.0);
    -45.0 + 90.0 * (part - (TAU * part).sin() / TAU)
}

/// The offset of the gyroscope in deg/s.
const OFFSET: f64 = 0.5;

/// The lag is the time from the motion to the start of the frame. The error is the difference from the motion before this time.
#[test]
pub fn swing_is_followed_within_5_ms_and_0_3_deg() {
    for clock in [-5.0, 5.0] {
        let motion = Rotation {
            angle: swing,
            vibration: |_| 0.0,
            offset: OFFSET,
        };
        let mut rig = fusing(motion, clock);
        rig.run((START * 1000.0) as u64 - rig.bus.now().ticks() / 1000);
        angles(&mut rig);
        rig.run(500);
        let sent = angles(&mut rig);
        assert!(sent.len() > 50, "{} values", sent.len());
        // Least squares.
        let sums = sent.iter().map(|&(time, angle)| {
            let rate = motion.rate(time);
            ((swing(time) - angle) * rate, rate * rate)
        });
        let (product, square) = sums.fold((0.0, 0.0), |(a, b), (c, d)| (a + c, b + d));
        let lag = product / square;
        let errors = sent
            .iter()
            .map(|&(time, angle)| (angle - swing(time - lag)).abs());
        let largest = errors.fold(0.0, f64::max);
        println!("{clock} %: {:.2} ms, {largest:.3} deg", lag * 1e3);
        assert!((0.0..=0.005).contains(&lag), "{clock} %: {lag} s");
        assert!(largest <= 0.3, "{clock} %: {largest} deg");
    }
}

/// The mean over each period of the vibration, from a second after the boot-up message on.
#[test]
fn vibration_from_power_up_is_averaged_out() {
    const PERIOD: f64 = 1.0 / 3.0;
    let motion = Rotation {
        angle: |_| 10.0,
        vibration: |time| 0.5 * (TAU * time / PERIOD).cos(),
        offset: 0.0,
    };
    // The Kalman filter with Q = 0.0001 acts from power-up on.
    let mut rig = configured(motion, 0.0);
    rig.download(0x3112, 2, [(-4_i8).cast_unsigned()]);
    rig.download_within(1_000, 0x1010, 1, *b"save");
    rig.power_cycle();
    rig.expect(HEARTBEAT, 300);
    rig.nmt(1);
    rig.run(1000);
    angles(&mut rig);
    rig.run(3000);
    let sent = angles(&mut rig);
    // An angle is in force until the next one.
    let held = sent
        .windows(2)
        .map(|pair| (pair[0].0, pair[1].0 - pair[0].0, pair[0].1));
    let held: Vec<_> = held.collect();
    let start = sent[0].0;
    let means = (0..8).map(|number| {
        let from = start + f64::from(number) * PERIOD;
        let period = held
            .iter()
            .filter(|(time, ..)| (from..from + PERIOD).contains(time));
        let sums = period.fold((0.0, 0.0), |(area, time), (_, length, angle)| {
            (area + length * angle, time + length)
        });
        sums.0 / sums.1
    });
    let worst = means.map(|mean| (mean - 10.0).abs()).fold(0.0, f64::max);
    println!("{worst:.3} deg");
    assert!(worst < 0.35, "{worst} deg");
}
