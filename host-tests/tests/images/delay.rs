//! The delay of the angle of the flashed IMS360. `sensor/delay.rs` has all filters, with a sensor built for the PC.

use crate::rig::{blank, image};
use host_tests::delay::{FUSION, OFF, check, delay};
use stm32_sim::Microcontroller;

#[test]
fn delay_is_the_stated_one() {
    for setting in [&OFF, &FUSION] {
        let measured = delay(setting, |bus, motion| {
            bus.attach(Microcontroller::new(
                "ims360",
                image("ims360"),
                1,
                blank(),
                motion,
            ));
        });
        check(setting, measured);
    }
}
