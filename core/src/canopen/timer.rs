//! A periodic timer without drift.

use crate::time::{Duration, Instant, after, millis, reached};

/// A periodic timer. It is off until it is started.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Periodic(Option<(Duration, Instant)>);

impl Periodic {
    /// Not started.
    pub const OFF: Self = Self(None);

    /// Begins a period of `period_ms` milliseconds; 0 switches the timer off.
    pub fn start(&mut self, now: Instant, period_ms: u32) {
        let period = millis(period_ms);
        self.0 = (period_ms > 0).then(|| (period, after(now, period)));
    }

    /// Switches the timer off.
    pub fn stop(&mut self) {
        self.0 = None;
    }

    /// Returns true if a period has ended; the next one begins. Several missed periods count as one.
    pub fn poll(&mut self, now: Instant) -> bool {
        let Some((period, due)) = self.0.filter(|&(_, due)| reached(now, due)) else {
            return false;
        };
        let next = after(due, period);
        let missed = reached(now, next);
        self.0 = Some((period, if missed { after(now, period) } else { next }));
        true
    }

    /// The end of the present period.
    pub fn deadline(&self) -> Option<Instant> {
        self.0.map(|(_, due)| due)
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
        assert_eq!(timer.deadline(), Some(at(20)));
        assert!(timer.poll(at(47)));
        assert!(!timer.poll(at(47)));
        assert_eq!(timer.deadline(), Some(at(57)));
        timer.start(at(50), 0);
        assert_eq!(timer.deadline(), None);
    }
}
