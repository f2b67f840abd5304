//! How a controller signals an error or an overload: flags, error counters and bus-off (ISO 11898-1, fault confinement).

use super::confinement::Role;
use super::machine::{FLAG, Flag, Phase};
use super::{ErrorCode, Event, Protocol};

/// Every further sequence of this many dominant bits after a flag counts as one more error.
const STUCK: u8 = 8;

/// The increment of the error counter for an error.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Cost {
    Nothing,
    /// 8 for a transmitter, 1 for a receiver.
    Usual,
    /// 8 for a transmitter and for a receiver.
    Serious,
}

impl Protocol {
    pub(super) fn wait_for_six(
        &mut self,
        dominant: bool,
        equal: u8,
        unacknowledged: bool,
    ) -> Option<Event> {
        if dominant && unacknowledged {
            self.confinement.serious_error(self.role());
            if self.confinement.is_bus_off() {
                return self.go_bus_off(ErrorCode::Acknowledgment);
            }
        }
        self.go(if equal == FLAG {
            Phase::OthersFlags {
                kind: Flag::Error,
                dominant: 0,
            }
        } else {
            Phase::PassiveFlag {
                equal,
                dominant,
                unacknowledged: unacknowledged && !dominant,
            }
        })
    }

    /// A dominant bit after its own flag; `before` such bits came before it.
    pub(super) fn outlast(&mut self, kind: Flag, before: u8) -> Option<Event> {
        let role = self.role();
        if before == 0 && kind == Flag::Error && role == Role::Receiver {
            self.confinement.serious_error(role);
        }
        let stuck = before + 1 == STUCK;
        self.phase = Phase::OthersFlags {
            kind,
            // After the first eight, zero would mean the first bit after the flag.
            dominant: if before + 1 == 2 * STUCK {
                STUCK
            } else {
                before + 1
            },
        };
        if !stuck && before + 1 != 2 * STUCK {
            return None;
        }
        self.confinement.serious_error(role);
        if self.confinement.is_bus_off() {
            return self.go_bus_off(ErrorCode::Form);
        }
        Some(Event::Error {
            code: ErrorCode::Form,
            transmitting: self.transmitter,
        })
    }

    pub(super) fn overload(&mut self) -> Option<Event> {
        self.go(Phase::ActiveFlag {
            kind: Flag::Overload,
            sent: 0,
        })
    }

    /// An error with the usual count.
    pub(super) fn fail(&mut self, code: ErrorCode) -> Option<Event> {
        self.raise_flag(code, Cost::Usual)
    }

    /// Starts an error flag. An error that makes the controller error passive still gets an active flag.
    pub(super) fn raise_flag(&mut self, code: ErrorCode, cost: Cost) -> Option<Event> {
        let (passive, role) = (self.confinement.is_passive(), self.role());
        let unacknowledged = passive && code == ErrorCode::Acknowledgment;
        match cost {
            Cost::Usual if !unacknowledged => self.confinement.error(role),
            Cost::Serious => self.confinement.serious_error(role),
            Cost::Usual | Cost::Nothing => {}
        }
        if self.confinement.is_bus_off() {
            return self.go_bus_off(code);
        }
        self.outgoing = None;
        self.error_flags += 1;
        self.phase = if passive {
            Phase::PassiveFlag {
                equal: 0,
                dominant: false,
                unacknowledged,
            }
        } else {
            Phase::ActiveFlag {
                kind: Flag::Error,
                sent: 0,
            }
        };
        Some(Event::Error {
            code,
            transmitting: self.transmitter,
        })
    }

    fn go_bus_off(&mut self, code: ErrorCode) -> Option<Event> {
        self.outgoing = None;
        self.transmitter = false;
        self.phase = Phase::BusOff {
            sequences: None,
            recessive: 0,
        };
        Some(Event::Error {
            code,
            transmitting: true,
        })
    }
}
