//! Values that were written, but not stored: the sensor loses them when it is switched off.

use super::{State, Worker};
use crate::ops::align::Aligned;
use crate::ops::report::Values;
use crate::ops::set::needs_save;
use crate::ops::{Report, Request};
use crate::session::Session;
use crate::sheet::Entry;
use serde_json::Value;

impl Worker {
    /// Their names, for the page.
    pub(super) fn unsaved(&self) -> Vec<&String> {
        match self.state {
            State::Active(_) => self.unsaved.keys().collect(),
            State::Closed | State::Listening(_) | State::Open(_) => Vec::new(),
        }
    }

    /// Notes what an operation has written without storing it, or that all is stored or lost.
    pub(super) fn note_unsaved(&mut self, request: &Request, report: &Report) {
        let State::Active(live) = &self.state else {
            return;
        };
        let session = &live.session;
        let written: Vec<(String, Value)> = match (request, report) {
            (_, Report::Written { values, stored }) if stored.is_none() => lost(session, values),
            (_, Report::Adjusted(adjusted)) if adjusted.stored.is_none() => {
                let entries = adjusted.what.written(session).into_iter();
                let entries = entries.filter(|entry| is_lost(session, entry));
                entries.map(|entry| (entry.name, Value::Null)).collect()
            }
            // They leave the stored values in force.
            (_, Report::Written { .. } | Report::Adjusted(_) | Report::Address(_))
            | (
                Request::Save
                | Request::LoadFactory
                | Request::Restart
                | Request::Rate { .. }
                | Request::Address(_),
                _,
            ) => {
                self.unsaved.clear();
                return;
            }
            _ => return,
        };
        self.unsaved.extend(written);
    }

    /// Notes the offsets that were written without storing them, or that all is stored.
    pub(super) fn note_aligned(&mut self, aligned: &Aligned) {
        let State::Active(live) = &self.state else {
            return;
        };
        match aligned.stored {
            Some(_) => self.unsaved.clear(),
            None => self.unsaved.extend(lost(&live.session, &aligned.offsets)),
        }
    }

    /// The values that a new reference has written, as they were read after it.
    pub(super) fn fill_unsaved(&mut self) {
        for (name, written) in self.unsaved.iter_mut() {
            if let (Value::Null, Some(own)) = (&*written, self.values.get(name)) {
                *written = own.clone();
            }
        }
    }

    /// Forgets the values that the sensor has no longer: it has been restarted.
    pub(super) fn forget_lost(&mut self) {
        let values = &self.values;
        self.unsaved
            .retain(|name, written| values.get(name) == Some(written));
    }
}

/// Whether the sensor loses this setting when it is switched off, unless it is stored.
fn is_lost(session: &Session, entry: &Entry) -> bool {
    let is_setting = entry.stored && !entry.command;
    is_setting && needs_save(session.sheet.product, entry.origin)
}

/// Those of these values that the sensor loses.
fn lost(session: &Session, values: &Values) -> Vec<(String, Value)> {
    let entry = |name: &str| session.sheet.entries.iter().find(|own| own.name == name);
    let values = values.0.iter();
    let values =
        values.filter(|shown| entry(&shown.name).is_some_and(|entry| is_lost(session, entry)));
    let values = values.map(|shown| (shown.name.clone(), shown.json.clone()));
    values.collect()
}
