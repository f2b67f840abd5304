//! The sensors that a bridge has had so far, in a file of its folder: a sensor that is missing at the next start is told to be offline, also
//! if the program could not tell it at its end.

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
        })
    }

    /// The topics.
    pub fn topics(&self) -> impl Iterator<Item = &String> {
        self.topics.iter()
    }

    /// Adds a topic.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn add(&mut self, topic: String) -> Result<(), Error> {
        if !self.topics.insert(topic) {
            return Ok(());
        }
        let text: String = self.topics.iter().flat_map(|own| [own, "\n"]).collect();
        let new = self.path.with_extension("new");
        let written = fs::write(&new, text).and_then(|()| fs::rename(&new, &self.path));
        written.map_err(|error| failed(&self.path, &error))
    }
}

fn failed(path: &Path, error: &io::Error) -> Error {
    FileError::FolderUnwritten(path.display().to_string(), error.to_string()).into()
}
