//! The recipes in the documents of the products, run against a simulated sensor.
//!
//! A recipe is a text block after a comment with the product, the scene, and `power-up` if it begins with the start of the
//! sensor, or `J1939` if the sensor is in J1939, with its address and without cyclic process data:
//!
//! ````text
//! <!-- recipe: is2, tilt=12.34,-5.67 -->
//! ```text
//! -> 300#00              a frame to the sensor, as cansend takes it
//! <- 301#0003D204C9FD    the next frame of the sensor
//! -- power off and on
//! ```
//! ````
//!
//! A comment can follow the frame. The sensor starts with a blank memory, and the bus has the bit rate of the sensor.

use bench::scene::{Axes, Scene, SceneArgument};
use bench::{AdapterId, Bus, BusRate, Device, DeviceId, Flash, NodeType};
use can_wire::text::parse;
use host_tests::documents::documents;
use plumbline::can::{Frame, standard};
use plumbline::time::{Duration, after, millis, reached};

/// The start of a recipe.
const BEGIN: &str = "<!-- recipe: ";

/// Maximum time until a frame of the sensor: the longest cycle in a recipe is 1 s.
const PATIENCE: Duration = millis(1500);

/// The sensor sends no other frame within this time after an expected frame.
const QUIET: Duration = millis(5);

/// Time for an action without a reply: a restart, a change of the state.
const WITHOUT_REPLY: Duration = millis(300);

/// Maximum time until a sensor is on-line: two seconds of the duplicate MAC ID check of DeviceNet.
const ONLINE: Duration = millis(2200);

struct Run {
    bus: Bus,
    sensor: DeviceId,
    tester: AdapterId,
    received: Vec<Frame>,
}

impl Run {
    fn new(product: &str, scene: &str) -> Self {
        let node_type = NodeType::find(product).expect("a product");
        let scene: SceneArgument = scene.parse().expect("a scene");
        let motion = Scene::open(Some(&scene), Axes::of(&node_type)).expect("a scene");
        let mut bus = Bus::new(BusRate::Follow);
        let sensor = Device::new(&node_type, 1, Flash::default(), Box::new(motion));
        let sensor = bus.attach(sensor);
        let tester = bus.adapter();
        bus.open(tester, None, false);
        Self {
            bus,
            sensor,
            tester,
            received: Vec::new(),
        }
    }

    fn wait(&mut self, time: Duration) {
        let until = after(self.bus.now(), time);
        self.bus.run_until(until);
        let received = self.bus.take_received(self.tester);
        self.received
            .extend(received.into_iter().map(|(_, frame)| frame));
    }

    /// Waits until the sensor is on the bus, also with automatic detection, and drops the frames that it sends after power-up.
    fn boot(&mut self) {
        self.wait(WITHOUT_REPLY);
        let any = Frame::data(standard(0x7FF), &[]).expect("no data");
        self.bus.send(self.tester, any);
        self.wait(ONLINE);
        self.received.clear();
    }

    /// Selects J1939 and waits until the sensor has its address. The next DM1 comes a second later.
    fn select_j1939(&mut self) -> Result<(), String> {
        let without_reply = "000#8132";
        let requests = [
            "632#2B04210100000000",
            "632#2F00310101000000",
            "632#2310100173617665",
            without_reply,
        ];
        for text in requests {
            self.bus.send(self.tester, parse(text)?);
            if text != without_reply && self.next().is_none() {
                return Err("no reply to the selection of J1939".to_owned());
            }
        }
        // The claim, and the first DM1.
        self.next();
        self.next();
        self.is_quiet()
    }

    /// The next frame of the sensor.
    fn next(&mut self) -> Option<Frame> {
        let until = after(self.bus.now(), PATIENCE);
        while self.received.is_empty() && !reached(self.bus.now(), until) {
            self.wait(millis(1));
        }
        (!self.received.is_empty()).then(|| self.received.remove(0))
    }

    fn step(&mut self, line: &str) -> Result<(), String> {
        let (what, rest) = line.split_at_checked(2).ok_or("the line is too short")?;
        let text = rest.split_whitespace().next().unwrap_or("");
        match what {
            "->" => {
                self.is_quiet()?;
                self.bus.send(self.tester, parse(text)?);
            }
            "<-" => {
                let expected = parse(text)?;
                let received = self.next();
                if received != Some(expected) {
                    return Err(format!("received {received:?}"));
                }
            }
            "--" => {
                self.is_quiet()?;
                self.bus.power_cycle(self.sensor);
            }
            _ => return Err("a line begins with ->, <- or --".to_owned()),
        }
        Ok(())
    }

    /// The sensor has sent no frame that is not in the recipe.
    fn is_quiet(&mut self) -> Result<(), String> {
        self.wait(QUIET);
        match self.received.first() {
            None => Ok(()),
            Some(frame) => Err(format!("received {frame:?} before this line")),
        }
    }
}

/// Runs the lines of a recipe.
fn run(heading: &str, recipe: &str) -> Result<(), String> {
    let (heading, powers_up) = match heading.strip_suffix(", power-up") {
        Some(rest) => (rest, true),
        None => (heading, false),
    };
    let (heading, in_j1939) = match heading.strip_suffix(", J1939") {
        Some(rest) => (rest, true),
        None => (heading, false),
    };
    let (product, scene) = heading.split_once(", ").ok_or("the scene is missing")?;
    let mut run = Run::new(product, scene);
    if !powers_up {
        run.boot();
    }
    if in_j1939 {
        run.select_j1939()?;
    }
    let lines: Vec<&str> = recipe.lines().collect();
    for (place, line) in lines.iter().enumerate() {
        run.step(line).map_err(|error| format!("{line}\n{error}"))?;
        let answered = lines
            .get(place + 1)
            .is_some_and(|next| next.starts_with("<-"));
        if !answered && !line.starts_with("<-") {
            run.wait(WITHOUT_REPLY);
        }
    }
    run.is_quiet()
}

#[test]
fn sensor_sends_the_frames_of_the_recipes() {
    let mut count = 0;
    let mut failures = Vec::new();
    for document in documents().expect("the documents can be read") {
        for part in document.text.split(BEGIN).skip(1) {
            let (heading, rest) = part.split_once(" -->\n```text\n").expect("a text block");
            let (recipe, _) = rest.split_once("```").expect("the end of the block");
            count += 1;
            if let Err(error) = run(heading, recipe) {
                failures.push(format!("{}: {heading}: {error}", document.path.display()));
            }
        }
    }
    assert!(failures.is_empty(), "{}", failures.join("\n\n"));
    assert!(count > 0, "there are no recipes");
}
