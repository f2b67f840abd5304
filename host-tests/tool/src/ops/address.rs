//! `node-id` and `mac`: another address, with the steps that the protocol needs, and a check at the new one.

use super::Report;
use super::set::write;
use crate::client::devicenet::Slave;
use crate::client::j1939;
use crate::client::sdo::{self, Answer, Server};
use crate::error::Error;
use crate::identify;
use crate::plan::Values;
use crate::scan::listen;
use crate::session::{Session, Target};
use crate::sheet::{Entry, Origin};
use plumbline::can::{CanId, Frame};
use plumbline::canopen::cob_id::{EMCY, ERROR_CONTROL, SDO_REPLY};
use plumbline::devicenet::identifiers::group_2_id;
use plumbline::model::catalog::{Product, Protocol};
use plumbline::time::{Duration, after, millis};

/// The number of times an address that must be free is asked.
const QUESTIONS: u8 = 3;

/// The longest time until a CANopen sensor has restarted.
const RESTART: Duration = millis(3000);

/// The longest time until a DeviceNet sensor has made its duplicate MAC ID check.
const CHECK: Duration = millis(4000);

/// Changes the node-ID: write, save, reset node, then ask at the new one.
pub(crate) fn node_id(session: &mut Session, new: u8) -> Result<Report, Error> {
    let (Protocol::Canopen(tables), Target::Canopen(old)) =
        (&session.sheet.product.protocol, session.target)
    else {
        let message = format!(
            "{} has no node-ID here: use `plumbline set`, `plumbline mac` or `plumbline address`",
            session.sheet.product.name
        );
        return Err(Error::usage("not-offered", message));
    };
    let entry = session.entry(tables.node_id)?;
    let permitted = if (1..=127).contains(&new) {
        entry.check(new.into(), &entry.scale)
    } else {
        Err(format!("{new} is no node-ID: choose one from 1 to 127"))
    };
    permitted.map_err(|why| Error::usage("out-of-range", why))?;
    if new == old {
        return Ok(Report::done(format!("the node-ID is {new} already")));
    }
    free(session, Target::Canopen(new))?;
    write(session, &vec![(entry, new.into())])?;
    session.save()?;
    session.restart()?;
    session.target = Target::Canopen(new);
    let until = after(session.link.now(), RESTART);
    loop {
        if Server::of(new).read(&mut session.link, 0x1000, 0)? != Answer::Silent {
            return Ok(Report::done(format!(
                "the node-ID is {new} now, and stored"
            )));
        }
        if session.link.now() >= until {
            return Err(missing(&format!("node-ID {new}")));
        }
    }
}

/// Changes the MAC ID; the sensor checks it and is on-line about two seconds later.
pub(crate) fn mac(session: &mut Session, new: u8) -> Result<Report, Error> {
    let (Protocol::Devicenet(tables), Target::Devicenet(old)) =
        (&session.sheet.product.protocol, session.target)
    else {
        let message = format!(
            "{} has no MAC ID: use `plumbline set`, `plumbline node-id` or `plumbline address`",
            session.sheet.product.name
        );
        return Err(Error::usage("not-offered", message));
    };
    let entry = session.entry(tables.roles.mac_id)?;
    let permitted = entry.check(new.into(), &entry.scale);
    permitted.map_err(|why| Error::usage("out-of-range", why))?;
    if new == old.mac {
        return Ok(Report::done(format!("the MAC ID is {new} already")));
    }
    free(session, Target::Devicenet(Slave { mac: new }))?;
    move_mac(session, &entry, new)?;
    Ok(Report::done(format!("the MAC ID is {new} now, and stored")))
}

/// Whether the sensor has another address as soon as this is written.
pub(crate) fn moves(product: &Product, entry: &Entry) -> bool {
    match &product.protocol {
        Protocol::Devicenet(tables) => entry.origin == Origin::Parameter(tables.roles.mac_id),
        Protocol::Fsc(_) | Protocol::Canopen(_) | Protocol::J1939(_) => false,
    }
}

/// Refuses values with a node-ID or MAC ID that is in use.
pub(crate) fn check(session: &mut Session, values: &Values) -> Result<(), Error> {
    for (entry, raw) in values {
        let id = match entry.origin {
            Origin::Parameter(id) => id,
            _ => continue,
        };
        let target = match &session.sheet.product.protocol {
            Protocol::Canopen(tables) => match (session.target, &tables.j1939) {
                (Target::J1939(_), Some(j1939)) if j1939.address == id => Target::J1939(*raw as u8),
                // Nobody is asked in the other protocol of the sensor.
                (Target::Canopen(_), _) if tables.node_id == id => Target::Canopen(*raw as u8),
                _ => continue,
            },
            Protocol::Devicenet(tables) if tables.roles.mac_id == id => {
                Target::Devicenet(Slave { mac: *raw as u8 })
            }
            _ => continue,
        };
        if target != session.target {
            free(session, target)?;
        }
    }
    Ok(())
}

/// Refuses an address that is in use: listens for its messages, then asks several times.
pub(crate) fn free(session: &mut Session, target: Target) -> Result<(), Error> {
    let ids: Vec<CanId> = match target {
        Target::Canopen(node) => [ERROR_CONTROL, SDO_REPLY, EMCY]
            .map(|base| CanId::standard(base + u16::from(node)))
            .to_vec(),
        Target::Devicenet(slave) => (0..8)
            .map(|message| CanId::standard(group_2_id(slave.mac, message)))
            .collect(),
        Target::Fsc(_) | Target::J1939(_) => Vec::new(),
    };
    let is_own = |frame: &Frame| ids.contains(&frame.can_id()).then_some(());
    let mut is_used = session.link.wait_for(listen::LONG, is_own)?.is_some();
    for _ in 0..QUESTIONS {
        is_used = is_used
            || match target {
                Target::J1939(address) => {
                    j1939::name(&mut session.link, address, j1939::ANSWER)?.is_some()
                }
                Target::Canopen(node) => {
                    Server::of(node).read(&mut session.link, 0x1000, 0)? != Answer::Silent
                }
                _ => identify::ask(&mut session.link, target, sdo::ANSWER)?.is_some(),
            };
    }
    match is_used {
        false => Ok(()),
        true => Err(Error::refused(
            "address-in-use",
            format!(
                "the {} is in use: nothing has changed. Choose another one; `plumbline scan --active` shows the devices on the bus",
                target.named()
            ),
        )),
    }
}

/// Writes the MAC ID, and waits until the sensor is on-line with it.
pub(crate) fn move_mac(session: &mut Session, entry: &Entry, new: u8) -> Result<(), Error> {
    session.write_bytes(entry, &[new])?;
    session.moved(Target::Devicenet(Slave { mac: new }));
    let until = after(session.link.now(), CHECK);
    loop {
        if identify::ask(&mut session.link, session.target, identify::PATIENT)?.is_some() {
            return Ok(());
        }
        if session.link.now() >= until {
            return Err(missing(&format!("MAC ID {new}")));
        }
    }
}

/// The sensor was changed, but does not answer as it should now.
pub(crate) fn missing(what: &str) -> Error {
    let message = format!(
        "the sensor does not answer at the {what}: switch it off and on, then `plumbline scan`"
    );
    Error::silent("no-answer", message)
}
