//! The numbers of the JN2101's baud rate and filter do what the manual says of them (7.7, 9.4).

use crate::tester::canopen::*;
use plumbline::can::BitRate;
use plumbline::node::{Action, BusMode};

#[test]
fn saved_baud_rate_is_used_after_a_power_cycle() {
    let rates = [
        (10, BitRate::K10),
        (20, BitRate::K20),
        (50, BitRate::K50),
        (125, BitRate::K125),
        (250, BitRate::K250),
        (500, BitRate::K500),
        (800, BitRate::K800),
        (1000, BitRate::M1),
    ];
    for (number, rate) in rates {
        let mut t = booted();
        t.write(0x2001, 0, 2, number).unwrap();
        t.write(0x1010, 1, 4, u32::from_le_bytes(*b"save")).unwrap();
        t.power_cycle();
        assert_eq!(t.sent_text(), ["70A#00"]);
        let online = Action::Bus(BusMode::Normal, rate);
        assert!(t.actions.contains(&online), "{number}: {:?}", t.actions);
    }
}

#[test]
fn each_filter_settles_after_its_own_time() {
    // In samples of 5 ms: the time after which a step has passed the whole filter.
    for (number, settled) in [(0, 1), (1, 13), (2, 29), (3, 157), (4, 317)] {
        let mut t = booted();
        t.write(0x2043, 0, 1, number).unwrap();
        t.tilt(0.0, 0.0);
        let (x, z) = (-20_f64.to_radians().sin(), 20_f64.to_radians().cos());
        let force = in_g([x, 0.0, z]);
        // The slower filters take every 2nd, 8th or 16th sample, so that a step may wait for one.
        let mut samples = 0;
        while t.read_i16(0x6010) != 2000 {
            t.hold(force, 1);
            samples += 1;
            assert!(samples <= settled + 16, "filter {number} does not settle");
        }
        assert!(
            (3 * settled / 4..=settled + 16).contains(&samples),
            "filter {number} settles after {samples} samples"
        );
    }
}
