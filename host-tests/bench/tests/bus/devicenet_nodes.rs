//! Two DeviceNet slaves and two masters on one wire: each slave answers only its own master, also when all exchange messages at
//! the same time.

use bench::motion::Motion;
use bench::{AdapterId, Bus, BusRate, Device, DeviceId, Flash, NodeType};
use plumbline::can::{BitRate, Frame, standard};
use plumbline::measure::{I32x3, ONE_G, Reading};
use plumbline::time::{after, millis};

/// The MAC IDs of the slaves: the one that is changed, and the factory value.
const SLAVES: [u16; 2] = [5, 63];

/// The MAC IDs of the masters.
const MASTERS: [u8; 2] = [0x0A, 0x0B];

/// The identifiers of the messages of MAC ID 0.
const POLL_RESPONSE: u16 = 0x3C0;
const CHANGE: u16 = 0x340;

struct Wire {
    bus: Bus,
    masters: [AdapterId; 2],
}

/// A specific force of 1 g along this axis.
fn along(axis: usize) -> Box<dyn Motion> {
    let part = |place| if place == axis { ONE_G } else { 0 };
    Box::new(Reading {
        acceleration: I32x3 {
            x: part(0),
            y: part(1),
            z: part(2),
        },
        ..Reading::default()
    })
}

impl Wire {
    /// Both masters, the first slave with its new MAC ID and the second one: on-line and not allocated.
    fn new() -> (Self, [DeviceId; 2]) {
        let mut bus = Bus::new(BusRate::Wire);
        let masters = [bus.adapter(), bus.adapter()];
        for master in masters {
            bus.open(master, Some(BitRate::K125), false);
        }
        let mut wire = Self { bus, masters };
        // The 080 lies level; the 360 is at 90 deg.
        let first = wire.attach("tiltix080", 1, 2);
        wire.wait(2100);
        let factory = SLAVES[1];
        let allocated = wire.exchange(0, factory, 6, &[MASTERS[0], 0x4B, 3, 1, 1, MASTERS[0]]);
        assert_eq!(allocated, ["5FB#0ACB00"]);
        let changed = wire.exchange(0, factory, 4, &[MASTERS[0], 0x10, 3, 1, 1, 5]);
        assert_eq!(changed, ["5FB#0A90", "42F#00620101000000"]);
        let second = wire.attach("tiltix360", 2, 0);
        wire.wait(2500);
        (wire, [first, second])
    }

    fn attach(&mut self, name: &str, serial: u32, axis: usize) -> DeviceId {
        let node_type = NodeType::find(name).expect("a product");
        let device = Device::new(&node_type, serial, Flash::default(), along(axis));
        self.bus.attach(device)
    }

    fn wait(&mut self, ms: u32) {
        self.bus.run_until(after(self.bus.now(), millis(ms)));
        for master in self.masters {
            self.bus.take_received(master);
        }
    }

    /// Queues a message of group 2 to a slave.
    fn send(&mut self, master: usize, slave: u16, message: u16, data: &[u8]) {
        let id = standard(0x400 | slave << 3 | message);
        let frame = Frame::data(id, data).expect("at most 8 bytes");
        self.bus.send(self.masters[master], frame);
    }

    /// The frames of the slaves within this many milliseconds. Each master receives all of them.
    fn received(&mut self, ms: u32) -> Vec<String> {
        self.bus.run_until(after(self.bus.now(), millis(ms)));
        let [one, other] = self.masters.map(|master| {
            let frames = self.bus.take_received(master).into_iter();
            let texts = frames.map(|(_, frame)| format!("{frame:?}"));
            texts.collect::<Vec<_>>()
        });
        one.into_iter()
            .filter(|text| other.contains(text))
            .collect()
    }

    /// The frames of the slaves within 20 ms after this message.
    fn exchange(&mut self, master: usize, slave: u16, message: u16, data: &[u8]) -> Vec<String> {
        self.send(master, slave, message, data);
        self.received(20)
    }

    /// A request of a master to the unconnected port of a slave. Returns the response without the MAC ID of the master.
    fn link(&mut self, master: usize, slave: u16, request: &[u8]) -> String {
        let mac = MASTERS[master];
        let sent = self.exchange(master, slave, 6, &[&[mac], request].concat());
        let header = format!("{:03X}#{mac:02X}", 0x400 | slave << 3 | 3);
        assert_eq!(sent.len(), 1, "{sent:?}");
        let body = sent[0].strip_prefix(&header);
        body.unwrap_or_else(|| panic!("{sent:?}")).to_owned()
    }

    /// The same on the explicit connection.
    fn ask(&mut self, master: usize, slave: u16, request: &[u8]) -> Vec<String> {
        let mac = MASTERS[master];
        self.exchange(master, slave, 4, &[&[mac], request].concat())
    }

    /// Each master allocates its slave: explicit, poll, COS without acknowledge. No connection times out.
    fn allocate(&mut self) {
        for (number, slave) in SLAVES.into_iter().enumerate() {
            let allocate = [0x4B, 3, 1, 0x53, MASTERS[number]];
            assert_eq!(self.link(number, slave, &allocate), "CB00");
            for instance in [1, 2, 4] {
                let response = self.ask(number, slave, &[0x10, 5, instance, 9, 0, 0]);
                assert!(response[0].ends_with("900000"), "{response:?}");
            }
        }
    }
}

/// The frames with this identifier.
fn of(frames: &[String], id: u16) -> Vec<&str> {
    let prefix = format!("{id:03X}#");
    let data = frames.iter().filter_map(|text| text.strip_prefix(&prefix));
    data.collect()
}

#[test]
fn each_slave_belongs_to_the_master_that_has_allocated_it() {
    let (mut wire, _) = Wire::new();
    wire.allocate();
    for (number, slave) in SLAVES.into_iter().enumerate() {
        let other = 1 - number;
        let allocate = [0x4B, 3, 1, 1, MASTERS[other]];
        assert_eq!(wire.link(other, slave, &allocate), "940C01");
        assert_eq!(wire.link(other, slave, &[0x4C, 3, 1, 1]), "940C01");
        // The explicit connection is that of the owner.
        assert_eq!(wire.ask(other, slave, &[0x0E, 3, 1, 1]), [""; 0]);
        let mac = wire.ask(number, slave, &[0x0E, 3, 1, 1]);
        assert!(mac[0].ends_with(&format!("8E{slave:02X}")), "{mac:?}");
    }
    // The owner of one slave releases it: the other slave is not concerned.
    assert_eq!(wire.link(0, SLAVES[0], &[0x4C, 3, 1, 0x13]), "CC");
    assert_eq!(wire.exchange(0, SLAVES[0], 5, &[]), [""; 0]);
    assert_eq!(wire.exchange(1, SLAVES[1], 5, &[]).len(), 1);
    let allocate = [0x4B, 3, 1, 1, MASTERS[1]];
    assert_eq!(wire.link(1, SLAVES[0], &allocate), "CB00");
}

#[test]
fn simultaneous_polls_are_answered_with_the_angles_of_each_slave() {
    let (mut wire, sensors) = Wire::new();
    wire.allocate();
    // X and Y in 0.01 deg: 0 and 0, 90 and 0.
    let words = ["00000000", "28230000"];
    for round in 0..50 {
        for (number, slave) in SLAVES.into_iter().enumerate() {
            wire.send(number, slave, 5, &[]);
        }
        let frames = wire.received(10);
        assert_eq!(frames.len(), 2, "{round}: {frames:?}");
        for (slave, words) in SLAVES.into_iter().zip(words) {
            assert_eq!(of(&frames, POLL_RESPONSE | slave), [words], "{round}");
        }
    }
    for sensor in sensors {
        assert_eq!(wire.bus.device(sensor).error_counters(), Some((0, 0)));
    }
}

#[test]
fn change_of_one_slave_is_sent_between_the_polls_of_both() {
    let (mut wire, sensors) = Wire::new();
    wire.allocate();
    wire.received(100);
    wire.bus.device_mut(sensors[1]).set_motion(along(1));
    let mut frames = Vec::new();
    for _ in 0..100 {
        for (number, slave) in SLAVES.into_iter().enumerate() {
            wire.send(number, slave, 5, &[]);
        }
        frames.extend(wire.received(10));
    }
    for slave in SLAVES {
        assert_eq!(of(&frames, POLL_RESPONSE | slave).len(), 100);
    }
    assert_eq!(of(&frames, CHANGE | SLAVES[0]), [""; 0], "at rest");
    let changes = of(&frames, CHANGE | SLAVES[1]);
    assert_eq!(changes.last(), Some(&"00000000"), "0 deg");
    let polled = of(&frames, POLL_RESPONSE | SLAVES[1]);
    assert_eq!(polled.last(), Some(&"00000000"));
}
