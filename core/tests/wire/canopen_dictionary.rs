//! The object dictionary of the JN2101: types, factory values, access and permitted values (manual 7.6, 7.7 and 14).

use crate::tester::canopen::*;

const READ_ONLY: u32 = 0x0601_0002;
const NO_OBJECT: u32 = 0x0602_0000;
const TOO_LONG: u32 = 0x0607_0012;
const NO_SUB: u32 = 0x0609_0011;
const VALUE: u32 = 0x0609_0030;
const TOO_HIGH: u32 = 0x0609_0031;
const TOO_LOW: u32 = 0x0609_0032;
const SIGNATURE: u32 = 0x0800_0020;

#[test]
fn dictionary_matches_manual() {
    let mut t = booted();
    let sizes = |t: &mut Jn2101Tester, index: u16, sub: u8| {
        let [low, high] = index.to_le_bytes();
        let reply = t.sdo(&format!("40{low:02X}{high:02X}{sub:02X}00000000"));
        4 - (u8::from_str_radix(&reply[..2], 16).unwrap() >> 2 & 3)
    };
    // Index, sub-index, size in bytes, value: manual 7.6, 7.7 and 14.
    let list: &[(u16, u8, u8, u32)] = &[
        (0x1000, 0, 4, 0x0004_019A),
        (0x1001, 0, 1, 0),
        (0x1003, 0, 1, 0),
        (0x1003, 1, 4, 0),
        (0x1003, 50, 4, 0),
        (0x1005, 0, 4, 0x80),
        (0x100C, 0, 2, 0),
        (0x100D, 0, 1, 0),
        (0x1010, 0, 1, 1),
        (0x1010, 1, 4, 0),
        (0x1011, 0, 1, 1),
        (0x1011, 1, 4, 0),
        (0x1014, 0, 4, 0x8A),
        (0x1015, 0, 2, 0),
        (0x1017, 0, 2, 0),
        (0x1018, 0, 1, 4),
        (0x1018, 1, 4, 0x6D66_6900),
        (0x1018, 2, 4, 0x01),
        (0x1018, 3, 4, 0xAA),
        (0x1018, 4, 4, crate::tester::SERIAL),
        (0x1029, 0, 1, 1),
        (0x1029, 1, 1, 0),
        (0x1200, 0, 1, 2),
        (0x1200, 1, 4, 0x60A),
        (0x1200, 2, 4, 0x58A),
        (0x1800, 0, 1, 5),
        (0x1800, 1, 4, 0x18A),
        (0x1800, 2, 1, 1),
        (0x1800, 3, 2, 0),
        (0x1800, 5, 2, 10),
        (0x1801, 0, 1, 5),
        (0x1801, 1, 4, 0x28A),
        (0x1801, 2, 1, 1),
        (0x1801, 3, 2, 0),
        (0x1801, 5, 2, 10),
        (0x1A00, 0, 1, 2),
        (0x1A00, 1, 4, 0x6010_0010),
        (0x1A00, 2, 4, 0x6020_0010),
        (0x1A01, 0, 1, 2),
        (0x1A01, 1, 4, 0x6110_0020),
        (0x1A01, 2, 4, 0x6120_0020),
        (0x1F80, 0, 4, 0),
        (0x2000, 0, 1, 10),
        (0x2001, 0, 2, 125),
        (0x2002, 0, 1, 0),
        (0x2040, 0, 1, 1),
        (0x2041, 0, 1, 1),
        (0x2042, 0, 1, 2),
        (0x2043, 0, 1, 2),
        (0x2044, 0, 1, 0),
        (0x2045, 0, 1, 1),
        (0x2046, 0, 1, 2),
        (0x207F, 0, 1, 0),
        (0x4004, 0, 1, 2),
        (0x4004, 1, 1, 0),
        (0x4004, 2, 1, 0),
        (0x4080, 0, 4, 250),
        (0x6000, 0, 2, 10),
        (0x6010, 0, 2, 0),
        (0x6011, 0, 1, 0),
        (0x6020, 0, 2, 0),
        (0x6021, 0, 1, 0),
        (0x6110, 0, 4, 0),
        (0x6111, 0, 1, 0),
        (0x6120, 0, 4, 0),
        (0x6121, 0, 1, 0),
    ];
    for &(index, sub, size, value) in list {
        assert_eq!(t.read(index, sub), Ok(value), "{index:04X}:{sub:02X}");
        assert_eq!(sizes(&mut t, index, sub), size, "{index:04X}:{sub:02X}");
    }
    assert_eq!(sizes(&mut t, 0x4081, 0), 2);
    assert_eq!(t.read_text(0x1008), "JN2101");
    assert_eq!(t.read_text(0x100A), "2.2.0");
    assert_eq!(t.read_text(0x1009).len(), 5);
    assert_eq!(t.read_text(0x3000), "D0UfZEgRKHAI5Ag=");
}

#[test]
fn missing_object_or_sub_index_is_refused() {
    let mut t = booted();
    for (request, object, code) in [
        ("4004100000000000", "041000", NO_OBJECT),
        ("40FFFFFF00000000", "FFFFFF", NO_OBJECT),
        ("4000000000000000", "000000", NO_OBJECT),
        ("40FF0F0000000000", "FF0F00", NO_OBJECT),
        ("4000100100000000", "001001", NO_SUB),
        ("4003103300000000", "031033", NO_SUB),
        ("4000180400000000", "001804", NO_SUB),
        ("4018100500000000", "181005", NO_SUB),
        ("4000200100000000", "002001", NO_SUB),
        ("2F04100000000000", "041000", NO_OBJECT),
        ("2F00200101000000", "002001", NO_SUB),
    ] {
        assert_eq!(t.sdo(request), abort(object, code), "{request}");
    }
}

#[test]
fn write_to_read_only_object_is_refused() {
    let mut t = booted();
    for (index, sub, size) in [
        (0x1000, 0, 4),
        (0x1001, 0, 1),
        (0x1003, 1, 4),
        (0x1010, 0, 1),
        (0x1011, 0, 1),
        (0x1014, 0, 4),
        (0x1018, 1, 4),
        (0x1200, 1, 4),
        (0x1800, 0, 1),
        (0x1A00, 0, 1),
        (0x1A00, 1, 4),
        (0x4004, 2, 1),
        (0x4080, 0, 4),
        (0x4081, 0, 2),
        (0x6010, 0, 2),
        (0x6011, 0, 1),
        (0x6110, 0, 4),
    ] {
        let before = t.read(index, sub);
        assert_eq!(
            t.write(index, sub, size, 0x55),
            Err(READ_ONLY),
            "{index:04X}:{sub}"
        );
        assert_eq!(t.read(index, sub), before);
    }
    // Also with a segmented transfer, and for the product designation.
    assert_eq!(t.sdo("2108100006000000"), abort("081000", READ_ONLY));
}

#[test]
fn values_out_of_range_are_refused_and_change_nothing() {
    let mut t = booted();
    for (index, sub, size, value, code) in [
        (0x2000, 0, 1, 0, TOO_LOW),
        (0x2000, 0, 1, 128, TOO_HIGH),
        (0x2001, 0, 2, 100, VALUE),
        (0x2001, 0, 2, 0, VALUE),
        (0x2002, 0, 1, 2, TOO_HIGH),
        (0x2040, 0, 1, 3, TOO_HIGH),
        (0x2041, 0, 1, 2, TOO_HIGH),
        (0x2042, 0, 1, 3, TOO_HIGH),
        (0x2043, 0, 1, 5, TOO_HIGH),
        (0x2044, 0, 1, 4, TOO_HIGH),
        (0x2045, 0, 1, 2, TOO_HIGH),
        (0x2046, 0, 1, 3, TOO_HIGH),
        (0x207F, 0, 1, 0, VALUE),
        (0x207F, 0, 1, 2, VALUE),
        (0x4004, 1, 1, 2, TOO_HIGH),
        (0x6000, 0, 2, 0, VALUE),
        (0x6000, 0, 2, 11, VALUE),
        (0x1029, 1, 1, 3, TOO_HIGH),
        (0x1F80, 0, 4, 1, VALUE),
        (0x1F80, 0, 4, 0x0001_0002, VALUE),
        (0x1800, 2, 1, 241, VALUE),
        (0x1801, 2, 1, 251, VALUE),
        (0x1003, 0, 1, 1, VALUE),
        (0x1003, 0, 4, 1, VALUE),
        (0x1003, 0, 4, 0x100, VALUE),
        (0x1010, 1, 4, 0x6461_6F6C, SIGNATURE),
        (0x1010, 1, 4, 0, SIGNATURE),
        (0x1011, 1, 4, 0x6576_6173, SIGNATURE),
        // SYNC: producer, 29 bits, and identifiers of other services.
        (0x1005, 0, 4, 0x4000_0080, VALUE),
        (0x1005, 0, 4, 0x2000_0080, VALUE),
        (0x1005, 0, 4, 0x0000_0880, VALUE),
        (0x1005, 0, 4, 0x000, VALUE),
        (0x1005, 0, 4, 0x07F, VALUE),
        (0x1005, 0, 4, 0x101, VALUE),
        (0x1005, 0, 4, 0x180, VALUE),
        (0x1005, 0, 4, 0x58A, VALUE),
        (0x1005, 0, 4, 0x60A, VALUE),
        (0x1005, 0, 4, 0x6E0, VALUE),
        (0x1005, 0, 4, 0x70A, VALUE),
        (0x1005, 0, 4, 0x7FF, VALUE),
    ] {
        let before = t.read(index, sub);
        assert_eq!(
            t.write(index, sub, size, value),
            Err(code),
            "{index:04X}:{sub} = {value}"
        );
        assert_eq!(t.read(index, sub), before, "{index:04X}:{sub}");
    }
    assert_eq!(t.memory, None);
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
