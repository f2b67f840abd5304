//! The settings of the TILTIX: every value of each attribute, what is stored, the factory values, and their effect on messages.

use crate::tester::Tester;
use crate::tester::sweep::every;
use crate::tester::tiltix::{FACTORY, tiltix080, tiltix360};
use plumbline::node::Node;

const INVALID_VALUE: u8 = 0x09;

/// A value for each attribute that can be set, other than the factory value.
const CHANGED: [(u8, &str); 15] = [
    (0x73, "02"),
    (0x74, "DC05"),
    (0x75, "01"),
    (0x77, "4101"),
    (0x7B, "03"),
    (0x7C, "C409"),
    (0x7D, "01"),
    (0x7F, "7B00"),
    (0x81, "65"),
    (0x82, "66"),
    (0x84, "FA"),
    (0x85, "E803"),
    (0x87, "01"),
    (0x88, "96"),
    (0x71, "6400"),
];

fn word(value: u16) -> String {
    format!("{:04X}", value.swap_bytes())
}

/// The attributes that do not depend on the angle.
fn settings<N: Node>(tester: &mut Tester<N>) -> Vec<(u8, String)> {
    let mut read = |attribute| (attribute, tester.get(attribute).expect("an attribute"));
    FACTORY
        .iter()
        .map(|(attribute, _)| read(*attribute))
        .collect()
}

/// Waits a second, switches the power off and on, and allocates the explicit connection.
fn restart<N: Node>(tester: &mut Tester<N>) {
    tester.wait(1000);
    tester.power_cycle();
    assert_eq!(tester.wait_text(2001).len(), 2);
    assert_eq!(tester.exchange("41E#0A4B0301010A"), ["41B#0ACB00"]);
}

/// Runs a test with both models and these connections.
macro_rules! both {
    ($choice:expr, $test:expr) => {{
        $test(tiltix080($choice));
        $test(tiltix360($choice));
    }};
}

#[test]
fn byte_takes_exactly_the_values_of_the_manual() {
    fn test<N: Node>(mut tester: Tester<N>) {
        for (attribute, low, high) in [
            (0x73, 0, 3),
            (0x75, 0, 1),
            (0x7B, 0, 3),
            (0x7D, 0, 1),
            (0x81, 101, 103),
            (0x82, 101, 103),
            (0x84, 0, 250),
            (0x87, 0, 1),
            (0x88, 0, 200),
        ] {
            let mut present = tester.get(attribute);
            for value in 0..=255_u8 {
                let is_valid = (low..=high).contains(&value);
                let text = format!("{value:02X}");
                let result = tester.set(attribute, &text);
                let expected = if is_valid { Ok(()) } else { Err(INVALID_VALUE) };
                assert_eq!(result, expected, "{attribute:02X} = {value}");
                if is_valid {
                    present = Ok(text);
                }
                assert_eq!(tester.get(attribute), present);
            }
        }
    }
    both!(1, test);
}

#[test]
fn word_takes_exactly_the_values_of_the_manual() {
    let mut tester = tiltix080(1);
    for value in (0..=1100).chain((1101..=u16::MAX).step_by(every(97))) {
        for (attribute, is_valid) in [
            (0x71, matches!(value, 10 | 100 | 1000)),
            (0x85, value <= 1000),
        ] {
            let result = tester.set(attribute, &word(value));
            let expected = if is_valid { Ok(()) } else { Err(INVALID_VALUE) };
            assert_eq!(result, expected, "{attribute:02X} = {value}");
            if is_valid {
                assert_eq!(tester.get(attribute), Ok(word(value)));
            }
        }
    }
    assert_eq!(tester.get(0x71), Ok(word(1000)));
    assert_eq!(tester.get(0x85), Ok(word(1000)));
}

#[test]
fn angle_and_cos_delta_have_the_limits_of_the_resolution() {
    fn test<N: Node>(mut tester: Tester<N>, is_circle: bool) {
        for unit in [1, 10, 100] {
            tester.set(0x71, &word(10 * unit)).unwrap();
            let (low, high) = if is_circle {
                (0, i32::from(36_000 / unit) - 1)
            } else {
                (-i32::from(8_000 / unit), i32::from(8_000 / unit))
            };
            let (least, greatest) = if is_circle {
                (0, 65_535)
            } else {
                (-32_768, 32_767)
            };
            let near = [low, high].into_iter().flat_map(|it| it - 2..=it + 2);
            let values = near.chain([least, greatest, 0, 1, -1, (high + greatest) / 2]);
            let values: Vec<i32> = values
                .filter(|it| (least..=greatest).contains(it))
                .collect();
            for attribute in [0x74, 0x77, 0x7C, 0x7F] {
                for &value in &values {
                    let before = tester.get(attribute);
                    let result = tester.set(attribute, &word(value as u16));
                    let is_valid = (low..=high).contains(&value);
                    let expected = if is_valid { Ok(()) } else { Err(INVALID_VALUE) };
                    assert_eq!(result, expected, "{attribute:02X} = {value}");
                    let after = if is_valid {
                        Ok(word(value as u16))
                    } else {
                        before
                    };
                    assert_eq!(tester.get(attribute), after);
                }
                tester.set(attribute, "0000").unwrap();
            }
            for value in 0..=255_u16 {
                let result = tester.set(0x88, &format!("{value:02X}"));
                assert_eq!(result.is_ok(), value <= 200 / unit, "{value} x {unit}");
            }
            tester.set(0x88, "00").unwrap();
        }
    }
    test(tiltix080(1), false);
    test(tiltix360(1), true);
}

/// T28, and the words of T10.
#[test]
fn slopes_follow_the_attitude() {
    let mut tester = tiltix080(1);
    for (x, y) in [
        (0.0, 0.0),
        (80.0, 0.0),
        (-80.0, 0.0),
        (0.0, 80.0),
        (0.0, -80.0),
        (30.0, 40.0),
        (-45.0, 20.01),
        (-0.01, -50.0),
    ] {
        tester.tilt(x, y);
        let hundredths = [x, y].map(|angle: f64| (100.0 * angle).round() as i32);
        for unit in [1, 10, 100] {
            tester.set(0x71, &word(10 * unit)).unwrap();
            let unit = i32::from(unit);
            for (attribute, angle) in [0x72, 0x7A].into_iter().zip(hundredths) {
                let slope = (angle.abs() + unit / 2) / unit * angle.signum();
                assert_eq!(tester.get(attribute), Ok(word(slope as u16)), "{x} {y}");
            }
        }
        for (attribute, angle) in [0x78, 0x80].into_iter().zip(hundredths) {
            let angle = (angle as u32).swap_bytes();
            assert_eq!(tester.get(attribute), Ok(format!("{angle:08X}")));
        }
    }
    let mut tester = tiltix360(1);
    for hundredths in [
        0_u32, 1, 4500, 9000, 18_000, 27_000, 32_768, 35_949, 35_950, 35_999,
    ] {
        // The axis of the rotation is level, and inclined by 20 deg.
        for cross in [0.0, 20.0_f64] {
            let (x, y) = (f64::from(hundredths) / 100.0).to_radians().sin_cos();
            let (z, plane) = cross.to_radians().sin_cos();
            tester.settle_at([x * plane, y * plane, z]);
            for unit in [1, 10, 100] {
                tester.set(0x71, &word(10 * unit)).unwrap();
                let unit = u32::from(unit);
                let slope = (hundredths + unit / 2) / unit % (36_000 / unit);
                assert_eq!(tester.get(0x72), Ok(word(slope as u16)), "{hundredths}");
                assert_eq!(tester.get(0x7A), Ok(word(0)));
            }
            assert_eq!(
                tester.get(0x78),
                Ok(format!("{:08X}", hundredths.swap_bytes()))
            );
            assert_eq!(tester.get(0x80), Ok("00000000".to_owned()));
        }
    }
}

/// T4, T13, T22: each of them alone.
#[test]
fn each_setting_is_kept_with_all_others() {
    fn test<N: Node>(mut tester: Tester<N>) {
        for (attribute, value) in CHANGED {
            tester.set(attribute, value).unwrap();
            assert_eq!(tester.get(attribute).as_deref(), Ok(value));
            let before = settings(&mut tester);
            restart(&mut tester);
            assert_eq!(settings(&mut tester), before, "{attribute:02X} = {value}");
        }
    }
    both!(1, test);
}

#[test]
fn offset_of_a_preset_is_kept_until_preset_enable_changes_from_0_to_1() {
    fn test<N: Node>(mut tester: Tester<N>) {
        for (mode, preset, enable, offset, slope) in [
            (0x73, 0x74, 0x75, 0x76, 0x72),
            (0x7B, 0x7C, 0x7D, 0x7E, 0x7A),
        ] {
            tester.set(mode, "02").unwrap();
            tester.set(preset, "A00F").unwrap();
            tester.set(enable, "01").unwrap();
            let kept = tester.get(offset);
            assert_eq!(tester.get(slope).as_deref(), Ok("A00F"));
            restart(&mut tester);
            assert_eq!(tester.get(offset), kept);
            assert_eq!(tester.get(slope).as_deref(), Ok("A00F"));
            // T13: a scanner that restores its configuration writes 1 over 1, and the zero point stays.
            assert_eq!(tester.get(enable).as_deref(), Ok("01"));
            tester.set(preset, "D007").unwrap();
            tester.set(enable, "01").unwrap();
            assert_eq!(tester.get(offset), kept);
            tester.set(enable, "00").unwrap();
            tester.set(enable, "01").unwrap();
            assert_eq!(tester.get(slope).as_deref(), Ok("D007"));
        }
    }
    let mut tester = tiltix080(1);
    tester.tilt(12.34, -5.67);
    test(tester);
    let mut tester = tiltix360(1);
    tester.turn(123.47);
    test(tester);
}

#[test]
fn converted_settings_and_the_last_of_quick_changes_are_kept() {
    fn test<N: Node>(mut tester: Tester<N>) {
        for (attribute, value) in [(0x74, "D304"), (0x77, "D204"), (0x88, "2D"), (0x71, "6400")] {
            tester.set(attribute, value).unwrap();
        }
        restart(&mut tester);
        for (attribute, value) in [(0x71, "6400"), (0x74, "7C00"), (0x77, "7B00"), (0x88, "05")] {
            assert_eq!(
                tester.get(attribute).as_deref(),
                Ok(value),
                "{attribute:02X}"
            );
        }
        for size in 0..50 {
            tester.set(0x84, &format!("{size:02X}")).unwrap();
            tester.wait(7);
        }
        restart(&mut tester);
        assert_eq!(tester.get(0x84).as_deref(), Ok("31"));
    }
    both!(1, test);
}

/// T23.
#[test]
fn reset_type_1_restores_all_factory_values() {
    fn test<N: Node>(mut tester: Tester<N>) {
        for (attribute, value) in CHANGED {
            tester.set(attribute, value).unwrap();
        }
        assert_eq!(tester.request("1003010301"), "90");
        assert_eq!(tester.request("1003010202"), "90");
        assert_eq!(tester.request("05010101"), "85");
        tester.wait(1000);
        tester.power_cycle();
        assert_eq!(tester.wait_text(2001).len(), 2);
        assert_eq!(tester.exchange("5FE#0A4B0301010A"), ["5FB#0ACB00"]);
        for (class, attribute, value) in [(3, 1, "3F"), (3, 2, "00"), (3, 3, "00")]
            .into_iter()
            .chain(FACTORY.map(|(attribute, value)| (0x65, attribute, value)))
        {
            let sent = tester.exchange(&format!("5FC#0A0E{class:02X}01{attribute:02X}"));
            assert_eq!(sent, [format!("5FB#0A8E{value}")], "{attribute:02X}");
        }
    }
    both!(1, test);
}

#[test]
fn setting_that_changes_a_word_sends_one_change_of_state_message() {
    let mut tester = tiltix080(0x51);
    tester.tilt(12.34, -5.67);
    let sent = tester.exchange("41C#0A100504090000");
    assert_eq!(sent, ["41B#0A900000", "343#D204C9FD"]);
    for (attribute, value, message) in [
        (0x71, "6400", "7B00C7FF"),
        (0x71, "E803", "0C00FAFF"),
        (0x71, "6400", "7B00C7FF"),
        (0x71, "0A00", "D204C9FD"),
        (0x73, "01", "2EFBC9FD"),
        (0x73, "03", ""),
        (0x74, "6400", ""),
        (0x75, "01", "6400C9FD"),
        (0x77, "0500", "6900C9FD"),
        (0x7B, "02", ""),
        (0x7F, "0700", "6900D0FD"),
        (0x7F, "0000", "6900C9FD"),
        (0x7D, "01", "69000000"),
        (0x87, "01", ""),
        (0x84, "32", ""),
        (0x85, "0500", ""),
        (0x88, "0A", ""),
        (0x81, "65", ""),
    ] {
        let mut expected = vec!["41B#0A90".to_owned()];
        if !message.is_empty() {
            expected.push(format!("343#{message}"));
        }
        let sent = tester.exchange(&format!("41C#0A106501{attribute:02X}{value}"));
        assert_eq!(sent, expected, "{attribute:02X} = {value}");
        assert_eq!(tester.wait_text(200), [], "{attribute:02X} = {value}");
    }
}

/// T32: the settings of the DeviceNet object are no configuration of the application.
#[test]
fn sensor_is_configured_exactly_with_a_changed_attribute_of_the_angle_object() {
    fn test<N: Node>(mut tester: Tester<N>) {
        let is_configured = |tester: &mut Tester<N>| match tester.request("0E010105").as_str() {
            "8E0500" => true,
            "8E0100" => false,
            other => panic!("{other}"),
        };
        for body in ["1003010201", "1003010301"] {
            assert_eq!(tester.request(body), "90");
            assert!(!is_configured(&mut tester), "{body}");
        }
        for (attribute, value) in CHANGED {
            tester.set(attribute, value).unwrap();
            assert!(is_configured(&mut tester), "{attribute:02X}");
            let (_, factory) = FACTORY.iter().find(|(it, _)| *it == attribute).unwrap();
            tester.set(attribute, factory).unwrap();
            assert!(!is_configured(&mut tester), "{attribute:02X}");
        }
    }
    both!(1, test);
}

/// T2, T17: 81h while the poll connection exists, 82h while the COS or cyclic connection exists. The value in force is no change.
#[test]
fn assembly_of_each_connection_is_not_settable_while_it_exists() {
    for (choice, held) in [
        (0x01, &[][..]),
        (0x03, &[0x81]),
        (0x11, &[0x82]),
        (0x21, &[0x82]),
        (0x51, &[0x82]),
        (0x61, &[0x82]),
        (0x13, &[0x81, 0x82]),
        (0x63, &[0x81, 0x82]),
    ] {
        for established in [false, true] {
            let mut tester = tiltix080(choice);
            for instance in [2, 4] {
                if established {
                    tester.exchange(&format!("41C#0A1005{instance:02X}090000"));
                }
            }
            for attribute in [0x81, 0x82] {
                for (value, code) in [("64", 0x09), ("68", 0x09), ("", 0x13), ("6500", 0x15)] {
                    assert_eq!(tester.set(attribute, value), Err(code), "{choice:02X}");
                }
                let is_held = held.contains(&attribute);
                let expected = if is_held { Err(0x0C) } else { Ok(()) };
                assert_eq!(tester.set(attribute, "65"), expected, "{choice:02X}");
                let value = if is_held { "67" } else { "65" };
                assert_eq!(tester.get(attribute).as_deref(), Ok(value));
                assert_eq!(tester.set(attribute, value), Ok(()), "{choice:02X}");
            }
            let release = format!("41E#0A4C0301{choice:02X}");
            assert_eq!(tester.exchange(&release), ["41B#0ACC"]);
            assert_eq!(tester.exchange("41E#0A4B0301010A"), ["41B#0ACB00"]);
            for attribute in [0x81, 0x82] {
                assert_eq!(tester.set(attribute, "66"), Ok(()), "{choice:02X}");
            }
        }
    }
}
