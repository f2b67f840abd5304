//! The sensors that a bridge has had so far, in a file of its folder: a sensor that is missing at the next start is told to be offline, also
//! if the program could not tell it at its end.

use super::queue::is_full;
use crate::error::{Error, FileError};
use std::collections::BTreeMap;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

/// The name of the file: a topic in each line, a tabulator, and the maker of the sensor.
const NAME: &str = "sensors";

/// The topics with the availability of these sensors.
pub struct Known {
    path: PathBuf,
    /// The makers by the topics. An older file does not say them.
    makers: BTreeMap<String, String>,
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
            makers: text
                .lines()
                .map(|line| line.split_once('\t').unwrap_or((line, "")))
                .map(|(topic, maker)| (topic.to_owned(), maker.to_owned()))
                .collect(),
            is_written: true,
        })
    }

    /// The topics with the makers of their sensors.
    pub fn makers(&self) -> &BTreeMap<String, String> {
        &self.makers
    }

    /// Adds the topic of a sensor of this maker. On a full disk [`sync`](Self::sync) writes it later.
    ///
    /// # Errors
    /// The file cannot be written, for another reason.
    pub fn add(&mut self, topic: String, maker: &str) -> Result<(), Error> {
        let before = self.makers.insert(topic, maker.to_owned());
        self.is_written &= before.as_deref() == Some(maker);
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
        let makers = self.makers.iter();
        let text: String = makers
            .map(|(topic, maker)| format!("{topic}\t{maker}\n"))
            .collect();
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
