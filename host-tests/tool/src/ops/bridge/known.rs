//! The sensors that a bridge has had so far, in a file of its folder: a sensor that is missing at the next start is told to be offline, also
//! if the program could not tell it at its end.

use super::queue::is_full;
use crate::error::{Error, FileError};
use std::collections::BTreeSet;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

/// The name of the file: a topic in each line.
const NAME: &str = "sensors";

/// The topics with the availability of these sensors.
pub struct Known {
    path: PathBuf,
    topics: BTreeSet<String>,
    /// The file has all of them.
    is_written: bool,
}

impl Known {
    /// Those of a folder.
    ///
    /// # Errors
    /// The file exists and cannot be read.
    pub fn open(folder: &Path) -> Result<Self, Error> {
        let path = folder.join(NAME);
        let text = match fs::read_to_string(&path) {
            Err(error) if error.kind() == io::ErrorKind::NotFound => String::new(),
            text => text.map_err(|error| failed(&path, &error))?,
        };
        Ok(Self {
            path,
            topics: text.lines().map(str::to_owned).collect(),
            is_written: true,
        })
    }

    /// The topics.
    pub fn topics(&self) -> impl Iterator<Item = &String> {
        self.topics.iter()
    }

    /// Adds a topic. On a full disk [`sync`](Self::sync) writes it later.
    ///
    /// # Errors
    /// The file cannot be written, for another reason.
    pub fn add(&mut self, topic: String) -> Result<(), Error> {
        self.is_written &= !self.topics.insert(topic);
        match self.sync() {
            Err(error) if !is_full(&error) => Err(failed(&self.path, &error)),
            _ => Ok(()),
        }
    }

    /// Writes what the file does not have yet.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn sync(&mut self) -> io::Result<()> {
        if self.is_written {
            return Ok(());
        }
        let topics = self.topics.iter();
        let text: String = topics.flat_map(|own| [own.as_str(), "\n"]).collect();
        let new = self.path.with_extension("new");
        fs::write(&new, text)?;
        fs::rename(&new, &self.path)?;
        self.is_written = true;
        Ok(())
    }
}

fn failed(path: &Path, error: &io::Error) -> Error {
    FileError::FolderUnwritten(path.display().to_string(), error.to_string()).into()
}
