//! Writes a file. An existing file is never partly overwritten.

use crate::failure::Failure;
use std::fs::File;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// Writes a file. A file that exists stays as it is until the new one is complete, and keeps its permissions. Behind a symbolic link the
/// file is written, and the link stays.
///
/// # Errors
/// The file cannot be written.
pub fn write_file(path: &Path, text: &str) -> Result<(), Failure> {
    let target = path.canonicalize().unwrap_or_else(|_| path.to_owned());
    // A special file cannot be replaced.
    let is_special = target.exists() && !target.is_file();
    let written = match is_special {
        true => std::fs::write(&target, text),
        false => replace(&target, text),
    };
    written.map_err(|error| {
        Failure::bus(
            "no-file",
            format!("cannot write {} ({error})", path.display()),
        )
    })
}

/// Writes a new file beside the old one, and gives it the name of the old one.
fn replace(path: &Path, text: &str) -> io::Result<()> {
    let (part, mut file) = match part_of(path) {
        // A file can be writable in a folder that is not.
        Err(error) if error.kind() == io::ErrorKind::PermissionDenied && path.exists() => {
            return std::fs::write(path, text);
        }
        part => part?,
    };
    let written = file.write_all(text.as_bytes()).and_then(|()| {
        if let Ok(old) = std::fs::metadata(path) {
            file.set_permissions(old.permissions())?;
        }
        std::fs::rename(&part, path)
    });
    if written.is_err() {
        let _ = std::fs::remove_file(&part);
    }
    written
}

/// A new file beside this one.
fn part_of(path: &Path) -> io::Result<(PathBuf, File)> {
    const NAMES: u32 = 100;
    let mut last = io::Error::from(io::ErrorKind::AlreadyExists);
    for number in 0..NAMES {
        let mut name = path.file_name().unwrap_or_default().to_owned();
        name.push(format!(".part{number}"));
        let part = path.with_file_name(name);
        match File::create_new(&part) {
            Ok(file) => return Ok((part, file)),
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists => last = error,
            Err(error) => return Err(error),
        }
    }
    Err(last)
}
