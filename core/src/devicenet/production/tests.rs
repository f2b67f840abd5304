//! Tests of the production of messages and of the acknowledge handler.

use super::*;
use crate::time::Duration;

fn at(ms: u32) -> Instant {
    Instant::from_ticks(0) + millis(ms)
}

/// The time in ms of the next message.
fn next(production: &Production) -> Option<u64> {
    let time = production.deadline().time();
    time.map(|time| time.ticks() / 1000)
}

/// A running production that has sent its first message at the time 100.
fn running(rate: u16, is_cyclic: bool, inhibit: u16) -> Production {
    let mut production = Production::OFF;
    production.set_inhibit(inhibit);
    production.set_rate(at(100), rate, is_cyclic);
    assert!(production.is_due(at(100), |_| false), "the first message");
    production.produced(at(100), [1, 2, 0, 0]);
    assert_eq!(production.sent(), &[1, 2, 0, 0]);
    production
}

#[test]
fn change_restarts_the_rate_of_cos_messages() {
    let mut cos = running(1000, false, 0);
    assert_eq!(next(&cos), Some(1100));
    assert!(cos.watches());
    cos.change();
    assert!(!cos.watches());
    assert!(cos.is_due(at(300), |_| true));
    cos.produced(at(300), [3, 2, 0, 0]);
    assert_eq!(next(&cos), Some(1300));
    assert!(!cos.is_due(at(1299), |_| true), "no change was seen");
    assert!(cos.is_due(at(1300), |_| false));
}

#[test]
fn cyclic_messages_ignore_changes_and_have_no_drift() {
    let mut cyclic = running(50, true, 0);
    assert!(!cyclic.watches());
    assert_eq!(next(&cyclic), Some(150));
    assert!(cyclic.is_due(at(153), |_| false));
    cyclic.produced(at(153), [1, 2, 0, 0]);
    assert_eq!(next(&cyclic), Some(200));
    assert!(cyclic.is_due(at(251), |_| false));
    cyclic.produced(at(251), [1, 2, 0, 0]);
    assert_eq!(next(&cyclic), Some(301), "a message was missed");
}

#[test]
fn repeated_cos_messages_have_no_drift() {
    let mut cos = running(2, false, 0);
    for due in [102, 104, 106] {
        assert_eq!(next(&cos), Some(due));
        let late = at(due as u32) + Duration::micros(30);
        assert!(cos.is_due(late, |_| false));
        cos.produced(late, [1, 2, 0, 0]);
    }
}

#[test]
fn new_inhibit_time_begins_with_the_last_message() {
    for (inhibit, due) in [(0, 150), (100, 200), (400, 500)] {
        let mut cos = running(0, false, 300);
        cos.change();
        assert_eq!(next(&cos), Some(400));
        assert!(!cos.is_due(at(150), |_| true));
        cos.set_inhibit(inhibit);
        if inhibit > 0 {
            assert!(!cos.is_due(at(due - 1), |_| true));
        }
        assert!(cos.is_due(at(due), |_| true));
    }
}

#[test]
fn rate_0_has_no_repetition() {
    for is_cyclic in [false, true] {
        let mut production = running(0, is_cyclic, 0);
        assert_eq!(next(&production), None);
        production.set_rate(at(200), 40, is_cyclic);
        assert_eq!(next(&production), Some(240));
        production.set_rate(at(200), 0, is_cyclic);
        assert_eq!(next(&production), None);
    }
}

#[test]
fn inhibit_time_delays_a_change_and_sends_only_what_still_differs() {
    let mut cos = running(1000, false, 30);
    cos.change();
    assert!(!cos.is_due(at(129), |_| true));
    assert_eq!(next(&cos), Some(130));
    assert!(cos.is_due(at(130), |sent| *sent == [1, 2, 0, 0]));
    cos.produced(at(130), [5, 2, 0, 0]);
    cos.change();
    assert!(!cos.is_due(at(160), |_| false), "the old value is back");
    assert!(cos.watches());
    assert_eq!(next(&cos), Some(1130));
}

#[test]
fn message_is_repeated_up_to_the_retry_limit() {
    for (retries, times) in [(0, &[][..]), (1, &[16]), (3, &[16, 32, 48])] {
        let mut handler = AcknowledgeHandler::DEFAULT;
        handler.set_retries(retries);
        handler.produced(at(0));
        let mut repeated = vec![];
        while let Some(time) = handler.deadline().time() {
            if handler.poll(time) {
                repeated.push(time.ticks() as u32 / 1000);
            }
        }
        assert_eq!(repeated, times);
    }
}

#[test]
fn acknowledged_message_is_not_repeated() {
    let mut handler = AcknowledgeHandler::DEFAULT;
    assert_eq!((handler.timer(), handler.retries()), (16, 1));
    handler.produced(at(0));
    assert!(!handler.poll(at(15)));
    handler.stop();
    assert!(!handler.poll(at(16)));
    assert_eq!(handler.deadline(), Deadline::NEVER);
}
