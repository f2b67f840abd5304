//! The measuring half of a node.

use super::Indicator;
use super::communication::Task;
use crate::application::Application;
use crate::measure::Reading;
use crate::measure::self_test::Working;
use crate::time::{Deadline, Instant};

/// The measuring half of a node: the application. Its calculations take long, and it does not access the communicating half: a
/// driver publishes the returned values with [`Communication::publish`](super::Communication::publish).
pub struct Acquisition<A> {
    application: A,
    pub(super) indicator: Indicator,
}

impl<A: Application> Acquisition<A> {
    pub(super) const INITIAL: Self = Self {
        application: A::INITIAL,
        indicator: Indicator::DARK,
    };

    pub(super) fn application(&mut self) -> &mut A {
        &mut self.application
    }

    /// Processes a reading. Returns the new values, for [`Communication`](super::Communication).
    pub fn sample(&mut self, now: Instant, reading: &Reading) -> A::Values {
        self.application.sample(now, reading)
    }

    /// Handles a gap before the next reading.
    pub fn interrupt(&mut self) {
        self.application.interrupt();
    }

    /// Performs a task that the communicating half requests.
    pub fn perform(&mut self, now: Instant, task: &Task<A>) -> A::Values {
        match task {
            Task::Apply(parameters) => self.application.apply(now, parameters),
            Task::Stale => self.application.stale(),
        }
    }

    /// Performs the action of the deadline of the application if it is reached.
    pub fn tick(&mut self, now: Instant) -> Option<A::Values> {
        let due = self.application.deadline().is_reached(now);
        due.then(|| self.application.tick(now))
    }

    /// Handles the result of the self-test of the accelerometer. Returns None if no value has changed.
    pub fn tested(&mut self, result: Working) -> Option<A::Values> {
        if !A::HAS_SELF_TEST {
            return None;
        }
        self.application.tested(result)
    }

    /// Handles a measurement of the supply voltage in mV. Returns None if no value has changed.
    pub fn supply(&mut self, millivolts: u16) -> Option<A::Values> {
        if !A::MEASURES_SUPPLY {
            return None;
        }
        self.application.supply(millivolts)
    }

    /// The state to keep over the restart that [`Action::Restart`](super::Action::Restart) requests, for
    /// [`Boot::kept`](super::Boot::kept).
    pub fn kept(&self) -> u32 {
        self.application.kept()
    }

    /// The time at which [`tick`](Self::tick) is due.
    pub fn deadline(&self) -> Deadline {
        self.application.deadline()
    }
}
