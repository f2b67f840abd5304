//! The LEDs while a master configures the node, and without a node-ID: both flicker, green and red in turn (CiA 303-3).

use crate::node::Pattern;
use crate::time::{Deadline, Duration, Instant, millis};

/// Half of the period of a flickering LED: the red one begins to flicker by this time after the green one.
const HALF: Duration = millis(50);

/// The stage of the LEDs. They begin dark, so that a restart also brings them in turn.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Stage {
    /// The LEDs show the state of the node.
    Off,
    Dark,
    Green,
    Both,
}

/// The start of the flickering LEDs.
#[derive(Clone, Copy, Debug)]
pub(super) struct Flicker {
    stage: Stage,
    due: Deadline,
}

impl Flicker {
    /// The LEDs show the state of the node.
    pub const OFF: Self = Self {
        stage: Stage::Off,
        due: Deadline::NEVER,
    };

    /// Begins or ends to flicker.
    pub fn set(&mut self, now: Instant, flickers: bool) {
        if !flickers {
            *self = Self::OFF;
        } else if self.stage == Stage::Off {
            self.enter(now, Stage::Dark);
        }
    }

    /// Begins again if the LEDs flicker.
    pub fn restart(&mut self, now: Instant) {
        if self.stage != Stage::Off {
            self.enter(now, Stage::Dark);
        }
    }

    fn enter(&mut self, now: Instant, stage: Stage) {
        self.stage = stage;
        self.due = Deadline::after(now, HALF);
    }

    /// Returns true if the patterns have changed.
    pub fn poll(&mut self, now: Instant) -> bool {
        if !self.due.is_reached(now) {
            return false;
        }
        if self.stage == Stage::Dark {
            self.enter(now, Stage::Green);
        } else {
            self.stage = Stage::Both;
            self.due = Deadline::NEVER;
        }
        true
    }

    /// The patterns of the green and the red LED; None if they show the state of the node.
    pub fn patterns(&self) -> Option<(Pattern, Pattern)> {
        match self.stage {
            Stage::Off => None,
            Stage::Dark => Some((Pattern::Off, Pattern::Off)),
            Stage::Green => Some((Pattern::Flickering, Pattern::Off)),
            Stage::Both => Some((Pattern::Flickering, Pattern::Flickering)),
        }
    }

    /// The time of the next change.
    pub fn deadline(&self) -> Deadline {
        self.due
    }
}
