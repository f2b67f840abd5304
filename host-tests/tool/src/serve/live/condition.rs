//! What the sensor says about its own state.

use super::{Live, STREAK};
use crate::error::Error;
use crate::serve::events::{Hub, Kind};
use crate::sheet::Address;
use serde_json::{Value, json};
use texts::Kind as Refusal;

/// The object with the error register.
pub(super) const ERROR_REGISTER: Address = Address::Object {
    index: 0x1001,
    sub: 0,
};

/// The bits of the error register (CiA 301, object 1001h), from bit 0.
const ERRORS: [&str; 8] = [
    "generic error",
    "current",
    "voltage",
    "temperature",
    "communication error",
    "device profile error",
    "reserved bit 6",
    "manufacturer-specific error",
];

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
        let bits = ERRORS.iter().enumerate();
        let active = bits.filter(|(place, _)| register >> place & 1 != 0);
        let words = active.map(|(_, name)| json!({"name": name, "error": true}));
        self.show_condition(words.collect(), hub);
        Ok(())
    }
}
