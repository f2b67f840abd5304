//! The predefined connection set: its owner, the allocated connections, and their time-outs.
//!
//! ```text
//!  choice   80h  40h        20h     10h  08h             04h     02h   01h
//!           -    acknowledge cyclic COS  multicast poll  strobe  poll  explicit
//!                suppressed
//! ```
//!
//! COS and cyclic use the same connection (instance 4). A request is accepted as a whole or refused.

use super::connection::{Connection, State};
use super::explicit::{Failure, MAC};
use crate::time::{Deadline, Instant};

/// Bits of the allocation choice.
pub mod choice {
    /// The explicit connection (instance 1).
    pub const EXPLICIT: u8 = 0x01;
    /// The poll connection (instance 2): I/O data on request of the master.
    pub const POLL: u8 = 0x02;
    /// Instance 4 sends a message when a word has changed, and one in each EPR.
    pub const CHANGE: u8 = 0x10;
    /// Instance 4 sends one message in each EPR.
    pub const CYCLIC: u8 = 0x20;
    /// COS and cyclic messages are not acknowledged.
    pub const SUPPRESS: u8 = 0x40;
    /// The choices that use instance 4.
    pub const PRODUCING: u8 = CHANGE | CYCLIC;
    /// The choices that no product has.
    pub const UNSUPPORTED: u8 = !(EXPLICIT | POLL | PRODUCING | SUPPRESS);
}

use choice::{CYCLIC, EXPLICIT, POLL, PRODUCING, SUPPRESS, UNSUPPORTED};

/// The allocation information of a node without owner (attribute 5 of the DeviceNet object).
const NO_OWNER: u8 = 0xFF;

/// Additional codes of the error responses to allocate and release.
const OTHER_OWNER: u8 = 1;
const CHOICE: u8 = 2;

/// The connections and their owner.
#[derive(Clone, Copy, Debug)]
pub(super) struct ConnectionSet {
    explicit: Connection,
    poll: Connection,
    producing: Connection,
    owner: Option<u8>,
    choice: u8,
    /// The choice with which the producing connection was allocated.
    kind: u8,
    /// The watchdog action of the explicit connection is deferred delete.
    defers: bool,
    /// The I/O connections that have timed out and were neither released nor allocated again, as bits of the choice.
    timed_out: u8,
}

impl ConnectionSet {
    /// The state before the master allocates a connection.
    pub const EMPTY: Self = Self {
        explicit: Connection::NONEXISTENT,
        poll: Connection::NONEXISTENT,
        producing: Connection::NONEXISTENT,
        owner: None,
        choice: 0,
        kind: 0,
        defers: false,
        timed_out: 0,
    };

    /// Allocates connections for a master.
    pub fn allocate(&mut self, now: Instant, choice: u8, master: u8) -> Result<(), Failure> {
        if self.owner.is_some_and(|owner| owner != master) {
            return Err(Failure::STATE.with(OTHER_OWNER));
        }
        if choice == 0 || choice & SUPPRESS != 0 && choice & PRODUCING == 0 {
            return Err(Failure::VALUE.with(CHOICE));
        }
        if choice & UNSUPPORTED != 0 {
            return Err(Failure::RESOURCE.with(CHOICE));
        }
        if choice & PRODUCING == PRODUCING
            || choice & EXPLICIT == 0 && !self.explicit.is_allocated()
            || master & !MAC != 0
        {
            return Err(Failure::VALUE.with(CHOICE));
        }
        let taken = [
            (EXPLICIT, &self.explicit),
            (POLL, &self.poll),
            (PRODUCING, &self.producing),
        ];
        if taken
            .iter()
            .any(|(bits, connection)| choice & bits != 0 && connection.is_allocated())
        {
            return Err(Failure::ALREADY.with(CHOICE));
        }
        if self.owner.is_none() {
            self.timed_out = 0;
        }
        self.owner = Some(master);
        self.choice |= choice;
        self.timed_out &= !choice;
        if choice & EXPLICIT != 0 {
            self.explicit = Connection::explicit(now);
            self.defers = false;
        }
        if choice & POLL != 0 {
            self.poll = Connection::io(true);
        }
        if choice & PRODUCING != 0 {
            self.producing = Connection::io(choice & SUPPRESS == 0);
            self.kind = choice & (PRODUCING | SUPPRESS);
            self.timed_out &= !PRODUCING;
        }
        Ok(())
    }

    /// Releases connections for a master.
    pub fn release(&mut self, master: u8, choice: u8) -> Result<(), Failure> {
        if self.owner.is_some_and(|owner| owner != master) {
            return Err(Failure::STATE.with(OTHER_OWNER));
        }
        let choice = choice & !SUPPRESS;
        if choice == 0 {
            return Err(Failure::VALUE.with(CHOICE));
        }
        if choice & UNSUPPORTED != 0 {
            return Err(Failure::RESOURCE.with(CHOICE));
        }
        if choice & !self.existing() != 0 {
            return Err(Failure::ALREADY.with(CHOICE));
        }
        if choice & EXPLICIT != 0 {
            self.explicit = Connection::NONEXISTENT;
        }
        if choice & POLL != 0 {
            self.poll = Connection::NONEXISTENT;
        }
        if choice & PRODUCING != 0 {
            self.producing = Connection::NONEXISTENT;
            self.choice &= !SUPPRESS;
            self.timed_out &= !PRODUCING;
        }
        self.choice &= !choice;
        self.timed_out &= !choice;
        self.clear_unused();
        Ok(())
    }

    /// The connections that exist, as bits of the choice.
    fn existing(&self) -> u8 {
        let bits = |connection: &Connection, bits| if connection.exists() { bits } else { 0 };
        bits(&self.explicit, EXPLICIT)
            | bits(&self.poll, POLL)
            | bits(&self.producing, self.kind & PRODUCING)
    }

    /// Releases everything if no connection is established.
    fn clear_unused(&mut self) {
        let connections = [&self.explicit, &self.poll, &self.producing];
        if !connections.iter().any(|one| one.is_established()) {
            *self = Self {
                timed_out: self.timed_out,
                ..Self::EMPTY
            };
        }
    }

    /// Handles expired watchdogs. Returns true if a state has changed.
    pub fn expire(&mut self, now: Instant) -> bool {
        let mut changed = false;
        if self.poll.expire(now) {
            self.poll.suspend(State::TimedOut);
            self.time_out_io(POLL);
            changed = true;
        }
        if self.producing.expire(now) {
            self.producing.suspend(State::TimedOut);
            self.time_out_io(PRODUCING | SUPPRESS);
            changed = true;
        }
        if self.explicit.expire(now) {
            let io = self.poll.is_established() || self.producing.is_established();
            if self.defers && io {
                self.explicit.suspend(State::Deferred);
            } else {
                self.delete_explicit();
            }
            changed = true;
        }
        if changed {
            self.clear_unused();
        }
        changed
    }

    /// Handles the time-out of an I/O connection. A deferred explicit connection is deleted with it.
    fn time_out_io(&mut self, bits: u8) {
        self.choice &= !bits;
        self.timed_out |= bits & !SUPPRESS;
        if self.explicit.state() == State::Deferred {
            self.delete_explicit();
        }
    }

    fn delete_explicit(&mut self) {
        self.explicit = Connection::NONEXISTENT;
        self.choice &= !EXPLICIT;
    }

    /// Handles an explicit request of the owner. Returns true if the watchdog may expire earlier than before.
    pub fn requested(&mut self, now: Instant) -> bool {
        let was_deferred = !self.explicit.is_established();
        self.explicit.consume(now);
        was_deferred
    }

    /// Handles a poll command. Returns true if the watchdog may expire earlier than before.
    pub fn polled(&mut self, now: Instant) -> bool {
        self.poll.consume(now)
    }

    /// Handles an acknowledge of a COS or cyclic message. Returns true if the watchdog may expire earlier than before.
    pub fn acknowledged(&mut self, now: Instant) -> bool {
        self.producing.consume(now)
    }

    /// Whether an explicit message of this master is handled.
    pub fn accepts_from(&self, master: u8) -> bool {
        self.owner == Some(master) && self.explicit.is_allocated()
    }

    /// The explicit connection: instance 1.
    pub fn explicit(&mut self) -> &mut Connection {
        &mut self.explicit
    }

    /// The poll connection: instance 2.
    pub fn poll(&mut self) -> &mut Connection {
        &mut self.poll
    }

    /// The COS or cyclic connection: instance 4.
    pub fn producing(&mut self) -> &mut Connection {
        &mut self.producing
    }

    /// Whether the poll connection is established: polls get a response.
    pub fn is_polled(&self) -> bool {
        self.poll.is_established()
    }

    /// Whether the producing connection is established.
    pub fn is_producing(&self) -> bool {
        self.producing.is_established()
    }

    /// Whether the producing connection was allocated for cyclic messages.
    pub fn is_cyclic(&self) -> bool {
        self.kind & CYCLIC != 0
    }

    /// Whether the explicit connection has the watchdog action deferred delete.
    pub fn defers(&self) -> bool {
        self.defers
    }

    /// Sets the watchdog action of the explicit connection.
    pub fn set_defers(&mut self, defers: bool) {
        self.defers = defers;
    }

    /// The choice and the MAC ID of the owner (attribute 5 of the DeviceNet object).
    pub fn information(&self) -> [u8; 2] {
        [self.choice, self.owner.unwrap_or(NO_OWNER)]
    }

    /// Whether there is an owner.
    pub fn is_owned(&self) -> bool {
        self.owner.is_some()
    }

    /// Whether a connection is established.
    pub fn is_used(&self) -> bool {
        let connections = [&self.explicit, &self.poll, &self.producing];
        connections.iter().any(|one| one.is_established())
    }

    /// Whether an I/O connection has timed out.
    pub fn has_timed_out(&self) -> bool {
        self.timed_out != 0
    }

    /// Adds the deadlines of the watchdogs.
    pub fn consider(&self, earliest: &mut Deadline) {
        for connection in [&self.explicit, &self.poll, &self.producing] {
            earliest.consider(connection.deadline());
        }
    }
}

#[cfg(test)]
mod tests;
