//! The delay of the angle of sensors built for the PC. `images/delay.rs` has that of a flashed image.

use bench::{Device, Flash, NodeType};
use host_tests::delay::{SETTINGS, check, delay};

#[test]
fn delay_is_the_stated_one() {
    for setting in &SETTINGS {
        let node_type = NodeType::find(setting.product.name).expect("a product");
        let measured = delay(setting, |bus, motion| {
            bus.attach(Device::new(&node_type, 1, Flash::default(), motion));
        });
        check(setting, measured);
    }
}
