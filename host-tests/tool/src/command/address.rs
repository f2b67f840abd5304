//! `node-id` and `mac`: another address, with the steps that the protocol needs, and a check at the new one.

use super::set::write;
use super::tell;
use crate::client::devicenet::Slave;
use crate::client::sdo::{Answer, Server};
use crate::failure::Failure;
use crate::identify;
use crate::output::Terminal;
use crate::session::{Session, Target};
use plumbline::model::catalog::Protocol;
use plumbline::time::{Duration, after, millis};

/// The longest time until a CANopen sensor has restarted.
const RESTART: Duration = millis(3000);

/// The longest time until a DeviceNet sensor has made its duplicate MAC ID check.
const CHECK: Duration = millis(4000);

/// Changes the node-ID: write, save, reset node, then ask at the new one.
pub(super) fn node_id(
    session: &mut Session,
    new: u8,
    terminal: &mut Terminal,
) -> Result<(), Failure> {
    let (Protocol::Canopen(tables), Target::Canopen(old)) =
        (&session.sheet.product.protocol, session.target)
    else {
        let message = format!(
            "{} has no node-ID: use `plumbline set` or `plumbline mac`",
            session.sheet.product.name
        );
        return Err(Failure::usage("not-offered", message));
    };
    let entry = session.entry(tables.node_id)?;
    let permitted = if (1..=127).contains(&new) {
        entry.check(new.into(), &entry.scale)
    } else {
        Err("a node-ID is 1 to 127".to_owned())
    };
    permitted.map_err(|why| Failure::usage("out-of-range", why))?;
    if new == old {
        return tell(terminal, &format!("the node-ID is {new} already"));
    }
    let server = Server {
        time: identify::question(&session.link),
        ..Server::of(new)
    };
    if server.read(&mut session.link, 0x1000, 0)? != Answer::Silent {
        let message = format!("the node-ID {new} is in use: nothing has changed");
        return Err(Failure::refused("address-in-use", message));
    }
    write(session, &vec![(entry, new.into())])?;
    session.save()?;
    session.restart()?;
    session.target = Target::Canopen(new);
    let until = after(session.link.now(), RESTART);
    loop {
        if server.read(&mut session.link, 0x1000, 0)? != Answer::Silent {
            return tell(terminal, &format!("the node-ID is {new} now, and stored"));
        }
        if session.link.now() >= until {
            return Err(missing(&format!("node-ID {new}")));
        }
    }
}

/// Changes the MAC ID; the sensor checks it and is on-line about two seconds later.
pub(super) fn mac(session: &mut Session, new: u8, terminal: &mut Terminal) -> Result<(), Failure> {
    let (Protocol::Devicenet(tables), Target::Devicenet(old)) =
        (&session.sheet.product.protocol, session.target)
    else {
        let message = format!(
            "{} has no MAC ID: use `plumbline set` or `plumbline node-id`",
            session.sheet.product.name
        );
        return Err(Failure::usage("not-offered", message));
    };
    let entry = session.entry(tables.roles.mac_id)?;
    let permitted = entry.check(new.into(), &entry.scale);
    permitted.map_err(|why| Failure::usage("out-of-range", why))?;
    if new == old.mac {
        return tell(terminal, &format!("the MAC ID is {new} already"));
    }
    let slave = Slave { mac: new };
    if identify::ask(&mut session.link, Target::Devicenet(slave))?.is_some() {
        let message = format!("the MAC ID {new} is in use: nothing has changed");
        return Err(Failure::refused("address-in-use", message));
    }
    session.write_bytes(&entry, &[new])?;
    session.moved(Target::Devicenet(slave));
    let until = after(session.link.now(), CHECK);
    loop {
        if identify::ask(&mut session.link, session.target)?.is_some() {
            return tell(terminal, &format!("the MAC ID is {new} now, and stored"));
        }
        if session.link.now() >= until {
            return Err(missing(&format!("MAC ID {new}")));
        }
    }
}

fn missing(what: &str) -> Failure {
    let message = format!(
        "the sensor does not answer at the {what}: switch it off and on, then `plumbline scan`"
    );
    Failure::silent("no-answer", message)
}
