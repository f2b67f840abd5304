//! Tests of the gain against double precision.

use super::*;
use proptest::prelude::*;

fn value(noise: Noise) -> f64 {
    f64::from(noise.mantissa) * 10_f64.powi(noise.exponent.into())
}

/// The gain in double precision.
fn exact(q: Noise, r: Noise) -> f64 {
    let relation = value(r) / value(q) * (200.0 / 80.0) * (200.0 / 80.0);
    2.0 / (1.0 + (1.0 + 4.0 * relation).sqrt())
}

fn noises() -> impl Strategy<Value = Noise> {
    (1..=127_i8, -10..=10_i8).prop_map(|(mantissa, exponent)| Noise::new(mantissa, exponent))
}

#[test]
fn factory_setting_has_the_gain_of_its_formula() {
    // Q / R is 0.0001 at 80 Hz, 0.000016 at 200 Hz.
    let q31 = f64::from(gain(Noise::new(1, -3), Noise::new(1, 1)));
    let expected = 2.0 / (1.0 + (1.0 + 4.0 / 0.000_016_f64).sqrt());
    assert!((q31 / 2_147_483_648.0 / expected - 1.0).abs() < 1e-6);
}

#[test]
fn numbers_outside_their_ranges_are_limited() {
    assert_eq!(Noise::new(0, -11), Noise::new(1, -10));
    assert_eq!(Noise::new(i8::MIN, i8::MIN), Noise::new(1, -10));
    assert_eq!(Noise::new(1, 11), Noise::new(1, 10));
    assert_eq!(Noise::new(127, i8::MAX), Noise::new(127, 10));
}

#[test]
fn gain_increases_with_each_larger_quotient() {
    let mut gains: Vec<(f64, u32)> = Vec::new();
    for exponent in -10..=0 {
        for mantissa in 1..=127 {
            for r in [Noise::new(1, 1), Noise::new(7, 0), Noise::new(127, -4)] {
                let q = Noise::new(mantissa, exponent);
                gains.push((value(q) / value(r), gain(q, r)));
            }
        }
    }
    gains.sort_by(|(a, _), (b, _)| a.total_cmp(b));
    for pair in gains.windows(2) {
        let [(low, small), (high, large)] = pair else {
            unreachable!()
        };
        if high / low > 1.0 + 1e-9 {
            assert!(small <= large, "{low} {small} {high} {large}");
        }
        if high / low > 1.001 && *small > 10_000 {
            assert!(small < large, "{low} {small} {high} {large}");
        }
    }
}

proptest! {
    #[test]
    fn gain_of_every_pair_is_within_one_millionth(q in noises(), r in noises()) {
        let (got, expected) = (f64::from(gain(q, r)), exact(q, r) * 2_147_483_648.0);
        prop_assert!((got - expected).abs() <= expected * 1e-6 + 2.0, "{got} {expected}");
        prop_assert!((1.0..=2_147_483_647.0).contains(&got));
    }

    #[test]
    fn equal_quotients_have_equal_gains(a in 1..=12_i8, b in 1..=12_i8, factor in 1..=10_i8, e in -9..=9_i8, f in -9..=9_i8, both in -1..=1_i8) {
        let plain = gain(Noise::new(a, e), Noise::new(b, f));
        prop_assert_eq!(gain(Noise::new(a * factor, e), Noise::new(b * factor, f)), plain);
        prop_assert_eq!(gain(Noise::new(a, e + both), Noise::new(b, f + both)), plain);
        if e > -10 {
            prop_assert_eq!(gain(Noise::new(a * 10, e - 1), Noise::new(b, f)), plain);
        }
        if f > -10 {
            prop_assert_eq!(gain(Noise::new(a, e), Noise::new(b * 10, f - 1)), plain);
        }
    }

    #[test]
    fn half_is_one_over_two_and_five_over_ten(e in -9..=9_i8) {
        let one = Noise::new(1, 0);
        let half = gain(Noise::new(5, e), one);
        prop_assert_eq!(gain(Noise::new(50, e - 1), one), half);
        prop_assert_eq!(gain(Noise::new(1, e + 1), Noise::new(2, 0)), half);
    }
}
