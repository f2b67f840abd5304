//! Property tests: the filter is stable for every pair of Q and R.

use super::*;
use crate::sweep::every;
use proptest::prelude::*;

/// Extreme components: the limits, and values beyond them.
fn component() -> impl Strategy<Value = i32> {
    prop_oneof![
        Just(i32::MIN),
        Just(i32::MAX),
        Just(0),
        any::<i32>(),
        -ONE_G..=ONE_G
    ]
}

fn vector() -> impl Strategy<Value = I32x3> {
    (component(), component(), component()).prop_map(|(x, y, z)| I32x3 { x, y, z })
}

fn noise() -> impl Strategy<Value = Noise> {
    (1..=127_i8, -10..=10_i8).prop_map(|(mantissa, exponent)| Noise::new(mantissa, exponent))
}

proptest! {
    #[test]
    fn every_pair_stays_within_14_g_for_every_input(
        q in noise(),
        r in noise(),
        inputs in prop::collection::vec((vector(), vector()), 1..20),
    ) {
        let mut fusion = tuned::<15_000>(q, r);
        for _ in 0..100 {
            for &(acceleration, rate) in &inputs {
                let up = fusion.step(acceleration, rate, true).to_array().map(f64::from);
                let length = up.iter().map(|c| c * c).sum::<f64>().sqrt() / f64::from(ONE_G);
                prop_assert!(length < 14.0, "{length} g");
            }
        }
    }

    #[test]
    fn every_pair_settles_or_follows_the_gyroscope(q in noise(), r in noise()) {
        // At rest from an error of 10 deg, with a bias: the error must never grow beyond the rotation by the bias.
        let mut fusion = tuned::<DELAY>(q, r);
        fusion.settle(integers(Axes::Two.up(10_f64.to_radians()), ONE_G.into()));
        let motion = Motion { bias: 0.1, ..Motion::REST };
        let outputs = motion.run(&mut fusion, 60.0 / every(3) as f64);
        let excess = outputs.iter().enumerate().map(|(n, o)| o.error.abs() - 10.0 - 0.1 * n as f64 * PERIOD);
        prop_assert!(excess.fold(0.0, f64::max) < 0.01);
    }
}
