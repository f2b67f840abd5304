//! The numbers of the JN2101's filter do what the manual says of them (7.7, 9.4).

use crate::tester::canopen::*;

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
