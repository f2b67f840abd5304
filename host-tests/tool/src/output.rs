//! What a command prints, and what it asks.

use crate::failure::Failure;
use serde_json::Value;
use std::io::Write;

/// The terminal of a command: its output, questions and the end by Ctrl-C.
pub struct Terminal<'a> {
    /// Prints documents instead of text.
    pub json: bool,
    /// Standard output.
    pub out: &'a mut dyn Write,
    /// Notes for people, on standard error.
    pub notes: &'a mut dyn Write,
    /// Asks a question; true means yes.
    pub confirm: &'a mut dyn FnMut(&str) -> bool,
    /// True when Ctrl-C was pressed.
    pub stopped: &'a dyn Fn() -> bool,
}

impl Terminal<'_> {
    /// Prints a line of text; nothing with `--json`.
    ///
    /// # Errors
    /// The output is closed.
    pub fn line(&mut self, text: impl AsRef<str>) -> Result<(), Failure> {
        if self.json {
            return Ok(());
        }
        writeln!(self.out, "{}", text.as_ref()).map_err(closed)
    }

    /// Prints a document on one line; nothing without `--json`.
    ///
    /// # Errors
    /// The output is closed.
    pub fn document(&mut self, document: &Value) -> Result<(), Failure> {
        if !self.json {
            return Ok(());
        }
        writeln!(self.out, "{document}").map_err(closed)
    }

    /// Prints a note for people; never in a document. It is no failure if nobody can read it.
    pub fn note(&mut self, text: impl AsRef<str>) {
        let _ = writeln!(self.notes, "{}", text.as_ref());
    }
}

fn closed(error: std::io::Error) -> Failure {
    Failure::bus("output-closed", format!("cannot write the output: {error}"))
}
