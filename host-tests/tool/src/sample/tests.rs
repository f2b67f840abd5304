use super::*;
use crate::identify::product;
use crate::sheet::Sheet;

/// A slope of the JN2101.
fn slope(name: &str) -> Entry {
    let sheet = Sheet::of(product("jn2101").unwrap());
    let mut entries = sheet.entries.into_iter();
    entries.find(|entry| entry.name == name).unwrap()
}

#[test]
fn end_of_16_bit_range_is_no_angle_if_the_range_is_too_small() {
    let unit = Scale {
        multiplier: 1,
        decimals: 3,
        unit: "deg",
    };
    let (short, long) = (slope("slope-long16"), slope("slope-long32"));
    for (entry, steps, number, expected) in [
        (&short, 1, 32_767, true),
        (&short, 1, -32_768, true),
        (&short, 1, 32_766, false),
        (&short, 1, -32_767, false),
        (&short, 10, 32_767, false),
        (&short, 1000, -32_768, false),
        (&long, 1, 32_767, false),
        (&long, 1, -32_768, false),
    ] {
        let clipped = is_clipped(entry, &unit.times(steps), number);
        assert_eq!(clipped, expected, "{} {steps} {number}", entry.name);
    }
    // A data sheet does not tell the unit.
    assert!(is_clipped(&short, &Scale::PLAIN, 32_767));
}
