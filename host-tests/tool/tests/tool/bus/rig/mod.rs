//! A simulated bus with sensors, the program, and a witness that listens.

mod adapter;
pub mod run;

use ::adapter::Mode;
use ::adapter::bench::SharedBus;
use ::adapter::unread::Unread;
use adapter::{Altered, Event};
use bench::motion::Motion;
use bench::scene::{Axes, Scene};
use bench::stage::Stage;
use bench::{AdapterId, Bus, BusRate, Device, DeviceId, Flash, Geometry, NodeType, Sensor};
use plumbline::can::{BitRate, Frame};
use plumbline::measure::{I32x3, ONE_G, Reading};
use plumbline::time::{Instant, after, millis};
use plumbline_tool::output::Bar;
use std::cell::RefCell;
use std::path::PathBuf;
use std::rc::Rc;

/// The products with a setting of their own in these tests.
pub const PRODUCTS: [&str; 12] = [
    "is1",
    "is2",
    "is1d",
    "is2d",
    "is1dm",
    "is2dm",
    "is1tk",
    "is2tk",
    "jn2101",
    "ims360",
    "tiltix080",
    "tiltix360",
];

/// A position in which every angle of every product is within its range.
pub fn tilted() -> Box<dyn Motion> {
    tilt(10.0, 5.0)
}

/// A position with these perpendicular angles of a 2-axis GEMAC sensor in degrees.
pub fn tilt(x: f64, y: f64) -> Box<dyn Motion> {
    let (gx, gy) = (x.to_radians().sin(), y.to_radians().sin());
    let up = [-gx, gy, (1.0 - gx * gx - gy * gy).sqrt()];
    let [x, y, z] = up.map(|part| (part * f64::from(ONE_G)).round() as i32);
    Box::new(Reading {
        acceleration: I32x3 { x, y, z },
        temperature: 25_00,
        ..Reading::default()
    })
}

/// About the same position of a product, with this fault of the accelerometer.
pub fn broken(product: &str, fault: &str) -> Box<dyn Motion> {
    let node_type = NodeType::find(product).expect("a product");
    let scene = Scene::tilt(10.0, 5.0, Axes::of(&node_type)).expect("valid angles");
    let fault = format!("accelerometer={fault}").parse().expect("a fault");
    Box::new(Stage::new(scene, &[fault]))
}

/// The path of a file for a test. A file of an earlier run is removed.
pub fn file(name: &str) -> PathBuf {
    let path = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(name);
    let _ = std::fs::remove_file(&path);
    path
}

/// A simulated bus with sensors, and the tool at it.
pub struct Rig {
    pub bus: SharedBus,
    witness: AdapterId,
    /// The rate of the wire, if it has one.
    rate_of_bus: Option<BitRate>,
    devices: Vec<DeviceId>,
    /// Whether questions are answered with yes.
    pub says_yes: bool,
    /// Only the questions that contain this text are answered with yes.
    pub yes_to: Option<&'static str>,
    /// The questions that were asked, and when.
    pub questions: Vec<String>,
    pub asked_at: Vec<Instant>,
    /// The rate for commands that do not say it and are no scans.
    pub rate: Option<&'static str>,
    /// The adapter fails after this number of requests.
    pub cut: Option<usize>,
    /// The folder with the names of sensors and the last command; None: an empty one for each command.
    pub config: Option<PathBuf>,
    /// The adapter does not have this rate.
    pub refused: Option<BitRate>,
    /// The adapter refuses every rate.
    pub refuses_all: bool,
    /// Another device sends this frame with this cycle in ms, as long as the tool runs.
    pub cyclic: Option<(u32, Frame)>,
    /// The adapter loses the frames that come between these times.
    pub deaf: Option<(Instant, Instant)>,
    /// The adapter loses the frames of the tool for which this is true.
    pub lost: fn(&Frame) -> bool,
    /// The adapter changes the frames that come between two times.
    pub altered: Option<Altered>,
    /// They happen on the bus at their times while the tool runs, the earliest first.
    pub events: Vec<Event>,
    /// The frames that the adapter says it has lost.
    pub overruns: Option<u64>,
    /// The lines of the adapter that the tool cannot read.
    pub unread: Unread,
    /// The adapter has no listen-only mode.
    pub only_active: bool,
    /// The modes in which the adapter was opened.
    pub modes: Rc<RefCell<Vec<Mode>>>,
    /// The adapter is an interface with this rate, which the tool cannot set.
    pub interface: Option<BitRate>,
    /// The adapter needs this time in ms to open.
    pub opening: u32,
    /// Ctrl-C is pressed after this number of checks for it.
    pub stop: Option<u32>,
    /// The progress bar of the next command.
    pub bar: Option<Box<dyn Bar>>,
}

impl Rig {
    pub fn new(rate: BusRate) -> Self {
        let mut bus = Bus::new(rate);
        let witness = bus.adapter();
        let witness_rate = match rate {
            BusRate::Fixed(rate) => Some(rate),
            _ => None,
        };
        bus.open(witness, witness_rate, true);
        Self {
            bus: Rc::new(RefCell::new(bus)),
            witness,
            rate_of_bus: witness_rate,
            devices: Vec::new(),
            says_yes: false,
            yes_to: None,
            questions: Vec::new(),
            asked_at: Vec::new(),
            rate: None,
            cut: None,
            config: None,
            refused: None,
            refuses_all: false,
            cyclic: None,
            deaf: None,
            lost: |_| false,
            altered: None,
            events: Vec::new(),
            overruns: None,
            unread: Unread::default(),
            only_active: false,
            modes: Rc::default(),
            interface: None,
            opening: 0,
            stop: None,
            bar: None,
        }
    }

    /// A bus with one sensor as delivered, which is on-line.
    pub fn with(product: &str) -> Self {
        let mut rig = Self::new(BusRate::Follow);
        rig.rate = Some("250");
        rig.says_yes = true;
        rig.attach(product, 1);
        let other = rig.bus.borrow_mut().adapter();
        rig.bus.borrow_mut().open(other, None, false);
        rig.run(3000);
        rig.bus.borrow_mut().remove(other);
        rig.witnessed();
        rig
    }

    /// Adds a sensor and switches it on.
    pub fn attach(&mut self, product: &str, serial: u32) -> DeviceId {
        let node_type = NodeType::find(product).expect("a product");
        self.attach_type(&node_type, serial)
    }

    /// Adds a sensor of a type and switches it on.
    pub fn attach_type(&mut self, node_type: &NodeType, serial: u32) -> DeviceId {
        let flash = Flash::blank(Geometry::STM32F103);
        self.attach_sensor(Device::new(node_type, serial, flash, tilted()))
    }

    /// Adds a sensor of any kind and switches it on.
    pub fn attach_sensor(&mut self, sensor: impl Sensor) -> DeviceId {
        let id = self.bus.borrow_mut().attach(sensor);
        self.devices.push(id);
        id
    }

    /// The sensor that was attached first.
    pub fn first(&self) -> DeviceId {
        self.devices[0]
    }

    /// Runs the bus for some milliseconds.
    pub fn run(&mut self, time: u32) {
        let mut bus = self.bus.borrow_mut();
        let until = after(bus.now(), millis(time));
        bus.run_until(until);
    }

    /// Switches a sensor off and on; it is on-line again some time later.
    pub fn power_cycle(&mut self, id: DeviceId) {
        self.bus.borrow_mut().power_cycle(id);
        let other = self.bus.borrow_mut().adapter();
        let rate = self.rate_of_bus;
        self.bus.borrow_mut().open(other, rate, false);
        self.run(3000);
        self.bus.borrow_mut().remove(other);
    }

    /// The present time, and some milliseconds.
    pub fn later(&self, time: u32) -> Instant {
        after(self.bus.borrow().now(), millis(time))
    }

    /// Lets the sensor be switched off and on while the tool runs, at this time.
    pub fn power_cycle_at(&mut self, at: Instant, id: DeviceId) {
        let happens = move |bus: &mut Bus| bus.power_cycle(id);
        self.events.push((at, Rc::new(happens)));
    }

    /// The frames that the witness has seen since the last call.
    pub fn witnessed(&mut self) -> Vec<Frame> {
        let frames = self.witnessed_at().into_iter();
        frames.map(|(_, frame)| frame).collect()
    }

    /// The same with the times of their reception.
    pub fn witnessed_at(&mut self) -> Vec<(Instant, Frame)> {
        self.bus.borrow_mut().take_received(self.witness)
    }

    /// Opens the witness at a rate.
    pub fn listen(&mut self, rate: BitRate) {
        self.rate_of_bus = Some(rate);
        self.bus.borrow_mut().open(self.witness, Some(rate), true);
    }
}
