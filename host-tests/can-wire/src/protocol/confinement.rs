//! Fault confinement: the error counters and the states derived from them (ISO 11898-1, fault confinement).

use plumbline::node::BusState;

/// The warning limit of a counter.
const WARNING: u16 = 96;

/// At this value of a counter a controller is error passive.
const PASSIVE: u16 = 128;

/// The highest value of the transmit error counter; above it is bus-off.
const TRANSMIT_MAX: u16 = 255;

/// The highest value of the receive error counter.
const RECEIVE_MAX: u16 = 255;

/// The value of a receive error counter above 127 after a success; the standard permits 119 to 127.
const AFTER_SUCCESS: u16 = 120;

/// The increment for a serious error.
const SERIOUS: u16 = 8;

/// The role of the controller whose error counter changes.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Role {
    Transmitter,
    Receiver,
}

/// The error counters of a controller.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub(super) struct Confinement {
    transmit: u16,
    receive: u16,
    bus_off: bool,
}

impl Confinement {
    /// An error that counts 8 for a transmitter and 1 for a receiver.
    pub(super) fn error(&mut self, role: Role) {
        match role {
            Role::Transmitter => self.serious_error(role),
            Role::Receiver => self.receive = (self.receive + 1).min(RECEIVE_MAX),
        }
    }

    /// An error that counts 8 for every controller.
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
