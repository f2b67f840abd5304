//! `align`: the offset of the mounting, by the reversal. The sensor is read at rest, turned by 180 deg about the vertical axis, and read
//! again. The turn inverts the inclination of the surface and keeps the offset of the mounting, so the mean of both angles is the offset.

pub(crate) mod rest;

use super::adjust::{What, chosen};
use super::report::{Done, Values};
use super::{get, set};
use crate::error::{Error, RequestError, SensorError, Silence};
use crate::identify::Found;
use crate::note::{Note, Step};
use crate::number::Scale;
use crate::output::Terminal;
use crate::question::{Change, Name, Question};
use crate::sample::{Sample, Sampler};
use crate::session::Session;
use crate::sheet::Entry;
use plumbline::model::catalog::Offset;
use plumbline::time::{Duration, after, millis};
use rest::{PERIOD, Rest, Window, reversal, wrapped};
use serde::Serialize;

/// The longest wait for rest.
const LONGEST: Duration = millis(60_000);

/// The longest time without an answer.
const SILENT: Duration = millis(3000);

/// The pause between two notes about the motion.
const TOLD: Duration = millis(5000);

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
        let Self {
            name,
            first,
            turned,
            spread,
            mounting,
            surface,
        } = self;
        format!(
            "{name}  {first:.2} deg, turned {turned:.2} deg, spread {spread:.2} deg; mounting {mounting:.2} deg, surface {surface:.2} deg"
        )
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

fn thousandths(degrees: f64) -> f64 {
    // Adds 0, so that -0 becomes 0.
    (degrees * 1e3).round() / 1e3 + 0.0
}

/// An angle with its offset.
struct Axis {
    angle: Entry,
    scale: Scale,
    offset: Offset,
}

impl Axis {
    /// A step of the number, in degrees.
    fn step(&self) -> f64 {
        degrees(&self.scale, 1)
    }
}

fn degrees(scale: &Scale, number: i64) -> f64 {
    number as f64 * scale.multiplier as f64 / 10_f64.powi(scale.decimals.into())
}

/// Measures the offset of the mounting and writes it as zero. Nothing is written before the last question.
pub(crate) fn align(
    session: &mut Session,
    found: &Found,
    save: bool,
    terminal: &mut Terminal,
) -> Result<Aligned, Error> {
    if session.sheet.data_sheet.is_some() {
        return Err(RequestError::NotDescribed.into());
    }
    let axes = axes(session)?;
    let mut sampler = Sampler::new(session)?;
    let first = at_rest(session, &mut sampler, &axes, terminal)?;
    if !terminal.ask(&Question::Turn(shown(&axes, &first)))? {
        let sensor = found.about(session.link.rate()).to_string();
        return Err(RequestError::NotTurned(sensor).into());
    }
    let turned = at_rest(session, &mut sampler, &axes, terminal)?;
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

/// The angles of the sensor with their offsets.
fn axes(session: &mut Session) -> Result<Vec<Axis>, Error> {
    let product = session.sheet.product;
    let mut axes = Vec::new();
    for adjustment in chosen(session, What::Zero, product.guide.zero, None)? {
        let none = RequestError::NoOffset(product.name);
        let offset = adjustment.offset.ok_or(none)?;
        let angle = session.sheet.value(offset.angle).cloned();
        let angle = angle.ok_or(RequestError::NoOffset(product.name))?;
        let scale = session.scale_of(&angle)?;
        axes.push(Axis {
            angle,
            scale,
            offset,
        });
    }
    Ok(axes)
}

/// Waits until all angles are at rest, and measures them.
fn at_rest(
    session: &mut Session,
    sampler: &mut Sampler,
    axes: &[Axis],
    terminal: &mut Terminal,
) -> Result<Vec<Rest>, Error> {
    let entries = sampler.entries();
    let place = |axis: &Axis| {
        entries
            .iter()
            .position(|own| own.origin == axis.angle.origin)
    };
    let every = millis(PERIOD);
    let end = after(session.link.now(), LONGEST);
    let mut next = after(session.link.now(), TOLD);
    let mut window = Window::default();
    let mut spread = None;
    loop {
        match sampler.poll(session, every)? {
            Some(sample) => {
                let angles = axes
                    .iter()
                    .map(|axis| angle(&sample, place(axis), &axis.scale));
                match angles.collect() {
                    Some(angles) => window.push(angles),
                    None => window.clear(),
                }
            }
            None => window.clear(),
        }
        if let Some(rest) = window.rest() {
            let largest = rest.iter().map(|rest| rest.spread).fold(0.0, f64::max);
            spread = Some(largest);
            let mut quiet = rest.iter().zip(axes);
            if quiet.all(|(rest, axis)| rest.is_quiet(axis.step())) {
                return Ok(rest);
            }
        }
        let now = session.link.now();
        let silence = sampler.silence(now);
        if silence >= SILENT {
            return Err(Silence::Seconds(silence.to_secs()).into());
        }
        if now >= end {
            return Err(match spread {
                Some(spread) => SensorError::NotAtRest(thousandths(spread)).into(),
                None => SensorError::NoValidAngle.into(),
            });
        }
        if now >= next {
            next = after(now, TOLD);
            terminal.note(&spread.map_or(Step::NoAngleYet, |own| Step::Moves(thousandths(own))));
        }
        if !sampler.wait(session, every, &*terminal.stopped)? {
            return Err(crate::link::stopped());
        }
    }
}

fn angle(sample: &Sample, place: Option<usize>, scale: &Scale) -> Option<f64> {
    let number = sample.numbers.get(place?)?;
    number.map(|number| degrees(scale, number))
}

/// The angles in a question.
fn shown(axes: &[Axis], rest: &[Rest]) -> String {
    let shown = axes.iter().zip(rest).map(|(axis, Rest { angle, spread })| {
        let name = &axis.angle.name;
        format!("{name}  {angle:.2} deg, spread {spread:.2} deg")
    });
    shown.collect::<Vec<_>>().join("; ")
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
    let lines: Vec<String> = angles.iter().map(Angle::line).collect();
    let question = Question::Change {
        change: Change::Align,
        sensor: sensor.clone(),
        angles: lines.join("; "),
    };
    match terminal.ask(&question)? {
        true => Ok(()),
        false => Err(RequestError::NotConfirmed(sensor, Name::Zero.to_string()).into()),
    }
}
