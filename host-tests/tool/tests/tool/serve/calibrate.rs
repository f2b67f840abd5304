//! The calibration in the page: a shell script is the command of the log, and the test turns the unit.

use crate::serve::client::{Running, Tab, until};
use plumbline_tool::calibrate::log::Source;
use plumbline_tool::cli::Options;
use plumbline_tool::serve::calibration::Unit;
use plumbline_tool::serve::{Server, Settings};
use serde_json::{Value, json};
use std::path::PathBuf;

/// The offset of the accelerometer in g.
const OFFSET: [f64; 3] = [0.02, -0.03, 0.05];

const SIDES: [&str; 6] = ["+z", "-z", "+x", "-x", "+y", "-y"];

/// 3 s of the log with a side up.
fn log(side: &str) -> String {
    let axis = ["x", "y", "z"].iter().position(|name| side.ends_with(name));
    let sign = if side.starts_with('-') { -1.0 } else { 1.0 };
    let raw: [i32; 3] = std::array::from_fn(|own| {
        let gravity = if Some(own) == axis { sign } else { 0.0 };
        ((OFFSET[own] + gravity) * 1e6_f64).round() as i32
    });
    let [x, y, z] = raw;
    let line = format!("0.06 [DEBUG] acceleration {x} {y} {z} ug, 2510 0.01 degC (app.rs:330)\n");
    format!("0.000012 [INFO ] serial number 7\n{}", line.repeat(600))
}

/// A unit on a bench.
struct Board {
    folder: tempfile::TempDir,
    server: Running,
    tab: Tab,
}

impl Board {
    fn new() -> Self {
        let folder = tempfile::tempdir().expect("a folder");
        let path = |name: &str| folder.path().join(name);
        let script = format!(
            "while cat '{}' 2>/dev/null; do sleep 0.02; done",
            path("log").display()
        );
        let unit = Unit {
            file: path("positions.csv"),
            store: Some(path("is2.bin")),
            serial: None,
            product: Some("is2".to_owned()),
            source: Some(Source::Command(
                ["sh", "-c", &script].map(str::to_owned).to_vec(),
            )),
        };
        let server = Running::calibrating(unit);
        let tab = server.tab();
        let board = Self {
            folder,
            server,
            tab,
        };
        board.turn("+z");
        board
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn turn(&self, side: &str) {
        let part = self.path("part");
        std::fs::write(&part, log(side)).expect("a file");
        std::fs::rename(&part, self.path("log")).expect("a file");
    }

    /// The positions in the file.
    fn rows(&self) -> usize {
        let text = std::fs::read_to_string(self.path("positions.csv")).unwrap_or_default();
        text.lines()
            .filter(|line| line.starts_with(['+', '-']))
            .count()
    }

    #[track_caller]
    fn ask(&self, body: Value) {
        let answer = self.server.post("/api/calibrate", &body.to_string());
        assert_eq!(answer.status, 200, "{body} {answer:?}");
    }

    #[track_caller]
    fn refused(&self, body: Value) -> String {
        self.server.post("/api/calibrate", &body.to_string()).code()
    }

    /// Waits for the question about a side; its number.
    #[track_caller]
    fn question(&mut self, side: &str) -> u64 {
        let asked = self
            .tab
            .wait("calibration", |state| state["state"] == "asking");
        assert_eq!(asked["side"], side);
        assert_eq!(asked["measured"]["state"], "ready");
        asked["question"].as_u64().expect("a number")
    }

    /// Waits for the end of the calibration.
    #[track_caller]
    fn end(&mut self, state: &str) -> Value {
        self.tab.wait("calibration", |own| own["state"] == state)
    }
}

#[test]
fn position_is_taken_only_by_the_answer_to_its_own_question() {
    let mut board = Board::new();
    let idle = board.tab.wait("calibration", |_| true);
    assert_eq!(idle["state"], "idle");
    assert!(
        idle["line"].as_str().is_some_and(|line| line
            .starts_with("plumbline --product is2 calibrate ")
            && line.contains(" -- sh -c 'while cat ")),
        "{idle}"
    );
    assert_eq!(board.refused(json!({"take": 0})), "old-question");
    board.ask(json!("start"));
    assert_eq!(board.refused(json!("start")), "running");
    let first = board.question("+z");
    assert_eq!(board.refused(json!({"take": first + 1})), "old-question");
    assert_eq!(board.rows(), 0);
    // The same position is measured again.
    board.ask(json!({"again": first}));
    let again = board.question("+z");
    assert_ne!(again, first);
    assert_eq!(board.rows(), 0);
    board.ask(json!({"take": again}));
    assert_eq!(
        board.refused(json!({"take": again})),
        "old-question",
        "a second click"
    );
    // The unit has not been turned: the next position waits.
    let waits = board.tab.wait("calibration", |state| {
        state["side"] == "-z" && state["measured"]["state"] == "other-side"
    });
    assert_eq!(
        (&waits["measured"]["up"], &waits["place"]),
        (&json!("+z"), &json!(2))
    );
    assert_eq!(board.rows(), 1);
    for side in &SIDES[1..] {
        board.turn(side);
        let question = board.question(side);
        board.ask(json!({"take": question}));
    }
    let done = board.end("done");
    for (place, expected) in OFFSET.iter().enumerate() {
        let offset = done["result"]["offset_mg"][place]
            .as_f64()
            .expect("a number");
        assert!((offset - expected * 1e3).abs() < 0.01, "{done}");
    }
    assert!(board.path("is2.bin").exists());
    assert!(
        done["next"]["en"]
            .as_str()
            .is_some_and(|next| next.contains("serial number 7")),
        "{done}"
    );
    let action = board.tab.wait("action", |action| action["state"] == "done");
    assert_eq!(action["line"], idle["line"]);
}

#[test]
fn stopped_calibration_goes_on_with_the_positions_that_are_missing() {
    let mut board = Board::new();
    board.ask(json!("start"));
    let question = board.question("+z");
    board.ask(json!({"take": question}));
    board.turn("-z");
    board.question("-z");
    board.ask(json!("stop"));
    let failed = board.end("failed");
    assert!(
        failed["error"]["en"]
            .as_str()
            .is_some_and(|why| why.contains("in the file")),
        "{failed}"
    );
    assert_eq!(board.rows(), 1);
    // On another side there is no question, which would wait for its answer.
    board.turn("+z");
    // The thread can take a moment to end.
    until("another start", || {
        board.server.post("/api/calibrate", "\"start\"").status == 200
    });
    let place = board
        .tab
        .wait("calibration", |state| !state["place"].is_null());
    assert_eq!((&place["place"], &place["side"]), (&json!(2), &json!("-z")));
    // A log that ends is a failure with a next step.
    std::fs::remove_file(board.path("log")).expect("the log");
    let ended = board.end("failed");
    assert!(
        ended["error"]["en"]
            .as_str()
            .is_some_and(|why| why.contains("connect the probe")),
        "{ended}"
    );
    assert_eq!(board.rows(), 1);
}

#[test]
fn store_file_without_a_product_is_refused_at_the_start() {
    let unit = Unit {
        file: "positions.csv".into(),
        store: Some("is2.bin".into()),
        serial: None,
        product: None,
        source: None,
    };
    let settings = Settings {
        listen: "127.0.0.1:0".parse().expect("an address"),
        options: Options::default(),
        demo: false,
        unit: Some(unit),
        store: None,
    };
    let refused = Server::bind(settings).err().expect("a failure");
    assert_eq!(refused.code(), "unknown-product");
}

#[test]
fn page_without_a_unit_starts_no_program() {
    let server = Running::new();
    for body in [
        r#""start""#,
        r#"{"start":{"log":["sh"]}}"#,
        r#"{"start":["sh"]}"#,
    ] {
        let answer = server.post("/api/calibrate", body);
        assert!(
            ["no-unit", "bad-request"].contains(&answer.code().as_str()),
            "{body} {answer:?}"
        );
    }
    let state = server.tab().wait("calibration", |_| true);
    assert_eq!(state["state"], "off");
}

#[test]
fn demonstration_connects_at_once_and_calibrates_a_virtual_unit() {
    let server = Running::demonstration();
    let mut tab = server.tab();
    let device = tab.wait("device", |device| !device.is_null());
    assert_eq!(device["product"], "is2");
    let mut tab = server.tab();
    let idle = tab.wait("calibration", |_| true);
    assert_eq!(
        (&idle["state"], &idle["demo"]),
        (&json!("idle"), &json!(true))
    );
    let post = |body: Value| server.post("/api/calibrate", &body.to_string());
    assert_eq!(post(json!("start")).status, 200);
    let asked = tab.wait("calibration", |state| state["state"] == "asking");
    assert_eq!((&asked["place"], &asked["side"]), (&json!(1), &json!("+z")));
    assert_eq!(asked["measured"]["state"], "ready");
    assert_eq!(post(json!({"take": asked["question"]})).status, 200);
    let next = tab.wait("calibration", |state| state["side"] == "-z");
    assert_eq!(next["place"], 2);
    assert_eq!(post(json!("stop")).status, 200);
    tab.wait("calibration", |state| state["state"] == "failed");
}
