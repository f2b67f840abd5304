//! Frames for a DeviceNet sensor, and the check of the frames that it sends.
//!
//! Most frames are requests of one master: allocations, reads and writes of attributes, mostly with permitted values, fragments and
//! polls.

use super::{Source, bytes, value};
use plumbline::can::{Frame, extended, standard};
use plumbline::devicenet::Source as Origin;
use plumbline::model::catalog::{Product, Protocol};
use plumbline::model::listing::devicenet::Tables;
use plumbline::node::Readout;

/// The MAC ID of the master of most requests.
const MASTER: u8 = 0x0A;

/// The factory value of the MAC ID; None if the product does not speak DeviceNet.
pub fn factory_mac_id(product: &Product) -> Option<u8> {
    match &product.protocol {
        Protocol::Devicenet(tables) => {
            let parameter = &product.parameters[usize::from(tables.roles.mac_id.0)];
            Some(parameter.factory as u8)
        }
        _ => None,
    }
}

/// A frame, mostly for the node with this MAC ID.
pub fn frame(source: &mut impl Source, tables: &Tables, product: &Product, mac_id: u8) -> Frame {
    let group2 = |message: u16| 0x400 | u16::from(mac_id) << 3 | message;
    let (id, data) = match source.byte() {
        0..=39 => (group2(6), allocation(source)),
        40..=49 => (group2(4), allocation(source)),
        50..=164 => (group2(4), request(source, tables, product)),
        165..=189 => (group2(4), fragment(source)),
        190..=214 => (group2(5), Vec::new()),
        215..=234 => (group2(2), Vec::new()),
        235 => (group2(7), duplicate_check(source)),
        236..=241 => (group2(u16::from(source.byte() % 7)), bytes(source)),
        242..=249 => (source.number() as u16, bytes(source)),
        250..=252 => {
            let length = usize::from(source.byte() % 9);
            let id = group2(u16::from(source.byte() % 8));
            return Frame::remote(standard(id), length).expect("at most eight bytes");
        }
        _ => {
            let frame = Frame::data(extended(source.number()), &bytes(source));
            return frame.expect("at most eight bytes");
        }
    };
    // Only a response to the duplicate check, or a request of it before the sensor is on-line, ends the communication.
    Frame::data(standard(id), &data).expect("at most eight bytes")
}

/// The first byte of a request: fragmented, XID, MAC ID of the master.
fn header(source: &mut impl Source) -> u8 {
    match source.byte() {
        0..=219 => MASTER,
        220..=244 => 0x40 | MASTER,
        _ => source.byte(),
    }
}

/// An allocation or a release, mostly of permitted choices.
fn allocation(source: &mut impl Source) -> Vec<u8> {
    let choices = [
        0x01, 0x02, 0x03, 0x10, 0x11, 0x13, 0x21, 0x23, 0x51, 0x53, 0x61, 0x73,
    ];
    let choice = match source.byte() {
        0..=219 => choices[usize::from(source.byte()) % choices.len()],
        _ => source.byte(),
    };
    let mut data = vec![header(source), 0x4B, 3, 1, choice, MASTER];
    if source.byte() < 40 {
        data[1] = 0x4C;
        data.pop();
    }
    data
}

/// The request or, rarely, the response of a duplicate MAC ID check.
fn duplicate_check(source: &mut impl Source) -> Vec<u8> {
    let [a, b, c, d] = source.number().to_le_bytes();
    let response = if source.byte() < 16 { 0x80 } else { 0 };
    vec![response, 0x62, 0x01, a, b, c, d]
}

/// A read or write, mostly of an attribute that exists.
fn request(source: &mut impl Source, tables: &Tables, product: &Product) -> Vec<u8> {
    let attributes = tables.objects.iter().flat_map(|object| {
        let attributes = object.attributes.iter();
        attributes.map(move |attribute| (object.class, attribute))
    });
    let attributes: Vec<_> = attributes.collect();
    let (class, attribute) = attributes[usize::from(source.byte()) % attributes.len()];
    let header = header(source);
    let mut data = match source.byte() {
        0..=69 => vec![header, 0x0E, class, 1, attribute.number],
        70..=149 => {
            let mut data = vec![header, 0x10, class, 1, attribute.number];
            if let Origin::Parameter(id) = attribute.source {
                let parameter = &product.parameters[usize::from(id.0)];
                let bytes = value(parameter, source).to_le_bytes();
                data.extend(bytes.iter().take(parameter.data_type.size().into()));
            }
            data
        }
        // The expected packet rate of a connection, mostly short.
        150..=189 => {
            let instance = [1, 2, 4][usize::from(source.byte()) % 3];
            let high = if source.byte() < 200 {
                0
            } else {
                source.byte()
            };
            vec![header, 0x10, 5, instance, 9, source.byte(), high]
        }
        // Any attribute of the objects of the protocol.
        190..=229 => {
            let class = [1, 2, 3, 4, 5, 0x2B][usize::from(source.byte()) % 6];
            let instance = match class {
                4 => {
                    tables.assemblies[usize::from(source.byte()) % tables.assemblies.len()].instance
                }
                5 => 1 + source.byte() % 4,
                _ => source.byte() % 2,
            };
            let service = if source.byte() < 180 { 0x0E } else { 0x10 };
            let mut data = vec![header, service, class, instance, source.byte() % 20];
            // A new MAC ID is rare: it takes two seconds, in which the sensor is not on-line.
            if (service, class) == (0x10, 3) {
                let (attribute, value) = match source.byte() {
                    0..=19 => (1, source.byte() % 66),
                    other => (2 + other % 3, source.byte() % 4),
                };
                data[4] = attribute;
                data.push(value);
            }
            data
        }
        230..=231 => vec![header, 0x05, 1, 1, source.byte() % 3],
        _ => {
            let mut data = bytes(source);
            data.insert(0, header);
            data
        }
    };
    // Sometimes too short or too long.
    match source.byte() {
        0..=9 => data.truncate(usize::from(source.byte()) % data.len()),
        10..=14 => data.push(source.byte()),
        _ => {}
    }
    data.truncate(8);
    data
}

/// A fragment of a request, or an acknowledgement of a fragment.
fn fragment(source: &mut impl Source) -> Vec<u8> {
    let count = source.byte() % 4;
    let header = 0x80 | header(source);
    let mut data = match source.byte() {
        0..=79 => vec![header, 0xC0 | count, source.byte() / 200],
        80..=139 => vec![header, 0x00, 0x10, 0x65, 1],
        140..=189 => vec![header, 0x80 | count, 0x85, 0x2C, 1],
        190..=219 => vec![header, 0x40 | count, 0x85],
        _ => return bytes(source),
    };
    data.truncate(8);
    data
}

/// Checks a frame that the sensor sent. Returns the MAC ID if it is a request of the duplicate check.
///
/// # Panics
/// If a DeviceNet sensor with this MAC ID never sends such a frame.
pub fn check(frame: &Frame, tables: &Tables, mac_id: u8) -> Option<u8> {
    let embedded_can::Id::Standard(id) = frame.id() else {
        panic!("no 29-bit identifiers: {frame:?}");
    };
    let (id, data) = (id.as_raw(), frame.bytes());
    assert!(!frame.is_remote(), "{frame:?}");
    let has_words = |size: usize| {
        let mut assemblies = tables.assemblies.iter();
        assemblies.any(|assembly| 2 * assembly.words.len() == size)
    };
    if id < 0x400 {
        let io = [0x0D, 0x0F].contains(&(id >> 6)) && (id & 0x3F) as u8 == mac_id;
        assert!(io && has_words(data.len()), "{frame:?}");
        return None;
    }
    let sender = (id >> 3 & 0x3F) as u8;
    match (id & 0x607, data) {
        (0x407, [0, ..]) if data.len() == 7 => return Some(sender),
        (0x407, [0x80, ..]) if data.len() == 7 && sender == mac_id => {}
        // A response, an error, or a fragment.
        (0x403, [_, 0x94, _, _]) if sender == mac_id => {}
        (0x403, [header, service, ..]) if sender == mac_id => {
            assert!(header & 0x80 != 0 || service & 0x80 != 0, "{frame:?}");
        }
        _ => panic!("{frame:?}"),
    }
    None
}

/// Whether the angles are within the range of the sensor. The sum of a 2-axis sensor is not limited.
pub fn is_possible(readout: Readout) -> bool {
    let range = -65_535..=65_535;
    range.contains(&readout.x) && readout.y.is_none_or(|y| range.contains(&y))
}
