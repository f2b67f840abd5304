//! The trouble codes of the IMS360: which condition has which code, and when it ends (S36, S37, S69, S70).

use crate::tester::Tester;
use crate::tester::ims360::Ims360Tester;
use crate::tester::j1939::{NO_CODES, claimed, claimed_with};
use plumbline::model::ims360::Ims360;
use plumbline::node::Boot;

/// The data of DM1 on request, if it fits into a frame; otherwise the announcement.
fn codes(tester: &mut Ims360Tester) -> String {
    let sent = tester.request_group("80", "CAFE00");
    sent[0].clone()
}

/// DM1 with one code: its bytes and the number of occurrences.
fn one(code: &str, count: u8) -> String {
    format!("18FECA80#04FF{code}{count:02X}FFFF")
}

/// Writes 3210h or 3220h in 0.01 deg, and waits until the code can change again.
fn offset(tester: &mut Ims360Tester, object: u8, value: i32) {
    let data = value.cast_unsigned().swap_bytes();
    tester.exchange(&format!("18EF8021#23{object:02X}3200{data:08X}"));
    tester.wait(1060);
}

#[test]
fn angle_beyond_90_deg_has_the_code_of_its_axis_and_side() {
    for (object, above, below) in [(0x10, "701300", "701301"), (0x20, "711300", "711301")] {
        let mut tester = claimed();
        let mut counts = [0; 2];
        for value in [
            9001,
            9000,
            -9001,
            -9000,
            20_000,
            -20_000,
            0,
            i32::MAX,
            i32::MIN,
            9000,
        ] {
            offset(&mut tester, object, value);
            let expected = if value > 9000 {
                counts[0] += 1;
                one(above, counts[0])
            } else if value < -9000 {
                counts[1] += 1;
                one(below, counts[1])
            } else {
                NO_CODES.to_string()
            };
            assert_eq!(codes(&mut tester), expected, "{value}");
        }
    }
}

#[test]
fn angle_of_one_axis_has_no_range() {
    let mut tester = claimed_with(&[(0x3120, 1, 1, 0)]);
    for value in [9001, -9001, 18_000] {
        offset(&mut tester, 0x10, value);
        offset(&mut tester, 0x20, value);
        assert_eq!(codes(&mut tester), NO_CODES);
    }
}

#[test]
fn clipping_has_the_codes_of_both_angles_for_a_second_at_least() {
    // As short as possible and for some time; with two axes and with one.
    for (objects, ms) in [(&[][..], 100), (&[], 3000), (&[(0x3120, 1, 1, 0)], 100)] {
        let mut tester = claimed_with(objects);
        tester.wait(100);
        tester.clip(21);
        tester.clipped = true;
        tester.wait(ms);
        tester.clipped = false;
        tester.wait(90);
        assert_eq!(codes(&mut tester), "1CEC2180#100A0002FFCAFE00");
        let sent = tester.exchange("1CEC8021#110201FFFFCAFE00");
        assert_eq!(sent[0], "1CEB2180#0104FF7013020171");
        assert_eq!(sent[1], "1CEB2180#02130201FFFFFFFF");
        tester.exchange("1CEC8021#130A0002FFCAFE00");
        tester.wait(1000);
        assert_eq!(codes(&mut tester), NO_CODES);
    }
}

/// The side is that of the angle, which is also sent.
#[test]
fn sensor_on_its_back_has_the_codes_of_both_angles_by_their_signs() {
    for (up, pitch, roll) in [
        ([-0.5, 0.5, -0.7], "701300", "711300"),
        ([0.5, -0.5, -0.7], "701301", "711301"),
    ] {
        let mut tester = claimed();
        tester.wait(100);
        tester.settle_at(up);
        tester.wait(200);
        assert_eq!(codes(&mut tester), "1CEC2180#100A0002FFCAFE00");
        let sent = tester.exchange("1CEC8021#110201FFFFCAFE00");
        assert_eq!(sent[0], format!("1CEB2180#0104FF{pitch}01{}", &roll[..2]));
        assert_eq!(sent[1], format!("1CEB2180#02{}01FFFFFFFF", &roll[2..]));
        tester.exchange("1CEC8021#130A0002FFCAFE00");
        tester.settle_at([0.0, 0.0, 1.0]);
        tester.wait(1000);
        assert_eq!(codes(&mut tester), NO_CODES);
    }
    let mut tester = claimed_with(&[(0x3120, 1, 1, 0)]);
    tester.settle_at([0.5, 0.5, -0.7]);
    tester.wait(100);
    assert_eq!(codes(&mut tester), NO_CODES, "one axis");
}

/// Level on its back, the noise is about 0 deg.
#[test]
fn noise_of_a_sensor_on_its_back_changes_no_code() {
    let mut tester = claimed();
    tester.wait(100);
    for angle in [-0.005, 0.005].repeat(4) {
        tester.settle_at([angle, -angle, -1.0]);
        tester.wait(1100);
    }
    assert_eq!(codes(&mut tester), "1CEC2180#100A0002FFCAFE00");
    let sent = tester.exchange("1CEC8021#110201FFFFCAFE00");
    assert_eq!(sent[0], "1CEB2180#0104FF7013000171", "the first occurrence");
    assert_eq!(sent[1], "1CEB2180#02130001FFFFFFFF");
}

/// 3 g for 20 ms, twice a second.
#[test]
fn repeated_shocks_of_3_g_have_no_code() {
    let mut tester = claimed();
    let still = tester.force;
    for _ in 0..20 {
        for (factor, ms) in [(4, 20), (1, 480)] {
            tester.force = still.map(|component| component * factor);
            let sent = tester.wait_text(ms);
            assert!(sent.iter().all(|(_, text)| text == NO_CODES), "{sent:?}");
        }
    }
}

/// A machine that digs: clipping for 120 ms, five times in two seconds. A code changes once a second, and DM1 is sent for the change and
/// once a second.
#[test]
fn repeated_clipping_sends_at_most_two_dm1_a_second() {
    let mut tester = claimed();
    tester.wait(100);
    let mut messages = 0;
    for _ in 0..25 {
        for (clipped, ms) in [(true, 120), (false, 280)] {
            tester.clipped = clipped;
            let sent = tester.wait_text(ms);
            let begins =
                |text: &str| text.starts_with("1CECFF80#20") || text.starts_with("18FECA80");
            messages += sent.iter().filter(|(_, text)| begins(text)).count();
        }
    }
    assert!((10..=21).contains(&messages), "{messages} in 10 s");
}

#[test]
fn supply_voltage_has_its_limits_and_hysteresis() {
    let (none, above, below) = ("", "A80003", "A80004");
    let mut tester = claimed();
    let mut counts = [0; 2];
    let mut before = none;
    // Below 8.0 V until 8.5 V, above 36.0 V until 35.5 V (S69).
    for (millivolts, code) in [
        (24_000, none),
        (8_000, none),
        (7_990, below),
        (8_490, below),
        (8_510, none),
        (36_000, none),
        (36_010, above),
        (35_510, above),
        (35_490, none),
        (7_000, below),
        (37_000, above),
        (24_000, none),
    ] {
        tester.supply(millivolts);
        tester.wait(60);
        if code != before && code != none {
            counts[usize::from(code == below)] += 1;
        }
        before = code;
        let expected = match code {
            "" => NO_CODES.to_string(),
            _ => one(code, counts[usize::from(code == below)]),
        };
        assert_eq!(codes(&mut tester), expected, "{millivolts} mV");
    }
}

#[test]
fn damaged_memory_has_its_code_until_a_good_save() {
    let stored = claimed().memory.unwrap();
    let boot = Boot {
        parameters: Some(&stored),
        damaged: true,
        ..Boot::default()
    };
    let mut tester = Tester::power_up(boot, Ims360::new);
    tester.sent();
    let sent = tester.wait_text(250);
    assert_eq!(sent, [(250, one("76020C", 1))]);
    tester.wait(100);
    let sent = tester.exchange("18EF8021#2310100173617665");
    assert_eq!(sent, ["18EF2180#6010100100000000", NO_CODES]);
}

#[test]
fn change_of_the_codes_is_sent_once() {
    let mut tester = claimed();
    for number in 1..=5 {
        for (data, expected) in [
            ("10270000", one("701300", number)),
            ("00000000", NO_CODES.to_string()),
        ] {
            // At different times after the last DM1.
            tester.wait(50 + 70 * u64::from(number));
            let sent = tester.exchange(&format!("18EF8021#23103200{data}"));
            assert_eq!(sent[1..], *std::slice::from_ref(&expected));
            let sent = tester.wait_text(1000);
            assert_eq!(sent, [(1000, expected)]);
        }
    }
}

#[test]
fn occurrences_begin_again_at_the_next_start() {
    let mut tester = claimed();
    for value in [10_000, 0, 10_000] {
        offset(&mut tester, 0x10, value);
    }
    assert_eq!(codes(&mut tester), one("701300", 2));
    tester.parameter("2310100173617665");
    tester.power_cycle();
    tester.sent();
    tester.hold(tester.force, 400);
    let sent = tester.wait_text(250);
    assert_eq!(sent, [(250, one("701300", 1))]);
}
