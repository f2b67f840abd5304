//! The interface that leads the user through a calibration: a terminal, or the page of `serve`.

use super::rest::Average;
use crate::output::Terminal;
use host_tests::calibrate::Side;
use std::fmt::{self, Display, Formatter};
use texts::{same, texts};

/// A side of the sensor, in a text.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Up(pub Side);

impl Display for Up {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}

same! { Up Average }

/// The number of checks with the same state after which a terminal prints the state again: 10 s.
const TOLD: usize = 20;

texts! {
    /// What happens. As a text, it is the note of a terminal.
    Step {
        Waiting(log: String) = "waiting for the log of `{log}`; the build of an image takes some minutes",
            "wartet auf das Protokoll von `{log}`; der Bau eines Images dauert einige Minuten";
        Serial(serial: u32) = "serial number {serial}", "Seriennummer {serial}";
        Complete = "the measurement is complete at this temperature", "die Messung ist bei dieser Temperatur vollständig";
        Place(place: usize, side: Up) = "position {place} of 6: place the sensor at rest on a level surface with {side} up",
            "Lage {place} von 6: Legen Sie den Sensor ruhig auf eine waagrechte Fläche, {side} nach oben";
        Measured(state: State, average: Average) = "{state}: {average}", "{state}: {average}";
        Taken(side: Up, path: String) = "{side} is in {path}", "{side} ist in {path}";
    }
}

texts! {
    /// Whether the last 3 s can be taken.
    #[derive(Copy)]
    State {
        Ready = "at rest", "in Ruhe";
        Moves = "it moves", "er bewegt sich";
        NoSide = "no side is up", "keine Seite ist oben";
        OtherSide(up: Up, side: Up) = "{up} is up, not {side}", "{up} ist oben, nicht {side}";
        TooFar(first: f64) = "too far from {first:.1} degC, the temperature of the first position",
            "zu weit weg von {first:.1} degC, der Temperatur der ersten Lage";
        TooNear = "too near to the temperature of an earlier measurement", "zu nah an der Temperatur einer früheren Messung";
    }
}

impl State {
    /// The name of the state for programs, in documents.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Ready => "ready",
            Self::Moves => "moves",
            Self::NoSide => "no-side",
            Self::OtherSide(..) => "other-side",
            Self::TooFar(_) => "too-far",
            Self::TooNear => "too-near",
        }
    }
}

texts! {
    /// A question to the user. A no to the second one ends the calibration.
    #[derive(Copy)]
    Question {
        Take(side: Up, average: Average) = "{side} is up and at rest: {average}. Take this position?",
            "{side} ist oben und in Ruhe: {average}. Diese Lage nehmen?";
        Again = "Measure this position again?", "Diese Lage noch einmal messen?";
    }
}

/// The interface that leads the user through the positions.
pub trait Host {
    /// Tells the user what happens.
    fn report(&mut self, step: &Step);

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
    fn report(&mut self, step: &Step) {
        match (step, self.told) {
            (Step::Measured(state, _), Some((told, looks))) if *state == told => {
                self.told = Some((told, looks + 1));
                if (looks + 1) % TOLD != 0 {
                    return;
                }
            }
            (Step::Measured(state, _), _) => self.told = Some((*state, 0)),
            _ => self.told = None,
        }
        self.terminal.note(step);
    }

    fn ask(&mut self, question: &Question) -> bool {
        self.told = None;
        (self.terminal.confirm)(&crate::question::Question::Calibrate(*question))
    }

    fn is_stopped(&self) -> bool {
        (self.terminal.stopped)()
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
