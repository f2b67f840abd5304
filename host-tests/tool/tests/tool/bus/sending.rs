//! `send`: frames of the user, at their times.

use super::rig::{Rig, file};
use bench::BusRate;
use can_wire::text::frame;
use plumbline::can::{BitRate, Frame};
use std::path::PathBuf;

/// A bus with a sensor that acknowledges and sends nothing by itself.
fn rig() -> Rig {
    let mut rig = Rig::with("jn2101");
    rig.rate = Some("125");
    rig
}

/// A list of frames in a file.
fn list(name: &str, text: &str) -> PathBuf {
    let path = file(name);
    std::fs::write(&path, text).unwrap();
    path
}

/// The times of a frame on the bus in us, after the first frame on the bus.
fn times(witnessed: &[(plumbline::time::Instant, Frame)], text: &str) -> Vec<u64> {
    let start = witnessed[0].0.ticks();
    let own = witnessed.iter().filter(|(_, own)| *own == frame(text));
    own.map(|(at, _)| at.ticks() - start).collect()
}

#[test]
fn frames_are_sent_once_in_their_order() {
    let mut rig = rig();
    let ended = rig.tool("send 123#0102 80# 18EAFFFE#00EE00 60A#R4");
    assert_eq!(ended.code, 0, "{ended:?}");
    let texts = ["123#0102", "080#", "18EAFFFE#00EE00", "60A#R4"];
    assert_eq!(rig.witnessed(), texts.map(frame));
    assert_eq!(ended.out, "sent 4 frames at 125 kbit/s\n");
    for text in texts {
        let told = format!("sends {text} once\n");
        assert!(ended.notes.contains(&told), "{ended:?}");
    }
    assert_eq!(rig.questions.len(), 0);
    assert_eq!(rig.json("send 123#")["sent"], 1);
}

#[test]
fn periodic_frames_have_their_periods() {
    let mut rig = rig();
    let path = list(
        "periods.toml",
        "[[send]]\nframe = \"123#01\"\nevery = 100\n[[send]]\nframe = \"124#01\"\nevery = 250\n[[send]]\nframe = \"125#01\"\n",
    );
    let send = format!("send {} 126#01 --every 500 --seconds 1", path.display());
    let ended = rig.tool(&send);
    assert_eq!(
        (ended.code, &*ended.out),
        (0, "sent 17 frames at 125 kbit/s\n")
    );
    assert!(
        ended.notes.contains("sends 124#01 every 250 ms\n"),
        "{ended:?}"
    );
    let witnessed = rig.witnessed_at();
    for (text, period, count) in [
        ("123#01", 100, 10),
        ("124#01", 250, 4),
        ("125#01", 0, 1),
        ("126#01", 500, 2),
    ] {
        let times = times(&witnessed, text);
        assert_eq!(times.len(), count, "{text}");
        // A frame waits until the bus has carried the others.
        for (time, place) in times.iter().zip(0..) {
            let late = time.abs_diff(place * period * 1000);
            assert!(late < 1500, "{text}: {times:?}");
        }
    }
}

#[test]
fn late_frames_of_a_full_bus_are_left_out_and_counted() {
    let mut rig = rig();
    let frames = (0..10).map(|place| format!("12{place}#0102030405060708"));
    let send = format!(
        "send {} --every 1 --seconds 1",
        frames.clone().collect::<Vec<_>>().join(" ")
    );
    let ended = rig.tool(&send);
    assert_eq!(ended.code, 0, "{ended:?}");
    assert!(ended.notes.contains("skipped: "), "{ended:?}");
    let witnessed = rig.witnessed_at();
    for text in frames {
        let count = times(&witnessed, &text).len();
        // 10 frames of 111 bits and some stuff bits take 8.9 ms to 10 ms.
        assert!((100..=113).contains(&count), "{text}: {count}");
    }
}

#[test]
fn ctrl_c_and_a_failed_adapter_end_the_frames_with_their_count() {
    let mut rig = rig();
    rig.stop = Some(20);
    let ended = rig.tool("send 123#01 --every 100");
    let count = rig.witnessed().len();
    assert!(ended.code == 0 && count > 1, "{ended:?}");
    assert_eq!(ended.out, format!("sent {count} frames at 125 kbit/s\n"));
    rig.stop = None;
    rig.cut = Some(3);
    let ended = rig.tool("send 123#01 --every 100");
    assert_eq!(ended.code, 4, "{ended:?}");
    assert!(
        ended.notes.contains("sent 3 frames at 125 kbit/s\n"),
        "{ended:?}"
    );
}

#[test]
fn rate_of_the_bus_is_that_of_the_traffic() {
    let mut rig = Rig::new(BusRate::Fixed(BitRate::K125));
    assert_eq!(rig.fails("send 123#01"), (3, "no-answer".to_owned()));
    rig.attach("jn2101", 1);
    rig.cyclic = Some((10, frame("080#")));
    rig.witnessed();
    let ended = rig.tool("send 123#01");
    assert_eq!(
        (ended.code, &*ended.out),
        (0, "sent 1 frame at 125 kbit/s\n")
    );
    assert!(rig.witnessed().contains(&frame("123#01")));
}

#[test]
fn errors_of_the_bus_are_told() {
    let mut rig = rig();
    rig.bus.borrow_mut().corrupt(3, None);
    let ended = rig.tool("send 123#01");
    assert!(
        ended.notes.contains("at least 3 errors of the bus"),
        "{ended:?}"
    );
}

#[test]
fn wrong_list_or_frame_sends_nothing() {
    let mut rig = rig();
    for text in [
        "",
        "send",
        "[[send]]\n",
        "[[send]]\nframe = \"123\"\n",
        "[[send]]\nframe = \"800#\"\n",
        "[[send]]\nframe = \"123#01\"\nevery = 0\n",
        "[[send]]\nframe = \"123#01\"\nevery = -1\n",
        "[[send]]\nframe = \"123#01\"\nevery = 3600001\n",
        "[[send]]\nframe = \"123#01\"\nperiod = 100\n",
        "[[send]]\nframe = \"123#01\"\n[other]\n",
        "[[send]]\nframe = \"123#01\"\n[[send]]\nframe = 123\n",
    ] {
        let path = list("wrong-list.toml", text);
        let failed = rig.fails(&format!("send {}", path.display()));
        assert_eq!(failed, (2, "bad-file".to_owned()), "{text}");
    }
    let missing = file("missing-list.toml");
    let failed = rig.fails(&format!("send {}", missing.display()));
    assert_eq!(failed, (4, "no-file".to_owned()));
    assert_eq!(rig.witnessed(), []);
    for text in [
        "800#",
        "12345#",
        "#01",
        "123#0",
        "é#",
        "1é#00",
        "123#010203040506070809",
    ] {
        assert!(plumbline_tool::cli::frames::frame(text).is_err(), "{text}");
    }
}
