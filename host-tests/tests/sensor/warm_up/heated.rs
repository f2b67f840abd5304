//! A sensor with a heater on a bus, and scenes with a temperature.

use bench::motion::Motion;
use bench::scene::Scene;
use bench::script::frame;
use bench::{AdapterId, Bus, BusRate, Device, DeviceId, Flash, NodeType, Sensor};
use plumbline::can::BitRate;
use plumbline::time::{after, millis};
use std::path::Path;

/// Bit 6 of the status byte (tables 14 and 15).
pub const ACCURACY_WARNING: u8 = 0x40;

/// The accuracy in the manual applies after this time at 25 degC (table 1, footnote 1), in s.
pub const RUNNING_TIME: u64 = 600;

/// A sensor on a bus with a tester.
pub struct Bench {
    pub bus: Bus,
    pub device: DeviceId,
    tester: AdapterId,
}

impl Bench {
    /// A sensor that has booted in this scene.
    pub fn new(model: &str, motion: Box<dyn Motion>) -> Self {
        let node_type = NodeType::find(model).expect("a product");
        Self::of(Device::new(&node_type, 1, Flash::default(), motion))
    }

    /// The same with this sensor.
    pub fn of(sensor: impl Sensor) -> Self {
        let mut bus = Bus::new(BusRate::Fixed(BitRate::K250));
        let device = bus.attach(sensor);
        let tester = bus.adapter();
        bus.open(tester, None, false);
        let mut bench = Self {
            bus,
            device,
            tester,
        };
        bench.boot();
        bench
    }

    /// Sends the first frame on the bus and checks that AccuracyWarning is set in the two boot-up messages.
    pub fn boot(&mut self) {
        self.bus.run_until(after(self.bus.now(), millis(200)));
        self.bus.lead_detection();
        self.bus.run_until(after(self.bus.now(), millis(60)));
        self.bus.send(self.tester, frame(0x7FE, &[]));
        self.bus.run_until(after(self.bus.now(), millis(10)));
        let boot_up: Vec<_> = self.bus.take_received(self.tester);
        assert_eq!(boot_up.len(), 2);
        for (_, frame) in boot_up {
            assert_eq!(frame.bytes()[1] & ACCURACY_WARNING, ACCURACY_WARNING);
        }
    }

    /// RESET; the first frame on the bus follows within 300 ms. Returns whether AccuracyWarning is set in the boot-up messages.
    pub fn reset(&mut self) -> bool {
        self.bus.send(self.tester, frame(0x300, b"\xFFRESET"));
        self.bus.run_until(after(self.bus.now(), millis(300)));
        self.bus.send(self.tester, frame(0x7FE, &[]));
        self.bus.run_until(after(self.bus.now(), millis(10)));
        let boot_up = self.bus.take_received(self.tester);
        assert_eq!(boot_up.len(), 2, "{boot_up:?}");
        boot_up
            .iter()
            .any(|(_, frame)| frame.bytes()[1] & ACCURACY_WARNING != 0)
    }

    /// Whether AccuracyWarning is set in the status.
    pub fn warns(&mut self) -> bool {
        self.bus.send(self.tester, frame(0x300, &[0x02]));
        self.bus.run_until(after(self.bus.now(), millis(5)));
        let [(_, reply)] = self.bus.take_received(self.tester)[..] else {
            panic!("one reply");
        };
        let status = reply.bytes()[1];
        assert_eq!(status & !ACCURACY_WARNING, 0x03, "no other bit is set");
        status & ACCURACY_WARNING != 0
    }

    /// Polls once a second until the warning is set or cleared; returns the seconds since power-up.
    pub fn warning_becomes(&mut self, warning: bool) -> u64 {
        let limit = self.seconds() + RUNNING_TIME;
        while self.warns() != warning {
            assert!(self.seconds() < limit, "the warning is still {}", !warning);
            self.bus.run_until(after(self.bus.now(), millis(1000)));
        }
        self.seconds()
    }

    pub fn seconds(&self) -> u64 {
        self.bus.now().ticks() / 1_000_000
    }

    /// The warning stays cleared until this time in s.
    pub fn stays_accurate(&mut self, until: u64) {
        while self.seconds() < until {
            assert!(!self.warns(), "at {} s", self.seconds());
            self.bus.run_until(after(self.bus.now(), millis(1000)));
        }
    }
}

/// A recording at rest with these times in s and temperatures in degC.
pub fn recording(name: &str, rows: &[(u64, f64)]) -> Box<dyn Motion> {
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    let rows = rows.iter().map(|(seconds, temperature)| {
        // Level for two axes; one axis is in its range with Y up.
        format!("{seconds},0,0.5,0.8660254,0,0,0,{temperature}\n")
    });
    let header = "t_s,ax_g,ay_g,az_g,gx_dps,gy_dps,gz_dps,temp_c\n".to_owned();
    std::fs::write(&path, header + &rows.collect::<String>()).expect("a file for the scene");
    Box::new(Scene::recording(&path).expect("a recording"))
}
