//! `backup`: all settings of a sensor.

use crate::backup::Backup;
use crate::error::Error;
use crate::identify::Found;
use crate::note::Note;
use crate::output::Terminal;
use crate::session::Session;
use crate::sheet::Entry;

/// Reads all settings.
pub(crate) fn read(
    session: &mut Session,
    found: &Found,
    terminal: &mut Terminal,
) -> Result<Backup, Error> {
    let sheet = session.sheet.clone();
    let is_foreign = sheet.data_sheet.is_some();
    let mut backup = Backup::new(&sheet, found);
    for entry in sheet.settings() {
        let raw = own(session.read(entry), entry, is_foreign, terminal)?;
        backup.values.extend(raw.map(|raw| (entry.clone(), raw)));
    }
    for entry in sheet.texts() {
        let bytes = own(session.read_bytes(entry), entry, is_foreign, terminal)?;
        let text = bytes.map(|bytes| String::from_utf8_lossy(&bytes).into_owned());
        backup
            .texts
            .extend(text.map(|text| (entry.name.clone(), text)));
    }
    backup.taken = taken(session)?;
    if !backup.taken.is_empty() {
        terminal.note(&Note::Taken(names(&backup.taken)));
    }
    if let Some(node) = session.target.node_id() {
        // The default identifiers in the file belong to the node-ID after the next restart.
        backup.number_from(node);
    }
    let left_out = sheet.commands().count();
    if left_out > 0 {
        terminal.note(&match left_out {
            1 => Note::CommandLeftOut,
            count => Note::CommandsLeftOut(count),
        });
    }
    Ok(backup)
}

/// What was read; None: a device does not need to have all that is in its data sheet.
fn own<T>(
    read: Result<T, Error>,
    entry: &Entry,
    is_foreign: bool,
    terminal: &mut Terminal,
) -> Result<Option<T>, Error> {
    match read {
        Err(failure @ Error::Refused(_)) if is_foreign => {
            terminal.note(&Note::EntryLeftOut(entry.name.clone(), failure));
            Ok(None)
        }
        read => read.map(Some),
    }
}

/// What the sensor has taken from its position, with its value; empty if it is as delivered.
pub(crate) fn taken(session: &mut Session) -> Result<Vec<(String, String)>, Error> {
    let entries: Vec<Entry> = session.sheet.positions().cloned().collect();
    let mut taken = Vec::new();
    for entry in entries {
        let raw = session.read(&entry)?;
        if entry.factory != Some(raw) {
            let scale = session.scale_of(&entry)?;
            taken.push((entry.name.clone(), Entry { scale, ..entry }.text(raw)));
        }
    }
    Ok(taken)
}

/// Their names.
pub(crate) fn names(taken: &[(String, String)]) -> String {
    let names: Vec<&str> = taken.iter().map(|(name, _)| name.as_str()).collect();
    names.join(", ")
}
