//! `node-id` and `mac`: another address, with the steps that the protocol needs, and a check at the new one.

use super::report::{Done, Report};
use super::set::write;
use crate::error::{Error, NumberError, SensorError, Silence};
use crate::identify;
use crate::master::{PROTOCOLS, Protocol, Roles, Target};
use crate::plan::Values;
use crate::session::Session;
use crate::sheet::{Entry, Origin};
use plumbline::model::catalog::Product;
use plumbline::time::{Duration, after, millis};

/// The longest time until a sensor has restarted, or has checked its new address.
const RESTART: Duration = millis(4000);

/// Changes the address of a sensor with this protocol, and asks at the new one.
pub(crate) fn change(
    session: &mut Session,
    protocol: &'static Protocol,
    new: Option<u8>,
) -> Result<Report, Error> {
    let Some(new) = new else {
        return Err(not_here(session, protocol));
    };
    let old = session.target;
    let roles = session.roles().filter(|_| old.protocol() == protocol);
    let roles = roles.ok_or_else(|| not_here(session, protocol))?;
    let entry = session.entry(roles.address)?;
    let kind = protocol.kind;
    let permitted = match protocol.range.contains(&new) {
        true => entry.check(new.into(), &entry.scale),
        false => {
            let (low, high) = protocol.range.clone().into_inner();
            Err(NumberError::NoAddress(new, kind, low, high))
        }
    };
    permitted?;
    let target = (roles.target)(new.into())?;
    if target == old {
        return Ok(Done::AddressAlready(kind, new).into());
    }
    free(session, target)?;
    if roles.moves_at_once {
        move_at_once(session, entry, new.into(), target)?;
    } else {
        write(session, &vec![(entry, new.into())])?;
        session.save()?;
        session.restart()?;
        arrive(session, target)?;
    }
    Ok(Done::Address(kind, new).into())
}

/// The sensor has no address of this protocol.
pub(crate) fn not_here(session: &Session, protocol: &Protocol) -> Error {
    let others = PROTOCOLS.iter().filter(|other| **other != protocol);
    let others = others.filter_map(|other| other.command.as_ref());
    let others: Vec<String> = others
        .map(|command| format!("`plumbline {}`", command.name))
        .collect();
    (protocol.lacks)(session.sheet.product.name, others.join(" or ")).into()
}

/// The address that the sensor has as soon as this is written.
pub(super) fn moved(product: &Product, entry: &Entry, raw: u32) -> Option<Target> {
    let roles = Roles::of(product).filter(|roles| roles.moves_at_once)?;
    let is_own = entry.origin == Origin::Parameter(roles.address);
    is_own.then(|| (roles.target)(raw).ok()).flatten()
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
        true => Err(SensorError::AddressInUse(target.named()).into()),
    }
}

/// Writes an address that acts at once, and waits until the sensor answers there.
pub(super) fn move_at_once(
    session: &mut Session,
    entry: Entry,
    raw: u32,
    target: Target,
) -> Result<(), Error> {
    session.write(&[(entry, raw)])?;
    arrive(session, target)
}

/// Waits until the sensor answers at its new address.
pub(crate) fn arrive(session: &mut Session, target: Target) -> Result<(), Error> {
    session.moved(target);
    let until = after(session.link.now(), RESTART);
    loop {
        if identify::ask(&mut session.link, target, identify::PATIENT)?.is_some() {
            return Ok(());
        }
        if session.link.now() >= until {
            return Err(missing(target));
        }
    }
}

/// The sensor was changed, but does not answer as it should now.
pub(crate) fn missing(target: Target) -> Error {
    Silence::Moved(target.named()).into()
}
