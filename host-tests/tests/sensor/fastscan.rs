//! Two IMS360 with the node-ID 50 on one bus, which differ only in the serial number: LSS fastscan (CiA 305) tells them apart.

use bench::NodeType;
use bench::script::LEVEL;
use bench::{AdapterId, Bus, BusRate, Device, Flash};
use plumbline::can::{BitRate, Frame, standard};
use plumbline::time::{after, millis};

/// Requests of the master, and answers of the sensors.
const REQUEST: u16 = 0x7E5;
const ANSWER: u16 = 0x7E4;

/// The serial numbers of the two nodes.
const SERIALS: [u32; 2] = [0x8000_0005, 4];

/// Vendor, product code and revision number (manual 6.3).
const IDENTITY: [u32; 3] = [0x195, 0x1869F, 0];

struct Master {
    bus: Bus,
    adapter: AdapterId,
}

impl Master {
    /// A bus with both sensors, which have sent their boot-up messages.
    fn new() -> Self {
        let node_type = NodeType::find("ims360").expect("a product");
        let mut bus = Bus::new(BusRate::Wire);
        let adapter = bus.adapter();
        bus.open(adapter, Some(BitRate::K125), false);
        for serial in SERIALS {
            let sensor = Device::new(&node_type, serial, Flash::default(), Box::new(LEVEL));
            bus.attach(sensor);
        }
        let mut master = Self { bus, adapter };
        assert!(!master.wait(100).is_empty(), "no boot-up message");
        master
    }

    fn wait(&mut self, ms: u32) -> Vec<Frame> {
        self.bus.run_until(after(self.bus.now(), millis(ms)));
        let received = self.bus.take_received(self.adapter).into_iter();
        received.map(|(_, frame)| frame).collect()
    }

    fn exchange(&mut self, id: u16, data: &[u8]) -> Vec<Frame> {
        let frame = Frame::data(standard(id), data).expect("at most 8 bytes");
        self.bus.send(self.adapter, frame);
        self.wait(5)
    }

    /// An LSS request; whether a sensor has answered with these first bytes.
    fn lss(&mut self, request: &[u8], answer: &[u8]) -> bool {
        let mut data = [0; 8];
        data[..request.len()].copy_from_slice(request);
        let answers = self.exchange(REQUEST, &data);
        let is_answer =
            |frame: &Frame| frame.id() == standard(ANSWER) && frame.bytes().starts_with(answer);
        answers.iter().any(is_answer)
    }

    /// Stores the configuration; the answer comes when the memory holds it.
    fn store(&mut self) {
        let [request, answer] = [REQUEST, ANSWER].map(standard);
        let bytes = [0x17, 0, 0, 0, 0, 0, 0, 0];
        let frame = Frame::data(request, &bytes).expect("8 bytes");
        self.bus.send(self.adapter, frame);
        let expected = Frame::data(answer, &bytes).expect("8 bytes");
        assert_eq!(self.wait(200), [expected]);
    }

    /// A fastscan request: number, bit to check, number of the identity, next number.
    fn asks(&mut self, number: u32, bit: u8, sub: u8, next: u8) -> bool {
        let [a, b, c, d] = number.to_le_bytes();
        self.lss(&[0x51, a, b, c, d, bit, sub, next], &[0x4F])
    }

    /// The identity of a sensor without a node-ID, which is then in the configuration state; None if there is none.
    fn scan(&mut self) -> Option<[u32; 4]> {
        if !self.asks(0, 128, 0, 0) {
            return None;
        }
        let mut found = [0; 4];
        for (sub, number) in (0..).zip(&mut found) {
            for bit in (0..32).rev() {
                if !self.asks(*number, bit, sub, sub) {
                    *number |= 1 << bit;
                }
            }
            assert!(self.asks(*number, 0, sub, (sub + 1) % 4), "number {sub}");
        }
        Some(found)
    }
}

#[test]
fn two_sensors_with_the_same_node_id_get_different_ones() {
    let mut master = Master::new();
    // Switch state global, no node-ID, waiting, reset communication.
    master.lss(&[0x04, 1], &[]);
    assert!(master.lss(&[0x11, 255], &[0x11, 0]));
    master.lss(&[0x04, 0], &[]);
    assert_eq!(master.exchange(0x000, &[0x82, 0]), []);
    assert_eq!(master.wait(200), [], "no boot-up message");

    // A bit that is 0 answers first, so the lower serial number is found first.
    let [one, two, three] = IDENTITY;
    for (node, serial) in [(51, SERIALS[1]), (52, SERIALS[0])] {
        assert_eq!(master.scan(), Some([one, two, three, serial]));
        assert!(master.lss(&[0x11, node], &[0x11, 0]));
        master.store();
        let mut frames = master.exchange(REQUEST, &[0x04, 0, 0, 0, 0, 0, 0, 0]);
        frames.extend(master.wait(100));
        let boot_up = Frame::data(standard(0x700 + u16::from(node)), &[0]).expect("a byte");
        assert_eq!(frames, [boot_up]);
        // Read 1018h:04.
        let read = master.exchange(0x600 + u16::from(node), &[0x40, 0x18, 0x10, 4, 0, 0, 0, 0]);
        let [a, b, c, d] = serial.to_le_bytes();
        let answer = Frame::data(
            standard(0x580 + u16::from(node)),
            &[0x43, 0x18, 0x10, 4, a, b, c, d],
        );
        assert_eq!(read, [answer.expect("eight bytes")]);
    }
    assert_eq!(master.scan(), None);
}
