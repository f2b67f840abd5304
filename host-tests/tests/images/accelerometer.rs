//! The accelerometer fails, recovers, clips, starts late, or has a clock error. `accelerometer_faults.rs` has its other faults,
//! `invalid.rs` the answers of all protocols.

use crate::rig::*;
use bench::motion::Motion;
use bench::{BusRate, Flash};
use plumbline::can::BitRate;
use plumbline::measure::{I32x3, ONE_G, Reading};
use plumbline::time::Instant;
use stm32_sim::ism330dhcx::{Fault, Noise};

pub const RATE: BitRate = BitRate::K500;

/// The sensor error bits of both axes.
pub const ERRORS: u8 = status::SENSOR_ERROR_X | status::SENSOR_ERROR_Y;

/// The time in ms after which the angles of [`quick`] are right.
const SETTLING: u64 = 300;

/// The memory of an is2 with the fastest filter: Butterworth, 25 Hz.
pub fn memory() -> Flash {
    let rate = [fsc::WRITE_BAUD_RATE, baud_rate_code(RATE)];
    saved("is2", &[&rate, &[fsc::WRITE_FILTER, 0xA8, 0x61, 1]])
}

/// An is2 with the fastest filter, settled.
pub fn quick() -> Rig {
    let mut rig = Rig::with("is2", BusRate::Fixed(RATE), memory());
    rig.boot_up();
    rig.run(SETTLING);
    rig
}

/// An angle of a reply in 0.01 degrees.
pub fn angle(reply: &[u8], at: usize) -> i16 {
    i16::from_le_bytes([reply[at], reply[at + 1]])
}

/// The reply to a poll has no error, 10 and 5 degrees. A count of the accelerometer is 0.014 degrees.
#[track_caller]
fn assert_right(reply: &[u8]) {
    assert_eq!(reply[1], 0, "{reply:02X?}");
    assert!(angle(reply, 2).abs_diff(1000) <= 1, "{reply:02X?}");
    assert!(angle(reply, 4).abs_diff(500) <= 1, "{reply:02X?}");
}

#[test]
pub fn accelerometer_failure_is_reported_within_200_ms_and_cleared_after_recovery() {
    for fault in [Fault::Silent(0xFF), Fault::Silent(0), Fault::Stopped] {
        let mut rig = quick();
        assert_right(&rig.poll());
        let (io, now) = rig.io();
        io.imu.set_fault(now, fault);
        // No sample for 100 ms (core/src/model/gemac/README.md, G19).
        rig.run(90);
        assert_right(&rig.poll());
        rig.run(110);
        assert_eq!(rig.poll()[1], ERRORS, "{fault:?}");
        let (io, now) = rig.io();
        io.imu.set_fault(now, Fault::None);
        rig.run(SETTLING);
        assert_right(&rig.poll());
    }
}

#[test]
fn accelerometer_that_starts_late_is_used() {
    let mut rig = Rig::with("is2", BusRate::Fixed(RATE), memory());
    rig.io().0.imu.unmount();
    rig.boot_up();
    assert_eq!(rig.poll()[1], ERRORS);
    rig.run(300);
    let (io, now) = rig.io();
    io.imu.power_on(now);
    rig.run(SETTLING);
    assert_right(&rig.poll());
}

#[test]
fn clipping_for_longer_than_100_ms_sets_the_sensor_error() {
    let mut rig = quick();
    assert_right(&rig.poll());
    let shock = Reading {
        acceleration: I32x3 {
            x: 0,
            y: 0,
            z: 9 * ONE_G,
        },
        angular_rate: I32x3 { x: 0, y: 0, z: 0 },
        temperature: 2500,
        clipped: true,
    };
    let device = rig.bus.device_mut(rig.sensor);
    device.set_motion(Box::new(shock));
    rig.run(90);
    assert_eq!(rig.poll()[1], 0);
    rig.run(60);
    assert_eq!(rig.poll()[1], ERRORS);
    let device = rig.bus.device_mut(rig.sensor);
    device.set_motion(tilt("is2", 10.0, 5.0));
    rig.run(80);
    assert_eq!(rig.poll()[1], ERRORS, "the error is held");
    rig.run(SETTLING);
    assert_right(&rig.poll());
}

/// At 30 deg about Y, with a shock along the vertical for 20 ms, twice a second, during which the acceleration is this one in g.
struct Digging(f64);

impl Motion for Digging {
    fn reading(&mut self, now: Instant) -> Reading {
        let g = if now.ticks() % 500_000 < 20_000 {
            self.0
        } else {
            1.0
        };
        let (x, z) = (-30_f64.to_radians().sin(), 30_f64.to_radians().cos());
        let [x, z] = [x, z].map(|part| (part * g * f64::from(ONE_G)).round() as i32);
        Reading {
            acceleration: I32x3 { x, y: 0, z },
            temperature: 2500,
            ..Reading::default()
        }
    }
}

#[test]
fn repeated_shocks_of_3_g_change_neither_angle_nor_status() {
    // 2 Hz, Butterworth and critically damped
    for kind in [1, 2] {
        let mut rig = quick();
        rig.write(&[fsc::WRITE_FILTER, 0xD0, 0x07, kind]);
        rig.bus
            .device_mut(rig.sensor)
            .set_motion(Box::new(Digging(4.0)));
        rig.run(4000);
        for _ in 0..100 {
            rig.run(17);
            let reply = rig.poll();
            assert_eq!(reply[1], 0, "{reply:02X?}");
            assert!(angle(&reply, 2).abs_diff(3000) <= 1, "{reply:02X?}");
            assert!(angle(&reply, 4).abs_diff(0) <= 1, "{reply:02X?}");
        }
    }
}

/// These shocks do not turn the sensor over.
#[test]
fn repeated_shocks_of_6_g_against_gravity_do_not_change_the_status() {
    let mut rig = quick();
    let device = rig.bus.device_mut(rig.sensor);
    device.set_motion(Box::new(Digging(-6.0)));
    rig.run(100);
    for _ in 0..400 {
        rig.run(7);
        let reply = rig.poll();
        assert_eq!(reply[1], 0, "{reply:02X?}");
    }
}

/// Level, it turns over within a sample.
#[test]
fn overturned_sensor_is_out_of_range_within_120_ms() {
    let mut rig = quick();
    let turned = Reading {
        acceleration: I32x3 {
            x: 0,
            y: 0,
            z: -ONE_G,
        },
        temperature: 2500,
        ..Reading::default()
    };
    let device = rig.bus.device_mut(rig.sensor);
    device.set_motion(Box::new(turned));
    let start = rig.bus.now().ticks();
    while rig.poll()[1] != ERRORS {
        rig.run(1);
    }
    let took = rig.bus.now().ticks() - start;
    println!("the status is out of range only {took} us after the motion");
    assert!((90_000..=120_000).contains(&took), "{took} us");
    rig.power_cycle();
    let boot_up = rig.expect(REPLY, 1000);
    assert_eq!(boot_up.bytes()[1], ERRORS, "no delay at power-up");
}

#[test]
fn accelerometer_clock_error_of_5_percent_has_no_effect() {
    for percent in [-5.0, 5.0] {
        let mut rig = quick();
        let (io, now) = rig.io();
        io.imu.set_clock_deviation(now, percent);
        // The FIFO would be empty, or have too many values, after 20 samples.
        for _ in 0..5 {
            rig.run(100);
            assert_right(&rig.poll());
        }
    }
}

/// SPI and I2C share the pins: a disturbance must not look like a start condition.
#[test]
pub fn i2c_of_the_accelerometer_is_disabled() {
    let mut rig = Rig::booted("is2", BitRate::K500);
    assert!(rig.io().0.imu.i2c_is_disabled());
}

/// 60 ug/sqrt(Hz) behind 2 Hz are 0.005 degrees rms. The digits of 0.014 degrees average out.
#[test]
fn noise_behind_2_hz_is_at_most_0_01_degrees_rms() {
    let rate = [fsc::WRITE_BAUD_RATE, baud_rate_code(RATE)];
    let memory = saved("is2", &[&rate, &[fsc::WRITE_FILTER, 0xD0, 0x07, 1]]);
    let mut rig = Rig::with("is2", BusRate::Fixed(RATE), memory);
    rig.io().0.imu.set_noise(Noise::Real);
    rig.boot_up();
    rig.run(1500);
    let errors: Vec<[f64; 2]> = (0..200)
        .map(|_| {
            rig.run(50);
            let reply = rig.poll();
            assert_eq!(reply[1], 0, "{reply:02X?}");
            [angle(&reply, 2) - 1000, angle(&reply, 4) - 500].map(|error| f64::from(error) / 100.0)
        })
        .collect();
    for axis in [0, 1] {
        let mean = |part: &dyn Fn(f64) -> f64| {
            let sum: f64 = errors.iter().map(|error| part(error[axis])).sum();
            sum / errors.len() as f64
        };
        let (offset, rms) = (mean(&|error| error), mean(&|error| error * error).sqrt());
        println!("axis {axis}: {offset:.4} deg, {rms:.4} deg rms");
        assert!(offset.abs() < 0.003, "axis {axis}: {offset}");
        assert!((0.003..0.01).contains(&rms), "axis {axis}: {rms}");
    }
}
