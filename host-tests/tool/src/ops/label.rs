//! `label`: the name of a sensor on this computer.

use super::{Done, Report};
use crate::error::Error;
use crate::identify::Found;
use crate::labels::Labels;
use crate::note::Note;
use crate::output::Terminal;

/// What to do with the name.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum Change<'a> {
    Show,
    Give(&'a str),
    Remove,
}

/// Shows or changes the name.
pub(crate) fn label(
    labels: &mut Labels,
    found: &Found,
    change: Change,
    terminal: &mut Terminal,
) -> Result<Report, Error> {
    let before = labels.name(found);
    match change {
        Change::Show => {}
        Change::Give(name) => labels.set(found, Some(name))?,
        Change::Remove => labels.set(found, None)?,
    }
    let name = labels.name(found);
    if let (Change::Give(_) | Change::Remove, Some(path)) = (change, labels.path()) {
        terminal.note(&Note::Labels(path.display().to_string()));
    }
    let line = match (change, &name, before) {
        (Change::Remove, None, Some(before)) => Done::LabelRemoved(before),
        (_, Some(name), _) => Done::Label(name.clone()),
        (_, None, _) => Done::NoLabel,
    };
    Ok(Report::Label { label: name, line })
}

/// Gives the name in a file to a sensor that has no name, for example to the replacement of a broken sensor.
pub(crate) fn take_over(
    labels: &mut Labels,
    found: &Found,
    name: Option<&str>,
    terminal: &mut Terminal,
) {
    let Some(name) = name.filter(|_| found.serial.is_some() && labels.name(found).is_none()) else {
        return;
    };
    // The settings are restored already.
    match labels.set(found, Some(name)) {
        Ok(()) => terminal.note(&Note::Labelled(name.to_owned())),
        Err(failure) => terminal.note(&Note::NotLabelled(failure)),
    }
}
