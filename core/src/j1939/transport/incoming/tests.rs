//! Tests of the messages to this node.

use super::*;

const PGN: Pgn = 0xFED8;
const MESSAGE: [u8; 9] = [1, 2, 3, 4, 5, 6, 7, 8, 9];
const FIRST: [u8; 8] = [1, 1, 2, 3, 4, 5, 6, 7];
const SECOND: [u8; 8] = [2, 8, 9, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF];
const TO_ALL: Sender = to_all(0x21);
const TO_US: Sender = to_us(0x21);

const fn to_all(source: u8) -> Sender {
    Sender {
        source,
        addressed: false,
    }
}

const fn to_us(source: u8) -> Sender {
    Sender {
        source,
        addressed: true,
    }
}

fn at(ms: u64) -> Instant {
    Instant::from_ticks(ms * 1000)
}

fn bam(pgn: Pgn) -> (Control, Pgn) {
    let control = Control::Broadcast {
        size: 9,
        packets: 2,
    };
    (control, pgn)
}

fn rts(limit: u8) -> (Control, Pgn) {
    let control = Control::RequestToSend {
        size: 9,
        packets: 2,
        limit,
    };
    (control, PGN)
}

fn answer(control: Control) -> Reaction {
    Reaction::Answer(Packet::control(0x21, control, PGN))
}

fn cts(count: u8, next: u8) -> Reaction {
    answer(Control::ClearToSend { count, next })
}

fn begun(sender: Sender, control: (Control, Pgn)) -> Incoming<9> {
    let mut incoming = Incoming::IDLE;
    incoming.control(at(0), sender, control, PGN);
    incoming
}

#[test]
fn message_to_all_is_received_between_messages_of_others() {
    let mut incoming = Incoming::<9>::IDLE;
    for source in 0..100 {
        let other = incoming.control(at(0), to_all(source), bam(0xFECA), PGN);
        assert_eq!(other, Reaction::None);
    }
    incoming.control(at(0), TO_ALL, bam(PGN), PGN);
    incoming.data(at(10), to_all(0x22), FIRST, PGN);
    assert_eq!(incoming.data(at(20), TO_ALL, FIRST, PGN), Reaction::None);
    incoming.data(at(30), to_all(0x22), SECOND, PGN);
    let complete = incoming.data(at(40), TO_ALL, SECOND, PGN);
    assert_eq!(complete, Reaction::Complete(None));
    assert_eq!(incoming.message(), MESSAGE);
    let repeated = incoming.data(at(50), TO_ALL, SECOND, PGN);
    assert_eq!(repeated, Reaction::None);
}

#[test]
fn message_to_us_is_acknowledged() {
    let mut incoming = Incoming::IDLE;
    assert_eq!(incoming.control(at(0), TO_US, rts(255), PGN), cts(2, 1));
    assert_eq!(incoming.data(at(1), TO_US, FIRST, PGN), Reaction::None);
    let end = Control::End {
        size: 9,
        packets: 2,
    };
    let end = Packet::control(0x21, end, PGN);
    let complete = incoming.data(at(2), TO_US, SECOND, PGN);
    assert_eq!(complete, Reaction::Complete(Some(end)));
    assert_eq!(incoming.message(), MESSAGE);
}

#[test]
fn sender_limits_the_packets_of_a_request() {
    let mut incoming = Incoming::<15>::IDLE;
    let control = Control::RequestToSend {
        size: 15,
        packets: 3,
        limit: 1,
    };
    let granted = incoming.control(at(0), TO_US, (control, PGN), PGN);
    assert_eq!(granted, cts(1, 1));
    assert_eq!(incoming.data(at(1), TO_US, FIRST, PGN), cts(1, 2));
    let second = [2, 8, 9, 10, 11, 12, 13, 14];
    assert_eq!(incoming.data(at(2), TO_US, second, PGN), cts(1, 3));
    let complete = incoming.data(at(3), TO_US, [3, 15, 0, 0, 0, 0, 0, 0], PGN);
    assert!(matches!(complete, Reaction::Complete(Some(_))));
    let bytes: [u8; 15] = core::array::from_fn(|place| place as u8 + 1);
    assert_eq!(incoming.message(), bytes);
}

#[test]
fn other_messages_to_us_are_aborted() {
    let mut incoming = Incoming::<9>::IDLE;
    let refused = answer(Control::Abort(2));
    for (size, packets) in [(10, 2), (8, 2), (9, 1), (9, 3)] {
        let control = Control::RequestToSend {
            size,
            packets,
            limit: 255,
        };
        assert_eq!(incoming.control(at(0), TO_US, (control, PGN), PGN), refused);
    }
    let (control, _) = rts(255);
    let other = incoming.control(at(0), TO_US, (control, 0xFECA), PGN);
    let abort = Packet::control(0x21, Control::Abort(2), 0xFECA);
    assert_eq!(other, Reaction::Answer(abort));
    for source in 1..=3 {
        incoming.control(at(0), to_us(source), rts(255), PGN);
    }
    let busy = incoming.control(at(0), TO_US, rts(255), PGN);
    assert_eq!(busy, answer(Control::Abort(1)));
}

#[test]
fn request_for_another_group_does_not_end_a_transfer() {
    let mut incoming = begun(TO_US, rts(255));
    incoming.data(at(1), TO_US, FIRST, PGN);
    let (control, _) = rts(255);
    let other = incoming.control(at(2), TO_US, (control, 0xFEEB), PGN);
    let abort = Packet::control(0x21, Control::Abort(2), 0xFEEB);
    assert_eq!(other, Reaction::Answer(abort));
    let complete = incoming.data(at(3), TO_US, SECOND, PGN);
    assert!(matches!(complete, Reaction::Complete(Some(_))));
    assert_eq!(incoming.message(), MESSAGE);
}

#[test]
fn wrong_packet_number_ends_the_transfer() {
    let mut incoming = begun(TO_ALL, bam(PGN));
    assert_eq!(incoming.data(at(1), TO_ALL, SECOND, PGN), Reaction::None);
    assert_eq!(incoming.data(at(2), TO_ALL, FIRST, PGN), Reaction::None);
    assert_eq!(incoming.data(at(3), TO_ALL, SECOND, PGN), Reaction::None);
    let mut incoming = begun(TO_US, rts(255));
    incoming.data(at(1), TO_US, FIRST, PGN);
    let repeated = incoming.data(at(2), TO_US, FIRST, PGN);
    assert_eq!(repeated, answer(Control::Abort(7)));
    assert_eq!(incoming.data(at(3), TO_US, SECOND, PGN), Reaction::None);
}

#[test]
fn transfer_ends_after_t1_and_t2() {
    let mut incoming = begun(TO_ALL, bam(PGN));
    assert_eq!(incoming.deadline().time(), Some(at(750)));
    assert_eq!(incoming.poll(at(750), PGN), None);
    assert!(!incoming.deadline().is_set());
    let mut incoming = begun(TO_US, rts(255));
    assert_eq!(incoming.poll(at(1249), PGN), None);
    let abort = Packet::control(0x21, Control::Abort(3), PGN);
    assert_eq!(incoming.poll(at(1250), PGN), Some(abort));
    assert_eq!(incoming.data(at(1251), TO_US, FIRST, PGN), Reaction::None);
    let mut incoming = begun(TO_US, rts(255));
    incoming.data(at(1000), TO_US, FIRST, PGN);
    assert_eq!(incoming.deadline().time(), Some(at(1750)));
}

#[test]
fn sender_ends_or_repeats_its_transfer() {
    let mut incoming = begun(TO_US, rts(255));
    incoming.control(at(1), TO_US, (Control::Abort(1), PGN), PGN);
    assert_eq!(incoming.data(at(2), TO_US, FIRST, PGN), Reaction::None);
    let mut incoming = begun(TO_ALL, bam(PGN));
    incoming.data(at(1), TO_ALL, FIRST, PGN);
    incoming.control(at(2), TO_ALL, bam(PGN), PGN);
    incoming.data(at(3), TO_ALL, FIRST, PGN);
    let complete = incoming.data(at(4), TO_ALL, SECOND, PGN);
    assert_eq!(complete, Reaction::Complete(None));
    assert_eq!(incoming.message(), MESSAGE);
    // Another message of the same sender.
    let mut incoming = begun(TO_ALL, bam(PGN));
    incoming.control(at(2), TO_ALL, bam(0xFECA), PGN);
    assert!(!incoming.deadline().is_set());
}

#[test]
fn timed_out_transfer_ignores_packets_before_the_poll() {
    let mut incoming = begun(TO_ALL, bam(PGN));
    incoming.control(at(0), to_all(0x22), bam(PGN), PGN);
    incoming.control(at(0), to_us(0x23), rts(255), PGN);
    incoming.data(at(1), to_us(0x23), FIRST, PGN);
    let abort = Packet::control(0x23, Control::Abort(3), PGN);
    for sender in [to_all(0x21), to_all(0x22), to_us(0x23)] {
        let late = incoming.data(at(751), sender, FIRST, PGN);
        assert_eq!(late, Reaction::None);
    }
    // The transfers to all have left their room.
    for source in [0x24, 0x25] {
        let granted = incoming.control(at(751), to_us(source), rts(255), PGN);
        assert!(
            granted != Reaction::Answer(Packet::control(source, Control::Abort(1), PGN)),
            "{source:02X}h"
        );
    }
    assert_eq!(incoming.poll(at(751), PGN), Some(abort));
    assert_eq!(incoming.poll(at(751), PGN), None);
}
