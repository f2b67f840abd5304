//! The PDOs of a node: their identifiers and mapped objects, from the tables, or from transfers that were heard.

use crate::decode::{Device, Named};
use crate::master::canopen::tables;
use crate::sheet::Address;
use plumbline::can::CanId;
use plumbline::canopen::cob_id::DISABLED;
use plumbline::canopen::dictionary::Target;
use plumbline::model::catalog::Product;
use plumbline::param::number;
use std::collections::HashMap;

/// The maximum number of PDOs in each direction, of those that the catalogue has.
const COUNT: u16 = 4;

/// The maximum number of mapped objects.
const OBJECTS: u8 = 8;

/// The first communication parameter of the TPDOs and of the RPDOs.
const DIRECTIONS: [(u16, &str); 2] = [(0x1800, "TPDO"), (0x1400, "RPDO")];

/// The first mapping parameter, from the communication parameter.
const MAPPING: u16 = 0x200;

/// The numbers of objects that were heard.
pub(super) type Heard = HashMap<(u16, u8), u32>;

/// Whether an object changes the PDOs.
pub(super) fn is_of_pdo(index: u16) -> bool {
    matches!(index, 0x1400..=0x1BFF)
}

/// A PDO.
#[derive(Clone, Debug)]
pub(super) struct Pdo {
    pub id: CanId,
    pub name: String,
    objects: Vec<(u16, u8, u8)>,
}

/// The PDOs that are on, as far as all possible products have the same.
pub(super) fn pdos(device: &Device, node: u8, heard: &Heard) -> Vec<Pdo> {
    let mut all = Vec::new();
    for (first, direction) in DIRECTIONS {
        for place in 0..COUNT {
            let get = |index: u16, sub: u8| {
                let heard = heard.get(&(index, sub)).copied();
                let own = || device.agreed(|product| factory(product, node, index, sub));
                heard
                    .or_else(own)
                    .or_else(|| described(device, node, index, sub))
            };
            let Some(cob_id) = get(first + place, 1).filter(|cob_id| cob_id & DISABLED == 0) else {
                continue;
            };
            let mapping = first + place + MAPPING;
            let count = get(mapping, 0).unwrap_or(0).min(OBJECTS.into()) as u8;
            let objects = (1..=count).map_while(|sub| get(mapping, sub));
            let objects = objects.map(|entry| {
                let [bits, sub, low, high] = entry.to_le_bytes();
                (u16::from_le_bytes([low, high]), sub, bits)
            });
            all.push(Pdo {
                id: CanId::standard((cob_id & 0x7FF) as u16),
                name: format!("{direction} {}", place + 1),
                objects: objects.collect(),
            });
        }
    }
    all
}

/// The number of an object as delivered.
fn factory(product: &Product, node: u8, index: u16, sub: u8) -> Option<u32> {
    let mut objects = tables(product)?.objects.iter();
    let object = objects.find(|object| (object.index, object.sub) == (index, sub))?;
    let parameter = |id: plumbline::param::ParameterId| {
        Some(product.parameters.get(usize::from(id.0))?.factory)
    };
    match object.target {
        Target::Constant(number) => Some(number),
        Target::NodeRelative(number) => Some(number + u32::from(node)),
        Target::Parameter(id) => parameter(id),
        Target::CobId(id) | Target::FreeCobId(id) => Some(parameter(id)? + u32::from(node)),
        _ => None,
    }
}

/// The same by the data sheet (EDS) of a device that is not in the catalogue.
fn described(device: &Device, node: u8, index: u16, sub: u8) -> Option<u32> {
    let entry = device.entry(Address::Object { index, sub })?;
    let added = if entry.node_relative { node.into() } else { 0 };
    Some(entry.factory?.wrapping_add(added))
}

/// The values of the mapped objects in the data of a PDO.
pub(super) fn values(pdo: &Pdo, device: &mut Device, data: &[u8]) -> Vec<Named> {
    let mut place = 0;
    let mut values = Vec::new();
    for (index, sub, bits) in &pdo.objects {
        let size = usize::from(bits / 8);
        let Some(bytes) = data.get(place..place + size).filter(|_| bits % 8 == 0) else {
            break;
        };
        place += size;
        let entry = device.entry(Address::Object {
            index: *index,
            sub: *sub,
        });
        values.push(match entry {
            Some(entry) => device.value(&entry, bytes),
            None => Named::text(
                format!("{index:04X}h:{sub}"),
                format!("{:0digits$X}h", number(bytes), digits = 2 * size),
            ),
        });
    }
    if place < data.len() {
        values.push(Named::bytes(&data[place..]));
    }
    values
}
