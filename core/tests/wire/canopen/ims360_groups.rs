//! What the IMS360 stores and restores: each setting with its group of 1010h and 1011h, and bit 2 of the status byte (manual, 7.2.8,
//! 7.2.9 and 7.2.27; S44, S54, S55 and S65 of the product's README).

use crate::tester::canopen::write_request;
use crate::tester::dictionary::Access::Rw;
use crate::tester::ims360::{Ims360Tester, booted};

const SAVE: u32 = 0x6576_6173;
const LOAD: u32 = 0x6461_6F6C;

/// Index, sub-index, size, value as delivered, another value.
type Setting = (u16, u8, u8, u32, u32);

/// The settings of 1000h to 1FFFh. 1803h is that of another TPDO.
#[rustfmt::skip]
const COMMUNICATION: &[Setting] = &[
    (0x1005, 0, 4, 0x80, 0x85), (0x1014, 0, 4, 0xB2, 0xB9), (0x1017, 0, 2, 0, 60_000),
    (0x1800, 1, 4, 0x1B2, 0x1C0), (0x1800, 2, 1, 254, 3), (0x1800, 3, 2, 0, 7), (0x1800, 5, 2, 0, 77),
    (0x1801, 1, 4, 0x8000_02B2, 0x1C1), (0x1801, 2, 1, 254, 4), (0x1801, 3, 2, 0, 8), (0x1801, 5, 2, 0, 78),
    (0x1802, 1, 4, 0x8000_03B2, 0x1C2), (0x1802, 2, 1, 254, 5), (0x1802, 3, 2, 0, 9), (0x1802, 5, 2, 0, 79),
    (0x1803, 1, 4, 0x8000_04B2, 0x1C3), (0x1803, 2, 1, 254, 6), (0x1803, 3, 2, 0, 10), (0x1803, 5, 2, 0, 80),
    (0x1A00, 0, 1, 2, 1), (0x1A00, 1, 4, 0x6110_0020, 0x6511_0008), (0x1A00, 2, 4, 0x6120_0020, 0),
    (0x1A01, 0, 1, 0, 1), (0x1A01, 1, 4, 0, 0x3010_0110), (0x1A02, 0, 1, 0, 2), (0x1A02, 1, 4, 0, 0x3000_0108),
    (0x1A02, 2, 4, 0, 0x3100_0108), (0x1A03, 0, 1, 0, 0), (0x1A03, 8, 4, 0, 0x6120_0020),
];

/// The settings of 2000h to 5FFFh but node-ID and bit rate.
#[rustfmt::skip]
const MANUFACTURER: &[Setting] = &[
    (0x2102, 0, 1, 128, 200), (0x2104, 1, 2, 10, 100), (0x2104, 2, 2, 0, 101), (0x2104, 3, 2, 0, 102), (0x2104, 4, 2, 0, 103),
    (0x2105, 1, 1, 3, 4), (0x2105, 2, 1, 3, 5), (0x2105, 3, 1, 3, 6), (0x2105, 4, 1, 3, 7),
    (0x2106, 1, 1, 1, 0), (0x2106, 2, 1, 0, 2), (0x2106, 3, 1, 0, 3), (0x2106, 4, 1, 0, 4), (0x2106, 5, 1, 145, 5),
    (0x2106, 6, 1, 0, 6), (0x2106, 7, 1, 0, 7), (0x2106, 8, 2, 2047, 8),
    (0x3100, 2, 1, 1, 0), (0x3110, 1, 1, 2, 1), (0x3110, 2, 1, 0, 1), (0x3111, 0, 2, 2000, 12_000),
    (0x3112, 1, 1, 1, 5), (0x3112, 2, 1, 0xFD, 0xFC), (0x3112, 3, 1, 1, 6), (0x3112, 4, 1, 1, 2),
    (0x3210, 0, 4, 0, -1000_i32 as u32), (0x3220, 0, 4, 0, 77),
];

/// Writes all settings in the order that the dynamic mapping requires: off, entries, number, on.
fn change(t: &mut Ims360Tester) {
    t.write(0x1014, 0, 4, 0x8000_00B2).unwrap();
    t.write(0x1800, 1, 4, 0x8000_01B2).unwrap();
    t.write(0x1A00, 0, 1, 0).unwrap();
    let is_entry = |row: &&Setting| (0x1A00..0x1B00).contains(&row.0) && row.1 > 0;
    let is_cob_id = |row: &&Setting| (0x1800..0x1900).contains(&row.0) && row.1 == 1;
    let entries = COMMUNICATION.iter().filter(is_entry);
    let others = COMMUNICATION
        .iter()
        .filter(|row| !is_entry(row) && !is_cob_id(row));
    let last = COMMUNICATION.iter().filter(is_cob_id);
    for &(index, sub, size, _, value) in entries.chain(others).chain(last).chain(MANUFACTURER) {
        let written = t.write(index, sub, size, value);
        assert_eq!(written, Ok(()), "{index:04X}h:{sub:02X}");
    }
}

fn expect(t: &mut Ims360Tester, settings: &[Setting], is_changed: bool, name: &str) {
    for &(index, sub, _, delivered, changed) in settings {
        let value = if is_changed { changed } else { delivered };
        let read = t.read(index, sub);
        assert_eq!(read, Ok(value), "{name}: {index:04X}h:{sub:02X}");
    }
}

#[test]
fn tables_have_each_setting() {
    let rows = super::ims360_dictionary::OBJECTS.iter();
    let settings: Vec<_> = rows
        .filter(|row| row.3 == Rw)
        .map(|row| (row.0, row.1))
        .filter(|key| !matches!(key.0, 0x2001 | 0x2002 | 0x3120) && *key != (0x3100, 1))
        // Of the entries of a mapping, some.
        .filter(|key| !(0x1A00..0x1B00).contains(&key.0))
        .collect();
    let tables = COMMUNICATION.iter().chain(MANUFACTURER);
    let listed: Vec<_> = tables
        .map(|row| (row.0, row.1))
        .filter(|key| !(0x1A00..0x1B00).contains(&key.0))
        .collect();
    assert_eq!(listed, settings);
}

#[test]
fn each_setting_is_stored_with_its_group() {
    for (group, communication, manufacturer) in [
        (1, true, true),
        (2, true, false),
        (3, false, false),
        (4, false, true),
    ] {
        let mut t = booted();
        change(&mut t);
        assert_eq!(t.write(0x1010, group, 4, SAVE), Ok(()));
        expect(&mut t, COMMUNICATION, true, "the save changes nothing");
        expect(&mut t, MANUFACTURER, true, "the save changes nothing");
        t.power_cycle();
        t.sent();
        let name = format!("1010h:{group:02X}");
        expect(&mut t, COMMUNICATION, communication, &name);
        expect(&mut t, MANUFACTURER, manufacturer, &name);
        t.exchange("000#8132");
        expect(&mut t, COMMUNICATION, communication, &name);
        expect(&mut t, MANUFACTURER, manufacturer, &name);
    }
}

#[test]
fn each_setting_is_restored_with_its_group() {
    for (group, communication, manufacturer) in [
        (1, false, false),
        (2, false, true),
        (3, true, true),
        (4, true, false),
        (5, false, false),
    ] {
        let mut t = booted();
        change(&mut t);
        t.store();
        let name = format!("1011h:{group:02X}");
        for restart in ["power", "000#8132"] {
            assert_eq!(t.write(0x1011, group, 4, LOAD), Ok(()));
            expect(&mut t, COMMUNICATION, true, "not before the restart");
            expect(&mut t, MANUFACTURER, true, "not before the restart");
            if restart == "power" {
                t.power_cycle();
            } else {
                t.send(restart);
            }
            t.sent();
            expect(&mut t, COMMUNICATION, communication, &name);
            expect(&mut t, MANUFACTURER, manufacturer, &name);
            t.power_cycle();
            t.sent();
            expect(&mut t, COMMUNICATION, true, "used up");
            expect(&mut t, MANUFACTURER, true, "used up");
        }
        t.write(0x1011, group, 4, LOAD).unwrap();
        t.power_cycle();
        t.sent();
        t.store();
        t.power_cycle();
        t.sent();
        expect(&mut t, COMMUNICATION, communication, &name);
        expect(&mut t, MANUFACTURER, manufacturer, &name);
    }
}

#[test]
fn node_id_and_bit_rate_are_restored_by_groups_4_and_5() {
    for (group, stays) in [(1, true), (2, true), (3, true), (4, false), (5, false)] {
        let mut t = booted();
        t.write(0x2002, 0, 1, 60).unwrap();
        t.write(0x2001, 0, 4, 500_000).unwrap();
        t.store();
        t.power_cycle();
        assert_eq!(t.sent_text(), ["73C#00"]);
        t.node_id = 60;
        t.write(0x1011, group, 4, LOAD).unwrap();
        t.power_cycle();
        let (node_id, rate, boot_up) = if stays {
            (60, 500_000, "73C#00")
        } else {
            (50, 125_000, "732#00")
        };
        assert_eq!(t.sent_text(), [boot_up], "1011h:{group:02X}");
        t.node_id = node_id;
        assert_eq!(t.read(0x2002, 0), Ok(node_id.into()));
        assert_eq!(t.read(0x2001, 0), Ok(rate));
    }
}

#[test]
fn status_bit_2_is_set_while_each_setting_has_its_value_as_delivered() {
    let others = [
        (0x2001, 0, 4, 125_000, 500_000),
        (0x2002, 0, 1, 50, 60),
        (0x3120, 1, 1, 1, 0),
        (0x3100, 1, 1, 2, 1),
    ];
    let settings = COMMUNICATION.iter().chain(MANUFACTURER).chain(&others);
    let mut tried = 0;
    for &(index, sub, size, delivered, changed) in settings {
        // Their steps are those of the mapping; 3111h takes 12 Hz with another filter only.
        if (0x1A00..0x1B00).contains(&index) || (index, sub) == (0x1800, 1) || index == 0x1014 {
            continue;
        }
        let changed = if index == 0x3111 { 3000 } else { changed };
        let mut t = booted();
        for (value, bit) in [(delivered, 4), (changed, 0), (delivered, 4)] {
            let written = t.write(index, sub, size, value);
            assert_eq!(written, Ok(()), "{index:04X}h:{sub:02X}");
            let status = t.read(0x3000, 1).unwrap();
            assert_eq!(status & 4, bit, "{index:04X}h:{sub:02X} = {value}");
        }
        tried += 1;
    }
    assert_eq!(tried, 48);
    let mut t = booted();
    t.write(0x1A01, 1, 4, 0x6511_0008).unwrap();
    assert_eq!(t.read(0x3000, 1), Ok(1));
    t.write(0x1A01, 1, 4, 0).unwrap();
    assert_eq!(t.read(0x3000, 1), Ok(5));
}

#[test]
fn history_keeps_the_eight_newest_errors() {
    let mut t = booted();
    for number in 0..10 {
        let index = 0x3210 + 0x10 * (number % 2);
        for offset in [9_500, 0] {
            let request = write_request(index, 0, 4, offset);
            assert_eq!(t.exchange(&format!("632#{request}")).len(), 2, "and EMCY");
            // A code changes at most once a second.
            t.wait(1000);
        }
    }
    assert_eq!(t.read(0x1003, 0), Ok(8));
    for sub in 1..=8 {
        let code = if sub % 2 == 1 { 0x5020 } else { 0x5010 };
        assert_eq!(t.read(0x1003, sub), Ok(code), "{sub}");
    }
}
