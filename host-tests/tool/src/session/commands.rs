//! The commands of a session: put an old value back, save, load the factory values, restart.

use super::{Session, TRIES, unexpected};
use crate::client::devicenet::Path;
use crate::client::fsc;
use crate::client::nmt::{self, Command};
use crate::client::sdo::Server;
use crate::error::Error;
use crate::master::{Node, Target};
use crate::sheet::Entry;
use plumbline::canopen::dictionary::{Service, Starts, Target as ObjectTarget, Use};
use plumbline::devicenet::service;
use plumbline::fsc::table::{Function, Operation};
use plumbline::model::catalog::Protocol;
use plumbline::model::listing;
use plumbline::param::number;

/// What follows if [`Session::loads_at_restart`] is true.
const AT_RESTART: &str = "factory values, including node-ID and bit rate, take effect after a restart; then `save` stores them";

impl Session {
    /// Writes the number that an entry had before the tool changed it for a moment, also if the user wants to stop. A write without an
    /// answer is repeated.
    ///
    /// # Errors
    /// The sensor refuses, nobody answers, or the adapter fails. The message says what the user has to set.
    pub fn put_back(&mut self, entry: &Entry, raw: u32) -> Result<(), Error> {
        let was_ending = self.link.set_ending(true);
        let value = [(entry.clone(), raw)];
        let mut written = self.write(&value);
        for _ in 1..TRIES {
            match &written {
                Err(failure) if failure.code == "no-answer" => written = self.write(&value),
                _ => break,
            }
        }
        self.link.set_ending(was_ending);
        written.map_err(|failure| Error {
            message: format!(
                "{}; the tool could not restore {}, which was {}: `plumbline set {}=raw:{raw}`, or switch the sensor off and on",
                failure.message,
                entry.name,
                entry.text(raw),
                entry.name
            ),
            ..failure
        })
    }

    /// The serial number of the sensor, if its protocol tells it in one answer. A connection of DeviceNet has checked it.
    ///
    /// # Errors
    /// The sensor refuses, nobody answers, or the adapter fails.
    pub(crate) fn serial(&mut self) -> Result<Option<u32>, Error> {
        const FSC: u8 = 0x04;
        let bytes = match self.target {
            Target::Fsc(sensor) => {
                let reply = fsc::must(&mut self.link, sensor, FSC, fsc::ANSWER)?;
                if let (Some(known), Protocol::Fsc(tables)) =
                    (&mut self.known, &self.sheet.product.protocol)
                {
                    known.is_clean = reply.status & fsc::errors(tables) == 0;
                }
                reply.data.get(..4).map(<[u8]>::to_vec)
            }
            Target::Canopen(Node(node)) => {
                let answer = Server::of(node).read(&mut self.link, 0x1018, 4)?;
                Some(answer.must(node, "to read the serial number")?)
            }
            Target::Devicenet(_) | Target::J1939(_) => None,
        };
        Ok(bytes.map(|bytes| number(&bytes)))
    }

    /// Stores the parameters. Returns a sentence about what happened.
    ///
    /// # Errors
    /// The sensor refuses, nobody answers, or the adapter fails.
    pub fn save(&mut self) -> Result<&'static str, Error> {
        match &self.sheet.product.protocol {
            Protocol::Fsc(tables) => self.signed(tables, Operation::Save)?,
            Protocol::Canopen(tables) => {
                let is = |service| matches!(service, Service::Store | Service::StoreGroup);
                let [object, ..] = services(tables, is)[..] else {
                    let message = "the device has no object that stores its parameters (1010h)";
                    return Err(Error::usage("not-offered", message));
                };
                self.object(object, b"save", "save")?;
            }
            Protocol::Devicenet(_) => {
                return Ok("the sensor stores each change by itself within one second");
            }
            Protocol::J1939(_) => return Err(no_command("stores its parameters")),
        }
        Ok("stored")
    }

    /// Whether the sensor takes its factory values at its next start, without storing them (1011h with groups).
    pub fn loads_at_restart(&self) -> bool {
        match &self.sheet.product.protocol {
            Protocol::Canopen(tables) => {
                !services(tables, |service| service == Service::RestoreGroup).is_empty()
            }
            Protocol::Fsc(_) | Protocol::Devicenet(_) | Protocol::J1939(_) => false,
        }
    }

    /// Loads the factory values. Returns a sentence about what follows.
    ///
    /// # Errors
    /// The sensor refuses, nobody answers, or the adapter fails.
    pub fn load_factory(&mut self) -> Result<&'static str, Error> {
        match &self.sheet.product.protocol {
            Protocol::Fsc(tables) => {
                self.signed(tables, Operation::Load)?;
                Ok(
                    "factory values are loaded and stored; identifiers and bit rate act after a restart",
                )
            }
            Protocol::Canopen(tables) => {
                // The last sub-index restores everything.
                let groups = services(tables, |service| service == Service::RestoreGroup);
                if let Some(all) = groups.last() {
                    self.object(*all, b"load", "load")?;
                    return Ok(AT_RESTART);
                }
                for object in services(tables, |service| service == Service::RestoreCommunication) {
                    self.object(object, b"load", "load")?;
                }
                for object in commands(tables, Starts::Restore) {
                    self.object(object, &[1], "load")?;
                }
                Ok("factory values are loaded; node-ID and bit rate act after a restart")
            }
            Protocol::Devicenet(_) => {
                self.reset(1)?;
                Ok("the sensor restarts with factory values, including MAC ID and bit rate")
            }
            Protocol::J1939(_) => Err(no_command("loads its factory values")),
        }
    }

    /// Restarts the sensor.
    ///
    /// # Errors
    /// The sensor refuses, nobody answers, or the adapter fails.
    pub fn restart(&mut self) -> Result<(), Error> {
        match (self.target, &self.sheet.product.protocol) {
            (Target::Fsc(sensor), Protocol::Fsc(tables)) => {
                let function = function(tables, Operation::Alive)?;
                // There is no answer, so the sensor must be there before.
                fsc::must(&mut self.link, sensor, function.code, fsc::ANSWER)?;
                fsc::send(&mut self.link, sensor, function.code, function.signature)
            }
            (Target::Canopen(Node(node)), _) => {
                let answer = Server::of(node).read(&mut self.link, 0x1000, 0)?;
                answer.must(node, "to read the device type")?;
                nmt::send(&mut self.link, Command::ResetNode, node)?;
                Ok(())
            }
            (Target::J1939(_), Protocol::Canopen(tables)) => {
                let Some(object) = commands(tables, Starts::Reset).next() else {
                    return Err(unexpected("restart"));
                };
                self.object(object, &[1], "the restart")
            }
            (Target::Devicenet(_), _) => self.reset(0),
            _ => Err(unexpected("restart")),
        }
    }

    /// The reset service of the identity object. It ends the connection.
    fn reset(&mut self, kind: u8) -> Result<(), Error> {
        let Target::Devicenet(slave) = self.target else {
            return Err(unexpected("reset"));
        };
        let identity = Path {
            class: 1,
            instance: 1,
        };
        let response = self.explicit(slave, service::RESET, identity, &[kind])?;
        self.is_allocated = false;
        response.must(slave.mac, "the reset").map(|_| ())
    }

    fn signed(&mut self, tables: &listing::fsc::Tables, operation: Operation) -> Result<(), Error> {
        let function = function(tables, operation)?;
        self.fsc_command(function.code, function.signature, fsc::SAVED)
    }

    fn object(&mut self, (index, sub): (u16, u8), bytes: &[u8], what: &str) -> Result<(), Error> {
        let server = self.target.server().ok_or_else(|| unexpected(what))?;
        let server = server.patient();
        server
            .write(&mut self.link, index, sub, bytes)?
            .must(server, what)
    }
}

fn function(tables: &listing::fsc::Tables, operation: Operation) -> Result<Function, Error> {
    let mut functions = tables.functions.iter();
    let function = functions.find(|function| function.operation == operation);
    function.copied().ok_or_else(|| unexpected("the function"))
}

/// J1939 has no such command; a product has its own ones.
fn no_command(what: &str) -> Error {
    Error::usage("not-offered", format!("J1939 has no command that {what}"))
}

/// The addresses of the objects with some services, in the order of the dictionary.
fn services(tables: &listing::canopen::Tables, is: impl Fn(Service) -> bool) -> Vec<(u16, u8)> {
    let objects = tables.objects.iter();
    let objects = objects.filter(|object| object.service().is_some_and(&is));
    objects.map(|object| (object.index, object.sub)).collect()
}

/// The addresses of the own objects that start this action when 1 is written.
fn commands(tables: &listing::canopen::Tables, wanted: Starts) -> impl Iterator<Item = (u16, u8)> {
    let objects = tables.objects.iter().filter(move |object| {
        matches!(object.target, ObjectTarget::Own(Use::Command(command)) if command.starts == wanted)
    });
    objects.map(|object| (object.index, object.sub))
}
