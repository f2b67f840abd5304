//! LPF2: a low-pass filter of second order, as a Butterworth filter in floating point.

use std::f64::consts::{FRAC_1_SQRT_2, PI};

/// The coefficients, for a DC gain of 1.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(super) struct LowPass {
    forward: [f64; 3],
    back: [f64; 2],
}

/// The state of one axis.
#[derive(Clone, Copy, PartialEq, Debug, Default)]
pub(super) struct Memory([f64; 2]);

impl LowPass {
    /// The cut-off (-3 dB) is a fraction of the sampling rate below one half (bilinear transform, cut-off pre-warped).
    pub(super) fn new(cutoff: f64) -> Self {
        let angle = 2.0 * PI * cutoff;
        let alpha = angle.sin() * FRAC_1_SQRT_2;
        let scale = 1.0 / (1.0 + alpha);
        let forward = (1.0 - angle.cos()) * scale;
        Self {
            forward: [forward / 2.0, forward, forward / 2.0],
            back: [-2.0 * angle.cos() * scale, (1.0 - alpha) * scale],
        }
    }

    /// Filters the next value.
    pub(super) fn step(&self, memory: &mut Memory, input: f64) -> f64 {
        let Memory([first, second]) = memory;
        let output = self.forward[0] * input + *first;
        *first = self.forward[1] * input - self.back[0] * output + *second;
        *second = self.forward[2] * input - self.back[1] * output;
        output
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The gain for a sine at this fraction of the sampling rate.
    fn gain(filter: LowPass, frequency: f64) -> f64 {
        let mut memory = Memory::default();
        let sine = |n: u32| (2.0 * PI * frequency * f64::from(n)).sin();
        (0..200_000)
            .map(|n| filter.step(&mut memory, sine(n)))
            .skip(100_000)
            .fold(0.0, f64::max)
    }

    #[test]
    fn gain_is_minus_3_db_at_cutoff_and_falls_12_db_per_octave() {
        for part in [1.0 / 10.0, 1.0 / 20.0, 1.0 / 100.0, 1.0 / 800.0] {
            let filter = LowPass::new(part);
            assert!((gain(filter, part) - FRAC_1_SQRT_2).abs() < 1e-3);
            assert!(gain(filter, part / 20.0) > 0.999);
        }
        // Second order: 40 dB per decade.
        assert!((gain(LowPass::new(1.0 / 800.0), 1.0 / 80.0) - 0.01).abs() < 5e-4);
    }

    #[test]
    fn dc_gain_is_one() {
        let filter = LowPass::new(1.0 / 20.0);
        let mut memory = Memory::default();
        let last = (0..1000).map(|_| filter.step(&mut memory, 1.0)).last();
        assert!((last.unwrap() - 1.0).abs() < 1e-12);
    }
}
