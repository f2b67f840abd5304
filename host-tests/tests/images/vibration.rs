//! Vibration behind the filters of the flashed image, at the clock errors of the accelerometer. `sensor/vibration.rs` has all frequencies
//! and filters, with a sensor built for the PC.

use crate::rig::{fixed, node_type, part};
use host_tests::effort;
use host_tests::vibration::{
    CUTOFFS, FREQUENCIES, RATE, SHORTEST, Shaker, check_cutoffs, check_residue,
};

/// Frequencies beside a multiple of the 200 readings in a second, which a wrong conversion of the data rate turns into slow motions, and the
/// highest one.
const NORMAL: [u32; 3] = [199, 201, *FREQUENCIES.end()];

/// An is2 whose accelerometer has this clock error in percent.
fn shaker(clock: i32) -> Shaker {
    let name = node_type("is2").name;
    Shaker::new(|bus, motion| {
        let memory = fixed(name, RATE);
        let mut microcontroller = part(name, 1, memory, motion);
        let accelerometer = &mut microcontroller.io_mut().imu;
        accelerometer.set_clock_deviation(0, clock.into());
        bus.attach(microcontroller);
    })
}

/// Checks a vibration with this clock error.
#[track_caller]
fn suppresses(clock: i32) {
    let frequencies = effort::choose(NORMAL.to_vec(), FREQUENCIES.collect());
    check_residue(&mut shaker(clock), &frequencies);
}

#[test]
fn vibration_is_suppressed_with_nominal_accelerometer() {
    suppresses(0);
}

#[test]
fn vibration_is_suppressed_with_slow_accelerometer() {
    suppresses(-5);
}

#[test]
fn vibration_is_suppressed_with_fast_accelerometer() {
    suppresses(5);
}

#[test]
fn cutoff_frequency_is_exact_at_each_clock_error() {
    let filters = effort::choose(&[SHORTEST][..], &CUTOFFS);
    for clock in [-5, 5] {
        check_cutoffs(&mut shaker(clock), filters);
    }
}
