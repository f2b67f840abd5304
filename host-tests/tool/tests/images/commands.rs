//! The commands against the images that are flashed, on the simulated microcontroller.
//!
//! Each image is found, changed, stored, backed up, restored and zeroed as a user does it. The microcontroller then reports no
//! violation of its reference manual.

use crate::rig::{Rig, file, tilt, tilted};
use bench::scene::{Axes, Scene};
use bench::stage::Stage;
use bench::{Bus, BusRate, DeviceId, Flash};
use plumbline::can::BitRate;
use plumbline::model::catalog::find;
use serde_json::{Value, json};
use std::any::Any;
use std::collections::BTreeMap;
use std::path::Path;
use std::rc::Rc;
use std::sync::OnceLock;
use stm32_sim::Microcontroller;
use stm32_sim::board::Board;
use stm32_sim::elf::Image;
use stm32_sim::firmware;

/// The serial number of the sensor.
const SERIAL: u32 = 7;

/// The bit rate of the bus: the sensors have it as delivered, or detect it.
const RATE: BitRate = BitRate::K125;

/// What a test does with a sensor.
struct Case {
    product: &'static str,
    /// What `scan` shows as its protocol and address.
    protocol: &'static str,
    address: &'static str,
    /// The options that address it, and the options that address it when the factory values are in force.
    options: &'static str,
    factory: &'static str,
    /// A change of a setting, its name, and the number that is read afterwards.
    change: (&'static str, &'static str, u32),
    /// The names of the angles.
    angles: &'static [&'static str],
}

/// The products whose images are used.
const PRODUCTS: [&str; 5] = ["is1", "is2", "jn2101", "ims360", "tiltix080"];

/// The ELF file of a product for the Blue Pill.
fn elf(product: &str) -> &'static [u8] {
    static FILES: OnceLock<BTreeMap<String, Vec<u8>>> = OnceLock::new();
    let files = FILES.get_or_init(|| {
        let built = firmware::build(Board::BluePill, &PRODUCTS);
        let built = built.unwrap_or_else(|error| panic!("{error}"));
        let read = |path| std::fs::read(path).expect("the image can be read");
        let files = built.into_iter();
        files.map(|(name, path)| (name, read(path))).collect()
    });
    files.get(product).expect("an image of this name")
}

/// Connects a microcontroller with the image of a product as delivered.
fn attach(rig: &mut Rig, product: &str) -> DeviceId {
    let image = Rc::new(Image::parse(elf(product)).expect("an ELF file"));
    let name = find(product).expect("a product").name;
    let flash = Flash::blank(Board::BluePill.chip().facts().geometry);
    rig.attach_sensor(Microcontroller::new(name, image, SERIAL, flash, tilted()).quiet())
}

impl Case {
    /// A bus with the image as delivered, after its start.
    fn start(&self) -> Rig {
        let mut rig = Rig::new(BusRate::Fixed(RATE));
        (rig.rate, rig.says_yes) = (Some("125"), true);
        attach(&mut rig, self.product);
        self.boot(&mut rig);
        rig
    }

    /// Waits for the start of the sensor. Another node acknowledges its messages.
    fn boot(&self, rig: &mut Rig) {
        let other = rig.bus.borrow_mut().adapter();
        rig.bus.borrow_mut().open(other, None, false);
        rig.run(match self.protocol {
            "devicenet" => 2300,
            "j1939" => 600,
            _ => 200,
        });
        rig.bus.borrow_mut().remove(other);
    }

    fn power_cycle(&self, rig: &mut Rig) {
        // The sensor has stored what it stores by itself.
        rig.run(1100);
        let id = rig.first();
        rig.bus.borrow_mut().power_cycle(id);
        self.boot(rig);
    }

    fn json(&self, rig: &mut Rig, command: &str) -> Value {
        rig.json(&format!("{} {command}", self.options))
    }

    /// The raw number of the changed setting.
    fn setting(&self, rig: &mut Rig, options: &str) -> Value {
        let (_, name, _) = self.change;
        rig.json(&format!("{options} get {name}"))[name]["raw"].clone()
    }

    /// All steps, from `scan` to `zero`.
    fn run(&self) {
        let mut rig = self.start();
        if self.protocol == "j1939" {
            rig.json("--node 50 set can-protocol=raw:1 --save");
            rig.json("--node 50 restart");
            self.boot(&mut rig);
        }
        self.is_found(&mut rig);
        let factory = self.setting(&mut rig, self.options);
        self.is_changed(&mut rig);
        let [one, two] = [1, 2].map(|number| {
            file(&format!(
                "image-{}-{}-{number}.toml",
                self.product, self.protocol
            ))
        });
        self.json(&mut rig, &format!("backup {}", one.display()));
        self.json(&mut rig, "load-factory");
        self.power_cycle(&mut rig);
        assert_eq!(
            self.setting(&mut rig, self.factory),
            factory,
            "{}",
            self.product
        );
        self.is_restored(&mut rig, &one, &two);
        self.is_watched(&mut rig);
        self.is_examined(&mut rig);
        self.is_replaced(&mut rig);
        self.is_zeroed(&mut rig);
        check(&rig);
    }

    fn is_found(&self, rig: &mut Rig) {
        let rows = rig.json("--rate 125 scan --active");
        let [row] = &rows.as_array().expect("a list")[..] else {
            panic!("{rows}");
        };
        for (key, value) in [
            ("rate", json!(125)),
            ("protocol", json!(self.protocol)),
            ("product", json!(self.product)),
            ("address", json!(self.address)),
            ("serial", json!(SERIAL)),
        ] {
            assert_eq!(row[key], value, "{row}");
        }
    }

    /// The setting is written, read back and stored.
    fn is_changed(&self, rig: &mut Rig) {
        let (assignment, _, raw) = self.change;
        self.json(rig, &format!("set {assignment} --save"));
        self.power_cycle(rig);
        assert_eq!(
            self.setting(rig, self.options),
            json!(raw),
            "{}",
            self.product
        );
    }

    fn is_restored(&self, rig: &mut Rig, one: &Path, two: &Path) {
        let restored = rig.json(&format!("{} restore {}", self.factory, one.display()));
        let differences = restored.as_object().expect("a list").len();
        assert_eq!(
            differences,
            if self.protocol == "j1939" { 2 } else { 1 },
            "{restored}"
        );
        self.power_cycle(rig);
        self.json(rig, &format!("backup {}", two.display()));
        let read = |path: &Path| std::fs::read_to_string(path).expect("a file");
        assert_eq!(read(one), read(two), "{}", self.product);
    }

    fn is_watched(&self, rig: &mut Rig) {
        let line = format!("{} --json watch --every 20 --seconds 0.2", self.options);
        let out = rig.done(&line);
        let lines: Vec<&str> = out.lines().collect();
        assert!((9..=11).contains(&lines.len()), "{out}");
        for line in lines {
            let sample: Value = serde_json::from_str(line).expect("a document");
            for name in self.angles {
                let angle = sample[name].as_f64().expect("a number");
                assert!(angle.abs() > 1.0, "{sample}");
            }
        }
    }

    fn is_examined(&self, rig: &mut Rig) {
        let line = format!("--rate 125 {} doctor --seconds 0.5 --active", self.options);
        let ended = rig.tool(&format!("--json {line}"));
        let document: Value = serde_json::from_str(&ended.out).expect("a document");
        // A sensor in J1939 broadcasts its angles, and is alone.
        let expected = match self.protocol {
            "j1939" => json!("nobody-acknowledges"),
            _ => Value::Null,
        };
        assert_eq!(document["findings"][0]["code"], expected, "{document}");
        let sensor = document["sensors"][0].as_str().expect("a sensor");
        assert!(sensor.contains(self.product), "{document}");
        let usage = document["usage"].as_array().expect("a list").len();
        assert_eq!(usage, usize::from(self.product != "ims360"), "{document}");
    }

    /// The sensor takes its own place.
    fn is_replaced(&self, rig: &mut Rig) {
        let path = file(&format!(
            "image-{}-{}-old.toml",
            self.product, self.protocol
        ));
        let path = path.display();
        if self.product == "is1" {
            let upright = Scene::tilt(30.0, 0.0, Axes::One).expect("valid angles");
            let upright = Stage::new(upright, &[]);
            let id = rig.first();
            rig.bus
                .borrow_mut()
                .device_mut(id)
                .set_motion(Box::new(upright));
            rig.run(3000);
        }
        self.json(rig, &format!("replace read {path}"));
        let document = self.json(rig, &format!("replace write {path}"));
        let angles = document["angles"].as_array().map(Vec::len);
        assert_eq!(angles, Some(self.angles.len()), "{document}");
    }

    fn is_zeroed(&self, rig: &mut Rig) {
        self.json(rig, "zero");
        rig.run(50);
        let read = self.json(rig, &format!("get {}", self.angles.join(" ")));
        for name in self.angles {
            let angle = read[name]["value"].as_f64().expect("a number");
            assert!(
                angle.abs() < 0.1 || angle > 359.9,
                "{} {read}",
                self.product
            );
        }
    }
}

/// Checks that the microcontroller reports no violation of its reference manual, and that the stack is within its limit.
fn check(rig: &Rig) {
    let bus = rig.bus.borrow();
    let sensor: &dyn Any = bus.device(rig.first());
    let microcontroller: &Microcontroller = sensor.downcast_ref().expect("a microcontroller");
    let violations = microcontroller.violations();
    assert!(violations.is_empty(), "{}", violations.join("\n"));
    let limit = microcontroller.image().stack_limit();
    assert!(microcontroller.lowest_stack() >= limit);
}

#[test]
#[ignore = "needs the image of a further product: `.ci/long ignored`"]
fn image_of_is1_is_found_set_backed_up_restored_and_zeroed() {
    Case {
        product: "is1",
        protocol: "fsc",
        address: "300",
        options: "--id 300",
        factory: "--id 300",
        change: ("cyclic-time=0.1s", "cyclic-time", 100),
        angles: &["angle"],
    }
    .run();
}

#[test]
#[ignore = "needs the image of a further product: `.ci/long ignored`"]
fn image_of_is2_is_found_set_backed_up_restored_and_zeroed() {
    Case {
        product: "is2",
        protocol: "fsc",
        address: "300",
        options: "--id 300",
        factory: "--id 300",
        change: ("cyclic-time=0.1s", "cyclic-time", 100),
        angles: &["angle-x", "angle-y"],
    }
    .run();
}

#[test]
fn image_of_jn2101_is_found_set_backed_up_restored_and_zeroed() {
    Case {
        product: "jn2101",
        protocol: "canopen",
        address: "10",
        options: "--node 10",
        factory: "--node 10",
        change: ("resolution=raw:100", "resolution", 100),
        angles: &["slope-long32", "slope-lateral32"],
    }
    .run();
}

#[test]
#[ignore = "needs the image of a further product: `.ci/long ignored`"]
fn image_of_ims360_is_found_set_backed_up_restored_and_zeroed() {
    Case {
        product: "ims360",
        protocol: "canopen",
        address: "50",
        options: "--node 50",
        factory: "--node 50",
        change: ("cut-off=2.5Hz", "cut-off", 2500),
        angles: &["slope-long32", "slope-lateral32"],
    }
    .run();
}

#[test]
#[ignore = "needs the image of a further product: `.ci/long ignored`"]
fn image_of_ims360_in_j1939_is_found_set_backed_up_restored_and_zeroed() {
    Case {
        product: "ims360",
        protocol: "j1939",
        address: "128",
        options: "--address 128",
        factory: "--node 50",
        change: ("cut-off=2.5Hz", "cut-off", 2500),
        angles: &["slope-long32", "slope-lateral32"],
    }
    .run();
}

#[test]
#[ignore = "needs the image of a further product: `.ci/long ignored`"]
fn image_of_tiltix_is_found_set_backed_up_restored_and_zeroed() {
    Case {
        product: "tiltix080",
        protocol: "devicenet",
        address: "63",
        options: "--mac 63",
        factory: "--mac 63",
        change: ("size-of=50", "size-of-moving-average-filter", 50),
        angles: &["slope-long16", "slope-lateral16"],
    }
    .run();
}

/// The second sensor is aligned afterwards: a mounting of X = 1 deg, Y = -0.5 deg on a surface of X = 2 deg, Y = 1.5 deg.
#[test]
#[ignore = "needs the image of a further product: `.ci/long ignored`"]
fn images_of_two_products_are_commissioned_and_aligned() {
    let mut rig = Rig::new(BusRate::Fixed(RATE));
    rig.says_yes = true;
    let [_, id] = ["jn2101", "is2"].map(|product| attach(&mut rig, product));
    let folder = tempfile::tempdir().expect("a folder");
    rig.config = Some(folder.path().to_owned());
    let plan = folder.path().join("plan.toml");
    let text = "[[sensor]]\nname = \"left\"\nproduct = \"jn2101\"\nzero = true\nparameters.node-id = 11\n\
        [[sensor]]\nname = \"boom\"\nproduct = \"is2\"\nparameters.set-id = \"310h\"\nparameters.reply-id = \"311h\"\n";
    std::fs::write(&plan, text).expect("a file");
    let document = rig.json(&format!("commission {}", plan.display()));
    let address = |place: usize| document["sensors"][place]["address"].clone();
    assert_eq!([address(0), address(1)], ["node-ID 11", "identifier 310h"]);
    rig.bus
        .borrow_mut()
        .device_mut(id)
        .set_motion(tilt(3.0, 1.0));
    rig.run(3000);
    let turn = move |bus: &mut Bus| bus.device_mut(id).set_motion(tilt(-1.0, -2.0));
    rig.events.push((rig.later(4500), Rc::new(turn)));
    let aligned = rig.json("--rate 125 --id 310 align --save");
    for (place, mounting) in [(0, 1.0), (1, -0.5)] {
        let angle = &aligned["angles"][place];
        let wrong = angle["mounting"].as_f64().expect("a number") - mounting;
        assert!(wrong.abs() < 0.06, "{aligned}");
    }
    check(&rig);
}

/// The sensor restarts in some ms, and sends its first message at the new rate. An adapter at the old rate brings the sensor to bus-off.
#[test]
fn images_restart_with_another_bit_rate() {
    for (product, address, old, new) in [
        ("is1", "--id 300", BitRate::K250, "800"),
        ("is2", "--id 300", BitRate::K20, "1000"),
        ("jn2101", "--node 10", BitRate::K125, "800"),
    ] {
        let mut rig = Rig::new(BusRate::Wire);
        rig.says_yes = true;
        attach(&mut rig, product);
        rig.listen(old);
        rig.run(100);
        rig.bus.borrow_mut().assist(true);
        rig.run(3000);
        let rate = old.bits_per_second() / 1000;
        let out = rig.done(&format!("--rate {rate} {address} rate {new}"));
        assert!(out.contains("now, and stored"), "{product} {out}");
        rig.done(&format!("--rate {new} {address} get"));
        check(&rig);
    }
}
