//! A simulated bus with sensors, the program, and a witness that listens.

use bench::motion::Motion;
use bench::{AdapterId, Bus, BusRate, Device, DeviceId, Flash, Geometry, NodeType};
use clap::Parser;
use plumbline::can::{BitRate, Frame};
use plumbline::measure::{I32x3, ONE_G, Reading};
use plumbline::time::{after, millis};
use plumbline_tool::adapter::bench::{BenchAdapter, SharedBus};
use plumbline_tool::cli::Cli;
use plumbline_tool::command::run_with;
use plumbline_tool::output::Terminal;
use serde_json::Value;
use std::cell::RefCell;
use std::rc::Rc;

/// All products, one of each family with one axis and with two.
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

/// A position in which every angle of every product is within its range: X = 10 deg, Y = 5 deg of a 2-axis GEMAC sensor.
pub fn tilted() -> Box<dyn Motion> {
    let (gx, gy) = (10_f64.to_radians().sin(), 5_f64.to_radians().sin());
    let up = [-gx, gy, (1.0 - gx * gx - gy * gy).sqrt()];
    let [x, y, z] = up.map(|part| (part * f64::from(ONE_G)).round() as i32);
    Box::new(Reading {
        acceleration: I32x3 { x, y, z },
        temperature: 25_00,
        ..Reading::default()
    })
}

/// A bus.
pub struct Rig {
    pub bus: SharedBus,
    witness: AdapterId,
    devices: Vec<DeviceId>,
    /// Whether questions are answered with yes.
    pub says_yes: bool,
    /// The questions that were asked.
    pub questions: Vec<String>,
}

/// The end of a run of the program.
#[derive(Debug)]
pub struct Ended {
    pub code: u8,
    pub out: String,
    pub notes: String,
}

impl Rig {
    /// An empty bus.
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
            devices: Vec::new(),
            says_yes: false,
            questions: Vec::new(),
        }
    }

    /// A bus with one sensor as delivered, which is on-line.
    pub fn with(product: &str) -> Self {
        let mut rig = Self::new(BusRate::Follow);
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
        let device = Device::new(node_type, serial, flash, tilted());
        let id = self.bus.borrow_mut().attach(device);
        self.devices.push(id);
        id
    }

    /// The first sensor.
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
        self.bus.borrow_mut().open(other, None, false);
        self.run(3000);
        self.bus.borrow_mut().remove(other);
    }

    /// The frames that the witness has seen since the last call.
    pub fn witnessed(&mut self) -> Vec<Frame> {
        let mut bus = self.bus.borrow_mut();
        let frames = bus.take_received(self.witness);
        frames.into_iter().map(|(_, frame)| frame).collect()
    }

    /// Opens the witness at a rate.
    pub fn listen(&mut self, rate: BitRate) {
        self.bus.borrow_mut().open(self.witness, Some(rate), true);
    }

    /// Runs the program with these arguments.
    pub fn tool(&mut self, arguments: &str) -> Ended {
        let words: Vec<&str> = arguments.split_whitespace().collect();
        self.tool_with(&words)
    }

    /// Runs the program with these arguments, which can have spaces.
    pub fn tool_with(&mut self, arguments: &[&str]) -> Ended {
        let all = ["plumbline", "--port", "bench"].iter().chain(arguments);
        let cli = Cli::try_parse_from(all).unwrap_or_else(|error| panic!("{error}"));
        let (mut out, mut notes) = (Vec::new(), Vec::new());
        let (says_yes, questions) = (self.says_yes, &mut self.questions);
        let mut confirm = |question: &str| {
            questions.push(question.to_owned());
            says_yes
        };
        let mut terminal = Terminal {
            json: cli.options.json,
            out: &mut out,
            notes: &mut notes,
            confirm: &mut confirm,
            stopped: &|| false,
        };
        let bus = self.bus.clone();
        let mut connect = |_: &str| Ok(Box::new(BenchAdapter::new(&bus)) as Box<_>);
        let result = run_with(&cli, &mut terminal, &mut connect);
        let mut ended = Ended {
            code: 0,
            out: String::from_utf8(out).expect("UTF-8"),
            notes: String::from_utf8(notes).expect("UTF-8"),
        };
        if let Err(failure) = result {
            ended.code = failure.kind.exit_code();
            if cli.options.json {
                ended.out.push_str(&failure.json().to_string());
            } else {
                ended.notes.push_str(&failure.message);
            }
        }
        ended
    }

    /// Runs the program, which must succeed, and returns its document.
    #[track_caller]
    pub fn json(&mut self, arguments: &str) -> Value {
        let ended = self.tool(&format!("--json {arguments}"));
        assert_eq!(ended.code, 0, "{arguments}: {ended:?}");
        serde_json::from_str(&ended.out).unwrap_or_else(|error| panic!("{error}: {}", ended.out))
    }

    /// Runs the program, which must succeed.
    #[track_caller]
    pub fn done(&mut self, arguments: &str) -> String {
        let ended = self.tool(arguments);
        assert_eq!(ended.code, 0, "{arguments}: {ended:?}");
        ended.out
    }

    /// Runs the program, which must fail, and returns its exit code and the code of the error.
    #[track_caller]
    pub fn fails(&mut self, arguments: &str) -> (u8, String) {
        let ended = self.tool(&format!("--json {arguments}"));
        let document: Value =
            serde_json::from_str(&ended.out).unwrap_or_else(|error| panic!("{error}: {ended:?}"));
        let code = document["error"]["code"]
            .as_str()
            .expect("a code")
            .to_owned();
        let message = document["error"]["message"].as_str().expect("a message");
        assert!(
            message.len() > 20,
            "the message names the next step: {message}"
        );
        (ended.code, code)
    }
}
