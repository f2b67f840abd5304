//! The objects of the IMS360 that only J1939 has: limits, factory values, and when they act.

use crate::tester::canopen::write_request;
use crate::tester::j1939::{CLAIM, claimed};
use crate::tester::sweep::every;

/// The limits of each object of this protocol, its factory value, and when it acts.
#[test]
fn objects_have_their_limits_and_factory_values() {
    let mut tester = claimed();
    let rows: [(u16, u8, u8, u32, u32); 18] = [
        (0x2102, 0, 1, 0x80, 254),
        (0x2104, 1, 2, 0, 9),
        (0x2104, 2, 2, 0, 1),
        (0x2104, 3, 2, 0, 5),
        (0x2104, 4, 2, 0, 9),
        (0x2105, 1, 1, 3, 8),
        (0x2105, 2, 1, 3, 8),
        (0x2105, 3, 1, 3, 255),
        (0x2105, 4, 1, 3, 8),
        (0x2106, 1, 1, 1, 2),
        (0x2106, 2, 1, 0, 8),
        (0x2106, 3, 1, 0, 16),
        (0x2106, 4, 1, 0, 128),
        (0x2106, 6, 1, 0, 32),
        (0x2106, 7, 1, 0, 8),
        (0x2106, 8, 2, 2047, 2048),
        (0x3100, 1, 1, 1, 0),
        (0x3100, 1, 1, 1, 3),
    ];
    for (index, sub, size, value, beyond) in rows {
        let [low, high] = index.to_le_bytes();
        let object = format!("{low:02X}{high:02X}{sub:02X}");
        let number = |number: u32| -> String {
            let bytes = number.to_le_bytes();
            bytes.iter().map(|byte| format!("{byte:02X}")).collect()
        };
        let (read, write) = if size == 1 {
            ("4F", "2F")
        } else {
            ("4B", "2B")
        };
        let present = format!("{read}{object}{}", number(value));
        let request = format!("40{object}00000000");
        assert_eq!(tester.parameter(&request), present);
        let refused = tester.parameter(&format!("{write}{object}{}", number(beyond)));
        // A value that is not in the list exceeds the range; a value above a range is too high.
        let listed = matches!(index, 0x2104 | 0x3100);
        let code = if listed { "30000906" } else { "31000906" };
        assert_eq!(refused, format!("80{object}{code}"));
        assert_eq!(tester.parameter(&request), present);
    }
    // The identity number is read-only. The function takes every value.
    assert_eq!(tester.parameter("2306210905000000"), "8006210902000106");
    assert_eq!(tester.parameter("4006210900000000"), "4306210901020300");
    assert_eq!(tester.parameter("2F062105FF000000"), "6006210500000000");
    assert_eq!(tester.parameter("2F022100FD000000"), "6002210000000000");
    // Address and NAME act after store and restart.
    assert_eq!(tester.request_group("80", "00EE00"), [CLAIM]);
    assert_eq!(tester.request_group("FD", "00EE00"), [""; 0]);
    tester.parameter("2310100173617665");
    tester.power_cycle();
    assert_eq!(tester.sent_text(), ["18EEFFFD#0102E3FF00FF0080"]);
}

#[test]
fn every_value_within_its_limits_is_accepted() {
    // Index, sub-indices, size, the lowest value besides 0, and the highest.
    let rows: [(u16, &[u8], u8, u32, u32); 9] = [
        (0x2102, &[0], 1, 1, 253),
        (0x2104, &[1, 2, 3, 4], 2, 10, 65_535),
        (0x2105, &[1, 2, 3, 4], 1, 1, 7),
        (0x2106, &[1], 1, 1, 1),
        (0x2106, &[2, 7], 1, 1, 7),
        (0x2106, &[3], 1, 1, 15),
        (0x2106, &[4], 1, 1, 127),
        (0x2106, &[5], 1, 1, 255),
        (0x2106, &[6], 1, 1, 31),
    ];
    let mut tester = claimed();
    for (index, subs, size, lowest, highest) in rows {
        for &sub in subs {
            let all = 0..1_u32 << (8 * size);
            // Both sides of each limit, and values between them.
            let near = all.clone().take(300).chain(all.clone().rev().take(3));
            for value in near.chain(all.step_by(every(97))) {
                let request = write_request(index, sub, size, value);
                // A rate acts at once: a frame can follow the reply.
                let sent = tester.exchange(&format!("18EF8021#{request}"));
                let valid = value == 0 || (lowest..=highest).contains(&value);
                let command = if valid { "60" } else { "80" };
                let reply = sent[0].strip_prefix("18EF2180#").unwrap();
                assert!(reply.starts_with(command), "{request}: {reply}");
            }
        }
    }
    for value in (0..=2100).chain((2101..=65_535).step_by(every(97))) {
        let reply = tester.parameter(&write_request(0x2106, 8, 2, value));
        assert_eq!(reply.starts_with("60"), value <= 2047, "{value}");
    }
}
