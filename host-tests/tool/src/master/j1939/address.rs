//! `address`: shows and changes the address of a sensor in J1939.
//!
//! Commanded Address acts at once, and the sensor takes the address over into its parameter, which is stored then. A sensor that does not
//! obey gets the parameter, and a restart.

use super::{PROTOCOL, tables};
use crate::error::{Error, Silence};
use crate::master::j1939::groups::{self as j1939, ANSWER};
use crate::master::{Ca, Target};
use crate::ops::Report;
use crate::ops::address::{free, not_here};
use crate::ops::report::Done;
use crate::session::Session;
use plumbline::j1939::name::Name;
use plumbline::param::ParameterId;
use plumbline::time::{Duration, after, millis};
use serde::Serialize;

/// The longest time until a sensor has restarted and has an address.
const RESTART: Duration = millis(3000);

/// Shows or changes the address.
pub(crate) fn address(session: &mut Session, new: Option<u8>) -> Result<Report, Error> {
    let tables = tables(session.sheet.product);
    let (Some(tables), Target::J1939(Ca(old))) = (tables, session.target) else {
        return Err(not_here(session, &PROTOCOL));
    };
    let name = j1939::name(&mut session.link, old, ANSWER)?;
    let name = name.ok_or_else(|| Silence::Moved(format!("address {old}")))?;
    let Some(new) = new else {
        return show(session, old, name, tables.address).map(Report::Address);
    };
    let entry = session.entry(tables.address)?;
    let permitted = entry.check(new.into(), &entry.scale);
    permitted?;
    if new != old {
        free(session, Target::J1939(Ca(new)))?;
        let claimed = j1939::command_address(&mut session.link, name, new)?;
        session.target = Target::J1939(Ca(claimed.unwrap_or(old)));
        if claimed.is_some() {
            // The sensor is silent until other nodes cannot contend for the address any more.
            answers(session, name)?;
        }
    }
    let is_there = session.target == Target::J1939(Ca(new));
    if !is_there || session.read(&entry)? != u32::from(new) {
        session.write(&[(entry, new.into())])?;
    }
    session.save()?;
    if !is_there {
        session.restart()?;
        session.target = Target::J1939(Ca(new));
        answers(session, name)?;
    }
    Ok(Done::Address("address", new).into())
}

/// Waits until the sensor answers at the address of the session.
fn answers(session: &mut Session, name: Name) -> Result<(), Error> {
    let Target::J1939(Ca(address)) = session.target else {
        return Ok(());
    };
    let until = after(session.link.now(), RESTART);
    loop {
        let answer = j1939::name(&mut session.link, address, ANSWER)?;
        // The address is its own 250 ms after the claim.
        session.link.wait_for(ANSWER, |_| None::<()>)?;
        if answer == Some(name) {
            return Ok(());
        }
        if session.link.now() >= until {
            return Err(Silence::Moved(format!("address {address}")).into());
        }
    }
}

/// The address of a sensor, and its NAME.
#[derive(Clone, Debug, Serialize)]
pub struct Shown {
    address: u8,
    /// The address that it claims first.
    preferred: u32,
    name: String,
    /// It claims another address if it loses this one.
    arbitrary: bool,
    #[serde(skip)]
    number: u64,
}

impl Shown {
    pub(crate) fn lines(&self) -> Vec<String> {
        let name = self.number;
        let loses = match self.arbitrary {
            true => "claims another address if it loses this one",
            false => "has no address if it loses this one",
        };
        vec![
            format!("address    {}", self.address),
            format!("preferred  {}", self.preferred),
            format!("NAME       {}", self.name),
            format!(
                "           identity {}, manufacturer {}, function {}, {loses}",
                name & 0x1F_FFFF,
                name >> 21 & 0x7FF,
                name >> 40 & 0xFF,
            ),
        ]
    }
}

fn show(
    session: &mut Session,
    address: u8,
    Name(number): Name,
    preferred: ParameterId,
) -> Result<Shown, Error> {
    let entry = session.entry(preferred)?;
    Ok(Shown {
        address,
        preferred: session.read(&entry)?,
        name: format!("{number:016X}"),
        arbitrary: number >> 63 != 0,
        number,
    })
}
