//! COB-IDs and mappings of CANopen: the service is switched off while they change.

use crate::error::Error;
use crate::note::Note;
use crate::plan::Values;
use crate::session::Session;
use crate::sheet::{Address, Entry};
use plumbline::canopen::cob_id::DISABLED;
use std::collections::BTreeSet;

/// The wanted values of a PDO, and its entries.
struct Pdo {
    cob_id: Option<Entry>,
    count: Option<Entry>,
    /// The wanted COB-ID, if it changes.
    wanted: Option<u32>,
    /// The wanted number of mapped objects.
    wanted_count: Option<u32>,
    /// The wanted mapped objects, by sub-index.
    entries: Values,
    /// The wanted inhibit time and SYNC start value.
    settings: Values,
}

/// The values of a PDO before they change.
struct Before {
    /// The mapped objects, then their number.
    mapping: Values,
    settings: Values,
}

/// The communication parameter of the PDO that must be off while an entry changes: its COB-ID, its mapping, the inhibit time and the SYNC
/// start value of a TPDO (CiA 301, 7.5.2.35 to 7.5.2.38).
fn communication(entry: &Entry) -> Option<u16> {
    let Address::Object { index, sub } = entry.address else {
        return None;
    };
    match (index, sub) {
        (0x1400..=0x15FF, 1) | (0x1800..=0x19FF, 1 | 3 | 6) => Some(index),
        (0x1600..=0x17FF | 0x1A00..=0x1BFF, _) => Some(index - MAPPING),
        _ => None,
    }
}

/// From the index of the communication parameter to the index of the mapping.
const MAPPING: u16 = 0x200;

/// Writes the COB-IDs and mappings of PDOs, and returns the other values.
pub(crate) fn pdos(session: &mut Session, values: Values) -> Result<Values, Error> {
    let (values, rest): (Values, Values) = values
        .into_iter()
        .partition(|(entry, _)| communication(entry).is_some());
    let indices = values.iter().filter_map(|(entry, _)| communication(entry));
    let indices: BTreeSet<u16> = indices.collect();
    for index in indices {
        Pdo::of(session, index, &values).write(session)?;
    }
    Ok(rest)
}

impl Pdo {
    /// The values of the PDO with this communication parameter.
    fn of(session: &Session, index: u16, values: &Values) -> Self {
        let object = |index, sub| Address::Object { index, sub };
        let (cob_id, count) = (object(index, 1), object(index + MAPPING, 0));
        let find = |wanted: Address| {
            let mut entries = session.sheet.entries.iter();
            let found = entries.find(|entry| entry.address == wanted);
            // A PDO with a constant COB-ID cannot be switched off.
            found.filter(|entry| entry.writable).cloned()
        };
        let given = |wanted: Address| {
            let mut values = values.iter();
            let value = values.find(|(entry, _)| entry.address == wanted);
            value.map(|(_, raw)| *raw)
        };
        let own = |wanted: u16, but: Address| -> Values {
            let is_own = |(entry, _): &&(Entry, u32)| {
                matches!(entry.address, Address::Object { index, .. } if index == wanted)
                    && entry.address != but
            };
            values.iter().filter(is_own).cloned().collect()
        };
        Self {
            cob_id: find(cob_id),
            count: find(count),
            wanted: given(cob_id),
            wanted_count: given(count),
            entries: own(index + MAPPING, count),
            settings: own(index, cob_id),
        }
    }

    fn write(&self, session: &mut Session) -> Result<(), Error> {
        let before = self.present(session)?;
        let Some(cob_id) = &self.cob_id else {
            return self.change(session, &before.mapping);
        };
        let present = session.read(cob_id)?;
        self.warn(session, present, &before.mapping);
        session.write(&[(cob_id.clone(), present | DISABLED)])?;
        let wanted = (cob_id.clone(), self.wanted.unwrap_or(present));
        let changed = self.change(session, &before.mapping);
        let written = changed.and_then(|()| session.write(&[wanted]));
        if written.is_err() {
            // The PDO must not stay switched off: a repeated command would read this state as the setting. If the mapping is neither the
            // old nor the new one, the PDO must stay switched off.
            undo(session, &before)?;
            session.put_back(cob_id, present)?;
        }
        written
    }

    fn present(&self, session: &mut Session) -> Result<Before, Error> {
        let mut before = Before {
            mapping: Values::new(),
            settings: Values::new(),
        };
        for (entry, _) in &self.settings {
            let raw = session.read(entry)?;
            before.settings.push((entry.clone(), raw));
        }
        if self.entries.is_empty() && self.wanted_count.is_none() {
            return Ok(before);
        }
        let entries = self.entries.iter().map(|(entry, _)| entry);
        for entry in entries.chain(&self.count) {
            let raw = session.read(entry)?;
            before.mapping.push((entry.clone(), raw));
        }
        Ok(before)
    }

    /// An earlier command can have been interrupted after it had switched the PDO off.
    fn warn(&self, session: &mut Session, cob_id: u32, mapping: &Values) {
        let Some(entry) = &self.cob_id else {
            return;
        };
        if self.wanted.is_none() && cob_id & DISABLED != 0 {
            session.note(Note::PdoOff(entry.name.clone()));
        }
        let count = mapping.last().filter(|(own, raw)| {
            *raw == 0
                && self.wanted_count.is_none()
                && self
                    .count
                    .as_ref()
                    .is_some_and(|count| count.name == own.name)
        });
        if let Some((count, _)) = count {
            session.note(Note::StaysZero(count.name.clone()));
        }
    }

    /// Writes the settings, and the mapped objects while their number is 0.
    fn change(&self, session: &mut Session, mapping: &Values) -> Result<(), Error> {
        for entry in &self.settings {
            session.write(std::slice::from_ref(entry))?;
        }
        let (Some(count), Some((_, present))) = (&self.count, mapping.last()) else {
            for entry in &self.entries {
                session.write(std::slice::from_ref(entry))?;
            }
            return Ok(());
        };
        session.write(&[(count.clone(), 0)])?;
        for entry in &self.entries {
            session.write(std::slice::from_ref(entry))?;
        }
        session.write(&[(count.clone(), self.wanted_count.unwrap_or(*present))])
    }
}

/// Writes the old settings, then the old mapping in the reverse order, and its number at the end.
fn undo(session: &mut Session, before: &Before) -> Result<(), Error> {
    for (entry, raw) in &before.settings {
        session.put_back(entry, *raw)?;
    }
    let Some(((count, present), entries)) = before.mapping.split_last() else {
        return Ok(());
    };
    session.put_back(count, 0)?;
    for (entry, raw) in entries.iter().rev() {
        session.put_back(entry, *raw)?;
    }
    session.put_back(count, *present)
}

/// Writes the other COB-IDs, and returns the other values. An identifier changes while its service is off.
pub(crate) fn others(session: &mut Session, values: Values) -> Result<Values, Error> {
    let (cob_ids, rest): (Values, Values) = values
        .into_iter()
        .partition(|(entry, _)| entry.node_relative);
    for (entry, raw) in cob_ids {
        let present = session.read(&entry)?;
        let is_moved = (present ^ raw) & !DISABLED != 0;
        if is_moved && (present | raw) & DISABLED == 0 {
            session.write(&[(entry.clone(), raw | DISABLED)])?;
        }
        let written = session.write(&[(entry.clone(), raw)]);
        if written.is_err() {
            session.put_back(&entry, present)?;
        }
        written?;
    }
    Ok(rest)
}
