//! The scale of a parameter of DeviceNet: a number has its unit only if its scale is known.

use super::*;

/// The parameter with these flags, this unit and these fields behind the default value.
fn parameter(flags: &str, unit: &str, fields: &str) -> Entry {
    let text = format!(
        "[Params]\nParam1 = 0,,\"20 65 24 01 30 71\",{flags},0xC3,2,\"Angle\",\"{unit}\",\"\",-900,900,0, {fields};"
    );
    let sheet = parsed(text.as_bytes()).unwrap();
    sheet.entries[0].clone()
}

#[test]
fn number_whose_scale_is_not_known_has_no_unit_and_says_that_it_is_raw() {
    for (flags, fields) in [
        // A third, an offset, a multiplier in another parameter.
        ("0", "1,3,1,0, 0,0,0,0, 0"),
        ("0", "1,1,1,-40, 0,0,0,0, 0"),
        ("0", "1,100,1,0, 7,0,0,0, 2"),
        ("0", "1,1,1,0, 0,0,7,0, 0"),
        ("0", "1,1,1,0, 0,0,0,Param7, 0"),
        // Links that the file does not name.
        ("0x08", "1,1,1,0"),
        ("0", "0.5,1,1,0, 0,0,0,0, 0"),
        ("0", "1,0,1,0, 0,0,0,0, 0"),
        ("0", "-1,1,1,0, 0,0,0,0, 0"),
        ("0", "9223372036854775807,1,2,0, 0,0,0,0, 0"),
        ("0x40", "1,10,1,0, 0,0,0,0, 255"),
    ] {
        let angle = parameter(flags, "deg", fields);
        assert_eq!(angle.title, "Angle (raw)", "{fields}");
        assert_eq!(angle.name, "angle-raw", "{fields}");
        assert_eq!(angle.text(30), "30", "{fields}");
        assert_eq!(angle.json(30)["unit"], "", "{fields}");
        assert_eq!(angle.parse("30"), Ok(30), "{fields}");
        assert!(angle.parse("10deg").is_err(), "{fields}");
    }
}

#[test]
fn number_whose_scale_is_known_has_its_unit() {
    for (flags, unit, fields, text) in [
        ("0", "deg", "1,1,1,0, 0,0,0,0, 0", "30 deg"),
        ("0", "deg", "", "30 deg"),
        ("0x08", "deg", "1,1,1,0, 0,0,0,0, 0", "30 deg"),
        ("0", "deg", "1,100,1,0, 0,0,0,0, 2", "0.30 deg"),
        ("0", "deg", "5,10,2,0, 0,0,0,0, 0", "30.0 deg"),
        ("0", "deg", "1,1,1,0, 0,0,0,0, 1", "3.0 deg"),
        ("0", "0.01 deg", "1,1,1,0, 0,0,0,0, 0", "0.30 deg"),
        // With extended precision, the decimals also divide the value.
        ("0x44", "deg", "1,10,1,0, 0,0,0,0, 1", "0.30 deg"),
        ("0x04", "deg", "1,10,1,0, 0,0,0,0, 1", "3.0 deg"),
    ] {
        let angle = parameter(flags, unit, fields);
        assert_eq!(angle.text(30), text, "{flags} {fields}");
        assert_eq!(angle.parse(text), Ok(30), "{flags} {fields}");
        assert_eq!(angle.title, "Angle", "{flags} {fields}");
    }
}

#[test]
fn long_title_of_a_raw_number_still_says_that_it_is_raw() {
    let long = "x".repeat(200);
    let text = format!(
        "[Params]\nParam1 = 0,,\"20 65 24 01 30 71\",0,0xC3,2,\"{long}\",\"deg\",\"\",0,9,0, 1,3,1,0;"
    );
    let sheet = parsed(text.as_bytes()).unwrap();
    assert!(sheet.entries[0].title.ends_with("x (raw)"));
}
