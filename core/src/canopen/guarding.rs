//! Error control: node guarding and life guarding (CiA 301, 7.2.8.2.2.1 and 7.2.8.2.2.2).
//!
//! The master polls the node with remote frames. The reply contains the NMT state and a toggle bit. Life guarding begins with the
//! first request. It times out if no further request comes within the life time (guard time multiplied by life time factor).

use super::nmt::State;
use crate::time::{Duration, Instant, after, is_due, millis};

/// The state of node guarding and life guarding.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Guarding {
    /// The life time; None: life guarding is off.
    life_time: Option<Duration>,
    toggle: bool,
    /// The end of the life time; None before the first request.
    until: Option<Instant>,
    /// Life guarding has timed out.
    failed: bool,
}

impl Guarding {
    /// Life guarding is off.
    pub const OFF: Self = Self {
        life_time: None,
        toggle: false,
        until: None,
        failed: false,
    };

    /// Sets guard time (in ms) and life time factor. If one of them is 0, life guarding is off.
    pub fn configure(&mut self, now: Instant, guard_time: u32, factor: u32) {
        let life_time = guard_time.saturating_mul(factor);
        self.life_time = (life_time > 0).then(|| millis(life_time));
        if self.until.is_some() {
            self.until = self.life_time.map(|life_time| after(now, life_time));
        }
        self.failed &= self.life_time.is_some();
    }

    /// The reply to a request: the NMT state, and the toggle bit in bit 7.
    pub fn answer(&mut self, now: Instant, state: State) -> u8 {
        let answer = u8::from(self.toggle) << 7 | state as u8;
        self.toggle = !self.toggle;
        self.until = self.life_time.map(|life_time| after(now, life_time));
        self.failed = false;
        answer
    }

    /// Returns true once when life guarding times out.
    pub fn poll(&mut self, now: Instant) -> bool {
        let over = is_due(&self.until, now);
        if over {
            self.until = None;
            self.failed = true;
        }
        over
    }

    /// Whether life guarding has timed out and no new request has come.
    pub fn failed(&self) -> bool {
        self.failed
    }

    /// The end of the life time.
    pub fn deadline(&self) -> Option<Instant> {
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
        assert_eq!(guarding.deadline(), None);
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
        assert_eq!(guarding.deadline(), None);
    }
}
