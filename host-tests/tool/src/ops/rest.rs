//! Waits until the angles of a sensor are at rest, and measures them: from the samples of the last 3 s.

use crate::error::{Error, SensorError, Silence};
use crate::link::stopped;
use crate::note::Step;
use crate::number::Scale;
use crate::output::Terminal;
use crate::sample::{Sample, Sampler};
use crate::session::Session;
use crate::sheet::Entry;
use plumbline::time::{Duration, after, millis};
use std::collections::VecDeque;

/// The longest wait for rest.
const LONGEST: Duration = millis(60_000);

/// The longest time without an answer.
const SILENT: Duration = millis(3000);

/// The pause between two notes about the motion.
const TOLD: Duration = millis(5000);

/// The pause between two samples in ms.
pub const PERIOD: u32 = 50;

/// The samples of a measurement: 3 s.
pub const WINDOW: usize = 60;

/// The samples of a mean of which the spread is made: 0.5 s. A mean has less noise than a sample.
const BLOCK: usize = 10;

/// The largest spread of an angle at rest in degrees, if its number has smaller steps.
const QUIET: f64 = 0.1;

/// The angle of a full turn in degrees.
const TURN: f64 = 360.0;

/// The same angle between -180 and 180 deg.
pub fn wrapped(angle: f64) -> f64 {
    angle - TURN * (angle / TURN).round()
}

/// An angle in the last seconds, in degrees.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Rest {
    /// The mean.
    pub angle: f64,
    /// The difference of the largest and the smallest mean of 0.5 s.
    pub spread: f64,
}

impl Rest {
    /// Whether an angle with steps of this size was at rest.
    pub fn is_quiet(&self, step: f64) -> bool {
        self.spread <= QUIET.max(step)
    }
}

/// The samples of the last seconds.
#[derive(Debug, Default)]
pub struct Window {
    samples: VecDeque<Vec<f64>>,
}

impl Window {
    /// Adds the angles of a sample in degrees; the oldest sample goes if the window is full.
    pub fn push(&mut self, angles: Vec<f64>) {
        if self.samples.len() == WINDOW {
            self.samples.pop_front();
        }
        self.samples.push_back(angles);
    }

    /// Forgets all samples, for example after one without a valid angle.
    pub fn clear(&mut self) {
        self.samples.clear();
    }

    /// Each angle; None: there are too few samples.
    pub fn rest(&self) -> Option<Vec<Rest>> {
        let first = self.samples.front()?;
        if self.samples.len() < WINDOW {
            return None;
        }
        let angles = first.iter().enumerate();
        let rest = angles.map(|(place, first)| {
            // An angle of a full turn can change between 359.99 and 0 deg.
            let samples = self.samples.iter();
            let turned: Vec<f64> = samples.map(|own| wrapped(own[place] - first)).collect();
            let means: Vec<f64> = turned.chunks(BLOCK).map(mean).collect();
            let largest = means.iter().copied().fold(f64::MIN, f64::max);
            let smallest = means.iter().copied().fold(f64::MAX, f64::min);
            Rest {
                angle: first + mean(&turned),
                spread: largest - smallest,
            }
        });
        Some(rest.collect())
    }
}

/// A number in degrees.
pub fn degrees(scale: &Scale, number: i64) -> f64 {
    number as f64 * scale.multiplier as f64 / 10_f64.powi(scale.decimals.into())
}

/// The same angle without more digits than a sensor has.
pub fn thousandths(degrees: f64) -> f64 {
    // Adds 0, so that -0 becomes 0.
    (degrees * 1e3).round() / 1e3 + 0.0
}

/// Why the angles are not measured yet.
enum Missing {
    /// There are too few samples with valid angles.
    Angle,
    /// The sensor reports an error with which they are not valid.
    Defect,
    /// They have this spread in degrees.
    Rest(f64),
}

impl Missing {
    fn step(&self) -> Step {
        match self {
            Self::Angle => Step::NoAngleYet,
            Self::Defect => Step::Defective,
            Self::Rest(spread) => Step::Moves(thousandths(*spread)),
        }
    }

    fn error(&self) -> SensorError {
        match self {
            Self::Angle => SensorError::NoValidAngle,
            Self::Defect => SensorError::Defective,
            Self::Rest(spread) => SensorError::NotAtRest(thousandths(*spread)),
        }
    }
}

/// Waits until these angles are at rest, and measures them.
///
/// # Errors
/// They are never at rest or not valid, nobody answers, the adapter fails, or the user has pressed Ctrl-C.
pub fn wait(
    session: &mut Session,
    sampler: &mut Sampler,
    angles: &[Entry],
    terminal: &mut Terminal,
) -> Result<Vec<Rest>, Error> {
    // The samples of J1939 have another scale than the objects.
    let scales = sampler.angles().to_vec();
    let places = angles.iter().map(|entry| {
        let mut scales = scales.iter().enumerate();
        let found = scales.find(|(_, (own, _))| own.origin == entry.origin)?;
        let (place, (_, scale)) = found;
        Some((place, scale))
    });
    let places: Option<Vec<_>> = places.collect();
    let places = places.ok_or(SensorError::NoValidAngle)?;
    let every = millis(PERIOD);
    let end = after(session.link.now(), LONGEST);
    let mut next = after(session.link.now(), TOLD);
    let mut window = Window::default();
    let mut missing = Missing::Angle;
    loop {
        match sampler.poll(session, every)? {
            Some(sample) if is_spoiled(session, &sample) => {
                missing = Missing::Defect;
                window.clear();
            }
            Some(sample) => {
                let own = places.iter();
                let own = own.map(|(place, scale)| angle(&sample, *place, scale));
                match own.collect() {
                    Some(angles) => window.push(angles),
                    None => window.clear(),
                }
            }
            None => window.clear(),
        }
        if let Some(rest) = window.rest() {
            let mut quiet = rest.iter().zip(&places);
            if !quiet.all(|(rest, (_, scale))| rest.is_quiet(degrees(scale, 1))) {
                let spreads = rest.iter().map(|rest| rest.spread);
                missing = Missing::Rest(spreads.fold(0.0, f64::max));
            } else {
                let target = session.target;
                match target.reports_defect(session) {
                    Ok(false) => return Ok(rest),
                    Ok(true) => missing = Missing::Defect,
                    // It is asked again after another measurement.
                    Err(Error::Silent(_)) => {}
                    Err(failure) => return Err(failure),
                }
                window.clear();
            }
        }
        let now = session.link.now();
        let silence = sampler.silence(now);
        if silence >= SILENT {
            return Err(Silence::Seconds(silence.to_secs()).into());
        }
        if now >= end {
            return Err(missing.error().into());
        }
        if now >= next {
            next = after(now, TOLD);
            terminal.note(&missing.step());
        }
        if !sampler.wait(session, every, &*terminal.stopped)? {
            return Err(stopped());
        }
    }
}

/// Whether the sensor reports with the sample that an angle is not valid.
fn is_spoiled(session: &Session, sample: &Sample) -> bool {
    let product = session.sheet.product;
    let conditions = sample
        .status
        .map(|status| session.target.conditions(product, status));
    conditions.into_iter().flatten().any(|bit| bit.spoils_angle)
}

fn angle(sample: &Sample, place: usize, scale: &Scale) -> Option<f64> {
    let number = sample.numbers.get(place)?;
    number.map(|number| degrees(scale, number))
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len().max(1) as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    fn window(count: usize, sample: impl Fn(usize) -> f64) -> Window {
        let mut window = Window::default();
        for place in 0..count {
            window.push(vec![sample(place)]);
        }
        window
    }

    #[test]
    fn angle_is_at_rest_after_3_seconds_without_motion() {
        assert_eq!(window(WINDOW - 1, |_| 1.0).rest(), None);
        // Noise of 0.2 deg from sample to sample.
        let noisy = window(WINDOW, |place| 1.0 + 0.2 * (place % 2) as f64);
        let rest = noisy.rest().unwrap()[0];
        assert!(rest.is_quiet(0.01), "{rest:?}");
        assert!((rest.angle - 1.1).abs() < 1e-9, "{rest:?}");
        let moved = window(WINDOW, |place| if place < BLOCK { 1.0 } else { 1.2 });
        assert!(!moved.rest().unwrap()[0].is_quiet(0.01));
        // A step of the number is no motion.
        assert!(moved.rest().unwrap()[0].is_quiet(1.0));
        // Old samples do not count.
        let moved = window(
            WINDOW + BLOCK,
            |place| if place < BLOCK { 1.0 } else { 9.0 },
        );
        assert!(moved.rest().unwrap()[0].is_quiet(0.01));
    }

    #[test]
    fn angle_at_the_end_of_a_turn_is_at_rest() {
        let rest = window(WINDOW, |place| if place % 2 == 0 { 359.99 } else { 0.01 });
        let rest = rest.rest().unwrap()[0];
        assert!(rest.is_quiet(0.01), "{rest:?}");
        assert!(wrapped(rest.angle).abs() < 1e-9, "{rest:?}");
    }
}
