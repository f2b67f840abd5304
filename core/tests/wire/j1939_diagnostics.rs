//! Diagnostic trouble codes of the IMS360 (DM1).

use crate::tester::ims360::Ims360Tester;
use crate::tester::j1939::{NO_CODES, claimed};
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
fn angle_out_of_range_is_told_at_once() {
    let mut tester = claimed();
    tester.wait(100);
    assert_eq!(write(&mut tester, "23103200FF230000"), dm1("70130001")); // 92.15 deg
    tester.wait(100);
    assert_eq!(write(&mut tester, "2310320000000000"), [NO_CODES]);
    tester.wait(100);
    assert_eq!(write(&mut tester, "2320320000DCFFFF"), dm1("71130101")); // -92.16 deg
    tester.wait(100);
    // Within 50 ms of a message, a change waits.
    assert_eq!(write(&mut tester, "2320320000000000"), [NO_CODES]);
    tester.wait(20);
    assert_eq!(write(&mut tester, "2320320000DCFFFF"), [""; 0]);
    assert_eq!(sent(&mut tester, 29), [""; 0]);
    assert_eq!(sent(&mut tester, 1), dm1("71130102"));
}

#[test]
fn several_codes_are_sent_by_transport_protocol() {
    let mut tester = claimed();
    tester.wait(100);
    tester.clipped = true;
    tester.sample();
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
    let stale = tester.wait_without_samples(160);
    let stale: Vec<_> = stale
        .iter()
        .map(|(_, frame)| format!("{frame:?}"))
        .collect();
    assert_eq!(stale[0], "1CECFF80#200A0002FFCAFE00");
    assert_eq!(stale[1], "1CEBFF80#0104FF70130C0171");
}

#[test]
fn error_history_and_register_are_those_of_canopen() {
    let mut tester = claimed();
    write(&mut tester, "23103200FF230000");
    tester.wait(10);
    assert_eq!(tester.parameter("4001100000000000"), "4F01100081000000");
    assert_eq!(tester.parameter("4003100000000000"), "4F03100001000000");
    assert_eq!(tester.parameter("4003100100000000"), "4303100110500000");
}
