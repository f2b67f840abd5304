//! `backup`, `restore`, `diff`, and `set --file`.

use super::set::{is_saved_on_command, later, read_back};
use crate::backup::Backup;
use crate::failure::Failure;
use crate::identify::Found;
use crate::output::Terminal;
use crate::plan;
use crate::resolve;
use crate::session::Session;
use crate::sheet::{Entry, Origin};
use plumbline::model::catalog::Protocol;
use plumbline::param::DataType;
use serde_json::{Map, Value, json};
use std::path::Path;

/// Reads all settings and writes them into a file.
pub(super) fn backup(
    session: &mut Session,
    found: &Found,
    path: &Path,
    terminal: &mut Terminal,
) -> Result<(), Failure> {
    let exists = path.exists();
    if exists && !(terminal.confirm)(&format!("{} exists. Replace it?", path.display())) {
        let message = format!(
            "{} exists: choose another name, or --yes replaces it",
            path.display()
        );
        return Err(Failure::usage("file-exists", message));
    }
    let mut backup = Backup::new(session.sheet.product, found);
    let settings: Vec<Entry> = session.sheet.settings().cloned().collect();
    for entry in settings {
        let raw = session.read(&entry)?;
        backup.values.push((entry, raw));
    }
    let is_text = |entry: &&Entry| entry.data_type == DataType::Text && entry.writable;
    let texts: Vec<Entry> = session
        .sheet
        .entries
        .iter()
        .filter(is_text)
        .cloned()
        .collect();
    for entry in texts {
        let bytes = session.read_bytes(&entry)?;
        backup
            .texts
            .push((entry.name, String::from_utf8_lossy(&bytes).into_owned()));
    }
    backup.write(path)?;
    let count = backup.values.len();
    terminal.line(format!("{count} settings are in {}", path.display()))?;
    terminal.document(&json!({"file": path.display().to_string(), "settings": count}))
}

/// A setting whose value in the file differs.
struct Difference {
    entry: Entry,
    sensor: (String, Value),
    file: (String, Value),
    raw: u32,
}

/// The settings of a file that differ from the sensor, compared as values with their unit.
fn differences(session: &mut Session, backup: &Backup) -> Result<Vec<Difference>, Failure> {
    let (own, wanted) = (session.sheet.product, backup.sheet.product);
    if own.name != wanted.name {
        let message = format!(
            "the file is of {}, but the sensor is {}: nothing was written",
            wanted.name, own.name
        );
        return Err(Failure::usage("wrong-file", message));
    }
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

fn show(differences: &[Difference], terminal: &mut Terminal) -> Result<(), Failure> {
    let width = differences
        .iter()
        .map(|one| one.entry.name.len())
        .max()
        .unwrap_or(0);
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
    let rows = differences.iter().map(|one| {
        (
            one.entry.name.clone(),
            json!({"sensor": one.sensor.1, "file": one.file.1}),
        )
    });
    terminal.document(&Value::Object(rows.collect::<Map<_, _>>()))
}

/// Prints the settings of a file that differ from the sensor.
pub(super) fn diff(
    session: &mut Session,
    path: &Path,
    terminal: &mut Terminal,
) -> Result<(), Failure> {
    let backup = Backup::read(path)?;
    let differences = differences(session, &backup)?;
    if differences.is_empty() {
        terminal.line(format!("the sensor has the settings of {}", path.display()))?;
    }
    show(&differences, terminal)
}

/// Writes the settings of a file that differ from the sensor, reads them back and stores them.
pub(super) fn restore(
    session: &mut Session,
    found: &Found,
    path: &Path,
    only: &[String],
    terminal: &mut Terminal,
) -> Result<(), Failure> {
    let mut backup = Backup::read(path)?;
    if !only.is_empty() {
        let mut wanted = Vec::new();
        for name in only {
            wanted.extend(
                resolve::entries(&session.sheet, name)?
                    .into_iter()
                    .map(|entry| entry.name.clone()),
            );
        }
        let resolution = session
            .sheet
            .product
            .guide
            .resolution
            .map(|resolution| Origin::Parameter(resolution.parameter));
        let follows = wanted.iter().any(|name| {
            let entry = session
                .sheet
                .entries
                .iter()
                .find(|entry| entry.name == *name);
            entry.is_some_and(|entry| session.sheet.follows_resolution(entry))
        });
        // Numbers in the unit of the resolution need the resolution of the file.
        let is_wanted = |entry: &Entry| {
            wanted.contains(&entry.name) || (follows && Some(entry.origin) == resolution)
        };
        backup.values.retain(|(entry, _)| is_wanted(entry));
    }
    let found_differences = differences(session, &backup)?;
    if found.serial != backup.serial {
        terminal.note("the file is of a sensor with another serial number");
    }
    if found_differences.is_empty() {
        terminal.line(format!(
            "the sensor has the settings of {} already",
            path.display()
        ))?;
    }
    show(&found_differences, terminal)?;
    let resolution = session
        .sheet
        .product
        .guide
        .resolution
        .map(|resolution| Origin::Parameter(resolution.parameter));
    let is_first = |one: &Difference| Some(one.entry.origin) == resolution;
    let mut values: plan::Values = found_differences
        .iter()
        .map(|one| (one.entry.clone(), one.raw))
        .collect();
    if found_differences.iter().any(is_first) {
        // The sensor converts the other numbers to the new unit, so they are compared again.
        values.retain(|(entry, _)| Some(entry.origin) == resolution);
        plan::write(session, &values)?;
        let rest = differences(session, &backup)?;
        values = rest
            .iter()
            .map(|one| (one.entry.clone(), one.raw))
            .collect();
    }
    plan::write(session, &values)?;
    read_back(session, &values)?;
    if found_differences.is_empty() {
        return Ok(());
    }
    if let Protocol::Devicenet(_) = session.sheet.product.protocol {
        terminal.line("the sensor stores each change by itself within one second")?;
    } else if is_saved_on_command(session.sheet.product) {
        terminal.line(session.save()?)?;
    }
    for one in &found_differences {
        if let Some(note) = later(session.sheet.product, &one.entry) {
            terminal.note(format!("{} acts {note}", one.entry.name));
        }
    }
    Ok(())
}

/// Changes values in a file, without a sensor.
pub(super) fn set(
    path: &Path,
    assignments: &[String],
    terminal: &mut Terminal,
) -> Result<(), Failure> {
    let mut backup = Backup::read(path)?;
    let sheet = backup.sheet.clone();
    let mut changed = Map::new();
    for assignment in assignments {
        for (entry, text) in resolve::assignments(&sheet, assignment)? {
            backup
                .set(&entry.name, &text)
                .map_err(|why| Failure::usage("out-of-range", why))?;
            if let Some((own, raw)) = backup.values.iter().find(|(own, _)| own.name == entry.name) {
                let shown = backup.text_of(own, *raw);
                terminal.line(format!("{}  {shown}", entry.name))?;
                changed.insert(entry.name.clone(), json!(shown));
            }
        }
    }
    backup.write(path)?;
    terminal.document(&Value::Object(changed))
}
