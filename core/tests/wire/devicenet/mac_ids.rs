//! DeviceNet: every MAC ID and every bit rate, and what a restart keeps.

use crate::tester::devicenet::{LevelTester, allocated};
use crate::tester::tiltix::tiltix080;
use plumbline::can::{BitRate, standard};
use plumbline::node::{Action, BusMode, ProductNode};

/// An identifier of group 2.
fn group_2(mac: u16, message: u16) -> u16 {
    0x400 | mac << 3 | message
}

/// Sends data on message `message` of this MAC ID. Returns the frames sent at once.
fn send(tester: &mut LevelTester, mac: u16, message: u16, data: &str) -> Vec<String> {
    tester.exchange(&format!("{:03X}#{data}", group_2(mac, message)))
}

/// Checks the identifiers of all messages of a node with this MAC ID, which is on-line.
fn has_identifiers(tester: &mut LevelTester, mac: u16) {
    let response = group_2(mac, 3);
    let allocated = send(tester, mac, 6, "0A4B0301130A");
    assert_eq!(allocated, [format!("{response:03X}#0ACB00")]);
    let [poll, change] = [0x3C0 | mac, 0x340 | mac];
    for (instance, produced, consumed) in [
        (1, response, group_2(mac, 4)),
        (2, poll, group_2(mac, 5)),
        (4, change, group_2(mac, 2)),
    ] {
        for (attribute, id) in [(4, produced), (5, consumed)] {
            let request = format!("0A0E05{instance:02X}{attribute:02X}");
            let id = id.swap_bytes();
            let expected = format!("{response:03X}#0A8E{id:04X}");
            assert_eq!(send(tester, mac, 4, &request), [expected]);
        }
    }
    send(tester, mac, 4, "0A100502090000");
    assert_eq!(send(tester, mac, 5, ""), [format!("{poll:03X}#D204C9FD")]);
    let sent = send(tester, mac, 4, "0A100504090000");
    assert_eq!(sent[1..], [format!("{change:03X}#D204C9FD")]);
    tester.exchange(&format!("{:03X}#", group_2(mac, 2)));
    assert_eq!(tester.wait_text(1000), [], "acknowledged");
    // If the address changes and the filters do not, a driver restarts the sensor.
    assert_eq!(tester.node.halves().0.address(), Some(mac.into()));
    let check = send(tester, mac, 7, "00620102020304");
    let answer = format!("{:03X}#80620101020304", group_2(mac, 7));
    assert_eq!(check, [answer]);
}

#[test]
fn every_mac_id_is_adopted_at_once_and_kept() {
    for mac in (0..64).filter(|mac| *mac != 3) {
        let mut tester = allocated(0);
        let request = format!("{:03X}#00620101020304", group_2(mac, 7));
        let sent = tester.exchange(&format!("41C#0A10030101{mac:02X}"));
        assert_eq!(sent, ["41B#0A90", request.as_str()]);
        assert_eq!(tester.wait_text(2000), [(1000, request.clone())]);
        has_identifiers(&mut tester, mac);
        let read = send(&mut tester, mac, 4, "0A0E030101");
        assert_eq!(read, [format!("{:03X}#0A8E{mac:02X}", group_2(mac, 3))]);
        // The MAC ID is not a configuration of the application (bit 2).
        let status = send(&mut tester, mac, 4, "0A0E010105");
        assert_eq!(status, [format!("{:03X}#0A8E0100", group_2(mac, 3))]);
        for id in 0..0x800 {
            let own = id >> 3 == 0x80 | mac && matches!(id & 7, 2 | 4..=7);
            assert_eq!(tester.accepts(standard(id)), own, "{id:03X}");
        }
        tester.power_cycle();
        assert_eq!(
            tester.wait_text(2000),
            [(0, request.clone()), (1000, request)]
        );
    }
}

#[test]
fn taken_mac_id_silences_the_node_in_either_wait() {
    for (wait, message) in [(0, 0x00), (500, 0x80), (1000, 0x80), (1999, 0x00)] {
        let mut tester = allocated(0x52);
        tester.exchange("41C#0A1003010109");
        tester.wait(wait);
        tester.ignores(&format!("44F#{message:02X}620102020304"));
        assert_eq!(tester.wait_text(5000), [], "{wait}");
        for text in [
            "44E#0A4B0301010A",
            "41E#0A4B0301010A",
            "44F#00620102020304",
            "41C#0A0E030101",
        ] {
            tester.ignores(text);
        }
        tester.power_cycle();
        assert_eq!(tester.sent_text(), ["44F#00620101020304"], "it is stored");
    }
}

/// The bit rates of the TILTIX (5.1.1).
#[test]
fn every_bit_rate_acts_after_a_power_cycle_or_a_reset() {
    for (code, rate) in [(0, BitRate::K125), (1, BitRate::K250), (2, BitRate::K500)] {
        for resets in [false, true] {
            let mut tester = tiltix080(1);
            tester.actions.clear();
            assert_eq!(tester.request(&format!("10030102{code:02X}")), "90");
            let read = tester.request("0E030102");
            assert_eq!(read, format!("8E{code:02X}"));
            tester.wait(1000);
            // It is stored, and the bus is not changed before.
            let expected: &[Action] = if code == 0 { &[] } else { &[Action::Save] };
            assert_eq!(tester.actions, expected);
            if resets {
                assert_eq!(tester.request("05010100"), "85");
            }
            tester.power_cycle();
            assert!(tester.actions.contains(&Action::Bus(BusMode::Normal, rate)));
        }
    }
    let mut tester = tiltix080(1);
    for value in 0..=255_u8 {
        for (attribute, is_valid) in [(2, value <= 2), (3, value <= 1), (1, value <= 63)] {
            if attribute == 1 && is_valid {
                continue;
            }
            let response = tester.request(&format!("100301{attribute:02X}{value:02X}"));
            let expected = if is_valid { "90" } else { "9409FF" };
            assert_eq!(response, expected, "{attribute} = {value}");
        }
    }
}

#[test]
fn every_other_type_of_a_reset_is_refused() {
    let mut tester = allocated(2);
    tester.set_rate(2, 0);
    for kind in 2..=255 {
        assert_eq!(tester.explicit(&format!("050101{kind:02X}")), "9420FF");
    }
    for data in ["0000", "0100", "0200"] {
        assert_eq!(tester.explicit(&format!("050101{data}")), "9415FF");
    }
    assert_eq!(tester.exchange("41D#"), ["3C3#D204C9FD"]);
}

#[test]
fn reset_ends_all_connections_with_its_answer() {
    for body in ["0A05010100", "4A050101", "0A05010101"] {
        let mut tester = allocated(0x62);
        tester.set_rate(2, 100);
        tester.exchange("41C#0A100504093200");
        assert_eq!(tester.exchange("41E#0B4B0301010B"), ["41B#0B940C01"]);
        let header = &body[..2];
        assert_eq!(
            tester.exchange(&format!("41C#{body}")),
            [format!("41B#{header}85")]
        );
        assert_eq!(tester.wait_text(3000), [], "until the node restarts");
    }
}

/// T22: connections, the bus-off counter, and the settings of the acknowledge handler are not stored.
#[test]
fn power_cycle_keeps_parameters_and_releases_connections() {
    let mut tester = allocated(0x12);
    tester.set_rate(2, 0);
    tester.exchange("41C#0A100504090000");
    for request in ["1003010301", "102B01016400", "102B010205"] {
        assert!(tester.explicit(request).starts_with("90"));
    }
    tester.wait(1000);
    tester.power_cycle();
    assert_eq!(tester.wait_text(2001).len(), 2);
    tester.ignores("41D#");
    assert_eq!(tester.exchange("41E#0A4C030101"), ["41B#0A940B02"]);
    tester.allocate(0x11);
    for (request, response) in [
        ("0E030103", "8E01"),
        ("0E030104", "8E00"),
        ("0E030105", "8E110A"),
        ("0E2B0101", "8E1000"),
        ("0E2B0102", "8E01"),
        ("0E050409", "8E0000"),
        ("1003010300", "90"),
    ] {
        assert_eq!(tester.explicit(request), response, "{request}");
    }
    tester.wait(1000);
    tester.power_cycle();
    tester.wait(2001);
    tester.allocate(1);
    assert_eq!(tester.explicit("0E030103"), "8E00");
}

#[test]
fn frames_are_answered_during_a_save() {
    let mut tester = allocated(2);
    tester.set_rate(2, 0);
    tester.memory_works = None;
    assert_eq!(tester.explicit("106501712C01"), "90");
    for _ in 0..100 {
        tester.wait(10);
        assert_eq!(tester.exchange("41D#"), ["3C3#D204C9FD"]);
        assert_eq!(tester.explicit("0E650171"), "8E2C01");
        assert_eq!(tester.explicit("1065017501"), "90");
        assert_eq!(
            tester.exchange("41F#00620102020304"),
            ["41F#80620101020304"]
        );
        assert_eq!(tester.exchange("41E#0B4B0301010B"), ["41B#0B940C01"]);
    }
}
