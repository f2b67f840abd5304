//! The names that the user gives to sensors. They are in a file of this computer, by maker and serial number:
//!
//! ```toml
//! [GEMAC]
//! 4711 = "boom left"
//! ```

use crate::backup::{Unread, read_text, write_file};
use crate::error::{Error, FileError, RequestError};
use crate::identify::Found;
use etcetera::{BaseStrategy, choose_base_strategy};
use std::path::{Path, PathBuf};
use toml::{Table, Value};

/// The first line of the file.
const HEADING: &str =
    "# Names of sensors by maker and serial number, written by `plumbline label`.\n";

/// The name of the file.
const FILE: &str = "labels.toml";

/// The name of the folder in the configuration of the user.
const FOLDER: &str = "plumbline";

/// The longest name, in characters.
const LONGEST: usize = 60;

/// The folder for the settings of the user; None: this computer has none.
pub(crate) fn folder(wanted: Option<&Path>) -> Option<PathBuf> {
    let own = || {
        let folders = choose_base_strategy().ok()?;
        Some(folders.config_dir().join(FOLDER))
    };
    wanted.map(Path::to_owned).or_else(own)
}

/// The names that users have given to sensors.
#[derive(Clone, Debug, Default)]
pub struct Labels {
    /// The file; None: this computer has no folder for it.
    path: Option<PathBuf>,
    makers: Table,
}

impl Labels {
    /// Reads the file in a folder, or in the folder of the user. A file that does not exist has no names.
    ///
    /// # Errors
    /// The file cannot be read, or is not one of names.
    pub fn open(folder: Option<&Path>) -> Result<Self, Error> {
        let Some(path) = self::folder(folder) else {
            return Ok(Self::default());
        };
        let path = path.join(FILE);
        let bad = |why: String| {
            let shown = path.display();
            FileError::LabelsUnread(shown.to_string(), why)
        };
        let makers = match read_text(&path) {
            Ok(text) => text
                .parse()
                .map_err(|error: toml::de::Error| bad(error.message().to_owned()))?,
            Err(Unread::Failed(error)) if error.kind() == std::io::ErrorKind::NotFound => {
                Table::new()
            }
            Err(unread) => return Err(bad(unread.to_string()).into()),
        };
        Ok(Self {
            path: Some(path),
            makers,
        })
    }

    /// The name of a sensor.
    pub fn name(&self, found: &Found) -> Option<String> {
        let (maker, serial) = key(found)?;
        let name = self.makers.get(&maker)?.get(&serial)?.as_str();
        name.and_then(|name| checked(name).ok())
    }

    /// Gives a sensor a name, or takes it away, and writes the file.
    ///
    /// # Errors
    /// The name is empty or too long, the sensor has no serial number, or the file cannot be written.
    pub fn set(&mut self, found: &Found, name: Option<&str>) -> Result<(), Error> {
        let Some((maker, serial)) = key(found) else {
            return Err(RequestError::NoSerial.into());
        };
        let name = name.map(checked).transpose()?;
        let names = self
            .makers
            .entry(maker.clone())
            .or_insert_with(|| Value::Table(Table::new()));
        let Value::Table(names) = names else {
            return Err(FileError::NoTable(maker).into());
        };
        match name {
            Some(name) => names.insert(serial, Value::String(name)),
            None => names.remove(&serial),
        };
        let Some(path) = &self.path else {
            return Err(FileError::NoFolder.into());
        };
        if let Some(folder) = path.parent() {
            std::fs::create_dir_all(folder).map_err(|error| {
                FileError::FolderUnmade(folder.display().to_string(), error.to_string())
            })?;
        }
        write_file(path, &format!("{HEADING}{}", self.makers))
    }

    /// The file with the names; None: there is no folder for it.
    pub fn path(&self) -> Option<&Path> {
        self.path.as_deref()
    }
}

/// The maker and the serial number. A foreign device has the name of its protocol.
fn key(found: &Found) -> Option<(String, String)> {
    let maker = found.products.first();
    let maker = maker.map_or(found.protocol(), |product| product.maker);
    Some((maker.to_owned(), found.serial?.to_string()))
}

/// A name that can be shown in one line.
pub(crate) fn checked(name: &str) -> Result<String, Error> {
    let name = name.trim();
    let is_shown = name.chars().all(|letter| !letter.is_control());
    if name.is_empty() || name.chars().count() > LONGEST || !is_shown {
        let start: String = name.chars().take(LONGEST + 1).collect();
        return Err(RequestError::BadLabel(start, LONGEST).into());
    }
    Ok(name.to_owned())
}
