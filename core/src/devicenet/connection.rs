//! A connection: its state and its watchdog.
//!
//! The master sets the expected packet rate (EPR) of a connection in ms. The watchdog of a connection that consumes messages expires
//! four times the EPR after the last one. With the EPR 0 there is no watchdog.

use crate::time::{Deadline, Duration, Instant, millis};

/// The expected packet rate of an explicit connection after its allocation, in ms.
const EXPLICIT_RATE: u16 = 2500;

/// The minimum wait of the watchdog for the first consumed I/O message.
const FIRST_WAIT: u32 = 10_000;

/// The state of a connection (attribute 1).
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
#[repr(u8)]
pub(super) enum State {
    /// Not allocated by a master, or released.
    Nonexistent = 0,
    /// I/O: allocated, and its EPR is not set yet.
    Configuring = 1,
    /// It can be used. For I/O: its EPR is set.
    Established = 3,
    /// I/O: its watchdog has expired.
    TimedOut = 4,
    /// Explicit: its watchdog has expired, and an I/O connection is established.
    Deferred = 5,
}

/// The state of a connection, and its watchdog.
#[derive(Clone, Copy, Debug)]
pub(super) struct Connection {
    state: State,
    /// It consumes messages, so that it has a watchdog.
    consumes: bool,
    /// It has consumed a message since its allocation.
    consumed: bool,
    rate: u16,
    expires: Deadline,
}

impl Connection {
    /// A connection that the master has not allocated.
    pub const NONEXISTENT: Self = Self {
        state: State::Nonexistent,
        consumes: false,
        consumed: false,
        rate: 0,
        expires: Deadline::NEVER,
    };

    /// A newly allocated explicit connection.
    pub fn explicit(now: Instant) -> Self {
        let mut connection = Self {
            consumes: true,
            consumed: true,
            ..Self::NONEXISTENT
        };
        connection.set_rate(now, EXPLICIT_RATE);
        connection
    }

    /// A newly allocated I/O connection.
    pub const fn io(consumes: bool) -> Self {
        Self {
            state: State::Configuring,
            consumes,
            ..Self::NONEXISTENT
        }
    }

    pub const fn state(&self) -> State {
        self.state
    }

    pub fn is_established(&self) -> bool {
        self.state == State::Established
    }

    /// Whether it is configuring, established or deferred.
    pub const fn is_allocated(&self) -> bool {
        !matches!(self.state, State::Nonexistent | State::TimedOut)
    }

    pub const fn exists(&self) -> bool {
        !matches!(self.state, State::Nonexistent)
    }

    pub const fn consumes(&self) -> bool {
        self.consumes
    }

    /// The expected packet rate in ms.
    pub const fn rate(&self) -> u16 {
        self.rate
    }

    /// Sets the expected packet rate in ms. The connection is established then. The rate in force does not restart the watchdog.
    pub fn set_rate(&mut self, now: Instant, rate: u16) {
        if self.is_established() && rate == self.rate {
            return;
        }
        self.state = State::Established;
        self.rate = rate;
        self.watch(now, if self.consumed { 0 } else { FIRST_WAIT });
    }

    /// Handles a consumed message. Returns true for the first one: the watchdog may expire earlier than before.
    pub fn consume(&mut self, now: Instant) -> bool {
        self.state = State::Established;
        self.watch(now, 0);
        !core::mem::replace(&mut self.consumed, true)
    }

    /// Restarts the watchdog with at least this time in ms.
    fn watch(&mut self, now: Instant, least: u32) {
        self.expires = if self.consumes && self.rate > 0 {
            let limit: Duration = millis((4 * u32::from(self.rate)).max(least));
            Deadline::after(now, limit)
        } else {
            Deadline::NEVER
        };
    }

    /// Returns true once if the watchdog has expired.
    pub fn expire(&mut self, now: Instant) -> bool {
        let expired = self.expires.is_reached(now);
        if expired {
            self.expires = Deadline::NEVER;
        }
        expired
    }

    /// Changes the state after the watchdog has expired.
    pub fn suspend(&mut self, state: State) {
        self.state = state;
        self.expires = Deadline::NEVER;
    }

    /// The time at which the watchdog expires.
    pub fn deadline(&self) -> Deadline {
        self.expires
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(ms: u32) -> Instant {
        Instant::from_ticks(0) + millis(ms)
    }

    /// The time in ms at which the watchdog expires.
    fn expires(connection: &Connection) -> Option<u64> {
        let time = connection.deadline().time();
        time.map(|time| time.ticks() / 1000)
    }

    #[test]
    fn explicit_connection_expires_10_s_after_last_message() {
        let mut explicit = Connection::explicit(at(1000));
        assert_eq!(explicit.state() as u8, 3);
        assert_eq!(expires(&explicit), Some(11_000));
        assert!(!explicit.consume(at(5000)));
        assert_eq!(expires(&explicit), Some(15_000));
        explicit.set_rate(at(6000), 100);
        assert_eq!(expires(&explicit), Some(6400));
        explicit.set_rate(at(6000), 0);
        assert_eq!(expires(&explicit), None);
    }

    #[test]
    fn io_connection_waits_at_least_10_s_for_first_message() {
        for (rate, first, later) in [
            (1, Some(10_000), Some(4)),
            (2500, Some(10_000), Some(10_000)),
            (2501, Some(10_004), Some(10_004)),
            (u16::MAX, Some(262_140), Some(262_140)),
            (0, None, None),
        ] {
            let mut poll = Connection::io(true);
            assert_eq!((poll.state() as u8, expires(&poll)), (1, None));
            poll.set_rate(at(0), rate);
            assert_eq!((poll.state() as u8, expires(&poll)), (3, first));
            assert!(poll.consume(at(0)));
            assert_eq!(expires(&poll), later);
            assert!(!poll.consume(at(0)));
            poll.set_rate(at(0), rate);
            assert_eq!(expires(&poll), later);
        }
    }

    #[test]
    fn connection_that_only_produces_never_expires() {
        let mut cyclic = Connection::io(false);
        cyclic.set_rate(at(0), 100);
        assert_eq!(expires(&cyclic), None);
        assert!(!cyclic.expire(at(u32::MAX / 1000)));
    }
}
