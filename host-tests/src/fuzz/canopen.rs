//! Frames for a CANopen sensor, and the check of the frames that it sends.
//!
//! Most frames are SDO requests for objects of the product's dictionary, mostly with permitted sizes and values.

use super::{Source, bytes, value};
use plumbline::can::{Frame, extended, standard};
use plumbline::canopen::dictionary::{Object, Service, Target};
use plumbline::canopen::{cob_id, profile};
use plumbline::model::catalog::{Product, Protocol};
use plumbline::model::listing::canopen::Tables;
use plumbline::node::Readout;
use plumbline::param::DataType;

/// The factory value of the node-ID; 0 if the product does not speak CANopen.
pub fn factory_node_id(product: &Product) -> u8 {
    match &product.protocol {
        Protocol::Canopen(tables) => {
            product.parameters[usize::from(tables.node_id.0)].factory as u8
        }
        _ => 0,
    }
}

/// A frame, mostly for the node with this node-ID.
pub fn frame(source: &mut impl Source, tables: &Tables, product: &Product, node_id: u8) -> Frame {
    let node = u16::from(node_id);
    let (id, data) = match source.byte() {
        0..=169 => (0x600 + node, request(source, tables, product).to_vec()),
        170..=189 => (
            0x000,
            vec![nmt(source), if source.byte() < 200 { 0 } else { node_id }],
        ),
        190..=214 => (0x080, Vec::new()),
        215..=224 => return remote(0x700 + node, source),
        225..=234 => return remote(0x180 + node, source),
        235..=239 => return remote(0x280 + node, source),
        240..=243 if tables.lss => (cob_id::LSS_REQUEST, layer_setting(source).to_vec()),
        240..=247 => (source.number() as u16, bytes(source)),
        _ => {
            let frame = Frame::data(extended(source.number()), &bytes(source));
            return frame.expect("at most eight bytes");
        }
    };
    Frame::data(standard(id), &data).expect("at most eight bytes")
}

fn remote(id: u16, source: &mut impl Source) -> Frame {
    Frame::remote(standard(id), usize::from(source.byte() % 9)).expect("at most eight bytes")
}

/// An NMT command, mostly start, so that PDOs are sent.
fn nmt(source: &mut impl Source) -> u8 {
    match source.byte() {
        0..=149 => 1,
        150..=169 => 2,
        170..=209 => 128,
        210..=219 => 129,
        220..=239 => 130,
        _ => source.byte(),
    }
}

/// A request of layer setting services: mostly the switch to the configuration state and back, node-IDs and bit rates.
fn layer_setting(source: &mut impl Source) -> [u8; 8] {
    let argument = source.byte();
    let [command, first, second] = match source.byte() {
        0..=59 => [0x04, argument & 1, 0],
        60..=109 => [0x11, argument, 0],
        110..=139 => [0x13, 0, argument & 7],
        140..=159 => [0x15, argument, 0],
        160..=189 => [0x17, 0, 0],
        190..=219 => [0x5A + argument % 5, 0, 0],
        220..=239 => [0x40 + argument % 0x12, source.byte(), source.byte()],
        _ => return std::array::from_fn(|_| source.byte()),
    };
    [command, first, second, 0, 0, 0, 0, 0]
}

/// An SDO request with random data for one of the objects.
pub fn request(source: &mut impl Source, tables: &Tables, product: &Product) -> [u8; 8] {
    let objects = tables.objects;
    let object = &objects[usize::from(source.byte()) % objects.len()];
    let data_type = object.data_type(product.parameters, product.quantities);
    let [low, high] = object.index.to_le_bytes();
    let sub = object.sub + source.byte() % (object.count + 1);
    match source.byte() {
        0..=59 => [0x40, low, high, sub, 0, 0, 0, 0],
        60..=159 => {
            let size = match data_type.size() {
                0 => 1 + source.byte() % 4,
                size => size,
            };
            let [a, b, c, d] = number(object, product, source).to_le_bytes();
            [0x23 | (4 - size) << 2, low, high, sub, a, b, c, d]
        }
        // Segmented, mostly with the right size.
        160..=179 => {
            let sized = source.byte() & 1;
            let size = match source.byte() {
                0..=199 if data_type == DataType::Text => 16,
                0..=199 => data_type.size(),
                _ => source.byte(),
            };
            [0x20 | sized, low, high, sub, size, 0, 0, 0]
        }
        180..=209 => segment(source, data_type.size()),
        210..=234 => [0x60 | (source.byte() & 1) << 4, 0, 0, 0, 0, 0, 0, 0],
        235..=239 => [0x80, low, high, sub, 0, 0, 0, 0],
        _ => std::array::from_fn(|_| source.byte()),
    }
}

/// A segment of a download: of the printed programming key, or of a small number.
fn segment(source: &mut impl Source, size: u8) -> [u8; 8] {
    const KEY: &[u8; 16] = b"D0UfZEgRKHAI5Ag=";
    let mut bytes = [0; 8];
    let toggle = (source.byte() & 1) << 4;
    let (data, last) = match source.byte() % 8 {
        0 => (&KEY[..7], false),
        1 => (&KEY[7..14], false),
        2 => (&KEY[14..], true),
        3 => (&KEY[..7], true),
        _ => (&[1, 0, 0, 0][..usize::from(size)], true),
    };
    bytes[0] = toggle | (7 - data.len() as u8) << 1 | u8::from(last);
    bytes[1..=data.len()].copy_from_slice(data);
    bytes
}

/// A number, mostly a permitted one.
fn number(object: &Object, product: &Product, source: &mut impl Source) -> u32 {
    match object.service() {
        Some(Service::Store | Service::StoreGroup) => return u32::from_le_bytes(*b"save"),
        Some(Service::RestoreCommunication | Service::RestoreGroup) => {
            return u32::from_le_bytes(*b"load");
        }
        _ => {}
    }
    match object.target {
        Target::Parameter(_) if (0x1A00..0x1C00).contains(&object.index) => {
            mapping(object, product, source)
        }
        // Enabled or disabled, mostly the default.
        Target::FreeCobId(id) => {
            let base = product.parameters[usize::from(id.0)].factory & 0x7FF;
            let node_id = u32::from(factory_node_id(product));
            let other = if source.byte() < 32 {
                source.number() & 0x7FF
            } else {
                0
            };
            u32::from(source.byte() & 1) << 31 | (base + node_id) ^ other
        }
        Target::Parameter(id) | Target::Command(id, _) => {
            value(&product.parameters[usize::from(id.0)], source)
        }
        Target::Service(_) | Target::Own(_) => source.number() % 2,
        _ => source.number() % 300,
    }
}

/// Checks a frame that the sensor sent. Returns the node-ID if it is a boot-up message.
///
/// # Panics
/// If a CANopen sensor never sends such a frame.
pub fn check(frame: &Frame, tables: &Tables, product: &Product) -> Option<u8> {
    if has_free_cob_ids(tables) {
        return check_free(frame);
    }
    let embedded_can::Id::Standard(id) = frame.id() else {
        panic!("no 29-bit identifiers: {frame:?}");
    };
    let id = id.as_raw();
    let node_id = (id & 0x7F) as u8;
    let data = frame.bytes();
    let service = id & 0x780;
    let keeps = match service {
        cob_id::NMT => id == 0 && data == [1, 0],
        cob_id::EMCY | cob_id::SDO_REPLY => data.len() == 8,
        cob_id::ERROR_CONTROL => matches!(data, [0 | 4 | 5 | 127 | 0x84 | 0x85 | 0xFF]),
        _ => tpdos(tables, product).any(|tpdo| tpdo == (service, data.len())),
    };
    assert!(keeps && !frame.is_remote(), "{frame:?}");
    (service == cob_id::ERROR_CONTROL && data == [0]).then_some(node_id)
}

/// The number of mapped objects, or an entry with a mappable object.
fn mapping(object: &Object, product: &Product, source: &mut impl Source) -> u32 {
    let Protocol::Canopen(tables) = &product.protocol else {
        return 0;
    };
    let choice = source.byte();
    if object.sub == 0 {
        return u32::from(choice % 10);
    }
    let mappable: Vec<_> = tables.objects.iter().filter(|row| row.mappable).collect();
    let mapped = mappable[usize::from(choice) % mappable.len()];
    let data_type = mapped.data_type(product.parameters, product.quantities);
    profile::entry(mapped.index, mapped.sub, 8 * data_type.size())
}

/// Whether a master can change COB-IDs.
fn has_free_cob_ids(tables: &Tables) -> bool {
    let is_free = |object: &Object| matches!(object.target, Target::FreeCobId(_));
    tables.objects.iter().any(is_free)
}

/// The check for a sensor with free COB-IDs: only the services with fixed identifiers have a fixed form.
fn check_free(frame: &Frame) -> Option<u8> {
    let data = frame.bytes();
    let embedded_can::Id::Standard(id) = frame.id() else {
        assert_eq!(
            data.len(),
            8,
            "only an emergency message can have 29 bits: {frame:?}"
        );
        return None;
    };
    let id = id.as_raw();
    let keeps = match id {
        0x001..=0x080 | 0x101..=0x180 | 0x601..=0x67F | 0x6E0..=0x6FF => false,
        0x581..=0x5FF | cob_id::LSS_REPLY => data.len() == 8,
        0x701..=0x77F => matches!(data, [0 | 4 | 5 | 127]),
        0x780.. => false,
        _ => true,
    };
    assert!(keeps && !frame.is_remote(), "{frame:?}");
    let is_boot_up = matches!(id, 0x701..=0x77F) && data == [0];
    is_boot_up.then_some((id & 0x7F) as u8)
}

/// The identifier of each TPDO, for node 0, and the length of its data.
fn tpdos(tables: &Tables, product: &Product) -> impl Iterator<Item = (u16, usize)> {
    tables.objects.iter().filter_map(|object| {
        let (Target::CobId(id) | Target::FreeCobId(id)) = object.target else {
            return None;
        };
        let mapping = object.index.checked_add(0x200)?;
        let bits = tables.objects.iter().map(|entry| match entry.target {
            Target::Constant(entry_of) if entry.index == mapping && entry.sub > 0 => {
                entry_of & 0xFF
            }
            _ => 0,
        });
        let bits: u32 = bits.sum();
        let base = product.parameters[usize::from(id.0)].factory as u16;
        (0x1800..0x1A00)
            .contains(&object.index)
            .then_some((base, bits as usize / 8))
    })
}

/// Whether the angles are within the range of the sensor. A sensor with free offsets has no range.
pub fn is_possible(readout: Readout, tables: &Tables) -> bool {
    if has_free_offset(tables) {
        return true;
    }
    let y = readout.y.is_some_and(|y| (-18_000..36_000).contains(&y));
    (-18_000..=18_000).contains(&readout.x) && y
}

/// Whether the sensor adds an offset (3210h) to its angle.
fn has_free_offset(tables: &Tables) -> bool {
    tables.objects.iter().any(|object| object.index == 0x3210)
}
