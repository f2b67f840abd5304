//! The attributes and words of the TILTIX (manual 5.1), with the MAC ID 3 and the master 0Ah of the manual's examples.

use crate::tester::Tester;
use crate::tester::tiltix::{FACTORY, tiltix080, tiltix360};
use plumbline::measure::ONE_G;
use plumbline::model::tiltix::tiltix080::Tiltix080;

const EXPLICIT: u8 = 0x01;
const POLL: u8 = 0x03;
const COS: u8 = 0x51;

/// The general codes of error responses.
const INVALID_VALUE: u8 = 0x09;
const STATE_CONFLICT: u8 = 0x0C;
const NOT_SETTABLE: u8 = 0x0E;
const NOT_ENOUGH_DATA: u8 = 0x13;
const NOT_SUPPORTED: u8 = 0x14;
const TOO_MUCH_DATA: u8 = 0x15;

const SLOPES: [u8; 4] = [0x72, 0x78, 0x7A, 0x80];

#[test]
fn angle_object_has_exactly_22_attributes_with_their_factory_values() {
    // The number of attributes, and the settings.
    let constants = || [(0x01, "1600")].into_iter().chain(FACTORY);
    let mut tester = tiltix080(EXPLICIT);
    for attribute in 0..=255 {
        let read = tester.get(attribute);
        let constant = constants().find(|(number, _)| *number == attribute);
        match constant {
            Some((_, value)) => assert_eq!(read.as_deref(), Ok(value), "{attribute:02X}"),
            None if SLOPES.contains(&attribute) => assert!(read.is_ok(), "{attribute:02X}"),
            None => assert_eq!(read, Err(NOT_SUPPORTED), "{attribute:02X}"),
        }
    }
    let mut tester = tiltix360(EXPLICIT);
    for (attribute, value) in constants() {
        assert_eq!(tester.get(attribute).as_deref(), Ok(value));
    }
}

/// The sizes of the attributes; 0: it can only be read.
const SIZES: [(u8, usize); 22] = [
    (0x01, 0),
    (0x71, 2),
    (0x72, 0),
    (0x73, 1),
    (0x74, 2),
    (0x75, 1),
    (0x76, 0),
    (0x77, 2),
    (0x78, 0),
    (0x7A, 0),
    (0x7B, 1),
    (0x7C, 2),
    (0x7D, 1),
    (0x7E, 0),
    (0x7F, 2),
    (0x80, 0),
    (0x81, 1),
    (0x82, 1),
    (0x84, 1),
    (0x85, 2),
    (0x87, 1),
    (0x88, 1),
];

#[test]
fn set_needs_the_size_of_the_attribute() {
    let mut tester = tiltix080(EXPLICIT);
    for (attribute, size) in SIZES {
        let before = tester.get(attribute);
        for length in (0..=3).filter(|length| size == 0 || *length != size) {
            let expected = match size {
                0 => NOT_SETTABLE,
                size if length < size => NOT_ENOUGH_DATA,
                _ => TOO_MUCH_DATA,
            };
            let result = tester.set(attribute, &"00".repeat(length));
            assert_eq!(result, Err(expected), "{attribute:02X}: {length}");
        }
        assert_eq!(tester.get(attribute), before);
    }
}

/// 16.34 deg is 1634 (5.1), and the table of the words.
#[test]
fn words_have_the_resolution() {
    let mut tester = tiltix080(POLL);
    tester.request("1005020900 00");
    tester.tilt(16.34, 0.0);
    assert_eq!(tester.get(0x72).as_deref(), Ok("6206"));
    tester.tilt(12.34, -5.67);
    for (resolution, words) in [
        ("0A00", "D204C9FD"),
        ("6400", "7B00C7FF"),
        ("E803", "0C00FAFF"),
    ] {
        tester.set(0x71, resolution).unwrap();
        assert_eq!(tester.exchange("41D#"), [format!("3C3#{words}")]);
        assert_eq!(tester.get(0x72).as_deref(), Ok(&words[..4]));
        assert_eq!(tester.get(0x7A).as_deref(), Ok(&words[4..]));
        assert_eq!(tester.get(0x78).as_deref(), Ok("D2040000"));
        assert_eq!(tester.get(0x80).as_deref(), Ok("C9FDFFFF"));
    }
    let mut tester = tiltix360(POLL);
    tester.request("1005020900 00");
    tester.turn(123.47);
    for (resolution, words) in [
        ("0A00", "3B300000"),
        ("6400", "D3040000"),
        ("E803", "7B000000"),
    ] {
        tester.set(0x71, resolution).unwrap();
        assert_eq!(tester.exchange("41D#"), [format!("3C3#{words}")]);
    }
    tester.turn(327.68);
    tester.set(0x71, "0A00").unwrap();
    assert_eq!(tester.exchange("41D#"), ["3C3#00800000"]);
    assert_eq!(tester.get(0x78).as_deref(), Ok("00800000"));
    tester.turn(359.96);
    tester.set(0x71, "6400").unwrap();
    assert_eq!(tester.exchange("41D#"), ["3C3#00000000"]);
    assert_eq!(tester.get(0x78).as_deref(), Ok("9C8C0000"));
}

/// Resolution, operating parameter, preset, differential offset: the order of 4.5.2.
#[test]
fn recipe_of_the_manual_sets_the_slope_to_the_preset_value() {
    let mut tester = tiltix080(POLL);
    tester.request("1005020900 00");
    tester.tilt(10.0, -20.0);
    tester.set(0x71, "6400").unwrap();
    tester.set(0x73, "03").unwrap();
    tester.set(0x74, "3200").unwrap();
    tester.set(0x75, "01").unwrap();
    // 5.0 deg - 10.0 deg * -1 = 15.0 deg.
    assert_eq!(tester.get(0x76).as_deref(), Ok("9600"));
    assert_eq!(tester.exchange("41D#"), ["3C3#320038FF"]);
    tester.set(0x77, "FDFF").unwrap();
    assert_eq!(tester.exchange("41D#"), ["3C3#2F0038FF"]);
    assert_eq!(tester.get(0x78).as_deref(), Ok("D6010000"));
    // The preset is repeated: again 5.0 deg - 0.3 deg, at another angle.
    tester.tilt(30.0, -20.0);
    tester.set(0x75, "01").unwrap();
    assert_eq!(
        tester.get(0x76).as_deref(),
        Ok("9600"),
        "1 to 1 does nothing"
    );
    tester.set(0x75, "00").unwrap();
    assert_eq!(
        tester.get(0x76).as_deref(),
        Ok("9600"),
        "1 to 0 does nothing"
    );
    tester.set(0x75, "01").unwrap();
    assert_eq!(tester.exchange("41D#"), ["3C3#2F0038FF"]);
    // Without scaling, only the inversion is left.
    tester.set(0x73, "01").unwrap();
    assert_eq!(tester.exchange("41D#"), ["3C3#D4FE38FF"]);
}

#[test]
fn assembly_is_selected_before_the_connection_exists() {
    let mut tester = tiltix080(EXPLICIT);
    tester.tilt(12.34, -5.67);
    for (instance, words) in [("65", "D204"), ("66", "C9FD"), ("67", "D204C9FD")] {
        assert_eq!(
            tester.request(&format!("0E04{instance}03")),
            format!("8E{words}")
        );
        tester.set(0x81, instance).unwrap();
        assert_eq!(tester.exchange("41C#0A4B0301020A"), ["41B#0ACB00"]);
        tester.request("1005020900 00");
        assert_eq!(tester.exchange("41D#"), [format!("3C3#{words}")]);
        // T2, T17: the range first, then the state. The other connection does not matter.
        assert_eq!(tester.set(0x81, "68"), Err(INVALID_VALUE));
        for value in ["65", "66", "67"] {
            // The value in force is no change.
            let is_in_force = value == instance;
            let expected = if is_in_force {
                Ok(())
            } else {
                Err(STATE_CONFLICT)
            };
            assert_eq!(tester.set(0x81, value), expected);
            assert_eq!(tester.get(0x81).as_deref(), Ok(instance));
            assert_eq!(tester.exchange("41D#"), [format!("3C3#{words}")]);
        }
        assert_eq!(tester.set(0x82, "66"), Ok(()));
        assert_eq!(tester.exchange("41C#0A4C030102"), ["41B#0ACC"]);
    }
}

/// The sequence of 6.2, and the COS delta (88h).
#[test]
fn change_of_state_message_follows_the_delta() {
    let mut tester = tiltix080(COS);
    tester.set(0x84, "00").unwrap();
    tester.tilt(12.34, -5.67);
    let sent = tester.exchange("41C#0A100504090000");
    assert_eq!(sent, ["41B#0A900000", "343#D204C9FD"]);
    tester.set(0x88, "05").unwrap();
    tester.tilt(12.38, -5.67);
    assert_eq!(tester.sent_text(), [""; 0]);
    tester.tilt(12.39, -5.67);
    assert_eq!(tester.sent_text(), ["343#D704C9FD"]);
    tester.set(0x88, "00").unwrap();
    tester.tilt(12.39, -5.66);
    assert_eq!(tester.sent_text(), ["343#D704CAFD"]);
}

#[test]
fn change_across_360_degrees_below_delta_sends_no_message() {
    let mut tester = tiltix360(COS);
    tester.set(0x84, "00").unwrap();
    tester.turn(359.9);
    tester.exchange("41C#0A100504090000");
    tester.set(0x88, "14").unwrap();
    tester.turn(0.0);
    assert_eq!(tester.sent_text(), [""; 0]);
    tester.turn(0.11);
    assert_eq!(tester.sent_text(), ["343#0B000000"]);
}

#[test]
fn weight_1000_holds_the_slope_until_it_changes() {
    let mut tester = tiltix080(EXPLICIT);
    tester.set(0x84, "00").unwrap();
    tester.tilt(5.0, 6.0);
    tester.set(0x85, "E803").unwrap();
    tester.tilt(-40.0, 0.0);
    assert_eq!(tester.get(0x72).as_deref(), Ok("F401"));
    tester.set(0x85, "0000").unwrap();
    tester.tilt(-40.0, 0.0);
    assert_eq!(tester.get(0x72).as_deref(), Ok("60F0"));
}

#[test]
fn filter_begins_again_after_missing_readings() {
    let mut tester = tiltix080(EXPLICIT);
    tester.set(0x84, "FA").unwrap();
    tester.set(0x85, "E703").unwrap();
    tester.tilt(5.0, 6.0);
    tester.wait_without_samples(225);
    tester.hold([0, 0, ONE_G], 1);
    assert_eq!(tester.get(0x72).as_deref(), Ok("0000"));
    assert_eq!(tester.get(0x7A).as_deref(), Ok("0000"));
}

/// Bit 10 of the status of the identity.
#[test]
fn implausible_acceleration_is_in_the_status_and_on_the_module_led() {
    let mut tester = tiltix080(EXPLICIT);
    for (force, status, red) in [
        ([0, 0, 0], "8E0104", true),
        ([0, 0, ONE_G], "8E0100", false),
        ([2 * ONE_G, 0, 0], "8E0104", true),
        // It has no message for a sensor on its back.
        ([0, 0, -ONE_G], "8E0100", false),
    ] {
        tester.hold(force, 130);
        assert_eq!(tester.request("0E010105"), status, "{force:?}");
        tester.wait(1000);
        assert_eq!(tester.leds.module_green, !red, "{force:?}");
    }
}

/// Without this status, the sensor would be reported as level.
#[test]
fn status_reports_dead_accelerometer_after_first_reading() {
    let mut tester = tiltix080(EXPLICIT);
    tester.force = [0; 3];
    tester.power_cycle();
    assert_eq!(tester.wait_text(2001).len(), 2);
    assert_eq!(tester.exchange("41E#0A4B0301010A"), ["41B#0ACB00"]);
    assert_eq!(tester.request("0E010105"), "8E0104");
}

/// What happens before a request, with its name.
type Case = (&'static str, fn(&mut Tester<Tiltix080>));

#[test]
fn preset_without_a_valid_angle_is_refused() {
    let cases: [Case; 3] = [
        ("stale", |tester| drop(tester.wait_without_samples(225))),
        ("a sample clips", |tester| tester.clip(1)),
        ("dead", |tester| tester.hold([0; 3], 130)),
    ];
    for (name, happens) in cases {
        let mut tester = tiltix080(EXPLICIT);
        tester.tilt(10.0, 5.0);
        happens(&mut tester);
        for (enable, offset) in [(0x75, 0x76), (0x7D, 0x7E)] {
            assert_eq!(tester.set(enable, "01"), Err(STATE_CONFLICT), "{name}");
            assert_eq!(tester.get(enable).as_deref(), Ok("00"), "{name}");
            assert_eq!(tester.get(offset).as_deref(), Ok("0000"), "{name}");
        }
        tester.tilt(10.0, 5.0);
        assert_eq!(tester.set(0x75, "01"), Ok(()), "{name}");
    }
}

/// Attribute 7 of the identity: `INCLINOMETER 360 degree`, in fragments.
#[test]
fn product_name_is_that_of_the_model() {
    let mut tester = tiltix360(EXPLICIT);
    let mut name = tester.exchange("41C#0A0E010107");
    for count in 0..4 {
        name.extend(tester.exchange(&format!("41C#8AC{count}00")));
    }
    assert_eq!(
        name,
        [
            "41B#8A008E17494E434C",
            "41B#8A41494E4F4D4554",
            "41B#8A42455220333630",
            "41B#8A43206465677265",
            "41B#8A8465",
        ]
    );
    let _ = tester.exchange("41C#8AC400");
    assert_eq!(tester.request("0E010101"), "8E6201");
    assert_eq!(tester.request("0E010103"), "8E6801");
    assert_eq!(tiltix080(EXPLICIT).request("0E010103"), "8E5000");
}
