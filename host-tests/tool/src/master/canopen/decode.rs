//! The messages of CANopen. A node is known by its boot-up message or heartbeat, or by its answers to SDO requests.

mod pdo;
pub(crate) mod sdo;

use super::{PROTOCOL, tables};
use crate::decode::{Decoded, Decoder, Device, Known, Named};
use crate::sheet::Address;
use pdo::{Heard, Pdo};
use plumbline::can::Frame;
use plumbline::canopen::cob_id::{
    EMCY, ERROR_CONTROL, LSS_REPLY, LSS_REQUEST, NMT, SDO_REPLY, SDO_REQUEST,
};
use plumbline::canopen::dictionary::Target;
use plumbline::canopen::lss::{answer, command};
use plumbline::param::number;
use sdo::Transfer;
use std::collections::BTreeMap;

/// A node.
struct Node {
    device: Device,
    /// It has sent a message that only CANopen has.
    is_known: bool,
    transfer: Transfer,
    heard: Heard,
    pdos: Vec<Pdo>,
}

/// The nodes on the bus.
struct Nodes {
    known: Known,
    nodes: BTreeMap<u8, Node>,
}

/// A decoder for these products.
pub(super) fn decoder(known: Known) -> Box<dyn Decoder> {
    Box::new(Nodes {
        known,
        nodes: BTreeMap::new(),
    })
}

/// The first object that the product defines, not CiA 301. Its name and value are not known before the product is.
const OWN: u16 = 0x2000;

/// The first error code that the maker defines.
const OWN_CODE: u16 = 0xFF00;

/// Whether it is known what an object of a device means.
pub(crate) fn is_understood(device: &Device, index: u16) -> bool {
    index < OWN || device.is_identified()
}

/// The name of an object: index, sub-index and the name in the dictionary.
pub(crate) fn object(device: &Device, index: u16, sub: u8) -> String {
    let place = format!("{index:04X}h:{sub}");
    if !is_understood(device, index) {
        return place;
    }
    let entry = device.entry(Address::Object { index, sub });
    let name = entry.map(|entry| entry.name).or_else(|| {
        device.agreed(|product| {
            let mut objects = tables(product)?.objects.iter();
            let object = objects.find(|own| (own.index, own.sub) == (index, sub))?;
            Some(crate::sheet::kebab(object.name)).filter(|name| !name.is_empty())
        })
    });
    match name {
        Some(name) => format!("{place} {name}"),
        None => place,
    }
}

/// Only products with this number in the identity object can be the device.
pub(crate) fn learn(device: &mut Device, index: u16, sub: u8, data: &[u8]) {
    if index != 0x1018 || !matches!(sub, 1 | 2) || data.len() != 4 {
        return;
    }
    let told = number(data);
    device.identify(usize::from(sub) - 1, told, |product| {
        tables(product).is_some_and(|tables| {
            let mut objects = tables.objects.iter();
            objects.any(|own| {
                (own.index, own.sub) == (index, sub) && own.target == Target::Constant(told)
            })
        })
    });
}

impl Decoder for Nodes {
    fn decode(&mut self, frame: &Frame) -> Option<Decoded> {
        let id = u16::try_from(frame.can_id().bits()).ok()?;
        let node = (id & 0x7F) as u8;
        let data = frame.bytes();
        match id {
            NMT | 0x100 | LSS_REPLY | LSS_REQUEST if !frame.is_remote() => common(id, data),
            EMCY if data.len() <= 1 && !frame.is_remote() => {
                let counter = data
                    .first()
                    .map(|counter| Named::number("counter", *counter));
                Some(Decoded::new(&PROTOCOL, "SYNC").with(counter.into_iter().collect()))
            }
            _ if id & 0x780 == ERROR_CONTROL && node != 0 => self.error_control(node, frame),
            _ if id & 0x780 == SDO_REQUEST && node != 0 => self.sdo(node, frame, true),
            _ if id & 0x780 == SDO_REPLY && node != 0 => self.sdo(node, frame, false),
            _ if id & 0x780 == EMCY && data.len() == 8 => self.emergency(node, data),
            0x181..=0x57F => self.pdo(frame),
            _ => None,
        }
    }
}

impl Nodes {
    fn node(&mut self, node: u8) -> &mut Node {
        let device = self.known.device();
        self.nodes.entry(node).or_insert_with(|| {
            let heard = Heard::new();
            Node {
                pdos: pdo::pdos(&device, node, &heard),
                is_known: device.is_told(),
                device,
                transfer: Transfer::default(),
                heard,
            }
        })
    }

    fn error_control(&mut self, node: u8, frame: &Frame) -> Option<Decoded> {
        let message = match frame.bytes() {
            _ if frame.is_remote() => "node guarding request".to_owned(),
            [0] => "boot-up".to_owned(),
            [state] => format!("heartbeat, {}", state_name(state & 0x7F)?),
            _ => return None,
        };
        let own = self.node(node);
        own.is_known = true;
        if frame.bytes() == [0] {
            own.transfer = Transfer::default();
        }
        Some(Decoded::new(&PROTOCOL, message).of(node, &own.device))
    }

    fn sdo(&mut self, node: u8, frame: &Frame, is_request: bool) -> Option<Decoded> {
        let bytes: [u8; 8] = frame.bytes().try_into().ok()?;
        let own = self.node(node);
        let Node {
            device, transfer, ..
        } = own;
        let message = match is_request {
            true => transfer.request(device, bytes),
            false => transfer.answer(device, bytes),
        }?;
        if let Some((index, sub, data)) = &message.done {
            if !is_request {
                learn(device, *index, *sub, data);
            }
            if pdo::is_of_pdo(*index) && data.len() <= 4 {
                own.heard.insert((*index, *sub), number(data));
            }
            own.pdos = pdo::pdos(&own.device, node, &own.heard);
        }
        let decoded = Decoded::new(&PROTOCOL, message.text).with(message.values);
        let mut done = message.done.iter();
        let needs_product = done.any(|(index, ..)| !is_understood(&own.device, *index));
        Some(Decoded {
            is_sure: own.is_known,
            needs_product,
            ..decoded.of(node, &own.device)
        })
    }

    fn emergency(&mut self, node: u8, data: &[u8]) -> Option<Decoded> {
        let (code, register) = (number(&data[..2]) as u16, data[2]);
        let own = self.nodes.get(&node).filter(|own| own.is_known)?;
        let name = own.device.agreed(|product| {
            let tables = tables(product)?;
            let mut faults = tables.faults.iter().chain(tables.events);
            let fault = faults.find(|fault| fault.code == code && !fault.name.is_empty())?;
            Some(fault.name)
        });
        let name = name.filter(|_| code < OWN_CODE || own.device.is_identified());
        let text = match (code, name) {
            (0, _) => "no error (0000h)".to_owned(),
            (_, Some(name)) => format!("{name} ({code:04X}h)"),
            (_, None) => format!("{code:04X}h"),
        };
        let values = vec![
            Named::text("error", text),
            Named::text("error-register", format!("{register:02X}h")),
            Named::bytes(&data[3..]),
        ];
        let decoded = Decoded::new(&PROTOCOL, "EMCY").with(values);
        Some(decoded.of(node, &own.device))
    }

    fn pdo(&mut self, frame: &Frame) -> Option<Decoded> {
        let id = frame.can_id();
        let device = self.known.device();
        if device.is_identified() {
            self.node((id.bits() & 0x7F) as u8);
        }
        let nodes = self.nodes.iter_mut().filter_map(|(node, own)| {
            let is_own = own.is_known || own.device.is_described();
            let pdo = own.pdos.iter().find(|pdo| pdo.id == id && is_own)?;
            Some((node, pdo.clone(), own))
        });
        // The first one that is known, or the first one.
        if let Some((node, pdo, own)) = nodes.min_by_key(|(_, _, own)| !own.is_known) {
            let decoded = match frame.is_remote() {
                true => Decoded::new(&PROTOCOL, format!("{} request", pdo.name)),
                false if !own.device.is_identified() => {
                    Decoded::new(&PROTOCOL, pdo.name).needing_product(frame.bytes())
                }
                false => {
                    let values = pdo::values(&pdo, &mut own.device, frame.bytes());
                    Decoded::new(&PROTOCOL, pdo.name).with(values)
                }
            };
            return Some(Decoded {
                is_sure: own.is_known,
                ..decoded.of(node, &own.device)
            });
        }
        // The node of the default identifier. Its mapping is not known.
        let (place, node) = ((id.bits() >> 7) as u16, (id.bits() & 0x7F) as u8);
        let own = self.nodes.get(&node);
        if node == 0 || frame.is_remote() {
            return None;
        }
        let direction = if place % 2 == 1 { "TPDO" } else { "RPDO" };
        let number = if place % 2 == 1 {
            place / 2 - 1
        } else {
            place / 2 - 2
        } + 1;
        // Any machine can use the identifier of a PDO.
        let own = own.filter(|own| own.is_known)?;
        let decoded = Decoded::new(&PROTOCOL, format!("{direction} {number}"));
        let decoded = match own.device.is_identified() {
            true => decoded.with(vec![Named::bytes(frame.bytes())]),
            false => decoded.needing_product(frame.bytes()),
        };
        Some(decoded.of(node, &own.device))
    }
}

fn state_name(state: u8) -> Option<&'static str> {
    match state {
        0 => Some("initialising"),
        4 => Some("stopped"),
        5 => Some("operational"),
        0x7F => Some("pre-operational"),
        _ => None,
    }
}

/// The messages without a node in their identifier.
fn common(id: u16, data: &[u8]) -> Option<Decoded> {
    let decoded = match (id, data) {
        (NMT, [specifier, node]) => {
            let name = match specifier {
                1 => "start",
                2 => "stop",
                0x80 => "enter pre-operational",
                0x81 => "reset node",
                0x82 => "reset communication",
                _ => return None,
            };
            let decoded = Decoded::new(&PROTOCOL, format!("NMT {name}"));
            Decoded {
                node: (*node != 0).then(|| node.to_string()),
                ..decoded
            }
        }
        (0x100, data) if data.len() == 6 => {
            Decoded::new(&PROTOCOL, "TIME").with(vec![Named::bytes(data)])
        }
        (LSS_REQUEST | LSS_REPLY, [code, rest @ ..]) if data.len() == 8 => {
            lss(id == LSS_REPLY, *code, rest)?
        }
        _ => return None,
    };
    Some(decoded)
}

/// A message of layer setting services.
fn lss(is_answer: bool, code: u8, data: &[u8]) -> Option<Decoded> {
    let number = |name: &str| vec![Named::text(name, format!("{:X}h", number(&data[..4])))];
    let byte = |name: &str| vec![Named::number(name, data[0])];
    let result = || match is_answer {
        true => byte("error"),
        false => Vec::new(),
    };
    let (name, values) = match code {
        command::SWITCH_GLOBAL => {
            let state = if data[0] == 0 {
                "waiting"
            } else {
                "configuration"
            };
            ("switch state global", vec![Named::text("state", state)])
        }
        command::NODE_ID if is_answer => ("configure node-ID", byte("error")),
        command::NODE_ID => ("configure node-ID", byte("node-id")),
        command::BIT_TIMING if is_answer => ("configure bit timing", byte("error")),
        command::BIT_TIMING => (
            "configure bit timing",
            vec![
                Named::number("table", data[0]),
                Named::number("place", data[1]),
            ],
        ),
        command::ACTIVATE => (
            "activate bit timing",
            vec![Named::number(
                "delay",
                u16::from_le_bytes([data[0], data[1]]),
            )],
        ),
        command::STORE => ("store configuration", result()),
        command::SELECT..=command::SELECT_LAST => ("switch state selective", number("number")),
        answer::SELECTED => ("switch state selective, selected", Vec::new()),
        command::IDENTIFY..=command::IDENTIFY_LAST => ("identify remote slave", number("number")),
        command::IDENTIFY_UNCONFIGURED => ("identify non-configured remote slave", Vec::new()),
        answer::IDENTIFIED => ("identified", Vec::new()),
        answer::UNCONFIGURED => ("node without node-ID", Vec::new()),
        command::FASTSCAN => (
            "fastscan",
            [
                number("number"),
                vec![
                    Named::number("bit", data[4]),
                    Named::number("sub", data[5]),
                    Named::number("next", data[6]),
                ],
            ]
            .concat(),
        ),
        command::INQUIRE..=command::INQUIRE_LAST if is_answer => {
            ("inquire identity", number("number"))
        }
        command::INQUIRE..=command::INQUIRE_LAST => ("inquire identity", Vec::new()),
        command::INQUIRE_NODE_ID if is_answer => ("inquire node-ID", byte("node-id")),
        command::INQUIRE_NODE_ID => ("inquire node-ID", Vec::new()),
        _ => return None,
    };
    let kind = if is_answer { "LSS answer" } else { "LSS" };
    Some(Decoded::new(&PROTOCOL, format!("{kind} {name}")).with(values))
}
