//! The TILTIX: its rise time with the clock of the accelerometer, and its terminating resistor.

use crate::rig::{blank, part, tilt};
use bench::{AdapterId, Bus, BusRate, DeviceId};
use host_tests::effort;
use host_tests::rise_time::{FILTERS, Filter, check, rise_time};
use plumbline::can::{Frame, standard};
use plumbline::time::{after, millis};
use stm32_sim::Microcontroller;

/// A sensor at rest that is on-line with its factory MAC ID 63, and a master.
pub struct Bench {
    pub bus: Bus,
    pub sensor: DeviceId,
    pub master: AdapterId,
}

impl Bench {
    pub fn new(name: &'static str, x: f64, y: f64) -> Self {
        let mut bus = Bus::new(BusRate::Follow);
        let motion = tilt(name, x, y);
        let sensor = bus.attach(part(name, 1, blank(), motion));
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

    fn chip(&self) -> &Microcontroller {
        Microcontroller::of(self.bus.device(self.sensor)).expect("a simulated microcontroller")
    }

    /// Both requests of the duplicate MAC ID check.
    pub fn check_duplicate(&mut self, request: &str) {
        assert_eq!(self.wait(2200), [request, request]);
    }

    /// The frames that the sensor sends within this many milliseconds.
    pub fn wait(&mut self, ms: u32) -> Vec<String> {
        self.bus.take_received(self.master);
        self.bus.run_until(after(self.bus.now(), millis(ms)));
        let frames = self.bus.take_received(self.master).into_iter();
        frames.map(|(_, frame)| format!("{frame:?}")).collect()
    }

    /// Sends a frame; returns the frames received within 5 ms.
    pub fn exchange(&mut self, id: u16, bytes: &[u8]) -> Vec<String> {
        let frame = Frame::data(standard(id), bytes).expect("at most eight bytes");
        self.bus.send(self.master, frame);
        self.wait(5)
    }

    /// A request on the explicit connection.
    pub fn ask(&mut self, request: &[u8]) -> String {
        self.exchange(0x5FC, &[&[0x0A], request].concat()).concat()
    }

    /// Allocates an explicit and a poll connection.
    pub fn allocate(&mut self) {
        let allocated = self.exchange(0x5FE, &[0x0A, 0x4B, 3, 1, 3, 0x0A]);
        assert_eq!(allocated, ["5FB#0ACB00"]);
        assert_eq!(self.ask(&[0x10, 5, 1, 9, 0, 0]), "5FB#0A900000");
        assert_eq!(self.ask(&[0x10, 5, 2, 9, 0, 0]), "5FB#0A900000");
    }
}

/// The rise time of the image with this clock error of the accelerometer in percent.
fn of_image(filter: Filter, clock: i32) -> f64 {
    rise_time(filter, |bus, motion| {
        let mut sensor = part("tiltix080", 1, blank(), motion);
        sensor.io_mut().imu.set_clock_deviation(0, clock.into());
        bus.attach(sensor);
    })
}

#[test]
fn rise_time_of_the_image_does_not_depend_on_the_clock_of_the_accelerometer() {
    for clock in [-5, 5] {
        for filter in effort::choose(&FILTERS[1..2], &FILTERS) {
            check(*filter, of_image(*filter, clock));
        }
    }
}

/// 3.5 and 5.1.2: attribute 87h switches the resistor, which works only while the sensor has power.
#[test]
fn terminating_resistor_follows_its_attribute_and_is_off_without_power() {
    let mut bench = Bench::new("tiltix080", 0.0, 0.0);
    bench.allocate();
    assert!(!bench.chip().terminated(), "off at the factory");
    for on in [true, false, true] {
        let set = [0x10, 0x65, 1, 0x87, on.into()];
        assert_eq!(bench.ask(&set), "5FB#0A90");
        assert_eq!(bench.chip().terminated(), on);
    }
    // The attribute is stored within a second.
    bench.wait(1000);
    let now = bench.bus.now();
    bench.bus.device_mut(bench.sensor).power_off(now);
    assert!(!bench.chip().terminated());
    bench.bus.power_cycle(bench.sensor);
    bench.wait(500);
    assert!(bench.chip().terminated(), "stored");
}
