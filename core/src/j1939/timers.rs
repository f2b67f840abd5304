//! The timers of the groups of a product.

use crate::time::{Deadline, Instant, Periodic};

/// The timer of a group.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Timer {
    timer: Periodic,
    /// The transmission rate in force, in ms.
    period: u32,
}

impl Timer {
    /// The group is not sent cyclically: rate 0, no period.
    const OFF: Self = Self {
        timer: Periodic::OFF,
        period: 0,
    };

    /// Begins a period of this length in ms.
    pub(super) fn start(&mut self, now: Instant, period: u32) {
        self.period = period;
        self.timer.start(now, period);
    }

    /// Sets another length of the period, and begins a period.
    pub(super) fn change(&mut self, now: Instant, period: u32) {
        if self.period != period {
            self.start(now, period);
        }
    }

    /// Whether the group must be sent now.
    pub(super) fn poll(&mut self, now: Instant) -> bool {
        self.timer.poll(now)
    }

    /// Stops cyclic sending of the group.
    pub(super) fn stop(&mut self) {
        self.timer.stop();
    }

    /// The end of the period.
    pub(super) fn deadline(&self) -> Deadline {
        self.timer.deadline()
    }
}

/// A timer for each group of a product.
pub trait Timers: AsMut<[Timer]> + Send + 'static {
    /// The number of timers: one for each group in [`Product::SENT`](super::Product::SENT).
    const COUNT: usize;
    /// All timers are off. All bits are 0.
    const OFF: Self;
}

impl<const N: usize> Timers for [Timer; N] {
    const COUNT: usize = N;
    const OFF: Self = [Timer::OFF; N];
}
