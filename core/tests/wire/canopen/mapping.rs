//! The dynamic mapping of TPDOs (CiA 301, 7.5.2.38): the procedure, its aborts, and mappings from memory.

use crate::tester::mapped::*;

const X: u32 = 0x3010_0110;
const Y: u32 = 0x3010_0210;
const FINE_X: u32 = 0x6110_0020;
const STATUS: u32 = 0x3000_0008;
const NUMBER: u32 = 0x3100_0008;

const ACCESS: u32 = 0x0601_0000;
const NO_OBJECT: u32 = 0x0602_0000;
const NOT_MAPPABLE: u32 = 0x0604_0041;
const TOO_MANY: u32 = 0x0604_0042;
const NO_SUB_INDEX: u32 = 0x0609_0011;

/// A node in pre-operational whose second TPDO is disabled and maps nothing.
fn unmapped() -> MappedTester {
    let mut t = mapped();
    t.push([1, 2, 1000]);
    t
}

/// The second TPDO after a SYNC in operational, without its identifier.
fn data(t: &mut MappedTester) -> Vec<String> {
    t.write(0x1800, 2, 1, 253).unwrap();
    t.write(0x1801, 2, 1, 1).unwrap();
    t.send("000#0132");
    t.exchange("080#")
}

#[test]
fn factory_mapping_is_sent_with_sync() {
    let mut t = mapped();
    t.push([1, -2, 1000]);
    t.write(0x1800, 2, 1, 1).unwrap();
    t.send("000#0132");
    assert_eq!(t.exchange("080#"), ["1B2#0100FEFF"]);
    assert_eq!(t.read(0x1A00, 0), Ok(2));
    assert_eq!(t.read(0x1A00, 1), Ok(X));
    assert_eq!(t.read(0x1A00, 3), Ok(0));
    assert_eq!(t.read(0x1A00, 9), Err(NO_SUB_INDEX));
    assert_eq!(t.read(0x1801, 1), Ok(0x8000_02B2));
}

#[test]
fn mapped_objects_are_sent_in_their_order() {
    let mut t = unmapped();
    t.map(1, &[STATUS, FINE_X, Y, NUMBER]);
    t.write(0x3100, 0, 1, 0xA5).unwrap();
    t.push([-1, 0x1234, 0]);
    assert_eq!(data(&mut t), ["2B2#8418FCFFFF3412A5"]);
    t.write(0x3100, 0, 1, 0).unwrap();
    assert_eq!(t.exchange("080#"), ["2B2#0418FCFFFF341200"]);
}

#[test]
fn eight_bytes_in_one_to_eight_objects_are_mapped() {
    let mut t = unmapped();
    t.map(1, &[STATUS; 8]);
    assert_eq!(data(&mut t), ["2B2#0404040404040404"]);
    let mut t = unmapped();
    t.map(1, &[X, X, Y, Y]);
    assert_eq!(data(&mut t), ["2B2#0100010002000200"]);
}

#[test]
fn mapping_changes_in_operational() {
    let mut t = unmapped();
    t.map(1, &[X]);
    assert_eq!(data(&mut t), ["2B2#0100"]);
    t.map(1, &[Y, X]);
    assert_eq!(t.exchange("080#"), ["2B2#02000100"]);
    // Between the first and the last step, the TPDO is silent.
    t.write(0x1801, 1, 4, 0x8000_02B2).unwrap();
    assert_eq!(t.exchange("080#"), [""; 0]);
    t.write(0x1801, 1, 4, 0x2B2).unwrap();
    assert_eq!(t.exchange("080#"), ["2B2#02000100"]);
}

#[test]
fn valid_tpdo_that_maps_nothing_is_silent() {
    let mut t = unmapped();
    t.write(0x1801, 1, 4, 0x2B2).unwrap();
    assert_eq!(data(&mut t), [""; 0]);
    assert_eq!(t.exchange("2B2#R8"), [""; 0]);
}

#[test]
fn write_to_mapping_of_valid_tpdo_is_refused() {
    let mut t = unmapped();
    for (sub, size, value) in [(0, 1, 0), (0, 1, 1), (1, 4, Y), (3, 4, X)] {
        assert_eq!(t.write(0x1A00, sub, size, value), Err(ACCESS), "{sub}");
    }
    // What changes nothing is accepted.
    for (sub, size, value) in [(0, 1, 2), (1, 4, X), (2, 4, Y), (3, 4, 0)] {
        assert_eq!(t.write(0x1A00, sub, size, value), Ok(()), "{sub}");
        assert_eq!(t.read(0x1A00, sub), Ok(value));
    }
}

#[test]
fn write_to_entry_while_number_is_not_0_is_refused() {
    let mut t = unmapped();
    t.write(0x1800, 1, 4, 0x8000_01B2).unwrap();
    assert_eq!(t.write(0x1A00, 1, 4, Y), Err(ACCESS));
    assert_eq!(t.write(0x1A00, 3, 4, Y), Err(ACCESS));
    assert_eq!(t.write(0x1A00, 1, 4, X), Ok(()));
    assert_eq!(t.write(0x1A00, 0, 1, 1), Ok(()));
    assert_eq!(t.write(0x1A00, 0, 1, 0), Ok(()));
    assert_eq!(t.write(0x1A00, 1, 4, Y), Ok(()));
    assert_eq!(t.read(0x1A00, 1), Ok(Y));
}

#[test]
fn entry_that_cannot_be_mapped_is_refused() {
    let mut t = unmapped();
    for (entry, abort) in [
        (0x3011_0010, NO_OBJECT),
        (0x0005_0008, NO_OBJECT),
        (0xFFFF_FFFF, NO_OBJECT),
        (0x3010_0410, NO_SUB_INDEX),
        (0x3010_0008, NOT_MAPPABLE),
        (0x6110_0120, NO_SUB_INDEX),
        (0x3010_0310, NOT_MAPPABLE),
        (0x3101_0008, NOT_MAPPABLE),
        (0x1001_0008, NOT_MAPPABLE),
        (0x1003_0120, NOT_MAPPABLE),
        (0x1005_0020, NOT_MAPPABLE),
        (0x3010_0120, NOT_MAPPABLE),
        (0x3010_0108, NOT_MAPPABLE),
        (0x3010_0100, NOT_MAPPABLE),
        (0x3000_0001, NOT_MAPPABLE),
    ] {
        assert_eq!(t.write(0x1A01, 1, 4, entry), Err(abort), "{entry:08X}");
        assert_eq!(t.read(0x1A01, 1), Ok(0));
    }
    t.write(0x1A01, 1, 4, X).unwrap();
    assert_eq!(t.write(0x1A01, 1, 4, 0), Ok(()), "an entry can be removed");
    assert_eq!(t.write(0x1A01, 1, 2, 0), Err(0x0607_0013));
}

#[test]
fn number_that_does_not_fit_entries_is_refused() {
    let mut t = unmapped();
    assert_eq!(t.write(0x1A01, 0, 1, 1), Err(NOT_MAPPABLE), "empty entry");
    for (sub, entry) in [(1, FINE_X), (2, X), (4, STATUS)] {
        t.write(0x1A01, sub, 4, entry).unwrap();
    }
    assert_eq!(t.write(0x1A01, 0, 1, 4), Err(NOT_MAPPABLE), "empty entry 3");
    t.write(0x1A01, 3, 4, X).unwrap();
    assert_eq!(t.write(0x1A01, 0, 1, 4), Err(TOO_MANY), "72 bits");
    for number in [9, 254, 255] {
        assert_eq!(t.write(0x1A01, 0, 1, number), Err(TOO_MANY), "{number}");
    }
    assert_eq!(t.read(0x1A01, 0), Ok(0));
    assert_eq!(t.write(0x1A01, 0, 1, 3), Ok(()));
    assert_eq!(t.read(0x1A01, 0), Ok(3));
    // A refused number keeps the one before.
    assert_eq!(t.write(0x1A01, 0, 1, 4), Err(TOO_MANY));
    assert_eq!(t.read(0x1A01, 0), Ok(3));
    t.write(0x1801, 1, 4, 0x2B2).unwrap();
    assert_eq!(data(&mut t), ["2B2#E803000001000100"]);
}

#[test]
fn stored_mapping_and_cob_id_are_in_force_after_power_cycle() {
    let mut t = unmapped();
    t.map(1, &[Y, STATUS]);
    t.write(0x1801, 1, 4, 0x8000_02B2).unwrap();
    t.write(0x1801, 1, 4, 0x1C5).unwrap();
    t.write(0x1801, 2, 1, 1).unwrap();
    // Not stored:
    t.write(0x1802, 1, 4, 0x8000_0123).unwrap();
    t.power_cycle();
    assert_eq!(t.sent_text(), ["732#00"]);
    assert_eq!(t.read(0x1801, 1), Ok(0x8000_02B2));
    t.map(1, &[Y, STATUS]);
    t.write(0x1801, 1, 4, 0x8000_02B2).unwrap();
    t.write(0x1801, 1, 4, 0x1C5).unwrap();
    t.write(0x1801, 2, 1, 1).unwrap();
    t.store();
    t.power_cycle();
    assert_eq!(t.sent_text(), ["732#00"]);
    assert_eq!(t.read(0x1802, 1), Ok(0x8000_03B2));
    t.push([1, 2, 0]);
    t.send("000#0132");
    assert_eq!(t.exchange("080#"), ["1C5#020004"]);
}

/// The offset in the image of the first parameter of the second TPDO, and of its mapping.
const COB_ID: usize = 1 + 2 + 4 + 4 + 9;
const MAPPING: usize = 1 + 2 + 4 + 4 + 4 * 9 + 33;

#[test]
fn stored_tpdo_that_does_not_fit_is_off_and_reported() {
    let mut t = unmapped();
    t.map(1, &[X, Y]);
    t.store();
    let image = t.memory.clone().unwrap();
    let patches: [(usize, &[u8]); 8] = [
        (COB_ID, &[0x80, 0x09, 0, 0]),            // restricted 180h
        (COB_ID, &[0x80, 0x02, 0, 0x20]),         // 29 bits
        (COB_ID, &[0xC5, 0x19, 0, 0]),            // 12 bits
        (MAPPING, &[9]),                          // more than 8
        (MAPPING, &[3]),                          // an empty entry
        (MAPPING + 1, &[0x10, 0x03, 0x10, 0x30]), // not mappable
        (MAPPING + 1, &[0x10, 0x01, 0x11, 0x30]), // no object
        (MAPPING + 9, &[0x08, 0x01, 0x10, 0x30]), // wrong length in an unused entry
    ];
    for (place, bytes) in patches {
        let mut image = image.clone();
        image[place..place + bytes.len()].copy_from_slice(bytes);
        let mut t = booted_with(Some(&image));
        let sent = t.sent_text();
        assert_eq!(sent[0], "732#00", "{place} {bytes:X?}");
        assert_eq!(sent[1], "0B2#0063010400000000", "{place} {bytes:X?}");
        assert_eq!(t.read(0x1801, 1), Ok(0x8000_02B2));
        for sub in 0..=8 {
            assert_eq!(t.read(0x1A01, sub), Ok(0), "{place} {bytes:X?}");
        }
        assert_eq!(t.read(0x1A00, 0), Ok(2), "the others start");
        let saved = t.exchange("632#2310100173617665");
        assert_eq!(saved, ["5B2#6010100100000000", "0B2#0000000000000000"]);
    }
    let mut t = booted_with(Some(&image));
    assert_eq!(t.sent_text(), ["732#00"]);
}
