//! Clipping: the accelerometer is at the end of its range, so the angle is wrong.

/// Samples for which a clipped one counts: 100 ms, so that vibration does not make the fault flicker.
const HOLD: u8 = 20;

/// Whether the accelerometer clips, or did so within the last 100 ms.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct Clipping {
    /// Samples for which it still counts.
    left: u8,
}

impl Clipping {
    /// No sample was clipped.
    pub const NONE: Self = Self { left: 0 };

    /// Takes in whether a sample was clipped.
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
    fn one_clipped_sample_counts_for_100_ms() {
        let mut clipping = Clipping::default();
        assert!(!clipping.step(false));
        assert!(clipping.step(true));
        for _ in 1..20 {
            assert!(clipping.step(false));
        }
        assert!(!clipping.step(false));
    }
}
