//! Two JN2101 with different node-IDs on one bus, one built for the PC and one with the image: each answers only its own
//! requests.

use bench::NodeType;
use bench::script::LEVEL;
use bench::{AdapterId, Bus, BusRate, Device, DeviceId, Flash};
use plumbline::can::{BitRate, Frame, standard};
use plumbline::time::{after, millis};
use std::rc::Rc;
use stm32_sim::Microcontroller;
use stm32_sim::board::Board;
use stm32_sim::elf::Image;

struct Wire {
    bus: Bus,
    tester: AdapterId,
}

impl Wire {
    fn new() -> Self {
        let mut bus = Bus::new(BusRate::Wire);
        let tester = bus.adapter();
        bus.open(tester, Some(BitRate::K125), false);
        Self { bus, tester }
    }

    /// The frames received within this many milliseconds, sorted by identifier.
    fn wait(&mut self, ms: u32) -> Vec<String> {
        self.bus.run_until(after(self.bus.now(), millis(ms)));
        let frames = self.bus.take_received(self.tester).into_iter();
        let mut texts: Vec<String> = frames.map(|(_, frame)| format!("{frame:?}")).collect();
        texts.sort();
        texts
    }

    fn exchange(&mut self, id: u16, data: &[u8]) -> Vec<String> {
        let frame = Frame::data(standard(id), data).expect("at most 8 bytes");
        self.bus.send(self.tester, frame);
        self.wait(20)
    }
}

/// Attaches the sensor built for the PC.
fn first(wire: &mut Wire) -> DeviceId {
    let node_type = NodeType::find("jn2101").expect("a product");
    let device = Device::new(&node_type, 1, Flash::default(), Box::new(LEVEL));
    wire.bus.attach(device)
}

/// Attaches a simulated microcontroller with the image.
fn second(wire: &mut Wire) -> DeviceId {
    let board = Board::BluePill;
    let node_type = NodeType::find("jn2101").expect("a product");
    let images =
        stm32_sim::firmware::build(board, &["jn2101"]).unwrap_or_else(|error| panic!("{error}"));
    let elf = std::fs::read(&images["jn2101"]).expect("the image can be read");
    let image = Rc::new(Image::parse(&elf).expect("an image"));
    let motion = Box::new(LEVEL);
    let memory = Flash::blank(board.chip().facts().geometry);
    let sensor = Microcontroller::of_type(&node_type, image, 2, memory, motion).quiet();
    wire.bus.attach(sensor)
}

#[test]
fn each_of_two_nodes_answers_only_its_own_requests() {
    let mut wire = Wire::new();
    let one = first(&mut wire);
    assert_eq!(wire.wait(70), ["70A#00"]);
    // Write the node-ID 11 and save it; it is in force after "reset node".
    let written = wire.exchange(0x60A, &[0x2F, 0x00, 0x20, 0, 11, 0, 0, 0]);
    assert_eq!(written, ["58A#6000200000000000"]);
    let saved = wire.exchange(0x60A, &[0x23, 0x10, 0x10, 1, b's', b'a', b'v', b'e']);
    assert_eq!(saved, ["58A#6010100100000000"]);
    assert_eq!(wire.exchange(0x000, &[0x81, 10]), ["70B#00"]);

    let two = second(&mut wire);
    assert_eq!(wire.wait(300), ["70A#00"]);

    // Read 1018h:04, the serial number, from each.
    let read = [0x40, 0x18, 0x10, 4, 0, 0, 0, 0];
    assert_eq!(wire.exchange(0x60B, &read), ["58B#4318100401000000"]);
    assert_eq!(wire.exchange(0x60A, &read), ["58A#4318100402000000"]);

    // Only the node that is operational answers the SYNC.
    let (ten, eleven) = ("18A#00000000", "18B#00000000");
    assert_eq!(wire.exchange(0x000, &[0x01, 11]), [""; 0]);
    let answers = wire.exchange(0x080, &[]);
    assert!(answers.iter().any(|text| text == eleven), "{answers:?}");
    assert!(!answers.iter().any(|text| text == ten), "{answers:?}");

    // Node-ID 0 starts both.
    assert_eq!(wire.exchange(0x000, &[0x01, 0]), [""; 0]);
    let answers = wire.exchange(0x080, &[]);
    for wanted in [ten, eleven] {
        assert!(answers.iter().any(|text| text == wanted), "{answers:?}");
    }
    for sensor in [one, two] {
        let sensor = wire.bus.device(sensor);
        assert_eq!(sensor.error_counters(), Some((0, 0)), "{}", sensor.boots());
    }
}
