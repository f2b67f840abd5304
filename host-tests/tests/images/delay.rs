//! The delay of the angle of the flashed images. `sensor/delay.rs` has all filters, with a sensor built for the PC.

use crate::rig::{Rig, blank, fsc, image};
use host_tests::delay::{FUSION, IS2_OFF, JN2101_OFF, OFF, TILTIX080_OFF, check, delay};
use plumbline::can::BitRate;
use stm32_sim::Microcontroller;

#[test]
fn delay_is_the_stated_one() {
    for setting in [&OFF, &FUSION, &IS2_OFF, &JN2101_OFF, &TILTIX080_OFF] {
        let name = setting.product.name;
        let measured = delay(setting, |bus, motion| {
            bus.attach(Microcontroller::new(name, image(name), 1, blank(), motion));
        });
        check(setting, measured);
    }
}

/// A frame that wakes the main loop between two milliseconds does not read the accelerometer earlier: that would shift the newest angle by up
/// to 1 ms, depending on the time of the boot.
#[test]
fn accelerometer_is_read_every_5_ms_also_when_frames_wake_the_main_loop() {
    const STEP_US: u64 = 20;
    let mut rig = Rig::booted("is2", BitRate::K500);
    let mut starts = Vec::new();
    let mut last = 0;
    for step in 0..10_000 {
        // At all times between two readings.
        if step % 37 == 0 {
            rig.send(&[fsc::INCLINATION]);
        }
        rig.run_us(STEP_US);
        let (io, _) = rig.io();
        if io.spi.is_busy() {
            if step - last > 2_000 / STEP_US {
                starts.push(step);
            }
            last = step;
        }
    }
    let periods: Vec<u64> = starts
        .windows(2)
        .map(|pair| (pair[1] - pair[0]) * STEP_US)
        .collect();
    assert!(periods.len() >= 38, "{periods:?}");
    let is_even = |period: &u64| (4_900..=5_100).contains(period);
    assert!(periods.iter().all(is_even), "{periods:?}");
}
