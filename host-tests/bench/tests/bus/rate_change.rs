//! Restarts that change the bit rate of a bus that follows its sensor: the frame that requests the restart is received once, and
//! the log is in the order of time.

use bench::script::LEVEL;
use bench::{AdapterId, Bus, BusRate, Device, DeviceId, Flash, Logged, NodeType, Source};
use plumbline::can::{BitRate, Frame, standard};
use plumbline::time::{after, millis};

/// The rates of the JN2101 (2001h, in kbit/s) in an order that changes up and down. GEMAC's sensors have them too.
const RATES: [(BitRate, u16, u8); 6] = [
    (BitRate::K500, 500, 7),
    (BitRate::K50, 50, 3),
    (BitRate::M1, 1000, 9),
    (BitRate::K20, 20, 2),
    (BitRate::K125, 125, 5),
    (BitRate::K250, 250, 6),
];

/// A sensor and two clients.
struct Rig {
    bus: Bus,
    sensor: DeviceId,
    client: AdapterId,
    other: AdapterId,
}

impl Rig {
    fn new(model: &str) -> Self {
        let mut bus = Bus::new(BusRate::Follow);
        let node_type = NodeType::find(model).expect("a product");
        let device = Device::new(&node_type, 1, Flash::default(), Box::new(LEVEL));
        let sensor = bus.attach(device);
        let [client, other] = [bus.adapter(), bus.adapter()];
        for adapter in [client, other] {
            bus.open(adapter, None, false);
        }
        let mut rig = Self {
            bus,
            sensor,
            client,
            other,
        };
        rig.run(100);
        rig
    }

    fn run(&mut self, ms: u32) {
        self.bus.run_until(after(self.bus.now(), millis(ms)));
    }

    fn send(&mut self, id: u16, data: &[u8]) {
        let frame = Frame::data(standard(id), data).expect("at most 8 bytes");
        self.bus.send(self.client, frame);
    }

    /// Sends a frame that restarts the sensor with this rate, and another frame right behind it. Checks the log of the next
    /// second, and that the sensor has sent this many frames with this identifier before any other.
    #[track_caller]
    fn restart(&mut self, request: (u16, &[u8]), rate: BitRate, boot_up: (u16, usize)) {
        self.bus.take_log();
        self.bus.take_received(self.other);
        self.send(request.0, request.1);
        self.send(0x7FF, &[]);
        self.run(1000);
        assert_eq!(self.bus.rate(), rate);
        let log = self.bus.take_log();
        assert!(in_order(&log), "{rate:?}: {log:#?}");
        let requests = log.iter().filter(|one| one.frame.bytes() == request.1);
        assert_eq!(requests.count(), 1, "{rate:?}: {log:#?}");
        let own = Source::Device(self.sensor);
        let sent = log.iter().filter(|one| one.source == own);
        let sent: Vec<_> = sent.map(|one| one.frame.id()).collect();
        assert_eq!(sent, vec![standard(boot_up.0); boot_up.1], "{rate:?}");
        // The other client has received what is in the log.
        let received = self.bus.take_received(self.other).into_iter();
        let received: Vec<Frame> = received.map(|(_, frame)| frame).collect();
        let logged: Vec<Frame> = log.iter().map(|one| one.frame).collect();
        assert_eq!(received, logged, "{rate:?}");
    }
}

/// Each frame starts after the end of the one before; ends are rounded up to microseconds.
fn in_order(log: &[Logged]) -> bool {
    let ends = log.iter().map(|one| one.at.ticks().saturating_sub(1));
    let starts = log.iter().skip(1).map(|one| one.start / 1_000_000);
    ends.zip(starts).all(|(end, start)| end <= start)
}

#[test]
fn reset_of_fsc_sensor_with_new_rate_is_received_once() {
    let mut rig = Rig::new("is2");
    rig.send(0x7FF, &[]);
    rig.run(300);
    for (rate, _, code) in RATES {
        rig.send(0x300, &[0x23, code]);
        rig.send(0x300, b"\x50SAVE");
        rig.run(300);
        let boots = rig.bus.device(rig.sensor).boots();
        rig.restart((0x300, b"\xFFRESET"), rate, (0x301, 2));
        assert_eq!(rig.bus.device(rig.sensor).boots(), boots + 1, "{rate:?}");
    }
    // Automatic detection; the frame behind RESET shows the rate.
    rig.send(0x300, &[0x23, 0]);
    rig.send(0x300, b"\x50SAVE");
    rig.run(300);
    rig.restart((0x300, b"\xFFRESET"), BitRate::K250, (0x301, 2));
}

#[test]
fn nmt_reset_of_canopen_sensor_with_new_rate_is_received_once() {
    let mut rig = Rig::new("jn2101");
    for (rate, kbits, _) in RATES {
        let [low, high] = kbits.to_le_bytes();
        rig.send(0x60A, &[0x2B, 0x01, 0x20, 0, low, high, 0, 0]);
        rig.send(0x60A, b"\x23\x10\x10\x01save");
        rig.run(300);
        // Reset node.
        rig.restart((0x000, &[0x81, 10]), rate, (0x70A, 1));
    }
}
