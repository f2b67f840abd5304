//! `zero`, `teach`, and the question before them and before `load-factory`.

use super::parameters::show;
use super::set::needs_save;
use crate::failure::{Failure, Kind};
use crate::identify::Found;
use crate::output::Terminal;
use crate::session::Session;
use crate::sheet::Origin;
use plumbline::model::catalog::{Adjustment, Written};
use serde_json::{Map, Value, json};

/// The reference that the present position becomes.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum What {
    Zero,
    /// The reference frame of the machine.
    Teach,
}

impl What {
    /// The name of the command.
    const fn name(self) -> &'static str {
        match self {
            Self::Zero => "zero",
            Self::Teach => "teach",
        }
    }

    const fn question(self) -> &'static str {
        match self {
            Self::Zero => "Make the present position zero",
            Self::Teach => "Make the present position the reference frame",
        }
    }
}

/// The angles as text and document; an angle that is not measured yet is left out.
fn angles(session: &mut Session) -> Result<(Vec<String>, Map<String, Value>), Failure> {
    let (mut lines, mut document) = (Vec::new(), Map::new());
    for id in session.sheet.product.guide.angles {
        let Some(entry) = session.sheet.value(*id).cloned() else {
            continue;
        };
        match show(session, &entry) {
            Err(failure) if failure.code == "refused" => {}
            shown => {
                let shown = shown?;
                lines.push(format!("{}  {}", entry.name, shown.text));
                document.insert(entry.name, shown.json);
            }
        }
    }
    Ok((lines, document))
}

/// Asks whether this is the right sensor: what, product, serial number, address, present angles.
///
/// # Errors
/// The answer is no, nobody answers, or the adapter fails.
pub(super) fn confirm(
    session: &mut Session,
    found: &Found,
    what: &str,
    terminal: &mut Terminal,
) -> Result<(), Failure> {
    let sensor = found.line(session.link.rate());
    let (angles, _) = angles(session)?;
    let question = format!("{what}? {sensor}; {}", angles.join(", "));
    match (terminal.confirm)(&question) {
        true => Ok(()),
        false => Err(Failure::usage(
            "not-confirmed",
            format!("nothing has changed ({sensor}): --yes answers the question"),
        )),
    }
}

/// Makes the present position a reference.
pub(super) fn adjust(
    session: &mut Session,
    found: &Found,
    what: What,
    (axis, save): (Option<&str>, bool),
    terminal: &mut Terminal,
) -> Result<(), Failure> {
    let product = session.sheet.product;
    let adjustments = match what {
        What::Zero => product.guide.zero,
        What::Teach => product.guide.teach,
    };
    let chosen = chosen(session, what, adjustments, axis)?;
    confirm(session, found, what.question(), terminal)?;
    let mut is_pending = false;
    for adjustment in chosen {
        for (id, written) in adjustment.writes {
            is_pending |= needs_save(product, Origin::Parameter(*id));
            let entry = session.entry(*id)?;
            let size = usize::from(entry.data_type.size());
            let number = match *written {
                Written::Nothing => {
                    let taken = session.write_bytes(&entry, &[]);
                    taken.map_err(not_taken)?;
                    continue;
                }
                Written::Number(number) => number,
                Written::Bits(bits) => session.read(&entry)? | bits,
            };
            let taken = session.write_bytes(&entry, &number.to_le_bytes()[..size]);
            taken.map_err(not_taken)?;
        }
    }
    let (lines, document) = angles(session)?;
    for line in lines {
        terminal.line(line)?;
    }
    if save {
        terminal.line(session.save()?)?;
    } else if is_pending {
        terminal.note("not stored yet: `plumbline save` stores it");
    } else {
        terminal.note("the sensor stores it by itself");
    }
    terminal.document(&json!({what.name(): document}))
}

/// The cause of a refusal.
fn not_taken(failure: Failure) -> Failure {
    if failure.kind != Kind::Refused {
        return failure;
    }
    let message = format!(
        "the present position was not taken: the sensor has no valid angle now (its accelerometer clips, fails or gives no values), or it cannot use this position; {failure}"
    );
    Failure { message, ..failure }
}

/// The adjustments of the wanted axis, or of all axes that the sensor has.
fn chosen(
    session: &mut Session,
    what: What,
    adjustments: &'static [Adjustment],
    axis: Option<&str>,
) -> Result<Vec<&'static Adjustment>, Failure> {
    let (product, what) = (session.sheet.product, what.name());
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
    Ok(chosen)
}
