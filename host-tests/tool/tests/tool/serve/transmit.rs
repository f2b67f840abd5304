//! What the page sends beside its requests, as a witness on the bus sees it: the transmit list, and the replay of a log.

use crate::bus::rig::Rig;
use crate::serve::client::{Running, Tab};
use crate::serve::hooked::{Hook, Hooked, Received, paced};
use adapter::bench::BenchAdapter;
use adapter::{Adapter, AdapterError};
use can_wire::text::frame;
use plumbline::can::Frame;
use plumbline::time::Instant;
use serde_json::{Value, json};
use std::sync::{Arc, Mutex};

/// The adapter is unplugged when this frame is sent.
const UNPLUGS: &str = "7FF#";

/// The adapter refuses this frame.
const REFUSED: &str = "7FE#";

/// The frames on the bus with their times.
type Seen = Arc<Mutex<Vec<(Instant, Frame)>>>;

/// A bus with a sensor and a witness.
struct Witnessed {
    rig: Rig,
    seen: Seen,
}

impl Hook for Witnessed {
    fn send(&mut self, adapter: &mut dyn Adapter, own: &Frame) -> Result<(), AdapterError> {
        let name = "bench".to_owned();
        match own {
            own if *own == frame(UNPLUGS) => Err(AdapterError::Lost(name, "unplugged".to_owned())),
            own if *own == frame(REFUSED) => Err(AdapterError::FrameRefused(name)),
            own => adapter.send(own),
        }
    }

    fn receive(&mut self, adapter: &mut dyn Adapter, until: Instant) -> Received {
        let received = paced(adapter, until);
        let seen = self.rig.witnessed_at();
        self.seen.lock().expect("frames").extend(seen);
        received
    }
}

/// A server that takes part in a bus with a JN2101 in this mode.
fn connected(mode: &str) -> (Running, Seen) {
    let seen = Seen::default();
    let own = seen.clone();
    let server = Running::with(Box::new(move |_| {
        let rig = Rig::with("jn2101");
        let adapter = BenchAdapter::new(&rig.bus);
        let seen = own.clone();
        Ok(Hooked::new(adapter, Witnessed { rig, seen }))
    }));
    let answer = server.post(
        "/api/connect",
        &json!({"port": "bench", "rate": 125, "mode": mode}).to_string(),
    );
    assert_eq!(answer.status, 200, "{answer:?}");
    (server, seen)
}

#[track_caller]
fn transmit(server: &Running, body: Value) {
    let answer = server.post("/api/transmit", &body.to_string());
    assert_eq!(answer.status, 200, "{answer:?}");
}

/// The next state of the transmission in which a line was sent at least this number of times.
fn sent(tab: &mut Tab, line: usize, count: u64) -> Value {
    tab.wait("transmission", |state| {
        state["lines"][line]["sent"].as_u64() >= Some(count)
    })
}

/// The times of a frame on the bus in us, in which 1 ms is permitted for the frame that is on the bus before.
fn times(seen: &Seen, text: &str) -> Vec<u64> {
    let seen = seen.lock().expect("frames");
    let own = seen.iter().filter(|(_, own)| *own == frame(text));
    own.map(|(at, _)| at.ticks()).collect()
}

const LOG: &str =
    "(0.1) can0 123#01\n(0.15) can0 124#01\n\ntext\n(0.25) can1 125#01\n(0.4) can0 123#02\n";

#[test]
fn lines_are_sent_with_their_periods_beside_polls_until_they_are_stopped() {
    for mode in ["frames", "active"] {
        let (server, seen) = connected(mode);
        let mut tab = server.tab();
        transmit(&server, json!({"add": {"frame": "123#01", "every": 100}}));
        transmit(&server, json!({"add": {"frame": "124#0102"}}));
        assert_eq!(times(&seen, "123#01"), [0; 0], "a new line has not started");
        for line in [1, 2] {
            transmit(&server, json!({"start": line}));
        }
        let state = sent(&mut tab, 0, 10);
        assert_eq!(state["lines"][0]["running"], true);
        let once = json!({"number": 2, "frame": "124#0102", "every": null, "running": false, "sent": 1, "leftOut": 0});
        assert_eq!(state["lines"][1], once, "{mode}");
        transmit(&server, json!({"stop": 1}));
        let stopped = tab.wait("transmission", |state| {
            state["lines"][0]["running"] == false
        });
        // It polls on, so a line that had not stopped would be sent.
        transmit(&server, json!({"start": 2}));
        sent(&mut tab, 1, 2);
        let times = times(&seen, "123#01");
        assert_eq!(stopped["lines"][0]["sent"], times.len(), "{mode}");
        for (time, place) in times.iter().zip(0..) {
            let late = time.abs_diff(times[0] + place * 100_000);
            assert!(late < 1500, "{mode}: {times:?}");
        }
        transmit(&server, json!({"remove": 1}));
        let left = tab.wait("transmission", |state| state["lines"][1].is_null());
        assert_eq!(left["lines"][0]["number"], 2);
    }
}

#[test]
fn log_is_sent_with_its_spacing_until_it_ends_or_is_stopped() {
    let (server, seen) = connected("active");
    let mut tab = server.tab();
    let log = |change: Value| {
        let mut log = json!({"text": LOG, "name": "crane.log", "speed": 0.5, "interface": "can0"});
        for (name, value) in change.as_object().into_iter().flatten() {
            log[name] = value.clone();
        }
        json!({"replay": log})
    };
    transmit(&server, log(json!({})));
    let line = "plumbline --port bench --rate 125 replay --speed 0.5 --interface=can0 crane.log";
    let action = tab.wait("action", |action| {
        action["line"] == line && action["state"] == "done"
    });
    let note = action["notes"][0]["en"].as_str().unwrap_or_default();
    assert!(note.starts_with("skipped: 1 line of the log"), "{action}");
    let ended = tab.wait("transmission", |state| state["log"]["running"] == false);
    let expected = json!({"name": "crane.log", "frames": 3, "sent": 3, "running": false});
    assert_eq!(ended["log"], expected);
    let first = times(&seen, "123#01")[0];
    for (text, after) in [("124#01", 100_000), ("123#02", 600_000)] {
        let late = times(&seen, text)[0].abs_diff(first + after);
        assert!(late < 1500, "{text}: {late}");
    }
    assert_eq!(times(&seen, "125#01"), [0; 0], "it is of another interface");
    transmit(&server, log(json!({"repeats": true, "speed": 1})));
    tab.wait("transmission", |state| {
        state["log"]["sent"].as_u64() >= Some(7)
    });
    transmit(&server, json!("stop-replay"));
    tab.wait("transmission", |state| state["log"]["running"] == false);
    transmit(&server, log(json!({"repeats": true})));
    transmit(&server, json!({"add": {"frame": "123#01", "every": 100}}));
    transmit(&server, json!({"start": 1}));
    sent(&mut tab, 0, 1);
    // Another connection is another bus.
    assert_eq!(server.post("/api/disconnect", "{}").status, 200);
    let state = tab.wait("transmission", |state| state["log"]["running"] == false);
    assert_eq!(state["lines"][0]["running"], false);
}

#[test]
fn adapter_that_fails_stops_all_lines() {
    let (server, _) = connected("frames");
    let mut tab = server.tab();
    transmit(&server, json!({"add": {"frame": "123#01", "every": 100}}));
    transmit(&server, json!({"start": 1}));
    sent(&mut tab, 0, 1);
    transmit(&server, json!({"add": {"frame": UNPLUGS}}));
    transmit(&server, json!({"start": 2}));
    let state = tab.wait("transmission", |state| {
        state["lines"][0]["running"] == false
    });
    assert_eq!(state["lines"][1]["sent"], 0, "{state}");
}

#[test]
fn frame_that_the_adapter_refuses_stops_all_lines_and_keeps_the_connection() {
    let (server, _) = connected("frames");
    let mut tab = server.tab();
    for frame in [
        json!({"frame": "123#01", "every": 100}),
        json!({"frame": REFUSED}),
    ] {
        transmit(&server, json!({"add": frame}));
    }
    transmit(&server, json!({"start": 1}));
    sent(&mut tab, 0, 1);
    transmit(&server, json!({"start": 2}));
    // What was refused is not sent.
    let state = tab.wait("transmission", |state| {
        state["lines"][0]["running"] == false
    });
    assert_eq!(state["lines"][1]["sent"], 0, "{state}");
    let status = tab.wait("status", |status| !status["error"].is_null());
    assert_eq!(status["state"], "open", "{status}");
    let text = status["error"]["de"].as_str().unwrap_or_default();
    assert!(text.contains("Frame"), "{status}");
    // The next start is without the message.
    transmit(&server, json!({"start": 1}));
    tab.wait("status", |status| status["error"].is_null());
    sent(&mut tab, 0, 1);
}

#[test]
fn wrong_frames_lists_and_logs_send_nothing() {
    let (server, seen) = connected("frames");
    let replay = |change: &str| {
        format!(r#"{{"replay":{{"text":"(1) can0 123#\n(2) can1 124#","name":"a.log",{change}}}}}"#)
    };
    let lines: String = (0..101).map(|_| "[[send]]\\nframe = '123#'\\n").collect();
    for (body, code) in [
        (r#"{"add":{"frame":"123"}}"#.to_owned(), "bad-value"),
        (
            r#"{"add":{"frame":"123#","every":0}}"#.to_owned(),
            "out-of-range",
        ),
        (
            r#"{"add":{"frame":"123#","every":3600001}}"#.to_owned(),
            "out-of-range",
        ),
        (
            r#"{"open":{"name":"a.toml","text":"[[send]]\nframe = 123"}}"#.to_owned(),
            "bad-file",
        ),
        (
            format!(r#"{{"open":{{"name":"a.toml","text":"{lines}"}}}}"#),
            "too-many-lines",
        ),
        (r#"{"start":1}"#.to_owned(), "no-line"),
        (r#"{"stop":1}"#.to_owned(), "no-line"),
        (replay(r#""speed":0"#), "out-of-range"),
        (replay(r#""speed":1"#), "bad-value"),
        (replay(r#""speed":1,"interface":"can2""#), "bad-value"),
        (
            r#"{"replay":{"text":"text","name":"a.log","speed":1}}"#.to_owned(),
            "bad-file",
        ),
    ] {
        assert_eq!(server.post("/api/transmit", &body).code(), code, "{body}");
    }
    let list = r#"{"open":{"name":"a.toml","text":"[[send]]\nframe = '123#'\nevery = 10\n[[send]]\nframe = '124#'"}}"#;
    assert_eq!(server.post("/api/transmit", list).status, 200);
    let listens = r#"{"port":"bench","rate":125,"mode":"listen"}"#;
    assert_eq!(server.post("/api/connect", listens).status, 200);
    for body in [
        json!({"start": 1}).to_string(),
        replay(r#""speed":1,"interface":"can1""#),
    ] {
        let code = server.post("/api/transmit", &body).code();
        assert_eq!(code, "not-connected", "{body}");
    }
    assert_eq!(*seen.lock().expect("frames"), []);
}
