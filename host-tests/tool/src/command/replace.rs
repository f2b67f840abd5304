//! `replace`: the file of the old sensor, and the report.

use super::bus::Bus;
use super::{distinct, replaced};
use crate::backup::write_file;
use crate::cli::replace::Replace;
use crate::error::{Error, FileError, SensorError};
use crate::note::Note;
use crate::ops::Report;
use crate::ops::replace::{self, old::Old};
use crate::output::Terminal;
use host_tests::store_file;
use serde_json::json;
use std::iter;
use std::path::Path;

/// Runs a step of a replacement.
pub(super) fn run(step: &Replace, bus: &mut Bus, terminal: &mut Terminal) -> Result<(), Error> {
    match step {
        Replace::Read { file } => bus.with_found(terminal, |session, found, terminal| {
            replaced(file, terminal)?;
            let (old, unit) = replace::read(session, found, terminal)?;
            write_file(file, &old.text(&unit))?;
            let (count, path) = (old.backup.values.len(), file.display().to_string());
            terminal.line(format!(
                "{count} settings, the identity and the angles are in {path}"
            ))?;
            terminal.document(&json!({"file": path, "settings": count}))
        }),
        Replace::Write {
            file,
            report,
            store,
        } => {
            let written = [report, store].into_iter().flatten().map(AsRef::as_ref);
            let all: Vec<&Path> = iter::once(file.as_ref()).chain(written).collect();
            distinct(&all)?;
            let old = Old::read(file)?;
            if let Some(report) = report {
                replaced(report, terminal)?;
            }
            bus.with_found(terminal, |session, found, terminal| {
                let (path, product) = (file.display().to_string(), session.sheet.product);
                let unit = store.as_ref().map(|store| {
                    let unit = old.identity.unit(product);
                    let bad = |why: String| FileError::Identity(path.clone(), why.into());
                    unit.map(|unit| (store, unit)).map_err(bad)
                });
                let unit = unit.transpose()?;
                let done = replace::write(session, found, (&old, path.clone()), terminal)?;
                let (text, differences) = (done.text(), done.differences());
                terminal.report(&Report::Replaced(Box::new(done)))?;
                // From here on, the sensor has the settings, and the user the report.
                if let Some(report) = report {
                    write_file(report, &text).map_err(Error::after_document)?;
                }
                if let Some((store, unit)) = unit {
                    let written = store_file::identify(product, &unit, store);
                    let failed = |why| Error::from(FileError::Store(why)).after_document();
                    written.map_err(failed)?;
                    let store = store.display().to_string();
                    terminal.note(&Note::Identity(product.name, store));
                }
                match differences {
                    0 => Ok(()),
                    count => {
                        let different = SensorError::Replacement(count);
                        Err(Error::from(different).after_document())
                    }
                }
            })
        }
    }
}
