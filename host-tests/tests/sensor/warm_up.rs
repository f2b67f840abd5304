//! Warm-up of GEMAC's reference line: AccuracyWarning over minutes, in scenes with a temperature (manual 9.3 and 9.5.2).

use bench::motion::Motion;
use bench::scene::{Axes, Scene};
use bench::script::frame;
use bench::{AdapterId, Bus, BusRate, Device, DeviceId, Flash, NodeType, Sensor};
use host_tests::effort;
use plumbline::can::BitRate;
use plumbline::time::{Instant, after, millis};
use std::path::Path;
use std::rc::Rc;
use stm32_sim::Microcontroller;
use stm32_sim::board::Board;
use stm32_sim::elf::Image;

/// Bit 6 of the status byte (tables 14 and 15).
const ACCURACY_WARNING: u8 = 0x40;

/// The accuracy in the manual applies after this time at 25 degC (table 1, footnote 1), in s.
const RUNNING_TIME: u64 = 600;

/// A sensor on a bus with a tester.
struct Bench {
    bus: Bus,
    device: DeviceId,
    tester: AdapterId,
}

impl Bench {
    /// A sensor that has booted in this scene.
    fn new(model: &str, motion: Box<dyn Motion>) -> Self {
        let node_type = NodeType::find(model).expect("a product");
        Self::of(Device::new(&node_type, 1, Flash::default(), motion))
    }

    /// The same with the image.
    fn of_image(model: &str, motion: Box<dyn Motion>) -> Self {
        let node_type = NodeType::find(model).expect("a product");
        let images = stm32_sim::firmware::build(Board::BluePill, &[node_type.name])
            .unwrap_or_else(|error| panic!("{error}"));
        let elf = std::fs::read(&images[node_type.name]).expect("the image can be read");
        let image = Rc::new(Image::parse(&elf).expect("an image"));
        let flash = Flash::default();
        Self::of(Microcontroller::of_type(
            &node_type, image, 1, flash, motion,
        ))
    }

    fn of(sensor: impl Sensor) -> Self {
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
    fn boot(&mut self) {
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
    fn reset(&mut self) -> bool {
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
    fn warns(&mut self) -> bool {
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
    fn warning_becomes(&mut self, warning: bool) -> u64 {
        let limit = self.seconds() + RUNNING_TIME;
        while self.warns() != warning {
            assert!(self.seconds() < limit, "the warning is still {}", !warning);
            self.bus.run_until(after(self.bus.now(), millis(1000)));
        }
        self.seconds()
    }

    fn seconds(&self) -> u64 {
        self.bus.now().ticks() / 1_000_000
    }

    /// The warning stays cleared until this time in s.
    fn stays_accurate(&mut self, until: u64) {
        while self.seconds() < until {
            assert!(!self.warns(), "at {} s", self.seconds());
            self.bus.run_until(after(self.bus.now(), millis(1000)));
        }
    }
}

/// A recording at rest with these times in s and temperatures in degC.
fn recording(name: &str, rows: &[(u64, f64)]) -> Box<dyn Motion> {
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    let rows = rows.iter().map(|(seconds, temperature)| {
        // Level for two axes; one axis is in its range with Y up.
        format!("{seconds},0,0.5,0.8660254,0,0,0,{temperature}\n")
    });
    let header = "t_s,ax_g,ay_g,az_g,gx_dps,gy_dps,gz_dps,temp_c\n".to_owned();
    std::fs::write(&path, header + &rows.collect::<String>()).expect("a file for the scene");
    Box::new(Scene::recording(&path).expect("a recording"))
}

#[test]
fn warning_without_a_temperature_in_the_scene_is_cleared_within_minutes() {
    for (model, axes) in [
        ("is1tk", Axes::One),
        ("is2tk", Axes::Two),
        ("is1dm", Axes::One),
        ("is2dm", Axes::Two),
    ] {
        let scene = Scene::tilt(10.0, 5.0, axes).expect("a valid attitude");
        let mut bench = Bench::new(model, Box::new(scene));
        let seconds = bench.warning_becomes(false);
        println!("{model} from 25 degC: {seconds} s");
        assert!((60..RUNNING_TIME).contains(&seconds), "{seconds}");
        bench.stays_accurate(seconds + 300);
    }
}

/// G32: neither the warning nor the temperature see the restart.
#[test]
fn warning_stays_cleared_over_a_reset() {
    for temperature in [-40.0, 25.0, 80.0] {
        let name = format!("reset-{temperature}.csv");
        let mut bench = Bench::new("is2tk", recording(&name, &[(0, temperature)]));
        let seconds = bench.warning_becomes(false);
        bench.stays_accurate(seconds + 300);
        for round in 1..=3 {
            assert!(!bench.reset(), "{temperature} degC");
            bench.stays_accurate(seconds + 300 + 120 * round);
        }
    }
}

#[test]
#[ignore = "takes minutes of simulated time: `.ci/long ignored`"]
fn warning_of_the_image_is_cleared_within_minutes_and_stays_cleared_over_a_reset() {
    let mut bench = Bench::of_image("is2tk", recording("reset-image.csv", &[(0, 50.0)]));
    let seconds = bench.warning_becomes(false);
    assert!((60..RUNNING_TIME).contains(&seconds), "{seconds}");
    let again = effort::choose(5, 30);
    bench.stays_accurate(seconds + again);
    assert!(!bench.reset());
    bench.stays_accurate(seconds + 2 * again);
    // The memory is lost with the power.
    let now = bench.bus.now();
    bench.bus.device_mut(bench.device).power_off(now);
    bench.bus.run_until(after(now, millis(100)));
    let now = bench.bus.now();
    bench.bus.device_mut(bench.device).power_on(now);
    bench.boot();
    assert!(bench.warns());
}

#[test]
fn warning_after_a_cold_start_follows_the_temperature() {
    let rows = [
        (0, -20.0),
        (900, -20.0),
        // Hotter than the set point: the heater cannot cool.
        (960, 90.0),
        (1500, 90.0),
        (1560, 20.0),
    ];
    let mut bench = Bench::new("is2tk", recording("cold-start.csv", &rows));
    let seconds = bench.warning_becomes(false);
    println!("from -20 degC: {seconds} s");
    assert!((120..RUNNING_TIME).contains(&seconds), "{seconds}");
    bench.stays_accurate(900);
    let hot = bench.warning_becomes(true);
    assert!((901..1500).contains(&hot), "{hot}");
    bench.bus.run_until(Instant::from_ticks(1_500_000_000));
    let again = bench.warning_becomes(false);
    assert!((1501..1500 + RUNNING_TIME).contains(&again), "{again}");
    bench.stays_accurate(again + 300);
}

/// "Independent of the operation temperature" (9.3): -40 to +80 degC (table 1).
#[test]
fn warning_is_cleared_at_every_operating_temperature() {
    for temperature in [-40.0, -10.0, 50.0, 80.0] {
        let name = format!("operating-{temperature}.csv");
        let mut bench = Bench::new("is2tk", recording(&name, &[(0, temperature)]));
        let seconds = bench.warning_becomes(false);
        println!("from {temperature} degC: {seconds} s");
        bench.stays_accurate(seconds + 300);
    }
}

#[test]
fn warning_after_a_power_cut_is_set_until_the_temperature_is_stable() {
    let mut bench = Bench::new("is2tk", recording("power-cut.csv", &[(0, 25.0)]));
    bench.warning_becomes(false);
    let cut = bench.bus.now();
    let device = bench.bus.device_mut(bench.device);
    device.power_off(cut);
    bench.bus.run_until(after(cut, millis(5000)));
    let on = bench.bus.now();
    bench.bus.device_mut(bench.device).power_on(on);
    let started = bench.seconds();
    bench.boot();
    let again = bench.warning_becomes(false) - started;
    println!("after 5 s without power: {again} s");
    assert!((30..RUNNING_TIME).contains(&again), "{again}");
}

#[test]
fn product_without_a_heater_never_sets_the_warning() {
    let rows = [(0, -20.0), (60, 82.0)];
    let node_type = NodeType::find("is2").expect("a product");
    assert_eq!(node_type.cell, None);
    let mut bus = Bus::new(BusRate::Fixed(BitRate::K250));
    let scene = recording("unheated.csv", &rows);
    bus.attach(Device::new(&node_type, 1, Flash::default(), scene));
    let tester = bus.adapter();
    bus.open(tester, None, false);
    bus.lead_detection();
    bus.run_until(after(bus.now(), millis(160)));
    for second in 0..120 {
        bus.send(tester, frame(0x300, &[0x02]));
        bus.run_until(after(bus.now(), millis(1000)));
        let frames = bus.take_received(tester);
        assert!(!frames.is_empty());
        for (_, frame) in frames {
            assert_eq!(frame.bytes()[1], 0x03, "at {second} s");
        }
    }
}
