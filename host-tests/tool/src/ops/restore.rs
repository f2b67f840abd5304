//! `restore`: the settings of a file in the sensor.

use super::diff::{differences, fitting, not_carried, take_resolution};
use super::report::Done;
use super::set::{acts_later, constrain, write};
use super::{address, adjust};
use crate::backup::Backup;
use crate::error::{Error, Kept, Why};
use crate::identify::Found;
use crate::master::Storing;
use crate::note::Note;
use crate::output::Terminal;
use crate::plan;
use crate::question::Change;
use crate::resolve;
use crate::session::Session;
use crate::sheet::Entry;
use serde_json::{Value, json};
use texts::Kind;

/// Writes the settings of a file that differ from the sensor, reads them back and stores them. Returns the document with them, and
/// the name of the sensor in the file, if all settings are restored.
pub(crate) fn restore(
    session: &mut Session,
    found: &Found,
    (backup, file): (Backup, String),
    only: &[String],
    terminal: &mut Terminal,
) -> Result<(Value, Option<String>), Error> {
    let mut backup = fitting(session, backup)?;
    if !only.is_empty() {
        let mut wanted = Vec::new();
        for name in only {
            wanted.extend(
                resolve::entries(&session.sheet, name)?
                    .into_iter()
                    .map(|entry| entry.name.clone()),
            );
        }
        let is_wanted = |entry: &Entry| wanted.contains(&entry.name);
        // The other values need not fit the resolution of the sensor.
        let sheet = session.sheet.clone();
        let is_read = |entry: &Entry| is_wanted(entry) || sheet.is_resolution(entry);
        backup.values.retain(|(entry, _)| is_read(entry));
        if !backup
            .values
            .iter()
            .any(|(entry, _)| session.sheet.is_resolution(entry) && is_wanted(entry))
        {
            take_resolution(session, &mut backup)?;
        }
        backup.values.retain(|(entry, _)| is_wanted(entry));
    }
    let found_differences = differences(session, &backup)?;
    if only.is_empty() {
        not_carried(session, found, &backup, terminal)?;
    }
    // Settings are restored also if nobody reads the output.
    let _ = match found_differences.0.is_empty() {
        true => terminal.line(format!("the sensor has the settings of {file} already")),
        false => {
            let mut lines = found_differences.lines().into_iter();
            lines.try_for_each(|line| terminal.line(line))
        }
    };
    let values = found_differences.values();
    if found.serial != backup.serial && !values.is_empty() {
        let shown = |serial: Option<u32>| serial.map_or("none".to_owned(), |own| own.to_string());
        let change = Change::Restore(shown(backup.serial), shown(found.serial));
        adjust::confirm(session, found, change, terminal)?;
    }
    constrain(session, &values)?;
    address::check(session, &values)?;
    let wanted = values.clone();
    session.written.clear();
    let written = write_and_store(session, &backup, values);
    let stored = written.map_err(|failure| interrupted(session, failure, &wanted))?;
    match stored {
        Some(stored) => terminal.line(stored.to_string())?,
        None => terminal.note(&Note::NoSaveCommand),
    }
    for one in &found_differences.0 {
        if acts_later(session.sheet.product, &one.entry) {
            terminal.note(&Note::AtRestart(one.entry.name.clone()));
        }
    }
    let label = backup.label.filter(|_| only.is_empty());
    Ok((json!(found_differences), label))
}

/// Writes values and stores them. None: the device has no command for that.
fn write_and_store(
    session: &mut Session,
    backup: &Backup,
    mut values: plan::Values,
) -> Result<Option<Done>, Error> {
    let sheet = session.sheet.clone();
    if values.iter().any(|(entry, _)| sheet.is_resolution(entry)) {
        // The sensor converts the other numbers to the new unit, so they are compared again.
        values.retain(|(entry, _)| sheet.is_resolution(entry));
        plan::write(session, &values)?;
        values = differences(session, backup)?.values();
    }
    write(session, &values)?;
    // An earlier restore can have been interrupted between the writes and this command, so it is sent in every case.
    match session.storing() {
        Storing::Unknown => Ok(None),
        _ => session.save().map(Some),
    }
}

/// The failure of a restore that did not end, with what is written by then and what to do.
fn interrupted(session: &Session, failure: Error, wanted: &plan::Values) -> Error {
    if !matches!(failure.kind(), Kind::Silent | Kind::Bus | Kind::Stopped) {
        return failure;
    }
    let is_written = |(entry, raw): &&(Entry, u32)| {
        let mut written = session.written.iter();
        written.any(|(name, own)| *name == entry.name && own == raw)
    };
    let (count, total) = (wanted.iter().filter(is_written).count(), wanted.len());
    let kept = match session.storing() {
        Storing::Itself => Kept::Written,
        _ => Kept::NotStored,
    };
    failure.explained(|failure| Why::Interrupted(failure, count, total, kept))
}
