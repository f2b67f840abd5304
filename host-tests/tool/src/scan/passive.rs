//! The second part of a scan: which nodes the frames of a bus show.
//!
//! | frame | node |
//! |---|---|
//! | any identifier, `FF ss id id id id vv vv` twice | GEMAC, boot-up message: the Set-Parameter-ID |
//! | 701h to 77Fh, one byte 00h, 04h, 05h or 7Fh | CANopen, boot-up message or heartbeat |
//! | 29 bits, PGN EE00h, 8 bytes | J1939, address claim |
//! | 407h + 8 x MAC ID, 7 bytes, port 0 | DeviceNet, duplicate MAC ID check: vendor and serial number |

use super::Row;
use crate::client::devicenet::Slave;
use crate::client::fsc::shown;
use crate::identify::boot_up;
use crate::session::Target;
use embedded_can::Id;
use plumbline::can::Frame;
use plumbline::devicenet::identifiers::{group_2, group_2_id};
use plumbline::time::{Duration, millis};

/// The duplicate MAC ID check of DeviceNet: the node answers after two seconds.
const CHECK: Duration = millis(3000);

/// A node that a frame shows.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Sign {
    Fsc(crate::client::fsc::Sensor),
    Canopen(u8),
    J1939 { address: u8, maker: u16 },
    Devicenet { mac: u8, vendor: u16, serial: u32 },
}

/// The nodes that the frames show, each once, in the order of their first frame.
pub fn rows(frames: &[Frame]) -> Vec<Row> {
    let mut signs: Vec<(Sign, usize)> = Vec::new();
    for sign in frames.iter().filter_map(sign) {
        match signs.iter_mut().find(|(own, _)| *own == sign) {
            Some((_, count)) => *count += 1,
            None => signs.push((sign, 1)),
        }
    }
    // Cyclic values can look like a boot-up message, but not twice with the same bytes of an identifier.
    let is_sure = |(sign, count): &(Sign, usize)| !matches!(sign, Sign::Fsc(_)) || *count >= 2;
    signs
        .into_iter()
        .filter(is_sure)
        .map(|(sign, _)| row(sign))
        .collect()
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
            Some(Sign::Canopen((id.as_raw() - 0x700) as u8))
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
        (Id::Extended(id), &[_, _, n2, n3, _, _, _, _])
            if id.as_raw() >> 8 & 0x3_FFFF == 0xEEFF =>
        {
            Some(Sign::J1939 {
                address: id.as_raw() as u8,
                maker: u16::from(n3) << 3 | u16::from(n2 >> 5),
            })
        }
        _ => None,
    }
}

fn row(sign: Sign) -> Row {
    let heard = |protocol, address, serial, article| Row::Heard {
        protocol,
        address,
        serial,
        article,
    };
    match sign {
        Sign::Fsc(sensor) => {
            let address = shown(sensor.request).trim_end_matches('h').to_owned();
            heard("fsc", address, None, None)
        }
        Sign::Canopen(node) => heard("canopen", node.to_string(), None, None),
        Sign::J1939 { address, maker } => heard(
            "j1939",
            address.to_string(),
            None,
            Some(format!("manufacturer {maker}")),
        ),
        Sign::Devicenet {
            mac,
            vendor,
            serial,
        } => heard(
            "devicenet",
            mac.to_string(),
            Some(serial),
            Some(format!("vendor {vendor}")),
        ),
    }
}

/// The address of a node that can be asked: nobody else talks to it.
pub fn target(row: &Row, frames: &[Frame]) -> Option<Target> {
    let Row::Heard {
        protocol, address, ..
    } = row
    else {
        return None;
    };
    let is_used = |wanted: u16| {
        let is = |frame: &Frame| matches!(frame.id(), Id::Standard(id) if id.as_raw() == wanted);
        frames.iter().any(is)
    };
    match *protocol {
        "fsc" => {
            let mut sensors = frames.iter().filter_map(boot_up);
            let sensor = sensors.find(|sensor| Target::Fsc(*sensor).address() == *address)?;
            let is_free = !frames.iter().any(|frame| frame.can_id() == sensor.request);
            is_free.then_some(Target::Fsc(sensor))
        }
        "canopen" => {
            let node: u8 = address.parse().ok()?;
            let is_free = !is_used(0x600 + u16::from(node)) && !is_used(0x580 + u16::from(node));
            is_free.then_some(Target::Canopen(node))
        }
        "devicenet" => {
            let mac: u8 = address.parse().ok()?;
            let is_free = !is_used(group_2_id(mac, group_2::REQUEST));
            is_free.then_some(Target::Devicenet(Slave { mac }))
        }
        _ => None,
    }
}

/// How long a node is asked that has just been heard.
pub fn patience(target: &Target) -> Duration {
    match target {
        Target::Devicenet(_) => CHECK,
        Target::Fsc(_) | Target::Canopen(_) => millis(200),
    }
}

#[cfg(test)]
mod tests;
