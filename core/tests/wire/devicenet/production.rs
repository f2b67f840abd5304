//! DeviceNet: polls and productions beside each other, the COS delta, and changes of rates.

use super::io::{producing, times};
use crate::tester::devicenet::allocated;

#[test]
fn poll_is_answered_between_its_first_rate_and_its_release() {
    for choice in [0x02, 0x12, 0x22, 0x52, 0x62] {
        let mut tester = allocated(choice);
        tester.ignores("41D#");
        tester.set_rate(2, 0);
        for _ in 0..5 {
            assert_eq!(tester.exchange("41D#"), ["3C3#D204C9FD"], "{choice:02X}");
        }
        for length in 1..=8 {
            tester.ignores(&format!("41D#{}", "00".repeat(length)));
        }
        assert_eq!(tester.exchange("41D#"), ["3C3#D204C9FD"]);
        assert_eq!(tester.wait_text(1000), [], "connection 4 has no rate");
        let release = format!("41E#0A4C0301{:02X}", choice | 1);
        assert_eq!(tester.exchange(&release), ["41B#0ACC"]);
        tester.ignores("41D#");
    }
    for choice in [0x01, 0x10, 0x50] {
        allocated(choice).ignores("41D#");
    }
}

#[test]
fn connection_that_is_configuring_or_released_produces_nothing() {
    for choice in [0x10, 0x20, 0x50, 0x60] {
        let mut tester = allocated(choice);
        tester.set_rate(1, 0);
        tester.force_milli(1, 1);
        assert_eq!(tester.wait_text(5000), [], "{choice:02X}");
        tester.exchange("41C#0A100504096400");
        let release = format!("41E#0A4C0301{choice:02X}");
        assert_eq!(tester.exchange(&release), ["41B#0ACC"]);
        tester.force_milli(2, 2);
        assert_eq!(tester.wait_text(1000), [], "{choice:02X}");
        assert_eq!(tester.explicit("0E030105"), "8E010A");
    }
}

/// A master that repeats its settings does not silence the sensor.
#[test]
fn settings_in_force_written_again_move_no_message() {
    for (choice, inhibit) in [(0x50, 14), (0x60, 14)] {
        let mut tester = producing(choice, 100);
        assert_eq!(
            tester.explicit(&format!("10050411{inhibit:02X}00")),
            "900E00"
        );
        tester.wait(100);
        let start = tester.now.ticks() / 1000;
        let mut sent = Vec::new();
        for _ in 0..20 {
            sent.extend(tester.wait(80));
            for body in [
                "100504096400",
                "100504110E00",
                "10650182 67",
                "106501880 0",
                "102B01011000",
                "102B010201",
            ] {
                let response = tester.request(body);
                assert!(response.starts_with("90"), "{body}: {response}");
            }
        }
        let times: Vec<u64> = sent.iter().map(|(at, _)| at - start).collect();
        assert_eq!(times, (1..=16).map(|n| 100 * n).collect::<Vec<_>>());
    }
}

/// Each word is compared with that of the last message (T21).
#[test]
fn message_follows_a_difference_of_the_delta_or_more() {
    let mut tester = producing(0x50, 0);
    let (mut sent, start) = ([1234, -567], [1234, -567]);
    for (delta, moves) in [
        (
            20,
            [
                [19, 0],
                [20, 0],
                [1, 0],
                [0, 0],
                [10, 19],
                [19, -19],
                [-20, 0],
            ],
        ),
        (
            20,
            [
                [0, 0],
                [0, 19],
                [19, 20],
                [0, 40],
                [0, 20],
                [0, 21],
                [-40, 1],
            ],
        ),
        (
            0,
            [[-40, 1], [-39, 1], [-39, 2], [0, 0], [1, 1], [1, 1], [0, 1]],
        ),
        (1, [[0, 1], [1, 1], [1, 2], [0, 0], [1, 1], [1, 1], [0, 1]]),
        (
            200,
            [
                [199, 0],
                [0, 200],
                [200, 0],
                [1, 1],
                [200, 199],
                [0, -1],
                [0, 200],
            ],
        ),
    ] {
        assert_eq!(tester.explicit(&format!("10650188{delta:02X}")), "90");
        for step in moves {
            let words = [start[0] + step[0], start[1] + step[1]];
            tester.force_milli(words[0], words[1]);
            let [x, y] = words.map(|word| (word as i16 as u16).swap_bytes());
            let differs = (0..2).any(|axis: usize| {
                let distance: i32 = words[axis] - sent[axis];
                distance.abs() >= delta.max(1)
            });
            let expected = format!("343#{x:04X}{y:04X}");
            let expected = if differs { vec![expected] } else { vec![] };
            assert_eq!(tester.sent_text(), expected, "{delta} {step:?}");
            if differs {
                sent = words;
            }
        }
    }
    // A motion in small steps.
    let mut tester = producing(0x50, 0);
    assert_eq!(tester.explicit("1065018832"), "90");
    let mut messages = Vec::new();
    for step in 1..=300 {
        tester.force_milli(1234 - 5 * step, -567);
        messages.extend(tester.sent_text());
    }
    assert_eq!(messages.len(), 30);
    assert_eq!(messages.last().map(String::as_str), Some("343#F6FEC9FD"));
}

#[test]
fn new_rate_of_a_running_production_counts_from_its_set() {
    for choice in [0x50, 0x60] {
        let mut tester = producing(choice, 200);
        tester.wait(330);
        for rate in [500, 50, 10, 2, 65_535, 3] {
            let rate_word = format!("{:04X}", u16::swap_bytes(rate));
            let response = tester.explicit(&format!("10050409{rate_word}"));
            assert_eq!(response, format!("90{rate_word}"));
            let period = u64::from(rate);
            let count = if rate > 500 { 1 } else { 3 };
            let expected: Vec<u64> = (1..=count).map(|number| number * period).collect();
            assert_eq!(times(&tester.wait_text(count * period)), expected, "{rate}");
        }
        tester.set_rate(4, 0);
        assert_eq!(tester.wait_text(100_000), []);
        // Without a rate, a cyclic connection sends nothing, and a COS connection its changes.
        tester.force_milli(1, 2);
        let expected: &[&str] = if choice == 0x50 {
            &["343#01000200"]
        } else {
            &[]
        };
        assert_eq!(tester.sent_text(), expected);
    }
}

#[test]
fn fault_ends_the_production() {
    for choice in [0x50, 0x60] {
        let mut tester = producing(choice, 20);
        assert_eq!(tester.wait_text(100).len(), 5);
        tester.ignores("41F#80620102020304");
        assert_eq!(tester.wait_text(1000), [], "{choice:02X}");
    }
}
