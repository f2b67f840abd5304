//! The digits of an accelerometer or gyroscope, with its noise or another one.

/// The noise of a part.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Noise {
    /// That of the datasheet.
    Real,
    /// The digits are one higher and one lower in turn, because a real part does not repeat a digit for long. That is half the data rate,
    /// which no filter behind it lets pass. Nothing is random.
    Alternating,
    /// The same for one pair of digits in 25, for a gyroscope: its values pass no filter, and a pair adds no rotation.
    Pairs,
    /// None, for tests of the part itself: the driver would take it for a defective one.
    None,
}

/// From the values to the digits of the three axes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Digits {
    random: u64,
    pub(crate) noise: Noise,
    /// Without random noise: the part of each value that its digit does not show.
    rest: [f64; 3],
    /// The number of digits so far, modulo 50.
    number: u8,
}

impl Digits {
    /// With noise, the same for the same seed.
    pub(crate) const fn new(seed: u64) -> Self {
        Self {
            // The state of the generator must not be 0.
            random: seed.wrapping_add(1).wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1,
            noise: Noise::Real,
            rest: [0.0; 3],
            number: 0,
        }
    }

    /// The digits of 16 bits ([`rounded`](Self::rounded)).
    pub(crate) fn of(&mut self, values: [f64; 3], deviation: f64, unit: f64) -> [i16; 3] {
        let digits = self.rounded(values, deviation, unit);
        digits.map(|digit| digit.clamp(i16::MIN.into(), i16::MAX.into()) as i16)
    }

    /// The digits of values, with noise of this standard deviation, and `unit` per digit.
    ///
    /// The real noise is wider than a digit, so the mean of many digits is the value. Otherwise the rest of each value is added to the next
    /// value: the mean is the value too.
    pub(crate) fn rounded(&mut self, values: [f64; 3], deviation: f64, unit: f64) -> [f64; 3] {
        let swing = match (self.noise, self.number % 2, self.number % 25) {
            (Noise::Alternating, 0, _) | (Noise::Pairs, _, 0) => 1.0,
            (Noise::Alternating, _, _) | (Noise::Pairs, _, 1) => -1.0,
            _ => 0.0,
        };
        self.number = (self.number + 1) % 50;
        let mut digits = [0.0; 3];
        for (axis, digit) in digits.iter_mut().enumerate() {
            let added = match self.noise {
                Noise::Real => self.normal() * deviation / unit,
                Noise::Alternating | Noise::Pairs | Noise::None => self.rest[axis],
            };
            let exact = values[axis] / unit + added;
            *digit = exact.round();
            self.rest[axis] = (exact - *digit).clamp(-0.5, 0.5);
            *digit += swing;
        }
        digits
    }

    /// A random number with the mean 0 and the standard deviation 1: the sum of twelve uniform ones.
    fn normal(&mut self) -> f64 {
        let mut sum = -6.0;
        for _ in 0..12 {
            // xorshift64
            self.random ^= self.random << 13;
            self.random ^= self.random >> 7;
            self.random ^= self.random << 17;
            sum += (self.random >> 11) as f64 / (1_u64 << 53) as f64;
        }
        sum
    }
}

impl Default for Digits {
    fn default() -> Self {
        Self::new(0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 60 ug * sqrt(833.375 / 2).
    const DEVIATION: f64 = 1.225e-3;
    const UNIT: f64 = 244e-6;

    /// Mean and standard deviation of one axis in g.
    fn statistics(mut digits: Digits, acceleration: f64) -> (f64, f64) {
        const COUNT: u32 = 100_000;
        let values: Vec<f64> = (0..COUNT)
            .map(|_| f64::from(digits.of([0.0, acceleration, 1.0], DEVIATION, UNIT)[1]) * UNIT)
            .collect();
        let mean = values.iter().sum::<f64>() / f64::from(COUNT);
        let square = values.iter().map(|value| (value - mean).powi(2));
        (mean, (square.sum::<f64>() / f64::from(COUNT)).sqrt())
    }

    #[test]
    fn noise_has_its_deviation_and_averages_out() {
        for (seed, acceleration) in [(1, 0.0), (2, 0.1001), (3, -0.500_09)] {
            let (mean, deviation) = statistics(Digits::new(seed), acceleration);
            // With the uniform distribution of a rounded digit.
            assert!((deviation / 1.227e-3 - 1.0).abs() < 0.01, "{deviation}");
            assert!((mean - acceleration).abs() < 15e-6, "{mean}");
        }
    }

    #[test]
    fn noise_is_the_same_for_the_same_seed_only() {
        let first = |seed| {
            let mut digits = Digits::new(seed);
            [(); 8].map(|()| digits.of([0.0; 3], DEVIATION, UNIT))
        };
        assert_eq!(first(1), first(1));
        assert_ne!(first(1), first(2));
    }

    /// Without the noise of the datasheet.
    fn with(noise: Noise) -> Digits {
        Digits {
            noise,
            ..Digits::new(1)
        }
    }

    #[test]
    fn mean_without_noise_is_exact_and_within_a_digit() {
        for acceleration in [0.0, 0.1001, -0.500_09] {
            let (mean, deviation) = statistics(with(Noise::None), acceleration);
            assert!((mean - acceleration).abs() < 1e-8, "{mean}");
            assert!(deviation <= UNIT / 2.0, "{deviation}");
        }
    }

    #[test]
    fn alternating_noise_averages_out_and_repeats_no_digit() {
        for acceleration in [0.0, 0.1001, -0.500_09] {
            for noise in [Noise::Alternating, Noise::Pairs] {
                let (mean, _) = statistics(with(noise), acceleration);
                assert!((mean - acceleration).abs() < 1e-8, "{mean}");
            }
            let mut digits = with(Noise::Alternating);
            let mut next = || digits.of([acceleration; 3], DEVIATION, UNIT)[0];
            let mut last = next();
            for _ in 0..1000 {
                let digit = next();
                assert!((1..=3).contains(&digit.abs_diff(last)), "{digit}");
                last = digit;
            }
        }
    }

    #[test]
    fn value_beyond_the_range_leaves_no_rest_for_later() {
        let mut digits = with(Noise::None);
        for _ in 0..10 {
            assert_eq!(
                digits.of([9.0, -9.0, 0.0], DEVIATION, UNIT),
                [32_767, -32_768, 0]
            );
        }
        assert!(digits.of([0.0; 3], DEVIATION, UNIT)[0] <= 1);
    }
}
