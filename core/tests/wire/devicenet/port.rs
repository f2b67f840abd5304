//! DeviceNet: the allocation and the release of connections, with every choice, every master and every service of the port.

use crate::tester::devicenet::{LevelTester, online, run};

/// Choices that can be allocated at once; 0: nothing.
const HELD: [u8; 11] = [
    0, 0x01, 0x03, 0x11, 0x21, 0x51, 0x61, 0x13, 0x23, 0x53, 0x63,
];

/// A node with these connections of the master 0Ah.
fn holding(choice: u8) -> LevelTester {
    let mut tester = online();
    if choice != 0 {
        tester.allocate(choice);
    }
    tester
}

/// The refusal of an allocation by the owner (T19): general and additional code.
fn allocation_refusal(choice: u8, held: u8) -> Option<&'static str> {
    let produced = choice & 0x30;
    if choice == 0 || choice & 0x40 != 0 && produced == 0 {
        return Some("0902");
    }
    if choice & 0x8C != 0 {
        return Some("0202");
    }
    if produced == 0x30 || (choice | held) & 1 == 0 {
        return Some("0902");
    }
    // COS and cyclic use one connection.
    let is_taken = choice & held & 3 != 0 || produced != 0 && held & 0x30 != 0;
    is_taken.then_some("0B02")
}

/// The refusal of a release by the owner. The suppression of the acknowledge has no meaning in it.
fn release_refusal(choice: u8, held: u8) -> Option<&'static str> {
    match choice & !0x40 {
        0 => Some("0902"),
        choice if choice & 0x8C != 0 => Some("0202"),
        choice if choice & !held != 0 => Some("0B02"),
        _ => None,
    }
}

fn expected(refusal: Option<&str>, success: &str) -> String {
    refusal.map_or(success.to_owned(), |codes| format!("41B#0A94{codes}"))
}

/// The allocation information (attribute 5 of the DeviceNet object).
fn information(tester: &mut LevelTester) -> String {
    tester.explicit("0E030105")
}

#[test]
fn each_choice_of_an_allocation_is_accepted_or_refused() {
    for held in HELD {
        let mut tester = holding(held);
        for choice in 0..=255 {
            // The owner may also use its explicit connection.
            let ports = if held == 0 {
                &["41E"][..]
            } else {
                &["41E", "41C"]
            };
            let refusal = allocation_refusal(choice, held);
            for port in ports {
                let sent = tester.exchange(&format!("{port}#0A4B0301{choice:02X}0A"));
                let expected = expected(refusal, "41B#0ACB00");
                assert_eq!(sent, [expected], "{held:02X} {choice:02X}");
                let now = if refusal.is_some() {
                    held
                } else {
                    held | choice
                };
                if now == 0 {
                    assert!(!tester.owner());
                    continue;
                }
                assert_eq!(information(&mut tester), format!("8E{now:02X}0A"));
                if refusal.is_none() {
                    let release = format!("{port}#0A4C0301{choice:02X}");
                    assert_eq!(tester.exchange(&release), ["41B#0ACC"]);
                }
            }
        }
    }
}

#[test]
fn each_choice_of_a_release_is_accepted_or_refused() {
    for held in HELD {
        let mut tester = holding(held);
        for choice in 0..=255 {
            let refusal = release_refusal(choice, held);
            let sent = tester.exchange(&format!("41E#0A4C0301{choice:02X}"));
            assert_eq!(
                sent,
                [expected(refusal, "41B#0ACC")],
                "{held:02X} {choice:02X}"
            );
            let mut left = held;
            if refusal.is_none() {
                left &= !choice | 0x40;
                if choice & 0x30 != 0 {
                    left &= !0x40;
                }
            }
            // Without the explicit connection, and with the others not yet established, nothing is left.
            assert_eq!(tester.owner(), left & 1 != 0, "{held:02X} {choice:02X}");
            if left & 1 != 0 {
                assert_eq!(information(&mut tester), format!("8E{left:02X}0A"));
            }
            if left != held {
                if left & 1 != 0 {
                    let rest = format!("41E#0A4C0301{left:02X}");
                    assert_eq!(tester.exchange(&rest), ["41B#0ACC"]);
                }
                tester.allocate(held);
            }
        }
    }
}

#[test]
fn other_master_is_refused_before_every_other_check() {
    let mut tester = holding(0x03);
    for choice in 0..=255 {
        for request in [
            format!("4B0301{choice:02X}0B"),
            format!("4C0301{choice:02X}"),
        ] {
            let sent = tester.exchange(&format!("41E#0B{request}"));
            assert_eq!(sent, ["41B#0B940C01"], "{request}");
        }
    }
    // An allocation belongs to the master in its last byte.
    for (request, response) in [
        ("41E#0A4B0301100B", "41B#0A940C01"),
        ("41E#0B4B0301010A", "41B#0B940B02"),
        ("41E#0B4B0301100A", "41B#0BCB00"),
    ] {
        assert_eq!(tester.exchange(request), [response], "{request}");
    }
    assert_eq!(information(&mut tester), "8E130A");
    for text in ["41C#0B4B0301100B", "41C#0B4C030103"] {
        tester.ignores(text);
    }
}

#[test]
fn every_mac_id_can_be_the_master_and_the_others_are_ignored() {
    let mut tester = online();
    for master in 0..64 {
        let xid = master | 0x40;
        for (request, response) in [
            (
                format!("41E#{master:02X}4B030101{master:02X}"),
                format!("41B#{master:02X}CB00"),
            ),
            (
                format!("41C#{master:02X}0E030105"),
                format!("41B#{master:02X}8E01{master:02X}"),
            ),
            (
                format!("41C#{xid:02X}0E030101"),
                format!("41B#{xid:02X}8E03"),
            ),
        ] {
            assert_eq!(tester.exchange(&request), [response], "{request}");
        }
        for other in (0..64).filter(|it| *it != master) {
            for header in [other, other | 0x40, other | 0x80, other | 0xC0] {
                tester.ignores(&format!("41C#{header:02X}106501712C01"));
            }
        }
        let release = tester.exchange(&format!("41E#{xid:02X}4C030101"));
        assert_eq!(release, [format!("41B#{xid:02X}CC")]);
    }
    tester.allocate(1);
    assert_eq!(tester.explicit("0E650171"), "8E0A00");
}

#[test]
fn port_has_no_other_service_and_no_other_object() {
    let mut tester = online();
    for service in (0..128).filter(|it| !matches!(it, 0x4B | 0x4C)) {
        let sent = tester.exchange(&format!("41E#0A{service:02X}030101"));
        assert_eq!(sent, ["41B#0A940203"], "{service:02X}");
    }
    for service in 128..=255 {
        tester.ignores(&format!("41E#0A{service:02X}0301010A"));
    }
    for number in 0..=255 {
        for (class, instance) in [(number, 1), (3, number)] {
            if (class, instance) == (3, 1) {
                continue;
            }
            for (service, data) in [("4B", "010A"), ("4C", "01")] {
                let request = format!("41E#0A{service}{class:02X}{instance:02X}{data}");
                assert_eq!(tester.exchange(&request), ["41B#0A940203"], "{request}");
            }
        }
    }
    assert!(!tester.owner());
}

#[test]
fn connections_are_released_and_allocated_one_by_one() {
    let mut tester = holding(0x53);
    run(
        &mut tester,
        &[
            ("41C#0A100501096400", "41B#0A906400"),
            ("41C#0A100502090000", "41B#0A900000"),
            // The poll connection alone.
            ("41E#0A4C030102", "41B#0ACC"),
            ("41C#0A0E030105", "41B#0A8E510A"),
            ("41D#", ""),
            ("41C#0A0E050201", "41B#0A9416FF"),
            ("41E#0A4B0301020A", "41B#0ACB00"),
            ("41C#0A0E030105", "41B#0A8E530A"),
            ("41C#0A0E050201", "41B#0A8E01"),
            ("41D#", ""),
            ("41C#0A100502090000", "41B#0A900000"),
            ("41D#", "3C3#D204C9FD"),
            // The explicit connection alone: it gets its default rate again.
            ("41E#0A4C030101", "41B#0ACC"),
            ("41C#0A0E030105", ""),
            ("41D#", "3C3#D204C9FD"),
            ("41E#0B4B0301010B", "41B#0B940C01"),
            ("41E#0A4B0301200A", "41B#0A940902"),
            ("41E#0A4C030101", "41B#0A940B02"),
            ("41E#0A4B0301010A", "41B#0ACB00"),
            ("41C#0A0E030105", "41B#0A8E530A"),
            ("41C#0A0E050109", "41B#0A8EC409"),
            // COS with and without the bit of the suppression.
            ("41E#0A4C030110", "41B#0ACC"),
            ("41C#0A0E030105", "41B#0A8E030A"),
            ("41E#0A4B0301500A", "41B#0ACB00"),
            ("41E#0A4C030153", "41B#0ACC"),
            ("41E#0A4C030101", "41B#0A940B02"),
            ("41E#0B4B0301030B", "41B#0BCB00"),
        ],
    );
}
