//! Fault confinement: the error counters and what follows from them (ISO 11898-1, fault confinement).

use plumbline::node::BusState;

/// From here on a counter is a warning.
const WARNING: u16 = 96;

/// From here on a controller is error passive.
const PASSIVE: u16 = 128;

/// The highest value of the transmit error counter; above it is bus-off.
const TRANSMIT_MAX: u16 = 255;

/// The receive error counter does not count further.
const RECEIVE_MAX: u16 = 255;

/// What a success leaves of a receive error counter above 127; the standard allows 119 to 127.
const AFTER_SUCCESS: u16 = 120;

/// What a serious error costs.
const SERIOUS: u16 = 8;

/// Whom an error is counted to.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Role {
    Transmitter,
    Receiver,
}

/// The error counters of a controller.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Confinement {
    transmit: u16,
    receive: u16,
    bus_off: bool,
}

impl Confinement {
    /// An error that costs a transmitter 8 and a receiver 1.
    pub(super) fn error(&mut self, role: Role) {
        match role {
            Role::Transmitter => self.serious_error(role),
            Role::Receiver => self.receive = (self.receive + 1).min(RECEIVE_MAX),
        }
    }

    /// An error that costs everybody 8.
    pub(super) fn serious_error(&mut self, role: Role) {
        match role {
            Role::Transmitter => {
                self.transmit += SERIOUS;
                self.bus_off |= self.transmit > TRANSMIT_MAX;
                self.transmit = self.transmit.min(TRANSMIT_MAX);
            }
            Role::Receiver => self.receive = (self.receive + SERIOUS).min(RECEIVE_MAX),
        }
    }

    /// A frame has been sent or received.
    pub(super) fn success(&mut self, role: Role) {
        match role {
            Role::Transmitter => self.transmit = self.transmit.saturating_sub(1),
            Role::Receiver if self.receive >= PASSIVE => self.receive = AFTER_SUCCESS,
            Role::Receiver => self.receive = self.receive.saturating_sub(1),
        }
    }

    pub(super) fn transmit(&self) -> u16 {
        self.transmit
    }

    pub(super) fn receive(&self) -> u16 {
        self.receive
    }

    pub(super) fn is_bus_off(&self) -> bool {
        self.bus_off
    }

    pub(super) fn is_passive(&self) -> bool {
        self.transmit.max(self.receive) >= PASSIVE
    }

    pub(super) fn state(&self) -> BusState {
        match self.transmit.max(self.receive) {
            _ if self.bus_off => BusState::BusOff,
            PASSIVE.. => BusState::Passive,
            WARNING.. => BusState::Warning,
            _ => BusState::Active,
        }
    }
}
