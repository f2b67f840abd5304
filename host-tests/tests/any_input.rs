//! A sensor does not panic, hang or lose a saved parameter with any input, power cut or bus fault.

use host_tests::fuzz::Sensor;
use plumbline::model::catalog::{PRODUCTS, Protocol};

/// Steps for each product.
const STEPS: u64 = 2_000_000;
/// Steps with one sensor; the next round uses a new sensor.
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
fn two_million_random_steps_of_each_product_neither_panic_nor_lose_parameters() {
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
        // The input must cause enough restarts, power cuts, saves and frames, or the test shows nothing. A sensor with CANopen
        // resets itself without a restart.
        let restarted = match product.protocol {
            Protocol::Fsc(_) | Protocol::Devicenet(_) => restarts > 100,
            Protocol::Canopen(_) => restarts == 0,
        };
        assert!(
            restarted && power_cuts > 1000 && saves > 100 && sent > 10_000,
            "{counts:?}"
        );
    }
}
