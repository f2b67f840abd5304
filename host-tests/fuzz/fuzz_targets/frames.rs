//! The steps of `host_tests::fuzz::Sensor`: requests of the product, samples, times, bus events, a failing memory, power cuts.
//! `Sensor::step` and `Sensor::finish` check what the sensor does.
//!
//! | byte of the input | what |
//! |---|---|
//! | 0 | the product: its number in the catalogue, or the number after the last one: the IMS360 in J1939; modulo that number + 1 |
//! | 1 to 36, 37 to 72, ... | one step each: byte 0 of it chooses the step as `Sensor::step` says, and the others are its source |
//!
//! A step that needs fewer bytes ignores the others; one that needs more reads zeros.

#![no_main]

use host_tests::fuzz::Sensor;
use libfuzzer_sys::{fuzz_crossover, fuzz_mutator, fuzz_target};

/// The bytes of a step in the input: as many as a reading needs.
const STEP: usize = 36;

fuzz_target!(|input: &[u8]| {
    let Some((&product, steps)) = input.split_first() else {
        return;
    };
    let mut sensor = Sensor::of_kind(product.into());
    for step in steps.chunks(STEP) {
        sensor.step(&mut step.iter().copied());
    }
    sensor.finish();
});

fuzz_mutator!(|data: &mut [u8], size: usize, max_size: usize, seed: u32| {
    fuzz::mutate::<STEP>(data, size, max_size, seed)
});

fuzz_crossover!(|one: &[u8], other: &[u8], joined: &mut [u8], seed: u32| {
    fuzz::cross_over::<STEP>(one, other, joined, seed)
});
