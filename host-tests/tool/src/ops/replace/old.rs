//! What is kept of the old sensor: the file of `backup` with three more sections. `restore` and `diff` take it too.
//!
//! ```toml
//! [identity]
//! vendor = 354
//!
//! [replies]
//! software-version = "3.44"
//!
//! [angles]
//! angle-x = { angle = 1.25, spread = 0.01 }
//! ```

use crate::backup::{Backup, read_text};
use crate::error::{Error, Fault, FileError};
use descriptors::unit::Sheet;
use plumbline::store::Unit;
use std::path::Path;
use toml::{Table, Value};

/// An angle at rest, in degrees.
#[derive(Clone, PartialEq, Debug)]
pub struct Measured {
    /// Its name.
    pub name: String,
    /// The mean.
    pub angle: f64,
    /// The spread in 3 s.
    pub spread: f64,
}

/// The old sensor.
#[derive(Clone, Debug)]
pub struct Old {
    /// Its settings.
    pub backup: Backup,
    /// Its identity, with the values that its product can have.
    pub identity: Sheet,
    /// The values that are no settings, by their names.
    pub replies: Vec<(String, String)>,
    /// Its angles at rest.
    pub angles: Vec<Measured>,
}

impl Old {
    /// The text of the file. `unit` is the identity.
    pub fn text(&self, unit: &Unit) -> String {
        let quoted = |text: &str| Value::String(text.to_owned()).to_string();
        let sheet = descriptors::unit::sheet(self.backup.sheet.product, unit);
        let is_line =
            |line: &&str| !line.starts_with(['#', '\n']) && !line.starts_with("product =");
        let mut text = self.backup.text() + "\n[identity]\n";
        for line in sheet.lines().filter(is_line) {
            text += &format!("{line}\n");
        }
        text += "\n[replies]\n";
        for (name, value) in &self.replies {
            text += &format!("{} = {}\n", quoted(name), quoted(value));
        }
        text += "\n[angles]\n";
        for Measured {
            name,
            angle,
            spread,
        } in &self.angles
        {
            text += &format!("{name} = {{ angle = {angle:?}, spread = {spread:?} }}\n");
        }
        text
    }

    /// Reads a file.
    ///
    /// # Errors
    /// The file cannot be read, or is not one of `replace read`.
    pub fn read(path: &Path) -> Result<Self, Error> {
        let shown = path.display().to_string();
        let backup = Backup::read(path).map_err(|failure| match failure {
            Error::File(FileError::BackupUnread(path, reason)) => {
                FileError::OldUnread(path, reason).into()
            }
            other => other,
        })?;
        let bad = |why: Fault| Error::from(FileError::Backup(shown.clone(), why));
        let text = read_text(path).unwrap_or_default();
        let table: Table = text.parse().unwrap_or_default();
        let section = |name: &str| {
            let section = table.get(name).and_then(Value::as_table);
            section.ok_or_else(|| bad(Fault::NoSection(name.to_owned())))
        };
        let identity = section("identity")?.to_string();
        let identity = Sheet::parse(&identity).map_err(|why| bad(why.into()))?;
        let mut replies = Vec::new();
        for (name, value) in section("replies")? {
            let text = value.as_str();
            let text = text.ok_or_else(|| bad(Fault::NoQuotes(name.clone())))?;
            replies.push((name.clone(), text.to_owned()));
        }
        let mut angles = Vec::new();
        for (name, value) in section("angles")? {
            let part = |key: &str| value.get(key).and_then(number);
            let (Some(angle), Some(spread)) = (part("angle"), part("spread")) else {
                return Err(bad(Fault::NoQuotes(name.clone())));
            };
            angles.push(Measured {
                name: name.clone(),
                angle,
                spread,
            });
        }
        Ok(Self {
            backup,
            identity,
            replies,
            angles,
        })
    }
}

fn number(value: &Value) -> Option<f64> {
    let integer = || value.as_integer().map(|number| number as f64);
    value
        .as_float()
        .or_else(integer)
        .filter(|own| own.is_finite())
}
