//! Frames for a sensor in J1939, and the check of the frames that it sends.
//!
//! Most frames are for the address of the sensor: requests, claims of its own address and of the next ones, the transport protocol
//! in both directions, and the bytes of SDO requests.

use super::{Source, bytes, canopen};
use plumbline::can::{Frame, extended};
use plumbline::j1939::name::Name;
use plumbline::j1939::transport::Control;
use plumbline::model::catalog::Product;
use plumbline::model::listing::canopen::Tables;
use plumbline::node::Node;
use plumbline::time::{Duration, Instant, after, millis};

/// The destination of a frame to all, and the source of a node without an address.
const GLOBAL: u8 = 255;
const NO_ADDRESS: u8 = 254;

/// The address of the tester.
const TESTER: u8 = 0x21;

/// Parameter groups with a destination, by their PF.
const REQUEST: u8 = 0xEA;
const CLAIM: u8 = 0xEE;
const CONTROL: u8 = 0xEC;
const DATA: u8 = 0xEB;
const PROPRIETARY: u8 = 0xEF;

/// The groups that the sensor knows, and two others.
const GROUPS: [u32; 13] = [
    0xEE00, 0xF029, 0xF013, 0xF02A, 0xF02D, 0xFECA, 0xFEEB, 0xFEDA, 0xFDC5, 0xFED8, 0xEF00, 0xFEEE,
    0xFECB,
];
const COMMANDED: u32 = 0xFED8;

/// The time after a claim in which nothing else is sent.
const SILENCE: Duration = millis(250);

/// After this time without a received frame, all connections to one node have ended: T3 after the last packet.
const CONNECTIONS_END: Duration = millis(2500);

/// The kind of a sent frame.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Kind {
    /// Address Claimed or cannot claim.
    Claim,
    /// A frame of the transport protocol to one node.
    Connection,
    /// A frame of another group.
    Other,
}

/// What a sensor has shown of itself.
#[derive(Clone, Debug, Default)]
pub struct Known {
    /// The address of the last claim, unless it was lost since then, and the time of its first claim.
    address: Option<(u8, Instant)>,
    /// An address that was lost to a lower NAME. It is not claimed again before a restart or Commanded Address.
    lost: Option<u8>,
    /// The address at the last packet. The end of Commanded Address is acknowledged from it, just before the claim of the new one.
    commanded: Option<u8>,
    /// A restart may be pending (2010h).
    restarts: bool,
    /// The NAME in its last claim.
    name: Option<Name>,
    /// The last frame of a connection to one node.
    connection: Option<Instant>,
}

/// Whether a node is in J1939: it accepts claims, and no NMT commands.
pub fn is_in_force(node: &dyn Node) -> bool {
    let (mut claims, mut commands) = (false, false);
    node.filters(&mut |filter| {
        claims |= filter.accepts(extended(0x18EE_FF00));
        commands |= filter.accepts(plumbline::can::standard(0));
    });
    claims && !commands
}

impl Known {
    /// The address of the sensor.
    pub fn address(&self) -> Option<u8> {
        self.address.map(|(address, _)| address)
    }

    /// The sensor starts again, or is bus-off: the next frame is a claim.
    pub fn restart(&mut self) {
        self.address = None;
        self.lost = None;
        self.restarts = false;
    }

    /// Notes a frame that the sensor receives.
    pub fn receive(&mut self, frame: &Frame) {
        let Some((id, data)) = parts(frame) else {
            return;
        };
        let format = (id >> 16 & 0x3FF) as u8;
        if format == DATA {
            // Perhaps Commanded Address with the lost one.
            self.lost = None;
            self.commanded = self.address().or(self.commanded);
        }
        self.restarts |= format == PROPRIETARY && data.get(1..3) == Some(&[0x10, 0x20]);
        if id >> 8 & 0x3_FFFF != 0xEEFF {
            return;
        }
        let (Ok(bytes), Some(name)) = (<[u8; 8]>::try_from(data), self.name) else {
            return;
        };
        if Name::from_bytes(bytes) < name
            && let Some((address, _)) = self.address.take_if(|(address, _)| *address == id as u8)
        {
            self.lost = Some(address);
        }
    }

    /// Checks a frame that the sensor sends. Returns its kind.
    ///
    /// # Panics
    /// If a sensor with J1939 must not send this frame at this time.
    pub fn check(&mut self, now: Instant, frame: &Frame) -> Kind {
        let Some((id, data)) = parts(frame) else {
            panic!("neither an 11-bit nor a remote frame: {frame:?}");
        };
        let source = id as u8;
        let (format, destination) = ((id >> 16) as u8, (id >> 8) as u8);
        assert!(id >> 24 & 3 == 0, "data pages: {frame:?}");
        if id >> 8 & 0x3_FFFF == 0xEEFF {
            let bytes = data.try_into().expect("a NAME has 8 bytes");
            self.claim(now, source, Name::from_bytes(bytes));
            return Kind::Claim;
        }
        let is_end = format == CONTROL && data.first() == Some(&0x13);
        if is_end && self.commanded == Some(source) {
            return Kind::Connection;
        }
        let Some((address, since)) = self.address.filter(|_| source != NO_ADDRESS) else {
            panic!("without an address: {frame:?}");
        };
        assert_eq!(source, address, "{frame:?}");
        assert!(now >= after(since, SILENCE), "silence: {frame:?}");
        let (group, known) = match format {
            0xF0.. => (u32::from(format) << 8 | u32::from(destination), true),
            CONTROL | DATA | PROPRIETARY => (0, data.len() == 8),
            0xE8 => (
                0,
                destination == GLOBAL && matches!(data, [1 | 3, 255, 255, 255, ..]),
            ),
            _ => (0, false),
        };
        let keeps = known && data.len() <= 8 && (group == 0 || GROUPS[1..9].contains(&group));
        assert!(keeps, "{frame:?}");
        if matches!(format, CONTROL | DATA) && destination != GLOBAL {
            self.connection = Some(now);
            return Kind::Connection;
        }
        Kind::Other
    }

    /// Checks that connections have ended when no frame was received since `begin`.
    ///
    /// # Panics
    /// If they have not.
    pub fn check_quiet(&self, begin: Instant) {
        let end = after(begin, CONNECTIONS_END);
        assert!(
            self.connection.is_none_or(|last| last <= end),
            "a connection does not end"
        );
    }

    fn claim(&mut self, now: Instant, source: u8, name: Name) {
        self.name = Some(name);
        if source == NO_ADDRESS {
            self.address = None;
            return;
        }
        assert!(source < NO_ADDRESS);
        assert!(
            self.restarts || self.lost != Some(source),
            "{source} is lost"
        );
        if self.address.is_none_or(|(address, _)| address != source) {
            self.address = Some((source, now));
        }
    }

    /// A frame, mostly for this sensor.
    pub fn frame(&self, source: &mut impl Source, tables: &Tables, product: &Product) -> Frame {
        let own = self.address().unwrap_or(0x80);
        let own = if source.byte() < 8 { NO_ADDRESS } else { own };
        let from = match source.byte() {
            0..=199 => TESTER,
            200..=239 => TESTER + source.byte() % 4,
            _ => source.byte(),
        };
        let destination = match source.byte() {
            0..=179 => own,
            180..=249 => GLOBAL,
            _ => source.byte(),
        };
        let (format, destination, from, data) = match source.byte() {
            0..=39 => (REQUEST, destination, from, request(source)),
            40..=69 => {
                let other = match source.byte() {
                    0..=149 => own,
                    150..=219 => own.wrapping_add(source.byte() % 4),
                    _ => source.byte(),
                };
                (CLAIM, GLOBAL, other, self.contending(source))
            }
            70..=119 => (CONTROL, destination, from, control(source)),
            120..=159 => (DATA, destination, from, self.packet(source)),
            160..=229 => {
                let request = canopen::request(source, tables, product).to_vec();
                (PROPRIETARY, destination, from, request)
            }
            230..=239 => (source.byte(), destination, from, bytes(source)),
            240..=247 => return canopen::frame(source, tables, product, 50),
            248..=250 => {
                let length = usize::from(source.byte() % 9);
                let id = extended(0x18EA_0000 | u32::from(own) << 8 | u32::from(from));
                return Frame::remote(id, length).expect("at most eight bytes");
            }
            _ => {
                let frame = Frame::data(extended(source.number() & 0x1FFF_FFFF), &bytes(source));
                return frame.expect("at most eight bytes");
            }
        };
        let priority = u32::from(source.byte() % 8);
        let id = priority << 26 | u32::from_be_bytes([0, format, destination, from]);
        Frame::data(extended(id), &data).expect("at most eight bytes")
    }

    /// The NAME of another node: mostly a little lower or higher than that of the sensor.
    fn contending(&self, source: &mut impl Source) -> Vec<u8> {
        let own = self.name.map_or(0, |name| name.0);
        let name = match source.byte() {
            0..=29 => own,
            30..=69 => own.wrapping_sub(1),
            70..=199 => own.wrapping_add(1),
            _ => u64::from(source.number()) << 32 | u64::from(source.number()),
        };
        let mut data = name.to_le_bytes().to_vec();
        if source.byte() < 8 {
            data.truncate(usize::from(source.byte() % 8));
        }
        data
    }

    /// A packet: mostly of Commanded Address with the NAME of the sensor.
    fn packet(&self, source: &mut impl Source) -> Vec<u8> {
        let name = self.name.map_or(0, |name| name.0).to_le_bytes();
        let mut data = vec![255; 8];
        match source.byte() {
            0..=119 => {
                data[0] = 1;
                data[1..].copy_from_slice(&name[..7]);
            }
            120..=219 => {
                let address = match source.byte() {
                    0..=199 => 128 + source.byte() % 120,
                    _ => source.byte(),
                };
                data[..3].copy_from_slice(&[2, name[7], address]);
            }
            220..=239 => data[0] = source.byte() % 4,
            _ => data = bytes(source),
        }
        data
    }
}

/// The identifier and the data of a data frame with 29 bits.
fn parts(frame: &Frame) -> Option<(u32, &[u8])> {
    match frame.id() {
        embedded_can::Id::Extended(id) if !frame.is_remote() => Some((id.as_raw(), frame.bytes())),
        _ => None,
    }
}

/// A group, mostly one that the sensor knows.
fn group(source: &mut impl Source) -> u32 {
    match source.byte() {
        0..=239 => GROUPS[usize::from(source.byte()) % GROUPS.len()],
        _ => source.number() & 0x3_FFFF,
    }
}

/// The data of a request: mostly three bytes.
fn request(source: &mut impl Source) -> Vec<u8> {
    let mut data = group(source).to_le_bytes()[..3].to_vec();
    match source.byte() {
        0..=9 => data.truncate(usize::from(source.byte() % 3)),
        10..=19 => data.resize(8, 255),
        _ => {}
    }
    data
}

/// A TP.CM message: mostly for a message of the sensor, or for Commanded Address.
fn control(source: &mut impl Source) -> Vec<u8> {
    let [count, next, limit] = [0, 1, 2].map(|_| source.byte());
    let (size, packets) = match source.byte() {
        0..=199 => (9, 2),
        _ => (u16::from(source.byte()) * 7, source.byte()),
    };
    let own = [0xFEEB, 0xFDC5, 0xFECA][usize::from(limit) % 3];
    let (control, group) = match source.byte() {
        0..=49 => (
            Control::RequestToSend {
                size,
                packets,
                limit,
            },
            COMMANDED,
        ),
        50..=79 => (Control::Broadcast { size, packets }, COMMANDED),
        80..=149 => (
            Control::ClearToSend {
                count: count % 7,
                next: next % 8,
            },
            own,
        ),
        150..=169 => (Control::ClearToSend { count, next }, own),
        170..=189 => (Control::End { size, packets }, own),
        190..=209 => (
            Control::Abort(count),
            if next < 128 { own } else { COMMANDED },
        ),
        210..=219 => (
            Control::RequestToSend {
                size,
                packets,
                limit,
            },
            group(source),
        ),
        220..=239 => (Control::Broadcast { size, packets }, group(source)),
        _ => return bytes(source),
    };
    control.bytes(group).to_vec()
}
