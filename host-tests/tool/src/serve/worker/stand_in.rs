//! The virtual sensor of a demonstration, which the user moves and breaks.

use super::Worker;
use crate::demo::StandIn;
use crate::error::{Error, PageError};
use crate::serve::events::Kind;
use serde_json::{Value, json};
use virtual_sensor::server::Request;

impl Worker {
    /// Moves or breaks the virtual sensor.
    pub(super) fn stand_in(&mut self, request: Request) -> Result<Value, Error> {
        let port = self.port.as_ref();
        let done = port.and_then(|(_, lease)| lease.with_stand_in(|own| own.perform(request)));
        done.ok_or(PageError::NoStandIn)??;
        self.show_stand_in();
        Ok(json!({}))
    }

    /// Shows the virtual sensor; or that there is none.
    pub(super) fn show_stand_in(&self) {
        let port = self.port.as_ref();
        let state = port.and_then(|(_, lease)| lease.with_stand_in(|own| StandIn::state(own)));
        self.hub.publish(Kind::StandIn, &json!(state));
    }
}
