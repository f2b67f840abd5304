//! The image of the IMS360.

use crate::rig::*;
use bench::motion::Motion;
use bench::script::LEVEL;
use plumbline::measure::{I32x3, Reading};

/// Level, with an angular rate of 10 deg/s.
fn turning() -> Box<dyn Motion> {
    Box::new(Reading {
        angular_rate: I32x3 {
            x: 0,
            y: 10 << 16,
            z: 0,
        },
        ..LEVEL
    })
}

#[test]
pub fn image_measures_supply_and_angular_rate() {
    let mut rig = Rig::ims360(turning());
    rig.run(100);
    assert_eq!(rig.upload(0x1000, 0), 0x0704_019A);
    // 3020h:02 in 0.1 deg/s, within the tolerance of the part.
    let rate = rig.upload(0x3020, 2);
    assert!((95..=105).contains(&rate), "{rate}");
    // 2020h:01 in mV.
    let supply = rig.upload(0x2020, 1);
    assert!((23_700..=24_300).contains(&supply), "{supply}");
}
