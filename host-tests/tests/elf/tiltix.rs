//! The images of the TILTIX: messages, stored settings, and the filters with the clock of the accelerometer.

use crate::rig::{blank, image, node_type, tilt};
use bench::{AdapterId, Bus, BusRate, Device, DeviceId, Flash};
use host_tests::rise_time::{FILTERS, Filter, check, rise_time};
use plumbline::can::{Frame, standard};
use plumbline::time::{after, millis};
use stm32_sim::Microcontroller;

/// A sensor at rest that is on-line with its factory MAC ID 63, and a master.
struct Bench {
    bus: Bus,
    sensor: DeviceId,
    master: AdapterId,
}

impl Bench {
    fn new(name: &'static str, x: f64, y: f64) -> Self {
        let mut bus = Bus::new(BusRate::Follow);
        let motion = tilt(name, x, y);
        let sensor = bus.attach(Microcontroller::new(name, image(name), 1, blank(), motion));
        let master = bus.adapter();
        bus.open(master, None, false);
        let mut bench = Self {
            bus,
            sensor,
            master,
        };
        bench.check_duplicate("5FF#00620101000000");
        bench
    }

    /// Both requests of the duplicate MAC ID check.
    fn check_duplicate(&mut self, request: &str) {
        assert_eq!(self.wait(2200), [request, request]);
    }

    /// The frames that the sensor sends within this many milliseconds.
    fn wait(&mut self, ms: u32) -> Vec<String> {
        self.bus.take_received(self.master);
        self.bus.run_until(after(self.bus.now(), millis(ms)));
        let frames = self.bus.take_received(self.master).into_iter();
        frames.map(|(_, frame)| format!("{frame:?}")).collect()
    }

    /// Sends a frame; returns the frames received within 5 ms.
    fn exchange(&mut self, id: u16, bytes: &[u8]) -> Vec<String> {
        let frame = Frame::data(standard(id), bytes).expect("at most eight bytes");
        self.bus.send(self.master, frame);
        self.wait(5)
    }

    /// A request on the explicit connection.
    fn ask(&mut self, request: &[u8]) -> String {
        self.exchange(0x5FC, &[&[0x0A], request].concat()).concat()
    }

    /// Allocates an explicit and a poll connection.
    fn allocate(&mut self) {
        let allocated = self.exchange(0x5FE, &[0x0A, 0x4B, 3, 1, 3, 0x0A]);
        assert_eq!(allocated, ["5FB#0ACB00"]);
        assert_eq!(self.ask(&[0x10, 5, 1, 9, 0, 0]), "5FB#0A900000");
        assert_eq!(self.ask(&[0x10, 5, 2, 9, 0, 0]), "5FB#0A900000");
    }
}

/// The words of the scene, of which the last digit has the tolerance of the sensing element.
fn words(response: &str) -> [i16; 2] {
    let data = response.strip_prefix("3FF#").expect("a poll response");
    let number = u32::from_str_radix(data, 16).expect("four bytes");
    let [a, b, c, d] = number.to_be_bytes();
    [i16::from_le_bytes([a, b]), i16::from_le_bytes([c, d])]
}

#[test]
fn image_answers_poll_and_explicit_requests() {
    let mut bench = Bench::new("tiltix080", 12.34, -5.67);
    assert_eq!(bench.exchange(0x5FD, &[]), [""; 0], "not allocated");
    bench.allocate();
    let [x, y] = words(&bench.exchange(0x5FD, &[]).concat());
    assert!(
        (1232..=1236).contains(&x) && (-569..=-565).contains(&y),
        "{x}, {y}"
    );
    assert_eq!(bench.ask(&[0x0E, 1, 1, 1]), "5FB#0A8E6201");
    assert_eq!(bench.ask(&[0x0E, 0x65, 1, 1]), "5FB#0A8E1600");
    assert_eq!(bench.ask(&[0x10, 0x65, 1, 0x84, 251]), "5FB#0A9409FF");
    assert_eq!(bench.ask(&[0x10, 0x65, 1, 0x81, 101]), "5FB#0A940CFF");
    // The terminal resistor.
    assert_eq!(bench.ask(&[0x10, 0x65, 1, 0x87, 1]), "5FB#0A90");
    let mut bench = Bench::new("tiltix360", 300.0, 0.0);
    bench.allocate();
    let [x, y] = words(&bench.exchange(0x5FD, &[]).concat());
    assert!((29_998..=30_002).contains(&(x as u16)) && y == 0, "{x}");
}

#[test]
fn image_stores_settings_and_changes_its_mac_id() {
    let mut bench = Bench::new("tiltix360", 123.4, 0.0);
    bench.allocate();
    assert_eq!(bench.ask(&[0x10, 0x65, 1, 0x71, 100, 0]), "5FB#0A90");
    assert_eq!(bench.ask(&[0x10, 0x65, 1, 0x73, 2]), "5FB#0A90");
    assert_eq!(bench.ask(&[0x10, 0x65, 1, 0x74, 10, 0]), "5FB#0A90");
    assert_eq!(bench.ask(&[0x10, 0x65, 1, 0x75, 1]), "5FB#0A90");
    assert_eq!(words(&bench.exchange(0x5FD, &[]).concat()), [10, 0]);
    bench.wait(1000);
    bench.bus.power_cycle(bench.sensor);
    bench.check_duplicate("5FF#00620101000000");
    bench.allocate();
    assert_eq!(words(&bench.exchange(0x5FD, &[]).concat()), [10, 0]);
    assert_eq!(bench.ask(&[0x0E, 0x65, 1, 0x75]), "5FB#0A8E00");
    let answer = bench.ask(&[0x10, 3, 1, 1, 3]);
    assert!(answer.starts_with("5FB#0A90"), "{answer}");
    bench.wait(2100);
    bench.bus.power_cycle(bench.sensor);
    bench.check_duplicate("41F#00620101000000");
}

/// The rise time of the image with this clock error of the accelerometer in percent.
fn of_image(filter: Filter, clock: i32) -> f64 {
    rise_time(filter, |bus, motion| {
        let mut sensor = Microcontroller::new("tiltix080", image("tiltix080"), 1, blank(), motion);
        sensor.io_mut().imu.set_clock_deviation(0, clock.into());
        bus.attach(sensor);
    })
}

#[test]
fn rise_times_of_the_image_are_those_of_the_manual_and_of_the_pc() {
    for filter in FILTERS {
        let image = of_image(filter, 0);
        check(filter, image);
        let pc = rise_time(filter, |bus, motion| {
            bus.attach(Device::new(
                &node_type("tiltix080"),
                1,
                Flash::default(),
                motion,
            ));
        });
        assert!((image / pc - 1.0).abs() < 0.02, "{filter:?}: {image}, {pc}");
    }
}

blue_pill_only! {
#[test]
fn rise_times_of_the_image_do_not_depend_on_the_clock_of_the_accelerometer() {
    for clock in [-5, 5] {
        for filter in FILTERS {
            check(filter, of_image(filter, clock));
        }
    }
}
}
