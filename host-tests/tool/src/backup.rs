//! The file with the settings of a sensor: TOML that people can read and change.
//!
//! ```toml
//! [sensor]
//! product = "is2"
//! article = "PR-23054-30"
//! serial = 1
//! firmware = "3.44"
//!
//! [parameters]
//! cyclic-time = "250 ms"
//! filter-type = "critically damped"
//! ```
//!
//! A value has the text of `get`. It is read as the one of `set` is, so `0.25 s` is the same.

mod file;
mod set;
mod texts;

pub use bench::file::{Unread, read as read_file, read_text};
pub use file::write_file;

use crate::error::{Error, Fault, FileError, NumberError};
use crate::identify::{Found, product};
use crate::master::canopen::{fit, tables};
use crate::number::Scale;
use crate::ops::set::once_each;
use crate::resolve;
use crate::sheet::{Entry, Origin, Sheet, parameters};
use ::texts::told;
use plumbline::param::ParameterId;
use std::path::Path;
use toml::{Table, Value};

/// The bits of a COB-ID that are its identifier.
const IDENTIFIER: u32 = 0x1FFF_FFFF;

/// The first line of a file.
const HEADING: &str = "# Settings of a CAN inclination sensor, written by plumbline. `plumbline restore` writes them to a sensor.\n";

/// The settings of a sensor.
#[derive(Clone, Debug)]
pub struct Backup {
    /// The sheet of the product.
    pub sheet: Sheet,
    /// The order number of the sensor.
    pub article: Option<String>,
    /// The serial number of the sensor.
    pub serial: Option<u32>,
    /// The version of the firmware.
    pub firmware: Option<String>,
    /// The node-ID of a device with a data sheet, which does not say which of its entries this is.
    pub node_id: Option<u8>,
    /// The name that the user has given to the sensor.
    pub label: Option<String>,
    /// Texts that a tool can write, for example the programming key; for people, they are not restored.
    pub texts: Vec<(String, String)>,
    /// What the sensor had taken from its position, with its value; no other sensor can be given it.
    pub taken: Vec<(String, String)>,
    /// Entries with their raw numbers.
    pub values: Vec<(Entry, u32)>,
}

impl Backup {
    /// The settings of a sensor that has been identified.
    pub fn new(sheet: &Sheet, found: &Found) -> Self {
        Self {
            article: found.article.clone(),
            serial: found.serial,
            firmware: found.firmware.clone(),
            node_id: found
                .target
                .node_id()
                .filter(|_| sheet.data_sheet.is_some()),
            label: found.label.clone(),
            ..Self::of(sheet)
        }
    }

    /// No settings of a product.
    pub fn of(sheet: &Sheet) -> Self {
        Self {
            sheet: sheet.clone(),
            article: None,
            serial: None,
            firmware: None,
            node_id: None,
            label: None,
            texts: Vec::new(),
            taken: Vec::new(),
            values: Vec::new(),
        }
    }

    /// Reads a file.
    ///
    /// # Errors
    /// The file cannot be read, is no backup, or has a name or value that the product does not have.
    pub fn read(path: &Path) -> Result<Self, Error> {
        Self::read_with(path, None)
    }

    /// The same. A product that is not in the catalogue is the product of `foreign`.
    ///
    /// # Errors
    /// See [`read`](Self::read).
    pub fn read_with(path: &Path, foreign: Option<&Sheet>) -> Result<Self, Error> {
        let shown = || path.display().to_string();
        let text = read_text(path).map_err(|unread| match unread {
            Unread::Failed(error) => FileError::BackupUnread(shown(), error.to_string()),
            Unread::Unfit(why) => FileError::Backup(shown(), why.into()),
        })?;
        let parsed = Self::parse_with(&text, foreign);
        parsed.map_err(|why| FileError::Backup(shown(), why).into())
    }

    /// Reads the text of a file.
    ///
    /// # Errors
    /// One sentence: it is no backup, or has a name or value that the product does not have.
    pub fn parse(text: &str) -> Result<Self, Fault> {
        Self::parse_with(text, None)
    }

    /// The same. A product that is not in the catalogue is the product of `foreign`.
    ///
    /// # Errors
    /// See [`parse`](Self::parse).
    pub fn parse_with(text: &str, foreign: Option<&Sheet>) -> Result<Self, Fault> {
        let table: Table = text
            .parse()
            .map_err(|error: toml::de::Error| told(error.message()))?;
        let section = |name: &str| {
            let section = table.get(name).and_then(Value::as_table);
            section.ok_or_else(|| Fault::NoSection(name.to_owned()))
        };
        let (sensor, parameters) = (section("sensor")?, section("parameters")?);
        let text = |name: &str| sensor.get(name).and_then(Value::as_str).map(str::to_owned);
        let name = text("product").ok_or(Fault::NoProduct)?;
        let sheet = match foreign.filter(|sheet| sheet.product.name == name) {
            Some(sheet) => sheet.clone(),
            None => Sheet::of(product(&name).map_err(|error| Fault::Product(Box::new(error)))?),
        };
        let serial = sensor.get("serial").and_then(Value::as_integer);
        let texts = texts::read(&table, &sheet);
        let taken = texts::taken(&table, &sheet);
        let node_id = sensor.get("node-id").map(|value| {
            let node = value.as_integer().and_then(|node| u8::try_from(node).ok());
            node.filter(|node| (1..=127).contains(node))
                .ok_or(Fault::NodeId)
        });
        let mut backup = Self {
            sheet,
            article: text("article"),
            serial: serial.and_then(|serial| u32::try_from(serial).ok()),
            firmware: text("firmware"),
            node_id: node_id.transpose()?,
            label: text("label"),
            texts,
            taken,
            values: Vec::new(),
        };
        // The resolution comes first: it is the unit of other values.
        let mut rows: Vec<(&String, &Value)> = parameters.iter().collect();
        let is_resolution = |name: &str| {
            let entry = backup.sheet.entries.iter().find(|entry| entry.name == name);
            entry.is_some_and(|entry| backup.sheet.is_resolution(entry))
        };
        rows.sort_by_key(|(name, _)| !is_resolution(name));
        for (name, value) in rows {
            let text = match value {
                Value::String(text) => text.clone(),
                Value::Integer(number) => number.to_string(),
                Value::Float(number) => number.to_string(),
                _ => return Err(Fault::NoQuotes(name.clone())),
            };
            backup.set(name, &text)?;
        }
        backup.constrain()?;
        Ok(backup)
    }

    /// Changes values by assignments as those of `set`. Returns the names of the values.
    ///
    /// # Errors
    /// A name is not known, or a value is not permitted, alone or together with the others.
    pub fn assign(&mut self, assignments: &[String]) -> Result<Vec<String>, Error> {
        let sheet = self.sheet.clone();
        let mut wanted = Vec::new();
        for assignment in assignments {
            wanted.extend(resolve::assignments(&sheet, assignment)?);
        }
        once_each(wanted.iter().map(|(entry, _)| *entry))?;
        // The resolution comes first: it is the unit of other values.
        wanted.sort_by_key(|(entry, _)| !sheet.is_resolution(entry));
        for (entry, text) in &wanted {
            self.set(&entry.name, text)?;
        }
        self.constrain()?;
        let names = wanted.iter().map(|(entry, _)| entry.name.clone());
        let names: Vec<String> = names.collect();
        fit::check(&self.sheet, &self.values, self.node(), &names)?;
        Ok(names)
    }

    /// Checks the values against each other.
    ///
    /// # Errors
    /// The sensor would refuse the values together.
    pub(crate) fn constrain(&self) -> Result<(), NumberError> {
        let value = |id: ParameterId| {
            let mut values = self.values.iter();
            let own = values.find(|(entry, _)| entry.origin == Origin::Parameter(id));
            own.map(|(_, raw)| *raw)
        };
        for constraint in self.sheet.product.constraints {
            let (one, other) = parameters(constraint);
            if let (Some(first), Some(second)) = (value(one), value(other))
                && let Some(why) = self.sheet.broken(constraint, first, second)
            {
                return Err(why);
            }
        }
        Ok(())
    }

    /// The node-ID in the file.
    pub fn node(&self) -> Option<u8> {
        let tables = tables(self.sheet.product)?;
        let wanted = Origin::Parameter(tables.node_id);
        let own = self.values.iter().find(|(entry, _)| entry.origin == wanted);
        own.and_then(|(_, raw)| u8::try_from(*raw).ok())
            .or(self.node_id)
    }

    /// Default identifiers for the node-ID `in_force` become the default identifiers for the node-ID in the file, which acts after a
    /// restart.
    pub fn number_from(&mut self, in_force: u8) {
        if let Some(own) = self.node() {
            self.renumber(in_force, own);
        }
    }

    /// Default identifiers for the node-ID in the file become the default identifiers for the node-ID `in_force` of a sensor.
    pub fn number_for(&mut self, in_force: u8) {
        if let Some(own) = self.node() {
            self.renumber(own, in_force);
        }
    }

    fn renumber(&mut self, from: u8, to: u8) {
        for (entry, raw) in &mut self.values {
            let Some(factory) = entry.factory.filter(|_| entry.node_relative) else {
                continue;
            };
            let default = |node: u8| (factory & IDENTIFIER) + u32::from(node);
            if *raw & IDENTIFIER == default(from) {
                *raw = *raw & !IDENTIFIER | default(to);
            }
        }
    }

    /// The scale of an entry at the resolution of this file.
    pub fn scale_of(&self, entry: &Entry) -> Scale {
        let resolution = self.sheet.product.guide.resolution;
        let own = resolution
            .filter(|_| self.sheet.follows_resolution(entry))
            .and_then(|resolution| {
                let wanted = Origin::Parameter(resolution.parameter);
                self.values.iter().find(|(own, _)| own.origin == wanted)
            });
        own.map_or(entry.scale.clone(), |(own, raw)| own.scale.times(*raw))
    }

    /// The text of a value.
    pub fn text_of(&self, entry: &Entry, raw: u32) -> String {
        let scaled = Entry {
            scale: self.scale_of(entry),
            ..entry.clone()
        };
        scaled.text(raw)
    }

    /// The value of an entry as a document.
    pub fn json_of(&self, entry: &Entry, raw: u32) -> serde_json::Value {
        let scaled = Entry {
            scale: self.scale_of(entry),
            ..entry.clone()
        };
        scaled.json(raw)
    }

    /// The file, with the parameters in the order of the sheet.
    pub fn text(&self) -> String {
        let quoted = |text: &str| Value::String(text.to_owned()).to_string();
        let mut text = HEADING.to_owned();
        text.push_str("[sensor]\n");
        let mut line = |name: &str, value: String| text.push_str(&format!("{name} = {value}\n"));
        line("product", quoted(self.sheet.product.name));
        line("maker", quoted(self.sheet.product.maker));
        if let Some(article) = &self.article {
            line("article", quoted(article));
        }
        if let Some(serial) = self.serial {
            line("serial", serial.to_string());
        }
        if let Some(firmware) = &self.firmware {
            line("firmware", quoted(firmware));
        }
        if let Some(node) = self.node_id {
            line("node-id", node.to_string());
        }
        if let Some(label) = &self.label {
            line("label", quoted(label));
        }
        text.push_str(&texts::section("texts", "", &self.texts));
        text.push_str(&texts::section("taken", texts::TAKEN, &self.taken));
        text.push_str("\n[parameters]\n");
        for entry in self.sheet.settings() {
            if let Some((_, raw)) = self.values.iter().find(|(own, _)| own.name == entry.name) {
                text.push_str(&format!(
                    "{} = {}\n",
                    entry.name,
                    quoted(&self.text_of(entry, *raw))
                ));
            }
        }
        text.push_str(&texts::left_out(&self.sheet));
        text
    }

    /// Writes the file. A file that exists stays as it is until the new one is complete.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn write(&self, path: &Path) -> Result<(), Error> {
        write_file(path, &self.text())
    }
}

/// The product and the serial number of the sensor in the text of a file.
pub fn sensor_in(text: &str) -> Option<(String, Option<u32>)> {
    let table: Table = text.parse().ok()?;
    let sensor = table.get("sensor")?;
    let serial = sensor.get("serial").and_then(Value::as_integer);
    let serial = serial.and_then(|serial| u32::try_from(serial).ok());
    Some((sensor.get("product")?.as_str()?.to_owned(), serial))
}

#[cfg(test)]
mod tests;
