//! Time: microseconds since power-up in 64 bits, so that it does not overflow.
//!
//! The core reads no clock. The driver of a [`Node`](crate::node::Node) passes the time as an argument. The time must never
//! decrease.

/// A point in time, in microseconds since power-up.
pub type Instant = fugit::Instant<u64, 1, 1_000_000>;

/// A duration in microseconds.
pub type Duration = fugit::Duration<u64, 1, 1_000_000>;

/// A duration of `ms` milliseconds.
pub const fn millis(ms: u32) -> Duration {
    Duration::from_ticks(ms as u64 * 1000)
}

/// The time `delay` after `now`. Saturates instead of overflowing.
#[inline(never)] // inlined, it would need 20 bytes at each call
pub const fn after(now: Instant, delay: Duration) -> Instant {
    Instant::from_ticks(now.ticks().saturating_add(delay.ticks()))
}

/// True if `deadline` is reached.
pub const fn reached(now: Instant, deadline: Instant) -> bool {
    now.ticks() >= deadline.ticks()
}

/// True if there is a deadline and it is reached.
pub fn is_due(deadline: &Option<Instant>, now: Instant) -> bool {
    deadline.is_some_and(|deadline| reached(now, deadline))
}

/// The earlier of two deadlines; None means never.
pub fn earlier(a: Option<Instant>, b: Option<Instant>) -> Option<Instant> {
    match (a, b) {
        (Some(a), Some(b)) => Some(if reached(a, b) { b } else { a }),
        (a, None) => a,
        (None, b) => b,
    }
}

/// The earliest of many deadlines. It needs a third of the code of a chain of [`earlier`].
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Earliest(u64);

impl Earliest {
    /// Adds a deadline; None means never.
    pub fn consider(&mut self, deadline: Option<Instant>) {
        if let Some(deadline) = deadline
            && deadline.ticks() < self.0
        {
            self.0 = deadline.ticks();
        }
    }

    /// The earliest deadline; None if no deadline was added.
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
    fn deadline_after_largest_time_saturates() {
        let end = Instant::from_ticks(u64::MAX);
        assert_eq!(after(end, millis(1)), end);
        assert!(reached(end, end));
    }

    #[test]
    fn earlier_returns_earlier_deadline_and_ignores_none() {
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
