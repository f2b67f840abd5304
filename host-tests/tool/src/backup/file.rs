//! Reads a regular file up to a length, and writes a file. An existing file is never partly overwritten.

use crate::failure::Failure;
use std::fmt::{self, Display, Formatter};
use std::fs::File;
use std::io::{self, Read, Write};
use std::path::Path;

/// The longest text that the tool has written by itself, in bytes.
pub const LONGEST_TEXT: u64 = 1 << 20;

/// Why a file was not read.
#[derive(Debug)]
pub enum Unread {
    /// It cannot be opened or read.
    Failed(io::Error),
    /// What it is not, or why it is not taken.
    Unfit(&'static str),
}

impl From<io::Error> for Unread {
    fn from(error: io::Error) -> Self {
        Self::Failed(error)
    }
}

impl Display for Unread {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        match self {
            Self::Failed(error) => error.fmt(f),
            Self::Unfit(why) => f.write_str(why),
        }
    }
}

/// Reads a regular file of at most this number of bytes. A device can have no end, and the opening of a pipe can wait without end, so both
/// are refused before they are opened.
///
/// # Errors
/// The file cannot be read, is not a regular file, or is longer.
pub fn read_file(path: &Path, longest: u64) -> Result<Vec<u8>, Unread> {
    const NOT_REGULAR: Unread = Unread::Unfit("it is not a regular file");
    if !std::fs::metadata(path)?.is_file() {
        return Err(NOT_REGULAR);
    }
    let file = File::open(path)?;
    if !file.metadata()?.is_file() {
        return Err(NOT_REGULAR);
    }
    let mut bytes = Vec::new();
    // The length of a file in /proc is 0, and a file can grow meanwhile.
    file.take(longest + 1).read_to_end(&mut bytes)?;
    match bytes.len() as u64 > longest {
        true => Err(Unread::Unfit("it is too long")),
        false => Ok(bytes),
    }
}

/// Reads a regular file with a text of at most 1 MiB.
///
/// # Errors
/// See [`read_file`]; or it is no text.
pub fn read_text(path: &Path) -> Result<String, Unread> {
    let bytes = read_file(path, LONGEST_TEXT)?;
    String::from_utf8(bytes).map_err(|_| Unread::Unfit("it is not a text in UTF-8"))
}

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
            format!(
                "cannot write {} ({error}): choose another file or folder",
                path.display()
            ),
        )
    })
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
