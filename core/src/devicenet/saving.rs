//! Stored parameters: each accepted change is stored within a second. Changes that follow each other are stored together.

use crate::application::Application;
use crate::node::Context;
use crate::param::{ParameterRow, Parameters};
use crate::time::{Deadline, Duration, Instant, millis};

/// The time from the first change to the save.
const COLLECTS: Duration = millis(300);

/// The number of attempts to save a change.
const ATTEMPTS: u8 = 3;

/// The contents of the nonvolatile memory.
pub(super) struct Saving<A: Application> {
    saved: Parameters<A::Table>,
    /// The contents are damaged: they differ from all parameters.
    unusable: bool,
    due: Deadline,
    /// The number of saves that have failed since the last successful one.
    failed: u8,
    /// The memory was damaged at the start, or the last save has failed.
    faulted: bool,
}

impl<A: Application> Saving<A> {
    /// The state before the stored parameters are read.
    pub const INITIAL: Self = Self {
        saved: Parameters::INITIAL,
        unusable: false,
        due: Deadline::NEVER,
        failed: 0,
        faulted: false,
    };

    /// Takes the stored parameters. `damaged`: the stored record is damaged or not usable.
    pub fn start(&mut self, parameters: &Parameters<A::Table>, damaged: bool) {
        self.saved = *parameters;
        self.unusable = damaged;
        self.faulted = damaged;
    }

    /// Whether the memory is damaged.
    pub fn is_faulted(&self) -> bool {
        self.faulted
    }

    /// Handles an accepted write of a parameter.
    pub fn changed(&mut self, now: Instant) {
        self.failed = 0;
        if !self.due.is_set() {
            self.due = Deadline::after(now, COLLECTS);
        }
    }

    /// Whether stored parameters have other values than in the memory.
    fn has_changes(&self, parameters: &Parameters<A::Table>) -> bool {
        if self.unusable {
            return true;
        }
        Parameters::<A::Table>::rows()
            .filter(|(_, row)| ParameterRow::is_stored(*row))
            .any(|(id, _)| parameters.get(id) != self.saved.get(id))
    }

    /// Begins a save if it is due.
    pub fn poll(&mut self, cx: &mut Context<A>, now: Instant) {
        if self.due.is_reached(now) {
            self.save(cx);
        }
    }

    /// Begins a save if there are changes. Returns false if there is nothing to wait for.
    pub fn save(&mut self, cx: &mut Context<A>) -> bool {
        if cx.is_saving() {
            return true;
        }
        self.due = Deadline::NEVER;
        let saves = self.failed < ATTEMPTS && self.has_changes(&cx.parameters);
        if saves {
            let parameters = cx.parameters;
            cx.save(parameters);
        }
        saves
    }

    /// Handles the end of a save.
    pub fn stored(&mut self, now: Instant, saved: &Parameters<A::Table>, succeeded: bool) {
        self.faulted = !succeeded;
        if succeeded {
            self.saved = *saved;
            self.unusable = false;
            self.failed = 0;
        } else {
            self.failed = self.failed.saturating_add(1);
            if !self.due.is_set() {
                self.due = Deadline::after(now, COLLECTS);
            }
        }
    }

    /// The time of the next save. A save that waits for the running one has none.
    pub fn deadline(&self, cx: &Context<A>) -> Deadline {
        if cx.is_saving() {
            return Deadline::NEVER;
        }
        self.due
    }
}
