//! `set`: checks, writes and reads back.

use super::address;
use super::get::show;
use super::report::{Report, Values as Read};
use crate::error::{Error, NumberError, RequestError, SensorError};
use crate::master::{Roles, Storing};
use crate::note::Note;
use crate::output::Terminal;
use crate::plan;
use crate::resolve;
use crate::session::Session;
use crate::sheet::{Entry, Origin, parameters};
use plumbline::model::catalog::Product;
use plumbline::param::{DataType, ParameterId, Persistence};

pub(crate) use crate::plan::Values as Checked;

/// Writes parameters: all are checked before the first is written, then read back.
pub(crate) fn set(
    session: &mut Session,
    assignments: &[String],
    save: bool,
    terminal: &mut Terminal,
) -> Result<Report, Error> {
    let sheet = session.sheet.clone();
    let mut wanted = Vec::new();
    for assignment in assignments {
        wanted.extend(resolve::assignments(&sheet, assignment)?);
    }
    once_each(wanted.iter().map(|(entry, _)| *entry))?;
    // The resolution comes first: it is the unit of other values.
    wanted.sort_by_key(|(entry, _)| !sheet.is_resolution(entry));
    let mut texts = Vec::new();
    let mut values = Checked::new();
    for (entry, text) in wanted {
        if !entry.writable {
            return Err(entry.read_only().into());
        }
        if entry.data_type == DataType::Text {
            if text.len() > LONGEST_TEXT || !text.bytes().all(|byte| (b' '..=b'~').contains(&byte))
            {
                return Err(NumberError::TooLong(entry.name.clone(), text, LONGEST_TEXT).into());
            }
            texts.push((entry.clone(), text));
            continue;
        }
        let raw = check(session, entry, &text, &values)?;
        values.push((entry.clone(), raw));
    }
    constrain(session, &values)?;
    address::check(session, &values)?;
    write(session, &values)?;
    for (entry, text) in &texts {
        session.write_bytes(entry, text.as_bytes())?;
        let read = session.read_bytes(entry)?;
        if !is_text(&read, text) {
            let read = format!("{:?}", String::from_utf8_lossy(&read));
            return Err(SensorError::NotWritten(entry.name.clone(), text.clone(), read).into());
        }
    }
    let mut read = Read::default();
    let written = values
        .iter()
        .map(|(entry, _)| entry)
        .chain(texts.iter().map(|(entry, _)| entry));
    for entry in written {
        if entry.readable {
            read.0.push(show(session, entry)?);
        }
        if acts_later(session.sheet.product, entry) {
            terminal.note(&Note::AtRestart(entry.name.clone()));
        }
    }
    let mut stored = None;
    if save {
        stored = Some(session.save()?);
    } else if values.iter().any(|(entry, _)| {
        entry.stored && !entry.command && needs_save(session.sheet.product, entry.origin)
    }) {
        terminal.note(&Note::NotStored);
    }
    Ok(Report::Written {
        values: read,
        stored,
    })
}

/// The longest text that is written.
const LONGEST_TEXT: usize = 255;

/// Whether the bytes of a sensor are this text.
fn is_text(read: &[u8], text: &str) -> bool {
    let end = read.iter().position(|byte| *byte == 0);
    read[..end.unwrap_or(read.len())] == *text.as_bytes()
}

/// Refuses a name that is given twice.
pub(crate) fn once_each<'a>(entries: impl Iterator<Item = &'a Entry>) -> Result<(), Error> {
    let mut seen: Vec<&str> = Vec::new();
    for entry in entries {
        if seen.contains(&entry.name.as_str()) {
            return Err(RequestError::GivenTwice(entry.name.clone()).into());
        }
        seen.push(&entry.name);
    }
    Ok(())
}

/// The raw number of a text, within the permitted values. Its unit is the unit after the writes of `others`.
fn check(session: &mut Session, entry: &Entry, text: &str, others: &Checked) -> Result<u32, Error> {
    let mut resolutions = others.iter();
    let resolution = resolutions.find(|(other, _)| {
        session.sheet.is_resolution(other) && session.sheet.follows_resolution(entry)
    });
    let scale = match resolution {
        Some((resolution, raw)) => resolution.scale.times(*raw),
        None => session.scale_of(entry)?,
    };
    Ok(entry.accept(text, &scale)?)
}

/// Checks values against each other and against the values in the sensor.
pub(crate) fn constrain(session: &mut Session, values: &Checked) -> Result<(), Error> {
    for constraint in session.sheet.product.constraints {
        let (one, other) = parameters(constraint);
        let is_set = |id: ParameterId| {
            values
                .iter()
                .any(|(entry, _)| entry.origin == Origin::Parameter(id))
        };
        if !is_set(one) && !is_set(other) {
            continue;
        }
        let first = present(session, values, one)?;
        let second = present(session, values, other)?;
        if let Some(wrong) = session.sheet.broken(constraint, first, second) {
            return Err(wrong.into());
        }
    }
    Ok(())
}

/// The value of a parameter after the writes.
fn present(session: &mut Session, values: &Checked, id: ParameterId) -> Result<u32, Error> {
    let own = values
        .iter()
        .find(|(entry, _)| entry.origin == Origin::Parameter(id));
    match own {
        Some((_, raw)) => Ok(*raw),
        None => {
            let entry = session.entry(id)?;
            session.read(&entry)
        }
    }
}

/// Writes values in an order that the sensor accepts, and reads them back. The MAC ID comes last, because the sensor has it at once.
pub(crate) fn write(session: &mut Session, values: &Checked) -> Result<(), Error> {
    let product = session.sheet.product;
    let (moving, rest): (Checked, Checked) = values
        .iter()
        .cloned()
        .partition(|(entry, raw)| address::moved(product, entry, *raw).is_some());
    plan::write(session, &rest)?;
    read_back(session, &rest)?;
    for (entry, raw) in moving {
        if let Some(target) = address::moved(product, &entry, raw) {
            address::move_at_once(session, entry, raw, target)?;
        }
    }
    Ok(())
}

/// Compares values with the values in the sensor.
pub(crate) fn read_back(session: &mut Session, values: &Checked) -> Result<(), Error> {
    for (entry, raw) in values {
        if !entry.readable || entry.command {
            continue;
        }
        let read = session.read(entry)?;
        if read != *raw {
            return Err(SensorError::NotWritten(
                entry.name.clone(),
                entry.text(*raw),
                entry.text(read),
            )
            .into());
        }
    }
    Ok(())
}

/// Whether a parameter acts after the next restart.
pub(crate) fn acts_later(product: &Product, entry: &Entry) -> bool {
    let (Origin::Parameter(id), Some(roles)) = (entry.origin, Roles::of(product)) else {
        return false;
    };
    roles.is_rate(id) || (roles.is_address(id) && !roles.moves_at_once)
}

/// Whether a change is lost at power-off until a command stores it.
pub(crate) fn needs_save(product: &Product, origin: Origin) -> bool {
    let id = match origin {
        Origin::Parameter(id) => id,
        Origin::DataSheet => return is_saved_on_command(product),
        Origin::Value(_) | Origin::Fact => return false,
    };
    let persistence = product.parameters[usize::from(id.0)].persistence;
    is_saved_on_command(product) && persistence != Persistence::AtOnce
}

/// Whether the product needs a command to store.
pub(crate) fn is_saved_on_command(product: &Product) -> bool {
    Roles::of(product).is_some_and(|roles| roles.storing == Storing::Command)
}
