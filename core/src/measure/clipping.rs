//! Clipping: the accelerometer is at the limit of its range, so the angle is wrong.

/// The number of samples for which the fault stays active: 100 ms. Vibration then does not switch the fault on and off.
const HOLD: u8 = 20;

/// Whether a sample was clipped within the last 100 ms.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct Clipping {
    /// The number of samples until the fault ends.
    left: u8,
}

impl Clipping {
    /// No sample was clipped.
    pub const NONE: Self = Self { left: 0 };

    /// Processes a sample. Returns true if this sample or one within the last 100 ms was clipped.
    pub fn step(&mut self, clipped: bool) -> bool {
        if clipped {
            self.left = HOLD;
        }
        let counts = self.left > 0;
        self.left = self.left.saturating_sub(1);
        counts
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn clipped_sample_is_reported_for_100_ms() {
        let mut clipping = Clipping::default();
        assert!(!clipping.step(false));
        assert!(clipping.step(true));
        for _ in 1..20 {
            assert!(clipping.step(false));
        }
        assert!(!clipping.step(false));
    }
}
