//! Time: microseconds since power-up in 64 bits, so that it does not overflow.
//!
//! The core reads no clock. The driver of a [`Node`](crate::node::Node) passes the time as an argument. The time must never
//! decrease.

mod periodic;

pub use periodic::Periodic;

/// A point in time, in microseconds since power-up.
pub type Instant = fugit::Instant<u64, 1, 1_000_000>;

/// A time between two [`Instant`]s, in microseconds.
pub type Duration = fugit::Duration<u64, 1, 1_000_000>;

/// A duration of `ms` milliseconds.
pub const fn millis(ms: u32) -> Duration {
    Duration::from_ticks(ms as u64 * 1000)
}

/// The time `delay` after `now`.
pub const fn after(now: Instant, delay: Duration) -> Instant {
    Instant::from_ticks(now.ticks().wrapping_add(delay.ticks()))
}

/// True if `deadline` is reached.
pub const fn reached(now: Instant, deadline: Instant) -> bool {
    now.ticks() >= deadline.ticks()
}

/// The earlier of two times; None means never.
pub fn earlier(a: Option<Instant>, b: Option<Instant>) -> Option<Instant> {
    match (a, b) {
        (Some(a), Some(b)) => Some(if reached(a, b) { b } else { a }),
        (a, None) => a,
        (None, b) => b,
    }
}

/// A deadline, or none.
///
/// The ticks are stored inverted: 0 is no deadline, and a comparison needs no check for it. An `Option<Instant>` has twice the size.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Deadline(u64);

impl Deadline {
    /// No deadline: it is never reached.
    pub const NEVER: Self = Self(0);

    /// A deadline at this time.
    pub const fn at(time: Instant) -> Self {
        Self(!time.ticks())
    }

    /// A deadline `delay` after `now`.
    pub const fn after(now: Instant, delay: Duration) -> Self {
        Self::at(after(now, delay))
    }

    /// True if there is a deadline and it is reached.
    pub const fn is_reached(self, now: Instant) -> bool {
        !now.ticks() <= self.0
    }

    /// True if there is a deadline.
    pub const fn is_set(self) -> bool {
        self.0 > 0
    }

    /// The time; None if there is no deadline.
    pub fn time(self) -> Option<Instant> {
        let time = Instant::from_ticks(!self.0);
        self.is_set().then_some(time)
    }

    /// The deadline with the delay `new` instead of `old` after the same time.
    pub const fn with_delay(self, old: Duration, new: Duration) -> Self {
        // Inverted ticks: a longer delay is a smaller number.
        match self {
            Self::NEVER => self,
            Self(ticks) => Self(ticks.wrapping_add(old.ticks()).wrapping_sub(new.ticks())),
        }
    }

    /// Becomes the earlier one of this and another deadline.
    pub fn consider(&mut self, other: Self) {
        self.0 = self.0.max(other.0);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn earlier_returns_earlier_time_and_ignores_none() {
        let (a, b) = (Instant::from_ticks(1), Instant::from_ticks(2));
        assert_eq!(earlier(Some(b), Some(a)), Some(a));
        assert_eq!(earlier(Some(a), Some(b)), Some(a));
        assert_eq!(earlier(None, Some(b)), Some(b));
        assert_eq!(earlier(None, None), None);
    }

    #[test]
    fn earliest_deadline_is_kept_and_none_is_ignored() {
        let (a, b) = (Instant::from_ticks(1), Instant::from_ticks(2));
        let mut earliest = Deadline::NEVER;
        assert_eq!(earliest.time(), None);
        for deadline in [
            Deadline::NEVER,
            Deadline::at(b),
            Deadline::at(a),
            Deadline::NEVER,
            Deadline::at(b),
        ] {
            earliest.consider(deadline);
        }
        assert_eq!(earliest.time(), Some(a));
    }

    #[test]
    fn deadline_is_reached_at_its_time() {
        let deadline = Deadline::after(Instant::from_ticks(5), Duration::from_ticks(2));
        assert!(deadline.is_set() && !deadline.is_reached(Instant::from_ticks(6)));
        assert!(deadline.is_reached(Instant::from_ticks(7)));
        assert!(!Deadline::NEVER.is_set());
        assert!(!Deadline::NEVER.is_reached(Instant::from_ticks(u64::MAX - 1)));
    }

    #[test]
    fn deadline_with_another_delay_counts_from_the_same_time() {
        let [two, five] = [2, 5].map(Duration::from_ticks);
        let start = Instant::from_ticks(10);
        for (old, new) in [(two, five), (five, two), (two, two)] {
            let moved = Deadline::after(start, old).with_delay(old, new);
            assert_eq!(moved, Deadline::after(start, new));
        }
        assert_eq!(Deadline::NEVER.with_delay(two, five), Deadline::NEVER);
    }

    #[test]
    fn deadline_without_delay_at_time_0_is_a_deadline() {
        let deadline = Deadline::after(Instant::from_ticks(0), Duration::from_ticks(0));
        assert!(deadline.is_set() && deadline.is_reached(Instant::from_ticks(0)));
    }
}
