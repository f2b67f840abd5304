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

/// Why a file or standard output cannot be written.
pub(super) fn unwritten(path: &Path, error: &io::Error) -> Error {
    match error.kind() {
        io::ErrorKind::BrokenPipe => FileError::Closed(error.to_string()).into(),
        _ => FileError::OutputUnwritten(path.display().to_string(), error.to_string()).into(),
    }
}
