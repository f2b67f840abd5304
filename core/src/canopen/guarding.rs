//! Node guarding and life guarding (CiA 301, 7.2.8.2.2.1 and 7.2.8.2.2.2).
//!
//! The master asks with remote frames and gets the state and a bit that alternates. A node that is not asked for its life time,
//! guard time times life time factor, takes the master for dead. It begins to count with the first request.

use super::nmt::State;
use crate::time::{Duration, Instant, after, is_due, millis};

/// The guarded node.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct Guarding {
    /// The life time; None: the master is not guarded.
    life_time: Option<Duration>,
    toggle: bool,
    /// The end of the life time, once the master has asked.
    until: Option<Instant>,
    /// The master was not heard for a life time.
    failed: bool,
}

impl Guarding {
    /// Sets guard time (in ms) and life time factor; 0 in one of them: the master is not guarded.
    pub fn configure(&mut self, now: Instant, guard_time: u32, factor: u32) {
        let life_time = guard_time.saturating_mul(factor);
        self.life_time = (life_time > 0).then(|| millis(life_time));
        if self.until.is_some() {
            self.until = self.life_time.map(|life_time| after(now, life_time));
        }
        self.failed &= self.life_time.is_some();
    }

    /// The answer to a request.
    pub fn answer(&mut self, now: Instant, state: State) -> u8 {
        let answer = u8::from(self.toggle) << 7 | state as u8;
        self.toggle = !self.toggle;
        self.until = self.life_time.map(|life_time| after(now, life_time));
        self.failed = false;
        answer
    }

    /// True at the moment at which the master is taken for dead.
    pub fn poll(&mut self, now: Instant) -> bool {
        let over = is_due(&self.until, now);
        if over {
            self.until = None;
            self.failed = true;
        }
        over
    }

    /// Whether the master is taken for dead.
    pub fn failed(&self) -> bool {
        self.failed
    }

    /// The end of the life time.
    pub fn deadline(&self) -> Option<Instant> {
        self.until
    }
}
