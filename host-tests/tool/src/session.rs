//! A session with one sensor: reads, writes and commands, whatever its protocol.

mod commands;

use crate::client::Link;
use crate::client::devicenet::{Path, Response, Slave};
use crate::client::fsc;
use crate::connect;
use crate::error::Error;
use crate::master::{Roles, Storing, Target};
use crate::number::Scale;
use crate::sheet::{Address, Entry, Sheet};
use plumbline::devicenet::service;
use plumbline::model::catalog::{Product, Protocol};
use plumbline::param::{DataType, ParameterId, number};
use plumbline::time::{Duration, Instant, after, millis};

/// The number of times a read is tried.
const TRIES: u8 = 3;

/// How long a connection of DeviceNet is certain to live after an answer; it ends after 10 s.
const FRESH: Duration = millis(5000);

/// The identity object of DeviceNet.
const IDENTITY: Path = Path {
    class: 1,
    instance: 1,
};

/// The attribute of the identity object with the serial number.
const SERIAL: u8 = 6;

/// The connection to a sensor.
pub struct Session {
    /// The link to the bus.
    pub link: Link,
    /// The address of the sensor.
    pub target: Target,
    /// The entries of the sensor.
    pub sheet: Sheet,
    /// What the user must know at the end; see [`note`](Self::note).
    pub notes: Vec<String>,
    /// Another master owns the sensor: nothing is sent to it, and it is only listened to.
    pub only_listens: bool,
    /// The serial number that the sensor must have at each new connection of DeviceNet. None: any.
    pub expected: Option<u32>,
    /// The connection of DeviceNet is allocated. Meanwhile nobody else can change the sensor, and another sensor does not answer.
    is_allocated: bool,
    /// The last answer on it.
    used: Option<Instant>,
    /// The settings that were read with this connection.
    settings: Vec<(Address, Vec<u8>)>,
    /// What one operation knows of the sensor; None: the sensor is asked each time.
    known: Option<Known>,
}

/// What the sensor has told since its last change. One operation does not ask for it twice.
#[derive(Default)]
struct Known {
    /// The bytes at each address; for FSC all data of the reply.
    read: Vec<(Address, Vec<u8>)>,
    /// FSC: the last reply had no error in its status.
    is_clean: bool,
}

impl Session {
    /// A session with the sensor at this address, which is of this product.
    pub fn new(link: Link, target: Target, product: &'static Product) -> Self {
        Self::with_sheet(link, target, Sheet::of(product))
    }

    /// A session with the device at this address, which has this sheet.
    pub fn with_sheet(link: Link, target: Target, sheet: Sheet) -> Self {
        Self {
            link,
            target,
            sheet,
            notes: Vec::new(),
            only_listens: false,
            expected: None,
            is_allocated: false,
            used: None,
            settings: Vec::new(),
            known: None,
        }
    }

    /// The parameters of the sensor with a role in its protocol.
    pub(crate) fn roles(&self) -> Option<Roles> {
        (self.target.protocol().roles)(self.sheet.product)
    }

    /// What stores a change in the sensor.
    pub(crate) fn storing(&self) -> Storing {
        let roles = Roles::of(self.sheet.product);
        roles.map_or(Storing::Unknown, |roles| roles.storing)
    }

    /// Ends the session and returns the link. A connection of DeviceNet is released.
    ///
    /// # Errors
    /// The adapter fails.
    pub fn finish(mut self) -> Result<Link, Error> {
        self.release()?;
        Ok(self.link)
    }

    /// From now on, the session does not ask twice for a value that nothing has changed; or it asks each time again.
    pub fn remember(&mut self, is_wanted: bool) {
        self.known = is_wanted.then(Known::default);
    }

    /// Releases the connection of DeviceNet.
    ///
    /// # Errors
    /// The adapter fails.
    pub fn release(&mut self) -> Result<(), Error> {
        if let (Target::Devicenet(slave), true) = (self.target, self.is_allocated) {
            self.is_allocated = false;
            slave.release(&mut self.link)?;
        }
        Ok(())
    }

    /// Remembers what the user must know at the end, each once.
    pub fn note(&mut self, note: impl Into<String>) {
        let note = note.into();
        if !self.notes.contains(&note) {
            self.notes.push(note);
        }
    }

    /// The sensor has another address now, and its connections are released.
    pub fn moved(&mut self, target: Target) {
        self.target = target;
        self.is_allocated = false;
    }

    /// Makes sure that the connection of DeviceNet is still that to the expected sensor. A connection that has just been used is.
    ///
    /// # Errors
    /// Another sensor answers, nobody answers, or the adapter fails.
    pub(crate) fn freshen(&mut self, slave: Slave) -> Result<(), Error> {
        let used = self.used.filter(|_| self.is_allocated);
        if used.is_none_or(|used| self.link.now() >= after(used, FRESH)) {
            // A connection that has ended is allocated again, with the check.
            let told = self.explicit(slave, service::GET, IDENTITY, &[SERIAL])?;
            told.must(slave.mac, "to read the serial number")?;
        }
        Ok(())
    }

    /// Allocates the connection of DeviceNet, if it is not allocated.
    ///
    /// # Errors
    /// Another sensor answers, nobody answers, or the adapter fails.
    fn slave(&mut self, slave: Slave) -> Result<Slave, Error> {
        if !self.is_allocated {
            self.settings.clear();
            slave.allocate(&mut self.link)?;
            self.is_allocated = true;
            if let Some(expected) = self.expected {
                let told = slave.explicit(&mut self.link, service::GET, IDENTITY, &[SERIAL])?;
                let told = told.must(slave.mac, "to read the serial number")?;
                if number(&told) != expected {
                    self.release()?;
                    let what = format!("serial {} at MAC ID {}", number(&told), slave.mac);
                    return Err(connect::other(&what));
                }
            }
        }
        Ok(slave)
    }

    /// The bytes of an entry; a text has any length. A request without an answer is repeated.
    ///
    /// # Errors
    /// The sensor refuses, nobody answers, or the adapter fails.
    pub fn read_bytes(&mut self, entry: &Entry) -> Result<Vec<u8>, Error> {
        let read = self.known.iter().flat_map(|known| &known.read);
        let mut read = read.filter(|(address, _)| address.is_read_with(entry.address));
        if let Some((_, bytes)) = read.next() {
            return part(entry, bytes);
        }
        let bytes = self.bytes_repeated(entry)?;
        if let Some(known) = &mut self.known {
            known.read.push((entry.address, bytes.clone()));
        }
        if self.is_allocated && entry.writable && !entry.command {
            self.settings.retain(|(own, _)| *own != entry.address);
            self.settings.push((entry.address, bytes.clone()));
        }
        part(entry, &bytes)
    }

    /// All data with an entry; a request without an answer is repeated.
    fn bytes_repeated(&mut self, entry: &Entry) -> Result<Vec<u8>, Error> {
        let mut read = self.bytes_once(entry);
        for _ in 1..TRIES {
            match &read {
                Err(failure) if failure.code == "no-answer" => read = self.bytes_once(entry),
                _ => break,
            }
        }
        read
    }

    fn bytes_once(&mut self, entry: &Entry) -> Result<Vec<u8>, Error> {
        match (self.target, entry.address) {
            (Target::Fsc(sensor), Address::Fsc { read, .. }) => {
                let reply = fsc::once(&mut self.link, sensor, read, &[], fsc::ANSWER)?;
                Ok(reply.data)
            }
            (target, Address::Object { index, sub }) => {
                let server = target.server().ok_or_else(|| unexpected(&entry.name))?;
                let answer = server.read(&mut self.link, index, sub)?;
                answer.must(server, &format!("to read {}", entry.name))
            }
            (
                Target::Devicenet(slave),
                Address::Attribute {
                    class,
                    instance,
                    attribute,
                },
            ) => {
                let path = Path { class, instance };
                let response = self.explicit(slave, service::GET, path, &[attribute])?;
                let bytes = response.must(slave.mac, &format!("to read {}", entry.name))?;
                Ok(match entry.data_type {
                    DataType::Text => short_string(&bytes).to_vec(),
                    _ => bytes,
                })
            }
            _ => Err(unexpected(&entry.name)),
        }
    }

    /// A request on the explicit connection. A pause of more than 10 s ends the connection; then it is allocated again.
    ///
    /// # Errors
    /// Another master owns the sensor, or the adapter fails.
    pub(crate) fn explicit(
        &mut self,
        slave: Slave,
        code: u8,
        path: Path,
        data: &[u8],
    ) -> Result<Response, Error> {
        let was_allocated = self.is_allocated;
        let slave = self.slave(slave)?;
        let response = slave.explicit(&mut self.link, code, path, data)?;
        if response != Response::Silent {
            self.used = Some(self.link.now());
        }
        if response != Response::Silent || !was_allocated {
            return Ok(response);
        }
        self.is_allocated = false;
        let slave = self.slave(slave)?;
        slave.explicit(&mut self.link, code, path, data)
    }

    /// The raw number of an entry.
    ///
    /// # Errors
    /// See [`read_bytes`](Self::read_bytes).
    pub fn read(&mut self, entry: &Entry) -> Result<u32, Error> {
        let bytes = self.read_bytes(entry)?;
        raw_number(entry, &bytes)
    }

    /// The raw number of a setting. It is not read again while the connection of DeviceNet is allocated.
    ///
    /// # Errors
    /// See [`read_bytes`](Self::read_bytes).
    pub(crate) fn in_force(&mut self, entry: &Entry) -> Result<u32, Error> {
        let mut settings = self.settings.iter();
        match settings.find(|(address, _)| self.is_allocated && *address == entry.address) {
            Some((_, bytes)) => raw_number(entry, bytes),
            None => self.read(entry),
        }
    }

    /// The raw number of an entry, without repetitions.
    ///
    /// # Errors
    /// See [`read_bytes`](Self::read_bytes).
    pub fn read_once(&mut self, entry: &Entry) -> Result<u32, Error> {
        let bytes = self.bytes_once(entry)?;
        raw_number(entry, &part(entry, &bytes)?)
    }

    /// Writes raw numbers. Parameters of FSC with the same code are written together: those that are not given keep their values.
    ///
    /// # Errors
    /// The sensor refuses, nobody answers, or the adapter fails.
    pub fn write(&mut self, values: &[(Entry, u32)]) -> Result<(), Error> {
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
                        self.fsc_command(write, &data, fsc::WRITTEN)?;
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
    fn bytes_of_code(&mut self, code: u8, values: &[(Entry, u32)]) -> Result<Vec<u8>, Error> {
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
    /// The sensor refuses, nobody answers, or the adapter fails.
    pub fn write_bytes(&mut self, entry: &Entry, bytes: &[u8]) -> Result<(), Error> {
        // The resolution is read once, though values in its unit are written.
        let resolution = self.sheet.product.guide.resolution;
        let resolution = resolution.and_then(|own| self.sheet.parameter(own.parameter));
        let resolution = resolution.map(|own| own.address);
        let is_kept = !entry.command && resolution != Some(entry.address);
        self.settings
            .retain(|(address, _)| is_kept && *address != entry.address);
        if let Some(known) = &mut self.known {
            let is_resolution = |address| is_kept && resolution == Some(address);
            known.read.retain(|(address, _)| is_resolution(*address));
        }
        let what = format!("to write {}", entry.name);
        match (self.target, entry.address) {
            (
                Target::Fsc(_),
                Address::Fsc {
                    write: Some(write), ..
                },
            ) => self.fsc_command(write, bytes, fsc::WRITTEN),
            (target, Address::Object { index, sub }) => {
                let server = target.server().ok_or_else(|| unexpected(&entry.name))?;
                let server = server.patient();
                server
                    .write(&mut self.link, index, sub, bytes)?
                    .must(server, &what)
            }
            (
                Target::Devicenet(slave),
                Address::Attribute {
                    class,
                    instance,
                    attribute,
                },
            ) => {
                let path = Path { class, instance };
                let data = [&[attribute], bytes].concat();
                let response = self.explicit(slave, service::SET, path, &data)?;
                response.must(slave.mac, &what)?;
                if is_kept {
                    self.settings.push((entry.address, bytes.to_vec()));
                }
                Ok(())
            }
            _ => Err(unexpected(&entry.name)),
        }
    }

    fn fsc_command(&mut self, code: u8, data: &[u8], time: Duration) -> Result<(), Error> {
        let (Target::Fsc(sensor), Protocol::Fsc(tables)) =
            (self.target, &self.sheet.product.protocol)
        else {
            return Err(unexpected("the request"));
        };
        // The request for the status clears its errors. There is nothing to clear if the reply before this request had none.
        let is_clean = self.known.as_ref().is_some_and(|known| known.is_clean);
        let earlier = match is_clean {
            true => Vec::new(),
            false => fsc::earlier(&mut self.link, sensor, tables)?,
        };
        if let Some(known) = &mut self.known {
            known.read.clear();
        }
        fsc::command(&mut self.link, sensor, tables, code, data, time)?;
        for name in earlier {
            let note =
                format!("the sensor had the error {name} before this command, which cleared it");
            self.note(note);
        }
        Ok(())
    }

    /// The number of an entry with the scale in force: the resolution can select it. Of a sensor that is only listened to, that as
    /// delivered.
    ///
    /// # Errors
    /// See [`read_bytes`](Self::read_bytes).
    pub fn scale_of(&mut self, entry: &Entry) -> Result<Scale, Error> {
        let resolution = self.sheet.product.guide.resolution;
        let is_selected = self.sheet.follows_resolution(entry) && !self.only_listens;
        let Some(resolution) = resolution.filter(|_| is_selected) else {
            return Ok(entry.scale.clone());
        };
        let Some(own) = self.sheet.parameter(resolution.parameter).cloned() else {
            return Ok(entry.scale.clone());
        };
        let number = self.in_force(&own)?;
        Ok(own.scale.times(number))
    }

    /// The entry of a parameter.
    ///
    /// # Errors
    /// The product has no address for it.
    pub fn entry(&self, id: ParameterId) -> Result<Entry, Error> {
        let entry = self.sheet.parameter(id).cloned();
        entry.ok_or_else(|| unexpected("a parameter"))
    }
}

/// The bytes of an entry in what was read with it.
fn part(entry: &Entry, bytes: &[u8]) -> Result<Vec<u8>, Error> {
    let Address::Fsc { offset, .. } = entry.address else {
        return Ok(bytes.to_vec());
    };
    let from = usize::from(offset);
    let to = from + usize::from(entry.data_type.size());
    let bytes = bytes.get(from..to).map(<[u8]>::to_vec);
    bytes.ok_or_else(|| unexpected(&entry.name))
}

/// The answer does not fit the product.
fn unexpected(what: &str) -> Error {
    Error::refused(
        "unexpected-answer",
        format!("the answer to {what} does not fit the product: is --product right?"),
    )
}

/// The letters of a text of DeviceNet (SHORT_STRING), which begins with its length.
fn short_string(bytes: &[u8]) -> &[u8] {
    match bytes {
        [length, letters @ ..] => &letters[..letters.len().min(usize::from(*length))],
        [] => bytes,
    }
}

fn raw_number(entry: &Entry, bytes: &[u8]) -> Result<u32, Error> {
    let bytes = bytes.get(..usize::from(entry.data_type.size()));
    bytes.map(number).ok_or_else(|| unexpected(&entry.name))
}
