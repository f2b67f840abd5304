//! `node-id` and `mac`: another address, with the steps that the protocol needs, and a check at the new one.

use super::Report;
use super::set::write;
use crate::client::devicenet::Slave;
use crate::client::sdo::{Answer, Server};
use crate::error::Error;
use crate::identify;
use crate::master::Roles;
use crate::master::{Node, Target};
use crate::plan::Values;
use crate::session::Session;
use crate::sheet::{Entry, Origin};
use plumbline::model::catalog::{Product, Protocol};
use plumbline::time::{Duration, after, millis};

/// The longest time until a CANopen sensor has restarted.
const RESTART: Duration = millis(3000);

/// The longest time until a DeviceNet sensor has made its duplicate MAC ID check.
const CHECK: Duration = millis(4000);

/// Changes the node-ID: write, save, reset node, then ask at the new one.
pub(crate) fn node_id(session: &mut Session, new: u8) -> Result<Report, Error> {
    let (Protocol::Canopen(tables), Target::Canopen(Node(old))) =
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
    free(session, Target::Canopen(Node(new)))?;
    write(session, &vec![(entry, new.into())])?;
    session.save()?;
    session.restart()?;
    session.target = Target::Canopen(Node(new));
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
    let roles = Roles::of(product).filter(|roles| roles.moves_at_once);
    roles.is_some_and(|roles| entry.origin == Origin::Parameter(roles.address))
}

/// Refuses values with an address that is in use.
pub(crate) fn check(session: &mut Session, values: &Values) -> Result<(), Error> {
    // Nobody is asked in the other protocol of the sensor.
    let Some(roles) = session.roles() else {
        return Ok(());
    };
    for (entry, raw) in values {
        if entry.origin == Origin::Parameter(roles.address)
            && let Ok(target) = (roles.target)(*raw)
            && target != session.target
        {
            free(session, target)?;
        }
    }
    Ok(())
}

/// Refuses an address that is in use.
pub(crate) fn free(session: &mut Session, target: Target) -> Result<(), Error> {
    let is_used = target.is_used(&mut session.link)?;
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
