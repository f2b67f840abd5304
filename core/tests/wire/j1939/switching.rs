//! The change between CANopen and J1939: what selects a protocol, what is kept, and which frames each protocol ignores
//! (S17 to S20, S54, S55, S65).

use crate::tester::canopen::write_request;
use crate::tester::ims360::{Ims360Tester, booted};
use crate::tester::j1939::{CLAIM, LOWER, claimed, claimed_with};

/// Every setting of J1939 with a value that it does not have as delivered: index, sub-index, size, value.
const CHANGED: [(u16, u8, u8, u32); 17] = [
    (0x2102, 0, 1, 200),
    (0x2104, 1, 2, 50),
    (0x2104, 2, 2, 20),
    (0x2104, 3, 2, 65_535),
    (0x2104, 4, 2, 10),
    (0x2105, 1, 1, 0),
    (0x2105, 2, 1, 7),
    (0x2105, 3, 1, 1),
    (0x2105, 4, 1, 6),
    (0x2106, 1, 1, 0),
    (0x2106, 2, 1, 7),
    (0x2106, 3, 1, 15),
    (0x2106, 4, 1, 127),
    (0x2106, 5, 1, 255),
    (0x2106, 6, 1, 31),
    (0x2106, 7, 1, 7),
    (0x2106, 8, 2, 0),
];

/// Other settings, of both groups of CANopen and of the application.
const OTHERS: [(u16, u8, u8, u32); 8] = [
    (0x1017, 0, 2, 1234),
    (0x1800, 2, 1, 7),
    (0x1A01, 1, 4, 0x6511_0008),
    (0x2001, 0, 4, 500_000),
    (0x2002, 0, 1, 50),
    (0x3100, 2, 1, 0),
    (0x3111, 0, 2, 3333),
    (0x3220, 0, 4, 0xFFFF_FF85),
];

/// Sends the bytes of a request from 21h to a node. Returns the data of the reply.
fn ask(tester: &mut Ims360Tester, address: u8, request: &str) -> String {
    let sent = tester.exchange(&format!("18EF{address:02X}21#{request}"));
    let head = format!("18EF21{address:02X}#");
    sent[0].strip_prefix(&head).unwrap().to_string()
}

/// The values of [`CHANGED`] and [`OTHERS`] in J1939.
#[track_caller]
fn has_all_values(tester: &mut Ims360Tester, address: u8) {
    for (index, sub, _, value) in CHANGED.into_iter().chain(OTHERS) {
        let [low, high] = index.to_le_bytes();
        let reply = ask(
            tester,
            address,
            &format!("40{low:02X}{high:02X}{sub:02X}00000000"),
        );
        assert_eq!(
            reply[8..],
            format!("{:08X}", value.swap_bytes()),
            "{index:04X}h"
        );
    }
}

#[test]
fn every_setting_is_kept_from_one_protocol_to_the_other() {
    let mut tester = booted();
    for (index, sub, size, value) in CHANGED.into_iter().chain(OTHERS) {
        assert_eq!(
            tester.write(index, sub, size, value),
            Ok(()),
            "{index:04X}h"
        );
    }
    tester.write(0x3100, 1, 1, 1).unwrap();
    tester.store();
    for reset in ["000#8132", "power"] {
        if reset == "power" {
            tester.power_cycle();
        } else {
            tester.send(reset);
        }
        // The NAME has each field.
        assert_eq!(tester.sent_text(), ["18EEFFC8#01020300FFFFFE7F"]);
        tester.wait(250);
        has_all_values(&mut tester, 200);
    }
    assert_eq!(
        ask(&mut tester, 200, "2F00310102000000"),
        "6000310100000000"
    );
    assert_eq!(
        ask(&mut tester, 200, "4000310100000000"),
        "4F00310102000000"
    );
    assert_eq!(
        ask(&mut tester, 200, "2310100173617665"),
        "6010100100000000"
    );
    for _ in 0..2 {
        tester.power_cycle();
        assert_eq!(tester.sent_text(), ["732#00"]);
        for (index, sub, _, value) in CHANGED.into_iter().chain(OTHERS) {
            assert_eq!(tester.read(index, sub), Ok(value), "{index:04X}h");
        }
    }
}

#[test]
fn objects_of_j1939_are_written_and_count_as_settings_in_canopen() {
    let mut tester = booted();
    for (index, sub, size, value) in CHANGED {
        let factory = tester.read(index, sub).unwrap();
        // ST0 bit 2: factory settings (S65).
        for (value, status) in [(value, 1), (factory, 5)] {
            assert_eq!(tester.write(index, sub, size, value), Ok(()));
            assert_eq!(
                tester.read(0x3000, 1),
                Ok(status),
                "{index:04X}h:{sub:02X}h"
            );
        }
    }
}

#[test]
fn protocol_has_two_values() {
    let mut canopen = booted();
    let mut tester = claimed();
    for value in 0..=255 {
        let valid = value == 1 || value == 2;
        let expected = if valid { Ok(()) } else { Err(0x0609_0030) };
        let before = canopen.read(0x3100, 1);
        assert_eq!(canopen.write(0x3100, 1, 1, value), expected);
        assert_eq!(
            canopen.read(0x3100, 1),
            if valid { Ok(value) } else { before }
        );
        let reply = tester.parameter(&write_request(0x3100, 1, 1, value));
        assert_eq!(reply.starts_with("60"), valid, "{value}");
    }
}

#[test]
fn protocol_is_in_force_after_a_save_and_a_restart_only() {
    // All groups, and that of the manufacturer.
    for save in [1, 4] {
        let mut tester = booted();
        tester.write(0x3100, 1, 1, 1).unwrap();
        for reset in ["000#8232", "000#8132"] {
            assert_eq!(tester.exchange(reset), ["732#00"], "not stored");
        }
        tester.write(0x3100, 1, 1, 1).unwrap();
        tester.power_cycle();
        assert_eq!(tester.sent_text(), ["732#00"], "not stored");
        assert_eq!(tester.read(0x3100, 1), Ok(2));
        tester.write(0x3100, 1, 1, 1).unwrap();
        tester.write(0x1010, save, 4, 0x6576_6173).unwrap();
        assert_eq!(
            tester.exchange("000#8232"),
            ["732#00"],
            "reset communication"
        );
        assert_eq!(tester.read(0x3100, 1), Ok(1));
        // 2010h:01, 100 ms after its reply.
        assert_eq!(
            tester.exchange("632#2F10200101000000"),
            ["5B2#6010200100000000"]
        );
        assert_eq!(tester.wait_text(100), [(100, CLAIM.to_string())]);
        tester.wait(250);
        // Back: not stored, so the restart stays in J1939.
        assert_eq!(tester.parameter("2F00310102000000"), "6000310100000000");
        assert!(!tester.exchange("18EF8021#2F10200101000000").is_empty());
        assert_eq!(tester.wait_text(100).last().unwrap().1, CLAIM);
        tester.wait(250);
        let reply = tester.exchange("18EF8021#4000310100000000");
        assert!(reply.contains(&"18EF2180#4F00310101000000".to_string()));
    }
}

#[test]
fn restored_group_selects_the_protocol_until_the_next_start() {
    // The groups with 3100h lead to CANopen.
    for (sub, canopen) in [(1, true), (2, false), (3, false), (4, true), (5, true)] {
        let mut tester = claimed_with(&[(0x3111, 0, 2, 3333), (0x1017, 0, 2, 1234)]);
        let reply = tester.parameter(&format!("231110{sub:02X}6C6F6164"));
        assert_eq!(reply, format!("601110{sub:02X}00000000"));
        // Nothing changes before the restart.
        for (request, reply) in [
            ("4000310100000000", "4F00310101000000"),
            ("4011310000000000", "4B113100050D0000"),
            ("4017100000000000", "4B171000D2040000"),
            ("2F10200101000000", "6010200100000000"),
        ] {
            assert_eq!(tester.parameter(request), reply, "{sub}");
        }
        let sent = tester.wait_text(100);
        if canopen {
            assert_eq!(sent, [(100, "732#00".to_string())], "{sub}");
            assert_eq!(tester.read(0x3100, 1), Ok(2));
            assert_eq!(tester.read(0x2104, 1), Ok(10));
        } else {
            assert_eq!(sent, [(100, CLAIM.to_string())], "{sub}");
            tester.wait(250);
            let heartbeat = tester.parameter("4017100000000000");
            let is_factory = heartbeat == "4B17100000000000";
            assert_eq!(is_factory, sub == 2, "{heartbeat}");
        }
        // It was not saved: the start after that has the stored values.
        if canopen {
            assert_eq!(tester.exchange("000#8132"), [CLAIM], "{sub}");
        } else {
            tester.parameter("2F10200101000000");
            assert_eq!(tester.wait_text(100), [(100, CLAIM.to_string())]);
        }
        tester.wait(250);
        assert_eq!(tester.parameter("4011310000000000"), "4B113100050D0000");
        assert_eq!(tester.parameter("4017100000000000"), "4B171000D2040000");
    }
}

#[test]
fn wrong_signatures_change_nothing() {
    let mut tester = claimed();
    for object in ["1010", "1110"] {
        for sub in 1..=4 {
            let reply = tester.parameter(&format!("23{object}{sub:02X}53415645"));
            assert_eq!(reply, format!("80{object}{sub:02X}20000008"));
            let reply = tester.parameter(&format!("40{object}{sub:02X}00000000"));
            assert_eq!(reply, format!("43{object}{sub:02X}01000000"));
        }
    }
    for value in [0, 2, 255] {
        let reply = tester.parameter(&write_request(0x2010, 1, 1, value));
        assert_eq!(reply, "8010200130000906");
    }
    assert_eq!(tester.wait_text(300), []);
}

#[test]
fn canopen_ignores_frames_with_29_bits() {
    let mut tester = booted();
    for text in [
        "18EAFFFE#00EE00",
        "18EAFF21#00EE00",
        "18EA8021#00EE00",
        "18EA3221#00EE00",
        "18EF8021#4000100000000000",
        "18EF3221#4000100000000000",
        &format!("18EEFF80#{LOWER}"),
        &format!("18EEFF32#{LOWER}"),
        "1CECFF21#20090002FFD8FE00",
        "1CEC8021#10090002FFD8FE00",
        "00000632#4000100000000000",
        "00000000#8132",
        "00000080#",
    ] {
        assert_eq!(tester.exchange(text), [""; 0], "{text}");
        assert_eq!(tester.wait_text(50), [], "{text}");
        assert_eq!(tester.read(0x1018, 1), Ok(0x195));
    }
}

#[test]
fn j1939_ignores_frames_of_canopen_and_sends_none() {
    // Heartbeat, a TPDO after a SYNC and by its timer, an emergency with 29 bits.
    let mut tester = claimed_with(&[
        (0x1017, 0, 2, 100),
        (0x1800, 2, 1, 1),
        (0x1800, 5, 2, 50),
        (0x1014, 0, 4, 0x8000_00B2),
        (0x1014, 0, 4, 0x2001_2345),
    ]);
    for text in [
        "000#0132",
        "000#8132",
        "000#8232",
        "000#8100",
        "080#",
        "632#4000100000000000",
        "632#2F00310102000000",
        "7E5#4C00000000000000",
        "7E5#0401000000000000",
        "7E5#5E00000000000000",
        "7E5#5100000000800000",
        "732#R1",
        "1B2#R8",
        "632#R8",
        "18EA8021#R3",
        "18EF8021#R8",
        "0CF02980#R8",
        "1AEA8021#EBFE00",
        "1BEA8021#EBFE00",
        "19EA8021#EBFE00",
        "1AEF8021#4000100000000000",
        "19EF8021#4000100000000000",
    ] {
        assert_eq!(tester.exchange(text), [""; 0], "{text}");
    }
    // The zero offset of 95 deg is an emergency in CANopen, and a trouble code here.
    tester.wait(100);
    let sent = tester.exchange("18EF8021#231032001C250000");
    assert_eq!(
        sent,
        ["18EF2180#6010320000000000", "18FECA80#04FF70130001FFFF"]
    );
    let sent = tester.wait_text(3000);
    assert!(
        sent.iter().all(|(_, text)| text.starts_with("18FECA80#")),
        "{sent:?}"
    );
    assert_eq!(tester.parameter("4000310100000000"), "4F00310101000000");
}

#[test]
fn bit_rate_is_that_of_2001h_in_both_protocols() {
    use plumbline::node::{Action, BusMode};
    for kbits in [125, 250, 500, 800, 1000] {
        let tester = claimed_with(&[(0x2001, 0, 4, kbits * 1000)]);
        let rates: Vec<u32> = tester
            .actions
            .iter()
            .filter_map(|action| match action {
                Action::Bus(BusMode::Normal, rate) => Some(rate.bits_per_second()),
                _ => None,
            })
            .collect();
        assert_eq!(rates, [kbits * 1000]);
    }
}
