//! Cyclic mode (section 9.9.3): a timer without drift and a 16-bit counter of expired periods.
//!
//! The counter starts at 0 and counts each period, also if its frame could not be sent. After 65535 it continues at 0.

use crate::time::{Duration, Instant, after, reached};

/// Cyclic mode while it is on.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) struct Cyclic {
    counter: u16,
    /// The time between two messages, in us.
    period: u32,
    due: Instant,
}

impl Cyclic {
    /// Switches cyclic mode on. The counter is 0, and the first period of `period_ms` begins now.
    pub fn start(now: Instant, period_ms: u32) -> Self {
        let period = 1000 * period_ms.clamp(1, 65_535);
        Self {
            counter: 0,
            period,
            due: after(now, Duration::from_ticks(period.into())),
        }
    }

    /// Sets the cyclic time. A new period begins now; the counter continues. The time in force changes nothing.
    pub fn set_period(&mut self, now: Instant, period_ms: u32) {
        let started = Self::start(now, period_ms);
        if started.period != self.period {
            *self = Self {
                counter: self.counter,
                ..started
            };
        }
    }

    /// Counts the expired periods. Returns true if there was one: a value is due.
    pub fn poll(&mut self, now: Instant) -> bool {
        if !reached(now, self.due) {
            return false;
        }
        // Usually one period has expired, after a pause several. A poll counts the periods of at most 71 minutes, because the
        // 64-bit division of the compiler is large; the next poll counts the rest.
        let late = now.ticks().saturating_sub(self.due.ticks());
        let late = u32::try_from(late).unwrap_or(u32::MAX);
        let periods = 1 + late / self.period.max(1);
        let expired = u64::from(periods) * u64::from(self.period);
        self.due = after(self.due, Duration::from_ticks(expired));
        self.counter = self.counter.wrapping_add(periods as u16);
        true
    }

    /// The number of expired periods.
    pub fn counter(&self) -> u16 {
        self.counter
    }

    /// The end of the present period.
    pub fn deadline(&self) -> Instant {
        self.due
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(ms: u64) -> Instant {
        Instant::from_ticks(ms * 1000)
    }

    #[test]
    fn first_value_comes_after_one_period_with_counter_1() {
        let mut cyclic = Cyclic::start(at(3), 250);
        assert!(!cyclic.poll(at(252)));
        assert_eq!(cyclic.counter(), 0);
        assert!(cyclic.poll(at(253)));
        assert_eq!(cyclic.counter(), 1);
        assert!(!cyclic.poll(at(253)));
    }

    #[test]
    fn late_polls_do_not_shift_period() {
        let mut cyclic = Cyclic::start(at(0), 10);
        for period in 1..=1000 {
            assert!(cyclic.poll(at(period * 10 + period % 10)));
            assert_eq!(u64::from(cyclic.counter()), period);
            assert_eq!(cyclic.deadline(), at((period + 1) * 10));
        }
    }

    #[test]
    fn counter_after_missed_periods_counts_them_and_wraps() {
        let mut cyclic = Cyclic::start(at(0), 1);
        assert!(cyclic.poll(at(65_535)));
        assert_eq!(cyclic.counter(), 65_535);
        assert!(cyclic.poll(at(65_536)));
        assert_eq!(cyclic.counter(), 0);
        assert!(cyclic.poll(at(65_536 * 4 + 7)));
        assert_eq!(cyclic.counter(), 7);
        assert_eq!(cyclic.deadline(), at(65_536 * 4 + 8));
    }

    #[test]
    fn counter_after_pause_of_hours_is_complete_after_some_polls() {
        let mut cyclic = Cyclic::start(at(0), 7);
        let now = 7 * 2_000_000;
        while cyclic.deadline() <= at(now) {
            assert!(cyclic.poll(at(now)));
        }
        assert_eq!(cyclic.counter(), (2_000_000_u32 % 65_536) as u16);
        assert_eq!(cyclic.deadline(), at(now + 7));
    }

    #[test]
    fn new_cyclic_time_acts_at_once_and_keeps_counter() {
        let mut cyclic = Cyclic::start(at(0), 100);
        assert!(cyclic.poll(at(100)));
        cyclic.set_period(at(150), 20);
        assert!(!cyclic.poll(at(169)));
        assert!(cyclic.poll(at(170)));
        assert_eq!(cyclic.counter(), 2);
    }
}
