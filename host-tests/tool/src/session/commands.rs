//! The commands of a session: save, load the factory values, restart.

use super::{Session, Target, unexpected};
use crate::client::devicenet::{self, Path};
use crate::client::fsc;
use crate::client::nmt::{self, Command};
use crate::client::sdo::{self, Server};
use crate::failure::Failure;
use plumbline::canopen::dictionary::{Service, Target as ObjectTarget};
use plumbline::fsc::table::{Function, Operation};
use plumbline::model::catalog::Protocol;
use plumbline::model::listing;
use plumbline::time::millis;

impl Session {
    /// Stores the parameters. Returns a sentence about what happened.
    ///
    /// # Errors
    /// The sensor refuses, nobody answers, or those of the adapter.
    pub fn save(&mut self) -> Result<&'static str, Failure> {
        match &self.sheet.product.protocol {
            Protocol::Fsc(tables) => self.signed(tables, Operation::Save)?,
            Protocol::Canopen(tables) => {
                let is = |service| matches!(service, Service::Store | Service::StoreGroup);
                let [object, ..] = services(tables, is)[..] else {
                    return Err(unexpected("save"));
                };
                self.object(object, b"save", "save")?;
            }
            Protocol::Devicenet(_) => {
                return Ok("the sensor stores each change by itself within one second");
            }
        }
        Ok("stored")
    }

    /// Loads the factory values. Returns a sentence about what follows.
    ///
    /// # Errors
    /// The sensor refuses, nobody answers, or those of the adapter.
    pub fn load_factory(&mut self) -> Result<&'static str, Failure> {
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
                    return Ok("factory values act after a restart; `save` then keeps them");
                }
                for object in services(tables, |service| service == Service::RestoreCommunication) {
                    self.object(object, b"load", "load")?;
                }
                for object in services(tables, |service| service == Service::RestoreApplication) {
                    self.object(object, &[1], "load")?;
                }
                Ok("factory values are loaded; node-ID and bit rate act after a restart")
            }
            Protocol::Devicenet(_) => {
                self.reset(1)?;
                Ok("the sensor restarts with factory values, also those of MAC ID and bit rate")
            }
        }
    }

    /// Restarts the sensor.
    ///
    /// # Errors
    /// The sensor refuses, nobody answers, or those of the adapter.
    pub fn restart(&mut self) -> Result<(), Failure> {
        match (self.target, &self.sheet.product.protocol) {
            (Target::Fsc(sensor), Protocol::Fsc(tables)) => {
                let function = function(tables, Operation::Alive)?;
                // There is no answer, so the sensor must be there before.
                fsc::must(&mut self.link, sensor, function.code, &[], fsc::ANSWER)?;
                fsc::ask(
                    &mut self.link,
                    sensor,
                    function.code,
                    function.signature,
                    millis(20),
                )?;
                Ok(())
            }
            (Target::Canopen(node), _) => {
                let answer = Server::of(node).read(&mut self.link, 0x1000, 0)?;
                answer.must(node, "to read the device type")?;
                nmt::send(&mut self.link, Command::ResetNode, node)?;
                // The command must leave the adapter before it is closed.
                self.link.wait_for(millis(20), |_| None::<()>)?;
                Ok(())
            }
            (Target::Devicenet(_), _) => self.reset(0),
            _ => Err(unexpected("restart")),
        }
    }

    /// The reset service of the identity object. It ends the connection.
    fn reset(&mut self, kind: u8) -> Result<(), Failure> {
        let Target::Devicenet(slave) = self.target else {
            return Err(unexpected("reset"));
        };
        let slave = self.slave(slave)?;
        let identity = Path {
            class: 1,
            instance: 1,
        };
        let response = slave.explicit(&mut self.link, devicenet::RESET, identity, &[kind])?;
        self.is_allocated = false;
        response.must(slave.mac, "the reset").map(|_| ())
    }

    fn signed(
        &mut self,
        tables: &listing::fsc::Tables,
        operation: Operation,
    ) -> Result<(), Failure> {
        let function = function(tables, operation)?;
        self.fsc_command(function.code, function.signature, fsc::SAVED)
    }

    fn object(&mut self, (index, sub): (u16, u8), bytes: &[u8], what: &str) -> Result<(), Failure> {
        let Target::Canopen(node) = self.target else {
            return Err(unexpected(what));
        };
        let server = Server {
            time: sdo::SAVED,
            ..Server::of(node)
        };
        server
            .write(&mut self.link, index, sub, bytes)?
            .must(node, what)
    }
}

fn function(tables: &listing::fsc::Tables, operation: Operation) -> Result<Function, Failure> {
    let mut functions = tables.functions.iter();
    let function = functions.find(|function| function.operation == operation);
    function.copied().ok_or_else(|| unexpected("the function"))
}

/// The addresses of the objects with some services, in the order of the dictionary.
fn services(tables: &listing::canopen::Tables, is: impl Fn(Service) -> bool) -> Vec<(u16, u8)> {
    let objects = tables.objects.iter();
    let objects = objects
        .filter(|object| matches!(object.target, ObjectTarget::Service(service) if is(service)));
    objects.map(|object| (object.index, object.sub)).collect()
}
