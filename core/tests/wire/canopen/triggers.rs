//! Triggers of TPDOs with transmission types 254 and 255: change of value, event timer and inhibit time.

use crate::tester::mapped::*;

/// A node in operational whose first TPDO has this type.
fn typed(kind: u32) -> MappedTester {
    let mut t = mapped();
    t.push([0, 0, 1000]);
    t.write(0x1800, 2, 1, kind).unwrap();
    t
}

fn times(frames: Vec<(u64, String)>) -> Vec<u64> {
    frames.into_iter().map(|(time, _)| time).collect()
}

#[test]
fn type_0_and_reserved_types_are_refused() {
    let mut t = mapped();
    for kind in [0, 241, 251] {
        assert_eq!(t.write(0x1800, 2, 1, kind), Err(0x0609_0030), "{kind}");
    }
    for kind in [1, 240, 252, 253, 254, 255] {
        assert_eq!(t.write(0x1800, 2, 1, kind), Ok(()), "{kind}");
    }
    assert_eq!(t.read(0x1800, 4), Err(0x0609_0011));
    assert_eq!(t.write(0x1800, 4, 1, 0), Err(0x0609_0011));
}

#[test]
fn type_255_is_sent_at_start_and_when_data_changes() {
    let mut t = typed(255);
    assert_eq!(t.exchange("000#0132"), ["1B2#00000000"]);
    t.push([0, 0, 900]);
    assert_eq!(t.sent_text(), [""; 0], "Z is not mapped");
    t.push([1, 0, 900]);
    assert_eq!(t.sent_text(), ["1B2#01000000"]);
    assert_eq!(t.wait_text(1000), []);
    t.push([0, 0, 1000]);
    assert_eq!(t.sent_text(), ["1B2#00000000"]);
    assert_eq!(t.exchange("080#"), [""; 0]);
    t.send("000#8032");
    assert_eq!(t.exchange("000#0132"), ["1B2#00000000"]);
}

#[test]
fn type_255_compares_with_data_sent_on_request() {
    let mut t = typed(255);
    t.write(0x1800, 3, 2, 100).unwrap();
    t.send("000#0132");
    assert_eq!(t.sent_text(), ["1B2#00000000"]);
    t.push([1, 0, 1000]);
    assert_eq!(t.sent_text(), [""; 0], "inhibit time");
    assert_eq!(t.wait_text(20), [(10, "1B2#01000000".to_string())]);
    assert_eq!(t.exchange("1B2#R4"), ["1B2#01000000"]);
    assert_eq!(t.wait_text(100), []);
}

#[test]
fn type_255_sends_at_most_once_in_inhibit_time() {
    let mut t = typed(255);
    t.write(0x1800, 3, 2, 500).unwrap();
    t.send("000#0132");
    assert_eq!(t.sent_text(), ["1B2#00000000"]);
    let mut sent = Vec::new();
    for step in 1..=100 {
        t.push([step, 0, 1000]);
        sent.extend(times(t.wait_text(1)).iter().map(|_| step));
    }
    assert_eq!(sent, [50, 100]);
}

#[test]
fn type_254_is_sent_by_timer_only() {
    let mut t = typed(254);
    t.write(0x1800, 5, 2, 20).unwrap();
    assert_eq!(t.exchange("000#0132"), [""; 0]);
    t.push([1, 0, 1000]);
    assert_eq!(times(t.wait_text(60)), [20, 40, 60]);
}

#[test]
fn each_transmission_restarts_event_timer() {
    let mut t = typed(255);
    t.write(0x1800, 5, 2, 20).unwrap();
    t.send("000#0132");
    assert_eq!(t.sent_text(), ["1B2#00000000"]);
    t.wait_text(15);
    assert_eq!(t.exchange("1B2#R4").len(), 1);
    assert_eq!(times(t.wait_text(45)), [20, 40]);
    t.push([1, 0, 1000]);
    assert_eq!(t.sent_text().len(), 1);
    assert_eq!(times(t.wait_text(25)), [20]);
}

#[test]
fn new_event_timer_acts_after_running_period() {
    let mut t = typed(254);
    t.write(0x1800, 5, 2, 50).unwrap();
    t.send("000#0132");
    t.wait_text(10);
    t.write(0x1800, 5, 2, 20).unwrap();
    assert_eq!(times(t.wait_text(80)), [40, 60, 80]);
    t.write(0x1800, 5, 2, 0).unwrap();
    assert_eq!(t.wait_text(1000), []);
    t.write(0x1800, 5, 2, 30).unwrap();
    assert_eq!(times(t.wait_text(60)), [30, 60]);
}

/// A node whose first TPDO, by a timer of 10 ms, was sent 30 ms ago. The inhibit time is 200 ms, so the next one waits.
fn waiting() -> MappedTester {
    let mut t = typed(254);
    t.write(0x1800, 3, 2, 2000).unwrap();
    t.write(0x1800, 5, 2, 10).unwrap();
    t.send("000#0132");
    assert_eq!(times(t.wait_text(40)), [10]);
    t
}

#[test]
fn new_inhibit_time_counts_from_the_last_frame() {
    for (inhibit, expected) in [(2000, [170, 370]), (500, [20, 70]), (3000, [270, 570])] {
        let mut t = waiting();
        t.write(0x1800, 3, 2, inhibit).unwrap();
        assert_eq!(times(t.wait_text(600))[..2], expected, "{inhibit}");
    }
}

#[test]
fn inhibit_time_of_0_sends_what_waits() {
    let mut t = waiting();
    assert_eq!(
        t.exchange("632#2B00180300000000"),
        ["5B2#6000180300000000", "1B2#00000000"]
    );
    assert_eq!(times(t.wait_text(20)), [10, 20]);
}

/// Section 7.2.13: writing 0 disables the service.
#[test]
fn event_of_the_timer_does_not_wait_behind_a_timer_of_0() {
    let mut t = waiting();
    t.write(0x1800, 5, 2, 0).unwrap();
    assert_eq!(t.wait_text(1000), []);
}

#[test]
fn request_waits_behind_a_timer_of_0() {
    let mut t = typed(254);
    t.write(0x1800, 3, 2, 1000).unwrap();
    t.write(0x1800, 5, 2, 10).unwrap();
    t.send("000#0132");
    assert_eq!(times(t.wait_text(10)), [10]);
    assert_eq!(t.exchange("1B2#R4"), [""; 0]);
    t.write(0x1800, 5, 2, 0).unwrap();
    assert_eq!(times(t.wait_text(400)), [100]);
}

#[test]
fn new_type_restarts_count_of_syncs() {
    let mut t = typed(3);
    t.send("000#0132");
    for expected in [0, 0, 1, 0] {
        assert_eq!(t.exchange("080#").len(), expected);
    }
    t.write(0x1800, 2, 1, 2).unwrap();
    for expected in [0, 1, 0, 1] {
        assert_eq!(t.exchange("080#").len(), expected);
    }
    // The same type again continues the count.
    t.send("080#");
    t.write(0x1800, 2, 1, 2).unwrap();
    assert_eq!(t.exchange("080#").len(), 1);
}

#[test]
fn type_252_answers_request_with_data_of_last_sync() {
    let mut t = typed(252);
    t.send("000#0132");
    t.push([5, 0, 1000]);
    assert_eq!(t.exchange("080#"), [""; 0]);
    t.push([6, 0, 1000]);
    assert_eq!(t.exchange("1B2#R4"), ["1B2#05000000"]);
    t.write(0x1800, 2, 1, 253).unwrap();
    assert_eq!(t.exchange("1B2#R4"), ["1B2#06000000"]);
}
