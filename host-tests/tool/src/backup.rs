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

use crate::failure::Failure;
use crate::identify::{Found, product};
use crate::number::Scale;
use crate::sheet::{Entry, Origin, Sheet};
use plumbline::model::catalog::Product;
use std::path::Path;
use toml::{Table, Value};

/// The longest file that is read, in bytes.
const LONGEST: u64 = 1 << 20;

/// The first line of a file.
const HEADING: &str = "# Settings of a CAN inclination sensor, written by plumbline. `plumbline restore` writes them to a sensor.\n";

/// The settings of a sensor.
#[derive(Clone, Debug)]
pub struct Backup {
    /// The sheet of the product.
    pub sheet: Sheet,
    /// The order number.
    pub article: Option<String>,
    /// The serial number.
    pub serial: Option<u32>,
    /// The version of the firmware.
    pub firmware: Option<String>,
    /// Texts that a tool can write, for example the programming key; for people, they are not restored.
    pub texts: Vec<(String, String)>,
    /// Entries with their raw numbers.
    pub values: Vec<(Entry, u32)>,
}

impl Backup {
    /// The settings of a sensor that has been identified.
    pub fn new(product: &'static Product, found: &Found) -> Self {
        Self {
            sheet: Sheet::of(product),
            article: found.article.clone(),
            serial: found.serial,
            firmware: found.firmware.clone(),
            texts: Vec::new(),
            values: Vec::new(),
        }
    }

    /// Reads a file.
    ///
    /// # Errors
    /// The file cannot be read, is no backup, or has a name or value that the product does not have.
    pub fn read(path: &Path) -> Result<Self, Failure> {
        let shown = path.display();
        let unreadable = |error: std::io::Error| {
            Failure::bus(
                "no-file",
                format!("cannot read {shown} ({error}): `plumbline backup` writes such a file"),
            )
        };
        let length = std::fs::metadata(path).map_err(unreadable)?.len();
        if length > LONGEST {
            return Err(bad(path, "it is too long"));
        }
        let text = std::fs::read_to_string(path).map_err(unreadable)?;
        Self::parse(&text).map_err(|why| bad(path, &why))
    }

    fn parse(text: &str) -> Result<Self, String> {
        let table: Table = text
            .parse()
            .map_err(|error: toml::de::Error| error.message().to_owned())?;
        let section = |name: &str| {
            let section = table.get(name).and_then(Value::as_table);
            section.ok_or_else(|| format!("it has no section [{name}]"))
        };
        let (sensor, parameters) = (section("sensor")?, section("parameters")?);
        let text = |name: &str| sensor.get(name).and_then(Value::as_str).map(str::to_owned);
        let name = text("product").ok_or("it names no product")?;
        let product = product(&name).map_err(|failure| failure.message)?;
        let serial = sensor.get("serial").and_then(Value::as_integer);
        let mut backup = Self {
            sheet: Sheet::of(product),
            article: text("article"),
            serial: serial.and_then(|serial| u32::try_from(serial).ok()),
            firmware: text("firmware"),
            texts: Vec::new(),
            values: Vec::new(),
        };
        // The resolution first: it is the unit of others.
        let mut rows: Vec<(&String, &Value)> = parameters.iter().collect();
        let resolution = product
            .guide
            .resolution
            .map(|resolution| Origin::Parameter(resolution.parameter));
        let is_resolution = |name: &str| {
            let entry = backup.sheet.entries.iter().find(|entry| entry.name == name);
            entry.is_some_and(|entry| Some(entry.origin) == resolution)
        };
        rows.sort_by_key(|(name, _)| !is_resolution(name));
        for (name, value) in rows {
            let text = match value {
                Value::String(text) => text.clone(),
                Value::Integer(number) => number.to_string(),
                Value::Float(number) => number.to_string(),
                _ => return Err(format!("{name} has no value in quotes")),
            };
            backup.set(name, &text)?;
        }
        Ok(backup)
    }

    /// Sets a value from its text.
    ///
    /// # Errors
    /// The product has no such setting, or the value is not permitted.
    pub fn set(&mut self, name: &str, text: &str) -> Result<(), String> {
        let entry = self
            .sheet
            .settings()
            .find(|entry| entry.name == name)
            .cloned();
        let entry =
            entry.ok_or_else(|| format!("{} has no setting {name}", self.sheet.product.name))?;
        let scale = self.scale_of(&entry);
        let scaled = Entry {
            scale: scale.clone(),
            ..entry.clone()
        };
        let raw = scaled
            .parse(text)
            .map_err(|why| format!("{name} = {text:?}: {why}"))?;
        entry.check(raw, &scale)?;
        match self.values.iter_mut().find(|(own, _)| own.name == name) {
            Some((_, own)) => *own = raw,
            None => self.values.push((entry, raw)),
        }
        Ok(())
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
        for (name, value) in &self.texts {
            line(name, quoted(value));
        }
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
        text
    }

    /// Writes the file.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn write(&self, path: &Path) -> Result<(), Failure> {
        let written = std::fs::write(path, self.text());
        written.map_err(|error| {
            Failure::bus(
                "no-file",
                format!("cannot write {} ({error})", path.display()),
            )
        })
    }
}

fn bad(path: &Path, why: &str) -> Failure {
    Failure::usage(
        "bad-file",
        format!(
            "{} is not valid: {why}; nothing was written",
            path.display()
        ),
    )
}

#[cfg(test)]
mod tests;
