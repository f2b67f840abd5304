//! DeviceNet: polls, COS and cyclic messages, and their watchdogs.

use crate::tester::devicenet::{LevelTester, allocated, online};

/// A node whose connection 4 is established with this choice and expected packet rate, and without the watchdog of the explicit
/// connection. Its first message is sent.
pub fn producing(choice: u8, rate: u16) -> LevelTester {
    let mut tester = allocated(choice);
    tester.explicit("100501090000");
    establish(&mut tester, rate);
    tester
}

/// Establishes connection 4.
pub fn establish(tester: &mut LevelTester, rate: u16) {
    let rate = format!("{:04X}", rate.swap_bytes());
    let sent = tester.exchange(&format!("41C#0A10050409{rate}"));
    assert_eq!(sent.len(), 2, "{sent:?}");
    assert_eq!(sent[0], format!("41B#0A90{rate}"));
    assert_eq!(sent[1], "343#D204C9FD");
}

/// The times of messages on 343h.
pub fn times(sent: &[(u64, String)]) -> Vec<u64> {
    assert!(
        sent.iter().all(|(_, text)| text.starts_with("343#")),
        "{sent:?}"
    );
    sent.iter().map(|(at, _)| *at).collect()
}

#[test]
fn poll_is_answered_only_when_established_and_without_data() {
    let mut tester = allocated(2);
    tester.ignores("41D#");
    tester.set_rate(2, 0);
    assert_eq!(tester.exchange("41D#"), ["3C3#D204C9FD"]);
    for text in [
        "41D#00",
        "41D#R",
        "0000041D#",
        "415#",
        "5FD#",
        "41A#",
        "418#",
        "419#",
    ] {
        tester.ignores(text);
    }
    tester.force_milli(-1, 1);
    assert_eq!(tester.exchange("41D#"), ["3C3#FFFF0100"]);
}

#[test]
fn thousand_polls_in_a_burst_are_answered() {
    let mut tester = allocated(2);
    tester.set_rate(2, 100);
    for _ in 0..1000 {
        assert_eq!(tester.exchange("41D#"), ["3C3#D204C9FD"]);
    }
}

#[test]
fn poll_connection_waits_10_s_for_its_first_poll_then_4_times_the_rate() {
    for (rate, first) in [(100, 10_000), (2500, 10_000), (3000, 12_000)] {
        let mut tester = allocated(2);
        tester.explicit("100501090000");
        tester.set_rate(2, rate);
        tester.wait(first - 1);
        assert_eq!(tester.explicit("0E050201"), "8E03", "{rate}");
        tester.wait(1);
        assert_eq!(tester.explicit("0E050201"), "8E04");
        assert_eq!(tester.explicit("0E030105"), "8E010A");
        tester.ignores("41D#");
        assert_eq!(tester.explicit("100502096400"), "940CFF");
        // It can be allocated again.
        tester.allocate(2);
        tester.set_rate(2, rate);
        assert_eq!(tester.exchange("41D#"), ["3C3#D204C9FD"]);
        tester.wait(4 * u64::from(rate) - 1);
        assert_eq!(tester.exchange("41D#"), ["3C3#D204C9FD"]);
        // A command with data is not consumed.
        tester.wait(10);
        tester.ignores("41D#00");
        tester.wait(4 * u64::from(rate) - 10);
        tester.ignores("41D#");
        assert_eq!(tester.explicit("0E050201"), "8E04");
    }
}

#[test]
fn explicit_connection_is_deleted_10_s_after_its_last_request() {
    let mut tester = allocated(2);
    tester.set_rate(2, 0);
    tester.wait(9_999);
    assert_eq!(tester.explicit("0E650163"), "9414FF");
    tester.wait(9_999);
    assert_eq!(tester.explicit("0E030105"), "8E030A");
    tester.wait(10_000);
    tester.ignores("41C#0A0E030105");
    assert_eq!(tester.exchange("41D#"), ["3C3#D204C9FD"]);
    assert_eq!(
        tester.exchange("41E#0B4B0301010B"),
        ["41B#0B940C01"],
        "the owner stays"
    );
    tester.allocate(1);
    assert_eq!(tester.explicit("0E030105"), "8E030A");
}

#[test]
fn deferred_explicit_connection_lives_until_io_times_out() {
    let mut tester = allocated(2);
    assert_eq!(tester.explicit("1005010C02"), "9409FF");
    assert_eq!(tester.explicit("1005010C03"), "90");
    assert_eq!(tester.explicit("0E05010C"), "8E03");
    assert_eq!(tester.explicit("1005020C01"), "940EFF");
    tester.set_rate(2, 5000);
    tester.wait(10_000);
    assert_eq!(
        tester.exchange("41E#0A4B0301010A"),
        ["41B#0A940B02"],
        "still allocated"
    );
    assert_eq!(tester.explicit("0E050101"), "8E03");
    tester.wait(9_999);
    assert!(tester.owner());
    tester.wait(1);
    assert!(!tester.owner());
    tester.ignores("41C#0A0E050101");
}

#[test]
fn cos_message_follows_each_change_by_delta_or_more() {
    let mut tester = producing(0x50, 0);
    tester.force_milli(1235, -567);
    assert_eq!(tester.sent_text(), ["343#D304C9FD"]);
    assert_eq!(tester.explicit("106501880A"), "90");
    // Nine steps away from the message in several steps.
    for (x, y) in [(1244, -567), (1226, -558), (1235, -576)] {
        tester.force_milli(x, y);
        assert_eq!(tester.sent_text(), [""; 0], "{x} {y}");
    }
    tester.force_milli(1245, -567);
    assert_eq!(tester.sent_text(), ["343#DD04C9FD"]);
    tester.force_milli(1245, -577);
    assert_eq!(tester.sent_text(), ["343#DD04BFFD"]);
    tester.force_milli(1245, -577);
    assert_eq!(tester.wait_text(20_000), []);
}

#[test]
fn word_outside_the_assembly_causes_no_message() {
    let mut tester = allocated(0);
    assert_eq!(tester.explicit("1065018265"), "90");
    tester.allocate(0x50);
    tester.receive(crate::tester::canopen::frame("41C#0A100504090000"));
    assert_eq!(tester.sent_text(), ["41B#0A900000", "343#D204"]);
    tester.force_milli(1234, 0);
    assert_eq!(tester.sent_text(), [""; 0]);
    tester.force_milli(1233, 0);
    assert_eq!(tester.sent_text(), ["343#D104"]);
}

#[test]
fn change_restarts_the_rate_of_cos() {
    let mut tester = producing(0x50, 100);
    assert_eq!(times(&tester.wait_text(250)), [100, 200]);
    tester.force_milli(1, -567);
    assert_eq!(tester.sent_text(), ["343#0100C9FD"]);
    assert_eq!(times(&tester.wait_text(250)), [100, 200]);
}

#[test]
fn cyclic_message_is_sent_at_the_rate_only() {
    let mut tester = producing(0x60, 50);
    tester.force_milli(1, 2);
    assert_eq!(tester.sent_text(), [""; 0]);
    let sent = tester.wait_text(20_000);
    let expected: Vec<u64> = (1..=400).map(|cycle| 50 * cycle).collect();
    assert_eq!(times(&sent), expected);
    assert_eq!(sent[0].1, "343#01000200");
    // Acknowledge is suppressed: it never times out.
    assert_eq!(tester.explicit("0E050401"), "8E03");
}

#[test]
fn rate_1_of_connection_4_becomes_2() {
    for choice in [0x50, 0x60] {
        let mut tester = allocated(choice);
        let sent = tester.exchange("41C#0A100504090100");
        assert_eq!(sent, ["41B#0A900200", "343#D204C9FD"]);
        assert_eq!(tester.wait_text(6).len(), 3);
    }
    let mut tester = allocated(2);
    tester.set_rate(2, 1);
}

#[test]
fn acknowledge_handler_has_its_settings() {
    let mut tester = allocated(0x10);
    for (request, response) in [
        ("0E2B0101", "8E1000"),
        ("0E2B0102", "8E01"),
        ("0E2B0103", "8E0400"),
        ("102B01010000", "9409FF"),
        ("102B010110", "9413FF"),
        ("102B0101FFFF", "90FFFF"),
        ("0E2B0101", "8EFFFF"),
        ("102B010200", "90"),
        ("0E2B0102", "8E00"),
        ("102B01030400", "940EFF"),
        ("052B01", "9408FF"),
    ] {
        assert_eq!(tester.explicit(request), response, "{request}");
    }
    tester.exchange("41E#0A4C030111");
    tester.allocate(1);
    assert_eq!(tester.explicit("0E2B0101"), "8E1000", "default again");
}

#[test]
fn connection_4_without_acknowledges_times_out() {
    let mut tester = producing(0x10, 100);
    tester.wait(9_999);
    assert_eq!(tester.explicit("0E050401"), "8E03");
    tester.wait(1);
    assert_eq!(tester.explicit("0E050401"), "8E04");
    assert_eq!(tester.wait_text(1000), []);
    tester.force_milli(1, 1);
    assert_eq!(tester.wait_text(1000), []);
    // Acknowledged in time.
    tester.allocate(0x20);
    tester.force_milli(1234, -567);
    establish(&mut tester, 100);
    for _ in 0..200 {
        tester.ignores("41A#");
        assert_eq!(times(&tester.wait_text(100)), [100]);
    }
    tester.wait(299);
    assert_eq!(tester.explicit("0E050401"), "8E03");
    tester.wait(1);
    assert_eq!(tester.explicit("0E050401"), "8E04");
}

#[test]
fn inhibit_time_delays_changes() {
    let mut tester = allocated(0x50);
    assert_eq!(tester.explicit("100504113200"), "903200");
    establish(&mut tester, 0);
    tester.force_milli(1, 1);
    assert_eq!(tester.sent_text(), [""; 0]);
    tester.force_milli(2, 2);
    let sent = tester.wait_text(49);
    assert_eq!(sent, []);
    assert_eq!(tester.wait_text(1), [(1, "343#02000200".into())]);
    // The old value is back before the end of the inhibit time.
    tester.force_milli(3, 3);
    tester.force_milli(2, 2);
    assert_eq!(tester.wait_text(1000), []);
    // After it, a change is sent at once.
    tester.force_milli(4, 4);
    assert_eq!(tester.sent_text(), ["343#04000400"]);
}

#[test]
fn inhibit_time_above_the_rate_is_refused_when_it_is_applied() {
    let mut tester = allocated(0x50);
    assert_eq!(tester.explicit("100504116500"), "906500");
    assert_eq!(tester.explicit("100504096400"), "940911");
    assert_eq!(tester.explicit("0E050401"), "8E01");
    assert_eq!(tester.explicit("100504116400"), "906400");
    establish(&mut tester, 100);
    assert_eq!(tester.explicit("100504116500"), "940911");
    assert_eq!(tester.explicit("0E050411"), "8E6400");
}

#[test]
fn poll_and_cos_work_beside_each_other() {
    let mut tester = producing(0x52, 0);
    tester.ignores("41D#");
    tester.set_rate(2, 0);
    assert_eq!(tester.exchange("41D#"), ["3C3#D204C9FD"]);
    tester.force_milli(5, 6);
    assert_eq!(tester.sent_text(), ["343#05000600"]);
    assert_eq!(tester.exchange("41D#"), ["3C3#05000600"]);
}

#[test]
fn io_continues_after_release_of_explicit() {
    let mut tester = producing(0x52, 100);
    tester.set_rate(2, 0);
    assert_eq!(tester.exchange("41E#0A4C030101"), ["41B#0ACC"]);
    tester.ignores("41C#0A0E030101");
    assert_eq!(times(&tester.wait_text(100)), [100]);
    assert_eq!(tester.exchange("41D#"), ["3C3#D204C9FD"]);
    assert_eq!(tester.exchange("41E#0A4C030152"), ["41B#0ACC"]);
    assert!(!tester.owner());
    assert_eq!(tester.wait_text(1000), []);
}

#[test]
fn connections_time_out_and_are_allocated_again() {
    let mut tester = producing(0x12, 100);
    tester.set_rate(2, 100);
    tester.set_rate(1, 2500);
    tester.wait(10_000);
    assert!(!tester.owner());
    assert_eq!(tester.wait_text(1000), []);
    let mut again = online();
    again.allocate(3);
    tester.allocate(3);
    for tester in [&mut tester, &mut again] {
        tester.set_rate(2, 0);
        assert_eq!(tester.exchange("41D#"), ["3C3#D204C9FD"]);
    }
}
