//! Reads, writes and commands of a session with an SDO server. A sensor in J1939 has one too.

use super::{CONTROL, HARDWARE, Node, PROGRAM, Program, tables};
use crate::error::{Error, RequestError, What};
use crate::link::Link;
use crate::master::canopen::lss;
use crate::master::canopen::nmt::{self, Command};
use crate::master::canopen::sdo::{Answer, Server};
use crate::ops::report::Done;
use crate::session::{Session, unexpected};
use crate::sheet::{Address, Entry};
use plumbline::can::BitRate;
use plumbline::canopen::Abort;
use plumbline::canopen::dictionary::{Service, Starts, Target, Use};
use plumbline::diagnosis;
use plumbline::model::listing::canopen::Tables;
use plumbline::param::number;
use plumbline::update::Hardware;

/// The identity object.
const IDENTITY: u16 = 0x1018;

/// The sub-index of the serial number in the identity object.
const SERIAL: u8 = 4;

/// The tables of the product of a session.
pub(in crate::master) fn own(session: &Session) -> Result<&'static Tables, Error> {
    tables(session.sheet.product).ok_or_else(|| unexpected(What::Request))
}

fn place(entry: &Entry) -> Result<(u16, u8), Error> {
    match entry.address {
        Address::Object { index, sub } => Ok((index, sub)),
        _ => Err(unexpected(What::Name(entry.name.clone()))),
    }
}

/// Reads an entry.
pub(in crate::master) fn read(
    session: &mut Session,
    server: Server,
    entry: &Entry,
) -> Result<Vec<u8>, Error> {
    let (index, sub) = place(entry)?;
    let answer = server.read(&mut session.link, index, sub)?;
    answer.must(server, What::Read(entry.name.clone()))
}

/// Writes an entry.
pub(in crate::master) fn write(
    session: &mut Session,
    server: Server,
    entry: &Entry,
    bytes: &[u8],
) -> Result<(), Error> {
    let what = What::Write(entry.name.clone());
    object(session, server, place(entry)?, bytes, what)
}

/// Writes an object; the answer can come when the memory is written.
pub(in crate::master) fn object(
    session: &mut Session,
    server: Server,
    (index, sub): (u16, u8),
    bytes: &[u8],
    what: What,
) -> Result<(), Error> {
    let server = server.patient();
    let answer = server.write(&mut session.link, index, sub, bytes)?;
    answer.must(server, what)
}

/// Stores the parameters.
pub(in crate::master) fn save(session: &mut Session, server: Server) -> Result<Done, Error> {
    let is = |service| matches!(service, Service::Store | Service::StoreGroup);
    let [first, ..] = services(own(session)?, is)[..] else {
        return Err(RequestError::NoSave.into());
    };
    object(session, server, first, b"save", What::Save)?;
    Ok(Done::Stored)
}

/// Whether the sensor takes its factory values at its next start, without storing them (1011h with groups).
pub(in crate::master) fn loads_at_restart(session: &Session) -> bool {
    let groups = own(session).map(|tables| services(tables, |own| own == Service::RestoreGroup));
    groups.is_ok_and(|groups| !groups.is_empty())
}

/// Loads the factory values, and says what follows.
pub(in crate::master) fn load(session: &mut Session, server: Server) -> Result<Done, Error> {
    let tables = own(session)?;
    // The last sub-index restores everything.
    let groups = services(tables, |service| service == Service::RestoreGroup);
    if let Some(all) = groups.last() {
        object(session, server, *all, b"load", What::Load)?;
        return Ok(Done::FactoryAtRestart);
    }
    for one in services(tables, |service| service == Service::RestoreCommunication) {
        object(session, server, one, b"load", What::Load)?;
    }
    for one in commands(tables, Starts::Restore) {
        object(session, server, one, &[1], What::Load)?;
    }
    Ok(Done::FactoryLoaded)
}

/// What the program tells of itself; None: the device does not have the object.
pub(in crate::master) fn program(
    session: &mut Session,
    server: Server,
) -> Result<Option<Program>, Error> {
    let crc = number_of_program(session, server, PROGRAM)?;
    let Some(crc) = crc else {
        return Ok(None);
    };
    let hardware = number_of_program(session, server, HARDWARE)?;
    let hardware = hardware.map(|number| Hardware::of(number as u16));
    Ok(Some(Program { crc, hardware }))
}

fn number_of_program(
    session: &mut Session,
    server: Server,
    (index, sub): (u16, u8),
) -> Result<Option<u32>, Error> {
    match server.read(&mut session.link, index, sub)? {
        Answer::Aborted(code)
            if code == Abort::NoObject as u32 || code == Abort::NoSubIndex as u32 =>
        {
            Ok(None)
        }
        answer => Ok(Some(number(&answer.must(server, What::Program)?))),
    }
}

/// A value of the diagnostic data of this project.
pub(in crate::master) fn diagnosis(
    link: &mut Link,
    server: Server,
    value: u8,
) -> Result<Option<u32>, Error> {
    Ok(match server.read(link, diagnosis::OBJECT, value)? {
        Answer::Done(bytes) => (bytes.len() == 4).then(|| number(&bytes)),
        Answer::Aborted(_) | Answer::Silent => None,
    })
}

/// Whether the program is stopped: the bootloader answers.
pub(in crate::master) fn is_stopped(link: &mut Link, server: Server) -> Result<bool, Error> {
    let (index, sub) = CONTROL;
    Ok(server.read(link, index, sub)? == Answer::Done(vec![0]))
}

/// Stops the program: the device restarts into its bootloader.
pub(in crate::master) fn enter_bootloader(
    session: &mut Session,
    server: Server,
) -> Result<(), Error> {
    object(session, server, CONTROL, &[0], What::Program)
}

impl Node {
    pub(super) fn server(self) -> Server {
        Server::of(self.0)
    }

    pub(super) fn serial_in(self, session: &mut Session) -> Result<Option<u32>, Error> {
        let answer = self.server().read(&mut session.link, IDENTITY, SERIAL)?;
        let serial = answer.must(self.0, What::Serial)?;
        Ok(Some(number(&serial)))
    }

    pub(super) fn restart_in(self, session: &mut Session) -> Result<(), Error> {
        let answer = self.server().read(&mut session.link, 0x1000, 0)?;
        answer.must(self.0, What::DeviceType)?;
        nmt::send(&mut session.link, Command::ResetNode, self.0)
    }

    /// Stores a bit rate by LSS, which stores nothing else. False: the product does not have LSS, or LSS not this rate.
    pub(super) fn store_by_lss(self, session: &mut Session, rate: BitRate) -> Result<bool, Error> {
        let Some(index) = lss::index(rate).filter(|_| own(session).is_ok_and(|own| own.lss)) else {
            return Ok(false);
        };
        let mut identity = [0; 4];
        for (sub, own) in (1..).zip(&mut identity) {
            let answer = self.server().read(&mut session.link, IDENTITY, sub)?;
            *own = number(&answer.must(self.0, What::Identity)?);
        }
        let stored = lss::store_rate(&mut session.link, identity, index);
        lss::release(&mut session.link)?;
        stored.map(|()| true)
    }
}

/// The addresses of the objects with some services, in the order of the dictionary.
fn services(tables: &Tables, is: impl Fn(Service) -> bool) -> Vec<(u16, u8)> {
    let objects = tables.objects.iter();
    let objects = objects.filter(|object| object.service().is_some_and(&is));
    objects.map(|object| (object.index, object.sub)).collect()
}

/// The addresses of the own objects that start this action when 1 is written.
pub(in crate::master) fn commands(
    tables: &Tables,
    wanted: Starts,
) -> impl Iterator<Item = (u16, u8)> {
    let objects = tables.objects.iter().filter(move |object| {
        matches!(object.target, Target::Own(Use::Command(command)) if command.starts == wanted)
    });
    objects.map(|object| (object.index, object.sub))
}
