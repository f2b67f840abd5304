//! Clipping: the accelerometer is at the limit of its range, so the angle is wrong.

/// 100 ms in samples: a fault begins if more consecutive samples were clipped, and it ends if as many were not.
const HOLD: u8 = 20;

/// Counts clipped samples, so that a single one is no fault.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct Clipping {
    /// The number of consecutive clipped samples, at most one more than [`HOLD`].
    clipped: u8,
    /// The number of samples until the last clipped one is forgotten.
    left: u8,
    fault: bool,
}

impl Clipping {
    /// The state before the first sample: no fault.
    pub const NONE: Self = Self {
        clipped: 0,
        left: 0,
        fault: false,
    };

    /// Processes a sample. Returns true while the accelerometer clips for longer than 100 ms: one shock is no fault. The fault ends 100 ms
    /// after the last clipped sample, so vibration does not switch it on and off.
    pub fn step(&mut self, clipped: bool) -> bool {
        if clipped {
            self.clipped = (self.clipped + 1).min(HOLD + 1);
            self.left = HOLD;
        } else {
            self.clipped = 0;
            self.left = self.left.saturating_sub(1);
        }
        self.fault = self.left > 0 && (self.fault || self.clipped > HOLD);
        self.fault
    }

    /// Whether a sample within the last 100 ms was clipped.
    pub fn is_recent(&self) -> bool {
        self.left > 0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fault_begins_after_more_than_100_ms_and_ends_after_100_ms() {
        let mut clipping = Clipping::NONE;
        for _ in 0..20 {
            assert!(!clipping.step(true));
        }
        assert!(clipping.step(true));
        for _ in 1..20 {
            assert!(clipping.step(false));
        }
        assert!(clipping.step(true), "a sample of 5 ms continues the fault");
        for _ in 1..20 {
            assert!(clipping.step(false));
        }
        assert!(!clipping.step(false));
        assert!(!clipping.step(true), "it begins again");
    }

    #[test]
    fn repeated_shocks_are_no_fault() {
        let mut clipping = Clipping::NONE;
        for n in 0..1000 {
            assert!(!clipping.step(n % 25 < 20), "sample {n}");
        }
    }

    #[test]
    fn clipped_sample_is_recent_for_100_ms() {
        let mut clipping = Clipping::NONE;
        assert!(!clipping.is_recent());
        clipping.step(true);
        for _ in 1..20 {
            clipping.step(false);
            assert!(clipping.is_recent());
        }
        clipping.step(false);
        assert!(!clipping.is_recent());
    }
}
