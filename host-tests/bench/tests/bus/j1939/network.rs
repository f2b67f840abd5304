//! A wire with IMS360 in J1939, and the rules that every frame of such a node keeps (SAE J1939-81).

use bench::script::LEVEL;
use bench::{AdapterId, Bus, BusRate, Device, DeviceId, Flash, Logged, NodeType, Source};
pub use can_wire::text::frame;
use plumbline::can::{BitRate, Frame, standard};
use plumbline::time::{Instant, after, millis};
use std::collections::BTreeMap;

/// Objects to write before the node starts in J1939: index, sub-index, data.
pub type Objects<'a> = &'a [(u16, u8, &'a [u8])];

/// The source address of a node without an address.
pub const NO_ADDRESS: u8 = 254;

/// The address that every node claims first, as delivered.
pub const PREFERRED: u8 = 0x80;

/// The NAME with factory values and this serial number.
pub fn name(serial: u32) -> u64 {
    0x8000_9100_FFE0_0000 | u64::from(serial & 0x1F_FFFF)
}

/// It is on the bus at once.
fn node_type() -> NodeType {
    NodeType {
        first_reading: millis(0),
        ..NodeType::find("ims360").expect("a product")
    }
}

/// A memory in which J1939 and these objects are stored, written over CANopen.
pub fn memory(serial: u32, objects: Objects) -> Flash {
    let mut bus = Bus::new(BusRate::Follow);
    let motion = Box::new(LEVEL);
    let device = bus.attach(Device::new(&node_type(), serial, Flash::default(), motion));
    let tester = bus.adapter();
    bus.open(tester, None, false);
    bus.run_until(after(bus.now(), millis(20)));
    bus.take_received(tester);
    let selection: Objects = &[(0x3100, 1, &[1]), (0x1010, 1, b"save")];
    for (index, sub, data) in objects.iter().chain(selection) {
        let [low, high] = index.to_le_bytes();
        let mut request = vec![0x23 | (4 - data.len() as u8) << 2, low, high, *sub];
        request.extend(*data);
        request.resize(8, 0);
        bus.send(
            tester,
            Frame::data(standard(0x632), &request).expect("8 bytes"),
        );
        bus.run_until(after(bus.now(), millis(100)));
        let frames = bus.take_received(tester);
        let texts: Vec<_> = frames
            .iter()
            .map(|(_, frame)| format!("{frame:?}"))
            .collect();
        assert_eq!(
            texts,
            [format!("5B2#60{low:02X}{high:02X}{sub:02X}00000000")]
        );
    }
    std::mem::take(bus.device_mut(device).flash())
}

/// A wire with a tester and sensors.
pub struct Network {
    pub bus: Bus,
    pub tester: AdapterId,
    pub sensors: Vec<DeviceId>,
    pub log: Vec<Logged>,
}

impl Network {
    /// Switches sensors with these serial numbers on at the same time.
    pub fn new(serials: &[u32], objects: Objects) -> Self {
        let mut bus = Bus::new(BusRate::Wire);
        let tester = bus.adapter();
        bus.open(tester, Some(BitRate::K125), false);
        let mut network = Self {
            bus,
            tester,
            sensors: Vec::new(),
            log: Vec::new(),
        };
        let memories: Vec<_> = serials
            .iter()
            .map(|serial| memory(*serial, objects))
            .collect();
        for (serial, memory) in serials.iter().zip(memories) {
            network.attach(*serial, memory);
        }
        network
    }

    /// Switches one more sensor on, with this serial number and memory.
    pub fn attach(&mut self, serial: u32, memory: Flash) -> DeviceId {
        let device = Device::new(&node_type(), serial, memory, Box::new(LEVEL));
        let sensor = self.bus.attach(device);
        self.sensors.push(sensor);
        sensor
    }

    /// Lets time pass, and returns the frames of this time.
    pub fn wait(&mut self, ms: u32) -> Vec<Logged> {
        self.bus.run_until(after(self.bus.now(), millis(ms)));
        let new = self.bus.take_log();
        self.log.extend(&new);
        new
    }

    /// Sends a frame and lets time pass.
    pub fn send(&mut self, text: &str, ms: u32) -> Vec<Logged> {
        self.bus.send(self.tester, frame(text));
        self.wait(ms)
    }

    /// The address of each sensor, after its last claim.
    pub fn addresses(&self) -> Vec<Option<u8>> {
        let last = |sensor: &DeviceId| {
            let own = self
                .log
                .iter()
                .filter(|one| one.source == Source::Device(*sensor));
            own.filter_map(|one| claimed(&one.frame)).next_back()
        };
        self.sensors.iter().map(last).collect()
    }

    /// Checks all frames since the start, see [`Rules`].
    pub fn check(&self) {
        let mut rules = Rules::default();
        for one in &self.log {
            rules.add(one);
        }
    }

    /// The number of these frames of each sensor that are not claims.
    pub fn active(&self, frames: &[Logged]) -> Vec<usize> {
        let count = |sensor: &DeviceId| {
            let own = frames
                .iter()
                .filter(|one| one.source == Source::Device(*sensor));
            own.filter(|one| claimed(&one.frame).is_none()).count()
        };
        self.sensors.iter().map(count).collect()
    }
}

/// The texts of frames, without SSI2 and DM1 without codes.
pub fn texts(frames: &[Logged]) -> Vec<String> {
    let texts = frames.iter().map(|one| format!("{:?}", one.frame));
    let is_cyclic = |text: &String| {
        text.starts_with("0CF029")
            || text.starts_with("18FECA") && text.ends_with("#00FF00000000FFFF")
    };
    texts.filter(|text| !is_cyclic(text)).collect()
}

/// The texts of the frames of sensors, as [`texts`].
pub fn answers(frames: &[Logged]) -> Vec<String> {
    let of_sensors = |one: &&Logged| matches!(one.source, Source::Device(_));
    let own: Vec<_> = frames.iter().filter(of_sensors).copied().collect();
    texts(&own)
}

/// Whether this is DM1 with the code "error passive" alone: claims of one address that collide raise the error counters.
pub fn is_error_passive(text: &str) -> bool {
    text.starts_with("18FECA") && text.contains("#04FF7F0202")
}

fn identifier(frame: &Frame) -> u32 {
    let text = format!("{frame:?}");
    let (id, _) = text.split_once('#').expect("an identifier");
    assert_eq!(id.len(), 8, "an 11-bit identifier: {text}");
    u32::from_str_radix(id, 16).expect("an identifier")
}

/// The source address of a claim; None for another frame.
pub fn claimed(frame: &Frame) -> Option<u8> {
    let id = identifier(frame);
    (id >> 8 & 0x3_FFFF == 0xEEFF).then_some(id as u8)
}

/// What is known of a sensor.
#[derive(Clone, Copy)]
struct Known {
    address: u8,
    /// The end of the claim that began the silence.
    since: Instant,
    /// The silence has ended: another frame than a claim was sent.
    settled: bool,
    /// Another node has claimed this address since the last claim.
    contended: bool,
    name: u64,
    /// A lower NAME has claimed this address.
    lost: bool,
}

/// Checks the frames of sensors: the source is the address of the last claim, nothing but claims is sent within 250 ms after a
/// claim, and nothing at all from an address after a claim with a lower NAME. The claim of a node that has its address, and the
/// answer to a request, begin no silence.
#[derive(Default)]
pub struct Rules {
    sensors: BTreeMap<usize, Known>,
}

impl Rules {
    fn add(&mut self, one: &Logged) {
        let source = identifier(&one.frame) as u8;
        let is_claim = claimed(&one.frame).is_some();
        // A frame is sent at the sample point of its last bit: a bit of 8 us earlier than its end.
        let start = Instant::from_ticks(one.start.div_ceil(1_000_000) + 8);
        if let Source::Device(id) = one.source {
            // The identification has no other public form.
            let key = format!("{id:?}")
                .bytes()
                .fold(0, |sum, byte| sum * 31 + usize::from(byte));
            if is_claim {
                let name = u64::from_le_bytes(one.frame.bytes().try_into().expect("8 bytes"));
                let known = self.sensors.get(&key).copied();
                let again = known.filter(|known| known.address == source);
                assert!(again.is_none_or(|known| !known.lost), "lost: {one:?}");
                let goes_on = again.filter(|known| known.settled || !known.contended);
                let known = Known {
                    address: source,
                    since: goes_on.map_or(one.at, |known| known.since),
                    settled: goes_on.is_some_and(|known| known.settled),
                    contended: false,
                    name,
                    lost: false,
                };
                self.sensors.insert(key, known);
            } else {
                let known = self.sensors.get_mut(&key).expect("a claim comes first");
                known.settled = true;
                assert!(source != NO_ADDRESS && source == known.address, "{one:?}");
                assert!(!known.lost, "lost: {one:?}");
                assert!(
                    start >= after(known.since, millis(250)),
                    "silence since {:?}: {one:?}",
                    known.since
                );
            }
        }
        if is_claim && source != NO_ADDRESS {
            let name = u64::from_le_bytes(one.frame.bytes().try_into().expect("8 bytes"));
            for known in self.sensors.values_mut() {
                let is_other = known.address == source && name != known.name;
                known.contended |= is_other;
                known.lost |= is_other && name < known.name;
            }
        }
    }
}
