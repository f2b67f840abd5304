//! `identity`: the identity of a sensor, and the unit record with which a replacement has it.

use super::{distinct, replaced};
use crate::backup::{Unread, read_file, write_file};
use crate::eds::identity as data_sheet;
use crate::error::{Error, FileError};
use crate::note::Note;
use crate::ops::Report;
use crate::ops::identity::{SensorIdentity, given};
use crate::output::Terminal;
use descriptors::unit;
use host_tests::store_file;
use std::iter;
use std::path::Path;

/// The longest file that is read, in bytes.
const LONGEST: u64 = 8 << 20;

/// Where the identity is written.
#[derive(Clone, Copy, Debug)]
pub(super) struct Into<'a> {
    /// The sheet that is written.
    pub output: Option<&'a Path>,
    /// The store file of the new unit.
    pub store: Option<&'a Path>,
}

/// Takes the identity in a file.
pub(super) fn from_file(
    path: &Path,
    name: Option<&str>,
    into: Into,
    terminal: &mut Terminal,
) -> Result<(), Error> {
    let written = [into.output, into.store].into_iter().flatten();
    let all: Vec<&Path> = iter::once(path).chain(written).collect();
    distinct(&all)?;
    let shown = path.display().to_string();
    let bytes = read_file(path, LONGEST).map_err(|unread| match unread {
        Unread::Failed(error) => FileError::IdentityUnread(shown.clone(), error.to_string()),
        Unread::Unfit(why) => FileError::Identity(shown.clone(), why.into()),
    })?;
    let identity = given(&data_sheet::text(&bytes), &shown, name)?;
    finish(&identity, into, terminal)
}

/// Prints the identity, and writes the files.
pub(super) fn finish(
    identity: &SensorIdentity,
    into: Into,
    terminal: &mut Terminal,
) -> Result<(), Error> {
    let SensorIdentity { product, unit } = identity;
    if let Some(path) = into.output {
        replaced(path, terminal)?;
        write_file(path, &unit::sheet(product, unit))?;
    }
    if let Some(path) = into.store {
        store_file::identify(product, unit, path).map_err(FileError::Store)?;
    }
    if let Some(path) = into.output {
        terminal.note(&Note::Sheet(path.display().to_string()));
    }
    if let Some(path) = into.store {
        terminal.note(&Note::Identity(product.name, path.display().to_string()));
    }
    terminal.report(&Report::Identity(Box::new(identity.clone())))
}
