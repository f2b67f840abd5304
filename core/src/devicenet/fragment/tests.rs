//! Tests of both directions of fragmented messages.

use super::*;

fn at(ms: u32) -> Instant {
    Instant::from_ticks(0) + millis(ms)
}

/// The data of the acknowledge of a fragment with the header 8Ah, and whether the message is complete.
fn receive(receiver: &mut Receiver, bytes: &[u8]) -> Option<([u8; 3], bool)> {
    let (answer, complete) = receiver.receive(bytes)?;
    let (data, length) = acknowledge(0x8A, answer);
    assert_eq!(length, 3);
    let [a, b, c, ..] = data.to_le_bytes();
    Some(([a, b, c], complete))
}

#[test]
fn fragments_are_appended_and_acknowledged() {
    let mut receiver = Receiver::IDLE;
    let mut take = |bytes: &[u8]| receive(&mut receiver, bytes);
    assert_eq!(take(&[0x00, 1, 2]), Some(([0x8A, 0xC0, 0], false)));
    assert_eq!(
        take(&[0x41, 3, 4, 5, 6, 7, 8]),
        Some(([0x8A, 0xC1, 0], false))
    );
    // The acknowledge was lost: the same fragment again.
    assert_eq!(
        take(&[0x41, 3, 4, 5, 6, 7, 8]),
        Some(([0x8A, 0xC1, 0], false))
    );
    assert_eq!(take(&[0x82, 9]), Some(([0x8A, 0xC2, 0], true)));
    assert_eq!(take(&[0x82, 9]), None, "the message is complete");
    let (body, length) = receiver.body();
    assert_eq!(body[..length], [1, 2, 3, 4, 5, 6, 7, 8, 9]);
}

#[test]
fn first_fragment_starts_anew() {
    let mut receiver = Receiver::IDLE;
    receive(&mut receiver, &[0x00, 1, 2]);
    receive(&mut receiver, &[0x41, 3]);
    assert_eq!(
        receive(&mut receiver, &[0x00, 9]),
        Some(([0x8A, 0xC0, 0], false))
    );
    assert_eq!(
        receive(&mut receiver, &[0x81, 8]),
        Some(([0x8A, 0xC1, 0], true))
    );
    let (body, length) = receiver.body();
    assert_eq!(body[..length], [9, 8]);
}

#[test]
fn fragments_without_valid_first_one_are_dropped() {
    let mut receiver = Receiver::IDLE;
    for bytes in [
        [0x40, 1],
        [0x80, 1],
        [0x41, 1],
        [0x01, 1],
        [0x41, 1],
        [0x82, 1],
    ] {
        assert_eq!(receive(&mut receiver, &bytes), None, "{bytes:02X?}");
    }
    // A first fragment with another count ends a message.
    assert!(receive(&mut receiver, &[0x00, 1]).is_some());
    assert_eq!(receive(&mut receiver, &[0x05, 1]), None);
    assert_eq!(receive(&mut receiver, &[0x41, 1]), None);
    assert_eq!(receiver.receive(&[]), None);
}

#[test]
fn fragment_with_another_count_ends_the_message() {
    for bytes in [[0x43, 1], [0x83, 1], [0x80, 1], [0x7F, 1]] {
        let mut receiver = Receiver::IDLE;
        receive(&mut receiver, &[0x00, 1]);
        assert_eq!(receive(&mut receiver, &bytes), None, "{bytes:02X?}");
        assert_eq!(receive(&mut receiver, &[0x81, 1]), None);
    }
}

#[test]
fn message_longer_than_consumed_size_is_refused() {
    let mut receiver = Receiver::IDLE;
    let parts = [0x00, 0x41, 0x42, 0x43, 0x44];
    for control in parts {
        let part = [control, 1, 2, 3, 4, 5, 6];
        assert_eq!(receive(&mut receiver, &part).unwrap().0[2], 0);
    }
    let last = [0x85, 1, 2];
    let mut full = Receiver { ..receiver };
    assert_eq!(receive(&mut full, &last), Some(([0x8A, 0xC5, 0], true)));
    assert_eq!(full.body().1, CONSUMED);
    let last = [0x85, 1, 2, 3];
    assert_eq!(
        receive(&mut receiver, &last),
        Some(([0x8A, 0xC5, 1], false))
    );
    assert_eq!(receive(&mut receiver, &[0x86, 1]), None);
}

#[test]
fn acknowledge_needs_a_status() {
    assert_eq!(kind(&[0xC2]), None);
    assert_eq!(kind(&[]), None);
    let (count, status) = (2, 1);
    assert_eq!(kind(&[0xC2, 1]), Some(Kind::Acknowledge { count, status }));
    assert_eq!(kind(&[0x82, 1]), Some(Kind::Part));
}

/// A sender that has sent its first fragment at the time 0.
fn sending() -> Sender {
    let mut sender = Sender::IDLE;
    sender.start(0x4A, 0x0E, Name::constant("INCLINOMETER 080 degree"));
    let first = ([0xCA, 0x00, 0x8E, 0x17, 0x49, 0x4E, 0x43, 0x4C], 8);
    assert_eq!(sender.take(at(0)), Some(first));
    assert_eq!(sender.take(at(0)), None);
    sender
}

#[test]
fn next_fragment_follows_acknowledge_of_present_one() {
    let mut sender = sending();
    sender.acknowledge(1, 0);
    assert_eq!(sender.take(at(1)), None, "another count");
    for count in 0..4 {
        sender.acknowledge(count, 0);
        let (bytes, length) = sender.take(at(1)).unwrap();
        let kind = if count == 3 { LAST } else { MIDDLE };
        assert_eq!(bytes[1], kind | (count + 1));
        assert_eq!(length, if count == 3 { 3 } else { 8 });
        sender.acknowledge(count, 0);
        assert_eq!(sender.take(at(1)), None, "acknowledged twice");
    }
    assert!(sender.is_running());
    sender.acknowledge(4, 0);
    assert!(!sender.is_running());
    assert_eq!(sender.deadline(), Deadline::NEVER);
}

#[test]
fn acknowledge_with_a_status_ends_the_message() {
    let mut sender = sending();
    sender.acknowledge(0, 1);
    assert!(!sender.is_running());
    assert_eq!(sender.take(at(1)), None);
}

#[test]
fn fragment_is_repeated_once() {
    let mut sender = sending();
    sender.poll(at(999));
    assert_eq!(sender.take(at(999)), None);
    sender.poll(at(1000));
    let (bytes, _) = sender.take(at(1000)).unwrap();
    assert_eq!(bytes[1], 0);
    sender.poll(at(1999));
    assert!(sender.is_running());
    sender.poll(at(2000));
    assert!(!sender.is_running());
    assert_eq!(sender.take(at(2000)), None);
}

#[test]
fn text_that_ends_with_a_full_fragment_has_no_empty_one() {
    let mut sender = Sender::IDLE;
    sender.start(0x0A, 0x0E, Name::constant("0123456789"));
    sender.take(at(0)).unwrap();
    sender.acknowledge(0, 0);
    let last = ([0x8A, 0x81, 0x34, 0x35, 0x36, 0x37, 0x38, 0x39], 8);
    assert_eq!(sender.take(at(0)), Some(last));
    sender.acknowledge(1, 0);
    assert!(!sender.is_running());
}
