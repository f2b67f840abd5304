//! The virtual sensor of the demonstration, moved and broken by the requests of the control protocol of `virtual-sensor`.

use crate::error::{Error, PageError};
use adapter::bench::SharedBus;
use plumbline::can::Frame;
use plumbline::time::Instant;
use serde_json::{Value, json};
use virtual_sensor::server::{MemoryFault, Passage, Request, Rule, Side, Unit};

/// The sensor, and the faults of its frames.
pub struct StandIn {
    bus: SharedBus,
    unit: Unit,
    memory: Option<MemoryFault>,
    pub(super) from_sensor: Passage,
}

impl StandIn {
    pub(super) fn new(bus: SharedBus, unit: Unit) -> Self {
        Self {
            bus,
            unit,
            memory: None,
            from_sensor: Passage::default(),
        }
    }

    /// The late frames that have arrived.
    pub(super) fn arrived(&mut self) -> Vec<(Instant, Frame)> {
        self.from_sensor.arrived(self.bus.borrow().now())
    }

    /// Performs a request that moves or breaks the sensor.
    ///
    /// # Errors
    /// It is another request, or not possible. Then nothing has changed.
    pub fn perform(&mut self, request: Request) -> Result<(), Error> {
        let refused = |why| Error::from(PageError::StandIn(why));
        let mut memory = self.memory;
        match request {
            Request::Lose {
                count,
                from: Side::Sensors,
                identifier,
            } => {
                let rule = Rule::new(count, identifier.as_deref(), None);
                self.from_sensor.add(rule.map_err(refused)?);
                return Ok(());
            }
            Request::Delay {
                count,
                from: Side::Sensors,
                identifier,
                seconds,
            } => {
                let rule = Rule::new(count, identifier.as_deref(), Some(seconds));
                self.from_sensor.add(rule.map_err(refused)?);
                return Ok(());
            }
            Request::Memory { fault } => memory = fault,
            Request::Tilt { .. }
            | Request::Temperature { .. }
            | Request::Supply { .. }
            | Request::Accelerometer { .. }
            | Request::Power { .. }
            | Request::Restart {}
            | Request::BusOff {}
            | Request::Corrupt { .. } => {}
            _ => return Err(PageError::NotOfStandIn.into()),
        }
        let bus = &mut self.bus.borrow_mut();
        self.unit.perform(bus, request).map_err(refused)?;
        self.memory = memory;
        Ok(())
    }

    /// Its state, for the page.
    pub fn state(&self) -> Value {
        let state = self
            .unit
            .perform(&mut self.bus.borrow_mut(), Request::State {});
        let state = state.unwrap_or_default();
        json!({
            "x": state["scene"][0],
            "y": state["scene"][1],
            "temperature": state["temperature"],
            "supply": state["supply"],
            "fault": state["fault"],
            "memory": self.memory.is_some(),
            "on": state["on"],
        })
    }
}
