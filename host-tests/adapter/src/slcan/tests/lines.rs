//! The forms of lines: their ends, other first letters, and what cannot be read.

use super::{adapter, give, next};
use crate::{Adapter, Mode};
use plumbline::can::BitRate;
use texts::Cause as _;

#[test]
fn frames_are_received_with_each_end_of_a_line() {
    for end in ["\r", "\n", "\r\n", "\r\r\n", "\r\r\r\n", " \r\n"] {
        let (mut adapter, shared) = adapter(&[]);
        adapter.open(None, Mode::Active).unwrap();
        for id in 0x100..0x120 {
            let line = format!("t{id:X}11F{end}");
            // The first in one piece, the others in two: an end arrives in parts.
            let (start, rest) = line.split_at(if id == 0x100 { line.len() } else { 7 });
            give(&shared, start.as_bytes());
            let early = next(&mut adapter);
            give(&shared, rest.as_bytes());
            let received = early.or_else(|| next(&mut adapter));
            assert_eq!(received, Some(format!("{id:X}#1F")), "{end:?}");
        }
        let unread = adapter.unread().unwrap();
        assert_eq!(unread.count(), 0, "{end:?}");
    }
}

#[test]
fn empty_line_at_the_end_of_a_frame_is_no_answer() {
    for (answer, code) in [
        (&b"t30111F\r\r\n\x07"[..], Some("no-listen-only")),
        (b"t30111F\r\nt30111F\r\r\n\x07", Some("no-listen-only")),
        (b"t30111F\r\r\n", Some("adapter-silent")),
        (b"t30111F\r\r\n\r\r\n", None),
        (b"t30111F\r\n\r\n", None),
        (b"t30111F\r\n\r", None),
        (b"t30111F\r\r", None),
        (b"\r\n", None),
        (b"\n", None),
    ] {
        let (mut adapter, _) = adapter(&[("L", answer)]);
        if code == Some("adapter-silent") {
            adapter.patience = std::time::Duration::from_millis(300);
        }
        let opened = adapter.open(Some(BitRate::K125), Mode::Listen);
        let text = answer.escape_ascii();
        assert_eq!(opened.err().map(|failure| failure.code()), code, "{text}");
    }
}

#[test]
fn frame_of_29_bits_with_the_letter_x_is_received() {
    let (mut adapter, shared) = adapter(&[]);
    adapter.open(None, Mode::Active).unwrap();
    give(&shared, b"x18EA8021300EE00\rx1FFFFFFF01A2B\rt30111F\r");
    for frame in ["18EA8021#00EE00", "1FFFFFFF#", "301#1F"] {
        assert_eq!(next(&mut adapter).as_deref(), Some(frame));
    }
    assert_eq!(adapter.unread().unwrap().count(), 0);
}

#[test]
fn lines_that_cannot_be_read_are_counted_and_the_first_is_quoted() {
    let unclear = [
        "x300100",
        "xFFFFFFFF0",
        "y18EA8021300EE00",
        "D18EA80219",
        "t3011",
        "t3019FF",
        "11F",
        "hello",
        "t30111Ft30211F",
        "[1234]",
    ];
    let (mut adapter, shared) = adapter(&[]);
    adapter.open(None, Mode::Active).unwrap();
    for line in unclear {
        give(&shared, format!("{line}\rt30111F\rz\rF00\r\r").as_bytes());
        assert_eq!(next(&mut adapter).as_deref(), Some("301#1F"), "{line}");
    }
    assert_eq!(next(&mut adapter), None);
    let unread = adapter.unread().unwrap();
    assert_eq!((unread.count(), unread.first().as_str()), (10, "x300100"));
}

#[test]
fn pieces_of_frames_before_the_channel_is_open_are_not_counted() {
    let busy = b"0102\rAB18EA\rD18EA80219\rt30111\r\r";
    let (mut adapter, _) = adapter(&[("C", busy), ("S4", busy), ("L", busy)]);
    adapter.open(Some(BitRate::K125), Mode::Listen).unwrap();
    assert_eq!(adapter.unread().unwrap().count(), 0);
}
