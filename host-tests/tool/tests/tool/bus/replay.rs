//! `replay`: the frames of a log, at their times.

use super::rig::{Rig, file};
use can_wire::text::frame;
use plumbline_tool::counted::Frames;
use std::path::PathBuf;

/// A log with this text.
fn log(name: &str, text: &str) -> PathBuf {
    let path = file(name);
    std::fs::write(&path, text).unwrap();
    path
}

/// A bus with a sensor that acknowledges and sends nothing by itself.
fn rig() -> Rig {
    let mut rig = Rig::with("jn2101");
    rig.rate = Some("125");
    rig
}

const LOG: &str = "(1700000000.100000) can0 123#01\n(1700000000.150000) can0 124#01\n(1700000000.250000) can0 18EAFFFE#00EE00\n(1700000000.400000) can0 123#02\n";

/// The frames on the bus with the time in ms after the first one, in steps of 5 ms.
fn replayed(rig: &mut Rig) -> Vec<(u64, String)> {
    let witnessed = rig.witnessed_at();
    let start = witnessed.first().map_or(0, |(at, _)| at.ticks());
    let witnessed = witnessed.into_iter();
    let rounded = |us: u64| (us + 2500) / 5000 * 5;
    witnessed
        .map(|(at, frame)| (rounded(at.ticks() - start), format!("{frame:?}")))
        .collect()
}

fn expected(frames: &[(u64, &str)]) -> Vec<(u64, String)> {
    let frames = frames.iter();
    frames.map(|(at, text)| (*at, (*text).to_owned())).collect()
}

#[test]
fn frames_of_a_log_have_their_spacing() {
    let mut rig = rig();
    let path = log("replay.log", LOG);
    let documents = file("replay.json");
    let text = rig.tool(&format!("--json decode {}", path.display())).out;
    std::fs::write(&documents, text).unwrap();
    let all = [
        (0, "123#01"),
        (50, "124#01"),
        (150, "18EAFFFE#00EE00"),
        (300, "123#02"),
    ];
    for (path, options, frames) in [
        (&path, "", &all[..]),
        (&documents, "", &all),
        (
            &path,
            "--speed 0.5",
            &[
                (0, "123#01"),
                (100, "124#01"),
                (300, "18EAFFFE#00EE00"),
                (600, "123#02"),
            ],
        ),
        (
            &path,
            "--speed 2",
            &[
                (0, "123#01"),
                (25, "124#01"),
                (75, "18EAFFFE#00EE00"),
                (150, "123#02"),
            ],
        ),
        (&path, "--filter 123", &[(0, "123#01"), (300, "123#02")]),
        (&path, "--filter request", &[(0, "18EAFFFE#00EE00")]),
        (&path, "--seconds 0.2", &all[..3]),
        // The mean gap is 100 ms.
        (
            &path,
            "--filter 123,124 --loop --seconds 0.7",
            &[
                (0, "123#01"),
                (50, "124#01"),
                (300, "123#02"),
                (450, "123#01"),
                (500, "124#01"),
            ],
        ),
        (
            &path,
            "--filter 124 --loop --seconds 0.25",
            &[(0, "124#01"), (100, "124#01"), (200, "124#01")],
        ),
    ] {
        let ended = rig.tool(&format!("replay {} {options}", path.display()));
        assert_eq!(ended.code, 0, "{options}: {ended:?}");
        assert_eq!(replayed(&mut rig), expected(frames), "{options}");
        let told = format!("sent {} at 125 kbit/s\n", Frames::from(frames.len()));
        assert_eq!(ended.out, told, "{options}");
    }
    let ended = rig.tool(&format!("replay {}", path.display()));
    let told = format!("sends 4 frames of {} in 0.3 s\n", path.display());
    assert!(ended.notes.contains(&told), "{ended:?}");
    assert_eq!(rig.questions.len(), 0);
}

#[test]
fn frames_of_a_fast_log_are_sent_in_order_as_fast_as_the_bus_is() {
    let mut rig = rig();
    let lines = (0..100).map(|place| format!("(1.000000) can0 123#{place:02X}\n"));
    // The time goes back.
    let text = format!("(2.0) can0 124#\n{}", lines.collect::<String>());
    let path = log("fast.log", &text);
    assert_eq!(rig.json(&format!("replay {}", path.display()))["sent"], 101);
    let witnessed = rig.witnessed();
    let bytes: Vec<u8> = witnessed[1..]
        .iter()
        .map(|frame| frame.bytes()[0])
        .collect();
    assert_eq!(bytes, (0..100).collect::<Vec<u8>>());
}

#[test]
fn log_of_two_buses_needs_an_interface() {
    let mut rig = rig();
    let path = log(
        "two.log",
        "(1.0) can0 123#01\n(1.1) can1 124#01\n(1.2) can0 123#02\n",
    );
    let replay = format!("replay {}", path.display());
    assert_eq!(rig.fails(&replay), (2, "bad-value".to_owned()));
    assert_eq!(
        rig.fails(&format!("{replay} --interface can2")),
        (2, "bad-value".to_owned())
    );
    assert_eq!(
        rig.fails(&format!("{replay} --filter 555 --loop")),
        (2, "bad-value".to_owned())
    );
    assert_eq!(rig.witnessed(), []);
    rig.done(&format!("{replay} --interface can0"));
    assert_eq!(rig.witnessed(), ["123#01", "123#02"].map(frame));
    rig.done(&format!("{replay} --filter 124"));
    assert_eq!(rig.witnessed(), ["124#01"].map(frame));
    let empty = log("empty.log", "no log\n");
    assert_eq!(
        rig.fails(&format!("replay {}", empty.display())),
        (2, "bad-file".to_owned())
    );
}

#[test]
fn ctrl_c_ends_a_loop_with_the_count() {
    let mut rig = rig();
    let path = log("loop.log", LOG);
    rig.stop = Some(40);
    let ended = rig.tool(&format!("replay {} --loop", path.display()));
    let count = rig.witnessed().len();
    assert!(ended.code == 0 && count > 2, "{ended:?}");
    assert_eq!(ended.out, format!("sent {count} frames at 125 kbit/s\n"));
    assert!(ended.notes.contains("repeatedly"), "{ended:?}");
}
