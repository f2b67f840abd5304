//! Time as an argument: microseconds since power-up, in 64 bits, so that it never wraps.
//!
//! The core reads no clock. Whoever drives a [`Node`](crate::node::Node) passes the time in, and time never runs backwards.

/// A point in time, in microseconds since power-up.
pub type Instant = fugit::Instant<u64, 1, 1_000_000>;

/// A length of time in microseconds.
pub type Duration = fugit::Duration<u64, 1, 1_000_000>;

/// A duration of `ms` milliseconds.
pub const fn millis(ms: u32) -> Duration {
    Duration::from_ticks(ms as u64 * 1000)
}

/// The point `delay` after `now`; saturates at the end of time instead of wrapping.
#[inline(never)] // 20 bytes at each of its many places otherwise
pub const fn after(now: Instant, delay: Duration) -> Instant {
    Instant::from_ticks(now.ticks().saturating_add(delay.ticks()))
}

/// True when `deadline` has come.
pub const fn reached(now: Instant, deadline: Instant) -> bool {
    now.ticks() >= deadline.ticks()
}

/// True when there is a deadline and it has come.
pub fn is_due(deadline: &Option<Instant>, now: Instant) -> bool {
    deadline.is_some_and(|deadline| reached(now, deadline))
}

/// The earlier of two deadlines, where None means never.
pub fn earlier(a: Option<Instant>, b: Option<Instant>) -> Option<Instant> {
    match (a, b) {
        (Some(a), Some(b)) => Some(if reached(a, b) { b } else { a }),
        (a, None) => a,
        (None, b) => b,
    }
}

/// The earliest of many deadlines; a third of the code that a chain of [`earlier`] takes.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Earliest(u64);

impl Earliest {
    /// Takes a deadline into account, where None means never.
    pub fn consider(&mut self, deadline: Option<Instant>) {
        if let Some(deadline) = deadline
            && deadline.ticks() < self.0
        {
            self.0 = deadline.ticks();
        }
    }

    /// The earliest; None when there was none, nor one before the end of time.
    pub fn instant(self) -> Option<Instant> {
        (self.0 < u64::MAX).then_some(Instant::from_ticks(self.0))
    }
}

impl Default for Earliest {
    fn default() -> Self {
        Self(u64::MAX)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_deadline_at_the_end_of_time_saturates() {
        let end = Instant::from_ticks(u64::MAX);
        assert_eq!(after(end, millis(1)), end);
        assert!(reached(end, end));
    }

    #[test]
    fn the_earlier_deadline_wins_and_none_is_never() {
        let (a, b) = (Instant::from_ticks(1), Instant::from_ticks(2));
        assert_eq!(earlier(Some(b), Some(a)), Some(a));
        assert_eq!(earlier(Some(a), Some(b)), Some(a));
        assert_eq!(earlier(None, Some(b)), Some(b));
        assert_eq!(earlier(None, None), None);
        let mut earliest = Earliest::default();
        assert_eq!(earliest.instant(), None);
        for deadline in [None, Some(b), Some(a), None, Some(b)] {
            earliest.consider(deadline);
        }
        assert_eq!(earliest.instant(), Some(a));
    }
}
