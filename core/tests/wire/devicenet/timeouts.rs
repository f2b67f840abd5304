//! DeviceNet: the watchdogs of the connections, their actions, and masters that vanish.

use crate::tester::devicenet::{LevelTester, allocated, run};

/// Checks that the owner loses the node after exactly this time.
#[track_caller]
fn is_free_after(tester: &mut LevelTester, ms: u64) {
    tester.wait(ms - 1);
    assert!(tester.owner(), "1 ms before");
    tester.wait(1);
    assert!(!tester.owner(), "{ms} ms");
}

#[test]
fn explicit_connection_ends_4_rates_after_its_last_request() {
    for rate in [1, 100, 250, 700, 10_000] {
        let wait = 4 * u64::from(rate);
        let mut tester = allocated(0);
        tester.set_rate(1, 60_000);
        tester.set_rate(1, rate);
        is_free_after(&mut tester, wait);
        tester.ignores("41C#0A0E030101");
        tester.allocate(1);
        tester.set_rate(1, rate);
        for request in ["0E030101", "0E030163", "55", "1065017100"] {
            tester.wait(wait - 1);
            tester.explicit(request);
        }
        is_free_after(&mut tester, wait);
    }
}

#[test]
fn explicit_connection_with_rate_0_does_not_end() {
    let mut tester = allocated(0);
    tester.set_rate(1, 0);
    tester.wait(100_000);
    assert_eq!(tester.explicit("0E030105"), "8E010A");
}

#[test]
fn only_requests_of_the_owner_keep_the_explicit_connection() {
    let mut tester = allocated(2);
    tester.set_rate(1, 100);
    for text in [
        "41E#0B4B0301010B",
        "41E#0A4B0301010A",
        "41E#0A0E030101",
        "41C#0B0E030101",
        "41C#0A8E030101",
        "41C#8AC000",
        "41D#",
        "41A#",
        "41F#00620102020304",
    ] {
        tester.wait(40);
        tester.exchange(text);
    }
    is_free_after(&mut tester, 40);
}

#[test]
fn deleted_explicit_connection_leaves_established_io_to_its_owner() {
    let mut tester = allocated(2);
    tester.set_rate(2, 0);
    tester.set_rate(1, 100);
    tester.wait(400);
    run(
        &mut tester,
        &[
            ("41C#0A0E030101", ""),
            ("41D#", "3C3#D204C9FD"),
            ("41E#0B4B0301010B", "41B#0B940C01"),
            ("41E#0A4C030101", "41B#0A940B02"),
            ("41E#0A4B0301100A", "41B#0A940902"),
            ("41E#0A4B0301010A", "41B#0ACB00"),
            ("41C#0A0E030105", "41B#0A8E030A"),
            ("41D#", "3C3#D204C9FD"),
            ("41C#0A100501096400", "41B#0A906400"),
        ],
    );
    tester.wait(400);
    run(
        &mut tester,
        &[
            ("41E#0A4C030102", "41B#0ACC"),
            ("41E#0B4B0301030B", "41B#0BCB00"),
        ],
    );
}

/// Watchdog action 3.
#[test]
fn explicit_connection_is_deferred_while_io_is_established() {
    for (choice, instance) in [(0x02, 2), (0x10, 4), (0x50, 4), (0x60, 4)] {
        let mut tester = allocated(choice);
        let rate = format!("41C#0A1005{instance:02X}090000");
        assert_eq!(tester.exchange(&rate)[0], "41B#0A900000");
        assert_eq!(tester.explicit("1005010C03"), "90");
        tester.set_rate(1, 100);
        tester.wait(1000);
        run(
            &mut tester,
            &[
                ("41E#0A4B0301010A", "41B#0A940B02"),
                ("41E#0B4B0301010B", "41B#0B940C01"),
                // The next request establishes it again.
                ("41C#0A0E050101", "41B#0A8E03"),
                ("41C#0A0E05010C", "41B#0A8E03"),
            ],
        );
        let information = format!("8E{:02X}0A", choice | 1);
        assert_eq!(tester.explicit("0E030105"), information);
        tester.wait(1000);
        run(
            &mut tester,
            &[
                ("41E#0A4C030101", "41B#0ACC"),
                ("41C#0A0E050101", ""),
                ("41E#0B4B0301010B", "41B#0B940C01"),
            ],
        );
    }
    // Without established I/O it is deleted.
    for choice in [0, 0x02, 0x10] {
        let mut tester = allocated(choice);
        assert_eq!(tester.explicit("1005010C03"), "90");
        tester.set_rate(1, 100);
        is_free_after(&mut tester, 400);
    }
}

#[test]
fn release_of_the_last_established_connection_releases_a_deferred_one() {
    for (choice, instances, release) in [
        (0x02, &[2][..], 0x02),
        (0x50, &[4], 0x10),
        (0x52, &[2, 4], 0x52),
    ] {
        let mut tester = allocated(choice);
        for instance in instances {
            tester.exchange(&format!("41C#0A1005{instance:02X}090000"));
        }
        assert_eq!(tester.explicit("1005010C03"), "90");
        tester.set_rate(1, 50);
        tester.wait(200);
        let sent = tester.exchange(&format!("41E#0A4C0301{release:02X}"));
        assert_eq!(sent, ["41B#0ACC"]);
        let sent = tester.exchange("41E#0B4B0301030B");
        assert_eq!(sent, ["41B#0BCB00"], "{choice:02X}");
    }
}

#[test]
fn poll_connection_times_out_is_allocated_again_and_released() {
    for rate in [1, 2, 10, 100] {
        let mut tester = allocated(0x12);
        tester.set_rate(1, 0);
        tester.exchange("41C#0A100504090000");
        tester.set_rate(2, rate);
        // The first poll may be late.
        tester.wait(9_999);
        for _ in 0..4 {
            assert_eq!(tester.exchange("41D#"), ["3C3#D204C9FD"], "{rate}");
            tester.wait(4 * u64::from(rate) - 1);
        }
        assert_eq!(tester.explicit("0E050201"), "8E03");
        tester.wait(1);
        run(
            &mut tester,
            &[
                ("41D#", ""),
                ("41C#0A0E050201", "41B#0A8E04"),
                ("41C#0A0E030105", "41B#0A8E110A"),
                ("41C#0A0E050401", "41B#0A8E03"),
                ("41C#0A100502090000", "41B#0A940CFF"),
                ("41E#0A4B0301020A", "41B#0ACB00"),
                ("41C#0A0E030105", "41B#0A8E130A"),
                ("41C#0A0E050201", "41B#0A8E01"),
                ("41D#", ""),
            ],
        );
        tester.set_rate(2, rate);
        assert_eq!(tester.exchange("41D#"), ["3C3#D204C9FD"]);
        tester.set_rate(2, 0);
        tester.wait(20_000);
        assert_eq!(tester.exchange("41D#"), ["3C3#D204C9FD"]);
        tester.set_rate(2, rate);
        tester.wait(4 * u64::from(rate));
        run(
            &mut tester,
            &[
                ("41D#", ""),
                ("41E#0A4C030102", "41B#0ACC"),
                ("41C#0A0E050201", "41B#0A9416FF"),
            ],
        );
    }
}

#[test]
fn timed_out_poll_connection_is_released_with_the_explicit_one() {
    let mut tester = allocated(2);
    tester.set_rate(2, 20);
    tester.exchange("41D#");
    tester.wait(80);
    assert_eq!(tester.exchange("41E#0A4C030103"), ["41B#0ACC"]);
    assert!(!tester.owner());
}

/// The consumed size of both connections is 0 (T26).
#[test]
fn io_message_with_data_does_not_restart_the_watchdog() {
    for (choice, instance, id) in [(0x02, 2, "41D"), (0x10, 4, "41A"), (0x20, 4, "41A")] {
        let mut tester = allocated(choice);
        tester.exchange(&format!("41C#0A1005{instance:02X}096400"));
        tester.exchange(&format!("{id}#"));
        for length in 1..=8 {
            tester.wait(40);
            let sent = tester.exchange(&format!("{id}#{}", "00".repeat(length)));
            assert!(!sent.iter().any(|text| text.starts_with("3C3")), "{sent:?}");
        }
        tester.wait(79);
        assert_eq!(tester.explicit(&format!("0E05{instance:02X}01")), "8E03");
        tester.wait(1);
        assert_eq!(tester.explicit(&format!("0E05{instance:02X}01")), "8E04");
    }
}

#[test]
fn time_out_of_the_explicit_connection_ends_fragmented_messages() {
    let mut tester = allocated(0);
    tester.set_rate(1, 100);
    assert_eq!(tester.exchange("41C#0A0E010107"), ["41B#8A008E17494E434C"]);
    assert_eq!(tester.wait_text(3000), [], "the fragment is not repeated");
    tester.allocate(1);
    tester.ignores("41C#8AC000");
    tester.set_rate(1, 100);
    assert_eq!(tester.exchange("41C#8A00106501"), ["41B#8AC000"]);
    tester.wait(400);
    tester.allocate(1);
    tester.ignores("41C#8A81712C01");
    assert_eq!(tester.explicit("0E650171"), "8E0A00");
}

/// What a master does before it vanishes, and the time in ms after which the node is free; None: never.
#[test]
fn node_of_a_vanished_master_is_free_when_all_watchdogs_have_ended() {
    let rate = |instance: u8, rate: u16| {
        let rate = format!("{:04X}", rate.swap_bytes());
        format!("41C#0A1005{instance:02X}09{rate}")
    };
    let poll = || "41D#".to_owned();
    for (choice, frames, free) in [
        (0x13, vec![], Some(10_000)),
        (0x01, vec!["41C#8A00106501".to_owned()], Some(10_000)),
        // The poll connection has ended before.
        (0x03, vec![rate(2, 1000), poll(), poll()], Some(10_000)),
        // It outlives the explicit one.
        (0x03, vec![rate(2, 600), rate(1, 100), poll()], Some(2_400)),
        (0x03, vec![rate(1, 500), rate(2, 100)], Some(10_000)),
        (0x03, vec![rate(1, 500), rate(2, 3000)], Some(12_000)),
        (0x11, vec![rate(1, 100), rate(4, 200)], Some(10_000)),
        (0x03, vec![rate(1, 0)], None),
        // A connection that only produces has no watchdog.
        (0x51, vec![rate(4, 200), rate(1, 100)], None),
        (0x61, vec![rate(4, 200), rate(1, 100)], None),
    ] {
        let mut tester = allocated(choice);
        for frame in &frames {
            assert!(!tester.exchange(frame).is_empty(), "{frame}");
        }
        let Some(free) = free else {
            tester.wait(100_000);
            assert!(tester.owner(), "{choice:02X} {frames:?}");
            continue;
        };
        is_free_after(&mut tester, free);
        run(
            &mut tester,
            &[
                ("41E#0B4B0301010B", "41B#0BCB00"),
                ("41C#0B0E030105", "41B#0B8E010B"),
                ("41D#", ""),
            ],
        );
        assert_eq!(tester.wait_text(1000), []);
    }
}

/// The rate in force is no change: a master that only repeats it has lost its scan.
#[test]
fn rate_in_force_written_again_does_not_restart_the_watchdog_of_io() {
    let mut tester = allocated(2);
    tester.set_rate(1, 0);
    tester.set_rate(2, 100);
    assert_eq!(tester.exchange("41D#"), ["3C3#D204C9FD"]);
    for _ in 0..3 {
        tester.wait(100);
        tester.set_rate(2, 100);
    }
    tester.wait(99);
    assert_eq!(tester.explicit("0E050201"), "8E03");
    tester.wait(1);
    assert_eq!(tester.explicit("0E050201"), "8E04");
}
