//! What is not on the disk yet. It is written without the queue, which takes records meanwhile.

use std::fs::{self, File};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// The name of the file with the first number that is not acknowledged.
pub(super) const ACKNOWLEDGED: &str = "acknowledged";

/// Files with records, and the first number that is not acknowledged.
pub struct Unsynced {
    pub(super) files: Vec<File>,
    pub(super) folder: PathBuf,
    pub(super) acknowledged: u64,
    pub(super) is_new: bool,
}

impl Unsynced {
    /// Brings it to the disk. A file that fails does not keep the others from it.
    ///
    /// # Errors
    /// A file cannot be written.
    pub fn write(&self) -> io::Result<()> {
        let written = self.files.iter().map(File::sync_data);
        written.fold(Ok(()), io::Result::and)?;
        match self.is_new {
            true => keep(&self.folder, self.acknowledged),
            false => Ok(()),
        }
    }
}

/// Writes the first number that is not acknowledged.
fn keep(folder: &Path, acknowledged: u64) -> io::Result<()> {
    let new = folder.join("acknowledged.new");
    let mut file = File::create(&new)?;
    writeln!(file, "{acknowledged}")?;
    file.sync_all()?;
    fs::rename(new, folder.join(ACKNOWLEDGED))
}
