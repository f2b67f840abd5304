//! A sensor does not panic, hang or lose a saved parameter with any input, power cut or bus fault.

use host_tests::effort;
use host_tests::fuzz::Sensor;
use plumbline::model::catalog::{PRODUCTS, Protocol, find};

/// Rounds for each product: in the normal run, and in the long one.
const ROUNDS: [u64; 2] = [50, 1_000];
/// Steps of a round with one sensor; the next round uses a new sensor.
const STEPS: u64 = 2_000;

/// An endless stream of random bytes (xorshift64*).
fn random(seed: u64) -> impl Iterator<Item = u8> {
    let mut state = seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1;
    std::iter::repeat_with(move || {
        state ^= state >> 12;
        state ^= state << 25;
        state ^= state >> 27;
        (state.wrapping_mul(0x2545_F491_4F6C_DD1D) >> 56) as u8
    })
}

/// Runs random steps in rounds. Returns restarts, power cuts, saves, sent frames, claims, packets in 1000 rounds.
fn run(name: &str, make: impl Fn() -> Sensor + std::panic::RefUnwindSafe) -> [u64; 6] {
    let mut counts = [0; 6];
    let [normal, long] = ROUNDS;
    let rounds = effort::choose(normal, long);
    for seed in 1..=rounds {
        let result = std::panic::catch_unwind(|| {
            let mut source = random(seed);
            let mut sensor = make();
            (0..STEPS).for_each(|_| sensor.step(&mut source));
            sensor.finish();
            [
                sensor.restarts,
                sensor.power_cuts,
                sensor.saves,
                sensor.sent,
                sensor.claims,
                sensor.packets,
            ]
        });
        let round = result.unwrap_or_else(|_| panic!("{name} with seed {seed}"));
        counts
            .iter_mut()
            .zip(round)
            .for_each(|(sum, count)| *sum += count);
    }
    let [restarts, power_cuts, saves, sent, claims, packets] = counts;
    println!(
        "{name}: {rounds} rounds, {sent} frames, {saves} saves, {restarts} restarts, {power_cuts} power cuts, \
         {claims} claims, {packets} packets"
    );
    counts.map(|count| count * 1_000 / rounds)
}

#[test]
fn random_steps_of_each_product_neither_panic_nor_lose_parameters() {
    for product in PRODUCTS {
        let counts = run(product.name, || Sensor::new(product));
        let [restarts, power_cuts, saves, sent, ..] = counts;
        // The input must cause enough restarts, power cuts, saves and frames, or the test shows nothing. A sensor with CANopen
        // resets itself without a restart.
        let restarted = match product.protocol {
            Protocol::Fsc(_) | Protocol::Devicenet(_) => restarts > 100,
            Protocol::Canopen(_) | Protocol::J1939(_) => restarts == 0,
        };
        assert!(
            restarted && power_cuts > 1000 && saves > 100 && sent > 10_000,
            "{counts:?}"
        );
    }
}

#[test]
fn random_steps_in_j1939_neither_panic_nor_break_the_rules_of_the_address() {
    let product = find("ims360").expect("a product");
    let counts = run("ims360 in J1939", || {
        Sensor::in_j1939(product).expect("J1939")
    });
    let [_, power_cuts, saves, sent, claims, packets] = counts;
    assert!(
        power_cuts > 1000 && saves > 100 && sent > 10_000 && claims > 5000 && packets > 1000,
        "{counts:?}"
    );
}
