//! The object dictionary of the JN2101: types, factory values, access and permitted values (manual 7.6, 7.7 and 14).

use crate::tester::SERIAL;
use crate::tester::canopen::*;
use crate::tester::dictionary::Access::{Command, Fixed, Own, Ro, Rw};
use crate::tester::dictionary::{BYTE, MEASURED, Row, Values, WORD};

const TOO_LONG: u32 = 0x0607_0012;
const VALUE: u32 = 0x0609_0030;
const TOO_HIGH: u32 = 0x0609_0031;
const SIGNATURE: u32 = 0x0800_0020;

/// The objects of the manual: 7.6, 7.7 and 14. 1003h has the sub-indices 1 to 50 besides.
#[rustfmt::skip]
const OBJECTS: &[Row] = &[
    (0x1000, 0, 4, Ro, 0x0004_019A), (0x1001, 0, 1, Ro, 0), (0x1003, 0, 1, Command, 0), (0x1005, 0, 4, Rw, 0x80),
    (0x1008, 0, 0, Ro, 0), (0x1009, 0, 0, Ro, 0), (0x100A, 0, 0, Ro, 0), (0x100C, 0, 2, Rw, 0), (0x100D, 0, 1, Rw, 0),
    (0x1010, 0, 1, Ro, 1), (0x1010, 1, 4, Command, 0), (0x1011, 0, 1, Ro, 1), (0x1011, 1, 4, Command, 0),
    (0x1014, 0, 4, Own, 0x8A), (0x1015, 0, 2, Rw, 0), (0x1017, 0, 2, Rw, 0), (0x1018, 0, 1, Ro, 4),
    (0x1018, 1, 4, Ro, 0x6D66_6900), (0x1018, 2, 4, Ro, 0x01), (0x1018, 3, 4, Ro, 0xAA), (0x1018, 4, 4, Ro, SERIAL),
    (0x1029, 0, 1, Ro, 1), (0x1029, 1, 1, Rw, 0), (0x1200, 0, 1, Ro, 2), (0x1200, 1, 4, Ro, 0x60A), (0x1200, 2, 4, Ro, 0x58A),
    (0x1800, 0, 1, Ro, 5), (0x1800, 1, 4, Rw, 0x18A), (0x1800, 2, 1, Rw, 1), (0x1800, 3, 2, Rw, 0), (0x1800, 5, 2, Rw, 10),
    (0x1801, 0, 1, Ro, 5), (0x1801, 1, 4, Rw, 0x28A), (0x1801, 2, 1, Rw, 1), (0x1801, 3, 2, Rw, 0), (0x1801, 5, 2, Rw, 10),
    (0x1A00, 0, 1, Fixed, 2), (0x1A00, 1, 4, Fixed, 0x6010_0010), (0x1A00, 2, 4, Fixed, 0x6020_0010), (0x1A01, 0, 1, Fixed, 2),
    (0x1A01, 1, 4, Fixed, 0x6110_0020), (0x1A01, 2, 4, Fixed, 0x6120_0020), (0x1F80, 0, 4, Rw, 0), (0x2000, 0, 1, Rw, 10),
    (0x2001, 0, 2, Rw, 125), (0x2002, 0, 1, Command, 0), (0x2040, 0, 1, Rw, 1), (0x2041, 0, 1, Rw, 1),
    (0x2042, 0, 1, Command, 2), (0x2043, 0, 1, Rw, 2), (0x2044, 0, 1, Rw, 0), (0x2045, 0, 1, Rw, 1), (0x2046, 0, 1, Command, 2),
    (0x207F, 0, 1, Command, 0), (0x3000, 0, 0, Command, 0), (0x4004, 0, 1, Ro, 2), (0x4004, 1, 1, Command, 0),
    (0x4004, 2, 1, Ro, 0), (0x4080, 0, 4, Ro, 250), (0x4081, 0, 2, Ro, MEASURED), (0x6000, 0, 2, Rw, 10), (0x6010, 0, 2, Ro, 0),
    (0x6011, 0, 1, Ro, 0), (0x6020, 0, 2, Ro, 0), (0x6021, 0, 1, Ro, 0), (0x6110, 0, 4, Ro, 0), (0x6111, 0, 1, Ro, 0),
    (0x6120, 0, 4, Ro, 0), (0x6121, 0, 1, Ro, 0),
];

pub fn objects() -> Vec<Row> {
    let mut rows = OBJECTS.to_vec();
    rows.extend((1..=50).map(|sub| (0x1003, sub, 4, Ro, 0)));
    rows.sort_by_key(|row| (row.0, row.1));
    rows
}

#[test]
fn objects_have_type_and_factory_value_of_manual() {
    let mut t = booted();
    t.assert_dictionary(&objects());
    assert_eq!(t.read_text(0x1008), "JN2101");
    assert_eq!(t.read_text(0x1009), "1.0.0");
    assert_eq!(t.read_text(0x100A), "2.2.0");
    assert_eq!(t.read_text(0x3000), "D0UfZEgRKHAI5Ag=");
}

#[test]
fn objects_have_access_of_manual() {
    for state in ["000#800A", "000#010A"] {
        let mut t = booted();
        t.send(state);
        t.assert_access(&objects());
        t.sent();
        assert_eq!(t.memory, None);
    }
}

#[test]
fn data_of_another_length_is_refused() {
    let mut rows = objects();
    // It takes one byte and four: see below.
    rows.retain(|row| row.0 != 0x1003);
    booted().assert_lengths(&rows);
}

#[test]
fn no_other_object_or_sub_index_exists() {
    booted().assert_no_other(&objects());
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
    let any: fn(u32) -> bool = |_| true;
    let types: fn(u32) -> bool = |kind| !(241..=251).contains(&kind);
    let values = [
        one(0x100D, 0, 1, BYTE, any),
        one(0x1029, 1, 1, BYTE, |value| value <= 2),
        one(0x1800, 2, 1, BYTE, types),
        one(0x1801, 2, 1, BYTE, types),
        one(0x1F80, 0, 4, &[0..=300], |value| matches!(value, 0 | 2 | 8)),
        one(0x2000, 0, 1, BYTE, |node| matches!(node, 1..=127)),
        one(0x2001, 0, 2, WORD, |rate| {
            matches!(rate, 10 | 20 | 50 | 125 | 250 | 500 | 800 | 1000)
        }),
        one(0x2040, 0, 1, BYTE, |value| value <= 2),
        one(0x2041, 0, 1, BYTE, |value| value <= 1),
        one(0x2043, 0, 1, BYTE, |value| value <= 4),
        one(0x2044, 0, 1, BYTE, |value| value <= 3),
        one(0x2045, 0, 1, BYTE, |value| value <= 1),
        one(0x6000, 0, 2, WORD, |step| {
            matches!(step, 1 | 10 | 100 | 1000)
        }),
        // SYNC: those that CiA 301 does not restrict (table 81), and that the sensor does not send.
        one(0x1005, 0, 4, &[0..=0x1000], |id| {
            matches!(id, 0x080..=0x100 | 0x181..=0x580 | 0x600 | 0x680..=0x6DF | 0x700)
                && !matches!(id, 0x08A | 0x18A | 0x28A)
        }),
    ];
    let mut t = booted();
    t.assert_values(&values);
    for index in [0x100C, 0x1015, 0x1017, 0x1800, 0x1801] {
        let subs: &[u8] = if index < 0x1800 { &[0] } else { &[3, 5] };
        for &sub in subs {
            for value in [1, 255, 256, 65_535] {
                assert_eq!(t.write(index, sub, 2, value), Ok(()), "{index:04X}h");
                assert_eq!(t.read(index, sub), Ok(value), "{index:04X}h");
            }
        }
    }
    assert_eq!(t.memory, None);
}

#[test]
fn commands_refuse_other_values_and_do_nothing() {
    let mut t = booted();
    let above = |limit: u32| (limit + 1..=255).collect::<Vec<_>>();
    t.assert_refused(0x2002, 0, 1, &above(1), TOO_HIGH);
    t.assert_refused(0x2042, 0, 1, &above(2), TOO_HIGH);
    t.assert_refused(0x2046, 0, 1, &above(2), TOO_HIGH);
    t.assert_refused(0x4004, 1, 1, &above(1), TOO_HIGH);
    t.assert_refused(0x207F, 0, 1, &above(1), VALUE);
    t.assert_refused(0x207F, 0, 1, &[0], VALUE);
    t.assert_refused(0x1003, 0, 1, &above(0), VALUE);
    t.assert_refused(0x1003, 0, 4, &[1, 0x100, u32::MAX], VALUE);
    let of = |text: &[u8; 4]| u32::from_le_bytes(*text);
    let signatures = [b"evas", b"daol", b"SAVE", b"LOAD", b"wron"].map(of);
    for (index, own) in [(0x1010, b"save"), (0x1011, b"load")] {
        t.assert_refused(index, 1, 4, &signatures, SIGNATURE);
        let others = [b"save", b"load", &[0; 4]].map(of);
        let others: Vec<_> = others.into_iter().filter(|text| *text != of(own)).collect();
        t.assert_refused(index, 1, 4, &others, SIGNATURE);
    }
    assert_eq!(t.wait_text(500), []);
    for (index, sub) in [(0x2042, 0), (0x2046, 0)] {
        assert_eq!(t.read(index, sub), Ok(2));
    }
    assert_eq!(t.read(0x4004, 1), Ok(0));
    assert_eq!(t.memory, None);
}

#[test]
fn sync_identifier_with_another_flag_or_29_bits_is_refused() {
    let mut t = booted();
    for value in [0x4000_0080, 0x2000_0080, 0x0001_0080, 0x0800] {
        assert_eq!(t.write(0x1005, 0, 4, value), Err(VALUE), "{value:X}h");
    }
    assert_eq!(t.read(0x1005, 0), Ok(0x80));
}

#[test]
fn sync_identifier_that_a_new_node_id_makes_its_own_is_sent_and_not_consumed() {
    for (sync, node_id) in [(0x085, 5), (0x185, 5), (0x285, 5)] {
        let mut t = booted();
        assert_eq!(t.write(0x1005, 0, 4, sync), Ok(()));
        t.write(0x2000, 0, 1, node_id).unwrap();
        t.write(0x1800, 5, 2, 0).unwrap();
        t.store();
        t.send("000#010A");
        let request = format!("{sync:03X}#");
        assert_eq!(t.exchange(&request).len(), 2);
        t.power_cycle();
        t.node_id = 5;
        t.send("000#0105");
        t.sent_text();
        assert_eq!(t.exchange(&request), [""; 0], "{sync:03X}h");
        assert_eq!(t.exchange("185#R4"), ["185#00000000"]);
        assert_eq!(t.read(0x1005, 0), Ok(sync));
        assert_eq!(t.write(0x1005, 0, 4, sync), Ok(()), "in force");
        assert_eq!(t.write(0x1005, 0, 4, 0x80), Ok(()));
        assert_eq!(t.exchange("080#").len(), 2);
        assert_eq!(t.write(0x1005, 0, 4, sync), Err(VALUE));
    }
}

/// The new node-ID is written before the other settings.
#[test]
fn sync_cob_id_of_present_node_id_is_accepted_if_pending_node_id_does_not_use_it() {
    for sync in [0x08A, 0x18A, 0x28A] {
        let mut t = booted();
        assert_eq!(t.write(0x1005, 0, 4, sync), Err(VALUE), "{sync:03X}h");
        t.write(0x2000, 0, 1, 20).unwrap();
        assert_eq!(t.write(0x1005, 0, 4, sync), Ok(()), "{sync:03X}h");
        assert_eq!(t.read(0x1005, 0), Ok(sync));
        // Until the reset, the sensor sends with this identifier and does not take it as SYNC.
        t.send("000#010A");
        assert_eq!(t.exchange(&format!("{sync:03X}#")), [""; 0]);
        t.store();
        t.power_cycle();
        t.node_id = 20;
        t.send("000#0114");
        t.sent_text();
        let tpdos = ["194#00000000", "294#0000000000000000"];
        assert_eq!(t.exchange(&format!("{sync:03X}#")), tpdos);
        // The present node-ID uses this identifier, and so does the stored one.
        assert_eq!(t.write(0x1005, 0, 4, sync + 10), Err(VALUE));
    }
}

/// 1003h:00 is u8; the manual prints u32.
#[test]
fn error_list_is_cleared_with_one_byte_and_with_four() {
    for clear in [
        &["2F03100000000000"][..],
        &["2303100000000000"],
        &["2203100000000000"],
        &["2103100001000000", "0D00000000000000"],
        &["2103100004000000", "0700000000000000"],
        &["2003100000000000", "0700000000000000"],
    ] {
        let mut t = booted();
        t.tilt(60.0, 0.0);
        t.wait_text(10);
        assert_eq!(t.read(0x1003, 0), Ok(1));
        for request in clear {
            let reply = t.sdo(request);
            assert!(!reply.starts_with("80"), "{request} -> {reply}");
        }
        assert_eq!(t.read(0x1003, 0), Ok(0), "{clear:?}");
    }
    let mut t = booted();
    t.tilt(60.0, 0.0);
    t.wait_text(10);
    for size in [2, 3] {
        assert_eq!(t.write(0x1003, 0, size, 0), Err(TOO_LONG));
    }
    assert_eq!(t.read(0x1003, 0), Ok(1));
}
