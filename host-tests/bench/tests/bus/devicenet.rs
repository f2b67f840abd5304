//! DeviceNet nodes on the simulated wire: a lone node, two nodes with the same MAC ID, two masters, bus-off.

use bench::{AdapterId, Bus, BusRate, Device, DeviceId, Flash, NodeType, Source};
use plumbline::can::{BitRate, Frame, standard};
use plumbline::measure::Reading;
use plumbline::time::{after, millis};

/// The MAC ID as delivered.
const FACTORY: u16 = 63;

struct Wire {
    bus: Bus,
    master: AdapterId,
}

impl Wire {
    /// A wire whose master takes part only if it is `open`.
    fn new(open: bool) -> Self {
        let mut bus = Bus::new(BusRate::Wire);
        let master = bus.adapter();
        if open {
            bus.open(master, Some(BitRate::K125), false);
        }
        Self { bus, master }
    }

    fn attach(&mut self, serial: u32) -> DeviceId {
        let node_type = NodeType::find("tiltix080").expect("a product");
        let motion = Box::new(Reading::default());
        let device = Device::new(&node_type, serial, Flash::default(), motion);
        self.bus.attach(device)
    }

    /// The frames received within this many milliseconds.
    fn wait(&mut self, ms: u32) -> Vec<String> {
        self.bus.run_until(after(self.bus.now(), millis(ms)));
        let frames = self.bus.take_received(self.master).into_iter();
        frames.map(|(_, frame)| format!("{frame:?}")).collect()
    }

    /// Queues a message of group 2 to the factory MAC ID.
    fn queue(&mut self, message: u16, data: &[u8]) {
        let frame = Frame::data(standard(0x5F8 | message), data);
        self.bus.send(self.master, frame.expect("at most 8 bytes"));
    }

    /// The frames received within 20 ms after this message of group 2.
    fn send(&mut self, mac: u16, message: u16, data: &[u8]) -> Vec<String> {
        let id = standard(0x400 | mac << 3 | message);
        let frame = Frame::data(id, data).expect("at most 8 bytes");
        self.bus.send(self.master, frame);
        self.wait(20)
    }

    /// Whether a node with this MAC ID is on-line: it refuses to release what is not allocated.
    fn is_online(&mut self, mac: u16) -> bool {
        !self.send(mac, 6, &[0x0A, 0x4C, 3, 1, 1]).is_empty()
    }

    /// Allocates an explicit connection that does not time out.
    fn connect(&mut self, mac: u16) {
        self.send(mac, 6, &[0x0A, 0x4B, 3, 1, 1, 0x0A]);
        let response = self.send(mac, 4, &[0x0A, 0x10, 5, 1, 9, 0, 0]);
        assert_eq!(response.len(), 1);
    }
}

#[test]
fn lone_node_is_online_two_seconds_after_the_first_acknowledge() {
    let mut wire = Wire::new(false);
    wire.attach(1);
    wire.wait(5000);
    wire.bus.open(wire.master, Some(BitRate::K125), false);
    let request = "5FF#00620101000000";
    assert_eq!(wire.wait(990), [request]);
    assert_eq!(wire.wait(20), [request]);
    wire.wait(970);
    assert!(!wire.is_online(FACTORY));
    wire.wait(20);
    assert!(wire.is_online(FACTORY));
}

#[test]
fn node_with_a_taken_mac_id_stays_silent() {
    let mut wire = Wire::new(true);
    wire.attach(1);
    wire.wait(2100);
    wire.connect(FACTORY);
    wire.attach(2);
    // The request of the second node and the response of the first one, which goes on.
    let sent = wire.wait(3000);
    assert_eq!(sent, ["5FF#00620102000000", "5FF#80620101000000"]);
    let serial = wire.send(FACTORY, 4, &[0x0A, 0x0E, 1, 1, 6]);
    assert_eq!(serial, ["5FB#0A8E01000000"]);
}

#[test]
fn nodes_with_one_mac_id_at_one_time_are_never_both_online() {
    let mut wire = Wire::new(true);
    wire.attach(1);
    wire.attach(2);
    wire.wait(5000);
    let answers = wire.send(FACTORY, 6, &[0x0A, 0x4C, 3, 1, 1]);
    assert!(answers.len() <= 1, "{answers:?}");
}

#[test]
fn change_to_a_taken_mac_id_silences_only_the_changed_node() {
    let mut wire = Wire::new(true);
    wire.attach(1);
    wire.wait(2100);
    wire.connect(FACTORY);
    let sent = wire.send(FACTORY, 4, &[0x0A, 0x10, 3, 1, 1, 5]);
    assert_eq!(sent, ["5FB#0A90", "42F#00620101000000"]);
    wire.wait(2100);
    wire.connect(5);
    let second = wire.attach(2);
    wire.wait(2100);
    wire.connect(FACTORY);
    let sent = wire.send(FACTORY, 4, &[0x0A, 0x10, 3, 1, 1, 5]);
    let check = ["42F#00620102000000", "42F#80620101000000"];
    assert_eq!(sent, ["5FB#0A90", check[0], check[1]]);
    assert_eq!(wire.wait(3000), [""; 0]);
    assert!(!wire.is_online(FACTORY));
    let serial = wire.send(5, 4, &[0x0A, 0x0E, 1, 1, 6]);
    assert_eq!(serial, ["42B#0A8E01000000"]);
    // The new MAC ID is stored.
    wire.bus.power_cycle(second);
    assert_eq!(wire.wait(3000), check);
}

#[test]
fn second_master_is_refused_while_the_first_one_owns_the_node() {
    let mut wire = Wire::new(true);
    let other = wire.bus.adapter();
    wire.bus.open(other, Some(BitRate::K125), false);
    wire.attach(1);
    wire.wait(2100);
    wire.connect(FACTORY);
    let allocate = Frame::data(standard(0x5FE), &[0x0B, 0x4B, 3, 1, 1, 0x0B]);
    wire.bus.send(other, allocate.expect("6 bytes"));
    let frames = wire.wait(20);
    assert_eq!(frames.last().map(String::as_str), Some("5FB#0B940C01"));
    let mac = wire.send(FACTORY, 4, &[0x0A, 0x0E, 3, 1, 1]);
    assert_eq!(mac, ["5FB#0A8E3F"]);
}

/// Requests that do not wait for the responses before them.
#[test]
fn burst_of_requests_is_answered_completely_and_in_order() {
    let mut wire = Wire::new(true);
    wire.attach(1);
    wire.wait(2100);
    wire.send(FACTORY, 6, &[0x0A, 0x4B, 3, 1, 3, 0x0A]);
    wire.send(FACTORY, 4, &[0x0A, 0x10, 5, 1, 9, 0, 0]);
    wire.send(FACTORY, 4, &[0x0A, 0x10, 5, 2, 9, 0, 0]);
    let mut expected = Vec::new();
    for number in 0..300_u16 {
        // With and without XID.
        let header = 0x0A | (number as u8 & 1) << 6;
        let attribute = 1 + (number % 4) as u8;
        wire.queue(4, &[header, 0x0E, 3, 1, attribute]);
        let value = if attribute == 1 { FACTORY } else { 0 };
        expected.push(format!("5FB#{header:02X}8E{value:02X}"));
    }
    assert_eq!(wire.wait(1000), expected);
    for _ in 0..100 {
        wire.queue(4, &[0x0A, 0x0E, 3, 1, 1]);
        wire.queue(5, &[]);
        wire.queue(7, &[0, 0x34, 0x12, 2, 0, 0, 0]);
        wire.queue(6, &[0x0B, 0x4B, 3, 1, 1, 0x0B]);
    }
    let sent = wire.wait(2000);
    for (text, name) in [
        ("5FB#0A8E3F", "explicit"),
        ("3FF#00000000", "poll"),
        ("5FF#80620101000000", "duplicate MAC ID check"),
        ("5FB#0B940C01", "port"),
    ] {
        let count = sent.iter().filter(|frame| *frame == text).count();
        assert_eq!(count, 100, "{name}");
    }
    assert_eq!(sent.len(), 400);
}

#[test]
fn bus_off_with_interrupt_checks_the_mac_id_again() {
    let mut wire = Wire::new(true);
    let device = wire.attach(1);
    wire.wait(2100);
    for (boi, counter) in [(1, 1), (0, 0)] {
        wire.connect(FACTORY);
        wire.send(FACTORY, 4, &[0x0A, 0x10, 3, 1, 3, boi]);
        wire.bus.corrupt(32, Some(Source::Device(device)));
        assert_eq!(wire.send(FACTORY, 4, &[0x0A, 0x0E, 3, 1, 1]), [""; 0]);
        let sent = wire.wait(2500);
        if boi == 0 {
            assert_eq!(sent, [""; 0]);
            assert!(!wire.is_online(FACTORY));
            continue;
        }
        assert_eq!(sent, ["5FF#00620101000000"; 2]);
        wire.connect(FACTORY);
        let answer = wire.send(FACTORY, 4, &[0x0A, 0x0E, 3, 1, 4]);
        assert_eq!(answer, [format!("5FB#0A8E{counter:02X}")]);
        wire.send(FACTORY, 6, &[0x0A, 0x4C, 3, 1, 1]);
    }
}
