//! The filter after a gap in the samples.

use super::*;

#[test]
fn filter_keeps_direction_and_bias_after_a_gap() {
    let motion = Motion {
        bias: 2.0,
        ..Motion::REST
    };
    let mut fusion = tuned::<DELAY>(Q[1], R);
    motion.run(&mut fusion, 60.0);
    fusion.skip();
    assert!(largest(&motion.run(&mut fusion, 5.0)) < 1e-3);
    fusion.skip();
    // The acceleration after the gap is that of a shock.
    let shock = I32x3 {
        x: 6 * ONE_G,
        y: 0,
        z: ONE_G,
    };
    let still = integers([0.0, 2.0, 0.0], 65_536.0);
    let angle = perpendicular(fusion.step(shock, still, true)).x;
    // The first sample after the gap has the weight 2 / 102.
    assert!(angle.millidegrees().abs() < 6_800, "{angle:?}");
}

#[test]
fn filter_corrects_rotation_in_a_gap_with_weight_of_100_samples() {
    let mut fusion = tuned::<DELAY>(Q[2], R);
    Motion::REST.run(&mut fusion, 60.0);
    fusion.skip();
    let turned = Motion {
        angle: &|_| 10.0,
        ..Motion::REST
    };
    let outputs = turned.run(&mut fusion, 2.0);
    // The product of 1 - 2 / (n + 1) for n = 101 to 500. With the steady-state gain, an error of 2.8 deg would remain.
    let error = outputs[399].error.abs();
    let expected = 10.0 * (100.0 * 101.0) / (500.0 * 501.0);
    assert!((error - expected).abs() < 0.03, "{error} deg");
}
