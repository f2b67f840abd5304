//! The interface that leads the user through a calibration: a terminal, or the page of `serve`.

use super::log::Source;
use super::rest::Average;
use crate::output::Terminal;
use host_tests::calibrate::Side;
use std::fmt::{self, Display, Formatter};
use std::path::Path;

/// The number of checks with the same state after which a terminal prints the state again: 10 s.
const TOLD: usize = 20;

/// What happens. As a text, it is the note of a terminal.
#[derive(Clone, Copy, Debug)]
pub enum Step<'a> {
    /// The log is started, and has no measurement yet.
    Waiting {
        /// Where the log comes from.
        source: &'a Source,
    },
    /// The unit in the log.
    Serial(u32),
    /// Nothing is missing at the present temperature.
    Complete,
    /// The user must turn the sensor.
    Place {
        /// The position, 1 to 6.
        place: usize,
        /// The side that must be up.
        side: Side,
    },
    /// A measurement of the last 3 s that cannot be used as a position.
    Measured {
        /// Why it cannot be used.
        state: State,
        /// The means of this time.
        average: Average,
    },
    /// A position is in the file.
    Taken {
        /// The side that is up.
        side: Side,
        /// The file of the measurement.
        path: &'a Path,
    },
}

/// Whether the last 3 s can be taken.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum State {
    /// The measurement can be used as a position.
    Ready,
    /// The sensor moves, so the measurement is no mean at rest.
    Moves,
    /// No side is up: the sensor is inclined.
    NoSide,
    /// Another side is up than that which is asked for.
    OtherSide {
        /// The side that is up.
        up: Side,
        /// The side that must be up.
        side: Side,
    },
    /// The temperature differs from the temperature of the first position.
    TooFar {
        /// The temperature of the first position in degC.
        first: f64,
    },
    /// The temperature is too near to the temperature of an earlier measurement.
    TooNear,
}

impl State {
    /// The name of the state for programs, in documents.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Ready => "ready",
            Self::Moves => "moves",
            Self::NoSide => "no-side",
            Self::OtherSide { .. } => "other-side",
            Self::TooFar { .. } => "too-far",
            Self::TooNear => "too-near",
        }
    }
}

/// A question to the user.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum Question {
    /// Whether a measurement is taken.
    Take {
        /// The side that is up.
        side: Side,
        /// The means of the measurement.
        average: Average,
    },
    /// Whether a position is measured again; no ends the calibration.
    Again {
        /// The side that must be up.
        side: Side,
    },
}

/// The interface that leads the user through the positions.
pub trait Host {
    /// Tells the user what happens.
    fn tell(&mut self, step: &Step);

    /// Asks, and waits for the answer; true means yes.
    fn ask(&mut self, question: &Question) -> bool;

    /// Whether the user has stopped the calibration.
    fn is_stopped(&self) -> bool;
}

/// Leads the user through the positions in a terminal.
pub struct Asks<'a, 'b> {
    terminal: &'a mut Terminal<'b>,
    /// The state that was reported last, and the number of times it was seen since then.
    told: Option<(State, usize)>,
}

impl<'a, 'b> Asks<'a, 'b> {
    /// Leads through a calibration at this terminal.
    pub fn new(terminal: &'a mut Terminal<'b>) -> Self {
        Self {
            terminal,
            told: None,
        }
    }
}

impl Host for Asks<'_, '_> {
    fn tell(&mut self, step: &Step) {
        match (*step, self.told) {
            (Step::Measured { state, .. }, Some((told, looks))) if state == told => {
                self.told = Some((told, looks + 1));
                if (looks + 1) % TOLD != 0 {
                    return;
                }
            }
            (Step::Measured { state, .. }, _) => self.told = Some((state, 0)),
            _ => self.told = None,
        }
        self.terminal.note(step.to_string());
    }

    fn ask(&mut self, question: &Question) -> bool {
        self.told = None;
        (self.terminal.confirm)(&crate::question::Question::Calibrate(*question))
    }

    fn is_stopped(&self) -> bool {
        (self.terminal.stopped)()
    }
}

impl Display for Step<'_> {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        match self {
            Self::Waiting { source } => write!(
                f,
                "waiting for the log of `{source}`; the build of an image takes some minutes"
            ),
            Self::Serial(serial) => write!(f, "serial number {serial}"),
            Self::Complete => f.write_str("the measurement is complete at this temperature"),
            Self::Place { place, side } => write!(
                f,
                "position {place} of 6: place the sensor at rest on a level surface with {side} up"
            ),
            Self::Measured { state, average } => write!(f, "{state}: {average}"),
            Self::Taken { side, path } => write!(f, "{side} is in {}", path.display()),
        }
    }
}

impl Display for State {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        match self {
            Self::Ready => f.write_str("at rest"),
            Self::Moves => f.write_str("it moves"),
            Self::NoSide => f.write_str("no side is up"),
            Self::OtherSide { up, side } => write!(f, "{up} is up, not {side}"),
            Self::TooFar { first } => write!(
                f,
                "too far from {first:.1} degC, the temperature of the first position"
            ),
            Self::TooNear => f.write_str("too near to the temperature of an earlier measurement"),
        }
    }
}

impl Display for Question {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        match self {
            Self::Take { side, average } => {
                write!(
                    f,
                    "{side} is up and at rest: {average}. Take this position?"
                )
            }
            Self::Again { .. } => f.write_str("Measure this position again?"),
        }
    }
}

impl Display for Average {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let [x, y, z] = self.acceleration.map(|value| value * 1e3);
        write!(
            f,
            "x {x:.1} mg, y {y:.1} mg, z {z:.1} mg, spread {:.2} mg in 3 s, {:.2} degC",
            self.spread * 1e3,
            self.temperature
        )
    }
}
