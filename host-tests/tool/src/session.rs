//! A session with one sensor: reads, writes and commands, whatever its protocol.

mod commands;

use crate::client::Link;
use crate::client::devicenet::{Path, Slave};
use crate::client::fsc::{self, Sensor};
use crate::client::sdo::{self, Server};
use crate::failure::Failure;
use crate::number::Scale;
use crate::sheet::{Address, Entry, Sheet};
use plumbline::model::catalog::{Product, Protocol};
use plumbline::param::{ParameterId, number};

/// The address of a sensor.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Target {
    /// Function select codes.
    Fsc(Sensor),
    /// A CANopen node.
    Canopen(u8),
    /// A DeviceNet slave.
    Devicenet(Slave),
}

impl Target {
    /// The address as `scan` shows it and the command line takes it: 300, 10 or 63.
    pub fn address(&self) -> String {
        match self {
            Self::Fsc(sensor) => fsc::shown(sensor.request).trim_end_matches('h').to_owned(),
            Self::Canopen(node) => node.to_string(),
            Self::Devicenet(slave) => slave.mac.to_string(),
        }
    }
}

/// A session.
pub struct Session {
    /// The link to the bus.
    pub link: Link,
    /// The address of the sensor.
    pub target: Target,
    /// Its sheet.
    pub sheet: Sheet,
    /// The connection of DeviceNet is allocated.
    is_allocated: bool,
}

impl Session {
    /// A session with the sensor at this address, which is of this product.
    pub fn new(link: Link, target: Target, product: &'static Product) -> Self {
        Self {
            link,
            target,
            sheet: Sheet::of(product),
            is_allocated: false,
        }
    }

    /// Ends the session and returns the link. A connection of DeviceNet is released.
    ///
    /// # Errors
    /// Those of the adapter.
    pub fn finish(mut self) -> Result<Link, Failure> {
        self.release()?;
        Ok(self.link)
    }

    /// Releases the connection of DeviceNet.
    ///
    /// # Errors
    /// Those of the adapter.
    pub fn release(&mut self) -> Result<(), Failure> {
        if let (Target::Devicenet(slave), true) = (self.target, self.is_allocated) {
            self.is_allocated = false;
            slave.release(&mut self.link)?;
        }
        Ok(())
    }

    /// The sensor has another address now, and its connections are released.
    pub fn moved(&mut self, target: Target) {
        self.target = target;
        self.is_allocated = false;
    }

    fn slave(&mut self, slave: Slave) -> Result<Slave, Failure> {
        if !self.is_allocated {
            slave.allocate(&mut self.link)?;
            self.is_allocated = true;
        }
        Ok(slave)
    }

    /// The bytes of an entry; a text has any length.
    ///
    /// # Errors
    /// The sensor refuses, nobody answers, or those of the adapter.
    pub fn read_bytes(&mut self, entry: &Entry) -> Result<Vec<u8>, Failure> {
        match (self.target, entry.address) {
            (Target::Fsc(sensor), Address::Fsc { read, offset, .. }) => {
                let reply = fsc::must(&mut self.link, sensor, read, &[], fsc::ANSWER)?;
                let from = usize::from(offset);
                let to = from + usize::from(entry.data_type.size());
                let bytes = reply.data.get(from..to);
                bytes
                    .map(<[u8]>::to_vec)
                    .ok_or_else(|| unexpected(&entry.name))
            }
            (Target::Canopen(node), Address::Object { index, sub }) => {
                let answer = Server::of(node).read(&mut self.link, index, sub)?;
                answer.must(node, &format!("to read {}", entry.name))
            }
            (
                Target::Devicenet(slave),
                Address::Attribute {
                    class,
                    instance,
                    attribute,
                },
            ) => {
                let slave = self.slave(slave)?;
                let path = Path { class, instance };
                let response = slave.get(&mut self.link, path, attribute)?;
                response.must(slave.mac, &format!("to read {}", entry.name))
            }
            _ => Err(unexpected(&entry.name)),
        }
    }

    /// The raw number of an entry.
    ///
    /// # Errors
    /// See [`read_bytes`](Self::read_bytes).
    pub fn read(&mut self, entry: &Entry) -> Result<u32, Failure> {
        let bytes = self.read_bytes(entry)?;
        let bytes = bytes.get(..usize::from(entry.data_type.size()));
        bytes.map(number).ok_or_else(|| unexpected(&entry.name))
    }

    /// Writes raw numbers. Parameters of FSC with the same code are written together: those that are not given keep their values.
    ///
    /// # Errors
    /// The sensor refuses, nobody answers, or those of the adapter.
    pub fn write(&mut self, values: &[(Entry, u32)]) -> Result<(), Failure> {
        let mut done = Vec::new();
        for (entry, raw) in values {
            match (self.target, entry.address) {
                (
                    Target::Fsc(_),
                    Address::Fsc {
                        write: Some(write), ..
                    },
                ) => {
                    if !done.contains(&write) {
                        done.push(write);
                        let data = self.bytes_of_code(write, values)?;
                        self.fsc_command(write, &data, fsc::ANSWER)?;
                    }
                }
                _ => {
                    let size = usize::from(entry.data_type.size());
                    self.write_bytes(entry, &raw.to_le_bytes()[..size])?;
                }
            }
        }
        Ok(())
    }

    /// The data of a write code: the given values, and the present ones of the other parameters.
    fn bytes_of_code(&mut self, code: u8, values: &[(Entry, u32)]) -> Result<Vec<u8>, Failure> {
        let is = |entry: &&Entry| matches!(entry.address, Address::Fsc { write: Some(own), .. } if own == code);
        let parts: Vec<Entry> = self.sheet.entries.iter().filter(is).cloned().collect();
        let mut data = Vec::new();
        for part in parts {
            let given = values.iter().find(|(entry, _)| entry.name == part.name);
            let raw = match given {
                Some((_, raw)) => *raw,
                None => self.read(&part)?,
            };
            data.extend_from_slice(&raw.to_le_bytes()[..usize::from(part.data_type.size())]);
        }
        Ok(data)
    }

    /// Writes the bytes of an entry, also none (FSC: the sensor takes the value from the present position) or a text.
    ///
    /// # Errors
    /// The sensor refuses, nobody answers, or those of the adapter.
    pub fn write_bytes(&mut self, entry: &Entry, bytes: &[u8]) -> Result<(), Failure> {
        let what = format!("to write {}", entry.name);
        match (self.target, entry.address) {
            (
                Target::Fsc(_),
                Address::Fsc {
                    write: Some(write), ..
                },
            ) => self.fsc_command(write, bytes, fsc::ANSWER),
            (Target::Canopen(node), Address::Object { index, sub }) => {
                let server = Server {
                    time: sdo::SAVED,
                    ..Server::of(node)
                };
                server
                    .write(&mut self.link, index, sub, bytes)?
                    .must(node, &what)
            }
            (
                Target::Devicenet(slave),
                Address::Attribute {
                    class,
                    instance,
                    attribute,
                },
            ) => {
                let slave = self.slave(slave)?;
                let path = Path { class, instance };
                let response = slave.set(&mut self.link, path, attribute, bytes)?;
                response.must(slave.mac, &what).map(|_| ())
            }
            _ => Err(unexpected(&entry.name)),
        }
    }

    fn fsc_command(
        &mut self,
        code: u8,
        data: &[u8],
        time: plumbline::time::Duration,
    ) -> Result<(), Failure> {
        let (Target::Fsc(sensor), Protocol::Fsc(tables)) =
            (self.target, &self.sheet.product.protocol)
        else {
            return Err(unexpected("the request"));
        };
        fsc::command(&mut self.link, sensor, tables, code, data, time)
    }

    /// The number of an entry with the scale in force: the resolution can select it.
    ///
    /// # Errors
    /// See [`read_bytes`](Self::read_bytes).
    pub fn scale_of(&mut self, entry: &Entry) -> Result<Scale, Failure> {
        let resolution = self.sheet.product.guide.resolution;
        let Some(resolution) = resolution.filter(|_| self.sheet.follows_resolution(entry)) else {
            return Ok(entry.scale.clone());
        };
        let Some(own) = self.sheet.parameter(resolution.parameter).cloned() else {
            return Ok(entry.scale.clone());
        };
        let number = self.read(&own)?;
        Ok(own.scale.times(number))
    }

    /// The entry of a parameter.
    ///
    /// # Errors
    /// The product has no address for it.
    pub fn entry(&self, id: ParameterId) -> Result<Entry, Failure> {
        let entry = self.sheet.parameter(id).cloned();
        entry.ok_or_else(|| unexpected("a parameter"))
    }
}

/// The answer does not fit the product.
fn unexpected(what: &str) -> Failure {
    Failure::refused(
        "unexpected-answer",
        format!("the answer to {what} does not fit the product: is --product right?"),
    )
}
