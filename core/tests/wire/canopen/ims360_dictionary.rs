//! The object dictionary of the IMS360: types, factory values, access and permitted values (manual, chapter 7).

use crate::tester::SERIAL;
use crate::tester::dictionary::Access::{Command, Ro, Rw, Wo};
use crate::tester::dictionary::{BYTE, Row, Values};
use crate::tester::ims360::booted;
use std::ops::RangeInclusive;

const NOT_PERMITTED: u32 = 0x0609_0030;
const DEVICE_STATE: u32 = 0x0800_0022;
const NO_DATA: u32 = 0x0800_0024;
const SIGNATURE: u32 = 0x0800_0020;

/// The objects of 7.2.1 to 7.2.49, and those of the J1939 mode, which CANopen reads and writes too. 1003h has the sub-indices 1 to 8
/// besides.
#[rustfmt::skip]
pub const OBJECTS: &[Row] = &[
    (0x1000, 0, 4, Ro, 0x704019A), (0x1001, 0, 1, Ro, 0), (0x1003, 0, 1, Command, 0), (0x1005, 0, 4, Rw, 128),
    (0x1008, 0, 0, Ro, 0), (0x1009, 0, 0, Ro, 0), (0x100A, 0, 0, Ro, 0), (0x1010, 0, 1, Ro, 4), (0x1010, 1, 4, Command, 1),
    (0x1010, 2, 4, Command, 1), (0x1010, 3, 4, Command, 1), (0x1010, 4, 4, Command, 1), (0x1011, 0, 1, Ro, 5),
    (0x1011, 1, 4, Command, 1), (0x1011, 2, 4, Command, 1), (0x1011, 3, 4, Command, 1), (0x1011, 4, 4, Command, 1),
    (0x1011, 5, 4, Command, 1), (0x1014, 0, 4, Rw, 178), (0x1017, 0, 2, Rw, 0), (0x1018, 0, 1, Ro, 4), (0x1018, 1, 4, Ro, 405),
    (0x1018, 2, 4, Ro, 0x1869F), (0x1018, 3, 4, Ro, 0), (0x1018, 4, 4, Ro, SERIAL), (0x1800, 0, 1, Ro, 5),
    (0x1800, 1, 4, Rw, 434), (0x1800, 2, 1, Rw, 254), (0x1800, 3, 2, Rw, 0), (0x1800, 5, 2, Rw, 0), (0x1A00, 0, 1, Rw, 2),
    (0x1A00, 1, 4, Rw, 0x61100020), (0x1A00, 2, 4, Rw, 0x61200020), (0x1A00, 3, 4, Rw, 0), (0x1A00, 4, 4, Rw, 0),
    (0x1A00, 5, 4, Rw, 0), (0x1A00, 6, 4, Rw, 0), (0x1A00, 7, 4, Rw, 0), (0x1A00, 8, 4, Rw, 0), (0x1801, 0, 1, Ro, 5),
    (0x1801, 1, 4, Rw, 0x800002B2), (0x1801, 2, 1, Rw, 254), (0x1801, 3, 2, Rw, 0), (0x1801, 5, 2, Rw, 0),
    (0x1A01, 0, 1, Rw, 0), (0x1A01, 1, 4, Rw, 0), (0x1A01, 2, 4, Rw, 0), (0x1A01, 3, 4, Rw, 0), (0x1A01, 4, 4, Rw, 0),
    (0x1A01, 5, 4, Rw, 0), (0x1A01, 6, 4, Rw, 0), (0x1A01, 7, 4, Rw, 0), (0x1A01, 8, 4, Rw, 0), (0x1802, 0, 1, Ro, 5),
    (0x1802, 1, 4, Rw, 0x800003B2), (0x1802, 2, 1, Rw, 254), (0x1802, 3, 2, Rw, 0), (0x1802, 5, 2, Rw, 0),
    (0x1A02, 0, 1, Rw, 0), (0x1A02, 1, 4, Rw, 0), (0x1A02, 2, 4, Rw, 0), (0x1A02, 3, 4, Rw, 0), (0x1A02, 4, 4, Rw, 0),
    (0x1A02, 5, 4, Rw, 0), (0x1A02, 6, 4, Rw, 0), (0x1A02, 7, 4, Rw, 0), (0x1A02, 8, 4, Rw, 0), (0x1803, 0, 1, Ro, 5),
    (0x1803, 1, 4, Rw, 0x800004B2), (0x1803, 2, 1, Rw, 254), (0x1803, 3, 2, Rw, 0), (0x1803, 5, 2, Rw, 0),
    (0x1A03, 0, 1, Rw, 0), (0x1A03, 1, 4, Rw, 0), (0x1A03, 2, 4, Rw, 0), (0x1A03, 3, 4, Rw, 0), (0x1A03, 4, 4, Rw, 0),
    (0x1A03, 5, 4, Rw, 0), (0x1A03, 6, 4, Rw, 0), (0x1A03, 7, 4, Rw, 0), (0x1A03, 8, 4, Rw, 0), (0x2000, 0, 1, Ro, 3),
    (0x2000, 1, 0, Ro, 0), (0x2000, 2, 4, Ro, 1), (0x2000, 3, 0, Ro, 0), (0x2001, 0, 4, Rw, 0x1E848), (0x2002, 0, 1, Rw, 50),
    (0x2010, 0, 1, Ro, 2), (0x2010, 1, 1, Wo, 0), (0x2020, 0, 1, Ro, 1), (0x2020, 1, 4, Ro, 0), (0x20FF, 0, 2, Ro, 1),
    (0x2102, 0, 1, Rw, 128), (0x2104, 0, 1, Ro, 4), (0x2104, 1, 2, Rw, 10), (0x2104, 2, 2, Rw, 0), (0x2104, 3, 2, Rw, 0),
    (0x2104, 4, 2, Rw, 0), (0x2105, 0, 1, Ro, 4), (0x2105, 1, 1, Rw, 3), (0x2105, 2, 1, Rw, 3), (0x2105, 3, 1, Rw, 3),
    (0x2105, 4, 1, Rw, 3), (0x2106, 0, 1, Ro, 9), (0x2106, 1, 1, Rw, 1), (0x2106, 2, 1, Rw, 0), (0x2106, 3, 1, Rw, 0),
    (0x2106, 4, 1, Rw, 0), (0x2106, 5, 1, Rw, 145), (0x2106, 6, 1, Rw, 0), (0x2106, 7, 1, Rw, 0), (0x2106, 8, 2, Rw, 0x7FF),
    (0x2106, 9, 4, Ro, 0x0003_0201), (0x3000, 0, 1, Ro, 5), (0x3000, 1, 1, Ro, 5), (0x3000, 2, 1, Ro, 0), (0x3000, 3, 1, Ro, 0),
    (0x3000, 4, 1, Ro, 0), (0x3000, 5, 1, Ro, 0), (0x3010, 0, 1, Ro, 3), (0x3010, 1, 2, Ro, 0), (0x3010, 2, 2, Ro, 0),
    (0x3010, 3, 2, Ro, 1000), (0x3011, 0, 4, Ro, 0), (0x3012, 0, 4, Ro, 0), (0x3013, 0, 4, Ro, 1000), (0x3020, 0, 1, Ro, 3),
    (0x3020, 1, 2, Ro, 0), (0x3020, 2, 2, Ro, 0), (0x3020, 3, 2, Ro, 0), (0x3021, 0, 4, Ro, 0), (0x3022, 0, 4, Ro, 0),
    (0x3023, 0, 4, Ro, 0), (0x3100, 0, 1, Ro, 2), (0x3100, 1, 1, Rw, 2), (0x3100, 2, 1, Rw, 1), (0x3110, 0, 1, Ro, 2),
    (0x3110, 1, 1, Rw, 2), (0x3110, 2, 1, Rw, 0), (0x3111, 0, 2, Rw, 0x7D0), (0x3112, 0, 1, Ro, 4), (0x3112, 1, 1, Rw, 1),
    (0x3112, 2, 1, Rw, 253), (0x3112, 3, 1, Rw, 1), (0x3112, 4, 1, Rw, 1), (0x3120, 0, 1, Ro, 1), (0x3120, 1, 1, Rw, 1),
    (0x3200, 0, 1, Wo, 0), (0x3210, 0, 4, Rw, 0), (0x3220, 0, 4, Rw, 0), (0x6000, 0, 2, Ro, 10), (0x6110, 0, 4, Ro, 0),
    (0x6111, 0, 1, Ro, 0), (0x6120, 0, 4, Ro, 0), (0x6121, 0, 1, Ro, 0), (0x6511, 0, 1, Ro, 25),
];

/// A level sensor.
#[test]
fn objects_have_type_and_factory_value_of_manual() {
    let mut t = booted();
    t.assert_dictionary(OBJECTS);
    assert_eq!(t.read_text(0x1008), "IMS360");
    assert_eq!(t.sdo("4009100000000000"), "4B09100030310000", "01");
    assert_eq!(t.read_text(0x100A), "010000");
    assert_eq!(t.read_text_at(0x2000, 1), SERIAL.to_string());
    assert_eq!(t.read_text_at(0x2000, 3), "IMS360");
    for sub in 1..=8 {
        assert_eq!(t.read(0x1003, sub), Err(NO_DATA), "empty");
        assert_eq!(t.write(0x1003, sub, 4, 0), Err(0x0601_0002));
    }
}

#[test]
fn objects_have_access_of_manual() {
    let mut t = booted();
    t.assert_access(OBJECTS);
    t.send("000#0132");
    // Written in pre-operational only.
    let mut rows = OBJECTS.to_vec();
    rows.retain(|row| !matches!(row.0, 0x1005 | 0x1014));
    t.assert_access(&rows);
    assert_eq!(t.memory, None);
}

#[test]
fn data_of_another_length_is_refused() {
    let mut rows = OBJECTS.to_vec();
    // The error list takes one byte and four, as that of the JN2101.
    rows.retain(|row| row.0 != 0x1003);
    booted().assert_lengths(&rows);
}

#[test]
fn no_other_object_or_sub_index_exists() {
    let mut rows = OBJECTS.to_vec();
    rows.extend((1..=8).map(|sub| (0x1003, sub, 4, Ro, 0)));
    rows.sort_by_key(|row| (row.0, row.1));
    booted().assert_no_other(&rows);
}

/// Both sides of the limits of a time in ms, and of the filter frequency in mHz.
const CYCLES: &[RangeInclusive<u32>] = &[0..=300, 65_500..=65_535];
const FREQUENCIES: &[RangeInclusive<u32>] =
    &[0..=110, 7_990..=8_010, 24_990..=25_010, 65_530..=65_535];

fn has_bits(value: u32, bits: u32) -> bool {
    value < 1 << bits
}

#[test]
fn settings_accept_exactly_the_values_of_manual() {
    let one = |index, sub, size, tried, accepted| Values {
        index,
        sub,
        size,
        tried,
        accepted,
    };
    let cycle: fn(u32) -> bool = |ms| ms == 0 || ms >= 10;
    let mantissa: fn(u32) -> bool = |value| matches!(value as u8 as i8, 1..=127);
    let exponent: fn(u32) -> bool = |value| matches!(value as u8 as i8, -10..=10);
    let types: fn(u32) -> bool = |kind| matches!(kind, 1..=240 | 252..=255);
    let mut values = vec![
        one(0x1017, 0, 2, CYCLES, cycle),
        one(
            0x1005,
            0,
            4,
            &[0..=0x1000],
            |id| matches!(id, 0x080..=0x100 | 0x181..=0x580 | 0x600 | 0x680..=0x6DF | 0x700),
        ),
        one(0x2002, 0, 1, BYTE, |node| matches!(node, 1..=126)),
        one(0x2102, 0, 1, BYTE, |address| address <= 253),
        one(0x2106, 1, 1, BYTE, |value| has_bits(value, 1)),
        one(0x2106, 2, 1, BYTE, |value| has_bits(value, 3)),
        one(0x2106, 3, 1, BYTE, |value| has_bits(value, 4)),
        one(0x2106, 4, 1, BYTE, |value| has_bits(value, 7)),
        one(0x2106, 5, 1, BYTE, |_| true),
        one(0x2106, 6, 1, BYTE, |value| has_bits(value, 5)),
        one(0x2106, 7, 1, BYTE, |value| has_bits(value, 3)),
        one(0x2106, 8, 2, &[0..=2100, 65_535..=65_535], |value| {
            has_bits(value, 11)
        }),
        // 1 J1939, 2 CANopen.
        one(0x3100, 1, 1, BYTE, |value| matches!(value, 1 | 2)),
        one(0x3100, 2, 1, BYTE, |value| value <= 1),
        one(0x3110, 1, 1, BYTE, |value| value <= 2),
        one(0x3110, 2, 1, BYTE, |value| value <= 1),
        // Critically damped, as delivered: up to 8 Hz.
        one(0x3111, 0, 2, FREQUENCIES, |value| {
            (100..=8_000).contains(&value)
        }),
        one(0x3112, 1, 1, BYTE, mantissa),
        one(0x3112, 2, 1, BYTE, exponent),
        one(0x3112, 3, 1, BYTE, mantissa),
        one(0x3112, 4, 1, BYTE, exponent),
        one(0x3120, 1, 1, BYTE, |value| value <= 1),
    ];
    values.extend((0x1800..0x1804).map(|index| one(index, 2, 1, BYTE, types)));
    for sub in 1..=4 {
        values.push(one(0x2104, sub, 2, CYCLES, cycle));
        values.push(one(0x2105, sub, 1, BYTE, |value| has_bits(value, 3)));
    }
    let mut t = booted();
    t.assert_values(&values);
    let rates = [125_000, 250_000, 500_000, 800_000, 1_000_000];
    let refused = [0, 125, 10_000, 20_000, 50_000, 100_000, 125_001, u32::MAX];
    for rate in rates {
        assert_eq!(t.write(0x2001, 0, 4, rate), Ok(()), "{rate}");
        t.assert_refused(0x2001, 0, 4, &refused, NOT_PERMITTED);
        assert_eq!(t.read(0x2001, 0), Ok(rate));
    }
    for index in 0x1800..0x1804 {
        for (sub, value) in [(3, 1), (3, 65_535), (5, 1), (5, 65_535)] {
            assert_eq!(t.write(index, sub, 2, value), Ok(()), "{index:04X}h");
            assert_eq!(t.read(index, sub), Ok(value), "{index:04X}h");
        }
    }
    t.assert_refused(0x1005, 0, 4, &[0x4000_0080, 0x2000_0080], NOT_PERMITTED);
    assert_eq!(t.memory, None);
}

#[test]
fn filter_frequency_without_critical_damping_is_up_to_25_hz() {
    let mut t = booted();
    for kind in [0, 1] {
        t.write(0x3110, 1, 1, kind).unwrap();
        t.assert_values(&[Values {
            index: 0x3111,
            sub: 0,
            size: 2,
            tried: FREQUENCIES,
            accepted: |value| (100..=25_000).contains(&value),
        }]);
    }
}

/// A configuration is downloaded in the order of the indices: the type comes before the frequency.
#[test]
fn critical_damping_lowers_a_filter_frequency_above_8_hz() {
    for (kind, before, after) in [
        (0, 25_000, 8_000),
        (1, 8_001, 8_000),
        (1, 8_000, 8_000),
        (0, 100, 100),
    ] {
        let mut t = booted();
        t.write(0x3110, 1, 1, kind).unwrap();
        t.write(0x3111, 0, 2, before).unwrap();
        assert_eq!(t.write(0x3110, 1, 1, 2), Ok(()));
        assert_eq!(t.read(0x3111, 0), Ok(after), "{before}");
        t.assert_refused(0x3111, 0, 2, &[8_001, 25_000], NOT_PERMITTED);
        assert_eq!(t.read(0x3111, 0), Ok(after));
    }
}

#[test]
fn offsets_take_each_value_of_32_bits() {
    let mut t = booted();
    t.write(0x1014, 0, 4, 0x8000_00B2).unwrap();
    for index in [0x3210, 0x3220] {
        for value in [1, 0x7FFF_FFFF, 0x8000_0000, u32::MAX, 0] {
            assert_eq!(t.write(index, 0, 4, value), Ok(()));
            assert_eq!(t.read(index, 0), Ok(value), "{index:04X}h");
        }
    }
}

#[test]
fn commands_refuse_other_values_and_do_nothing() {
    let mut t = booted();
    let from = |first| (first..=255).collect::<Vec<_>>();
    t.assert_refused(0x2010, 1, 1, &[&[0], &from(2)[..]].concat(), NOT_PERMITTED);
    t.assert_refused(0x3200, 0, 1, &[&[0], &from(4)[..]].concat(), NOT_PERMITTED);
    t.assert_refused(0x1003, 0, 1, &from(1), NOT_PERMITTED);
    let of = |text: &[u8; 4]| u32::from_le_bytes(*text);
    let texts = [
        b"evas", b"daol", b"SAVE", b"LOAD", &[0; 4], b"save", b"load",
    ]
    .map(of);
    for (index, own, subs) in [(0x1010, b"save", 1..=4), (0x1011, b"load", 1..=5)] {
        let others: Vec<_> = texts.into_iter().filter(|text| *text != of(own)).collect();
        for sub in subs {
            t.assert_refused(index, sub, 4, &others, SIGNATURE);
        }
    }
    assert_eq!(t.wait_text(500), []);
    assert_eq!(t.memory, None);
}

#[test]
fn identifiers_of_sync_and_emergency_change_in_pre_operational_only() {
    let mut t = booted();
    t.send("000#0132");
    t.assert_refused(0x1005, 0, 4, &[0x81, 0x85], DEVICE_STATE);
    t.assert_refused(0x1014, 0, 4, &[0xB3, 0x8000_00B2], DEVICE_STATE);
    assert_eq!(t.write(0x1005, 0, 4, 0x80), Ok(()), "in force");
    assert_eq!(t.write(0x1014, 0, 4, 0xB2), Ok(()), "in force");
}
