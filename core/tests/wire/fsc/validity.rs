//! What the FSC sensors tell of an accelerometer that clips, is dead or lies on its back, and which zero points they refuse.

use crate::tester::Tester;
use crate::tester::fsc::*;
use plumbline::can::{Frame, standard};
use plumbline::measure::ONE_G;
use plumbline::model::gemac::is2::TwoAxes;
use plumbline::node::Node;

const X: u8 = 0x10;
const Y: u8 = 0x20;
const BOTH: u8 = 0x30;

/// The sensor errors in the status byte.
fn errors<N: Node>(tester: &mut Tester<N>) -> u8 {
    tester.ask(&[0x02])[1] & BOTH
}

#[test]
fn clipping_for_longer_than_100_ms_sets_sensor_errors() {
    let mut tester = is2();
    tester.clip(20);
    assert_eq!(errors(&mut tester), 0, "100 ms");
    tester.clip(1);
    assert_eq!(errors(&mut tester), BOTH);
    tester.hold([0, 0, ONE_G], 19);
    assert_eq!(errors(&mut tester), BOTH, "for 100 ms");
    tester.hold([0, 0, ONE_G], 1);
    assert_eq!(errors(&mut tester), 0);
    let mut tester = is1();
    tester.clip(21);
    assert_eq!(errors(&mut tester), X);
}

#[test]
fn implausible_acceleration_sets_sensor_errors_after_half_a_second() {
    let mut tester = is2();
    tester.hold([0, 0, 0], 99);
    assert_eq!(errors(&mut tester), 0);
    tester.hold([0, 0, 0], 20);
    assert_eq!(errors(&mut tester), BOTH);
    tester.hold([0, 0, ONE_G], 99);
    assert_eq!(errors(&mut tester), BOTH);
    tester.hold([0, 0, ONE_G], 20);
    assert_eq!(errors(&mut tester), 0);
    let mut tester = is1();
    tester.hold([0, 2 * ONE_G, 0], 120);
    assert_eq!(errors(&mut tester), X);
}

#[test]
fn first_reading_of_a_dead_accelerometer_sets_sensor_errors() {
    let mut tester = is2();
    tester.force = [0, 0, 0];
    tester.power_cycle();
    tester.receive(Frame::data(standard(0x7FF), &[]).unwrap());
    tester.sent();
    assert_eq!(errors(&mut tester), BOTH);
}

#[test]
fn two_axis_sensor_on_its_back_is_out_of_range() {
    let mut tester = is2();
    for (degrees, expected) in [
        (80.0, 0),
        (88.0, Y),
        (91.0, BOTH),
        (180.0, BOTH),
        (270.5, BOTH),
        // 0.02 g are 1.15 deg.
        (272.0, Y),
        (280.0, 0),
    ] {
        let (y, z) = f64::sin_cos(f64::to_radians(degrees));
        let [y, z] = [y, z].map(|part| (part * f64::from(ONE_G)) as i32);
        tester.rest(0, y, z);
        assert_eq!(errors(&mut tester), expected, "{degrees} deg");
    }
    // The angle of one axis has the whole circle.
    let mut tester = is1();
    tester.rest(0, -ONE_G, -ONE_G / 100);
    assert_eq!(errors(&mut tester), 0);
}

/// Level and on its back: a shock of 6 g against gravity for 20 ms, twice a second, for 10 s.
#[test]
fn shocks_do_not_change_errors_of_level_or_overturned_sensor() {
    for (gravity, expected) in [(ONE_G, 0), (-ONE_G, BOTH)] {
        let mut tester = is2();
        tester.rest(0, 0, gravity);
        for sample in 0..2000 {
            let g = if sample % 100 < 4 { -6 } else { 1 };
            tester.hold([0, 0, g * gravity], 1);
            assert_eq!(errors(&mut tester), expected, "sample {sample}");
        }
    }
}

#[test]
fn overturned_sensor_is_out_of_range_after_100_ms_and_immediately_at_power_up() {
    let mut tester = is2();
    tester.rest(0, 0, ONE_G);
    tester.hold([0, 0, -ONE_G], 19);
    assert_eq!(errors(&mut tester), 0);
    tester.hold([0, 0, -ONE_G], 1);
    assert_eq!(errors(&mut tester), BOTH);
    tester.power_cycle();
    tester.receive(Frame::data(standard(0x7FF), &[]).unwrap());
    for frame in tester.sent() {
        assert_eq!(frame.bytes()[1] & BOTH, BOTH, "{frame:?}");
    }
}

/// What happens before a request, with its name.
type Case = (&'static str, fn(&mut FscTester<TwoAxes>));

/// 28h and 29h without data take the present angle (9.2).
#[test]
fn zero_point_without_a_valid_angle_is_refused() {
    let cases: [Case; 4] = [
        ("a sample clips", |tester| tester.clip(1)),
        ("stale", |tester| drop(tester.wait_without_samples(200))),
        ("dead", |tester| tester.hold([0, 0, 0], 120)),
        ("too long", |tester| tester.hold([0, 0, 2 * ONE_G], 120)),
    ];
    for (name, happens) in cases {
        let mut tester = is2();
        tester.rest(-ONE_G / 2, 0, ONE_G);
        tester.ask(&[0x28, 0x64, 0x00]);
        happens(&mut tester);
        for code in [0x28, 0x29] {
            let reply = tester.ask(&[code]);
            assert_eq!(reply[1] & CMD_PARAM_ERROR, CMD_PARAM_ERROR, "{name}");
            // Reading the status clears the error.
            tester.ask(&[0x02]);
        }
        assert_eq!(tester.ask(&[0x18])[2..], [0x64, 0x00], "{name}");
        assert_eq!(tester.ask(&[0x19])[2..], [0, 0], "{name}");
        // A number is not measured.
        assert_eq!(tester.ask(&[0x28, 0x32, 0x00])[1] & CMD_PARAM_ERROR, 0);
        tester.rest(0, 0, ONE_G);
        assert_eq!(tester.ask(&[0x28])[1] & CMD_PARAM_ERROR, 0, "{name}");
        assert_eq!(tester.ask(&[0x18])[2..], [0, 0], "{name}");
    }
}
