//! What a command prints, and what it asks.

use crate::error::{Error, FileError};
use crate::link::stopped;
use crate::note::Step;
use crate::ops::Report;
use crate::question::{Name, Question};
use serde_json::Value;
use std::io::{ErrorKind, Write};
use std::rc::Rc;
use texts::Text;

/// The progress of a command.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Progress<'a> {
    /// The steps that are done.
    pub done: usize,
    /// The number of all steps.
    pub total: usize,
    /// What is done.
    pub step: &'a Step,
}

/// A bar that shows the progress of a command.
pub trait Bar {
    /// Shows the bar in this state.
    fn show(&mut self, progress: Progress);

    /// Removes it, so that the terminal can show lines and questions.
    fn hide(&mut self);

    /// Takes what a scan has found until now.
    fn found(&mut self, _rows: &Value) {}
}

/// Where notes go: a terminal, or the page.
pub trait Notes {
    /// Shows a note.
    fn note(&mut self, text: &dyn Text);
}

impl<W: Write> Notes for W {
    /// A closed standard error is no failure.
    fn note(&mut self, text: &dyn Text) {
        let _ = writeln!(self, "{text}");
    }
}

/// The terminal of a command: its output, questions and the end by Ctrl-C.
pub struct Terminal<'a> {
    /// Prints documents instead of text.
    pub json: bool,
    /// Results, on standard output.
    pub out: &'a mut dyn Write,
    /// Notes for people, on standard error.
    pub notes: &'a mut dyn Notes,
    /// Asks a question that is not answered yet; true means yes.
    pub confirm: &'a mut dyn FnMut(&Question) -> bool,
    /// The questions that the user has answered with yes before.
    pub yes: &'a [Name],
    /// True when Ctrl-C was pressed.
    pub stopped: Rc<dyn Fn() -> bool>,
    /// The progress bar; None: a line for each important step.
    pub bar: Option<Box<dyn Bar>>,
}

impl Terminal<'_> {
    /// Asks a question; true means yes.
    ///
    /// # Errors
    /// The user has pressed Ctrl-C instead of an answer.
    pub fn ask(&mut self, question: &Question) -> Result<bool, Error> {
        if question.name().is_some_and(|name| name.is_in(self.yes)) {
            return Ok(true);
        }
        self.hide();
        let is_yes = (self.confirm)(question);
        match !is_yes && (self.stopped)() {
            true => Err(stopped()),
            false => Ok(is_yes),
        }
    }

    /// Prints a line of text; nothing with `--json`.
    ///
    /// # Errors
    /// The output is closed.
    pub fn line(&mut self, text: impl AsRef<str>) -> Result<(), Error> {
        if self.json {
            return Ok(());
        }
        self.hide();
        writeln!(self.out, "{}", text.as_ref()).map_err(closed)
    }

    /// Shows the progress of a command. Without a progress bar it prints `line`, if there is one.
    pub fn progress(&mut self, progress: Progress, line: Option<&Step>) {
        match (&mut self.bar, line) {
            (Some(bar), _) => bar.show(progress),
            (None, Some(line)) => self.note(line),
            (None, None) => {}
        }
    }

    /// Takes the progress bar away.
    pub fn hide(&mut self) {
        if let Some(bar) = &mut self.bar {
            bar.hide();
        }
    }

    /// Shows what a scan has found until now.
    pub fn found(&mut self, rows: &Value) {
        if let Some(bar) = &mut self.bar {
            bar.found(rows);
        }
    }

    /// Prints a document on one line; nothing without `--json`.
    ///
    /// # Errors
    /// The output is closed.
    pub fn document(&mut self, document: &Value) -> Result<(), Error> {
        if !self.json {
            return Ok(());
        }
        writeln!(self.out, "{document}").map_err(closed)
    }

    /// Prints what an operation has done, as text or as document.
    ///
    /// # Errors
    /// The output is closed.
    pub fn report(&mut self, report: &Report) -> Result<(), Error> {
        if self.json {
            let document = serde_json::to_value(report);
            return self.document(&document.unwrap_or_default());
        }
        report.lines().iter().try_for_each(|line| self.line(line))
    }

    /// Prints a note for people; never in a document.
    pub fn note(&mut self, text: &dyn Text) {
        self.hide();
        self.notes.note(text);
    }
}

/// The failure of an output that cannot be written. If nobody reads it any more, the program ends without a message.
pub(crate) fn closed(error: std::io::Error) -> Error {
    match error.kind() {
        ErrorKind::BrokenPipe => FileError::Closed(error.to_string()).into(),
        _ => FileError::NoOutput(error.to_string()).into(),
    }
}
