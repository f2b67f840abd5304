//! The files of `backup` and `set --file`.

use super::replaced;
use crate::backup::{Backup, read_text, sensor_in, write_file};
use crate::error::{Error, FileError};
use crate::identify::Found;
use crate::master::canopen::eds::dcf::{self, Commissioning};
use crate::ops;
use crate::output::Terminal;
use crate::question::Question;
use crate::session::Session;
use crate::sheet::Sheet;
use serde_json::{Map, Value, json};
use std::path::{Path, PathBuf};

/// Reads all settings and writes them into a file.
pub(super) fn backup(
    session: &mut Session,
    found: &Found,
    path: &Path,
    terminal: &mut Terminal,
) -> Result<(), Error> {
    let (_, document) = save(session, found, path, terminal)?;
    terminal.document(&document)
}

/// The same without its document, which is returned with the settings.
pub(super) fn save(
    session: &mut Session,
    found: &Found,
    path: &Path,
    terminal: &mut Terminal,
) -> Result<(Backup, Value), Error> {
    match other_sensor(session, found, path) {
        Some(other) if !terminal.ask(&other)? => {
            return Err(FileError::Exists(path.display().to_string()).into());
        }
        Some(_) => {}
        None => replaced(path, terminal)?,
    }
    let configuration = configuration_path(session, path)?;
    if let Some(path) = &configuration {
        replaced(path, terminal)?;
    }
    let backup = ops::backup::read(session, found, terminal)?;
    backup.write(path)?;
    let count = backup.values.len();
    let what = match count {
        1 => "1 setting is".to_owned(),
        count => format!("{count} settings are"),
    };
    terminal.line(format!("{what} in {}", path.display()))?;
    let mut document = json!({"file": path.display().to_string(), "settings": count});
    if let Some(path) = configuration {
        write_file(&path, &configuration_text(session, &backup, &path))?;
        let shown = path.display().to_string();
        terminal.line(format!("the same for CANopen tools (DCF) is in {shown}"))?;
        document["dcf"] = json!(shown);
    }
    Ok((backup, document))
}

/// The question about a file with the settings of another sensor; None: it is no such file.
fn other_sensor(session: &Session, found: &Found, path: &Path) -> Option<Question> {
    let (product, serial) = sensor_in(&read_text(path).ok()?)?;
    let own = session.sheet.product.name;
    let shown = |serial: Option<u32>| serial.map_or("-".to_owned(), |own| own.to_string());
    let is_same = product == own && serial == found.serial;
    (!is_same).then(|| Question::OverwriteOther {
        path: path.display().to_string(),
        file: format!("{product} {}", shown(serial)),
        own: format!("{own} {}", shown(found.serial)),
    })
}

/// The settings in a file for this sensor, with the name of the file.
pub(super) fn read(session: &Session, path: &Path) -> Result<(Backup, String), Error> {
    let foreign = session.sheet.data_sheet.is_some();
    let backup = Backup::read_with(path, foreign.then_some(&session.sheet))?;
    Ok((backup, path.display().to_string()))
}

/// The path of the Device Configuration File (DCF), which is also written for a CANopen device.
fn configuration_path(session: &Session, path: &Path) -> Result<Option<PathBuf>, Error> {
    let is_special = path.exists() && !path.is_file();
    if session.target.node_id().is_none() || is_special {
        return Ok(None);
    }
    let configuration = path.with_extension("dcf");
    if configuration == path {
        return Err(FileError::Dcf(path.display().to_string()).into());
    }
    Ok(Some(configuration))
}

/// The Device Configuration File (DCF) with the values of a backup.
fn configuration_text(session: &Session, backup: &Backup, path: &Path) -> String {
    let Some(in_force) = session.target.node_id() else {
        return String::new();
    };
    let data_sheet = match &session.sheet.data_sheet {
        Some(data_sheet) => data_sheet.text.to_string(),
        None => descriptors::describe(session.sheet.product).text,
    };
    let name = path.file_name().unwrap_or_default();
    let commissioning = Commissioning {
        file: name.to_string_lossy().into_owned(),
        node: backup.node().unwrap_or(in_force),
        name: backup.label.clone().unwrap_or_default(),
        rate: session.link.rate(),
        serial: backup.serial,
    };
    dcf::text(&data_sheet, &commissioning, &backup.values)
}

/// Changes values in a file, without a sensor.
pub(super) fn set_in_file(
    path: &Path,
    assignments: &[String],
    foreign: Option<&Sheet>,
    terminal: &mut Terminal,
) -> Result<(), Error> {
    let mut backup = Backup::read_with(path, foreign)?;
    let mut changed = Map::new();
    let names = backup.assign(assignments)?;
    backup.write(path)?;
    for name in names {
        if let Some((own, raw)) = backup.values.iter().find(|(own, _)| own.name == name) {
            let shown = backup.text_of(own, *raw);
            terminal.line(format!("{name}  {shown}"))?;
            changed.insert(name, backup.json_of(own, *raw));
        }
    }
    terminal.document(&Value::Object(changed))
}
