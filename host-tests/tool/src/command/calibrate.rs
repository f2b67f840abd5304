//! `calibrate`: the measurement on the terminal.

use crate::calibrate::host::Asks;
use crate::calibrate::log::Source;
use crate::error::{CalibrationError, Error};
use crate::ops::calibrate::{self, Unit};
use crate::output::Terminal;
use serde_json::json;
use std::path::Path;

/// Measures what is missing, if there is a log, computes the calibration, and prints it.
pub(super) fn calibrate(
    path: &Path,
    log: &[String],
    may_measure: bool,
    unit: Unit,
    terminal: &mut Terminal,
) -> Result<(), Error> {
    if !log.is_empty() && !may_measure {
        return Err(CalibrationError::NeedsAnswers.into());
    }
    let source = (!log.is_empty()).then(|| Source::Command(log.to_vec()));
    let done = calibrate::run(path, source.as_ref(), unit, &mut Asks::new(terminal))?;
    terminal.line(done.line())?;
    terminal.note(&done.next);
    terminal.document(&json!(done))
}
