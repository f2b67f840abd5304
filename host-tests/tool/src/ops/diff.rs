//! The settings of a file that differ from those of the sensor.

use super::backup::{names, taken};
use crate::backup::Backup;
use crate::error::{Error, FileError, NumberError};
use crate::identify::Found;
use crate::note::Note;
use crate::output::Terminal;
use crate::plan;
use crate::session::Session;
use crate::sheet::Entry;
use serde::{Serialize, Serializer};
use serde_json::{Value, json};

/// A setting whose value in the file differs.
pub struct Difference {
    /// The setting.
    pub entry: Entry,
    /// What the sensor has, for people and for programs.
    pub sensor: (String, Value),
    /// What the file has.
    pub file: (String, Value),
    /// The number in the file.
    pub raw: u32,
}

/// The settings that differ. As JSON: both values by the names.
pub struct Differences(pub Vec<Difference>);

impl Differences {
    /// For people.
    pub fn lines(&self) -> Vec<String> {
        let names = self.0.iter().map(|one| one.entry.name.len());
        let width = names.max().unwrap_or(0);
        let lines = self.0.iter().map(|one| {
            let (name, sensor, file) = (&one.entry.name, &one.sensor.0, &one.file.0);
            format!("{name:width$}  sensor: {sensor}  file: {file}")
        });
        lines.collect()
    }

    /// The settings with the numbers of the file.
    pub fn values(&self) -> plan::Values {
        let values = self.0.iter();
        values.map(|one| (one.entry.clone(), one.raw)).collect()
    }
}

impl Serialize for Differences {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        to.collect_map(self.0.iter().map(|one| {
            let both = json!({"sensor": one.sensor.1, "file": one.file.1});
            (&one.entry.name, both)
        }))
    }
}

/// The settings of a file that differ from the sensor, compared as values with their unit.
pub(super) fn differences(session: &mut Session, backup: &Backup) -> Result<Differences, Error> {
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
    Ok(Differences(differences))
}

/// Gives a file the resolution of the sensor. The values in its unit stay the same, so their raw numbers change.
pub(super) fn take_resolution(session: &mut Session, backup: &mut Backup) -> Result<(), Error> {
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
pub(super) fn fitting(session: &mut Session, mut backup: Backup) -> Result<Backup, Error> {
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

/// The number of settings of a file of this product that differ from the sensor.
pub(crate) fn compare(session: &mut Session, backup: Backup) -> Result<usize, Error> {
    let backup = fitting(session, backup)?;
    count_differences(session, &backup)
}

/// The number of settings of a file that differ from the sensor.
pub(crate) fn count_differences(session: &mut Session, backup: &Backup) -> Result<usize, Error> {
    Ok(differences(session, backup)?.0.len())
}

/// Says what the old sensor had taken from its position and this one does not have.
pub(super) fn not_carried(
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

/// The settings of a file that differ from the sensor.
///
/// # Errors
/// The file is of another product, the sensor refuses, nobody answers, or the adapter fails.
pub fn diff(
    session: &mut Session,
    found: &Found,
    backup: Backup,
    terminal: &mut Terminal,
) -> Result<Differences, Error> {
    let backup = fitting(session, backup)?;
    let differences = differences(session, &backup)?;
    not_carried(session, found, &backup, terminal)?;
    Ok(differences)
}
