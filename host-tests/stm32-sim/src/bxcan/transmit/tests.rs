use super::*;
use plumbline::can::{extended, standard};

const AGAIN: bool = true;
const NOT_AGAIN: bool = false;

/// CAN_TSR after a reset: all mailboxes empty.
const ALL_EMPTY: u32 = 0x1C00_0000;

fn request(transmitter: &mut Transmitter, mailbox: usize, identifier: u32) {
    let mut violations = Violations::default();
    assert!(transmitter.write(mailbox, 0, identifier << 21 | REQUEST, &mut violations));
    assert_eq!(violations.all, []);
}

/// Mailboxes 0, 1, 2 with these standard identifiers, requested in that order.
fn pending(identifiers: &[u32]) -> Transmitter {
    let mut transmitter = Transmitter::default();
    for (mailbox, identifier) in identifiers.iter().enumerate() {
        request(&mut transmitter, mailbox, *identifier);
    }
    transmitter
}

/// Sends all pending frames; returns the mailboxes in the order of transmission.
fn sent(transmitter: &mut Transmitter, order: Order) -> Vec<usize> {
    let mut sent = Vec::new();
    while transmitter.offered(order).is_some() {
        transmitter.started(order);
        sent.extend(transmitter.under_way);
        transmitter.ended(Outcome::Succeeded, AGAIN);
    }
    sent
}

fn results(transmitter: &Transmitter, mailbox: usize) -> u32 {
    transmitter.status(Order::Identifier) >> (8 * mailbox) & 0xFF
}

fn is_empty(transmitter: &Transmitter, mailbox: usize) -> bool {
    transmitter.status(Order::Identifier) >> (26 + mailbox) & 1 != 0
}

#[test]
fn frame_is_sent_unchanged() {
    let mut transmitter = Transmitter::default();
    let mut violations = Violations::default();
    for (word, value) in [
        (1, 3),
        (2, 0x00CC_BBAA),
        (3, 0),
        (0, 0x1234_5678 << 3 | 0b101),
    ] {
        transmitter.write(1, word, value, &mut violations);
    }
    let frame = Frame::data(extended(0x1234_5678), &[0xAA, 0xBB, 0xCC]);
    assert_eq!(transmitter.offered(Order::Identifier), frame);
    assert_eq!(transmitter.read(1, 0), 0x1234_5678 << 3 | 0b101);
    assert_eq!(transmitter.read(1, 1), 3);
    transmitter.started(Order::Identifier);
    assert!(!transmitter.is_completed());
    transmitter.ended(Outcome::Succeeded, AGAIN);
    assert!(transmitter.is_completed());
    assert_eq!(results(&transmitter, 1), COMPLETED | SUCCEEDED);
    assert_eq!(transmitter.read(1, 0) & REQUEST, 0);
    assert_eq!(transmitter.offered(Order::Identifier), None);
}

#[test]
fn identifier_order_sends_lowest_identifier_first() {
    assert_eq!(
        sent(&mut pending(&[0x300, 0x100, 0x200]), Order::Identifier),
        [1, 2, 0]
    );
}

#[test]
fn equal_identifiers_are_sent_in_mailbox_order() {
    let mut transmitter = Transmitter::default();
    for mailbox in [2, 0, 1] {
        request(&mut transmitter, mailbox, 0x123);
    }
    assert_eq!(sent(&mut transmitter, Order::Identifier), [0, 1, 2]);
}

#[test]
fn request_order_sends_first_request_first() {
    let mut transmitter = Transmitter::default();
    for (mailbox, identifier) in [(2, 0x300), (0, 0x200), (1, 0x100)] {
        request(&mut transmitter, mailbox, identifier);
    }
    assert_eq!(sent(&mut transmitter, Order::Request), [2, 0, 1]);
}

#[test]
fn lower_identifier_overtakes_after_lost_arbitration() {
    let mut transmitter = pending(&[0x200]);
    transmitter.started(Order::Identifier);
    request(&mut transmitter, 1, 0x100);
    transmitter.ended(Outcome::LostArbitration, AGAIN);
    assert_eq!(sent(&mut transmitter, Order::Identifier), [1, 0]);
}

#[test]
fn status_has_empty_mailboxes() {
    let code = |status: u32| status >> 24 & 3;
    let empty = |status: u32| status >> 26 & 7;
    let lowest = |status: u32| status >> 29;
    assert_eq!(Transmitter::default().status(Order::Identifier), ALL_EMPTY);
    let one = pending(&[0x100]).status(Order::Identifier);
    assert_eq!((empty(one), code(one), lowest(one)), (0b110, 1, 0));
    let two = pending(&[0x300, 0x100]).status(Order::Identifier);
    assert_eq!((empty(two), code(two), lowest(two)), (0b100, 2, 0b001));
}

#[test]
fn code_is_lowest_priority_mailbox_when_all_are_full() {
    let code_and_lowest = |identifiers: &[u32], order| {
        let status = pending(identifiers).status(order);
        (status >> 26 & 7, status >> 24 & 3, status >> 29)
    };
    assert_eq!(
        code_and_lowest(&[0x200, 0x300, 0x100], Order::Identifier),
        (0, 1, 0b010)
    );
    assert_eq!(
        code_and_lowest(&[0x200, 0x200, 0x200], Order::Identifier),
        (0, 2, 0b100)
    );
    assert_eq!(
        code_and_lowest(&[0x300, 0x200, 0x100], Order::Request),
        (0, 2, 0b100)
    );
}

#[test]
fn write_to_pending_mailbox_is_violation() {
    let mut transmitter = pending(&[0x100]);
    let mut violations = Violations::default();
    for word in 0..4 {
        assert!(!transmitter.write(0, word, 0xFFFF_FFFF, &mut violations));
    }
    let registers: Vec<_> = violations.all.iter().map(|v| v.register).collect();
    assert_eq!(
        registers,
        ["CAN_TI0R", "CAN_TDT0R", "CAN_TDL0R", "CAN_TDH0R"]
    );
    assert_eq!(
        transmitter.offered(Order::Identifier),
        Frame::data(standard(0x100), &[])
    );
}

#[test]
fn failed_attempt_is_repeated() {
    let mut transmitter = pending(&[0x100]);
    for (outcome, flag) in [
        (Outcome::Failed, FAILED),
        (Outcome::LostArbitration, LOST_ARBITRATION),
    ] {
        transmitter.started(Order::Identifier);
        transmitter.ended(outcome, AGAIN);
        assert_eq!(results(&transmitter, 0), flag);
        assert!(!is_empty(&transmitter, 0));
    }
    transmitter.started(Order::Identifier);
    transmitter.ended(Outcome::Succeeded, AGAIN);
    assert_eq!(results(&transmitter, 0), COMPLETED | SUCCEEDED);
}

#[test]
fn no_retransmission_limits_to_one_attempt() {
    for (outcome, flag) in [
        (Outcome::Failed, FAILED),
        (Outcome::LostArbitration, LOST_ARBITRATION),
        (Outcome::Succeeded, SUCCEEDED),
    ] {
        let mut transmitter = pending(&[0x100]);
        transmitter.started(Order::Identifier);
        transmitter.ended(outcome, NOT_AGAIN);
        assert_eq!(results(&transmitter, 0), COMPLETED | flag);
        assert!(is_empty(&transmitter, 0));
    }
}

#[test]
fn pending_mailbox_is_aborted_at_once() {
    let mut transmitter = pending(&[0x100, 0x200]);
    transmitter.started(Order::Identifier);
    transmitter.write_status(ABORT << 8);
    assert!(is_empty(&transmitter, 1));
    assert_eq!(results(&transmitter, 1), COMPLETED);
    assert!(!is_empty(&transmitter, 0));
}

#[test]
fn mailbox_on_the_wire_is_aborted_after_its_attempt() {
    for (outcome, flag) in [
        (Outcome::Succeeded, SUCCEEDED),
        (Outcome::Failed, FAILED),
        (Outcome::LostArbitration, LOST_ARBITRATION),
    ] {
        let mut transmitter = pending(&[0x100]);
        transmitter.started(Order::Identifier);
        transmitter.write_status(ABORT);
        assert!(!is_empty(&transmitter, 0));
        assert_eq!(results(&transmitter, 0), ABORT);
        transmitter.ended(outcome, AGAIN);
        assert!(is_empty(&transmitter, 0));
        assert_eq!(results(&transmitter, 0), COMPLETED | flag);
    }
}

#[test]
fn abort_of_empty_mailbox_has_no_effect() {
    let mut transmitter = Transmitter::default();
    transmitter.write_status(ABORT | ABORT << 8 | ABORT << 16);
    assert_eq!(transmitter.status(Order::Identifier), ALL_EMPTY);
}

#[test]
fn results_are_cleared_by_software_or_next_request() {
    let mut transmitter = pending(&[0x100, 0x200]);
    sent(&mut transmitter, Order::Identifier);
    transmitter.write_status(COMPLETED);
    assert_eq!(results(&transmitter, 0), 0);
    assert_eq!(results(&transmitter, 1), COMPLETED | SUCCEEDED);
    request(&mut transmitter, 1, 0x200);
    assert_eq!(results(&transmitter, 1), 0);
    assert!(!transmitter.is_completed());
}
