//! The IMS360 at the CAN frame level: its objects, variants and actions, compared with the user manual "IMS360 CANopen".

use crate::tester::canopen::abort;
use crate::tester::ims360::{Ims360Tester, booted, with_memory};

/// Abort codes.
const NO_SUB_INDEX: u32 = 0x0609_0011;
const READ_ONLY: u32 = 0x0601_0002;
const WRITE_ONLY: u32 = 0x0601_0001;
const NOT_PERMITTED: u32 = 0x0609_0030;
const SIGNATURE: u32 = 0x0800_0020;
const DEVICE_STATE: u32 = 0x0800_0022;
const NO_DATA: u32 = 0x0800_0024;
const HARDWARE: u32 = 0x0606_0000;

const SAVE: u32 = 0x6576_6173;
const LOAD: u32 = 0x6461_6F6C;

/// Index, sub-index, size in bytes and factory value of each readable number (chapter 7).
#[rustfmt::skip]
const NUMBERS: &[(u16, u8, u8, u32)] = &[
    (0x1000, 0, 4, 0x0704_019A), (0x1001, 0, 1, 0), (0x1003, 0, 1, 0), (0x1005, 0, 4, 0x80),
    (0x1010, 0, 1, 4), (0x1010, 1, 4, 1), (0x1010, 2, 4, 1), (0x1010, 3, 4, 1), (0x1010, 4, 4, 1),
    (0x1011, 0, 1, 5), (0x1011, 1, 4, 1), (0x1011, 2, 4, 1), (0x1011, 3, 4, 1), (0x1011, 4, 4, 1), (0x1011, 5, 4, 1),
    (0x1014, 0, 4, 0xB2), (0x1017, 0, 2, 0),
    (0x1018, 0, 1, 4), (0x1018, 1, 4, 0x195), (0x1018, 2, 4, 0x1_869F), (0x1018, 3, 4, 0), (0x1018, 4, 4, 0x0403_0201),
    (0x1800, 0, 1, 5), (0x1800, 1, 4, 0x1B2), (0x1800, 2, 1, 254), (0x1800, 3, 2, 0), (0x1800, 5, 2, 0),
    (0x1801, 0, 1, 5), (0x1801, 1, 4, 0x8000_02B2), (0x1801, 2, 1, 254), (0x1801, 3, 2, 0), (0x1801, 5, 2, 0),
    (0x1802, 0, 1, 5), (0x1802, 1, 4, 0x8000_03B2), (0x1802, 2, 1, 254), (0x1802, 3, 2, 0), (0x1802, 5, 2, 0),
    (0x1803, 0, 1, 5), (0x1803, 1, 4, 0x8000_04B2), (0x1803, 2, 1, 254), (0x1803, 3, 2, 0), (0x1803, 5, 2, 0),
    (0x1A00, 0, 1, 2), (0x1A00, 1, 4, 0x6110_0020), (0x1A00, 2, 4, 0x6120_0020), (0x1A00, 3, 4, 0), (0x1A00, 8, 4, 0),
    (0x1A01, 0, 1, 0), (0x1A01, 1, 4, 0), (0x1A01, 8, 4, 0), (0x1A02, 0, 1, 0), (0x1A03, 0, 1, 0), (0x1A03, 8, 4, 0),
    (0x2000, 0, 1, 3), (0x2000, 2, 4, 1), (0x2001, 0, 4, 125_000), (0x2002, 0, 1, 50), (0x2010, 0, 1, 2),
    (0x2102, 0, 1, 128), (0x2104, 0, 1, 4), (0x2104, 1, 2, 10), (0x2104, 2, 2, 0), (0x2104, 3, 2, 0), (0x2104, 4, 2, 0),
    (0x2105, 0, 1, 4), (0x2105, 1, 1, 3), (0x2105, 2, 1, 3), (0x2105, 3, 1, 3), (0x2105, 4, 1, 3),
    (0x2106, 0, 1, 9), (0x2106, 1, 1, 1), (0x2106, 2, 1, 0), (0x2106, 3, 1, 0), (0x2106, 4, 1, 0), (0x2106, 5, 1, 145),
    (0x2106, 6, 1, 0), (0x2106, 7, 1, 0), (0x2106, 8, 2, 2047), (0x2106, 9, 4, 0x0003_0201),
    (0x2020, 0, 1, 1), (0x2020, 1, 4, 0), (0x20FF, 0, 2, 1),
    (0x3000, 0, 1, 5), (0x3000, 1, 1, 5), (0x3000, 2, 1, 0), (0x3000, 3, 1, 0), (0x3000, 4, 1, 0), (0x3000, 5, 1, 0),
    (0x3010, 0, 1, 3), (0x3010, 1, 2, 0), (0x3010, 2, 2, 0), (0x3010, 3, 2, 1000),
    (0x3011, 0, 4, 0), (0x3012, 0, 4, 0), (0x3013, 0, 4, 1000),
    (0x3020, 0, 1, 3), (0x3020, 1, 2, 0), (0x3020, 2, 2, 0), (0x3020, 3, 2, 0),
    (0x3021, 0, 4, 0), (0x3022, 0, 4, 0), (0x3023, 0, 4, 0),
    (0x3100, 0, 1, 2), (0x3100, 1, 1, 2), (0x3100, 2, 1, 1),
    (0x3110, 0, 1, 2), (0x3110, 1, 1, 2), (0x3110, 2, 1, 0), (0x3111, 0, 2, 2000),
    (0x3112, 0, 1, 4), (0x3112, 1, 1, 1), (0x3112, 2, 1, 0xFD), (0x3112, 3, 1, 1), (0x3112, 4, 1, 1),
    (0x3120, 0, 1, 1), (0x3120, 1, 1, 1), (0x3210, 0, 4, 0), (0x3220, 0, 4, 0),
    (0x6000, 0, 2, 10), (0x6110, 0, 4, 0), (0x6111, 0, 1, 0), (0x6120, 0, 4, 0), (0x6121, 0, 1, 0), (0x6511, 0, 1, 25),
];

#[test]
fn objects_have_type_and_factory_value_of_manual() {
    let mut tester = booted();
    for &(index, sub, size, value) in NUMBERS {
        let [low, high] = index.to_le_bytes();
        let reply = tester.sdo(&format!("40{low:02X}{high:02X}{sub:02X}00000000"));
        let command = 0x43 | (4 - size) << 2;
        let [a, b, c, d] = value.to_le_bytes();
        let expected =
            format!("{command:02X}{low:02X}{high:02X}{sub:02X}{a:02X}{b:02X}{c:02X}{d:02X}");
        assert_eq!(reply, expected, "{index:04X}h:{sub:02X}");
    }
}

#[test]
fn no_other_object_exists() {
    let listed = [0x1003, 0x1008, 0x1009, 0x100A, 0x3200];
    let mut tester = booted();
    for index in 0x1000..0x7000 {
        let exists = NUMBERS.iter().any(|row| row.0 == index) || listed.contains(&index);
        let found = tester.read_any(index, 0) != Err(0x0602_0000);
        assert_eq!(found, exists, "{index:04X}h");
    }
    for index in 0x1800..0x1804 {
        assert_eq!(tester.read(index, 4), Err(NO_SUB_INDEX));
        assert_eq!(tester.write(index, 4, 1, 0), Err(NO_SUB_INDEX));
    }
    for (index, sub) in [
        (0x1003, 9),
        (0x1010, 5),
        (0x1011, 6),
        (0x2010, 2),
        (0x1A00, 9),
    ] {
        assert_eq!(tester.read(index, sub), Err(NO_SUB_INDEX), "{index:04X}h");
    }
}

#[test]
fn texts_and_serial_number_are_read() {
    let mut tester = booted();
    assert_eq!(tester.read_text(0x1008), "IMS360");
    assert_eq!(tester.sdo("4009100000000000"), "4B09100030310000");
    assert_eq!(tester.read_text(0x100A), "010000");
    // 04030201h
    assert_eq!(tester.read_text_at(0x2000, 1), "67305985");
    assert_eq!(tester.read_text_at(0x2000, 3), "IMS360");
    assert_eq!(tester.write(0x1000, 0, 4, 0x0703_019A), Err(READ_ONLY));
    assert_eq!(tester.read(0x3200, 0), Err(WRITE_ONLY));
    assert_eq!(tester.read(0x2010, 1), Err(WRITE_ONLY));
}

#[test]
fn refused_values_change_nothing() {
    let mut tester = booted();
    #[rustfmt::skip]
    let refused = [
        (0x1017, 0, 2, 9), (0x1017, 0, 2, 1), (0x1800, 2, 1, 0), (0x1800, 2, 1, 241), (0x1800, 2, 1, 251),
        (0x2001, 0, 4, 100_000), (0x2001, 0, 4, 125), (0x2002, 0, 1, 0), (0x2002, 0, 1, 127), (0x2002, 0, 1, 255),
        (0x3100, 1, 1, 0), (0x3100, 1, 1, 3), (0x3111, 0, 2, 8_001),
    ];
    for (index, sub, size, value) in refused {
        let before = tester.read(index, sub);
        let result = tester.write(index, sub, size, value);
        assert_eq!(result, Err(NOT_PERMITTED), "{index:04X}h = {value}");
        assert_eq!(tester.read(index, sub), before);
    }
    #[rustfmt::skip]
    let outside = [
        (0x3100, 2, 1, 2), (0x3110, 1, 1, 3), (0x3110, 2, 1, 2), (0x3111, 0, 2, 99), (0x3111, 0, 2, 25_001),
        (0x3112, 1, 1, 0), (0x3112, 1, 1, 0x80), (0x3112, 2, 1, 11), (0x3112, 2, 1, 0xF5), (0x3112, 4, 1, 11),
        (0x3120, 1, 1, 2), (0x3120, 1, 1, 0xFF),
    ];
    for (index, sub, size, value) in outside {
        let before = tester.read(index, sub);
        let code = tester.write(index, sub, size, value).unwrap_err();
        assert!(
            (0x0609_0030..=0x0609_0032).contains(&code),
            "{index:04X}h = {value}: {code:08X}"
        );
        assert_eq!(tester.read(index, sub), before);
    }
    for command in [0, 4, 5, 0xFF] {
        assert_eq!(tester.write(0x3200, 0, 1, command), Err(NOT_PERMITTED));
    }
    for command in [0, 2, 0xFF] {
        assert_eq!(tester.write(0x2010, 1, 1, command), Err(NOT_PERMITTED));
    }
}

#[test]
fn filter_type_and_frequency_stay_a_pair() {
    let mut tester = booted();
    assert_eq!(tester.write(0x3110, 1, 1, 1), Ok(()));
    assert_eq!(tester.write(0x3111, 0, 2, 25_000), Ok(()));
    assert_eq!(tester.write(0x3110, 1, 1, 2), Err(NOT_PERMITTED));
    assert_eq!(tester.read(0x3110, 1), Ok(1));
    assert_eq!(tester.write(0x3111, 0, 2, 8_000), Ok(()));
    assert_eq!(tester.write(0x3110, 1, 1, 2), Ok(()));
    assert_eq!(tester.write(0x3111, 0, 2, 8_001), Err(NOT_PERMITTED));
    assert_eq!(tester.read(0x3111, 0), Ok(8_000));
}

#[test]
fn angles_are_sent_by_first_tpdo_with_sync() {
    let mut tester = booted();
    tester.tilt(30.0, -20.0);
    tester.write(0x1800, 2, 1, 1).unwrap();
    tester.send("000#0132");
    // 3000 = 0BB8h, -2000 = FFFFF830h
    assert_eq!(tester.exchange("080#"), ["1B2#B80B000030F8FFFF"]);
}

#[test]
fn one_axis_variant_acts_after_store_and_restart() {
    let mut tester = booted();
    tester.write(0x3120, 1, 1, 0).unwrap();
    assert_eq!(tester.read(0x1000, 0), Ok(0x0704_019A));
    assert_eq!(tester.exchange("000#8132"), ["732#00"]);
    assert_eq!(tester.read(0x3120, 1), Ok(1), "not stored");

    tester.write(0x3120, 1, 1, 0).unwrap();
    tester.store();
    assert_eq!(tester.exchange("000#8232"), ["732#00"]);
    assert_eq!(
        tester.read(0x1000, 0),
        Ok(0x0704_019A),
        "reset communication"
    );
    assert_eq!(tester.read(0x1A00, 0), Ok(2));
    assert_eq!(tester.exchange("000#8132"), ["732#00"]);
    assert_one_axis(&mut tester);
    assert_eq!(tester.exchange("000#8232"), ["732#00"]);
    assert_one_axis(&mut tester);
    tester.power_cycle();
    assert_eq!(tester.sent_text(), ["732#00"]);
    assert_one_axis(&mut tester);

    tester.settle_at([1.0, 0.0, 0.0]);
    assert_eq!(tester.read_i32(0x6110), 9_000);
    assert_eq!(tester.read_i32(0x6120), 0);
    tester.settle_at([-1.0, 0.0, 0.0]);
    assert_eq!(tester.read_i32(0x6110), 27_000);
    for offset in [10_000_i32, -28_000, 36_000 * 3 + 10_000] {
        tester.write(0x3210, 0, 4, offset as u32).unwrap();
        tester.write(0x3220, 0, 4, 5).unwrap();
        let expected = (27_000 + offset).rem_euclid(36_000);
        assert_eq!(tester.read_i32(0x6110), expected);
        assert_eq!(tester.read_i32(0x6120), 0);
    }
    assert_eq!(tester.write(0x3200, 0, 1, 2), Err(NOT_PERMITTED));
    assert_eq!(tester.write(0x3200, 0, 1, 3), Err(NOT_PERMITTED));
    assert_eq!(tester.write(0x3200, 0, 1, 1), Ok(()));
    assert_eq!(tester.read_i32(0x6110), 0);
    assert_eq!(tester.read_i32(0x3210), -27_000);
}

fn assert_one_axis(tester: &mut Ims360Tester) {
    assert_eq!(tester.read(0x1000, 0), Ok(0x0703_019A));
    assert_eq!(tester.read(0x3000, 1).unwrap() & 1, 0);
    assert_eq!(tester.read(0x1A00, 0), Ok(1));
    assert_eq!(tester.read(0x1A00, 1), Ok(0x6110_0020));
    assert_eq!(tester.read(0x1A00, 2), Ok(0));
}

#[test]
fn mapping_of_master_does_not_follow_the_variant() {
    let mut tester = booted();
    tester.map(0, &[0x6120_0020, 0x6110_0020]);
    tester.write(0x3120, 1, 1, 0).unwrap();
    tester.store();
    tester.power_cycle();
    tester.sent();
    assert_eq!(tester.read(0x1000, 0), Ok(0x0703_019A));
    assert_eq!(tester.read(0x1A00, 0), Ok(2));
    assert_eq!(tester.read(0x1A00, 1), Ok(0x6120_0020));
}

#[test]
fn default_mapping_returns_with_two_axes() {
    let mut tester = booted();
    tester.write(0x3120, 1, 1, 0).unwrap();
    tester.store();
    tester.power_cycle();
    tester.sent();
    tester.store();
    tester.write(0x3120, 1, 1, 1).unwrap();
    tester.store();
    tester.power_cycle();
    tester.sent();
    assert_eq!(tester.read(0x1000, 0), Ok(0x0704_019A));
    assert_eq!(tester.read(0x1A00, 0), Ok(2));
    assert_eq!(tester.read(0x1A00, 2), Ok(0x6120_0020));
    assert_eq!(tester.read(0x3000, 1), Ok(5));
}

#[test]
fn store_groups_store_their_objects_only() {
    for (group, communication, manufacturer) in [
        (1, true, true),
        (2, true, false),
        (3, false, false),
        (4, false, true),
    ] {
        let mut tester = booted();
        tester.write(0x1017, 0, 2, 500).unwrap();
        tester.write(0x3111, 0, 2, 700).unwrap();
        tester.write(0x2002, 0, 1, 7).unwrap();
        assert_eq!(tester.write(0x1010, group, 4, LOAD), Err(SIGNATURE));
        assert_eq!(tester.write(0x1010, group, 4, SAVE), Ok(()));
        tester.power_cycle();
        tester.node_id = if manufacturer { 7 } else { 50 };
        let boot_up = format!("{:03X}#00", 0x700 + u16::from(tester.node_id));
        assert_eq!(tester.sent_text(), [boot_up], "{group}");
        let or = |stored: bool, value, factory| Ok(if stored { value } else { factory });
        assert_eq!(tester.read(0x1017, 0), or(communication, 500, 0), "{group}");
        assert_eq!(
            tester.read(0x3111, 0),
            or(manufacturer, 700, 2000),
            "{group}"
        );
    }
}

/// A sensor that has stored other values: heartbeat 500 ms, 700 mHz, node-ID 7, 250 kbit/s.
fn changed() -> Ims360Tester {
    let mut tester = booted();
    tester.write(0x1017, 0, 2, 500).unwrap();
    tester.write(0x3111, 0, 2, 700).unwrap();
    tester.write(0x2002, 0, 1, 7).unwrap();
    tester.write(0x2001, 0, 4, 250_000).unwrap();
    tester.store();
    tester.power_cycle();
    tester.node_id = 7;
    assert_eq!(tester.sent_text(), ["707#00"]);
    tester
}

/// Heartbeat time, filter frequency and node-ID after a start.
fn values_after_start(tester: &mut Ims360Tester) -> [u32; 3] {
    let sent = tester.sent_text();
    let id = u16::from_str_radix(&sent[0][..3], 16).unwrap() - 0x700;
    tester.node_id = id as u8;
    [0x1017, 0x3111, 0x2002].map(|index| tester.read(index, 0).unwrap())
}

#[test]
fn restore_acts_at_next_start_and_lasts_only_if_saved() {
    #[rustfmt::skip]
    let groups = [
        (1, [0, 2000, 7]), (2, [0, 700, 7]), (3, [500, 700, 7]), (4, [500, 2000, 50]), (5, [0, 2000, 50]),
    ];
    for (group, restored) in groups {
        let mut tester = changed();
        assert_eq!(tester.write(0x1011, group, 4, SAVE), Err(SIGNATURE));
        assert_eq!(tester.write(0x1011, group, 4, LOAD), Ok(()));
        assert_eq!(tester.read(0x1017, 0), Ok(500), "not before a reset");
        tester.power_cycle();
        assert_eq!(values_after_start(&mut tester), restored, "{group}");
        tester.power_cycle();
        assert_eq!(
            values_after_start(&mut tester),
            [500, 700, 7],
            "{group}: used up"
        );

        tester.write(0x1011, group, 4, LOAD).unwrap();
        let reset = format!("000#81{:02X}", tester.node_id);
        tester.send(&reset);
        assert_eq!(values_after_start(&mut tester), restored, "{group}: NMT");
        tester.store();
        tester.power_cycle();
        assert_eq!(values_after_start(&mut tester), restored, "{group}: saved");
    }
}

#[test]
fn reset_communication_restores_communication_profile_only() {
    let mut tester = changed();
    tester.write(0x1011, 5, 4, LOAD).unwrap();
    tester.send("000#8207");
    assert_eq!(values_after_start(&mut tester), [0, 700, 7]);
    tester.send("000#8207");
    assert_eq!(values_after_start(&mut tester), [500, 700, 7], "used up");
    tester.send("000#8107");
    assert_eq!(values_after_start(&mut tester), [500, 2000, 50], "the rest");
}

#[test]
fn failed_store_and_restore_are_reported() {
    let mut tester = booted();
    tester.memory_works = Some(false);
    for (index, signature) in [(0x1010, SAVE), (0x1011, LOAD)] {
        let request = crate::tester::canopen::write_request(index, 1, 4, signature);
        let mut sent = tester.exchange(&format!("632#{request}"));
        sent.sort();
        let [low, high] = index.to_le_bytes();
        let object = format!("{low:02X}{high:02X}01");
        assert_eq!(
            sent[sent.len() - 1],
            format!("5B2#{}", abort(&object, HARDWARE))
        );
    }
    assert_eq!(tester.read(0x1001, 0), Ok(0x81));
    tester.memory_works = Some(true);
    let request = crate::tester::canopen::write_request(0x1010, 1, 4, SAVE);
    let sent = tester.exchange(&format!("632#{request}"));
    assert!(
        sent.contains(&"0B2#0000000000000000".to_string()),
        "{sent:?}"
    );
    assert_eq!(tester.read(0x1001, 0), Ok(0));
}

#[test]
fn controller_reset_starts_with_stored_values() {
    let mut tester = booted();
    tester.write(0x2002, 0, 1, 9).unwrap();
    tester.write(0x2001, 0, 4, 500_000).unwrap();
    assert_eq!(tester.sdo("2F10200101000000"), "6010200100000000");
    let sent = tester.wait_text(200);
    assert_eq!(sent, [(100, "732#00".to_string())]);
    assert_eq!(tester.read(0x2002, 0), Ok(50));
    assert_eq!(tester.read(0x2001, 0), Ok(125_000));
    // An NMT reset takes them along.
    tester.write(0x2002, 0, 1, 9).unwrap();
    assert_eq!(tester.exchange("000#8132"), ["709#00"]);
}

#[test]
fn auto_zero_sets_offsets() {
    let mut tester = booted();
    tester.tilt(10.0, -20.0);
    for (command, offsets, angles) in [(1, [-1_000, 0], [0, -2_000]), (2, [-1_000, 2_000], [0, 0])]
    {
        tester.write(0x3200, 0, 1, command).unwrap();
        assert_eq!(
            [0x3210, 0x3220].map(|index| tester.read_i32(index)),
            offsets
        );
        assert_eq!([0x6110, 0x6120].map(|index| tester.read_i32(index)), angles);
    }
    tester.write(0x3210, 0, 4, 123).unwrap();
    assert_eq!(tester.read_i32(0x6110), 1_123);
    tester.write(0x3200, 0, 1, 3).unwrap();
    assert_eq!(
        [0x3210, 0x3220].map(|index| tester.read_i32(index)),
        [-1_000, 2_000]
    );
    // Not stored by itself.
    tester.power_cycle();
    tester.sent();
    assert_eq!(tester.read_i32(0x3210), 0);
    tester.tilt(10.0, 0.0);
    // The sum is beyond 90 deg (5010h), but it does not overflow.
    let sent = tester.exchange("632#23103200FFFFFF7F");
    assert_eq!(sent, ["5B2#6010320000000000", "0B2#1050810000000000"]);
    assert_eq!(tester.read_i32(0x6110), i32::MAX);
    tester.wait_without_samples(200);
    tester.sent();
    assert_eq!(tester.write(0x3200, 0, 1, 1), Err(DEVICE_STATE));
}

#[test]
fn history_has_codes_and_is_stored() {
    let mut tester = booted();
    assert_eq!(tester.read(0x1003, 1), Err(NO_DATA));
    tester.wait_without_samples(200);
    assert_eq!(tester.read(0x1003, 0), Ok(2));
    assert_eq!(tester.read(0x1003, 1), Ok(0xFF02));
    assert_eq!(tester.read(0x1003, 2), Ok(0xFF01));
    assert_eq!(tester.read(0x1003, 3), Err(NO_DATA));
    tester.sample();
    tester.sent();
    assert_eq!(tester.read(0x3000, 1), Ok(5), "the history is no setting");
    tester.write(0x1010, 2, 4, SAVE).unwrap();
    tester.power_cycle();
    tester.sent();
    assert_eq!(tester.read(0x1003, 0), Ok(2));
    assert_eq!(tester.read(0x1003, 1), Ok(0xFF02));
    assert_eq!(tester.read(0x3000, 1), Ok(5));
    tester.write(0x1003, 0, 1, 0).unwrap();
    assert_eq!(tester.read(0x1003, 1), Err(NO_DATA));
    tester.power_cycle();
    tester.sent();
    assert_eq!(tester.read(0x1003, 0), Ok(2), "the stored history");
    tester.write(0x1011, 4, 4, LOAD).unwrap();
    tester.power_cycle();
    tester.sent();
    assert_eq!(tester.read(0x1003, 0), Ok(2));
    tester.write(0x1011, 2, 4, LOAD).unwrap();
    tester.power_cycle();
    tester.sent();
    assert_eq!(tester.read(0x1003, 0), Ok(0));
}

#[test]
fn damaged_image_is_parameter_memory_fault() {
    let mut tester = with_memory(Some(&[0; 3]));
    assert_eq!(tester.sent_text(), ["732#00", "0B2#00FF810000000000"]);
    assert_eq!(tester.read(0x1001, 0), Ok(0x81));
}
