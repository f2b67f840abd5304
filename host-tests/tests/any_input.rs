//! No input, no power cut and no bus fault may make a sensor panic, hang or lose a saved parameter.

use host_tests::fuzz::Sensor;
use plumbline::model::catalog::PRODUCTS;

/// Steps for each model.
const STEPS: u64 = 2_000_000;
/// Steps before the attack begins anew with a fresh sensor.
const ROUND: u64 = 2_000;

/// Random bytes: xorshift64*.
fn random(seed: u64) -> impl Iterator<Item = u8> {
    let mut state = seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1;
    std::iter::repeat_with(move || {
        state ^= state >> 12;
        state ^= state << 25;
        state ^= state >> 27;
        (state.wrapping_mul(0x2545_F491_4F6C_DD1D) >> 56) as u8
    })
}

#[test]
fn two_million_steps_for_each_model() {
    for product in PRODUCTS {
        let mut counts = [0; 4];
        for seed in 1..=STEPS / ROUND {
            let result = std::panic::catch_unwind(|| {
                let mut source = random(seed);
                let mut sensor = Sensor::new(product);
                (0..ROUND).for_each(|_| sensor.step(&mut source));
                [
                    sensor.restarts,
                    sensor.power_cuts,
                    sensor.saves,
                    sensor.sent,
                ]
            });
            let round = result.unwrap_or_else(|_| panic!("{} with seed {seed}", product.name));
            counts
                .iter_mut()
                .zip(round)
                .for_each(|(sum, count)| *sum += count);
        }
        let [restarts, power_cuts, saves, sent] = counts;
        println!(
            "{}: {STEPS} steps, {sent} frames, {saves} saves, {restarts} restarts, {power_cuts} power cuts",
            product.name
        );
        // The attack must get somewhere, or it shows nothing.
        assert!(
            restarts > 100 && power_cuts > 1000 && saves > 100 && sent > 10_000,
            "{counts:?}"
        );
    }
}
