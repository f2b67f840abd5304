//! `restore` and `diff`: the settings of a file and the settings of the sensor.

use super::backup::{names, taken};
use super::report::Done;
use super::set::{acts_later, constrain, write};
use super::{address, adjust};
use crate::backup::Backup;
use crate::error::{Differing, Error, FileError, Kept, NumberError, SensorError, Why};
use crate::identify::Found;
use crate::master::Storing;
use crate::note::Note;
use crate::output::Terminal;
use crate::plan;
use crate::question::Change;
use crate::resolve;
use crate::session::Session;
use crate::sheet::Entry;
use serde_json::{Map, Value, json};
use texts::Kind;

/// A setting whose value in the file differs.
struct Difference {
    entry: Entry,
    sensor: (String, Value),
    file: (String, Value),
    raw: u32,
}

/// The settings of a file that differ from the sensor, compared as values with their unit.
fn differences(session: &mut Session, backup: &Backup) -> Result<Vec<Difference>, Error> {
    let mut differences = Vec::new();
    for (entry, raw) in &backup.values {
        let at = |scale| Entry {
            scale,
            ..entry.clone()
        };
        let read = session.read(entry)?;
        let (sensor, file) = (at(session.scale_of(entry)?), at(backup.scale_of(entry)));
        let (sensor, file) = (
            (sensor.text(read), sensor.json(read)),
            (file.text(*raw), file.json(*raw)),
        );
        if sensor.1["value"] != file.1["value"] {
            differences.push(Difference {
                entry: entry.clone(),
                sensor,
                file,
                raw: *raw,
            });
        }
    }
    Ok(differences)
}

/// Gives a file the resolution of the sensor. The values in its unit stay the same, so their raw numbers change.
fn take_resolution(session: &mut Session, backup: &mut Backup) -> Result<(), Error> {
    let guide = &session.sheet.product.guide;
    let Some(resolution) = &guide.resolution else {
        return Ok(());
    };
    let entry = session.entry(resolution.parameter)?;
    let text = entry.text(session.read(&entry)?);
    let set = backup.set(&entry.name, &text);
    set.map_err(|why| NumberError::Resolution(text, Box::new(why)).into())
}

/// The settings of a file of this product, with the default identifiers of the node-ID that the sensor has now. A file without resolution
/// has the resolution of the sensor.
fn fitting(session: &mut Session, mut backup: Backup) -> Result<Backup, Error> {
    let (own, wanted) = (session.sheet.product, backup.sheet.product);
    if own.name != wanted.name {
        return Err(FileError::OtherProduct(wanted.name, own.name).into());
    }
    if let Some(node) = session.target.node_id() {
        backup.number_for(node);
    }
    if !backup
        .values
        .iter()
        .any(|(entry, _)| session.sheet.is_resolution(entry))
    {
        take_resolution(session, &mut backup)?;
    }
    Ok(backup)
}

fn show(differences: &[Difference], terminal: &mut Terminal) -> Result<(), Error> {
    let names = differences.iter().map(|one| one.entry.name.len());
    let width = names.max().unwrap_or(0);
    for Difference {
        entry,
        sensor,
        file,
        ..
    } in differences
    {
        terminal.line(format!(
            "{:width$}  sensor: {}  file: {}",
            entry.name, sensor.0, file.0
        ))?;
    }
    Ok(())
}

fn document(differences: &[Difference]) -> Value {
    let rows = differences.iter().map(|one| {
        (
            one.entry.name.clone(),
            json!({"sensor": one.sensor.1, "file": one.file.1}),
        )
    });
    Value::Object(rows.collect::<Map<_, _>>())
}

/// The number of settings of a file of this product that differ from the sensor.
pub(crate) fn compare(session: &mut Session, backup: Backup) -> Result<usize, Error> {
    let backup = fitting(session, backup)?;
    count_differences(session, &backup)
}

/// The number of settings of a file that differ from the sensor.
pub(crate) fn count_differences(session: &mut Session, backup: &Backup) -> Result<usize, Error> {
    Ok(differences(session, backup)?.len())
}

/// Says what the old sensor had taken from its position and this one does not have.
fn not_carried(
    session: &mut Session,
    found: &Found,
    backup: &Backup,
    terminal: &mut Terminal,
) -> Result<(), Error> {
    if backup.taken.is_empty() {
        return Ok(());
    }
    let own = taken(session)?;
    let is_other = found.serial != backup.serial;
    let missing = backup.taken.iter();
    let missing: Vec<(String, String)> = missing
        .filter(|old| is_other || !own.contains(old))
        .cloned()
        .collect();
    if !missing.is_empty() {
        terminal.note(&Note::TakenMissing(names(&missing)));
    }
    Ok(())
}

/// Prints the settings of a file that differ from the sensor. With `exit_code` a difference is a failure.
pub(crate) fn diff(
    session: &mut Session,
    found: &Found,
    (backup, file): (Backup, String),
    exit_code: bool,
    terminal: &mut Terminal,
) -> Result<(), Error> {
    let backup = fitting(session, backup)?;
    let differences = differences(session, &backup)?;
    not_carried(session, found, &backup, terminal)?;
    if differences.is_empty() {
        terminal.line(format!("the sensor has the settings of {file}"))?;
    }
    show(&differences, terminal)?;
    terminal.document(&document(&differences))?;
    match differences.len() {
        count @ 1.. if exit_code => {
            let different = SensorError::Different(Differing::of(count), file);
            Err(Error::from(different).after_document())
        }
        _ => Ok(()),
    }
}

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
    let _ = match found_differences.is_empty() {
        true => terminal.line(format!("the sensor has the settings of {file} already")),
        false => show(&found_differences, terminal),
    };
    let values = values_of(&found_differences);
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
    for one in &found_differences {
        if acts_later(session.sheet.product, &one.entry) {
            terminal.note(&Note::AtRestart(one.entry.name.clone()));
        }
    }
    let label = backup.label.filter(|_| only.is_empty());
    Ok((document(&found_differences), label))
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
        values = values_of(&differences(session, backup)?);
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

/// The values of a file that differ.
fn values_of(differences: &[Difference]) -> plan::Values {
    let values = differences.iter();
    values.map(|one| (one.entry.clone(), one.raw)).collect()
}
