//! The files that commands write.

use crate::error::{Error, FileError};
use crate::output::Terminal;
use crate::question::Question;
use std::io;
use std::path::Path;

/// A file that exists is replaced only after a yes.
pub(super) fn replaced(path: &Path, terminal: &mut Terminal) -> Result<(), Error> {
    if path.is_file() && !terminal.ask(&Question::Overwrite(path.display().to_string()))? {
        return Err(FileError::Exists(path.display().to_string()).into());
    }
    Ok(())
}

/// Refuses a command that would write a file that it also reads, or that it writes twice: no answer permits that.
pub(super) fn distinct(paths: &[&Path]) -> Result<(), Error> {
    let absolute = |path: &Path| path.canonicalize().or_else(|_| std::path::absolute(path));
    let known: Vec<_> = paths.iter().map(|path| absolute(path).ok()).collect();
    for (place, path) in paths.iter().enumerate() {
        if known[place].is_some() && known[..place].contains(&known[place]) {
            return Err(FileError::Twice(path.display().to_string()).into());
        }
    }
    Ok(())
}

/// Why a file or standard output cannot be written.
pub(super) fn unwritten(path: &Path, error: &io::Error) -> Error {
    match error.kind() {
        io::ErrorKind::BrokenPipe => FileError::Closed(error.to_string()).into(),
        _ => FileError::OutputUnwritten(path.display().to_string(), error.to_string()).into(),
    }
}
