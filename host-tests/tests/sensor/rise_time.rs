//! The filters of a TILTIX built for the PC, at the clock errors of the accelerometer. `images/tiltix.rs` has a filter of the flashed
//! image.

use bench::{Device, Flash, NodeType};
use host_tests::rise_time::{FILTERS, check, rise_time};

#[test]
fn rise_times_are_those_of_the_manual_at_each_clock_error() {
    let node_type = NodeType::find("tiltix080").expect("a product");
    for filter in FILTERS {
        for clock in [-5, 0, 5] {
            let measured = rise_time(filter, |bus, motion| {
                let device = Device::new(&node_type, 1, Flash::default(), motion);
                bus.attach(device.with_clock_deviation(clock * 10_000));
            });
            check(filter, measured);
        }
    }
}
