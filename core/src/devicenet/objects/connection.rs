//! The connection object (class 5): instances 1 explicit, 2 poll, 4 COS or cyclic.

use super::class;
use crate::devicenet::connection::{Connection, State};
use crate::devicenet::exchange::selected;
use crate::devicenet::explicit::{Data, Failure, Request, exactly, nothing, service};
use crate::devicenet::fragment::{CONSUMED, PRODUCED};
use crate::devicenet::identifiers::{Group1, group_2, group_2_id};
use crate::devicenet::protocol::{ContextOf, Devicenet};
use crate::devicenet::table::{Product, path};
use crate::time::Instant;

/// The revision of the class.
const REVISION: u8 = 1;

/// The instances of the connections.
const EXPLICIT: u8 = 1;
const POLL: u8 = 2;
const PRODUCING: u8 = 4;

/// The attributes that can be set.
const RATE: u8 = 9;
const WATCHDOG_ACTION: u8 = 12;
const INHIBIT: u8 = 17;

/// Watchdog actions of the explicit connection.
const AUTO_DELETE: u8 = 1;
const DEFERRED_DELETE: u8 = 3;

/// Additional code: the production inhibit time exceeds the expected packet rate.
const INHIBIT_TOO_LONG: u8 = 0x11;

/// The least expected packet rate of COS and cyclic messages in ms.
const LEAST_RATE: u16 = 2;

pub(super) fn serve<P: Product>(
    device: &mut Devicenet<P>,
    cx: &mut ContextOf<P>,
    now: Instant,
    request: &Request,
) -> Result<Data, Failure> {
    let instance = request.instance;
    if instance == 0 {
        return request.class_attribute(REVISION);
    }
    if !connection(device, instance)?.exists() {
        return Err(Failure::OBJECT);
    }
    match request.service {
        service::GET => {
            let (attribute, rest) = request.attribute()?;
            let data = get(device, cx, instance, attribute)?;
            nothing(rest)?;
            Ok(data)
        }
        service::SET => {
            let (attribute, data) = request.attribute()?;
            get(device, cx, instance, attribute)?;
            set(device, now, instance, attribute, data)
        }
        _ => Err(Failure::SERVICE),
    }
}

fn connection<P: Product>(
    device: &mut Devicenet<P>,
    instance: u8,
) -> Result<&mut Connection, Failure> {
    match instance {
        EXPLICIT => Ok(device.connections.explicit()),
        POLL => Ok(device.connections.poll()),
        PRODUCING => Ok(device.connections.producing()),
        _ => Err(Failure::OBJECT),
    }
}

fn get<P: Product>(
    device: &mut Devicenet<P>,
    cx: &ContextOf<P>,
    instance: u8,
    attribute: u8,
) -> Result<Data, Failure> {
    let mac = device.mac;
    let is_cyclic = device.connections.is_cyclic();
    let &mut connection = connection(device, instance)?;
    let consumes = connection.consumes();
    let is_io = instance != EXPLICIT;
    // The produced assembly of an I/O connection, and its size in bytes.
    let (assembly, size) = match instance {
        POLL => selected::<P>(cx, P::ROLES.polled_assembly),
        PRODUCING => selected::<P>(cx, P::ROLES.cyclic_assembly),
        _ => None,
    }
    .map_or((0, 0), |row| (row.instance, row.size()));
    Ok(match attribute {
        1 => Data::byte(connection.state() as u8),
        2 => Data::byte(is_io.into()),
        3 => Data::byte(match (instance, is_cyclic, consumes) {
            (EXPLICIT, ..) => 0x83,
            (POLL, ..) => 0x82,
            (_, false, true) => 0x13,
            (_, true, true) => 0x03,
            (_, false, false) => 0x10,
            (_, true, false) => 0x00,
        }),
        4 => Data::word(match instance {
            EXPLICIT => group_2_id(mac, group_2::RESPONSE),
            POLL => Group1::PollResponse.id(mac),
            _ => Group1::ChangeOrCyclic.id(mac),
        }),
        5 => Data::word(match instance {
            EXPLICIT => group_2_id(mac, group_2::REQUEST),
            POLL => group_2_id(mac, group_2::POLL),
            _ if consumes => group_2_id(mac, group_2::ACKNOWLEDGE),
            _ => 0xFFFF,
        }),
        6 => Data::byte(match (instance, consumes) {
            (EXPLICIT, _) => 0x21,
            (_, true) => 0x01,
            (_, false) => 0x0F,
        }),
        7 if is_io => Data::word(size.into()),
        7 => Data::word(PRODUCED as u16),
        8 if is_io => Data::word(0),
        8 => Data::word(CONSUMED as u16),
        RATE => Data::word(connection.rate()),
        WATCHDOG_ACTION if is_io => Data::byte(0),
        WATCHDOG_ACTION if device.connections.defers() => Data::byte(DEFERRED_DELETE),
        WATCHDOG_ACTION => Data::byte(AUTO_DELETE),
        13 if is_io => Data::word(6),
        14 if is_io => {
            let [a, b, c, d, e, f] = path(assembly);
            Data::Bytes {
                bytes: u64::from_le_bytes([a, b, c, d, e, f, 0, 0]),
                length: 6,
            }
        }
        15 if instance == PRODUCING && consumes => Data::word(4),
        16 if instance == PRODUCING && consumes => Data::Bytes {
            bytes: u64::from_le_bytes([0x20, class::ACKNOWLEDGE_HANDLER, 0x24, 1, 0, 0, 0, 0]),
            length: 4,
        },
        13 | 15 => Data::word(0),
        14 | 16 => Data::NONE,
        INHIBIT if instance == PRODUCING => Data::word(device.production.inhibit()),
        _ => return Err(Failure::ATTRIBUTE),
    })
}

fn set<P: Product>(
    device: &mut Devicenet<P>,
    now: Instant,
    instance: u8,
    attribute: u8,
    data: &[u8],
) -> Result<Data, Failure> {
    match attribute {
        RATE => set_rate(device, now, instance, exactly(data, 2)? as u16),
        WATCHDOG_ACTION if instance == EXPLICIT => {
            let action = exactly(data, 1)? as u8;
            if action != AUTO_DELETE && action != DEFERRED_DELETE {
                return Err(Failure::VALUE);
            }
            device.connections.set_defers(action == DEFERRED_DELETE);
            Ok(Data::NONE)
        }
        INHIBIT if instance == PRODUCING => {
            let inhibit = exactly(data, 2)? as u16;
            let &mut connection = connection(device, instance)?;
            check_inhibit(inhibit, connection.rate())?;
            check_state(&connection)?;
            device.production.set_inhibit(inhibit);
            Ok(Data::word(inhibit))
        }
        _ => Err(Failure::NOT_SETTABLE),
    }
}

/// Sets the expected packet rate: the connection is established then.
fn set_rate<P: Product>(
    device: &mut Devicenet<P>,
    now: Instant,
    instance: u8,
    mut rate: u16,
) -> Result<Data, Failure> {
    if instance == PRODUCING {
        if rate > 0 {
            rate = rate.max(LEAST_RATE);
        }
        check_inhibit(device.production.inhibit(), rate)?;
    }
    let connection = connection(device, instance)?;
    check_state(connection)?;
    connection.set_rate(now, rate);
    if instance == PRODUCING {
        let is_cyclic = device.connections.is_cyclic();
        device.production.set_rate(now, rate, is_cyclic);
    }
    Ok(Data::word(rate))
}

/// The production inhibit time must not exceed the expected packet rate, if that is not 0.
fn check_inhibit(inhibit: u16, rate: u16) -> Result<(), Failure> {
    if rate > 0 && inhibit > rate {
        return Err(Failure::VALUE.with(INHIBIT_TOO_LONG));
    }
    Ok(())
}

/// A connection that has timed out must be allocated again.
fn check_state(connection: &Connection) -> Result<(), Failure> {
    if connection.state() == State::TimedOut {
        return Err(Failure::STATE);
    }
    Ok(())
}
