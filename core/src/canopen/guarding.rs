//! Error control: node guarding and life guarding (CiA 301, 7.2.8.2.2.1 and 7.2.8.2.2.2).
//!
//! The master polls the node with remote frames. The reply contains the NMT state and a toggle bit. Life guarding begins with the
//! first request. It times out if no further request comes within the life time (guard time multiplied by life time factor).

use super::nmt::State;
use crate::time::{Deadline, Instant, millis};

/// The state of node guarding and life guarding.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Guarding {
    /// The life time in ms; 0: life guarding is off.
    life_time: u32,
    toggle: bool,
    /// The end of the life time; unset before the first request.
    until: Deadline,
    /// Life guarding has timed out.
    failed: bool,
}

impl Guarding {
    pub const OFF: Self = Self {
        life_time: 0,
        toggle: false,
        until: Deadline::NEVER,
        failed: false,
    };

    /// Sets guard time (in ms) and life time factor. If one of them is 0, life guarding is off.
    pub fn configure(&mut self, now: Instant, guard_time: u32, factor: u32) {
        self.life_time = guard_time.saturating_mul(factor);
        if self.until.is_set() {
            self.restart(now);
        }
        self.failed &= self.life_time > 0;
    }

    /// The reply to a request: the NMT state, and the toggle bit in bit 7.
    pub fn answer(&mut self, now: Instant, state: State) -> u8 {
        let answer = u8::from(self.toggle) << 7 | state as u8;
        self.toggle = !self.toggle;
        self.restart(now);
        self.failed = false;
        answer
    }

    fn restart(&mut self, now: Instant) {
        self.until = if self.life_time > 0 {
            Deadline::after(now, millis(self.life_time))
        } else {
            Deadline::NEVER
        };
    }

    /// Returns true once when life guarding times out.
    pub fn poll(&mut self, now: Instant) -> bool {
        let over = self.until.is_reached(now);
        if over {
            self.until = Deadline::NEVER;
            self.failed = true;
        }
        over
    }

    /// Whether life guarding has timed out and no new request has come.
    pub fn failed(&self) -> bool {
        self.failed
    }

    /// The end of the life time.
    pub fn deadline(&self) -> Deadline {
        self.until
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(ms: u64) -> Instant {
        Instant::from_ticks(ms * 1000)
    }

    #[test]
    fn toggle_bit_starts_at_0_and_alternates() {
        let mut guarding = Guarding::OFF;
        let answers = [1, 2, 3].map(|ms| guarding.answer(at(ms), State::PreOperational));
        assert_eq!(answers, [0x7F, 0xFF, 0x7F]);
    }

    #[test]
    fn life_guarding_after_first_request_times_out_after_life_time() {
        let mut guarding = Guarding::OFF;
        guarding.configure(at(0), 100, 3);
        assert_eq!(guarding.deadline(), Deadline::NEVER);
        guarding.answer(at(1000), State::Operational);
        assert!(!guarding.poll(at(1299)));
        assert!(guarding.poll(at(1300)));
        assert!(guarding.failed() && !guarding.poll(at(1301)));
        guarding.answer(at(2000), State::Operational);
        assert!(!guarding.failed());
    }

    #[test]
    fn life_guarding_with_factor_0_is_off() {
        let mut guarding = Guarding::OFF;
        guarding.configure(at(0), 100, 0);
        guarding.answer(at(0), State::Stopped);
        assert_eq!(guarding.deadline(), Deadline::NEVER);
    }
}
