//! Measurement and actions of the JN2101 (manual 7.7, 8, 9).

use crate::tester::canopen::*;
use plumbline::node::{Action, Node};

const DEVICE_STATE: u32 = 0x0800_0022;

pub fn angles(t: &mut Jn2101Tester) -> (i16, i16) {
    (t.read_i16(0x6010), t.read_i16(0x6020))
}

/// The up vector of the excavator of 8.5 on a slope of 30 deg, rotated by `heading` deg from the uphill direction.
fn embankment(heading: f64) -> [f64; 3] {
    let (slope, heading) = (30_f64.to_radians(), heading.to_radians());
    [
        -slope.sin() * heading.sin(),
        -slope.sin() * heading.cos(),
        slope.cos(),
    ]
}

#[test]
fn excavator_example_of_manual_gives_its_angles() {
    // 8.5, positions 1 to 6: longitudinal and lateral for perpendicular, Euler, gimbal X and gimbal Y. Position 3 is printed
    // truncated to integer degrees: 20.70 and -22.21.
    let undefined = i16::MAX;
    let table = [
        ([0.0, 0.0, 1.0], [(0, 0), (0, undefined), (0, 0), (0, 0)]),
        (
            embankment(0.0),
            [(0, -3000), (3000, 0), (0, -3000), (0, -3000)],
        ),
        (
            embankment(45.0),
            [(2070, -2070), (3000, 4500), (2070, -2221), (2221, -2070)],
        ),
        (
            embankment(90.0),
            [(3000, 0), (3000, 9000), (3000, 0), (3000, 0)],
        ),
        (
            embankment(180.0),
            [(0, 3000), (3000, 18_000), (0, 3000), (0, 3000)],
        ),
    ];
    for (up, expected) in table {
        let mut t = booted();
        t.settle_at(up);
        for (definition, (longitudinal, lateral)) in (0..).zip(expected) {
            t.write(0x2044, 0, 1, definition).unwrap();
            let got = angles(&mut t);
            assert!(
                (got.0 - longitudinal).abs() <= 1,
                "{up:?} {definition}: {got:?}"
            );
            if lateral != undefined {
                // At +-180 deg both signs are correct.
                let error = (got.1.abs() - lateral.abs()).abs();
                assert!(error <= 1, "{up:?} {definition}: {got:?}");
                assert!(
                    got.1.signum() == lateral.signum() || lateral == 18_000 || got.1.abs() <= 1
                );
            }
        }
    }
}

#[test]
fn half_turn_is_plus_180_degrees() {
    let mut t = booted();
    t.write(0x2044, 0, 1, 1).unwrap();
    t.settle_at([0.0, 0.5, 0.75_f64.sqrt()]);
    assert_eq!(angles(&mut t), (3000, 18_000));
}

#[test]
fn quadrant_correction_extends_lateral_euler_angle() {
    // Direction 225 deg: -135 deg, and 45 deg without correction.
    let up = embankment(225.0);
    for (quadrants, lateral) in [(0, 4500), (1, -13_500), (2, 22_500)] {
        let mut t = booted();
        t.settle_at(up);
        t.write(0x2044, 0, 1, 1).unwrap();
        t.write(0x2040, 0, 1, quadrants).unwrap();
        let (slope, direction) = angles(&mut t);
        assert!((slope - 3000).abs() <= 1 && (direction - lateral).abs() <= 1);
        // The other definitions have no quadrant correction.
        t.write(0x2044, 0, 1, 0).unwrap();
        assert_eq!(angles(&mut t), (-2070, 2070));
    }
}

#[test]
fn resolution_scales_angles_and_16_bit_values_saturate() {
    let mut t = booted();
    t.tilt(40.0, -35.5);
    for (resolution, x, y) in [
        (1, 40_000, -35_500),
        (10, 4000, -3550),
        (100, 400, -355),
        (1000, 40, -36),
    ] {
        t.write(0x6000, 0, 2, resolution).unwrap();
        let (x32, y32) = (t.read_i32(0x6110), t.read_i32(0x6120));
        // Half a unit can be rounded up or down.
        assert!(
            (x32 - x).abs() <= 1 && (y32 - y).abs() <= 1,
            "{resolution}: {x32} {y32}"
        );
        let limited = |value: i32| value.clamp(-32_768, 32_767) as i16;
        assert_eq!(angles(&mut t), (limited(x32), limited(y32)));
    }
    t.write(0x6000, 0, 2, 1).unwrap();
    assert_eq!(angles(&mut t), (32_767, -32_768));
    t.send("000#0100");
    assert_eq!(t.exchange("080#")[0], "18A#FF7F0080");
    // 9.10: -2370 is -23.70 deg.
    t.write(0x6000, 0, 2, 10).unwrap();
    t.tilt(-23.7, 0.0);
    assert_eq!(angles(&mut t), (-2370, 0));
}

#[test]
fn zero_point_is_subtracted_until_reset() {
    let mut t = booted();
    t.tilt(10.0, -5.0);
    assert_eq!(t.write(0x2046, 0, 1, 1), Ok(()));
    assert_eq!(angles(&mut t), (0, 0));
    assert_eq!(t.read(0x2046, 0), Ok(1));
    t.tilt(12.0, -6.0);
    assert_eq!(angles(&mut t), (200, -100));
    assert_eq!(t.write(0x2046, 0, 1, 0), Ok(()), "0 changes nothing");
    assert_eq!(t.read(0x2046, 0), Ok(1));
    assert_eq!(angles(&mut t), (200, -100));
    assert_eq!(
        t.write(0x2046, 0, 1, 1),
        Ok(()),
        "from the measured angles again"
    );
    assert_eq!(angles(&mut t), (0, 0));
    assert_eq!(t.write(0x2046, 0, 1, 2), Ok(()));
    assert_eq!(angles(&mut t), (1200, -600));
}

#[test]
fn teach_makes_present_position_level() {
    let mut t = booted();
    // By the definition, not by the printed example: after teach-in at -13.2/-29.3, -30/0 is -43.20/-21.50.
    t.tilt(-13.2, -29.3);
    assert_eq!(t.write(0x2042, 0, 1, 1), Ok(()));
    assert_eq!(t.read(0x2042, 0), Ok(1));
    assert_eq!(angles(&mut t), (0, 0));
    t.tilt(-43.2, -21.5);
    let (x, y) = angles(&mut t);
    assert!((x + 3000).abs() <= 2 && y.abs() <= 2, "{x} {y}");
    assert_eq!(t.write(0x2042, 0, 1, 0), Ok(()));
    assert_eq!(t.read(0x2042, 0), Ok(1));
    assert_eq!(t.write(0x2042, 0, 1, 2), Ok(()));
    let (x, y) = angles(&mut t);
    assert!((x + 4320).abs() <= 1 && (y + 2150).abs() <= 1, "{x} {y}");
}

/// 9.5: the new reference is 0/0, also with a zero point.
#[test]
fn teach_clears_the_zero_point_and_both_persist() {
    let mut t = booted();
    t.tilt(10.0, -5.0);
    t.write(0x2046, 0, 1, 1).unwrap();
    t.tilt(-20.0, 15.0);
    t.write(0x2042, 0, 1, 1).unwrap();
    assert_eq!(angles(&mut t), (0, 0));
    assert_eq!(t.read(0x2046, 0), Ok(2));
    t.power_cycle();
    t.settle_at([0.0, 0.0, 1.0]);
    t.tilt(-20.0, 15.0);
    t.sent_text();
    assert_eq!(angles(&mut t), (0, 0));
    assert_eq!((t.read(0x2042, 0), t.read(0x2046, 0)), (Ok(1), Ok(2)));
    // A zero point of the new reference.
    t.write(0x2046, 0, 1, 1).unwrap();
    t.write(0x2042, 0, 1, 2).unwrap();
    assert_eq!(t.read(0x2046, 0), Ok(1));
}

#[test]
fn teach_with_vertical_x_axis_is_refused() {
    let mut t = booted();
    for up in [[1.0, 0.0, 0.0], [-1.0, 0.0, 0.0], [1.0, 0.01, 0.01]] {
        t.settle_at(up);
        t.sent_text();
        assert_eq!(t.write(0x2042, 0, 1, 1), Err(DEVICE_STATE), "{up:?}");
        assert_eq!(t.read(0x2042, 0), Ok(2));
    }
    assert_eq!(t.memory, None);
}

/// What happens before a request, with its name.
type Case = (&'static str, fn(&mut Jn2101Tester));

#[test]
fn zero_and_teach_without_a_valid_angle_are_refused() {
    let cases: [Case; 4] = [
        ("stale", |t| drop(t.wait_without_samples(200))),
        ("a sample clips", |t| t.clip(1)),
        ("dead", |t| t.hold([0; 3], 120)),
        ("too long", |t| t.hold(in_g([0.0, 0.0, 2.0]), 120)),
    ];
    for (name, happens) in cases {
        let mut t = booted();
        t.tilt(10.0, 0.0);
        happens(&mut t);
        t.sent_text();
        for object in [0x2046, 0x2042] {
            assert_eq!(t.write(object, 0, 1, 1), Err(DEVICE_STATE), "{name}");
            assert_eq!(t.read(object, 0), Ok(2), "{name}");
            assert_eq!(t.write(object, 0, 1, 2), Ok(()), "{name}");
        }
        assert_eq!(t.memory, None, "{name}");
        t.tilt(10.0, 0.0);
        t.sent_text();
        assert_eq!(t.write(0x2046, 0, 1, 1), Ok(()), "{name}");
        assert_eq!(angles(&mut t), (0, 0), "{name}");
    }
}

/// 9.3 and 9.6: the zero point is subtracted from the direction, which stays within the range of 2040h.
#[test]
fn direction_with_zero_point_stays_in_the_range_of_quadrant_correction() {
    for (quadrants, turned) in [(1, [13_500, -13_500]), (2, [13_500, 22_500])] {
        let mut t = booted();
        t.settle_at(embankment(90.0));
        t.write(0x2044, 0, 1, 1).unwrap();
        t.write(0x2040, 0, 1, quadrants).unwrap();
        t.write(0x2046, 0, 1, 1).unwrap();
        assert_eq!(angles(&mut t), (0, 0));
        for (heading, expected) in [(225.0, turned[0]), (-45.0, turned[1])] {
            t.settle_at(embankment(heading));
            let (slope, direction) = angles(&mut t);
            let good = slope.abs() <= 1 && (i32::from(direction) - expected).abs() <= 1;
            assert!(good, "{quadrants} {heading}: {slope} {direction}");
        }
    }
}

#[test]
fn teach_zero_point_and_resolution_act_together() {
    let mut t = booted();
    t.tilt(5.0, 12.0);
    t.write(0x2042, 0, 1, 1).unwrap();
    t.write(0x6000, 0, 2, 1).unwrap();
    t.tilt(-8.0, 21.0);
    let wide = |t: &mut Jn2101Tester| [t.read_i32(0x6110), t.read_i32(0x6120)];
    let near = |got: [i32; 2], expected: [f64; 2]| {
        let errors = [0, 1].map(|axis| (f64::from(got[axis]) - 1000.0 * expected[axis]).abs());
        assert!(errors[0] < 2.0 && errors[1] < 2.0, "{got:?} {expected:?}");
    };
    // 9.5: the new Z axis is gravity at teach-in, the new X axis lies in the plane of Z and the old X axis.
    let gravity = |x: f64, y: f64| {
        let (x, y) = (x.to_radians().sin(), y.to_radians().sin());
        [x, y, (1.0 - x * x - y * y).sqrt()]
    };
    let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    let zb = gravity(5.0, 12.0);
    let scale = (1.0 - zb[0] * zb[0]).sqrt();
    let xb = [scale, -zb[0] * zb[1] / scale, -zb[0] * zb[2] / scale];
    let yb = [
        zb[1] * xb[2] - zb[2] * xb[1],
        zb[2] * xb[0] - zb[0] * xb[2],
        zb[0] * xb[1] - zb[1] * xb[0],
    ];
    let g = gravity(-8.0, 21.0);
    let taught = [dot(xb, g), dot(yb, g)].map(|sine| sine.asin().to_degrees());
    near(wide(&mut t), taught);
    t.write(0x2046, 0, 1, 1).unwrap();
    near(wide(&mut t), [0.0, 0.0]);
    t.write(0x2042, 0, 1, 2).unwrap();
    t.write(0x2046, 0, 1, 2).unwrap();
    near(wide(&mut t), [-8.0, 21.0]);
}

#[test]
fn filter_smooths_and_setting_0_switches_it_off() {
    let step = |filter| {
        let mut t = booted();
        t.write(0x2043, 0, 1, filter).unwrap();
        t.force = in_g([0.0, 0.5, 0.75_f64.sqrt()]);
        t.wait_text(5);
        let first = t.read_i16(0x6020);
        t.wait_text(2000);
        assert_eq!(t.read_i16(0x6020), 3000);
        first
    };
    assert_eq!(step(0), 3000);
    for filter in 1..=4 {
        assert!(step(filter) < 300, "{filter}");
    }
}

#[test]
fn terminating_resistor_follows_its_object() {
    let mut t = power_up();
    assert!(t.actions.contains(&Action::Termination(true)));
    t.sent_text();
    t.actions.clear();
    t.write(0x2045, 0, 1, 0).unwrap();
    assert_eq!(t.actions, [Action::Termination(false)]);
    t.write(0x2045, 0, 1, 0).unwrap();
    assert_eq!(t.actions.len(), 1);
}

#[test]
fn self_test_is_active_until_its_result() {
    for (x, y, register) in [
        (true, true, 0b110),
        (true, false, 0b100),
        (false, true, 0b010),
        (false, false, 0),
    ] {
        let mut t = booted();
        t.actions.clear();
        assert_eq!(t.write(0x4004, 1, 1, 1), Ok(()));
        assert_eq!(t.actions, [Action::SelfTest]);
        assert_eq!(t.read(0x4004, 1), Ok(1));
        assert_eq!(t.write(0x4004, 1, 1, 1), Ok(()), "it is running");
        assert_eq!(t.actions.len(), 1);
        t.wait_text(2000);
        t.tested(x, y);
        assert_eq!(t.read(0x4004, 1), Ok(0));
        assert_eq!(t.read(0x4004, 2), Ok(register));
        let emergencies = t.wait_text(10);
        assert_eq!(emergencies.is_empty(), x && y);
        if let Some((_, frame)) = emergencies.first() {
            assert_eq!(frame, "08A#0010010100000000");
        }
    }
}

/// The test deflects the element.
#[test]
fn angles_keep_their_values_during_self_test_and_zero_and_teach_are_refused() {
    let mut t = booted();
    t.tilt(10.0, -5.0);
    t.write(0x4004, 1, 1, 1).unwrap();
    t.send("000#010A");
    t.clipped = true;
    t.tilt(80.0, 30.0);
    assert_eq!(t.wait_text(500), [], "no error");
    assert_eq!(t.exchange("080#")[0], "18A#E8030CFE");
    assert_eq!(t.write(0x2046, 0, 1, 1), Err(DEVICE_STATE));
    assert_eq!(t.write(0x2042, 0, 1, 1), Err(DEVICE_STATE));
    for object in [0x2042, 0x2046] {
        assert_eq!(t.read(object, 0), Ok(2));
        assert_eq!(t.write(object, 0, 1, 2), Ok(()), "in force");
        assert_eq!(t.write(object, 0, 1, 0), Ok(()));
    }
    t.clipped = false;
    t.tested(true, true);
    t.tilt(20.0, 5.0);
    assert_eq!(angles(&mut t), (2000, 500));
    assert_eq!(t.write(0x2046, 0, 1, 1), Ok(()));
}

#[test]
fn self_test_without_result_fails() {
    let mut t = booted();
    t.write(0x4004, 1, 1, 1).unwrap();
    t.wait_text(3999);
    assert_eq!(t.read(0x4004, 1), Ok(1));
    t.wait_text(10);
    assert_eq!((t.read(0x4004, 1), t.read(0x4004, 2)), (Ok(0), Ok(0)));
    // A result without a request is ignored.
    t.tested(true, true);
    assert_eq!(t.read(0x4004, 2), Ok(0));
}

#[test]
fn temperature_is_updated_every_200_ms() {
    let mut t = booted();
    t.wait_text(200);
    t.temperature = -12_34;
    t.wait_text(190);
    assert_eq!(t.read(0x4080, 0), Ok(250));
    t.wait_text(10);
    assert_eq!(t.read_i32(0x4080), -123);
}

#[test]
fn heating_follows_temperature_and_can_be_switched_off() {
    let mut t = booted();
    t.temperature = -20_00;
    t.wait_text(400);
    assert_eq!(t.actions.last(), Some(&Action::Heater(1000)));
    assert_eq!(t.read(0x4081, 0), Ok(1500));
    t.write(0x2041, 0, 1, 0).unwrap();
    assert_eq!(t.actions.last(), Some(&Action::Heater(0)));
    assert_eq!(t.read(0x4081, 0), Ok(0));
    t.wait_text(1000);
    assert_eq!(t.actions.last(), Some(&Action::Heater(0)));
    t.write(0x2041, 0, 1, 1).unwrap();
    t.wait_text(200);
    assert_eq!(t.actions.last(), Some(&Action::Heater(1000)));
    // A hot cell is not heated.
    t.temperature = 80_00;
    t.wait_text(5000);
    assert_eq!(t.actions.last(), Some(&Action::Heater(0)));
    assert_eq!(t.read(0x4081, 0), Ok(0));
    t.temperature = -20_00;
    t.wait_text(5000);
    assert_eq!(t.actions.last(), Some(&Action::Heater(1000)));
    // Without samples of the accelerometer there is no temperature.
    t.sampled = false;
    t.wait_text(200);
    assert_eq!(t.actions.last(), Some(&Action::Heater(0)));
    assert_eq!(t.read(0x4081, 0), Ok(0));
}

#[test]
fn readout_with_any_resolution_is_in_0_01_degrees() {
    let mut t = booted();
    t.tilt(12.34, -5.0);
    t.write(0x6000, 0, 2, 1000).unwrap();
    let readout = t.node.readout();
    assert_eq!((readout.x, readout.y), (1234, Some(-500)));
}

#[test]
fn nmt_reset_node_does_not_start_a_self_test() {
    let mut t = booted();
    t.write(0x4004, 1, 1, 1).unwrap();
    t.tested(true, true);
    t.actions.clear();
    assert_eq!(t.exchange("000#810A"), ["70A#00"]);
    t.wait_text(100);
    assert!(!t.actions.contains(&Action::SelfTest), "{:?}", t.actions);
    assert_eq!(t.read(0x4004, 1), Ok(0));
    // The next request does.
    t.write(0x4004, 1, 1, 1).unwrap();
    t.wait_text(10);
    assert!(t.actions.contains(&Action::SelfTest));
}
