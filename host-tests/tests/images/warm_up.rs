//! Warm-up of GEMAC's reference line with the image: AccuracyWarning over minutes (manual 9.3 and 9.5.2).

#[allow(dead_code)] // the test `sensor` uses all of it
#[path = "../sensor/warm_up/heated.rs"]
mod heated;

use crate::rig::{SERIAL, blank, image, node_type};
use heated::{Bench, RUNNING_TIME, recording};
use host_tests::effort;
use plumbline::time::{after, millis};
use stm32_sim::Microcontroller;

#[test]
#[ignore = "takes minutes of simulated time: `.ci/long ignored`"]
fn warning_of_the_image_is_cleared_within_minutes_and_stays_cleared_over_a_reset() {
    // With the cell of the accelerometer, which the heater warms.
    let node_type = node_type("is2tk");
    let motion = recording("reset-image.csv", &[(0, 50.0)]);
    let mut bench = Bench::of(Microcontroller::of_type(
        &node_type,
        image("is2tk"),
        SERIAL,
        blank(),
        motion,
    ));
    let seconds = bench.warning_becomes(false);
    assert!((60..RUNNING_TIME).contains(&seconds), "{seconds}");
    let again = effort::choose(5, 30);
    bench.stays_accurate(seconds + again);
    assert!(!bench.reset());
    bench.stays_accurate(seconds + 2 * again);
    // The memory is lost with the power.
    let now = bench.bus.now();
    bench.bus.device_mut(bench.device).power_off(now);
    bench.bus.run_until(after(now, millis(100)));
    let now = bench.bus.now();
    bench.bus.device_mut(bench.device).power_on(now);
    bench.boot();
    assert!(bench.warns());
}
