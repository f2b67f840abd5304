//! The second part of a scan: which nodes the frames of a bus show.
//!
//! | frame | node |
//! |---|---|
//! | any identifier, `FF ss id id id id vv vv` twice | GEMAC, boot-up message: the Set-Parameter-ID |
//! | 701h to 77Fh, one byte 00h, 04h, 05h or 7Fh | CANopen, boot-up message or heartbeat |
//! | 29 bits, PGN EE00h, 8 bytes | J1939, address claim |
//! | 29 bits, PGN FECAh, priority 6, 8 bytes | J1939, diagnostic message 1 |
//! | 29 bits, PGN F013h, F029h, F02Ah or F02Dh, 8 bytes, twice | J1939, process data of an inclination sensor |
//! | 407h + 8 x MAC ID, 7 bytes, port 0 | DeviceNet, duplicate MAC ID check: vendor and serial number |
//! | process data of GEMAC, DeviceNet and CANopen | see the module `process_data` |
//!
//! If a node does not exist, a request to it can be a command to another device. The tool asks a node without a yes if its messages are
//! certain: GEMAC exactly twice at once, or alone on the bus; DeviceNet exactly twice with 1 s between them, or alone on the bus, without a
//! sign of CANopen or J1939; CANopen twice, or without a sign of DeviceNet. A node that is known by its process data is asked only after a
//! yes, because its address is likely at most; a slave that another master owns is not asked.

use super::listen::Frames;
use super::process_data::{self, Node};
use super::row::{By, Heard, Row};
use crate::error::RequestError;
use crate::master::devicenet::explicit::Slave;
use crate::master::fsc::boot_up::{BootUps, boot_up, is_repeated, may_be_asked};
use crate::master::fsc::factory_reply;
use crate::master::fsc::request::Sensor;
use crate::master::{Ca, Target, canopen};
use crate::number::shown;
use embedded_can::Id;
use plumbline::can::Frame;
use plumbline::canopen::cob_id::ERROR_CONTROL;
use plumbline::devicenet::identifiers::{group_2, group_2_id};
use plumbline::j1939::groups;
use plumbline::j1939::identifier::{
    ACTIVE_CODES, ADDRESS_CLAIMED, Identifier, NO_ADDRESS, PRIORITY,
};
use plumbline::time::{Instant, millis};

/// The time between the two messages of the check.
const CHECKS: std::ops::RangeInclusive<u64> = millis(900).ticks()..=millis(1100).ticks();

/// A node that a frame shows.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Sign {
    Fsc(Sensor),
    Canopen(u8),
    J1939 { address: u8, maker: Option<u16> },
    Devicenet { mac: u8, vendor: u16, serial: u32 },
}

impl Sign {
    fn protocol(self) -> &'static str {
        match self {
            Self::Fsc(_) => "fsc",
            Self::Canopen(_) => "canopen",
            Self::J1939 { .. } => "j1939",
            Self::Devicenet { .. } => "devicenet",
        }
    }

    /// The address for a question.
    fn target(self) -> Option<Target> {
        match self {
            Self::Fsc(sensor) => may_be_asked(sensor).then_some(Target::Fsc(sensor)),
            Self::Canopen(node) => Some(Target::Canopen(canopen::Node(node))),
            Self::J1939 { address, .. } => Some(Target::J1939(Ca(address))),
            Self::Devicenet { mac, .. } => Some(Target::Devicenet(Slave { mac })),
        }
    }
}

/// A node that the frames show.
pub struct Sighting {
    /// The row of the list.
    pub row: Row,
    /// Its address, if it can be asked and no other device uses its identifiers.
    pub target: Option<Target>,
    /// Its messages are messages of a sensor, so the tool asks it. The tool asks other nodes only after a yes.
    pub is_sure: bool,
    /// Its messages show the protocol of the bus.
    shows_protocol: bool,
}

impl Sighting {
    /// Its protocol and address, with what it has told besides in a message of its own; None: process data only, or no address.
    pub(crate) fn told(&self) -> Option<(String, String)> {
        let Row::Heard(heard) = &self.row else {
            return None;
        };
        let address = heard.address.as_ref().filter(|_| heard.by == By::Message)?;
        let told = format!("{:?} {:?}", heard.serial, heard.text);
        Some((format!("{} {address}", heard.protocol), told))
    }

    /// The name of its protocol in documents.
    fn protocol(&self) -> &'static str {
        self.row.address().0
    }
}

/// The nodes that the frames show, each once, in the order of their first frame.
pub fn sightings(frames: &Frames) -> Vec<Sighting> {
    let mut signs: Vec<(Sign, Vec<Instant>)> = Vec::new();
    for (at, frame) in frames {
        let Some(sign) = sign(frame) else {
            continue;
        };
        match signs.iter_mut().find(|(own, _)| *own == sign) {
            Some((_, times)) => times.push(*at),
            None => signs.push((sign, vec![*at])),
        }
    }
    let boot_ups = BootUps::of(frames);
    // The claim tells more than the process data of the same node.
    let claims = signs.iter().filter_map(|(sign, _)| match sign {
        Sign::J1939 {
            address,
            maker: Some(_),
        } => Some(*address),
        _ => None,
    });
    let claims: Vec<u8> = claims.collect();
    signs.retain(|(sign, _)| {
        !matches!(sign, Sign::J1939 { address, maker: None } if claims.contains(address))
    });
    let has = |protocol| signs.iter().any(|(sign, _)| sign.protocol() == protocol);
    let is_other_bus = has("canopen") || has("j1939");
    let is_devicenet = has("devicenet");
    let mut sightings: Vec<Sighting> = Vec::new();
    for (sign, times) in signs {
        let count = times.len();
        let is_sure = match sign {
            // One frame can be anything.
            Sign::Fsc(_) if count < 2 => continue,
            Sign::Fsc(sensor) => boot_ups.is_sure(sensor),
            Sign::Devicenet { .. } => !is_other_bus && is_check(&times, frames.len()),
            Sign::Canopen(_) => count >= 2 || !is_devicenet,
            Sign::J1939 { address, maker } => {
                maker.is_some() || count >= 2 || is_diagnosed(address, frames)
            }
        };
        sightings.push(Sighting {
            row: row(sign),
            target: sign.target().filter(|target| !is_used(*target, frames)),
            is_sure,
            shows_protocol: is_sure,
        });
    }
    let mut sure = sightings.iter().filter(|own| own.shows_protocol);
    let is_other = sure.any(|own| own.protocol() != "fsc");
    for node in process_data::nodes(frames, is_other) {
        if let Some(sighting) = by_process_data(node, &sightings, &boot_ups, frames) {
            sightings.push(sighting);
        }
    }
    sightings
}

/// The MAC IDs that several DeviceNet nodes have told, which are different by vendor and serial number. Only one of them goes on-line.
pub(super) fn twins(sightings: &[Sighting]) -> Vec<RequestError> {
    let told = |sighting: &Sighting| match &sighting.row {
        Row::Heard(Heard {
            protocol: "devicenet",
            address: Some(mac),
            serial: Some(serial),
            ..
        }) => Some((mac.clone(), serial.to_string())),
        _ => None,
    };
    let mut macs: Vec<(String, Vec<String>)> = Vec::new();
    for (mac, serial) in sightings.iter().filter_map(told) {
        match macs.iter_mut().find(|(own, _)| *own == mac) {
            Some((_, serials)) => serials.push(serial),
            None => macs.push((mac, vec![serial])),
        }
    }
    macs.retain(|(_, serials)| serials.len() > 1);
    let error = |(mac, serials): (_, Vec<String>)| {
        RequestError::TwinMacs(serials.len(), mac, serials.join(" and "))
    };
    macs.into_iter().map(error).collect()
}

/// A node that is known by its process data alone; None: it has told its address, or the bus has another protocol.
fn by_process_data(
    node: Node,
    known: &[Sighting],
    boot_ups: &BootUps,
    frames: &Frames,
) -> Option<Sighting> {
    let mut others = known.iter().filter(|sighting| sighting.shows_protocol);
    let (protocol, number) = match node {
        Node::Cyclic { reply, axes } => {
            if boot_ups.is_reply(reply) {
                return None;
            }
            let request = factory_reply(reply);
            let kind = if axes == 1 { "angle" } else { "angles" };
            let row = Heard {
                protocol: "fsc",
                address: None,
                serial: None,
                text: Some(format!("GEMAC, {axes} {kind} at {}", shown(reply))),
                by: By::Cyclic { reply, request },
            };
            let sensor = request.map(|request| Sensor {
                request,
                reply: Some(reply),
            });
            return Some(Sighting {
                row: Row::Heard(row),
                target: sensor
                    .map(Target::Fsc)
                    .filter(|target| !is_used(*target, frames)),
                is_sure: false,
                shows_protocol: request.is_some() && others.next().is_none(),
            });
        }
        Node::Slave { mac, .. } => ("devicenet", mac),
        Node::Pdo { node, .. } => ("canopen", node),
    };
    if others.any(|sighting| sighting.protocol() != protocol)
        || known
            .iter()
            .any(|own| own.row.address() == (protocol, Some(number.to_string())))
    {
        return None;
    }
    let (by, text, target) = match node {
        Node::Slave { is_sure: true, .. } => (By::Owned, "I/O of another master".to_owned(), None),
        Node::Slave { .. } => (By::Likely, "likely, by its I/O messages".to_owned(), None),
        Node::Pdo { node, id } => {
            let text = format!("likely, by a TPDO ({id:03X}h)");
            (By::Likely, text, Some(Target::Canopen(canopen::Node(node))))
        }
        Node::Cyclic { .. } => return None,
    };
    let row = Heard {
        protocol,
        address: Some(number.to_string()),
        serial: None,
        text: Some(text),
        by,
    };
    Some(Sighting {
        row: Row::Heard(row),
        target: target.filter(|target| !is_used(*target, frames)),
        is_sure: false,
        shows_protocol: by == By::Owned,
    })
}

/// Whether messages at these times belong to a duplicate MAC ID check: exactly two, or repeated by a node that is alone on the bus. A
/// cyclic frame with constant data looks like them.
fn is_check(times: &[Instant], all: usize) -> bool {
    let is_alone = times.len() == all
        && matches!(times, [first, .., last] if is_repeated(all as u32, *first, *last));
    let is_pair =
        matches!(times, [first, second] if CHECKS.contains(&(second.ticks() - first.ticks())));
    is_alone || is_pair
}

/// Whether a J1939 node has sent its diagnostic message, which comes once a second.
fn is_diagnosed(address: u8, frames: &Frames) -> bool {
    let mut ids = frames.iter().filter_map(|(_, frame)| Identifier::of(frame));
    ids.any(|id| id.source == address && id.pgn == ACTIVE_CODES && id.priority == PRIORITY)
}

/// The protocol of the bus, if the frames show it for sure. One bus has one protocol.
pub fn protocol(sightings: &[Sighting]) -> Option<&'static str> {
    let mut sure = sightings.iter().filter(|sighting| sighting.shows_protocol);
    sure.next().map(Sighting::protocol)
}

/// Whether the frames show that another node uses an identifier of the questions to an address, or of their answers.
pub fn is_used(target: Target, frames: &Frames) -> bool {
    let ids = target.identifiers();
    frames
        .iter()
        .any(|(_, frame)| ids.contains(&frame.can_id()))
}

fn sign(frame: &Frame) -> Option<Sign> {
    if frame.is_remote() {
        return None;
    }
    if let Some(sensor) = boot_up(frame) {
        return Some(Sign::Fsc(sensor));
    }
    match (frame.id(), frame.bytes()) {
        (Id::Standard(id), [0x00 | 0x04 | 0x05 | 0x7F])
            if (0x701..=0x77F).contains(&id.as_raw()) =>
        {
            Some(Sign::Canopen((id.as_raw() - ERROR_CONTROL) as u8))
        }
        (Id::Standard(id), &[port, v0, v1, s0, s1, s2, s3]) if port & 0x7F == 0 => {
            let mac = (id.as_raw() >> 3 & 0x3F) as u8;
            let is_check = id.as_raw() == group_2_id(mac, group_2::DUPLICATE_CHECK);
            is_check.then(|| Sign::Devicenet {
                mac,
                vendor: u16::from_le_bytes([v0, v1]),
                serial: u32::from_le_bytes([s0, s1, s2, s3]),
            })
        }
        (Id::Extended(_), &[_, _, n2, n3, _, _, _, _]) => {
            let id = Identifier::of(frame).filter(|id| id.source < NO_ADDRESS)?;
            let maker = match id.pgn {
                ADDRESS_CLAIMED => Some(u16::from(n3) << 3 | u16::from(n2 >> 5)),
                pgn if pgn == ACTIVE_CODES || groups::place(pgn).is_some() => None,
                _ => return None,
            };
            Some(Sign::J1939 {
                address: id.source,
                maker,
            })
        }
        _ => None,
    }
}

fn row(sign: Sign) -> Row {
    let (address, serial, text) = match sign {
        Sign::Fsc(sensor) => {
            let address = shown(sensor.request).trim_end_matches('h').to_owned();
            (address, None, None)
        }
        Sign::Canopen(node) => (node.to_string(), None, None),
        Sign::J1939 { address, maker } => (
            address.to_string(),
            None,
            maker.map(|maker| format!("manufacturer {maker}")),
        ),
        Sign::Devicenet {
            mac,
            vendor,
            serial,
        } => (
            mac.to_string(),
            Some(serial),
            Some(format!("vendor {vendor}")),
        ),
    };
    Row::Heard(Heard {
        protocol: sign.protocol(),
        address: Some(address),
        serial,
        text,
        by: By::Message,
    })
}

#[cfg(test)]
mod tests;
