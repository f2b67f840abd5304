//! What a node makes of the stored parameters at its start.

use super::Context;
use crate::application::Application;
use crate::param::Parameters;
use crate::store::Boot;

impl<A: Application> Context<A> {
    /// Takes the stored parameters over; those that were not stored, and all of them when the record cannot be used, have their
    /// factory values. True when there was something that could not be used.
    pub(super) fn restore(&mut self, boot: &Boot) -> bool {
        self.parameters = Parameters::factory();
        let Some(stored) = boot.parameters else {
            return boot.damaged;
        };
        let restored = self.parameters.restore(stored);
        let usable = restored.is_some() && A::is_consistent(&self.parameters);
        if !usable {
            self.parameters = Parameters::factory();
        }
        boot.damaged || !usable
    }
}
