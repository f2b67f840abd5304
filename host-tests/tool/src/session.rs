//! A session with one sensor: reads, writes and commands, whatever its protocol.

use crate::error::{Error, SensorError, What, Why};
use crate::link::Link;
use crate::master::devicenet::Connection;
use crate::master::{Roles, Storing, Target};
use crate::note::Note;
use crate::number::Scale;
use crate::ops::report::Done;
use crate::sheet::{Address, Entry, Sheet};
use plumbline::model::catalog::Product;
use plumbline::param::{ParameterId, number};

/// The number of times a read is tried.
const TRIES: u8 = 3;

/// The connection to a sensor.
pub struct Session {
    /// The link to the bus.
    pub link: Link,
    /// The address of the sensor.
    pub target: Target,
    /// The entries of the sensor.
    pub sheet: Sheet,
    /// What the user must know at the end; see [`note`](Self::note).
    pub notes: Vec<Note>,
    /// Another master owns the sensor: nothing is sent to it, and it is only listened to.
    pub only_listens: bool,
    /// The last number that was written to each entry since an operation has cleared this.
    pub(crate) written: Vec<(String, u32)>,
    /// The serial number that the sensor must have at each new connection of DeviceNet. None: any.
    pub expected: Option<u32>,
    /// The connection of DeviceNet.
    pub(crate) connection: Connection,
    /// The settings that were read with this connection.
    settings: Vec<(Address, Vec<u8>)>,
    /// What one operation knows of the sensor; None: the sensor is asked each time.
    known: Option<Known>,
}

/// What the sensor has told since its last change. One operation does not ask for it twice.
#[derive(Default)]
pub(crate) struct Known {
    /// The bytes at each address; for FSC all data of the reply.
    pub read: Vec<(Address, Vec<u8>)>,
    /// FSC: the last reply had no error in its status.
    pub is_clean: bool,
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
            written: Vec::new(),
            expected: None,
            connection: Connection::default(),
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

    /// What the sensor has told since its last change, if the operation remembers it.
    pub(crate) fn known(&mut self) -> Option<&mut Known> {
        self.known.as_mut()
    }

    /// Forgets the settings that were read with the connection of DeviceNet.
    pub(crate) fn forget_settings(&mut self) {
        self.settings.clear();
    }

    /// Releases the connection of DeviceNet.
    ///
    /// # Errors
    /// The adapter fails.
    pub fn release(&mut self) -> Result<(), Error> {
        let target = self.target;
        target.release(self)
    }

    /// Remembers what the user must know at the end, each once.
    pub fn note(&mut self, note: Note) {
        if !self.notes.contains(&note) {
            self.notes.push(note);
        }
    }

    /// The sensor has another address now, and its connections are released.
    pub fn moved(&mut self, target: Target) {
        self.target = target;
        self.connection.is_allocated = false;
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
        if self.connection.is_allocated && entry.writable && !entry.command {
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
                Err(Error::Silent(_)) => read = self.bytes_once(entry),
                _ => break,
            }
        }
        read
    }

    fn bytes_once(&mut self, entry: &Entry) -> Result<Vec<u8>, Error> {
        let target = self.target;
        target.read(self, entry)
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
        match settings
            .find(|(address, _)| self.connection.is_allocated && *address == entry.address)
        {
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
        let target = self.target;
        target.write_values(self, values)?;
        for (entry, raw) in values {
            self.written.retain(|(name, _)| *name != entry.name);
            self.written.push((entry.name.clone(), *raw));
        }
        Ok(())
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
        let target = self.target;
        target.write(self, entry, bytes)?;
        if is_kept && self.connection.is_allocated {
            self.settings.push((entry.address, bytes.to_vec()));
        }
        Ok(())
    }

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
                Err(Error::Silent(_)) => written = self.write(&value),
                _ => break,
            }
        }
        self.link.set_ending(was_ending);
        let (name, value) = (entry.name.clone(), entry.text(raw));
        let explained = |failure: Error| {
            failure.explained(|failure| Why::NotRestored(failure, name, value, raw))
        };
        written.map_err(explained)
    }

    /// The serial number of the sensor, if its protocol tells it in one answer.
    ///
    /// # Errors
    /// The sensor refuses, nobody answers, or the adapter fails.
    pub(crate) fn serial(&mut self) -> Result<Option<u32>, Error> {
        let target = self.target;
        target.serial(self)
    }

    /// Stores the parameters. Returns a sentence about what happened.
    ///
    /// # Errors
    /// The sensor refuses, nobody answers, or the adapter fails.
    pub fn save(&mut self) -> Result<Done, Error> {
        let target = self.target;
        target.save(self)
    }

    /// Whether the sensor takes its factory values at its next start, without storing them.
    pub fn loads_at_restart(&self) -> bool {
        self.target.loads_at_restart(self)
    }

    /// Loads the factory values, and says what follows.
    ///
    /// # Errors
    /// The sensor refuses, nobody answers, or the adapter fails.
    pub fn load_factory(&mut self) -> Result<Done, Error> {
        let target = self.target;
        target.load(self)
    }

    /// Restarts the sensor.
    ///
    /// # Errors
    /// The sensor refuses, nobody answers, or the adapter fails.
    pub fn restart(&mut self) -> Result<(), Error> {
        let target = self.target;
        target.restart(self)
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
        entry.ok_or_else(|| unexpected(What::Parameter))
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
    bytes.ok_or_else(|| unexpected(What::Name(entry.name.clone())))
}

/// The answer does not fit the product.
pub(crate) fn unexpected(what: What) -> Error {
    SensorError::Unexpected(what).into()
}

fn raw_number(entry: &Entry, bytes: &[u8]) -> Result<u32, Error> {
    let bytes = bytes.get(..usize::from(entry.data_type.size()));
    bytes
        .map(number)
        .ok_or_else(|| unexpected(What::Name(entry.name.clone())))
}
