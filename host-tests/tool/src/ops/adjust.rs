//! `zero`, `teach`, and the question before them and before `load-factory`.

use super::get::show;
use super::report::{Adjusted, Report, Values};
use super::set::needs_save;
use crate::error::{Error, RequestError, Why};
use crate::identify::Found;
use crate::note::Note;
use crate::output::Terminal;
use crate::question::{Change, Question};
use crate::session::Session;
use crate::sheet::{Entry, Origin};
use plumbline::model::catalog::{Adjustment, Product, Written};
use texts::Kind;

/// The reference that the present position becomes.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum What {
    /// Zero of the angles.
    Zero,
    /// The reference frame of the machine.
    Teach,
}

impl What {
    /// The name of the command.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Zero => "zero",
            Self::Teach => "teach",
        }
    }

    const fn adjustments(self, product: &Product) -> &'static [Adjustment] {
        match self {
            Self::Zero => product.guide.zero,
            Self::Teach => product.guide.teach,
        }
    }

    /// The readable parameters that the adjustments write.
    pub fn written(self, session: &Session) -> Vec<Entry> {
        let adjustments = self.adjustments(session.sheet.product).iter();
        let writes = adjustments.flat_map(|adjustment| adjustment.writes);
        let entries = writes.filter_map(|(id, _)| session.sheet.parameter(*id));
        entries.filter(|entry| entry.readable).cloned().collect()
    }

    pub(crate) const fn change(self) -> Change {
        match self {
            Self::Zero => Change::Zero,
            Self::Teach => Change::Teach,
        }
    }
}

/// The angles; an angle that is not measured yet is left out.
fn angles(session: &mut Session) -> Result<Values, Error> {
    let mut angles = Values::default();
    for id in session.sheet.product.guide.angles {
        let Some(entry) = session.sheet.value(*id).cloned() else {
            continue;
        };
        match show(session, &entry) {
            Err(Error::Refused(_)) => {}
            shown => angles.0.push(shown?),
        }
    }
    Ok(angles)
}

/// Asks whether this is the right sensor: what, product, serial number, address, present angles.
///
/// # Errors
/// The answer is no, nobody answers, or the adapter fails.
pub(crate) fn confirm(
    session: &mut Session,
    found: &Found,
    change: Change,
    terminal: &mut Terminal,
) -> Result<(), Error> {
    let name = change.name();
    if name.is_in(terminal.yes) {
        return Ok(());
    }
    let sensor = found.about(session.link.rate());
    let angles = angles(session)?.0.into_iter();
    let angles = angles.map(|angle| format!("{}  {}", angle.name, angle.text));
    let question = Question::Change {
        change,
        sensor: sensor.to_string(),
        angles: angles.collect::<Vec<_>>().join(", "),
    };
    match terminal.ask(&question)? {
        true => Ok(()),
        false => Err(RequestError::NotConfirmed(sensor.to_string(), name.to_string()).into()),
    }
}

/// Makes the present position a reference.
pub(crate) fn adjust(
    session: &mut Session,
    found: &Found,
    what: What,
    (axis, save): (Option<&str>, bool),
    terminal: &mut Terminal,
) -> Result<Report, Error> {
    let chosen = chosen(session, what, axis)?;
    confirm(session, found, what.change(), terminal)?;
    write(session, what, &chosen, save, terminal)
}

/// Makes the present position a reference, without a question.
pub(crate) fn write(
    session: &mut Session,
    what: What,
    chosen: &[&'static Adjustment],
    save: bool,
    terminal: &mut Terminal,
) -> Result<Report, Error> {
    let product = session.sheet.product;
    let (mut is_pending, mut numbers) = (false, Vec::new());
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
                Written::Bits(bits) => session.in_force(&entry)? | bits,
            };
            let taken = session.write_bytes(&entry, &number.to_le_bytes()[..size]);
            taken.map_err(not_taken)?;
            numbers.retain(|(own, _): &(Entry, u32)| own.name != entry.name);
            if !entry.command {
                numbers.push((entry, number));
            }
        }
    }
    let angles = angles(session)?;
    let mut stored = None;
    if save {
        stored = Some(session.save()?);
    } else if is_pending {
        terminal.note(&Note::NotStored);
    } else {
        terminal.note(&Note::StoredBySensor);
    }
    Ok(Report::Adjusted(Adjusted {
        what,
        angles,
        stored,
        written: numbers,
    }))
}

/// The cause of a refusal.
fn not_taken(failure: Error) -> Error {
    match failure.kind() {
        Kind::Refused => failure.explained(Why::NotTaken),
        _ => failure,
    }
}

/// The adjustments of the wanted axis, or of all axes that the sensor has.
pub(crate) fn chosen(
    session: &mut Session,
    what: What,
    axis: Option<&str>,
) -> Result<Vec<&'static Adjustment>, Error> {
    let product = session.sheet.product;
    let (adjustments, what) = (what.adjustments(product), what.name());
    if adjustments.is_empty() {
        return Err(RequestError::NoCommand(product.name, what).into());
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
        return Err(match axes[..] {
            [""] => RequestError::OnlyTogether(product.name, what),
            _ => RequestError::NoAxis(product.name, axes.join(", ")),
        }
        .into());
    }
    Ok(chosen)
}
