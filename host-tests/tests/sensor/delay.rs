//! The delay of the angle of an IMS360 built for the PC. `images/delay.rs` has that of the flashed image.

use bench::{Device, Flash, NodeType};
use host_tests::delay::{SETTINGS, check, delay};

#[test]
fn delay_is_the_stated_one() {
    let node_type = NodeType::find("ims360").expect("a product");
    for setting in SETTINGS {
        let measured = delay(setting, |bus, motion| {
            bus.attach(Device::new(&node_type, 1, Flash::default(), motion));
        });
        check(setting, measured);
    }
}
