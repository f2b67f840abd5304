//! Vibration behind the filters of a sensor built for the PC. `images/vibration.rs` has a few frequencies, with the flashed
//! image.

use bench::{Device, Flash, NodeType};
use host_tests::effort;
use host_tests::vibration::{
    CLOCKS, CUTOFFS, FREQUENCIES, SELECTED, Shaker, check_cutoffs, check_residue,
};

/// An is2 whose accelerometer has this clock error in percent.
fn shaker(clock: i32) -> Shaker {
    let node_type = NodeType::find("is2").expect("a product");
    Shaker::new(|bus, motion| {
        let device = Device::new(&node_type, 1, Flash::default(), motion);
        bus.attach(device.with_clock_deviation(clock * 10_000));
        bus.lead_detection();
    })
}

#[test]
fn vibration_from_8_to_400_hz_is_suppressed() {
    for clock in CLOCKS {
        let frequencies = effort::choose(SELECTED.to_vec(), FREQUENCIES.collect());
        check_residue(&mut shaker(clock), &frequencies);
    }
}

#[test]
fn cutoff_frequencies_are_within_0_15_percent() {
    for clock in CLOCKS {
        check_cutoffs(&mut shaker(clock), &CUTOFFS);
    }
}
