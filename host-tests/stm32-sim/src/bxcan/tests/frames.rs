//! Mailboxes and FIFOs; the test generates the events of the wire.

use super::*;

#[test]
fn received_frame_is_in_fifo() {
    let mut can = on_the_bus(BTR_500K);
    can.set(IER, 1 << 1);
    let data = [0x11, 0x22, 0x33, 0x44, 0x55, 0x66];
    can.event(
        NOW,
        Event::Received(Frame::data(extended(0x1234_5678), &data).unwrap()),
    );
    assert_eq!(can.lines(), [false, true, false, false]);
    assert_eq!(can.get(RF0R), 1);
    assert_eq!(can.get(RI0R), 0x1234_5678 << 3 | 0b100);
    assert_eq!(can.get(RDT0R), 6);
    assert_eq!(can.get(RDL0R), 0x4433_2211);
    assert_eq!(can.get(RDH0R), 0x0000_6655);
    can.set(RF0R, 1 << 5);
    assert_eq!(can.get(RF0R), 0);
    assert_eq!(can.lines(), [false; 4]);
    can.get(RI0R);
    can.set(RF0R, 1 << 5);
    assert_eq!(
        can.violation_list(),
        [
            ("CAN_RI0R", "read while the FIFO is empty"),
            ("CAN_RF0R", "released while the FIFO is empty")
        ]
    );
    can.set(RI0R, 0);
    assert_eq!(can.violation_list()[2], ("CAN_RI0R", "is read-only"));
}

#[test]
fn overruns_are_counted_and_locked_fifo_keeps_oldest() {
    for (lock, last) in [(0, 5), (1 << 3, 3)] {
        let mut can = on_the_bus(BTR_500K);
        can.set(MCR, lock);
        for id in 1..=5 {
            can.event(NOW, Event::Received(frame(id)));
        }
        assert_eq!(can.overruns(), 2);
        can.set(RF0R, 1 << 5);
        can.set(RF0R, 1 << 5);
        assert_eq!(can.get(RI0R) >> 21, last);
    }
}

#[test]
fn no_frame_is_received_during_filter_initialization() {
    let mut can = on_the_bus(BTR_500K);
    can.set(FMR, 0x2A1C_0E01);
    can.event(NOW, Event::Received(frame(1)));
    assert_eq!(can.get(RF0R), 0);
}

#[test]
fn requested_frame_is_sent() {
    let mut can = on_the_bus(BTR_500K);
    can.set(IER, 1);
    assert_eq!(can.offered(), None);
    request(&mut can, 0x123);
    assert!(can.take_changed());
    assert!(!can.take_changed());
    assert_eq!(can.offered(), Frame::data(standard(0x123), &[]));
    can.event(NOW, Event::Started);
    can.event(NOW, Event::Transmitted);
    assert!(can.take_changed());
    assert_eq!(can.offered(), None);
    assert_eq!(can.lines(), [true, false, false, false]);
    can.set(TSR, 1);
    assert_eq!(can.lines(), [false; 4]);
    assert_eq!(can.get(TSR), 0x1C00_0000);
}

#[test]
fn error_sets_terr_and_keeps_frame_pending() {
    let mut can = on_the_bus(BTR_500K);
    request(&mut can, 0x123);
    can.event(NOW, Event::Started);
    let transmitting = true;
    let code = ErrorCode::Acknowledgment;
    can.event(NOW, Event::Error { code, transmitting });
    assert_eq!(can.get(ESR) >> 4 & 7, 3);
    assert_eq!(can.get(TSR) & 0xFF, 1 << 3);
    assert!(can.offered().is_some());
    // The error of another transmitter does not change the mailbox.
    can.event(NOW, Event::Started);
    let transmitting = false;
    can.event(NOW, Event::Error { code, transmitting });
    can.set(TSR, 1 << 7);
    assert_eq!(can.get(TSR) & 0x81, 0x80, "still on the wire");
    can.event(NOW, Event::Received(frame(1)));
    assert_eq!(can.get(ESR) >> 4 & 7, 0);
}

#[test]
fn error_ends_request_without_retransmission() {
    let mut can = on_the_bus(BTR_500K);
    can.set(MCR, 1 << 4);
    request(&mut can, 0x123);
    can.event(NOW, Event::Started);
    can.event(NOW, Event::LostArbitration);
    assert_eq!(can.get(TSR) & 0xFF, 0b0101);
    assert_eq!(can.offered(), None);
}

#[test]
fn no_frame_is_offered_off_the_bus_or_while_leaving() {
    let mut can = initializing(BTR_500K);
    request(&mut can, 0x123);
    assert_eq!(can.offered(), None);
    can.set(MCR, 0);
    assert_eq!(can.offered(), None);
    can.event(NOW, Event::Joined);
    assert!(can.offered().is_some());
    can.set(MCR, INRQ);
    assert_eq!(can.offered(), None);
    assert_eq!(can.violation_list(), []);
}

#[test]
fn silent_controller_sends_nothing() {
    let mut can = on_the_bus(SILM | BTR_500K);
    assert!(can.is_silent());
    request(&mut can, 0x123);
    assert_eq!(can.offered(), None);
    assert_eq!(
        can.violation_list(),
        [("CAN_TI0R", "transmission requested in silent mode")]
    );
    let mut before = initializing(SILM | BTR_500K);
    request(&mut before, 0x123);
    before.set(MCR, 0);
    assert_eq!(
        before.violation_list(),
        [("CAN_TSR", "a transmission is pending in silent mode")]
    );
}
