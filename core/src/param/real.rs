//! Real numbers (IEEE 754) by their bits, without floating-point arithmetic.

/// Positive infinity as a REAL32.
const INFINITY: u32 = 0x7F80_0000;
/// Positive infinity as a REAL64.
const INFINITY_64: u64 = 0x7FF0_0000_0000_0000;
/// The number of fraction bits of a REAL32.
const FRACTION: u32 = 23;

/// Whether these bits of a REAL32 are a NaN.
pub const fn is_nan(bits: u32) -> bool {
    bits & (u32::MAX >> 1) > INFINITY
}

/// Whether these bits of a REAL64 are a NaN.
pub const fn is_nan_64(bits: u64) -> bool {
    bits & (u64::MAX >> 1) > INFINITY_64
}

/// Converts a real number into an unsigned number with the same order. Both zeros are equal.
pub(super) const fn ordered(bits: u32) -> u32 {
    match bits {
        0x8000_0000 => 0x8000_0000,
        _ if bits >> 31 != 0 => !bits,
        _ => bits | 1 << 31,
    }
}

/// The bits of `number` divided by 10 to the power of `decimals` (0 to 9), rounded to the nearest real number of 32 bits: the number of a
/// quantity with the type [`Real32`](super::DataType::Real32).
pub fn real32(number: i32, decimals: u8) -> u32 {
    const POWERS: [u64; 10] = [
        1,
        10,
        100,
        1_000,
        10_000,
        100_000,
        1_000_000,
        10_000_000,
        100_000_000,
        1_000_000_000,
    ];
    let divisor = POWERS.get(usize::from(decimals)).copied().unwrap_or(1);
    let magnitude = u64::from(number.unsigned_abs());
    if magnitude == 0 {
        return 0;
    }
    // The quotient has at least 25 bits: 24 of the result and one to round.
    let shift = (25 + magnitude.leading_zeros()).saturating_sub(divisor.leading_zeros());
    let scaled = magnitude << shift;
    let quotient = scaled.checked_div(divisor).unwrap_or(0);
    let is_exact = quotient.wrapping_mul(divisor) == scaled;
    let dropped = (64 - quotient.leading_zeros()).saturating_sub(FRACTION + 1);
    let mut fraction = quotient >> dropped;
    let rest = quotient & !(u64::MAX << dropped);
    let half = 1 << dropped >> 1;
    if rest > half || rest == half && (!is_exact || fraction & 1 != 0) {
        fraction += 1;
    }
    // The addition of the fraction adds its hidden bit to the exponent, and also a carry of the rounding.
    let exponent = (126 + FRACTION + dropped).wrapping_sub(shift);
    let sign = if number < 0 { 1 << 31 } else { 0 };
    sign | (exponent << FRACTION).wrapping_add(fraction as u32)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn decimal_number_is_rounded_to_nearest_real_number() {
        let numbers = [
            1, 2, 3, 5, 7, 9, 10, 99, 4500, 9000, 12_345, 16_777_215, 16_777_216,
        ];
        let large = [
            16_777_217,
            16_777_219,
            33_554_433,
            123_456_789,
            i32::MAX,
            i32::MIN + 1,
        ];
        for number in numbers.into_iter().chain(large).chain([0, i32::MIN]) {
            for decimals in 0..=9 {
                for number in [number, number.wrapping_neg()] {
                    let expected: f32 = std::format!("{number}e-{decimals}").parse().unwrap();
                    let bits = real32(number, decimals);
                    assert_eq!(f32::from_bits(bits), expected, "{number}e-{decimals}");
                }
            }
        }
    }

    #[test]
    fn ordered_numbers_have_the_order_of_the_real_numbers() {
        let numbers = [
            f32::NEG_INFINITY,
            -f32::MAX,
            -1.0,
            -f32::MIN_POSITIVE,
            0.0,
            f32::MIN_POSITIVE,
            1.0,
            f32::INFINITY,
        ];
        let ordered_numbers = numbers.map(|number| ordered(number.to_bits()));
        assert!(ordered_numbers.is_sorted_by(|one, next| one < next));
        assert_eq!(ordered((-0.0_f32).to_bits()), ordered(0));
    }

    #[test]
    fn nan_is_recognised_and_infinity_is_not_nan() {
        for bits in [0, 0x7F80_0000, 0xFF80_0000, 0x8000_0000] {
            assert!(!is_nan(bits), "{bits:08X}");
        }
        for bits in [0x7F80_0001, 0x7FC0_0000, 0xFF80_0001, 0xFFFF_FFFF] {
            assert!(is_nan(bits), "{bits:08X}");
        }
        assert!(!is_nan_64(f64::INFINITY.to_bits()) && !is_nan_64(f64::NEG_INFINITY.to_bits()));
        assert!(is_nan_64(f64::NAN.to_bits()) && is_nan_64(u64::MAX));
    }
}
