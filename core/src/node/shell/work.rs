//! The work of a node: the actions that the driver must perform, in their order, and the time of the next one.

use super::{NodeState, Shell, cause};
use crate::application::Outputs;
use crate::node::{Action, Patterns};
use crate::time::{Deadline, Instant, reached};

impl Shell {
    pub(in crate::node) fn begin_save(&mut self) {
        self.save = true;
        self.dirty = true;
    }

    /// True if there is nothing to do.
    pub(in crate::node) fn is_idle(&self, now: Instant) -> bool {
        !self.dirty && !self.new_patterns && !self.wake.is_reached(now)
    }

    /// The patterns of the LEDs, once after each change.
    pub(in crate::node) fn take_patterns(&mut self) -> Option<Patterns> {
        core::mem::take(&mut self.new_patterns).then_some(self.patterns)
    }

    /// Clears the request of [`wake_up`](Self::wake_up).
    pub(in crate::node) fn begin_work(&mut self) {
        self.dirty = false;
    }

    /// The next action in the order of priority, except [`Action::Leds`]. `outputs` are the outputs of the application.
    pub(in crate::node) fn next_action(
        &mut self,
        now: Instant,
        outputs: Option<Outputs>,
    ) -> Option<Action> {
        if self.is_blocked(cause::BUS) {
            self.block(cause::BUS, false);
            let (mode, rate) = self.bus;
            return Some(Action::Bus(mode, rate));
        }
        if core::mem::take(&mut self.recover) {
            return Some(Action::Recover);
        }
        if core::mem::take(&mut self.save) {
            return Some(Action::Save);
        }
        if let Some(outputs) = outputs
            && outputs != self.reported
        {
            return Some(self.report(outputs));
        }
        match self.state {
            NodeState::Restarting(until) if self.queue.is_empty() || reached(now, until) => {
                self.state = NodeState::Restarted;
                Some(Action::Restart)
            }
            _ => None,
        }
    }

    /// Reports one changed output to the hardware.
    fn report(&mut self, outputs: Outputs) -> Action {
        if let Some(connected) = outputs.termination()
            && outputs.termination() != self.reported.termination()
        {
            self.reported = self.reported.with_termination(connected);
            return Action::Termination(connected);
        }
        if let Some(duty) = outputs.heater()
            && outputs.heater() != self.reported.heater()
        {
            self.reported = self.reported.with_heater(duty);
            return Action::Heater(duty);
        }
        self.reported = outputs;
        Action::SelfTest
    }

    /// Whether these outputs were reported to the hardware.
    pub(in crate::node) fn has_reported(&self, outputs: Outputs) -> bool {
        self.reported == outputs
    }

    /// Sets the time of the next work. `earliest` is the next deadline of the protocol.
    pub(in crate::node) fn schedule(&mut self, mut earliest: Deadline) {
        if let NodeState::Restarting(until) = self.state {
            earliest.consider(Deadline::at(until));
        }
        if !self.is_stale && !self.is_leaving() {
            earliest.consider(Deadline::at(self.valid_until));
        }
        self.wake = earliest;
    }

    pub(in crate::node) fn deadline(&self) -> Deadline {
        self.wake
    }
}
