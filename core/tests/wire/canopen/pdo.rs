//! TPDOs and SYNC of the JN2101 (CiA 301, 7.2.2, 7.2.5, 7.5.2.37; manual 7.4, 7.5).

use crate::tester::canopen::*;
use plumbline::can::standard;
use plumbline::node::Action;

/// 10.00 deg longitudinal, -5.00 deg lateral: 03E8h and FE0Ch.
const TPDO0: &str = "18A#E8030CFE";
const TPDO1: &str = "28A#E80300000CFEFFFF";

fn tilted() -> Jn2101Tester {
    let mut t = operational();
    t.tilt(10.0, -5.0);
    t
}

/// A tilted sensor in pre-operational, so that a test can configure it first.
fn tilted_pre_operational() -> Jn2101Tester {
    let mut t = booted();
    t.tilt(10.0, -5.0);
    t
}

fn silence(t: &mut Jn2101Tester, number: u16) {
    t.write(0x1800 + number, 2, 1, 253).unwrap();
}

#[test]
fn both_tpdos_with_factory_values_answer_each_sync() {
    let mut t = tilted();
    for _ in 0..5 {
        assert_eq!(t.exchange("080#"), [TPDO0, TPDO1]);
    }
    assert_eq!(t.wait_text(1000), [], "no TPDO without a SYNC");
}

#[test]
fn sync_with_counter_is_accepted() {
    let mut t = tilted();
    for counter in ["080#00", "080#01", "080#05", "080#F0"] {
        assert_eq!(t.exchange(counter), [TPDO0, TPDO1], "{counter}");
    }
    for frame in ["080#0102", "080#R", "00000080#", "00000080#R", "081#"] {
        assert_eq!(t.exchange(frame), [""; 0], "{frame}");
    }
}

#[test]
fn sync_is_answered_with_newest_sample() {
    let mut t = booted();
    t.write(0x2043, 0, 1, 0).unwrap();
    t.send("000#0100");
    t.tilt(10.0, -5.0);
    assert_eq!(t.exchange("080#"), [TPDO0, TPDO1]);
    t.tilt(-10.0, 0.0);
    assert_eq!(t.exchange("080#")[0], "18A#18FC0000");
}

#[test]
fn pdos_are_sent_only_in_operational() {
    let mut t = tilted_pre_operational();
    for state in ["000#800A", "000#020A"] {
        t.send(state);
        assert_eq!(t.exchange("080#"), [""; 0]);
        assert_eq!(t.exchange("18A#R4"), [""; 0]);
    }
    t.send("000#800A");
    t.write(0x1800, 2, 1, 254).unwrap();
    assert_eq!(t.wait_text(100), []);
    t.send("000#010A");
    assert_eq!(t.wait_text(10).len(), 1);
    t.send("000#800A");
    assert_eq!(t.wait_text(100), []);
}

#[test]
fn queued_pdo_is_not_sent_after_operational() {
    let mut t = tilted();
    t.send("080#");
    t.send("000#800A");
    assert_eq!(t.sent_text(), [""; 0]);
}

#[test]
fn cyclic_pdo_is_sent_with_each_nth_sync() {
    for (number, tpdo) in [(0, TPDO0), (1, TPDO1)] {
        for n in [1, 2, 3, 10, 100, 239, 240] {
            let mut t = tilted_pre_operational();
            t.write(0x1800 + number, 2, 1, n).unwrap();
            silence(&mut t, 1 - number);
            t.send("000#010A");
            for round in 1..=3 {
                for count in 1..=n {
                    let expected: &[&str] = if count == n { &[tpdo] } else { &[] };
                    assert_eq!(t.exchange("080#"), expected, "{round}: {count} of {n}");
                }
            }
            assert_eq!(t.wait_text(100), [], "the event timer has no effect");
        }
    }
}

#[test]
fn type_0_answers_sync_if_data_has_changed() {
    let mut t = tilted_pre_operational();
    t.write(0x1800, 2, 1, 0).unwrap();
    silence(&mut t, 1);
    t.send("000#010A");
    assert_eq!(t.wait_text(100), [], "not without a SYNC");
    assert_eq!(t.exchange("080#"), [TPDO0]);
    assert_eq!(t.exchange("080#"), [""; 0]);
    t.tilt(10.0, -6.0);
    assert_eq!(t.exchange("080#"), ["18A#E803A8FD"]);
    assert_eq!(t.exchange("080#"), [""; 0]);
    // The first SYNC after entering operational is always answered.
    t.send("000#800A");
    t.send("000#010A");
    assert_eq!(t.exchange("080#"), ["18A#E803A8FD"]);
}

#[test]
fn type_252_samples_with_sync_and_sends_on_request() {
    let mut t = tilted_pre_operational();
    t.write(0x1800, 2, 1, 252).unwrap();
    silence(&mut t, 1);
    t.send("000#010A");
    assert_eq!(t.exchange("080#"), [""; 0]);
    t.tilt(0.0, 0.0);
    assert_eq!(t.exchange("18A#R4"), [TPDO0]);
    assert_eq!(t.exchange("18A#R4"), [TPDO0]);
    assert_eq!(t.exchange("080#"), [""; 0]);
    assert_eq!(t.exchange("18A#R4"), ["18A#00000000"]);
}

#[test]
fn type_253_sends_on_request() {
    let mut t = tilted_pre_operational();
    silence(&mut t, 0);
    silence(&mut t, 1);
    t.send("000#010A");
    assert_eq!(t.exchange("080#"), [""; 0]);
    assert_eq!(t.wait_text(1000), []);
    assert_eq!(t.exchange("18A#R4"), [TPDO0]);
    assert_eq!(t.exchange("28A#R8"), [TPDO1]);
    assert_eq!(t.exchange("18B#R4"), [""; 0]);
    // A data frame with its identifier is ignored.
    assert_eq!(t.exchange("18A#00000000"), [""; 0]);
}

#[test]
fn remote_frames_of_each_length_are_answered_in_all_types() {
    for kind in [0, 1, 240, 252, 253, 254, 255] {
        let mut t = tilted_pre_operational();
        for number in 0..2 {
            t.write(0x1800 + number, 2, 1, kind).unwrap();
            t.write(0x1800 + number, 5, 2, 0).unwrap();
        }
        t.send("000#010A");
        for length in 0..=8 {
            assert_eq!(t.exchange(&format!("18A#R{length}")), [TPDO0], "{kind}");
            assert_eq!(t.exchange(&format!("28A#R{length}")), [TPDO1], "{kind}");
        }
        for other in ["0000018A#R4", "18B#R4", "28B#R8", "28A#00", "18A#00000000"] {
            assert_eq!(t.exchange(other), [""; 0], "{kind}: {other}");
        }
    }
}

#[test]
fn event_timer_sends_periodically() {
    for kind in [254, 255] {
        let mut t = tilted_pre_operational();
        t.write(0x1800, 2, 1, kind).unwrap();
        t.send("000#010A");
        let every_10_ms: Vec<(u64, String)> = (1..=100).map(|n| (n * 10, TPDO0.into())).collect();
        assert_eq!(t.wait_text(1000), every_10_ms, "{kind}");
        assert_eq!(
            t.exchange("080#"),
            [TPDO1],
            "the other TPDO is sent with the SYNC"
        );
        // A request between two events does not shift the period.
        t.wait_text(5);
        assert_eq!(t.exchange("18A#R4"), [TPDO0]);
        assert_eq!(t.wait_text(10), [(5, TPDO0.to_string())]);
    }
}

#[test]
fn event_timer_of_1_ms_is_kept_beside_sdo_transfers() {
    let mut t = tilted_pre_operational();
    t.write(0x1800, 5, 2, 1).unwrap();
    t.write(0x1800, 2, 1, 254).unwrap();
    t.send("000#010A");
    for _ in 0..100 {
        assert_eq!(t.wait_text(1), [(1, TPDO0.to_string())]);
        assert_eq!(t.read(0x1000, 0), Ok(0x0004_019A));
    }
}

#[test]
fn new_event_timer_acts_at_once_and_0_switches_off() {
    let mut t = tilted();
    t.write(0x1801, 2, 1, 254).unwrap();
    t.write(0x1801, 5, 2, 250).unwrap();
    t.wait_text(100);
    t.write(0x1801, 5, 2, 20).unwrap();
    assert_eq!(
        t.wait_text(40),
        [(20, TPDO1.to_string()), (40, TPDO1.to_string())]
    );
    t.write(0x1801, 5, 2, 0).unwrap();
    assert_eq!(t.wait_text(1000), []);
    t.write(0x1801, 5, 2, 65_535).unwrap();
    assert_eq!(t.wait_text(65_535), [(65_535, TPDO1.to_string())]);
}

#[test]
fn inhibit_time_delays_events() {
    for (number, tpdo, request) in [(0, TPDO0, "18A#R4"), (1, TPDO1, "28A#R8")] {
        let mut t = tilted_pre_operational();
        let index = 0x1800 + number;
        silence(&mut t, 1 - number);
        t.write(index, 2, 1, 254).unwrap();
        // 25 ms, in units of 100 us, with an event every 10 ms.
        t.write(index, 3, 2, 250).unwrap();
        t.send("000#010A");
        let times: Vec<_> = t.wait_text(90).into_iter().map(|(time, _)| time).collect();
        assert_eq!(times, [10, 35, 60, 85]);
        // The inhibit time also applies to a request.
        t.write(index, 5, 2, 0).unwrap();
        assert_eq!(t.wait_text(100), []);
        assert_eq!(t.exchange(request), [tpdo]);
        assert_eq!(t.exchange(request), [""; 0]);
        assert_eq!(t.wait_text(100), [(25, tpdo.to_string())]);
        // A new inhibit time counts from the last frame.
        for (inhibit, time) in [(250, 25), (400, 40), (100, 10)] {
            t.write(index, 3, 2, 250).unwrap();
            assert_eq!(t.exchange(request), [tpdo]);
            assert_eq!(t.exchange(request), [""; 0]);
            t.write(index, 3, 2, inhibit).unwrap();
            assert_eq!(t.wait_text(100), [(time, tpdo.to_string())]);
        }
        // The inhibit time does not apply to the SYNC.
        t.write(index, 2, 1, 1).unwrap();
        assert_eq!(t.exchange("080#"), [tpdo]);
        assert_eq!(t.exchange("080#"), [tpdo]);
    }
}

#[test]
fn inhibit_time_has_resolution_of_100_us() {
    let mut t = tilted_pre_operational();
    t.write(0x1800, 2, 1, 254).unwrap();
    t.write(0x1800, 3, 2, 13).unwrap();
    t.write(0x1800, 5, 2, 1).unwrap();
    t.sampled = false;
    t.send("000#010A");
    let start = t.now.ticks();
    let mut times = Vec::new();
    while times.len() < 4 {
        if !t.next_text().is_empty() {
            times.push(t.now.ticks() - start);
        }
    }
    assert_eq!(times, [1000, 2300, 3600, 4900]);
}

#[test]
fn new_sync_identifier_acts_at_once() {
    let mut t = tilted();
    t.actions.clear();
    assert_eq!(t.write(0x1005, 0, 4, 0x123), Err(0x0609_0030));
    assert_eq!(t.write(0x1005, 0, 4, 0x8000_00A0), Ok(()));
    assert_eq!(t.read(0x1005, 0), Ok(0x8000_00A0));
    assert!(
        t.actions
            .iter()
            .any(|action| matches!(action, Action::Bus(..)))
    );
    assert!(t.accepts(standard(0x0A0)) && !t.accepts(standard(0x080)));
    assert_eq!(t.exchange("080#"), [""; 0]);
    assert_eq!(t.exchange("0A0#"), [TPDO0, TPDO1]);
    // Writing the same identifier again has no effect.
    t.actions.clear();
    assert_eq!(t.write(0x1005, 0, 4, 0xA0), Ok(()));
    assert_eq!(t.actions, []);
}

#[test]
fn used_identifiers_pass_filters() {
    let t = booted();
    for id in [0x000, 0x080, 0x60A, 0x70A, 0x18A, 0x28A] {
        assert!(t.accepts(standard(id)), "{id:03X}");
    }
    assert!(!t.accepts(standard(0x58A)));
}

#[test]
fn newest_value_on_busy_bus_replaces_queued_one() {
    let mut t = tilted();
    for _ in 0..100 {
        t.send("080#");
    }
    t.tilt(0.0, 0.0);
    t.send("080#");
    assert_eq!(t.sent_text(), ["18A#00000000", "28A#0000000000000000"]);
}
