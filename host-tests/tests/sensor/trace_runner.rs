//! Tests that the replay of a trace finds every kind of difference.
#![cfg(target_os = "linux")]

use bench::NodeType;
use bench::motion::Motion;
use bench::script::{self, FIXED, LEVEL};
use host_tests::trace::{Difference, Failure, Trace};

/// The scripted node 1: the boot-up frame `101#FF00` with a blank memory, echoes, saves.
///
/// At 250 kbit/s a bit takes 4 us. A node that starts waits for 11 recessive bits. The frames have 65 (101#FF00), 55 (201#01) and
/// 56 (301#01) bits.
const GOOD: &str = "\
# origin: written for this test
# model: fixed
# bitrate: 250000
# tolerance-us: 20

(0.000304) can0 101#FF00 R
# -- Two echoes.
(0.100000) can0 201#01 T
(0.100456) can0 301#01 R
(0.200000) can0 201#0102 T
(0.200524) can0 301#0102 R
";

fn level(_: &NodeType, text: &str) -> Result<Box<dyn Motion>, String> {
    match text {
        "tilt=0,0" => Ok(Box::new(LEVEL)),
        _ => Err("only level".to_owned()),
    }
}

fn replay(text: &str) -> Result<(), Failure> {
    let trace: Trace = text.parse().map_err(Failure::Trace)?;
    trace.replay(&FIXED, &level)
}

fn difference(text: &str) -> Difference {
    match replay(text) {
        Err(Failure::Differs(difference)) => difference,
        other => panic!("{other:?}"),
    }
}

/// The marked line of the output; there must be exactly one.
fn marked(text: &str) -> String {
    let difference = difference(text);
    assert_eq!(difference.count(), 1, "{difference}");
    let shown = difference.to_string();
    let marked: Vec<&str> = shown.lines().filter(|line| line.starts_with('!')).collect();
    assert_eq!(marked.len(), 1, "{shown}");
    marked[0].split_whitespace().collect::<Vec<_>>().join(" ")
}

/// The text without the frames of the sensor.
fn stripped(text: &str) -> String {
    let lines = text.lines().filter(|line| !line.ends_with(" R"));
    lines.map(|line| format!("{line}\n")).collect()
}

fn recorded(text: &str) -> String {
    Trace::record(text, &FIXED, &level).expect("a trace")
}

#[test]
fn recording_adds_the_frames_of_the_sensor() {
    assert_eq!(recorded(&stripped(GOOD)), GOOD);
}

#[test]
fn recording_replaces_wrong_frames_and_keeps_the_time_of_right_ones() {
    let right = GOOD.replace("0.100456", "0.100450");
    assert_eq!(recorded(&right), right);
    let wrong = GOOD.replace("301#01 R", "301#02 R");
    assert_eq!(recorded(&wrong), GOOD);
    let late = GOOD.replace("0.100456", "0.100500");
    assert_eq!(recorded(&late), GOOD);
    let more = GOOD.replace("# -- Two", "(0.090000) can0 301#77 R\n# -- Two");
    assert_eq!(recorded(&more), GOOD);
}

#[test]
fn recorded_action_acts_after_the_reply() {
    let text = GOOD.replace("(0.2000", "# power-cycle\n(0.2000");
    let with_action = recorded(&stripped(&text));
    let again = "(0.100456) can0 301#01 R\n# power-cycle\n(0.100760) can0 101#FF00 R\n";
    assert!(with_action.contains(again), "{with_action}");
    replay(&with_action).unwrap_or_else(|failure| panic!("{failure}"));
}

#[test]
fn matching_trace_passes() {
    replay(GOOD).unwrap_or_else(|failure| panic!("{failure}"));
}

#[test]
fn wrong_byte_is_reported() {
    let text = GOOD.replace("(0.100456) can0 301#01 R", "(0.100456) can0 301#03 R");
    assert_eq!(marked(&text), "! 9 0.100456 301#03 0.100456 301#01 wrong");
}

#[test]
fn wrong_identifier_format_or_length_is_reported() {
    for wrong in ["00000301#01", "301#0100", "301#", "301#R1", "302#01"] {
        let text = GOOD.replace("301#01 R", &format!("{wrong} R"));
        assert!(marked(&text).ends_with("wrong"), "{wrong}");
    }
}

#[test]
fn missing_frame_is_reported() {
    let text = GOOD.replace("(0.2000", "(0.150000) can0 301#01 R\n(0.2000");
    assert_eq!(marked(&text), "! 10 0.150000 301#01 - missing");
}

#[test]
fn extra_frame_is_reported() {
    let text = GOOD.replace("(0.100456) can0 301#01 R\n", "");
    assert_eq!(marked(&text), "! - 0.100456 301#01 not expected");
    let text = GOOD.replace("(0.200524) can0 301#0102 R\n", "(0.300000) can0 7FF# T\n");
    assert_eq!(marked(&text), "! - 0.200524 301#0102 not expected");
}

#[test]
fn late_frame_and_early_frame_are_reported() {
    let text = GOOD.replace("0.100456", "0.100435");
    assert_eq!(
        marked(&text),
        "! 9 0.100435 301#01 0.100456 301#01 21 us late"
    );
    let text = GOOD.replace("0.100456", "0.100477");
    assert!(marked(&text).ends_with("21 us early"));
    for within in ["0.100436", "0.100476"] {
        replay(&GOOD.replace("0.100456", within)).unwrap();
    }
}

#[test]
fn tolerance_between_frames_is_that_of_the_frames_after_it() {
    let late = GOOD.replace("0.100456", "0.100435");
    let before = late.replace("# -- Two echoes.", "# tolerance-us: 30");
    replay(&before).unwrap_or_else(|failure| panic!("{failure}"));
    let restored = before.replace("(0.200000)", "# tolerance-us: 20\n(0.200000)");
    replay(&restored).unwrap_or_else(|failure| panic!("{failure}"));
    let behind = late.replace("(0.200000)", "# tolerance-us: 30\n(0.200000)");
    assert!(marked(&behind).ends_with("21 us late"));
}

#[test]
fn frames_in_another_order_are_reported() {
    let swapped = GOOD
        .replace("301#01 R", "301#x R")
        .replace("301#0102 R", "301#01 R")
        .replace("301#x R", "301#0102 R");
    assert_eq!(difference(&swapped).count(), 2);
}

#[test]
fn difference_shows_the_frames_of_the_tester() {
    let shown = difference(&GOOD.replace("301#0102 R", "301#0103 R")).to_string();
    let expected = "  line  expected                                received
   ...
     9     0.100456 301#01                         0.100456 301#01
    10     0.200000 201#0102 (sent)
!   11     0.200524 301#0103                       0.200524 301#0102                    wrong
";
    assert_eq!(shown, expected, "\n{shown}");
}

/// A save of 07h takes 28 half-words of 52 us after its frame of 64 bits; the reply has 55 bits.
const SAVED: &str = "\
# origin: written for this test
# model: fixed
# bitrate: 250000
# tolerance-us: 2000
(0.000304) can0 101#FF00 R
(0.100000) can0 201#0207 T
(0.101932) can0 301#00 R
";

#[test]
fn power_cycle_keeps_the_saved_value() {
    replay(&format!(
        "{SAVED}# power-cycle\n(0.102248) can0 101#0700 R\n"
    ))
    .unwrap();
    let lost = format!("{SAVED}# power-cycle\n(0.102248) can0 101#FF00 R\n");
    assert!(marked(&lost).ends_with("wrong"));
}

#[test]
fn corrupted_newest_record_is_not_loaded() {
    replay(&format!(
        "{SAVED}# corrupt newest-image\n# power-cycle\n(0.102248) can0 101#FF01 R\n"
    ))
    .unwrap();
    let nothing = "# origin: x\n# model: fixed\n# corrupt newest-image\n";
    let failure = replay(nothing).unwrap_err();
    assert_eq!(
        failure.to_string(),
        "line 3: no record has been written yet"
    );
}

#[test]
fn failing_writes_make_a_save_fail_until_they_work_again() {
    replay(&format!(
        "{SAVED}# fail-writes on
(0.200000) can0 201#0208 T
(0.200500) can0 301#FF R
# fail-writes off
(0.300000) can0 201#0209 T
(0.301932) can0 301#00 R
# power-cycle
(0.302248) can0 101#0900 R
"
    ))
    .unwrap();
}

#[test]
fn sensor_with_automatic_detection_is_set_to_the_bit_rate_of_the_trace() {
    let text = "\
# origin: written for this test
# model: detecting
# bitrate: 62500
# tolerance-us: 200
(0.100000) can0 7FF#R4 T
(0.101936) can0 101#FF00 R
";
    let trace: Trace = text.parse().unwrap();
    trace.replay(&script::DETECTING, &level).unwrap();
}

#[test]
fn error_in_a_trace_is_reported_with_its_line() {
    let head = "# origin: x\n# model: fixed\n";
    for (text, message) in [
        (
            "# model: fixed\n".to_owned(),
            "the line \"# origin: ...\" is missing",
        ),
        (
            "# origin: x\n".to_owned(),
            "the line \"# model: ...\" is missing",
        ),
        (
            format!("{head}# powercycle\n"),
            "line 3: neither a comment nor an action nor a property: # powercycle",
        ),
        (
            format!("{head}# speed: 1\n"),
            "line 3: unknown property: # speed: 1",
        ),
        (
            format!("{head}# bitrate: 300000\n"),
            "line 3: not one of the ten bit rates: # bitrate: 300000",
        ),
        (
            format!("{head}(0.100000) can0 7FF# T\n# serial: 1\n"),
            "line 4: this must be before the first frame: # serial: 1",
        ),
        (
            format!("{head}(0.100000) can0 7FF#\n"),
            "line 3: the direction T or R is missing at the end: (0.100000) can0 7FF#",
        ),
        (
            format!("{head}(0.200000) can0 7FF# T\n(0.100000) can0 7FF# T\n"),
            "line 4: the time is less than in the line before: (0.100000) can0 7FF# T",
        ),
        (
            format!("{head}(0.200000) can0 7FF##1 T\n"),
            "line 3: not a classic data or remote frame: (0.200000) can0 7FF##1 T",
        ),
        (format!("{head}# scene: upside down\n"), "only level"),
    ] {
        assert_eq!(replay(&text).unwrap_err().to_string(), message);
    }
    assert!(replay(&format!("{head}(0.2) can0 7FF# T\n")).is_err());
    assert!(replay(&format!("{head}(0.200000) can0 7FF#1 T\n")).is_err());
}
