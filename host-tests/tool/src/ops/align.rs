//! `align`: the offset of the mounting, by the reversal. The sensor is read at rest, turned by 180 deg about the vertical axis, and read
//! again. The turn inverts the inclination of the surface and keeps the offset of the mounting, so the mean of both angles is the offset.

use super::adjust::{What, chosen};
use super::report::{Done, Values};
use super::rest::{self, Rest, degrees, thousandths, wrapped};
use super::{get, set};
use crate::error::{Error, RequestError};
use crate::identify::Found;
use crate::note::Note;
use crate::output::Terminal;
use crate::question::{self, AtRest, Name, Question};
use crate::sample::Sampler;
use crate::session::Session;
use crate::sheet::Entry;
use plumbline::model::catalog::Offset;
use serde::Serialize;

/// The offset of the mounting.
#[derive(Clone, Debug, Serialize)]
pub struct Aligned {
    /// Each angle.
    pub angles: Vec<Angle>,
    /// The offsets that were written.
    pub offsets: Values,
    /// What has stored them.
    #[serde(skip)]
    pub stored: Option<Done>,
}

/// An angle in both directions, in degrees.
#[derive(Clone, Debug, Serialize)]
pub struct Angle {
    /// Its name.
    pub name: String,
    /// Before the turn.
    pub first: f64,
    /// After the turn.
    pub turned: f64,
    /// The larger spread of both measurements.
    pub spread: f64,
    /// The offset of the mounting.
    pub mounting: f64,
    /// The inclination of the surface.
    pub surface: f64,
}

impl Angle {
    fn new(name: String, first: Rest, turned: Rest) -> Self {
        let (mounting, surface) = reversal(first.angle, turned.angle);
        Self {
            name,
            first: thousandths(first.angle),
            turned: thousandths(turned.angle),
            spread: thousandths(first.spread.max(turned.spread)),
            mounting: thousandths(mounting),
            surface: thousandths(surface),
        }
    }

    fn line(&self) -> String {
        self.shown().to_string()
    }

    fn shown(&self) -> question::Angle {
        question::Angle::Both {
            name: self.name.clone(),
            first: self.first,
            turned: self.turned,
            spread: self.spread,
            mounting: self.mounting,
            surface: self.surface,
        }
    }
}

impl Aligned {
    /// For people.
    pub fn lines(&self) -> Vec<String> {
        let mut lines: Vec<String> = self.angles.iter().map(Angle::line).collect();
        lines.extend(self.offsets.lines());
        lines.extend(self.stored.as_ref().map(Done::to_string));
        lines
    }
}

/// What was measured. The page ends at a question, and goes on from here after the answer.
#[derive(Debug, Default)]
pub(crate) struct Measured {
    first: Option<Vec<Rest>>,
    turned: Option<Vec<Rest>>,
}

/// An angle with its offset.
struct Axis {
    angle: Entry,
    offset: Offset,
}

/// Measures the offset of the mounting and writes it as zero. Nothing is written before the last question.
pub(crate) fn align(
    session: &mut Session,
    found: &Found,
    (measured, save): (&mut Measured, bool),
    terminal: &mut Terminal,
) -> Result<Aligned, Error> {
    if session.sheet.data_sheet.is_some() {
        return Err(RequestError::NotDescribed.into());
    }
    let axes = axes(session)?;
    let first = at_rest(session, &axes, &mut measured.first, terminal)?;
    let angles = shown(&axes, &first);
    if !terminal.ask(&Question::Turn { angles })? {
        let sensor = found.about(session.link.rate()).to_string();
        return Err(RequestError::NotTurned(sensor).into());
    }
    let turned = at_rest(session, &axes, &mut measured.turned, terminal)?;
    let both = first.iter().zip(&turned).zip(&axes);
    let angles: Vec<Angle> = both
        .map(|((first, turned), axis)| Angle::new(axis.angle.name.clone(), *first, *turned))
        .collect();
    let mut values = set::Checked::new();
    for (axis, angle) in axes.iter().zip(&angles) {
        values.extend(offset(session, axis, angle.mounting)?);
    }
    confirm(session, found, &angles, terminal)?;
    set::write(session, &values)?;
    let mut offsets = Values::default();
    for (entry, _) in &values {
        offsets.0.push(get::show(session, entry)?);
    }
    let stored = match save {
        true => Some(session.save()?),
        false => None,
    };
    if !save && set::is_saved_on_command(session.sheet.product) {
        terminal.note(&Note::NotStored);
    }
    Ok(Aligned {
        angles,
        offsets,
        stored,
    })
}

/// The angles at rest, which are measured once.
fn at_rest(
    session: &mut Session,
    axes: &[Axis],
    measured: &mut Option<Vec<Rest>>,
    terminal: &mut Terminal,
) -> Result<Vec<Rest>, Error> {
    if let Some(rest) = measured {
        return Ok(rest.clone());
    }
    let mut sampler = Sampler::new(session)?;
    let angles: Vec<Entry> = axes.iter().map(|axis| axis.angle.clone()).collect();
    let rest = rest::wait(session, &mut sampler, &angles, terminal)?;
    *measured = Some(rest.clone());
    Ok(rest)
}

/// The angles of the sensor with their offsets.
fn axes(session: &mut Session) -> Result<Vec<Axis>, Error> {
    let product = session.sheet.product;
    let mut axes = Vec::new();
    for adjustment in chosen(session, What::Zero, None)? {
        let none = RequestError::NoOffset(product.name);
        let offset = adjustment.offset.ok_or(none)?;
        let angle = session.sheet.value(offset.angle).cloned();
        let angle = angle.ok_or(RequestError::NoOffset(product.name))?;
        axes.push(Axis { angle, offset });
    }
    Ok(axes)
}

/// The angles in a question.
fn shown(axes: &[Axis], rest: &[Rest]) -> AtRest {
    let both = axes.iter().zip(rest);
    let shown = both.map(|(axis, rest)| question::Angle::First {
        name: axis.angle.name.clone(),
        angle: thousandths(rest.angle),
        spread: thousandths(rest.spread),
    });
    AtRest(shown.collect())
}

/// The writes that subtract the mounting from an angle.
fn offset(session: &mut Session, axis: &Axis, mounting: f64) -> Result<set::Checked, Error> {
    let entry = session.entry(axis.offset.parameter)?;
    let scale = session.scale_of(&entry)?;
    let step = degrees(&scale, 1);
    let mut number = entry.data_type.value(session.read(&entry)?);
    let mut switched = None;
    if let Some(switch) = axis.offset.switch {
        let switching = session.entry(switch.parameter)?;
        let bits = session.read(&switching)?;
        if bits & switch.bits != switch.bits {
            // Neither offset acts yet, and both do after the write.
            let other = session.entry(switch.other)?;
            number = -other.data_type.value(session.read(&other)?);
            switched = Some((switching, bits | switch.bits));
        }
    }
    let wanted = number as f64 * step - mounting;
    let number = (wanted / step).round() as i64;
    let turned = (wrapped(wanted) / step).round() as i64;
    let turn = (360.0 / step).round() as i64;
    // An offset of a full turn can be permitted as a number of 0 to 360 deg only.
    let numbers = [number, turned, turned + turn];
    let accepted = numbers.map(|number| entry.accept(&format!("raw:{number}"), &scale));
    let [first, ..] = &accepted;
    let failure = first.clone();
    let number = accepted.into_iter().find_map(Result::ok);
    let number = number.map_or(failure, Ok)?;
    Ok([(entry, number)].into_iter().chain(switched).collect())
}

/// Asks whether the offset of the mounting becomes zero.
fn confirm(
    session: &Session,
    found: &Found,
    angles: &[Angle],
    terminal: &mut Terminal,
) -> Result<(), Error> {
    let sensor = found.about(session.link.rate()).to_string();
    let question = Question::Align {
        sensor: sensor.clone(),
        angles: AtRest(angles.iter().map(Angle::shown).collect()),
    };
    match terminal.ask(&question)? {
        true => Ok(()),
        false => Err(RequestError::NotConfirmed(sensor, Name::Zero.to_string()).into()),
    }
}

/// The offset of the mounting and the inclination of the surface, of the angle in one direction and that after a turn by 180 deg about the
/// vertical axis. The turn inverts the sign of the inclination only.
fn reversal(first: f64, turned: f64) -> (f64, f64) {
    let surface = wrapped(first - turned) / 2.0;
    (wrapped(first - surface), surface)
}

#[cfg(test)]
mod tests {
    use super::*;

    const TURN: f64 = 360.0;

    #[test]
    fn reversal_separates_mounting_and_surface() {
        for (mounting, surface) in [
            (0.0, 0.0),
            (1.5, 0.25),
            (-3.0, -10.0),
            (179.5, 2.0),
            (-0.5, 30.0),
        ] {
            let (own, inclination) = reversal(
                (mounting + surface + TURN) % TURN,
                (mounting - surface + TURN) % TURN,
            );
            assert!((own - mounting).abs() < 1e-9, "{mounting} {surface}: {own}");
            assert!((inclination - surface).abs() < 1e-9, "{inclination}");
        }
    }

    #[test]
    fn spread_of_an_angle_is_the_larger_one_of_both_measurements() {
        for spreads in [(0.01, 0.02), (0.02, 0.01)] {
            let [first, turned] = [spreads.0, spreads.1].map(|spread| Rest { angle: 1.0, spread });
            let angle = Angle::new("angle".to_owned(), first, turned);
            assert_eq!(angle.spread, 0.02, "{spreads:?}");
        }
    }
}
