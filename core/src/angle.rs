//! Binary angles: 360 deg is 2^32, so the overflow of the integers is the wrap at 360 deg.
//!
//! One unit is 8.4e-8 deg. The error of [`Angle::atan2`] is at most 1.3e-5 deg ([`Angle::ATAN2_ERROR`]). It needs a table of 65
//! arc tangents, a few multiplications and three 32-bit divisions.

use crate::walk::{at, put};
use core::ops::{Add, AddAssign, Neg, Sub, SubAssign};

/// An angle modulo 360 deg, in units of 360 deg / 2^32.
///
/// ```
/// use plumbline::angle::Angle;
///
/// // The difference between 359.9 deg and 0.1 deg is 0.2 deg.
/// let step = Angle::from_centidegrees(10) - Angle::from_centidegrees(35_990);
/// assert_eq!(step.centidegrees(), 20);
/// assert_eq!((-step).centidegrees_unsigned(), 35_980);
/// ```
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Angle(pub u32);

impl Angle {
    /// 0 deg, which is also 360 deg.
    pub const ZERO: Self = Self(0);
    /// 90 deg, a quarter of a turn.
    pub const QUARTER: Self = Self(1 << 30);
    /// 180 deg, half a turn.
    pub const HALF: Self = Self(1 << 31);
    /// 270 deg, three quarters of a turn.
    pub const THREE_QUARTERS: Self = Self(3 << 30);

    /// The largest error of [`atan2`](Self::atan2): 1.3e-5 deg. The tests check it.
    pub const ATAN2_ERROR: Self = Self(155);

    /// The angle of `value` * 0.01 deg modulo 360 deg, rounded to the nearest unit. All values are permitted.
    pub const fn from_centidegrees(value: i32) -> Self {
        let part = value.rem_euclid(TURN as i32) as u32;
        // 2^32 / 36000 is 2^27 / 1125. It is split into quotient and remainder, so the arithmetic is exact in 32 bits.
        let (dividend, divisor) = (1_u32 << 27, 1125);
        let rest = (part.wrapping_mul(dividend % divisor) + divisor / 2) / divisor;
        Self(part.wrapping_mul(dividend / divisor).wrapping_add(rest))
    }

    /// The angle in 0.01 deg, -18000..=17999, rounded to nearest (halves up). 180.00 deg is returned as -18000.
    pub const fn centidegrees(self) -> i32 {
        to_signed::<36_000>(self.0)
    }

    /// The angle in 0.01 deg, 0..=35999, rounded to nearest (halves up). 359.996 deg is 0.
    pub const fn centidegrees_unsigned(self) -> u16 {
        let rounded = ((self.0 as u64 * TURN as u64 + (1 << 31)) >> 32) as u32;
        (if rounded == TURN { 0 } else { rounded }) as u16
    }

    /// The angle in 0.001 deg, -180000..=179999, rounded to nearest (halves up). 180.000 deg is returned as -180000.
    pub const fn millidegrees(self) -> i32 {
        to_signed::<360_000>(self.0)
    }

    /// The direction of the point (`x`, `y`), measured from the x axis towards the y axis; 0 for the origin.
    ///
    /// Only the ratio has an effect, and all inputs are permitted. The result is exact on the axes and on their bisectors.
    ///
    /// ```
    /// use plumbline::angle::Angle;
    ///
    /// assert_eq!(Angle::atan2(7, 7), Angle::from_centidegrees(45_00));
    /// assert_eq!(Angle::atan2(1, -1).centidegrees(), 135_00);
    /// ```
    pub fn atan2(y: i32, x: i32) -> Self {
        let first = Self::first_quadrant(y.unsigned_abs(), x.unsigned_abs());
        let upper = if x < 0 { Self::HALF - first } else { first };
        if y < 0 { -upper } else { upper }
    }

    /// [`atan2`](Self::atan2) of two lengths, 0..=90 deg.
    ///
    /// `a` is the longer side, `b` the shorter, and k/64 the point of the table nearest to b/a. The angle is atan(k/64) +
    /// atan((64 b - k a) / (64 a + k b)). The argument of the second arc tangent is at most 1/128, so the arc tangent is nearly
    /// equal to it.
    pub(crate) fn first_quadrant(y: u32, x: u32) -> Self {
        let steep = y > x;
        let (a, b) = if steep { (y, x) } else { (x, y) };
        // 24 bits, so that 64 a + k b stays below 2^31. Bit 23 is already set, except for the origin.
        let shift = a.leading_zeros();
        let a = (a.wrapping_shl(shift) >> 8) | (1 << 23);
        let b = b.wrapping_shl(shift) >> 8;

        let k = (64 * b + a / 2) / a;
        let numerator = (64 * b).wrapping_sub(k.wrapping_mul(a)) as i32;
        let denominator = 64 * a + k.wrapping_mul(b);

        // The quotient in Q24, 8 bits at a time: |numerator| < 2^23 and 2^21 <= divisor < 2^23.
        let divisor = ((denominator >> 8) | 1) as i32;
        let dividend = numerator << 8;
        let high = dividend / divisor;
        let low = ((dividend % divisor) << 8) / divisor;
        let quotient = high.wrapping_mul(1 << 15).wrapping_add(low << 7);
        let small = ((i64::from(quotient) * UNITS_PER_RADIAN) >> 32) as i32;

        let octant = ATAN.get(k as usize).copied().unwrap_or_default();
        let angle = Self(octant.wrapping_add_signed(small));
        if steep { Self::QUARTER - angle } else { angle }
    }
}

/// 360 deg in units of 0.01 deg.
const TURN: u32 = 36_000;

/// 2^32 / 2 pi * (1 - 2^-16) in Q1: turns a quotient in Q31 into units. The factor distributes the missing cubic term of the arc
/// tangent evenly over |t| <= 1/128. A quarter of it remains: 2.3e-6 deg.
const UNITS_PER_RADIAN: i64 = 1_367_109_690;

/// The arc tangents of k/64 for k = 0..=64.
static ATAN: [u32; 65] = arc_tangents();

/// atan(k/64) is atan((k-1)/64) + atan(64 / (4096 + k (k-1))); the sums are scaled so that the last one, pi/4, is 2^29.
const fn arc_tangents() -> [u32; 65] {
    const ONE: u128 = 1 << 60;
    let mut radians = [0u128; 65];
    let mut sum = 0;
    let mut k = 1;
    while k < radians.len() {
        let t = 64 * ONE / (4096 + (k * (k - 1)) as u128);
        let square = t * t / ONE;
        // t - t^3/3 + t^5/5 - t^7/7 + t^9/9
        let mut series = ONE / 9;
        series = ONE / 7 - square * series / ONE;
        series = ONE / 5 - square * series / ONE;
        series = ONE / 3 - square * series / ONE;
        series = ONE - square * series / ONE;
        sum += t * series / ONE;
        put(&mut radians, k, sum);
        k += 1;
    }
    let mut table = [0; 65];
    let mut k = 0;
    while k < table.len() {
        put(
            &mut table,
            k,
            (((*at(&radians, k) << 29) + sum / 2) / sum) as u32,
        );
        k += 1;
    }
    table
}

/// The angle in units of 1 / `TURN` of a circle, rounded to nearest, from -`TURN` / 2 to `TURN` / 2 - 1.
const fn to_signed<const TURN: i32>(angle: u32) -> i32 {
    let rounded = ((angle as i32 as i64 * TURN as i64 + (1 << 31)) >> 32) as i32;
    if rounded == TURN / 2 {
        -(TURN / 2)
    } else {
        rounded
    }
}

impl Add for Angle {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self(self.0.wrapping_add(other.0))
    }
}

impl Sub for Angle {
    type Output = Self;

    fn sub(self, other: Self) -> Self {
        Self(self.0.wrapping_sub(other.0))
    }
}

impl Neg for Angle {
    type Output = Self;

    fn neg(self) -> Self {
        Self(self.0.wrapping_neg())
    }
}

impl AddAssign for Angle {
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl SubAssign for Angle {
    fn sub_assign(&mut self, other: Self) {
        *self = *self - other;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::f64::consts::TAU;
    use proptest::prelude::*;

    /// The units in 360 deg.
    const UNITS: f64 = 4_294_967_296.0;
    /// The size of one unit in deg.
    const UNIT: f64 = 360.0 / UNITS;

    /// The error of `Angle::atan2(y, x)` in units. The error of f64 is below 1e-6 units.
    fn error(y: i32, x: i32) -> f64 {
        let truth = f64::from(y).atan2(f64::from(x)).to_degrees() / UNIT;
        let difference = (f64::from(Angle::atan2(y, x).0) - truth) / UNITS;
        (difference - difference.round()).abs() * UNITS
    }

    fn check(y: i32, x: i32) {
        let error = error(y, x);
        let limit = f64::from(Angle::ATAN2_ERROR.0);
        assert!(error <= limit, "atan2({y}, {x}) is off by {error} units");
    }

    #[test]
    fn stated_error_is_1_3e_5_deg() {
        assert!(f64::from(Angle::ATAN2_ERROR.0) * UNIT <= 1.3e-5);
    }

    #[test]
    fn table_contains_arc_tangents() {
        for (k, &entry) in ATAN.iter().enumerate() {
            let truth = (k as f64 / 64.0).atan() / TAU * UNITS;
            assert!((f64::from(entry) - truth).abs() <= 0.5, "{k}");
        }
        let units = UNITS / TAU * (1.0 - 1.0 / 65_536.0) * 2.0;
        assert!((UNITS_PER_RADIAN as f64 - units).abs() <= 0.5, "{units}");
    }

    #[test]
    fn atan2_on_axes_and_bisectors_is_exact() {
        for m in [1, 2, 3, 1000, 1 << 24, (1 << 24) + 1, 1 << 28, i32::MAX] {
            assert_eq!(Angle::atan2(0, m), Angle::ZERO);
            assert_eq!(Angle::atan2(m, m), Angle(1 << 29));
            assert_eq!(Angle::atan2(m, 0), Angle::QUARTER);
            assert_eq!(Angle::atan2(m, -m), Angle(3 << 29));
            assert_eq!(Angle::atan2(0, -m), Angle::HALF);
            assert_eq!(Angle::atan2(-m, -m), Angle(5 << 29));
            assert_eq!(Angle::atan2(-m, 0), Angle::THREE_QUARTERS);
            assert_eq!(Angle::atan2(-m, m), Angle(7 << 29));
        }
        assert_eq!(Angle::atan2(i32::MIN, i32::MIN), Angle(5 << 29));
        assert_eq!(Angle::atan2(i32::MIN, 0), Angle::THREE_QUARTERS);
        assert_eq!(Angle::atan2(0, 0), Angle::ZERO);
    }

    #[test]
    fn atan2_in_all_directions_is_within_error() {
        for magnitude in [
            3e2,
            1e3,
            65_535.0,
            8_388_608.0,
            16_777_215.0,
            2e7,
            268_435_456.0,
            2_147_483_647.0,
        ] {
            for step in 0..1 << 18 {
                let (sin, cos) = (f64::from(step) / f64::from(1 << 18) * TAU).sin_cos();
                check((magnitude * sin) as i32, (magnitude * cos) as i32);
            }
        }
    }

    #[test]
    fn atan2_of_small_inputs_and_at_table_borders_is_within_error() {
        for y in -300..=300 {
            for x in -300..=300 {
                check(y, x);
            }
        }
        // At each border between two points of the table, and at the limits of the range.
        for a in [8_388_608, 8_388_609, 16_777_215, 268_435_456, i32::MAX] {
            for k in 0..=128 {
                for d in -2..=2 {
                    let b = i64::from(a) * k / 128 + d;
                    let b = b.clamp(0, i64::from(i32::MAX)) as i32;
                    check(b, a);
                    check(a, b);
                    check(-b, a);
                    check(a, -b);
                }
            }
        }
    }

    #[test]
    fn centidegrees_round_to_nearest_and_wrap() {
        // 359.996 deg and 359.994 deg
        assert_eq!(Angle((359.996 / UNIT) as u32).centidegrees_unsigned(), 0);
        assert_eq!(
            Angle((359.994 / UNIT) as u32).centidegrees_unsigned(),
            35_999
        );
        assert_eq!(Angle::HALF.centidegrees(), -18_000);
        assert_eq!(Angle(Angle::HALF.0 - 1).centidegrees(), -18_000);
        assert_eq!(Angle((179.994 / UNIT) as u32).centidegrees(), 17_999);
        assert_eq!(Angle((0.004 / UNIT) as u32).centidegrees(), 0);
        assert_eq!(Angle((0.006 / UNIT) as u32).centidegrees(), 1);
        assert_eq!((-Angle((0.006 / UNIT) as u32)).centidegrees(), -1);
        assert_eq!((-Angle((0.0006 / UNIT) as u32)).millidegrees(), -1);
    }

    #[test]
    fn centidegrees_are_unchanged_after_conversion() {
        for c in 0..36_000u16 {
            let angle = Angle::from_centidegrees(c.into());
            assert!((f64::from(angle.0) * UNIT - f64::from(c) / 100.0).abs() <= 0.5001 * UNIT);
            assert_eq!(angle.centidegrees_unsigned(), c);
        }
        for c in -18_000..18_000 {
            assert_eq!(Angle::from_centidegrees(c).centidegrees(), c);
        }
    }

    proptest! {
        #[test]
        fn atan2_of_random_inputs_is_within_error(y: i32, x: i32, shift in 0..32u32) {
            check(y, x);
            check(y >> shift, x);
            check(y >> shift, x >> shift);
        }

        #[test]
        fn mirrored_point_has_mirrored_angle(y: i32, x: i32) {
            prop_assume!(y != i32::MIN && x != i32::MIN);
            let angle = Angle::atan2(y, x);
            prop_assert_eq!(Angle::atan2(-y, x), -angle);
            prop_assert_eq!(Angle::atan2(y, -x), Angle::HALF - angle);
            prop_assert_eq!(Angle::atan2(-y, -x), Angle::HALF + angle);
        }

        #[test]
        fn multiples_of_360_degrees_have_no_effect(value in -1_000_000..1_000_000i32, turns in -1000..1000i32) {
            prop_assert_eq!(
                Angle::from_centidegrees(value + turns * 36_000),
                Angle::from_centidegrees(value)
            );
        }

        #[test]
        fn addition_wraps(a: u32, b: u32) {
            let (a, b) = (Angle(a), Angle(b));
            prop_assert_eq!((a + b) - b, a);
            prop_assert_eq!(a + -a, Angle::ZERO);
            let mut c = a;
            c += b;
            c -= a;
            prop_assert_eq!(c, b);
        }
    }
}
