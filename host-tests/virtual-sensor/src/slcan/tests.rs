//! The protocol against the LAWICEL manual and the input of real drivers.

use super::*;
use embedded_can::Id;
use plumbline::can::{extended, standard};
use proptest::prelude::*;

/// A call of a port.
#[derive(Clone, PartialEq, Debug)]
enum Call {
    Open(Option<BitRate>, bool),
    Close,
    Send(Frame),
}

/// A port that records its calls and accepts `room` frames.
#[derive(Clone, PartialEq, Debug)]
struct Recorder {
    calls: Vec<Call>,
    room: usize,
}

impl Recorder {
    fn new() -> Self {
        Self {
            calls: Vec::new(),
            room: usize::MAX,
        }
    }
}

impl Port for Recorder {
    fn open(&mut self, rate: Option<BitRate>, listen_only: bool) {
        self.calls.push(Call::Open(rate, listen_only));
    }
    fn close(&mut self) {
        self.calls.push(Call::Close);
    }
    fn send(&mut self, frame: Frame) -> Result<(), QueueFull> {
        self.room = self.room.checked_sub(1).ok_or(QueueFull)?;
        self.calls.push(Call::Send(frame));
        Ok(())
    }
}

/// The answers of a new channel to `input`, and the calls of its port.
fn run(input: &[u8]) -> (Vec<u8>, Vec<Call>) {
    let (mut channel, mut port, mut answers) = (Channel::new(), Recorder::new(), Vec::new());
    channel.input(input, &mut port, &mut answers);
    (answers, port.calls)
}

/// The answer of an open channel to `line`, and the calls of its port.
fn run_open(line: &[u8]) -> (Vec<u8>, Vec<Call>) {
    let mut input = b"O\r".to_vec();
    input.extend_from_slice(line);
    input.push(b'\r');
    let (answers, mut calls) = run(&input);
    assert_eq!(calls.remove(0), Call::Open(None, false));
    (answers.strip_prefix(b"\r").unwrap().to_vec(), calls)
}

fn sent(line: &str) -> Frame {
    match run_open(line.as_bytes()) {
        (answer, calls) if answer == b"z\r" || answer == b"Z\r" => match calls[..] {
            [Call::Send(frame)] => frame,
            _ => panic!("{line}: {calls:?}"),
        },
        (answer, _) => panic!("{line}: answered {answer:?}"),
    }
}

#[track_caller]
fn assert_refused(line: &[u8]) {
    let shown = String::from_utf8_lossy(line);
    assert_eq!(run_open(line), (vec![BEL], vec![]), "open: {shown:?}");
    let mut closed = line.to_vec();
    closed.push(CR);
    assert_eq!(run(&closed), (vec![BEL], vec![]), "closed: {shown:?}");
}

#[test]
fn open_sequence_of_python_can_is_accepted() {
    assert_eq!(
        run(b"C\rS6\r\rO\rO\r"),
        (
            b"\r\r\r\r\r".to_vec(),
            vec![Call::Open(Some(BitRate::K500), false)]
        )
    );
    assert_eq!(
        run(b"C\rs031C\rO\rO\rC\r"),
        (
            b"\r\r\r\r\r".to_vec(),
            vec![Call::Open(Some(BitRate::K125), false), Call::Close]
        )
    );
    assert_eq!(run(b"L\r"), (b"\r".to_vec(), vec![Call::Open(None, true)]));
}

#[test]
fn nine_standard_rates_are_accepted() {
    use BitRate::*;
    let rates = [K10, K20, K50, K100, K125, K250, K500, K800, M1];
    for (digit, rate) in rates.into_iter().enumerate() {
        let (answers, calls) = run(format!("S{digit}\rO\r").as_bytes());
        assert_eq!(answers, b"\r\r");
        assert_eq!(calls, [Call::Open(Some(rate), false)]);
    }
}

/// The settings of the SJA1000 that CiA recommends at 16 MHz, and 62.5 kbit/s (sample point 87.5 %).
#[test]
fn registers_give_same_rates() {
    use BitRate::*;
    let settings = [
        ("311C", K10),
        ("181C", K20),
        ("091C", K50),
        ("071C", K62_5),
        ("041C", K100),
        ("031C", K125),
        ("011c", K250),
        ("001C", K500),
        ("0016", K800),
        ("0014", M1),
        // The jump width and triple sampling do not change the rate.
        ("C09C", K500),
    ];
    for (registers, rate) in settings {
        let (answers, calls) = run(format!("s{registers}\rO\r").as_bytes());
        assert_eq!(answers, b"\r\r", "{registers}");
        assert_eq!(calls, [Call::Open(Some(rate), false)], "{registers}");
    }
}

#[test]
fn settings_are_refused_while_open_and_channel_stays_open() {
    for line in ["S4", "s031C", "Z1", "Z0"] {
        assert_eq!(run_open(line.as_bytes()), (vec![BEL], vec![]), "{line}");
    }
    let (answers, calls) = run(b"S6\rO\rS4\rC\rO\r");
    assert_eq!(answers, b"\r\r\x07\r\r");
    let open = Call::Open(Some(BitRate::K500), false);
    assert_eq!(calls, [open.clone(), Call::Close, open]);
}

#[test]
fn listen_only_receives_but_does_not_send() {
    let (answers, calls) = run(b"L\rt1230\rO\rC\rO\rL\rt1230\r");
    assert_eq!(answers, b"\r\x07\x07\r\r\x07z\r");
    assert_eq!(
        calls,
        [
            Call::Open(None, true),
            Call::Close,
            Call::Open(None, false),
            Call::Send(Frame::data(standard(0x123), &[]).unwrap()),
        ]
    );
}

#[test]
fn frames_of_all_four_types_are_sent() {
    let eight = [0xDE, 0xAD, 0xBE, 0xEF, 0, 1, 2, 0xFF];
    assert_eq!(
        Some(sent("t3018DEADBEEF000102FF")),
        Frame::data(standard(0x301), &eight)
    );
    assert_eq!(Some(sent("t7fF1aB")), Frame::data(standard(0x7FF), &[0xAB]));
    assert_eq!(Some(sent("t0000")), Frame::data(standard(0), &[]));
    assert_eq!(
        Some(sent("T1FFFFFFF2BEEF")),
        Frame::data(extended(0x1FFF_FFFF), &[0xBE, 0xEF])
    );
    assert_eq!(Some(sent("T000001230")), Frame::data(extended(0x123), &[]));
    assert_eq!(Some(sent("r1238")), Frame::remote(standard(0x123), 8));
    assert_eq!(Some(sent("R000001230")), Frame::remote(extended(0x123), 0));
}

#[test]
fn answer_to_frame_depends_on_format() {
    assert_eq!(run_open(b"t1230").0, b"z\r");
    assert_eq!(run_open(b"r1230").0, b"z\r");
    assert_eq!(run_open(b"T000001230").0, b"Z\r");
    assert_eq!(run_open(b"R000001230").0, b"Z\r");
}

#[test]
fn malformed_lines_are_refused_without_effect() {
    #[rustfmt::skip]
    let lines: &[&[u8]] = &[
        b"t", b"T", b"r", b"R", b"t12", b"t123", b"T1234567", b"T00000123",
        // The length is above 8 or not a digit.
        b"t1239112233445566778899", b"t1239", b"t123A", b"t123:", b"t123/", b"r1239", b"r123F",
        // Too few digits, too many, half a byte, a ninth byte.
        b"t12321", b"t123211", b"t1232112", b"t123211223", b"t12321122334", b"t12300", b"r12301", b"r123811",
        b"R00000123000", b"t1238112233445566778899", b"T000001238112233445566778899",
        // Identifiers out of range.
        b"t8000", b"tFFF0", b"r8000", b"T200000000", b"TFFFFFFFF0", b"R200000000",
        // Not hexadecimal; a sign or a space is not a digit.
        b"t12G0", b"t+120", b"t 120", b"t1232zz11", b"t12321 22", b"t1232+1-1", b"T1234567G0",
        // Settings.
        b"S", b"S9", b"SA", b"S66", b"s", b"s031", b"s031C0", b"s03IC", b"s0000", b"sFFFF", b"s+31C",
        b"Z", b"Z2", b"Z01", b"Zx",
        // Too many characters.
        b"OO", b"O ", b"C1", b"L0", b"V1", b"N?", b"F0", b"O\0", b"\0", b"\0O",
        // LF has no special meaning; it neither ends nor begins a line.
        b"\n", b"O\n", b"\nO", b"t1230\n", b"\nt1230",
        // Unknown commands, including the filter commands.
        b"x", b"o", b"c", b"v", b"f", b"z", b"P", b"A", b"X1", b"W0", b"M00000000", b"mFFFFFFFF",
        b"\x07", b"\x7F", b"\xFF\xFE", "Ö".as_bytes(),
    ];
    for line in lines {
        assert_refused(line);
    }
}

#[test]
fn closed_channel_sends_nothing() {
    for line in ["t1230", "T000001230", "r1230", "R000001230", "F"] {
        let (answers, calls) = run(format!("{line}\rS4\rO\rC\r{line}\r").as_bytes());
        assert_eq!(answers, b"\x07\r\r\r\x07", "{line}");
        assert_eq!(
            calls,
            [Call::Open(Some(BitRate::K125), false), Call::Close],
            "{line}"
        );
    }
}

#[test]
fn too_long_line_uses_no_memory_and_gets_one_bel() {
    let (mut channel, mut port, mut answers) = (Channel::new(), Recorder::new(), Vec::new());
    for _ in 0..1000 {
        channel.input(&[b't'; 1000], &mut port, &mut answers);
    }
    assert!(answers.is_empty());
    channel.input(b"\rO\r", &mut port, &mut answers);
    assert_eq!(answers, b"\x07\r");
    assert_eq!(port.calls, [Call::Open(None, false)]);
    // One character more than the longest line, which is a valid frame.
    assert_eq!(run_open(b"T1FFFFFFF81122334455667788").0, b"Z\r");
    assert_refused(b"T1FFFFFFF811223344556677880");
}

#[test]
fn version_and_serial_number_are_answered_open_or_closed() {
    assert_eq!(run(b"V\rN\r").0, b"V1010\rN0001\r");
    assert_eq!(run_open(b"V").0, b"V1010\r");
    assert_eq!(run_open(b"N").0, b"N0001\r");
}

#[test]
fn full_queue_refuses_frame_and_sets_flag_until_read() {
    let (mut channel, mut port, mut answers) = (Channel::new(), Recorder::new(), Vec::new());
    port.room = 1;
    channel.input(b"O\rF\rt1230\rt1240\rF\rF\r", &mut port, &mut answers);
    assert_eq!(answers, b"\rF00\rz\r\x07F02\rF00\r");
    assert_eq!(port.calls.len(), 2);
}

fn heard(setup: &[u8], at_us: u64, frame: Option<Frame>) -> String {
    let (mut channel, mut lines) = (Channel::new(), Vec::new());
    channel.input(setup, &mut Recorder::new(), &mut Vec::new());
    channel.received(Instant::from_ticks(at_us), &frame.unwrap(), &mut lines);
    String::from_utf8(lines).unwrap()
}

#[test]
fn received_frames_are_sent_only_while_open() {
    let frame = Frame::data(standard(0x301), &[0x0F, 0xA0]);
    assert_eq!(heard(b"", 0, frame), "");
    assert_eq!(heard(b"S6\rZ1\r", 0, frame), "");
    assert_eq!(heard(b"O\rC\r", 0, frame), "");
    assert_eq!(heard(b"O\r", 0, frame), "t30120FA0\r");
    assert_eq!(heard(b"L\r", 0, frame), "t30120FA0\r");
    let remote = Frame::remote(standard(7), 8);
    assert_eq!(heard(b"O\r", 0, remote), "r0078\r");
    let long = Frame::data(extended(0x18EA_FFFE), &[0xAB; 8]);
    assert_eq!(heard(b"O\r", 0, long), "T18EAFFFE8ABABABABABABABAB\r");
    let remote = Frame::remote(extended(0x123), 0);
    assert_eq!(heard(b"O\r", 0, remote), "R000001230\r");
}

#[test]
fn time_stamps_are_milliseconds_within_minute() {
    let frame = Frame::data(standard(0x100), &[0x11]);
    assert_eq!(heard(b"Z1\rO\r", 0, frame), "t1001110000\r");
    assert_eq!(heard(b"Z1\rO\r", 1_999, frame), "t1001110001\r");
    assert_eq!(heard(b"Z1\rO\r", 59_999_999, frame), "t100111EA5F\r");
    assert_eq!(heard(b"Z1\rO\r", 60_000_000, frame), "t1001110000\r");
    assert_eq!(heard(b"Z1\rZ0\rO\r", 7_000, frame), "t100111\r");
    // Closing keeps the setting.
    assert_eq!(heard(b"Z1\rO\rC\rO\r", 10_000, frame), "t100111000A\r");
}

fn any_frame() -> impl Strategy<Value = Frame> {
    let id = prop_oneof![
        (0u16..0x800).prop_map(standard),
        (0u32..0x2000_0000).prop_map(extended)
    ];
    (id, any::<bool>(), prop::collection::vec(any::<u8>(), 0..=8)).prop_map(|(id, remote, data)| {
        if remote {
            Frame::remote(id, data.len()).unwrap()
        } else {
            Frame::data(id, &data).unwrap()
        }
    })
}

/// The line of a frame, built from the protocol description without the code under test.
fn line_of(frame: &Frame) -> String {
    let (kind, id) = match frame.id() {
        Id::Standard(id) => ('t', format!("{:03X}", id.as_raw())),
        Id::Extended(id) => ('T', format!("{:08X}", id.as_raw())),
    };
    let kind = match (frame.is_remote(), kind) {
        (true, 't') => 'r',
        (true, _) => 'R',
        (false, kind) => kind,
    };
    let data: String = frame.bytes().iter().map(|b| format!("{b:02X}")).collect();
    format!("{kind}{id}{}{data}", frame.dlc())
}

proptest! {
    #[test]
    fn frame_survives_round_trip(frame in any_frame(), lower in any::<bool>()) {
        let line = line_of(&frame);
        prop_assert_eq!(heard(b"O\r", 0, Some(frame)), format!("{line}\r"));
        let (kind, digits) = line.split_at(1);
        let digits = if lower { digits.to_lowercase() } else { digits.into() };
        prop_assert_eq!(sent(&format!("{kind}{digits}")), frame);
    }

    #[test]
    fn frame_line_with_missing_or_extra_digit_is_refused(frame in any_frame(), extra in "[0-9A-Fa-f]") {
        let line = line_of(&frame).into_bytes();
        let mut longer = line.clone();
        longer.extend_from_slice(extra.as_bytes());
        assert_refused(&longer);
        assert_refused(&line[..line.len() - 1]);
    }

    #[test]
    fn frame_line_with_invalid_character_is_refused(
        frame in any_frame(),
        at in 1usize..26,
        strange in any::<u8>().prop_filter("hexadecimal or CR", |b| !b.is_ascii_hexdigit() && *b != CR),
    ) {
        let mut line = line_of(&frame).into_bytes();
        let at = 1 + at % (line.len() - 1);
        line[at] = strange;
        assert_refused(&line);
    }

    #[test]
    fn each_line_gets_one_answer_for_any_fragmentation(
        input in prop::collection::vec(prop_oneof![
            3 => Just(CR), 10 => prop::sample::select(b"OLCSsZVNFtTrR0123468Ff".to_vec()), 1 => any::<u8>(),
        ], 0..200),
        piece in 1usize..20,
    ) {
        let (mut channel, mut port, mut answers) = (Channel::new(), Recorder::new(), Vec::new());
        for piece in input.chunks(piece) {
            channel.input(piece, &mut port, &mut answers);
        }
        let ends = |bytes: &[u8]| bytes.iter().filter(|b| matches!(**b, CR | BEL)).count();
        prop_assert_eq!(ends(&answers), input.iter().filter(|b| **b == CR).count());
        prop_assert_eq!((answers, port.calls), run(&input));
    }

    #[test]
    fn refused_line_changes_nothing(
        line in prop::collection::vec(any::<u8>().prop_filter("CR", |b| *b != CR), 0..40),
        setup in prop::sample::select(vec!["", "S4\r", "Z1\r", "O\r", "S8\rL\r", "Z1\rO\r"]),
    ) {
        let (mut channel, mut port, mut answers) = (Channel::new(), Recorder::new(), Vec::new());
        channel.input(setup.as_bytes(), &mut port, &mut answers);
        let before = (format!("{channel:?}"), port.clone());
        answers.clear();
        channel.input(&line, &mut port, &mut answers);
        channel.input(b"\r", &mut port, &mut answers);
        if answers == [BEL] {
            prop_assert_eq!((format!("{channel:?}"), port), before);
        }
    }
}
