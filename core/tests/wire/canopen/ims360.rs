//! The IMS360 at the CAN frame level: its objects, variants and actions, compared with the user manual "IMS360 CANopen".

use crate::tester::canopen::abort;
use crate::tester::ims360::{Ims360Tester, booted, with_memory};

/// The abort codes that the manual requires.
const NOT_PERMITTED: u32 = 0x0609_0030;
const SIGNATURE: u32 = 0x0800_0020;
const DEVICE_STATE: u32 = 0x0800_0022;
const NO_DATA: u32 = 0x0800_0024;
const HARDWARE: u32 = 0x0606_0000;

const SAVE: u32 = 0x6576_6173;
const LOAD: u32 = 0x6461_6F6C;

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
}

/// What happens before a request, with its name.
type Case = (&'static str, fn(&mut Ims360Tester));

#[test]
fn auto_zero_without_a_valid_angle_is_refused() {
    let cases: [Case; 3] = [
        ("stale", |tester| drop(tester.wait_without_samples(200))),
        ("a sample clips", |tester| tester.clip(1)),
        ("dead", |tester| tester.hold([0; 3], 120)),
    ];
    for (name, happens) in cases {
        let mut tester = booted();
        tester.tilt(10.0, 0.0);
        happens(&mut tester);
        tester.sent();
        for command in 1..=3 {
            let refused = tester.write(0x3200, 0, 1, command);
            assert_eq!(refused, Err(DEVICE_STATE), "{name}");
        }
        assert_eq!(tester.read_i32(0x3210), 0, "{name}");
        tester.tilt(10.0, 0.0);
        tester.sent();
        assert_eq!(tester.write(0x3200, 0, 1, 1), Ok(()), "{name}");
        assert_eq!(tester.read_i32(0x3210), -1_000, "{name}");
    }
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
