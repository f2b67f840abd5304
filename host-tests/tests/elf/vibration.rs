//! Vibration behind the filters of the flashed image, at the clock errors of the accelerometer. `tests/vibration.rs` has the same
//! tests of a sensor built for the PC.

use crate::rig::{fixed, image, node_type};
use host_tests::vibration::{FREQUENCIES, RATE, Shaker, check_cutoffs, check_residue};
use stm32_sim::Microcontroller;

/// An is2 whose accelerometer has this clock error in percent.
fn shaker(clock: i32) -> Shaker {
    let name = node_type("is2").name;
    Shaker::new(|bus, motion| {
        let memory = fixed(name, RATE);
        let mut microcontroller = Microcontroller::new(name, image(name), 1, memory, motion);
        let accelerometer = &mut microcontroller.io_mut().imu;
        accelerometer.set_clock_deviation(0, clock.into());
        bus.attach(microcontroller);
    })
}

#[test]
fn vibration_is_suppressed_with_nominal_accelerometer() {
    check_residue(&mut shaker(0), FREQUENCIES);
}

blue_pill_only! {
#[test]
fn vibration_is_suppressed_with_slow_accelerometer() {
    check_residue(&mut shaker(-5), FREQUENCIES);
}

#[test]
fn vibration_is_suppressed_with_fast_accelerometer() {
    check_residue(&mut shaker(5), FREQUENCIES);
}

#[test]
fn cutoff_frequencies_are_within_0_15_percent_with_slow_accelerometer() {
    check_cutoffs(&mut shaker(-5));
}

#[test]
fn cutoff_frequencies_are_within_0_15_percent_with_fast_accelerometer() {
    check_cutoffs(&mut shaker(5));
}
}
