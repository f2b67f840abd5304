//! Gyroscope and supply, with the program that checks them on a board (`firmware-stm32/src/bin/sensing.rs`).

use crate::rig::{blank, chip, part};
use bench::motion::Motion;
use bench::{AdapterId, Bus, BusRate, DeviceId};
use plumbline::can::{BitRate, Frame, standard};
use plumbline::measure::{I32x3, ONE_G, Reading};
use plumbline::time::{Duration, Instant, after};
use std::f64::consts::PI;
use stm32_sim::Microcontroller;

/// 1 deg/s in the unit of a reading.
const UNIT: f64 = 65_536.0;

/// Turns about X from 0 to 90 deg within this time, from this time on, in s: at 471 deg/s at most within 0.3 s.
#[derive(Clone, Copy)]
struct Turn {
    start: f64,
    length: f64,
}

impl Turn {
    fn angle(self, time: f64) -> f64 {
        let part = ((time - self.start) / self.length).clamp(0.0, 1.0);
        45.0 * (1.0 - (PI * part).cos())
    }
}

impl Motion for Turn {
    fn reading(&mut self, now: Instant) -> Reading {
        let time = now.ticks() as f64 / 1e6;
        let rate = (self.angle(time + 1e-6) - self.angle(time - 1e-6)) / 2e-6;
        let (sine, cosine) = self.angle(time).to_radians().sin_cos();
        Reading {
            acceleration: I32x3 {
                x: 0,
                y: (sine * f64::from(ONE_G)) as i32,
                z: (cosine * f64::from(ONE_G)) as i32,
            },
            angular_rate: I32x3 {
                x: (rate * UNIT) as i32,
                y: 0,
                z: 0,
            },
            temperature: 2500,
            clipped: false,
        }
    }
}

/// At rest, with this supply in mV.
fn still(supply: u16) -> Box<dyn Motion> {
    let reading = Turn {
        start: 1.0,
        length: 1.0,
    }
    .reading(Instant::from_ticks(0));
    Box::new((reading, supply))
}

/// The program and a tester on a bus with 250 kbit/s.
struct Bench {
    bus: Bus,
    sensor: DeviceId,
    tester: AdapterId,
}

impl Bench {
    /// In operational, at 0.2 s.
    fn new(motion: Box<dyn Motion>, prepare: impl FnOnce(&mut Microcontroller)) -> Self {
        let mut bus = Bus::new(BusRate::Fixed(BitRate::K250));
        let mut microcontroller = part("sensing", 1, blank(), motion);
        prepare(&mut microcontroller);
        let sensor = bus.attach(microcontroller);
        let tester = bus.adapter();
        bus.open(tester, None, false);
        let mut bench = Self {
            bus,
            sensor,
            tester,
        };
        bench.run_until(180_000);
        bench.send(0x000, &[1, 1]);
        bench.run_until(200_000);
        bench.bus.take_received(tester);
        bench
    }

    fn send(&mut self, id: u16, data: &[u8]) {
        let frame = Frame::data(standard(id), data).expect("at most eight bytes");
        self.bus.send(self.tester, frame);
    }

    fn run_until(&mut self, us: u64) {
        self.bus.run_until(Instant::from_ticks(us));
    }

    fn seconds(&self) -> f64 {
        self.bus.now().ticks() as f64 / 1e6
    }

    /// Rotation in deg, angular rate in deg/s and supply in V, by SYNC and TPDO.
    fn measure(&mut self) -> [f64; 3] {
        self.send(0x080, &[]);
        self.bus
            .run_until(after(self.bus.now(), Duration::from_ticks(900)));
        let received = self.bus.take_received(self.tester);
        let [(_, frame)] = received.as_slice() else {
            panic!("{received:?}")
        };
        assert_eq!(frame.id(), standard(0x181));
        let &[r0, r1, r2, r3, w0, w1, s0, s1] = frame.bytes() else {
            panic!("{frame:?}")
        };
        let rotation = i32::from_le_bytes([r0, r1, r2, r3]);
        let rate = i16::from_le_bytes([w0, w1]);
        let supply = u16::from_le_bytes([s0, s1]);
        [
            f64::from(rotation) / 1000.0,
            f64::from(rate) / 10.0,
            f64::from(supply) / 100.0,
        ]
    }

    fn chip(&mut self) -> &mut Microcontroller {
        Microcontroller::of_mut(self.bus.device_mut(self.sensor))
            .expect("a simulated microcontroller")
    }
}

impl Drop for Bench {
    fn drop(&mut self) {
        if !std::thread::panicking() {
            assert_eq!(self.chip().violations(), [""; 0], "{:?}", chip());
        }
    }
}

/// The sum of the rates is the rotation, with each error of the clock of the gyroscope. A value is published 3 to 4.5 ms after its time,
/// and stays for a sampling period.
#[test]
fn rotation_is_exact_and_late_by_at_most_10_5_ms() {
    let turn = Turn {
        start: 6.0,
        length: 0.3,
    };
    for percent in [-5.0, 0.0, 5.0] {
        let mut bench = Bench::new(Box::new(turn), |microcontroller| {
            let imu = &mut microcontroller.io_mut().imu;
            imu.set_clock_deviation(0, percent);
        });
        bench.run_until(5_990_000);
        let [start, ..] = bench.measure();
        let mut lags = Vec::new();
        // Four steps are 0.12 ms longer than the sampling period: each phase is measured to 0.12 ms.
        for step in 10..90 {
            bench.run_until(6_000_000 + step * 2_530);
            let time = bench.seconds();
            let [rotation, ..] = bench.measure();
            let slope = (turn.angle(time) - turn.angle(time - 1e-6)) / 1e-6;
            lags.push((turn.angle(time) - (rotation - start)) / slope);
        }
        let worst = lags.iter().copied().fold(f64::MIN, f64::max);
        let least = lags.iter().copied().fold(f64::MAX, f64::min);
        println!("{percent} %: {:.2} to {:.2} ms", least * 1e3, worst * 1e3);
        assert!(worst < 10.5e-3, "{percent} %: {worst}");
        assert!(least < 4.5e-3 + 0.12e-3, "{percent} %: {least}");
        bench.run_until(6_400_000);
        let [rotation, rate, _] = bench.measure();
        let error = rotation - start - 90.0;
        println!("{percent} %: {error:.3} deg");
        assert!(error.abs() < 0.05, "{percent} %: {error}");
        assert!(rate.abs() < 0.11, "{rate}");
    }
}

#[test]
fn mean_rate_is_the_rate() {
    // 45 deg / 10 s * pi / 2 in the middle.
    let turn = Turn {
        start: -4.5,
        length: 10.0,
    };
    let mut bench = Bench::new(Box::new(turn), |_| {});
    bench.run_until(500_000);
    let [_, rate, _] = bench.measure();
    assert!((rate - 14.1).abs() < 0.11, "{rate}");
}

/// 12.7 mV for a count of the converter.
#[test]
pub fn supply_is_measured_within_13_mv() {
    for millivolts in [0_u16, 7_990, 24_000, 36_010, 50_000] {
        let mut bench = Bench::new(still(millivolts), |_| {});
        let [_, _, volts] = bench.measure();
        let error = f64::from(millivolts) / 1000.0 - volts;
        assert!((-0.001..0.024).contains(&error), "{millivolts}: {volts}");
        let device = bench.bus.device_mut(bench.sensor);
        device.set_motion(still(12_000));
        bench.run_until(220_000);
        let [_, _, volts] = bench.measure();
        assert!((11.97..=12.0).contains(&volts), "{volts}");
    }
}

#[test]
fn supply_is_measured_without_accelerometer() {
    let mut bench = Bench::new(still(30_000), |microcontroller| {
        microcontroller.io_mut().imu.unmount();
    });
    let [_, _, volts] = bench.measure();
    assert!((29.97..=30.0).contains(&volts), "{volts}");
}
