//! Diagnostic trouble codes of the IMS360 (DM1).

use crate::tester::ims360::Ims360Tester;
use crate::tester::j1939::{CLAIM, NO_CODES, claimed};
use plumbline::measure::ONE_G;
use plumbline::node::{BusEvent, BusState};

/// The messages with trouble codes within this time.
fn sent(tester: &mut Ims360Tester, ms: u64) -> Vec<String> {
    tester
        .wait_text(ms)
        .into_iter()
        .map(|(_, text)| text)
        .collect()
}

fn dm1(code: &str) -> Vec<String> {
    vec![format!("18FECA80#04FF{code}FFFF")]
}

#[test]
fn message_is_sent_every_second() {
    let mut tester = claimed();
    let times: Vec<_> = tester.wait_text(3000);
    let expected = [1000, 2000, 3000].map(|at| (at, NO_CODES.to_string()));
    assert_eq!(times, expected);
}

/// Writes an object. Returns the frames after the reply.
fn write(tester: &mut Ims360Tester, request: &str) -> Vec<String> {
    let mut sent = tester.exchange(&format!("18EF8021#{request}"));
    assert!(sent[0].starts_with("18EF2180#60"), "{sent:?}");
    sent.remove(0);
    sent
}

#[test]
fn angle_out_of_range_sends_dm1_at_once() {
    let mut tester = claimed();
    tester.wait(100);
    assert_eq!(write(&mut tester, "23103200FF230000"), dm1("70130001")); // 92.15 deg
    // A code changes at most once a second.
    tester.wait(1100);
    assert_eq!(write(&mut tester, "2310320000000000"), [NO_CODES]);
    tester.wait(1100);
    assert_eq!(write(&mut tester, "2320320000DCFFFF"), dm1("71130101")); // -92.16 deg
    tester.wait(1100);
    // Within 50 ms of a message, a change waits.
    assert_eq!(write(&mut tester, "2320320000000000"), [NO_CODES]);
    tester.wait(20);
    assert_eq!(write(&mut tester, "23103200FF230000"), [""; 0]);
    assert_eq!(sent(&mut tester, 29), [""; 0]);
    assert_eq!(sent(&mut tester, 1), dm1("70130002"));
}

#[test]
fn several_codes_are_sent_by_transport_protocol() {
    let mut tester = claimed();
    tester.wait(100);
    tester.clip(21);
    let messages = sent(&mut tester, 120);
    assert_eq!(
        messages,
        [
            "1CECFF80#200A0002FFCAFE00",
            "1CEBFF80#0104FF7013020171",
            "1CEBFF80#02130201FFFFFFFF",
        ]
    );
    let answer = tester.request_group("80", "CAFE00");
    assert_eq!(answer, ["1CEC2180#100A0002FFCAFE00"]);
    assert_eq!(
        tester.request_group("FF", "CAFE00"),
        ["1CECFF80#200A0002FFCAFE00"]
    );
}

#[test]
fn defective_sensor_memory_supply_and_network_have_codes() {
    let mut tester = claimed();
    tester.wait(100);
    tester.supply(40_000);
    assert_eq!(sent(&mut tester, 1), dm1("A8000301"));
    tester.wait(100);
    tester.supply(24_000);
    assert_eq!(sent(&mut tester, 60), [NO_CODES]);
    tester.supply(6_000);
    assert_eq!(sent(&mut tester, 60), dm1("A8000401"));
    tester.supply(24_000);
    tester.wait(100);
    tester.memory_works = Some(false);
    let sent_at_once = tester.exchange("18EF8021#2310100173617665");
    assert_eq!(sent_at_once[0], "18EF2180#8010100100000606");
    assert_eq!(sent_at_once[1..], dm1("76020C01"));
    tester.memory_works = Some(true);
    tester.wait(100);
    assert_eq!(write(&mut tester, "2310100173617665"), [NO_CODES]);
    tester.wait(100);
    tester.bus(BusEvent::State(BusState::Passive));
    assert_eq!(sent(&mut tester, 60), dm1("7F020201"));
    tester.bus(BusEvent::State(BusState::Active));
    tester.wait(100);
    tester.bus(BusEvent::Overrun);
    assert_eq!(
        sent(&mut tester, 60),
        [dm1("7F020202"), vec![NO_CODES.into()]].concat()
    );
    let stale = tester.wait_without_samples(220);
    let stale: Vec<_> = stale
        .iter()
        .map(|(_, frame)| format!("{frame:?}"))
        .collect();
    assert_eq!(stale[0], "1CECFF80#200A0002FFCAFE00");
    assert_eq!(stale[1], "1CEBFF80#0104FF70130C0171");
    assert_eq!(stale[2], "1CEBFF80#02130C01FFFFFFFF");
}

#[test]
fn error_history_and_register_match_canopen() {
    let mut tester = claimed();
    write(&mut tester, "23103200FF230000");
    tester.wait(10);
    assert_eq!(tester.parameter("4001100000000000"), "4F01100081000000");
    assert_eq!(tester.parameter("4003100000000000"), "4F03100001000000");
    assert_eq!(tester.parameter("4003100100000000"), "4303100110500000");
}

/// Writes 3210h, the zero offset of pitch: 100 deg is above the range.
fn pitch(tester: &mut Ims360Tester, data: &str) -> Vec<String> {
    write(tester, &format!("23103200{data}"))
}

const ABOVE: &str = "10270000";

/// The supply voltage in mV, and the frames sent at once. More than 36 V are a code.
fn supply(tester: &mut Ims360Tester, millivolts: u16) -> Vec<String> {
    tester.supply(millivolts);
    tester.sent_text()
}

const HIGH: u16 = 40_000;
const NORMAL: u16 = 24_000;

/// The accelerometer fails: both angles have a code until [`recover`].
fn fail(tester: &mut Ims360Tester) {
    tester.hold([0; 3], 120);
}

/// The accelerometer works again.
fn recover(tester: &mut Ims360Tester) {
    tester.hold([0, 0, ONE_G], 120);
}

#[track_caller]
fn assert_timed(sent: &[(u64, String)], expected: &[(u64, &str)]) {
    let sent: Vec<_> = sent.iter().map(|(at, text)| (*at, &text[..])).collect();
    assert_eq!(sent, expected);
}

#[test]
fn overrun_with_another_active_code_is_reported_once() {
    let mut tester = claimed();
    tester.wait(100);
    assert_eq!(pitch(&mut tester, ABOVE), dm1("70130001"));
    tester.wait(100);
    tester.bus(BusEvent::Overrun);
    assert_timed(
        &tester.wait_text(1119),
        &[
            (0, "1CECFF80#200A0002FFCAFE00"),
            (60, "1CEBFF80#0104FF701300017F"),
            (120, "1CEBFF80#02020201FFFFFFFF"),
            (120, "18FECA80#04FF70130001FFFF"),
        ],
    );
    assert_timed(&tester.wait_text(1), &[(1, "18FECA80#04FF70130001FFFF")]);
}

#[test]
fn overrun_during_another_broadcast_is_reported_after_it() {
    let mut tester = claimed();
    tester.wait(100);
    assert_eq!(pitch(&mut tester, ABOVE), dm1("70130001"));
    tester.wait(100);
    tester.request_group("FF", "EBFE00");
    tester.wait(10);
    tester.bus(BusEvent::Overrun);
    let sent = sent(&mut tester, 900);
    assert_eq!(
        sent[4..],
        [
            "1CECFF80#200A0002FFCAFE00",
            "1CEBFF80#0104FF701300017F",
            "1CEBFF80#02020201FFFFFFFF",
            "18FECA80#04FF70130001FFFF",
        ]
    );
}

#[test]
fn dm1_with_fewer_codes_is_sent_after_the_previous_dm1() {
    let mut tester = claimed();
    tester.wait(100);
    fail(&mut tester);
    assert_timed(
        &tester.wait_text(100),
        &[
            (0, "1CECFF80#200A0002FFCAFE00"),
            (60, "1CEBFF80#0104FF70130C0171"),
        ],
    );
    recover(&mut tester);
    assert_timed(
        &tester.wait_text(1019),
        &[(20, "1CEBFF80#02130C01FFFFFFFF"), (20, NO_CODES)],
    );
    assert_timed(&tester.wait_text(1), &[(1, NO_CODES)]);
}

#[test]
fn requested_dm1_waits_for_the_end_of_the_previous_dm1() {
    let mut tester = claimed();
    tester.wait(100);
    fail(&mut tester);
    tester.wait(105);
    recover(&mut tester);
    for destination in ["80", "FF"] {
        assert_eq!(tester.request_group(destination, "CAFE00"), [""; 0]);
    }
    assert_timed(
        &tester.wait_text(100),
        &[(15, "1CEBFF80#02130C01FFFFFFFF"), (15, NO_CODES)],
    );
}

#[test]
fn code_active_only_during_another_message_is_reported_after_it() {
    let mut tester = claimed();
    tester.wait(100);
    tester.request_group("FF", "EBFE00");
    fail(&mut tester);
    tester.wait(100);
    recover(&mut tester);
    tester.wait(139);
    assert_timed(
        &tester.wait_text(300),
        &[
            (1, "1CEBFF80#04353938352A2AFF"),
            (1, "1CECFF80#200A0002FFCAFE00"),
            (61, "1CEBFF80#0104FF70130C0171"),
            (121, "1CEBFF80#02130C01FFFFFFFF"),
            (121, NO_CODES),
        ],
    );
}

#[test]
fn message_that_becomes_shorter_while_it_waits_is_one_frame() {
    let mut tester = claimed();
    tester.wait(100);
    assert_eq!(pitch(&mut tester, ABOVE), dm1("70130001"));
    tester.wait(100);
    tester.supply(40_000);
    assert_eq!(sent(&mut tester, 990).len(), 3);
    tester.request_group("FF", "EBFE00");
    // The period ends, and the message with both codes waits.
    assert_eq!(tester.wait_text(20), []);
    tester.supply(24_000);
    assert_eq!(sent(&mut tester, 1), dm1("70130001"));
    let rest = sent(&mut tester, 900);
    assert!(rest.iter().all(|text| text.starts_with("1CEBFF80#")));
    assert_eq!(rest.len(), 4, "the identification");
}

#[test]
fn code_active_for_less_than_50_ms_is_in_the_next_message() {
    let mut tester = claimed();
    tester.wait(100);
    assert_eq!(supply(&mut tester, HIGH), dm1("A8000301"));
    tester.wait(100);
    assert_eq!(supply(&mut tester, NORMAL), [NO_CODES]);
    tester.wait(10);
    assert_eq!(supply(&mut tester, HIGH), [""; 0]);
    tester.wait(20);
    assert_eq!(supply(&mut tester, NORMAL), [""; 0]);
    assert_timed(
        &tester.wait_text(1069),
        &[(20, "18FECA80#04FFA8000302FFFF"), (70, NO_CODES)],
    );
    assert_timed(&tester.wait_text(1), &[(1, NO_CODES)]);
}

#[test]
fn code_cleared_for_less_than_50_ms_is_reported_with_its_count() {
    let mut tester = claimed();
    tester.wait(100);
    assert_eq!(supply(&mut tester, HIGH), dm1("A8000301"));
    tester.wait(10);
    assert_eq!(supply(&mut tester, NORMAL), [""; 0]);
    assert_eq!(supply(&mut tester, HIGH), [""; 0]);
    assert_timed(
        &tester.wait_text(1000),
        &[(40, "18FECA80#04FFA8000302FFFF")],
    );
}

#[test]
fn identification_is_sent_while_codes_change_all_the_time() {
    let mut tester = claimed();
    tester.wait(100);
    // Every 110 ms the codes change: while a message with them is sent, the next one is due.
    fail(&mut tester);
    tester.request_group("FF", "EBFE00");
    tester.request_group("FF", "C5FD00");
    let mut sent = Vec::new();
    for _ in 0..20 {
        sent.extend(tester.wait_text(100));
        recover(&mut tester);
        sent.extend(tester.wait_text(10));
        fail(&mut tester);
    }
    let begun: Vec<_> = sent
        .iter()
        .filter(|(_, text)| text.starts_with("1CEC"))
        .map(|(_, text)| &text[text.len() - 6..])
        .collect();
    assert_eq!(begun[..4], ["EBFE00", "C5FD00", "CAFE00", "CAFE00"]);
}

#[test]
fn overrun_before_a_restart_is_not_reported_after_it() {
    let mut tester = claimed();
    tester.wait(100);
    tester.supply(40_000);
    assert_eq!(sent(&mut tester, 20), dm1("A8000301"));
    // The next message is possible 50 ms after this one.
    tester.bus(BusEvent::Overrun);
    assert_eq!(write(&mut tester, "2F10200101000000"), [""; 0]);
    let sent = tester.wait_text(900);
    assert_timed(&sent, &[(100, CLAIM), (350, "18FECA80#04FFA8000301FFFF")]);
}
