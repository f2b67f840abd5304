//! `record`: the samples as CSV. The first sample replaces an earlier recording; without one the file stays as it was.

use super::watch::tell;
use super::written::unwritten;
use crate::counted::Samples;
use crate::error::Error;
use crate::ops::watch::{Request, watch};
use crate::output::Terminal;
use crate::session::Session;
use std::fs::{self, File, OpenOptions};
use std::io::{self, BufWriter, Write};
use std::path::Path;

/// A file that is written from the first row on.
struct Csv<'a> {
    path: &'a Path,
    file: BufWriter<File>,
    /// There was no such file before.
    is_new: bool,
    has_rows: bool,
}

impl<'a> Csv<'a> {
    /// Opens the file, and leaves its content as it is.
    ///
    /// # Errors
    /// The file cannot be written.
    fn open(path: &'a Path) -> Result<Self, Error> {
        let is_new = !path.exists();
        let mut options = OpenOptions::new();
        let file = options.write(true).create(true).truncate(false).open(path);
        Ok(Self {
            path,
            file: BufWriter::new(file.map_err(|error| unwritten(path, &error))?),
            is_new,
            has_rows: false,
        })
    }

    /// Adds a row, and before the first one the heading.
    ///
    /// # Errors
    /// The file cannot be written.
    fn row(&mut self, heading: impl Fn() -> String, row: &str) -> Result<(), Error> {
        let written = self.begin(heading);
        let written = written.and_then(|()| writeln!(self.file, "{row}"));
        written.map_err(|error| unwritten(self.path, &error))
    }

    fn begin(&mut self, heading: impl Fn() -> String) -> io::Result<()> {
        if self.has_rows {
            return Ok(());
        }
        self.has_rows = true;
        let file = self.file.get_ref();
        // A pipe has no length.
        if file.metadata()?.is_file() {
            file.set_len(0)?;
        }
        writeln!(self.file, "{}", heading())
    }

    /// Writes what is not yet in the file.
    ///
    /// # Errors
    /// The file cannot be written.
    fn flush(&mut self) -> Result<(), Error> {
        let flushed = self.file.flush();
        flushed.map_err(|error| unwritten(self.path, &error))
    }
}

impl Drop for Csv<'_> {
    fn drop(&mut self) {
        if self.is_new && !self.has_rows {
            // An empty file that stays does no harm.
            let _ = fs::remove_file(self.path);
        }
    }
}

/// Records the samples as CSV.
///
/// # Errors
/// The file cannot be written, a name is wrong, or a request of the session fails.
pub(super) fn record(
    session: &mut Session,
    wanted: &Request,
    path: &Path,
    terminal: &mut Terminal,
) -> Result<(), Error> {
    let mut csv = Csv::open(path)?;
    let watched = watch(
        session,
        wanted,
        terminal,
        &mut |terminal, session, sampler, sample| {
            terminal.document(&sampler.json(session, sample))?;
            csv.row(|| sampler.heading(), &sampler.row(sample))
        },
    )?;
    csv.flush()?;
    let samples = Samples(watched.samples);
    terminal.line(format!("recorded {samples} in {}", path.display()))?;
    tell(&watched, terminal)
}
