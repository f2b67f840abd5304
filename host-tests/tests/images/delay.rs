//! The delay of the angle of the flashed images. `sensor/delay.rs` has all filters, with a sensor built for the PC.

use crate::rig::{blank, image};
use host_tests::delay::{FUSION, IS2_OFF, JN2101_OFF, OFF, TILTIX080_OFF, check, delay};
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
