//! How a scan recognises DeviceNet slaves.
//!
//! | frames | slave |
//! |---|---|
//! | 407h + 8 x MAC ID, 7 bytes, port 0 | duplicate MAC ID check: vendor and serial number; sure exactly twice with 1 s between them, or alone on the bus, without a sign of CANopen or J1939 |
//! | 3C0h + MAC ID, each after 405h + 8 x MAC ID | poll: another master owns the slave |
//! | 340h + MAC ID, each before 402h + 8 x MAC ID | change of state or cyclic with acknowledge: another master owns the slave |
//! | 340h + MAC ID, if all others are of DeviceNet | likely |

use super::PROTOCOL;
use super::explicit::Slave;
use crate::error::RequestError;
use crate::master::Target;
use crate::master::fsc::boot_up::is_repeated;
use crate::scan::row::{By, Heard};
use crate::scan::signs::{Bus, Judge, Shown, Sign, Signs, is_steady};
use embedded_can::Id;
use plumbline::can::{CanId, Frame};
use plumbline::devicenet::identifiers::{Group1, MAC_MAX, group_2, group_2_id};
use plumbline::time::{Instant, millis};

/// The time between the two messages of the check.
const CHECKS: std::ops::RangeInclusive<u64> = millis(900).ticks()..=millis(1100).ticks();

pub(super) const SIGNS: Signs = Signs {
    node,
    is_own: true,
    judge,
    process_data,
    // Only one of them goes on-line.
    twins: Some(RequestError::TwinMacs),
};

fn node(frame: &Frame) -> Option<Sign> {
    let (Id::Standard(id), &[port, v0, v1, s0, s1, s2, s3]) = (frame.id(), frame.bytes()) else {
        return None;
    };
    let mac = (id.as_raw() >> 3 & 0x3F) as u8;
    let is_check = port & 0x7F == 0 && id.as_raw() == group_2_id(mac, group_2::DUPLICATE_CHECK);
    is_check.then(|| Sign {
        target: Target::Devicenet(Slave { mac }),
        serial: Some(u32::from_le_bytes([s0, s1, s2, s3])),
        text: Some(format!("vendor {}", u16::from_le_bytes([v0, v1]))),
    })
}

fn judge<'a>(bus: &'a Bus) -> Judge<'a> {
    let is_other = bus.has_other(&PROTOCOL);
    Box::new(move |seen| Some(!is_other && is_check(&seen.times, bus.frames.len())))
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

/// The slaves that send I/O messages.
fn process_data(bus: &Bus) -> Vec<Shown> {
    // Whether a slave or its master has a message with this identifier.
    let is_devicenet = bus.all_are(|id| id >= Group1::ChangeOrCyclic.id(0));
    if !is_devicenet || bus.is_other(&PROTOCOL) {
        return Vec::new();
    }
    let shown = bus.ids.iter().filter_map(|id| slave(*id, bus));
    shown.collect()
}

/// A slave that sends I/O messages with this identifier.
fn slave(id: CanId, bus: &Bus) -> Option<Shown> {
    let standard = u16::try_from(id.bits()).ok()?;
    let mac = (standard & u16::from(MAC_MAX)) as u8;
    let is_poll = standard == Group1::PollResponse.id(mac);
    if !is_poll && standard != Group1::ChangeOrCyclic.id(mac) {
        return None;
    }
    // A poll comes before its response. An acknowledge comes after its message.
    let other = match is_poll {
        true => group_2::POLL,
        false => group_2::ACKNOWLEDGE,
    };
    let other = CanId::standard(group_2_id(mac, other));
    let both = bus.frames.iter().map(|(_, frame)| frame.can_id());
    let both: Vec<CanId> = both.filter(|own| [id, other].contains(own)).collect();
    let wanted = if is_poll { [other, id] } else { [id, other] };
    let pairs = both.windows(2).filter(|pair| *pair == wanted).count();
    let (by, text) = match pairs >= 2 {
        true => (By::Owned, "I/O of another master"),
        false if is_poll || !is_steady(&bus.with(id).1) => return None,
        false => (By::Likely, "likely, by its I/O messages"),
    };
    let heard = Heard {
        protocol: PROTOCOL.name,
        address: Some(mac.to_string()),
        serial: None,
        text: Some(text.to_owned()),
        by,
    };
    // The master owns the slave, or another device sends the messages.
    Some(Shown {
        id,
        heard,
        target: None,
    })
}
