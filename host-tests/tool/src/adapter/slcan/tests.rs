use super::*;
use std::cell::RefCell;
use std::rc::Rc;

/// A stream that answers lines as a script says.
#[derive(Default)]
struct Script {
    /// What the tool wrote.
    written: Vec<u8>,
    /// Lines and their answers; another line is answered with CR.
    answers: Vec<(&'static str, &'static [u8])>,
    pending: Vec<u8>,
    ended: bool,
}

#[derive(Clone, Default)]
struct Shared(Rc<RefCell<Script>>);

impl Stream for Shared {
    fn read(&mut self, bytes: &mut [u8], timeout: time::Duration) -> io::Result<usize> {
        let mut script = self.0.borrow_mut();
        if script.ended {
            return Err(io::ErrorKind::UnexpectedEof.into());
        }
        if script.pending.is_empty() {
            std::thread::sleep(timeout.min(time::Duration::from_millis(1)));
        }
        let count = script.pending.len().min(bytes.len());
        bytes[..count].copy_from_slice(&script.pending[..count]);
        script.pending.drain(..count);
        Ok(count)
    }

    fn write(&mut self, bytes: &[u8]) -> io::Result<()> {
        let mut script = self.0.borrow_mut();
        script.written.extend_from_slice(bytes);
        let line = String::from_utf8(bytes.to_vec()).unwrap();
        let own = script
            .answers
            .iter()
            .find(|(own, _)| line == format!("{own}\r"));
        let answer = own.map_or(&b"\r"[..], |(_, answer)| answer).to_vec();
        script.pending.extend(answer);
        Ok(())
    }
}

fn adapter(answers: &[(&'static str, &'static [u8])]) -> (Slcan<Shared>, Shared) {
    let shared = Shared::default();
    shared.0.borrow_mut().answers = answers.to_vec();
    (Slcan::new(shared.clone(), "test"), shared)
}

fn written(shared: &Shared) -> String {
    String::from_utf8(std::mem::take(&mut shared.0.borrow_mut().written)).unwrap()
}

fn give(shared: &Shared, bytes: &[u8]) {
    shared.0.borrow_mut().pending.extend_from_slice(bytes);
}

fn next(adapter: &mut Slcan<Shared>) -> Option<String> {
    let until = after(adapter.now(), millis(20));
    let received = adapter.receive(until).unwrap();
    received.map(|(_, frame)| format!("{frame:?}"))
}

#[test]
fn adapter_is_closed_before_rate_and_mode_are_set() {
    let (mut adapter, shared) = adapter(&[("C", b"\x07")]);
    adapter.open(Some(BitRate::K250), Mode::Listen).unwrap();
    assert_eq!(written(&shared), "\rC\rS5\rL\r");
    adapter.open(Some(BitRate::K62_5), Mode::Active).unwrap();
    assert_eq!(written(&shared), "\rC\rs071C\rO\r");
}

#[test]
fn adapter_without_listen_only_mode_is_never_opened() {
    let (mut adapter, shared) = adapter(&[("L", b"\x07")]);
    let failure = adapter.open(Some(BitRate::K125), Mode::Listen).unwrap_err();
    assert_eq!(failure.code, "no-listen-only");
    assert!(!written(&shared).contains('O'));
    let frame = Frame::data(standard(1), &[]).unwrap();
    assert!(adapter.send(&frame).is_err());
    assert_eq!(written(&shared), "");
}

#[test]
fn listening_adapter_sends_nothing() {
    let (mut adapter, shared) = adapter(&[]);
    adapter.open(Some(BitRate::K125), Mode::Listen).unwrap();
    written(&shared);
    assert!(
        adapter
            .send(&Frame::data(standard(1), &[]).unwrap())
            .is_err()
    );
    assert_eq!(written(&shared), "");
}

#[test]
fn rate_that_the_adapter_refuses_is_an_error() {
    let (mut adapter, _) = adapter(&[("s071C", b"\x07")]);
    let failure = adapter
        .open(Some(BitRate::K62_5), Mode::Active)
        .unwrap_err();
    assert_eq!(failure.code, "rate-refused");
}

#[test]
fn silent_port_is_no_adapter() {
    let (mut adapter, _) = adapter(&[("", b""), ("C", b""), ("S4", b"")]);
    let failure = adapter.open(Some(BitRate::K125), Mode::Active).unwrap_err();
    assert_eq!(
        (failure.code, failure.kind.exit_code()),
        ("adapter-silent", 4)
    );
}

#[test]
fn frames_are_received_between_answers_and_in_pieces() {
    let (mut adapter, shared) = adapter(&[]);
    adapter.open(None, Mode::Active).unwrap();
    give(&shared, b"z\rt3012AB");
    assert_eq!(next(&mut adapter), None);
    give(&shared, b"CD\rT1FFFFFFF0\rr1238\rt10020102000F\r");
    assert_eq!(next(&mut adapter).as_deref(), Some("301#ABCD"));
    assert_eq!(next(&mut adapter).as_deref(), Some("1FFFFFFF#"));
    assert_eq!(next(&mut adapter).as_deref(), Some("123#R8"));
    assert_eq!(
        next(&mut adapter).as_deref(),
        Some("100#0102"),
        "with a time stamp"
    );
}

#[test]
fn malformed_lines_are_ignored() {
    let (mut adapter, shared) = adapter(&[]);
    adapter.open(None, Mode::Active).unwrap();
    for line in [
        "t",
        "t30",
        "t301",
        "t3019",
        "t8000",
        "t301200",
        "t3011GG",
        "T3000000000",
        "t301+00",
        "t3011+1",
        "t30110",
        "t301100000",
        "\u{7f}\u{0}",
        "tttttttttttttttttttttttttttttttttttttttttttttttttttttttt",
        "t\u{e4}\u{e4}1100",
    ] {
        give(&shared, line.as_bytes());
        give(&shared, b"\r");
    }
    give(&shared, &[0xFF; 100]);
    give(&shared, b"\rt30111F\r");
    assert_eq!(next(&mut adapter).as_deref(), Some("301#1F"));
}

#[test]
fn refused_frame_and_lost_adapter_are_errors() {
    let (mut adapter, shared) = adapter(&[("t3001FF", b"\x07")]);
    adapter.open(None, Mode::Active).unwrap();
    adapter
        .send(&Frame::data(standard(0x300), &[0xFF]).unwrap())
        .unwrap();
    let until = after(adapter.now(), millis(20));
    assert_eq!(adapter.receive(until).unwrap_err().code, "frame-refused");
    shared.0.borrow_mut().ended = true;
    let failure = adapter.receive(until).unwrap_err();
    assert_eq!(
        (failure.code, failure.kind.exit_code()),
        ("adapter-lost", 4)
    );
}

#[test]
fn status_with_bus_error_counts_as_error() {
    let (mut noisy, _) = adapter(&[("F", b"F84\r")]);
    noisy.open(None, Mode::Listen).unwrap();
    assert_eq!(noisy.errors(), Some(1));
    let (mut quiet, _) = adapter(&[("F", b"F00\r")]);
    quiet.open(None, Mode::Listen).unwrap();
    assert_eq!(quiet.errors(), Some(0));
    let (mut silent, _) = adapter(&[("F", b"\x07")]);
    silent.open(None, Mode::Listen).unwrap();
    assert_eq!(silent.errors(), None);
}

#[test]
fn every_frame_is_written_as_it_is_read() {
    for frame in [
        Frame::data(standard(0x7FF), &[1, 2, 3, 4, 5, 6, 7, 8]),
        Frame::data(extended(0), &[]),
        Frame::remote(extended(0x1FFF_FFFF), 8),
        Frame::remote(standard(0), 0),
    ] {
        let frame = frame.unwrap();
        assert_eq!(read_frame(write_frame(&frame).as_bytes()), Some(frame));
    }
}
