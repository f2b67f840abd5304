//! The commands that open and close the channel.

use super::Shared;
use super::{adapter, give, next, written};
use crate::slcan::Slcan;
use crate::{Adapter, Mode};
use plumbline::can::{BitRate, Frame, standard};
use std::collections::VecDeque;
use texts::Cause as _;

#[test]
fn adapter_is_closed_before_rate_and_mode_are_set() {
    let (mut adapter, shared) = adapter(&[("C", b"\x07")]);
    adapter.open(Some(BitRate::K250), Mode::Listen).unwrap();
    assert_eq!(written(&shared), "C\rC\rS5\rL\r");
    adapter.open(Some(BitRate::K62_5), Mode::Active).unwrap();
    assert_eq!(written(&shared), "C\rC\rs071C\rO\r");
}

#[test]
fn channel_is_closed_again_when_opening_failed() {
    for answers in [("L", &b"\x07"[..]), ("L", b""), ("S4", b"\x07")] {
        let (mut adapter, shared) = adapter(&[answers]);
        assert!(
            adapter.open(Some(BitRate::K125), Mode::Listen).is_err(),
            "{answers:?}"
        );
        assert!(written(&shared).ends_with("\rC\r"), "{answers:?}");
    }
}

#[test]
fn late_answer_to_close_is_not_used_as_answer_to_rate_or_mode() {
    // The answers to the incomplete line of another program and to C come one after the other, so that two come after both C.
    let (mut adapter, shared) = adapter(&[("C", b""), ("L", b"\x07")]);
    shared.0.borrow_mut().pieces = VecDeque::from([&b"\x07"[..], b"\r", b"\r", b"\r"]);
    let failure = adapter.open(Some(BitRate::K125), Mode::Listen).unwrap_err();
    assert_eq!(failure.code(), "no-listen-only");
}

#[test]
fn opening_after_listening_needs_three_commands() {
    let (mut adapter, shared) = adapter(&[]);
    let rates = [(BitRate::K250, "S5"), (BitRate::K62_5, "s071C")];
    for (rate, _) in rates.into_iter().cycle().take(80) {
        adapter.open(Some(rate), Mode::Listen).unwrap();
        give(&shared, b"t30111F\r");
        assert_eq!(next(&mut adapter).as_deref(), Some("301#1F"), "{rate:?}");
        adapter.close();
    }
    let steps = rates.iter().cycle().take(80);
    let steps: String = steps.map(|(_, own)| format!("{own}\rL\rC\r")).collect();
    assert_eq!(written(&shared), format!("C\rC\r{steps}"));
}

#[test]
fn adapter_that_has_sent_is_closed_again_before_it_is_opened() {
    let (mut adapter, shared) = adapter(&[]);
    adapter.open(Some(BitRate::K250), Mode::Active).unwrap();
    adapter
        .send(&Frame::data(standard(1), &[]).unwrap())
        .unwrap();
    adapter.close();
    written(&shared);
    adapter.open(Some(BitRate::K125), Mode::Listen).unwrap();
    assert_eq!(written(&shared), "C\rC\rS4\rL\r");
}

#[test]
fn closed_adapter_that_refuses_is_closed_and_asked_once_more() {
    let (mut adapter, shared) = adapter(&[("S4", b"\x07")]);
    adapter.open(Some(BitRate::K250), Mode::Listen).unwrap();
    adapter.close();
    written(&shared);
    let failure = adapter.open(Some(BitRate::K125), Mode::Listen).unwrap_err();
    assert_eq!(failure.code(), "rate-refused");
    assert_eq!(written(&shared), "S4\rC\rC\rS4\rC\r");
}

#[test]
fn lost_connection_is_told_from_a_lost_adapter() {
    for (name, part) in [
        ("slcan://127.0.0.1:11898", "is the server still running?"),
        ("slcan:/dev/ttyACM0", "plug it in again"),
    ] {
        let shared = Shared::default();
        let mut adapter = Slcan::new(shared.clone(), name);
        adapter.open(None, Mode::Active).unwrap();
        shared.0.borrow_mut().ended = true;
        let failure = adapter.receive(adapter.now()).unwrap_err();
        assert!(failure.to_string().contains(part), "{failure}");
    }
}

#[test]
fn frames_of_an_earlier_opening_are_forgotten() {
    let (mut adapter, shared) = adapter(&[]);
    adapter.open(None, Mode::Active).unwrap();
    give(&shared, b"t1230\rt1240\r");
    assert_eq!(next(&mut adapter).as_deref(), Some("123#"));
    adapter.open(None, Mode::Active).unwrap();
    assert_eq!(next(&mut adapter), None);
}
