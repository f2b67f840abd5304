//! The gain of the filter from the noise parameters Q and R (SIKO IMS360 manual 5.1.4.2, object 3112h).
//!
//! The state is a random walk with the variance Q in each update, and each measurement has the variance R. In the steady state,
//! the gain is K = 2 / (1 + sqrt(1 + 4 R / Q)).
//!
//! The manual does not state the update rate to which Q and R refer. It is [`UPDATE_RATE`] here. The filter runs at the sampling
//! rate, with the noise densities of this update rate: Q / R is scaled with the inverse square of the ratio of the rates. So the
//! time constant of the correction does not depend on the sampling rate.
//!
//! Equal ratios give exactly equal gains, because R / Q is first reduced to a / b 2^n 5^m without common factors.

use crate::measure::SAMPLE_PERIOD;
use crate::measure::low_pass_design::ratio;
use crate::measure::teach::square_root;

/// The update rate to which Q and R refer, in Hz. With it, a vibration of 0.5 g at 3 Hz causes 0.86 deg rms at Q = 0.001 and R =
/// 10.
const UPDATE_RATE: u64 = 80;

/// 4 times the square of the ratio of the sampling rate to the update rate.
const RATE_FACTOR: Float = {
    let update = 1_000_000 / UPDATE_RATE;
    let sample = SAMPLE_PERIOD.ticks();
    Float::quotient(4 * update * update, sample * sample)
};

/// 5/8 and 4/5 in Q32.
const FIVE_EIGHTHS: u32 = 0xA000_0000;
const FOUR_FIFTHS: u32 = 0xCCCC_CCCD;

/// A noise parameter, Q or R: mantissa * 10^exponent.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Noise {
    /// 1..=127
    mantissa: u8,
    /// -10..=10
    exponent: i8,
}

impl Noise {
    /// The parameter `mantissa` * 10^`exponent`. The ranges are 1..=127 and -10..=10; a number outside is limited to its range.
    pub const fn new(mantissa: i8, exponent: i8) -> Self {
        Self {
            mantissa: if mantissa < 1 { 1 } else { mantissa as u8 },
            exponent: match exponent {
                ..-10 => -10,
                -10..=10 => exponent,
                11.. => 10,
            },
        }
    }
}

/// The gain for each sample, Q31: 1..=2^31 - 1.
pub(super) fn gain(q: Noise, r: Noise) -> u32 {
    let Float { mantissa, exponent } = relation(r, q).times(RATE_FACTOR);
    // 1 + 4 R / Q, divided by 4^halvings so that it is below 2, Q60
    let halvings = exponent.max(0).cast_unsigned().div_ceil(2);
    if halvings > 31 {
        return 1;
    }
    let down = (2 * halvings).wrapping_sub(exponent.cast_unsigned());
    let four_r = (u64::from(mantissa) << 28).checked_shr(down).unwrap_or(0);
    let root = square_root(((1 << 60) >> (2 * halvings)) + four_r);
    let (one, two) = ((1 << 30) >> halvings, (1 << 31) >> halvings);
    (ratio(two, root + one) >> 1).max(1)
}

/// `numerator` / `denominator`; equal for equal quotients.
fn relation(numerator: Noise, denominator: Noise) -> Float {
    let (a, b) = (
        u32::from(numerator.mantissa),
        u32::from(denominator.mantissa),
    );
    let common = common_divisor(a, b).max(1);
    let (a, twos_a, fives_a) = without_two_and_five(a / common);
    let (b, twos_b, fives_b) = without_two_and_five(b / common);
    let tens = i32::from(numerator.exponent) - i32::from(denominator.exponent);
    let twos = tens + twos_a - twos_b;
    let fives = tens + fives_a - fives_b;

    let aligned = a << (a.leading_zeros() & 31);
    let mut float = Float::normal(aligned / b.max(1), 32 - a.leading_zeros() as i32 + twos);
    for _ in 0..fives.unsigned_abs() {
        float = float.times(if fives > 0 {
            Float {
                mantissa: FIVE_EIGHTHS,
                exponent: 3,
            }
        } else {
            Float {
                mantissa: FOUR_FIFTHS,
                exponent: -2,
            }
        });
    }
    float
}

fn common_divisor(mut a: u32, mut b: u32) -> u32 {
    while b != 0 {
        (a, b) = (b, a % b);
    }
    a
}

/// `number` without its factors 2 and 5, and their numbers. `number` is 1..=127.
fn without_two_and_five(number: u32) -> (u32, i32, i32) {
    let twos = number.trailing_zeros();
    let mut rest = number >> (twos & 31);
    let mut fives = 0;
    for _ in 0..2 {
        if rest.is_multiple_of(5) {
            rest /= 5;
            fives += 1;
        }
    }
    (rest, twos as i32, fives)
}

/// The positive number mantissa * 2^(exponent - 32). Bit 31 of the mantissa is 1.
#[derive(Clone, Copy)]
struct Float {
    mantissa: u32,
    exponent: i32,
}

impl Float {
    /// `mantissa` * 2^(`exponent` - 32).
    fn normal(mantissa: u32, exponent: i32) -> Self {
        let shift = mantissa.leading_zeros() & 31;
        Self {
            mantissa: mantissa << shift,
            exponent: exponent - shift as i32,
        }
    }

    /// `numerator` / `denominator`, rounded down, for constants.
    const fn quotient(numerator: u64, denominator: u64) -> Self {
        let mut mantissa = ((numerator as u128) << 64) / denominator as u128;
        let mut exponent = -32;
        while mantissa >> 32 != 0 {
            mantissa >>= 1;
            exponent += 1;
        }
        assert!(mantissa >> 31 == 1);
        Self {
            mantissa: mantissa as u32,
            exponent,
        }
    }

    fn times(self, other: Self) -> Self {
        let product = u64::from(self.mantissa) * u64::from(other.mantissa);
        Self::normal((product >> 32) as u32, self.exponent + other.exponent)
    }
}

#[cfg(test)]
mod tests;
