//! Restores the stored parameters at the start of a node.

use super::Context;
use crate::application::Application;
use crate::param::Parameters;
use crate::store::Boot;

impl<A: Application> Context<A> {
    /// Restores the stored parameters. A parameter that was not stored gets its factory value. If the record is not usable, all
    /// parameters get their factory values. Returns true if a record is damaged or not usable.
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
