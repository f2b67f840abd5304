//! `diff`: the settings of a file that differ from the sensor.

use crate::backup::Backup;
use crate::error::{Differing, Error, SensorError};
use crate::identify::Found;
use crate::ops::diff;
use crate::output::Terminal;
use crate::session::Session;
use serde_json::json;

/// Prints them. With `exit_code` a difference is a failure.
pub(super) fn diff(
    session: &mut Session,
    found: &Found,
    (backup, file): (Backup, String),
    exit_code: bool,
    terminal: &mut Terminal,
) -> Result<(), Error> {
    let differences = diff::diff(session, found, backup, terminal)?;
    if differences.0.is_empty() {
        terminal.line(format!("the sensor has the settings of {file}"))?;
    }
    for line in differences.lines() {
        terminal.line(line)?;
    }
    terminal.document(&json!(differences))?;
    match differences.0.len() {
        count @ 1.. if exit_code => {
            let different = SensorError::Different(Differing::of(count), file);
            Err(Error::from(different).after_document())
        }
        _ => Ok(()),
    }
}
