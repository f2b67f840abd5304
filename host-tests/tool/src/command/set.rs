//! `set`, `zero` and `teach`.

use super::parameters::show;
use crate::failure::Failure;
use crate::output::Terminal;
use crate::plan;
use crate::resolve;
use crate::session::Session;
use crate::sheet::{Entry, Origin};
use plumbline::model::catalog::{Adjustment, Product, Protocol, Written};
use plumbline::param::{Constraint, DataType, ParameterId};
use serde_json::{Map, Value, json};

pub(super) use crate::plan::Values as Checked;

/// Writes parameters: all are checked before the first is written, then read back.
pub(super) fn set(
    session: &mut Session,
    assignments: &[String],
    save: bool,
    terminal: &mut Terminal,
) -> Result<(), Failure> {
    let sheet = session.sheet.clone();
    let mut wanted = Vec::new();
    for assignment in assignments {
        wanted.extend(resolve::assignments(&sheet, assignment)?);
    }
    let mut texts = Vec::new();
    let mut values = Checked::new();
    for (entry, text) in wanted {
        if !entry.writable {
            let message = format!("{} can only be read", entry.name);
            return Err(Failure::usage("read-only", message));
        }
        if entry.data_type == DataType::Text {
            texts.push((entry.clone(), text));
            continue;
        }
        let raw = check(session, entry, &text)?;
        values.push((entry.clone(), raw));
    }
    constrain(session, &values)?;
    for (entry, text) in &texts {
        session.write_bytes(entry, text.as_bytes())?;
    }
    write(session, &values)?;
    let mut document = Map::new();
    let written = values
        .iter()
        .map(|(entry, _)| entry)
        .chain(texts.iter().map(|(entry, _)| entry));
    for entry in written {
        if entry.readable && !moves(session.sheet.product, entry) {
            let shown = show(session, entry)?;
            terminal.line(format!("{}  {}", entry.name, shown.text))?;
            document.insert(entry.name.clone(), shown.json);
        }
        if let Some(note) = later(session.sheet.product, entry) {
            terminal.note(format!("{} acts {note}", entry.name));
        }
    }
    if save {
        terminal.line(session.save()?)?;
    } else if values
        .iter()
        .any(|(entry, _)| entry.stored && !entry.command)
        && is_saved_on_command(session.sheet.product)
    {
        terminal.note("not stored yet: `plumbline save` keeps it after power-off");
    }
    terminal.document(&Value::Object(document))
}

/// The raw number of a text, within the permitted values.
pub(super) fn check(session: &mut Session, entry: &Entry, text: &str) -> Result<u32, Failure> {
    let scaled = Entry {
        scale: session.scale_of(entry)?,
        ..entry.clone()
    };
    let raw = scaled.parse(text).map_err(|why| {
        let message = format!("{}={text}: {why}; it takes {}", entry.name, entry.range());
        Failure::usage("bad-value", message)
    })?;
    let permitted = entry.check(raw, &scaled.scale);
    permitted.map_err(|why| Failure::usage("out-of-range", why))?;
    Ok(raw)
}

/// Checks values against each other and against those in the sensor.
pub(super) fn constrain(session: &mut Session, values: &Checked) -> Result<(), Failure> {
    for constraint in session.sheet.product.constraints {
        let (one, other) = match *constraint {
            Constraint::Different(one, other) => (one, other),
            Constraint::AtMost {
                parameter, other, ..
            } => (parameter, other),
        };
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
        let (one, other) = (session.entry(one)?, session.entry(other)?);
        let broken = match *constraint {
            Constraint::Different(..) if first == second => Some(format!(
                "{} and {} must differ: both would be {}",
                one.name,
                other.name,
                one.text(first)
            )),
            Constraint::AtMost { high, number, .. }
                if second == u32::from(number) && first > u32::from(high) =>
            {
                let (limit, with) = (one.text(high.into()), other.text(second));
                Some(format!(
                    "{} is at most {limit} with {} {with}",
                    one.name, other.name
                ))
            }
            _ => None,
        };
        if let Some(message) = broken {
            return Err(Failure::usage("out-of-range", message));
        }
    }
    Ok(())
}

/// The value of a parameter after the writes.
fn present(session: &mut Session, values: &Checked, id: ParameterId) -> Result<u32, Failure> {
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

/// Writes values in an order that the sensor accepts, and reads them back.
pub(super) fn write(session: &mut Session, values: &Checked) -> Result<(), Failure> {
    plan::write(session, values)?;
    read_back(session, values)
}

/// Compares values with those in the sensor.
pub(super) fn read_back(session: &mut Session, values: &Checked) -> Result<(), Failure> {
    for (entry, raw) in values {
        if !entry.readable || entry.command || moves(session.sheet.product, entry) {
            continue;
        }
        let read = session.read(entry)?;
        if read != *raw {
            let message = format!(
                "{} was written as {}, but reads {}",
                entry.name,
                entry.text(*raw),
                entry.text(read)
            );
            return Err(Failure::refused("not-written", message));
        }
    }
    Ok(())
}

/// Whether the sensor has another address as soon as this is written.
fn moves(product: &Product, entry: &Entry) -> bool {
    match &product.protocol {
        Protocol::Devicenet(tables) => entry.origin == Origin::Parameter(tables.roles.mac_id),
        Protocol::Fsc(_) | Protocol::Canopen(_) => false,
    }
}

/// When a parameter acts, if not at once.
pub(super) fn later(product: &Product, entry: &Entry) -> Option<&'static str> {
    let Origin::Parameter(id) = entry.origin else {
        return None;
    };
    let restarts = match &product.protocol {
        Protocol::Fsc(tables) => {
            let roles = &tables.roles;
            [roles.set_id, roles.reply_id, roles.sync_id, roles.bit_rate].contains(&id)
        }
        Protocol::Canopen(tables) => [tables.node_id, tables.bit_rate].contains(&id),
        Protocol::Devicenet(tables) => tables.roles.baud_rate == id,
    };
    restarts.then_some("after the next restart")
}

/// Whether the product needs a command to store.
pub(super) fn is_saved_on_command(product: &Product) -> bool {
    !matches!(product.protocol, Protocol::Devicenet(_))
}

/// Makes the present position a reference.
pub(super) fn adjust(
    session: &mut Session,
    what: &str,
    adjustments: &'static [Adjustment],
    axis: Option<&str>,
    save: bool,
    terminal: &mut Terminal,
) -> Result<(), Failure> {
    let product = session.sheet.product;
    if adjustments.is_empty() {
        let message = format!(
            "{} has no {what}: `plumbline parameters` lists what it has",
            product.name
        );
        return Err(Failure::usage("not-offered", message));
    }
    let mut chosen: Vec<&Adjustment> = Vec::new();
    for adjustment in adjustments {
        let is_absent = match adjustment.absent_if {
            Some((id, number)) => {
                let entry = session.entry(id)?;
                session.read(&entry)? == number
            }
            None => false,
        };
        if axis.is_none_or(|axis| axis == adjustment.axis) && !is_absent {
            chosen.push(adjustment);
        }
    }
    if chosen.is_empty() {
        let axes: Vec<&str> = adjustments
            .iter()
            .map(|adjustment| adjustment.axis)
            .collect();
        let hint = match axes[..] {
            [""] => format!("both axes together: `plumbline {what}`"),
            _ => format!("the axes are {}", axes.join(", ")),
        };
        let message = format!("{} has no such axis: {hint}", product.name);
        return Err(Failure::usage("no-axis", message));
    }
    for adjustment in chosen {
        for (id, written) in adjustment.writes {
            let entry = session.entry(*id)?;
            let size = usize::from(entry.data_type.size());
            let number = match *written {
                Written::Nothing => {
                    session.write_bytes(&entry, &[])?;
                    continue;
                }
                Written::Number(number) => number,
                Written::Bits(bits) => session.read(&entry)? | bits,
            };
            session.write_bytes(&entry, &number.to_le_bytes()[..size])?;
        }
    }
    let mut document = Map::new();
    for id in product.guide.angles {
        let Some(entry) = session.sheet.value(*id).cloned() else {
            continue;
        };
        let shown = show(session, &entry)?;
        terminal.line(format!("{}  {}", entry.name, shown.text))?;
        document.insert(entry.name, shown.json);
    }
    if save {
        terminal.line(session.save()?)?;
    } else if is_saved_on_command(product) {
        terminal.note("not stored yet: `plumbline save` keeps it after power-off");
    }
    terminal.document(&json!({what: document}))
}
