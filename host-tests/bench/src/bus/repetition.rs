//! Skips the attempts of a sensor that is alone on the wire and repeats a frame without acknowledge.

use super::{Bus, DeviceId};
use can_wire::protocol::{Picoseconds, Protocol};

/// The attempts to send a frame that no other node acknowledges.
#[derive(Debug, Default)]
pub(super) struct Attempts {
    /// The sensor whose attempt has just failed.
    pub(super) failed: Option<DeviceId>,
    /// The sensor of the attempt before, and its controller after it.
    last: Option<(DeviceId, Protocol)>,
}

impl Bus {
    /// After an attempt without acknowledge: skips the further attempts up to `end` if they are all alike. They are only skipped up
    /// to the next event beside the wire, so that the sensor misses nothing.
    pub(super) fn skip_attempts(&mut self, end: Picoseconds) {
        let Some(id) = self.attempts.failed.take() else {
            return;
        };
        let limit = self.next_beside().unwrap_or(end).min(end);
        let last = self.attempts.last.take();
        if !self.is_alone(id) {
            return;
        }
        let sensor = &mut self.devices[id.0].sensor;
        let Some(state) = sensor.protocol() else {
            return;
        };
        if let Some((before, earlier)) = last
            && before == id
            && let Some(period) = state.period_since(&earlier)
        {
            let count = limit.saturating_sub(self.time + 1) / period.time;
            sensor.skip(period, count);
        }
        self.attempts.last = sensor.protocol().map(|state| (id, state.clone()));
    }

    /// True when nothing else changes the level of the wire.
    fn is_alone(&self, id: DeviceId) -> bool {
        let others = self.devices.iter().enumerate();
        let mut others = others.filter(|(place, _)| *place != id.0);
        let is_on = |one: Option<&Protocol>| one.is_some_and(Protocol::is_on);
        let assistant = &self.assistant.0;
        !others.any(|(_, one)| is_on(one.sensor.protocol()))
            && !self.adapters.values().any(|(one, _)| one.protocol.is_on())
            && !assistant.is_on()
            && self.disturbances.is_empty()
            && self.devices[id.0].line.next_event(self.time).is_none()
            && !self.wishes.is_pending()
    }
}
