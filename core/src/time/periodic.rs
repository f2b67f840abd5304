//! A periodic timer without drift.

use super::{Deadline, Instant, after, millis, reached};

/// A periodic timer. It is off until it is started.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Periodic {
    period_ms: u32,
    /// The end of the present period.
    due: Deadline,
}

impl Periodic {
    /// The timer before [`start`](Self::start): no period ends.
    pub const OFF: Self = Self {
        period_ms: 0,
        due: Deadline::NEVER,
    };

    /// Begins a period of `period_ms` milliseconds; 0 switches the timer off.
    #[inline(never)] // measured: smaller, and no answer takes longer
    pub fn start(&mut self, now: Instant, period_ms: u32) {
        self.stop();
        if period_ms > 0 {
            self.period_ms = period_ms;
            self.due = Deadline::after(now, millis(period_ms));
        }
    }

    /// Sets the length of the periods after the running one, in milliseconds.
    pub fn set_period(&mut self, period_ms: u32) {
        self.period_ms = period_ms;
    }

    /// No period ends until the next [`start`](Self::start).
    pub fn stop(&mut self) {
        self.due = Deadline::NEVER;
    }

    /// Returns true if a period has ended; the next one begins. Several missed periods count as one.
    pub fn poll(&mut self, now: Instant) -> bool {
        let ended = self.due.is_reached(now);
        if ended {
            self.begin_next(now);
        }
        ended
    }

    /// The next period begins where this one ended; after a missed one it begins now.
    #[inline(never)] // measured: most polls do not need it, and an SDO answer of the JN2101 waits for a poll
    fn begin_next(&mut self, now: Instant) {
        let due = self.due.time().unwrap_or(now);
        let period = millis(self.period_ms);
        let next = after(due, period);
        let missed = reached(now, next);
        self.due = Deadline::at(if missed { after(now, period) } else { next });
    }

    /// The end of the present period.
    pub fn deadline(&self) -> Deadline {
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
    fn late_polls_do_not_shift_period_and_missed_periods_are_skipped() {
        let mut timer = Periodic::OFF;
        assert!(!timer.poll(at(1000)));
        timer.start(at(0), 10);
        assert!(!timer.poll(at(9)));
        assert!(timer.poll(at(13)));
        assert_eq!(timer.deadline().time(), Some(at(20)));
        assert!(timer.poll(at(47)));
        assert!(!timer.poll(at(47)));
        assert_eq!(timer.deadline().time(), Some(at(57)));
        timer.start(at(50), 0);
        assert_eq!(timer.deadline().time(), None);
    }
}
