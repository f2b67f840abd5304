//! The accelerometer fails, recovers, clips, starts late, or has a clock error; and several sensors on one bus.

use crate::rig::*;
use bench::{Bus, BusRate, Device, Flash};
use plumbline::can::BitRate;
use plumbline::measure::{I32x3, ONE_G, Reading};
use plumbline::time::Instant;
use stm32_sim::Microcontroller;
use stm32_sim::ism330dhcx::Fault;

const RATE: BitRate = BitRate::K500;

/// All sensor error bits of each product.
const ERRORS: [(&str, u8); 2] = [
    ("is1", status::SENSOR_ERROR_X),
    ("is2", status::SENSOR_ERROR_X | status::SENSOR_ERROR_Y),
];

fn angle(reply: &[u8], at: usize) -> i16 {
    i16::from_le_bytes([reply[at], reply[at + 1]])
}

/// The reply to a poll has no error and 10 degrees, with two axes also 5 degrees. A count of the accelerometer is 0.0035 degrees.
#[track_caller]
fn assert_right(reply: &[u8]) {
    assert_eq!(reply[1], 0, "{reply:02X?}");
    assert!(angle(reply, 2).abs_diff(1000) <= 1, "{reply:02X?}");
    if reply.len() > 4 {
        assert!(angle(reply, 4).abs_diff(500) <= 1, "{reply:02X?}");
    }
}

#[test]
fn accelerometer_failure_is_reported_within_200_ms_and_cleared_after_recovery() {
    for (name, errors) in ERRORS {
        for fault in [Fault::Silent(0xFF), Fault::Silent(0), Fault::Stopped] {
            let mut rig = Rig::booted(name, RATE);
            rig.run(2_000);
            assert_right(&rig.poll());
            let (io, now) = rig.io();
            io.imu.set_fault(now, fault);
            // No sample for 100 ms (core/src/model/gemac/README.md, G19).
            rig.run(90);
            assert_right(&rig.poll());
            rig.run(110);
            assert_eq!(rig.poll()[1], errors, "{name}, {fault:?}");
            let (io, now) = rig.io();
            io.imu.set_fault(now, Fault::None);
            rig.run(4_000);
            assert_right(&rig.poll());
        }
    }
}

#[test]
fn accelerometer_that_starts_late_is_used() {
    for (name, errors) in ERRORS {
        let mut rig = Rig::with(name, BusRate::Fixed(RATE), fixed(name, RATE));
        rig.io().0.imu.unmount();
        rig.boot_up();
        assert_eq!(rig.poll()[1], errors);
        rig.run(700);
        let (io, now) = rig.io();
        io.imu.power_on(now);
        rig.run(4_000);
        assert_right(&rig.poll());
    }
}

#[test]
fn clipping_sets_the_sensor_error_for_100_ms() {
    for (name, errors) in ERRORS {
        let mut rig = Rig::booted(name, RATE);
        rig.run(2_000);
        let up = if name == "is1" {
            I32x3 {
                x: 0,
                y: 3 * ONE_G,
                z: 0,
            }
        } else {
            I32x3 {
                x: 0,
                y: 0,
                z: 3 * ONE_G,
            }
        };
        let shock = Reading {
            acceleration: up,
            angular_rate: I32x3 { x: 0, y: 0, z: 0 },
            temperature: 2500,
            clipped: true,
        };
        let device = rig.bus.device_mut(rig.sensor);
        device.set_motion(Box::new(shock));
        rig.run(60);
        assert_eq!(rig.poll()[1], errors, "{name}");
        let device = rig.bus.device_mut(rig.sensor);
        device.set_motion(tilt(name, 10.0, 5.0));
        rig.run(80);
        assert_eq!(rig.poll()[1], errors, "{name}: the error is held");
        rig.run(2_500);
        assert_right(&rig.poll());
    }
}

#[test]
fn accelerometer_clock_error_of_5_percent_has_no_effect() {
    for name in MODELS {
        for percent in [-5.0, 5.0] {
            let mut rig = Rig::booted(name, RATE);
            let (io, now) = rig.io();
            io.imu.set_clock_deviation(now, percent);
            for _ in 0..30 {
                rig.run(100);
                assert_eq!(rig.poll()[1], 0);
            }
            assert_right(&rig.poll());
        }
    }
}

/// A memory with the Set-Parameter-ID 300h + `set` and the next identifier as Reply-Parameter-ID.
fn numbered(save: fn(&str, &[&[u8]]) -> Flash, set: u8) -> Flash {
    let rate = [fsc::WRITE_BAUD_RATE, baud_rate_code(RATE)];
    save(
        "is2",
        &[&[0x21, set + 1, 3, 0, 0], &[0x20, set, 3, 0, 0], &rate],
    )
}

#[test]
fn three_sensors_work_on_one_bus() {
    let mut bus = Bus::new(BusRate::Wire);
    let microcontrollers =
        [0x10, 0x20].map(|set| bus.attach(microcontroller("is2", numbered(saved, set))));
    let host = Device::new(
        &node_type("is2"),
        SERIAL,
        numbered(saved_on_pc, 0x30),
        tilt("is2", 10.0, 5.0),
    );
    bus.attach(host);
    let tester = bus.adapter();
    bus.open(tester, Some(RATE), false);
    bus.run_until(Instant::from_ticks(300_000));
    let boot_ups = bus.take_received(tester);
    assert_eq!(boot_ups.len(), 6, "{boot_ups:?}");
    for round in 0..20 {
        bus.send(tester, data(SYNC, &[]));
        bus.run_until(Instant::from_ticks(300_000 + (round + 1) * 10_137));
        let answers = bus.take_received(tester);
        let ids: Vec<_> = answers.iter().map(|(_, frame)| frame.id()).collect();
        let expected = [0x311, 0x321, 0x331].map(plumbline::can::standard);
        assert_eq!(ids.len(), 3);
        assert!(expected.iter().all(|id| ids.contains(id)), "{ids:?}");
        for (_, frame) in answers {
            assert_right(frame.bytes());
        }
    }
    for id in microcontrollers {
        let microcontroller =
            Microcontroller::of(bus.device(id)).expect("a simulated microcontroller");
        check(microcontroller);
        assert_eq!(microcontroller.resets().len(), 1);
        assert_eq!(bus.device(id).error_counters(), Some((0, 0)));
    }
}

/// SPI and I2C share the pins: a disturbance must not look like a start condition.
#[test]
fn i2c_of_the_accelerometer_is_disabled() {
    let mut rig = Rig::booted("is2", BitRate::K500);
    assert!(rig.io().0.imu.i2c_is_disabled());
}
