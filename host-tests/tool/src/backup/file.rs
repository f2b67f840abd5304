//! Writes a file. An existing file is never partly overwritten.

use crate::error::{Error, FileError};
use std::io::{self, Write};
use std::path::Path;

/// Writes a file. A file that exists stays as it is until the new one is complete, and keeps its permissions. Behind a symbolic link the
/// file is written, and the link stays.
///
/// # Errors
/// The file cannot be written.
pub fn write_file(path: &Path, text: &str) -> Result<(), Error> {
    let target = path.canonicalize().unwrap_or_else(|_| path.to_owned());
    // A special file cannot be replaced.
    let is_special = target.exists() && !target.is_file();
    let written = match is_special {
        true => std::fs::write(&target, text),
        false => replace(&target, text),
    };
    written
        .map_err(|error| FileError::Unwritten(path.display().to_string(), error.to_string()).into())
}

/// Writes a new file beside the old one, and gives it the name of the old one.
fn replace(path: &Path, text: &str) -> io::Result<()> {
    let folder = path
        .parent()
        .filter(|folder| !folder.as_os_str().is_empty());
    let mut part = match new_file().tempfile_in(folder.unwrap_or(Path::new("."))) {
        // A file can be writable in a folder that is not.
        Err(error) if error.kind() == io::ErrorKind::PermissionDenied && path.exists() => {
            return std::fs::write(path, text);
        }
        part => part?,
    };
    part.write_all(text.as_bytes())?;
    if let Ok(old) = std::fs::metadata(path) {
        part.as_file().set_permissions(old.permissions())?;
    }
    part.persist(path)?;
    Ok(())
}

/// A new file with the usual permissions; by itself, only its owner could read a temporary file.
fn new_file() -> tempfile::Builder<'static, 'static> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(".plumbline-");
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        builder.permissions(std::fs::Permissions::from_mode(0o666));
    }
    builder
}
