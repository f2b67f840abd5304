use super::*;
use plumbline::can::{extended, standard};
use plumbline::time::{after, millis};
use std::cell::RefCell;
use std::rc::Rc;
use texts::Cause as _;

mod lines;
mod opening;

/// A stream that answers lines as a script says.
#[derive(Default)]
struct Script {
    /// What the tool wrote.
    written: Vec<u8>,
    /// Lines and their answers; another line is answered with CR.
    answers: Vec<(&'static str, &'static [u8])>,
    pending: Vec<u8>,
    /// Pieces that come before it, one in each read.
    pieces: VecDeque<&'static [u8]>,
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
        if let Some(piece) = script.pieces.pop_front() {
            bytes[..piece.len()].copy_from_slice(piece);
            return Ok(piece.len());
        }
        if script.pending.is_empty() {
            let step = time::Duration::from_millis(1);
            std::thread::sleep(timeout.min(step));
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
    let mut adapter = Slcan::new(shared.clone(), "test");
    // A stream of pieces or without an answer is waited for until the end of this time; the others answer at once.
    let answers_all = answers
        .iter()
        .all(|(_, answer)| answer.ends_with(b"\r") || answer.ends_with(b"\x07"));
    adapter.patience = time::Duration::from_millis(if answers_all { 5000 } else { 300 });
    (adapter, shared)
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
fn adapter_without_listen_only_mode_is_never_opened() {
    let (mut adapter, shared) = adapter(&[("L", b"\x07")]);
    let failure = adapter.open(Some(BitRate::K125), Mode::Listen).unwrap_err();
    assert_eq!(failure.code(), "no-listen-only");
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
    assert_eq!(failure.code(), "rate-refused");
}

#[test]
fn port_that_does_not_answer_is_not_an_adapter() {
    let (mut adapter, _) = adapter(&[("C", b"")]);
    let failure = adapter.open(Some(BitRate::K125), Mode::Active).unwrap_err();
    assert_eq!(
        (failure.code(), failure.kind().exit_code()),
        ("adapter-silent", 4)
    );
}

#[test]
fn port_of_another_service_is_not_an_adapter() {
    for (command, text, said) in [
        (
            "C",
            &b"HTTP/1.1 400 Bad Request\r\nConnection: close\r\n\r\n"[..],
            "HTTP/1.1 400 Bad Request",
        ),
        // A terminal repeats what was typed.
        ("C", b"C\r\n-sh: C: not found\r\n", "-sh: C: not found"),
        ("C", b"220 mail.example\r\n", "220 mail.example"),
        ("S4", b"Not Found\r", "Not Found"),
        ("O", b"ERROR\r", "ERROR"),
        ("O", b"\xFF\xFE\x01\r", ""),
    ] {
        let (mut adapter, _) = adapter(&[(command, text)]);
        let failure = adapter.open(Some(BitRate::K125), Mode::Active).unwrap_err();
        let code = (failure.code(), failure.kind().exit_code());
        assert_eq!(code, ("no-adapter", 4), "{said}: {failure}");
        assert!(failure.to_string().contains(said), "{failure}");
    }
}

#[test]
fn frames_and_answers_to_other_commands_are_no_answers() {
    // Another program has left the channel open on a busy bus.
    let busy = b"0102\rt3012ABCD\rF00\rV1013\rNA123\rsa000000\re2bo\rt10020102000F\r\r";
    for (answers, code) in [
        (&[("C", &busy[..])][..], None),
        (&[("C", b"\x07"), ("S4", b"t1238010203\rz\r\r")], None),
        (&[("L", b"T1FFFFFFF0\rr1238\rABt30111F\r\r")], None),
        (&[("S4", b"t30111F\r\x07")], Some("rate-refused")),
        (&[("L", b"V1013\rF00\r\x07")], Some("no-listen-only")),
        // No other line is an answer.
        (
            &[("L", b"t30111F\rV1013\rF00\rz\r")],
            Some("adapter-silent"),
        ),
    ] {
        let (mut adapter, _) = adapter(answers);
        if code == Some("adapter-silent") {
            // It waits until the end of this time.
            adapter.patience = time::Duration::from_millis(300);
        }
        let opened = adapter.open(Some(BitRate::K125), Mode::Listen);
        assert_eq!(
            opened.err().map(|failure| failure.code()),
            code,
            "{answers:?}"
        );
    }
    let (mut adapter, _) = adapter(&[("F", b"t30111F\r0A\rV1013\rF80\r")]);
    adapter.open(None, Mode::Listen).unwrap();
    assert_eq!(adapter.errors(), Some(1));
    assert_eq!(next(&mut adapter).as_deref(), Some("301#1F"));
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
    // A late call still reads the frames that have arrived.
    let past = adapter.now();
    assert_eq!(adapter.receive(past).unwrap_err().code(), "frame-refused");
    shared.0.borrow_mut().ended = true;
    let failure = adapter.receive(past).unwrap_err();
    assert_eq!(
        (failure.code(), failure.kind().exit_code()),
        ("adapter-lost", 4)
    );
}

#[test]
fn refused_frame_is_noticed_after_frames_that_were_answered_with_cr() {
    let (mut adapter, _) = adapter(&[("t3000", b"\x07")]);
    adapter.open(None, Mode::Active).unwrap();
    for id in [0x100, 0x101, 0x300] {
        adapter
            .send(&Frame::data(standard(id), &[]).unwrap())
            .unwrap();
    }
    let now = adapter.now();
    assert_eq!(adapter.receive(now).unwrap_err().code(), "frame-refused");
}

#[test]
fn frame_that_has_arrived_is_received_after_the_time_out() {
    let (mut adapter, shared) = adapter(&[]);
    adapter.open(None, Mode::Active).unwrap();
    give(&shared, b"t30111F\r");
    let past = adapter.now();
    let received = adapter.receive(past).unwrap();
    assert_eq!(
        received.map(|(_, frame)| format!("{frame:?}")).as_deref(),
        Some("301#1F")
    );
}

#[test]
fn bus_time_is_the_time_of_the_server() {
    let (adapter, shared) = adapter(&[("@0", b"@100\r"), ("@3E8", b"#2A0\rt30111F\r@2C8\r")]);
    let mut adapter = adapter.in_bus_time().unwrap();
    assert_eq!(
        adapter.patience, ADVANCED,
        "the load of the computer has no influence"
    );
    assert_eq!(adapter.now(), Instant::from_ticks(0x100));
    adapter.open(None, Mode::Active).unwrap();
    written(&shared);
    let until = after(adapter.now(), millis(1));
    let (at, frame) = adapter.receive(until).unwrap().unwrap();
    assert_eq!(
        (at.ticks(), format!("{frame:?}")),
        (0x2A0, "301#1F".to_owned())
    );
    assert_eq!(adapter.now(), Instant::from_ticks(0x2C8));
    assert_eq!(written(&shared), "@3E8\r");
}

#[test]
fn status_with_bus_error_counts_as_error() {
    let (mut noisy, _) = adapter(&[("F", b"F84\r")]);
    noisy.open(None, Mode::Listen).unwrap();
    assert_eq!(noisy.errors(), Some(1));
    let (mut quiet, _) = adapter(&[("F", b"F00\r")]);
    quiet.open(None, Mode::Listen).unwrap();
    assert_eq!(quiet.errors(), Some(0));
    for (answer, asked) in [(&b"\x07"[..], "F\rF\r"), (b"", "F\r")] {
        let (mut other, shared) = adapter(&[("F", answer)]);
        other.open(None, Mode::Listen).unwrap();
        written(&shared);
        assert_eq!((other.errors(), other.overruns()), (None, None));
        assert_eq!(written(&shared), asked);
    }
}

#[test]
fn status_with_overrun_or_full_queue_counts_as_lost_frames() {
    for (answer, lost, errors) in [
        (&b"F08\r"[..], 1, 0),
        (b"F01\r", 1, 0),
        (b"F00\r", 0, 0),
        (b"F80\r", 0, 1),
    ] {
        let (mut adapter, _) = adapter(&[("F", answer)]);
        adapter.open(None, Mode::Listen).unwrap();
        assert_eq!(adapter.overruns(), Some(lost));
        assert_eq!(adapter.errors(), Some(2 * errors));
    }
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
