//! The attributes and words of the TILTIX (manual 5.1), with the MAC ID 3 and the master 0Ah of the manual's examples.

use crate::tester::tiltix::{tiltix080, tiltix360};

const EXPLICIT: u8 = 0x01;
const POLL: u8 = 0x03;
const COS: u8 = 0x51;

/// General codes of CIP.
const INVALID_VALUE: u8 = 0x09;
const STATE_CONFLICT: u8 = 0x0C;
const NOT_SETTABLE: u8 = 0x0E;
const NOT_ENOUGH_DATA: u8 = 0x13;
const NOT_SUPPORTED: u8 = 0x14;
const TOO_MUCH_DATA: u8 = 0x15;

/// The factory values of the attributes that do not depend on the angle.
const FACTORY: [(u8, &str); 18] = [
    (0x01, "1600"),
    (0x71, "0A00"),
    (0x73, "00"),
    (0x74, "0000"),
    (0x75, "00"),
    (0x76, "0000"),
    (0x77, "0000"),
    (0x7B, "00"),
    (0x7C, "0000"),
    (0x7D, "00"),
    (0x7E, "0000"),
    (0x7F, "0000"),
    (0x81, "67"),
    (0x82, "67"),
    (0x84, "64"),
    (0x85, "0000"),
    (0x87, "00"),
    (0x88, "00"),
];

const SLOPES: [u8; 4] = [0x72, 0x78, 0x7A, 0x80];

#[test]
fn angle_object_has_exactly_22_attributes_with_their_factory_values() {
    let mut tester = tiltix080(EXPLICIT);
    for attribute in 0..=255 {
        let read = tester.get(attribute);
        let factory = FACTORY.iter().find(|(number, _)| *number == attribute);
        match factory {
            Some((_, value)) => assert_eq!(read.as_deref(), Ok(*value), "{attribute:02X}"),
            None if SLOPES.contains(&attribute) => assert!(read.is_ok(), "{attribute:02X}"),
            None => assert_eq!(read, Err(NOT_SUPPORTED), "{attribute:02X}"),
        }
    }
    let mut tester = tiltix360(EXPLICIT);
    for (attribute, value) in FACTORY {
        assert_eq!(tester.get(attribute).as_deref(), Ok(value));
    }
}

#[test]
fn read_only_attributes_are_not_settable() {
    let mut tester = tiltix080(EXPLICIT);
    for attribute in [0x01, 0x72, 0x76, 0x78, 0x7A, 0x7E, 0x80] {
        for value in ["", "00", "0000"] {
            assert_eq!(tester.set(attribute, value), Err(NOT_SETTABLE));
        }
    }
}

/// Values beyond the limits, of the wrong size, and the limits themselves. The 360 model has other limits for the angles.
#[test]
fn limits_are_those_of_the_manual() {
    let cases: [(u8, &[&str], &[&str]); 16] = [
        (
            0x71,
            &["0A00", "6400", "E803"],
            &["0000", "0900", "0B00", "0100", "1027"],
        ),
        (0x73, &["00", "01", "02", "03"], &["04", "80", "FF"]),
        (0x74, &["C0E0", "401F"], &["BFE0", "411F", "0080", "FF7F"]),
        (0x75, &["00", "01"], &["02", "FF"]),
        (0x77, &["C0E0", "401F"], &["BFE0", "411F"]),
        (0x7B, &["00", "03"], &["04", "FF"]),
        (0x7C, &["C0E0", "401F"], &["BFE0", "411F"]),
        (0x7D, &["00", "01"], &["02", "FF"]),
        (0x7F, &["C0E0", "401F"], &["BFE0", "411F"]),
        (0x81, &["65", "66", "67"], &["00", "64", "68"]),
        (0x82, &["65", "66", "67"], &["00", "64", "68"]),
        (0x84, &["00", "FA"], &["FB", "FF"]),
        (0x85, &["0000", "E803"], &["E903", "FFFF"]),
        (0x87, &["00", "01"], &["02", "FF"]),
        (0x88, &["00", "C8"], &["C9", "FF"]),
        (0x75, &["00"], &[]),
    ];
    for (attribute, good, bad) in cases {
        let mut tester = tiltix080(EXPLICIT);
        for value in good {
            assert_eq!(tester.set(attribute, value), Ok(()), "{attribute:02X}");
            assert_eq!(tester.get(attribute).as_deref(), Ok(*value));
            tester.set(0x71, "0A00").unwrap();
        }
        let before = tester.get(attribute);
        for value in bad {
            let refused = tester.set(attribute, value);
            assert_eq!(refused, Err(INVALID_VALUE), "{attribute:02X}: {value}");
        }
        let [first, ..] = good else { unreachable!() };
        let longer = format!("{first}00");
        assert_eq!(tester.set(attribute, &longer), Err(TOO_MUCH_DATA));
        let shorter = &first[2..];
        assert_eq!(tester.set(attribute, shorter), Err(NOT_ENOUGH_DATA));
        assert_eq!(tester.get(attribute), before, "{attribute:02X}");
    }
}

#[test]
fn angles_of_the_360_model_are_unsigned() {
    let mut tester = tiltix360(EXPLICIT);
    for attribute in [0x74, 0x77, 0x7C, 0x7F] {
        assert_eq!(tester.set(attribute, "9F8C"), Ok(()));
        assert_eq!(tester.set(attribute, "A08C"), Err(INVALID_VALUE));
        assert_eq!(tester.set(attribute, "FFFF"), Err(INVALID_VALUE));
        assert_eq!(tester.get(attribute).as_deref(), Ok("9F8C"));
    }
    tester.set(0x71, "6400").unwrap();
    // 359.99 deg is 360.0 deg, which is 0.
    assert_eq!(tester.get(0x74).as_deref(), Ok("0000"));
    assert_eq!(tester.set(0x74, "0F0E"), Ok(()));
    assert_eq!(tester.set(0x74, "100E"), Err(INVALID_VALUE));
    tester.set(0x71, "E803").unwrap();
    // 359.9 deg is 360 deg.
    assert_eq!(tester.get(0x74).as_deref(), Ok("0000"));
    assert_eq!(tester.set(0x74, "6701"), Ok(()));
    assert_eq!(tester.set(0x74, "6801"), Err(INVALID_VALUE));
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
fn new_resolution_converts_presets_offsets_and_delta() {
    let mut tester = tiltix080(EXPLICIT);
    for (attribute, value) in [
        (0x74, "D204"),
        (0x77, "2EFB"),
        (0x7C, "D304"),
        (0x7F, "2DFB"),
        (0x88, "2D"),
    ] {
        tester.set(attribute, value).unwrap();
    }
    tester.tilt(-12.34, 0.0);
    tester.set(0x75, "01").unwrap();
    assert_eq!(tester.get(0x76).as_deref(), Ok("A409"));
    tester.set(0x71, "6400").unwrap();
    // 1234, -1234, 1235, -1235, 2468, 45: to the nearest, halves away from zero.
    let mut expect = |values: [&str; 6]| {
        for (attribute, value) in [0x74, 0x77, 0x7C, 0x7F, 0x76, 0x88].into_iter().zip(values) {
            assert_eq!(
                tester.get(attribute).as_deref(),
                Ok(value),
                "{attribute:02X}"
            );
        }
    };
    expect(["7B00", "85FF", "7C00", "84FF", "F700", "05"]);
    let mut tester = tester;
    tester.set(0x71, "0A00").unwrap();
    assert_eq!(tester.get(0x74).as_deref(), Ok("CE04"));
    assert_eq!(tester.get(0x88).as_deref(), Ok("32"));
    tester.set(0x88, "04").unwrap();
    tester.set(0x71, "6400").unwrap();
    assert_eq!(tester.get(0x88).as_deref(), Ok("00"));
    // 2 deg in units of 0.1 deg.
    assert_eq!(tester.set(0x88, "15"), Err(INVALID_VALUE));
    assert_eq!(tester.set(0x88, "14"), Ok(()));
    assert_eq!(tester.set(0x74, "2103"), Err(INVALID_VALUE));
    assert_eq!(tester.set(0x74, "2003"), Ok(()));
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
        assert_eq!(tester.set(0x81, "66"), Err(STATE_CONFLICT));
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
fn change_across_360_degrees_is_small() {
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
fn settings_are_stored_within_a_second_and_preset_enable_is_not() {
    let mut tester = tiltix360(EXPLICIT);
    tester.turn(100.0);
    for (attribute, value) in [
        (0x71, "6400"),
        (0x73, "02"),
        (0x74, "6400"),
        (0x75, "01"),
        (0x77, "0100"),
        (0x81, "65"),
        (0x82, "66"),
        (0x84, "05"),
        (0x85, "F401"),
        (0x87, "01"),
        (0x88, "03"),
    ] {
        tester.set(attribute, value).unwrap();
    }
    tester.wait(1000);
    tester.power_cycle();
    tester.wait(2001);
    assert_eq!(tester.exchange("41E#0A4B0301010A"), ["41B#0ACB00"]);
    for (attribute, value) in [
        (0x71, "6400"),
        (0x73, "02"),
        (0x74, "6400"),
        (0x75, "00"),
        // 10.0 - 100.0 deg.
        (0x76, "8C0A"),
        (0x77, "0100"),
        (0x81, "65"),
        (0x82, "66"),
        (0x84, "05"),
        (0x85, "F401"),
        (0x87, "01"),
        (0x88, "03"),
        (0x72, "6500"),
    ] {
        assert_eq!(
            tester.get(attribute).as_deref(),
            Ok(value),
            "{attribute:02X}"
        );
    }
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
