//! How a scan recognises CANopen nodes.
//!
//! | frames | node |
//! |---|---|
//! | 701h to 77Fh, one byte 00h, 04h, 05h or 7Fh | boot-up message or heartbeat; sure twice, or without a sign of DeviceNet |
//! | 181h to 1FFh, 281h, 381h, 481h .., if all others are of CANopen, and one is a sign of it or all have one node-ID | likely: the node-ID of the default COB-ID |

use super::{Node, PROTOCOL};
use crate::master::{Target, devicenet};
use crate::scan::row::{By, Heard};
use crate::scan::signs::{Bus, Judge, Shown, Sign, Signs, is_steady};
use embedded_can::Id;
use plumbline::can::{CanId, Frame};
use plumbline::canopen::cob_id::ERROR_CONTROL;

pub(super) const SIGNS: Signs = Signs {
    node,
    is_own: true,
    judge,
    process_data,
    twins: None,
};

fn node(frame: &Frame) -> Option<Sign> {
    match (frame.id(), frame.bytes()) {
        (Id::Standard(id), [0x00 | 0x04 | 0x05 | 0x7F])
            if (0x701..=0x77F).contains(&id.as_raw()) =>
        {
            let node = (id.as_raw() - ERROR_CONTROL) as u8;
            Some(Target::Canopen(Node(node)).into())
        }
        _ => None,
    }
}

fn judge<'a>(bus: &'a Bus) -> Judge<'a> {
    let is_devicenet = bus.has(&devicenet::PROTOCOL);
    Box::new(move |seen| Some(seen.times.len() >= 2 || !is_devicenet))
}

/// The TPDOs with their default COB-IDs.
fn process_data(bus: &Bus) -> Vec<Shown> {
    let is_canopen = bus.all_are(is_canopen_id)
        && (bus.frames.iter().any(|(_, frame)| is_sign(frame)) || is_one_node(&bus.ids));
    if !is_canopen || bus.is_other(&PROTOCOL) {
        return Vec::new();
    }
    let shown = bus.ids.iter().filter_map(|id| {
        let standard = u16::try_from(id.bits()).ok()?;
        let node = (standard & 0x7F) as u8;
        let is_tpdo = matches!(standard & 0x780, 0x180 | 0x280 | 0x380 | 0x480) && node != 0;
        (is_tpdo && is_steady(&bus.with(*id).1)).then(|| Shown {
            id: *id,
            heard: Heard {
                protocol: PROTOCOL.name,
                address: Some(node.to_string()),
                serial: None,
                text: Some(format!("likely, by a TPDO ({standard:03X}h)")),
                by: By::Likely,
            },
            target: Some(Target::Canopen(Node(node))),
        })
    });
    shown.collect()
}

/// Whether CANopen has a message with this identifier.
fn is_canopen_id(id: u16) -> bool {
    match id {
        0x000 | 0x100 | 0x7E4 | 0x7E5 => true,
        0x080..=0x0FF => true,
        0x181..=0x67F | 0x701..=0x77F => id & 0x7F != 0,
        _ => false,
    }
}

/// Whether a frame of 11 bits is one that only CANopen has: NMT, SYNC, heartbeat. Any machine can use the identifiers of PDOs.
fn is_sign(frame: &Frame) -> bool {
    match (frame.can_id().bits(), frame.bytes()) {
        (0x000, [1 | 2 | 0x80..=0x82, node]) => *node <= 127,
        (0x080, [] | [_]) => !frame.is_remote(),
        (0x701..=0x77F, [0x00 | 0x04 | 0x05 | 0x7F]) => true,
        _ => false,
    }
}

/// Whether all these identifiers of 11 bits belong to one node-ID.
fn is_one_node(ids: &[CanId]) -> bool {
    let is_of_node = |id: &&CanId| !matches!(id.bits(), 0x000 | 0x080 | 0x100 | 0x7E4 | 0x7E5);
    let mut nodes = ids.iter().filter(is_of_node).map(|id| id.bits() & 0x7F);
    let first = nodes.next();
    nodes.all(|node| Some(node) == first)
}
