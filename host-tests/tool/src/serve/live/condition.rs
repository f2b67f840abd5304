//! What the sensor says about its own state.

use super::{Live, STREAK};
use crate::error::Error;
use crate::master::canopen::error_register;
use crate::serve::events::{Hub, Kind};
use serde_json::{Value, json};
use texts::Kind as Refusal;

impl Live {
    pub(super) fn show_condition(&mut self, condition: Value, hub: &Hub) {
        if self.is_main && self.condition != condition {
            hub.publish(Kind::Condition, &condition);
            self.condition = condition;
        }
    }

    pub(super) fn read_register(&mut self, hub: &Hub) -> Result<(), Error> {
        let Some(entry) = self.register.clone() else {
            return Ok(());
        };
        let read = self.session.read(&entry);
        if self.sampler.is_none() {
            // Nothing else shows whether the device is there.
            self.streak = match &read {
                Err(failure) if failure.kind() == Refusal::Silent => STREAK,
                _ => 0,
            };
        }
        let register = match read {
            Ok(register) => register,
            Err(failure) if failure.kind() == Refusal::Bus => return Err(failure),
            Err(_) => return Ok(()),
        };
        let active = error_register::names(register);
        let words = active.map(|name| json!({"name": name, "error": true}));
        self.show_condition(words.collect(), hub);
        Ok(())
    }
}
