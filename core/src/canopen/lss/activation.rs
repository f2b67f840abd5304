//! Activate bit timing (CiA 305): the node is silent for a delay, switches the bit rate, and is silent for the same delay again.

use crate::time::{Deadline, Duration, Instant};

/// A step of the activation.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Step {
    /// The first delay has ended: switch the bit rate.
    Switch,
    /// The second delay has ended: send and receive again.
    Resume,
}

/// The delays of activate bit timing.
#[derive(Clone, Copy, Debug)]
pub(super) struct Activation {
    delay: Duration,
    due: Deadline,
    /// The second delay is running.
    switched: bool,
}

impl Activation {
    /// No bit rate is being activated.
    pub const IDLE: Self = Self {
        delay: Duration::from_ticks(0),
        due: Deadline::NEVER,
        switched: false,
    };

    /// Begins the delay before the change of the bit rate. The delay after it has the same length.
    pub fn begin(&mut self, now: Instant, delay: Duration) {
        self.delay = delay;
        self.due = Deadline::after(now, delay);
        self.switched = false;
    }

    /// Whether a delay is running.
    pub fn is_running(&self) -> bool {
        self.due.is_set()
    }

    /// The next step, if its delay has ended.
    pub fn poll(&mut self, now: Instant) -> Option<Step> {
        if !self.due.is_reached(now) {
            return None;
        }
        if self.switched {
            self.due = Deadline::NEVER;
            return Some(Step::Resume);
        }
        self.switched = true;
        self.due = Deadline::after(now, self.delay);
        Some(Step::Switch)
    }

    /// The end of the running delay.
    pub fn deadline(&self) -> Deadline {
        self.due
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::time::millis;

    #[test]
    fn activation_switches_after_one_delay_and_resumes_after_two() {
        let at = |ms: u64| Instant::from_ticks(ms * 1000);
        let mut activation = Activation::IDLE;
        assert_eq!(activation.poll(at(1)), None);
        activation.begin(at(10), millis(100));
        assert!(activation.is_running());
        assert_eq!(activation.poll(at(109)), None);
        assert_eq!(activation.poll(at(110)), Some(Step::Switch));
        assert_eq!(activation.poll(at(209)), None);
        assert_eq!(activation.poll(at(210)), Some(Step::Resume));
        assert!(!activation.is_running());
        assert_eq!(activation.poll(at(1000)), None);
    }

    #[test]
    fn activation_with_delay_0_ends_at_any_start_time() {
        for start in [0, 1, 1_000_000] {
            let at = |us: u64| Instant::from_ticks(start + us);
            let mut activation = Activation::IDLE;
            activation.begin(at(0), Duration::from_ticks(0));
            assert!(activation.is_running(), "{start}");
            assert_eq!(activation.poll(at(1)), Some(Step::Switch));
            assert_eq!(activation.poll(at(1)), Some(Step::Resume));
            assert!(!activation.is_running());
        }
    }
}
