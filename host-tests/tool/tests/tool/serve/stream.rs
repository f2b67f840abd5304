//! The events: samples without loss, the log, the limit of tabs.

use crate::serve::client::{Running, until};
use crate::serve::fast_bus;
use crate::serve::foreign::{opener, unknown};
use crate::serve::hooked::{Hook, Hooked, Received};
use adapter::Adapter;
use plumbline::time::Instant;
use serde_json::{Value, json};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::Duration;

#[test]
fn sixth_tab_is_told_to_close_one() {
    let server = Running::new();
    let mut tabs: Vec<_> = (0..5).map(|_| server.tab()).collect();
    assert!(tabs.iter().all(|tab| tab.status == 200));
    assert_eq!(server.tab().status, 503);
    let refused = server.get("/api/events");
    assert_eq!(
        (refused.status, refused.code().as_str()),
        (503, "too-many-tabs")
    );
    assert!(refused.body.contains("close one"), "{refused:?}");
    tabs.pop();
    // The server sees the end of a connection soon.
    until("another tab", || server.tab().status == 200);
}

#[test]
fn samples_have_all_numbers_and_angles_of_the_sensor() {
    let server = Running::connected("is2");
    assert_eq!(
        server.post("/api/samples", r#"{"perSecond":200}"#).status,
        200
    );
    let mut tab = server.tab();
    let device = tab.wait("device", |device| !device.is_null());
    assert_eq!(
        device["angles"],
        json!([{"name": "angle-x", "unit": "deg"}, {"name": "angle-y", "unit": "deg"}])
    );
    assert_eq!(
        (&device["product"], &device["serial"]),
        (&json!("is2"), &json!(1))
    );
    let condition = tab.wait("condition", |condition| !condition.is_null());
    assert_eq!(
        condition,
        json!([{"name": "DefaultParam", "error": false}, {"name": "AutobaudDetection", "error": false}])
    );
    let mut next = None;
    let mut rows: Vec<Value> = Vec::new();
    while rows.len() < 400 {
        let samples = tab.wait("samples", |_| true);
        let first = samples["first"].as_u64().expect("a number");
        assert_eq!(first, next.unwrap_or(first));
        let own = samples["rows"].as_array().expect("rows").clone();
        next = Some(first + own.len() as u64);
        rows.extend(own);
    }
    let number = |row: &Value, place: usize| row[place].as_f64();
    let whole: Vec<&Value> = rows
        .iter()
        .filter(|row| row.as_array().is_some_and(|row| row.len() == 3))
        .collect();
    assert!(whole.len() > 390);
    for pair in whole.windows(2) {
        assert!(number(pair[0], 0) < number(pair[1], 0), "{pair:?}");
    }
    // The demonstration sways by 15 and 8 degrees.
    assert!(
        whole
            .iter()
            .all(|row| number(row, 1).is_some_and(|x| x.abs() < 16.0))
    );
    assert!(
        whole
            .iter()
            .all(|row| number(row, 2).is_some_and(|y| y.abs() < 9.0))
    );
}

#[test]
fn action_is_shown_with_the_line_that_repeats_it() {
    let server = Running::connected("is2");
    let mut tab = server.tab();
    let connected = tab.wait("action", |action| action["state"] == "done");
    assert_eq!(connected["line"], "plumbline --port demo:is2 watch");
    let answer = server.post(
        "/api/run",
        r#"{"set":{"assignments":["filter=2.5Hz,butterworth"],"save":true}}"#,
    );
    assert_eq!(answer.status, 200);
    let action = tab.wait("action", |action| {
        action["n"] == 2 && action["state"] == "done"
    });
    assert_eq!(
        action["line"],
        "plumbline --port demo:is2 --id 300 set --save filter=2.5Hz,butterworth"
    );
    let values = tab.wait("values", |values| !values.is_null());
    assert_eq!(values["cut-off"]["raw"], 2500);
    server.post("/api/run", r#"{"set":{"assignments":["cyclic-time=0"]}}"#);
    let failed = tab.wait("action", |action| {
        action["n"] == 3 && action["state"] == "failed"
    });
    assert_eq!(failed["error"]["code"], "out-of-range");
    // A new tab knows all of it.
    let again = server.tab().wait("action", |action| action["n"] == 2);
    assert_eq!(again, action);
}

#[test]
fn frames_have_the_newest_of_each_identifier() {
    let server = Running::connected("is2");
    let mut tab = server.tab();
    let frames = tab.wait("frames", |frames| {
        frames.as_array().is_some_and(|frames| frames.len() >= 2)
    });
    let ids: Vec<&str> = frames
        .as_array()
        .expect("rows")
        .iter()
        .filter_map(|row| row["id"].as_str())
        .collect();
    assert!(ids.contains(&"300h") && ids.contains(&"301h"), "{ids:?}");
    let own = frames
        .as_array()
        .expect("rows")
        .iter()
        .find(|row| row["id"] == "300h")
        .expect("a request");
    assert_eq!(own["own"], true);
    let status = tab.wait("status", |status| {
        status["perSecond"].as_f64().is_some_and(|rate| rate > 10.0)
    });
    assert_eq!(status["state"], "active");
}

#[test]
fn scan_lists_the_sensor() {
    let server = Running::new();
    let mut tab = server.tab();
    let answer = server.post("/api/scan", r#"{"port":"demo:jn2101"}"#);
    assert_eq!(answer.status, 200, "{answer:?}");
    assert_eq!(answer.json()[0]["product"], "jn2101");
    let step = tab.wait("progress", |_| true);
    assert!(
        step["texts"]["en"]
            .as_str()
            .is_some_and(|text| text.contains("listened")),
        "{step}"
    );
    let found = tab.wait("found", |_| true);
    assert_eq!(found[0]["address"], "10");
}

/// The time of the bus stands still while a test holds it.
struct Held(Arc<AtomicBool>);

impl Hook for Held {
    fn receive(&mut self, adapter: &mut dyn Adapter, until: Instant) -> Received {
        while self.0.load(Ordering::Relaxed) {
            thread::sleep(Duration::from_millis(1));
        }
        adapter.receive(until)
    }
}

#[test]
fn running_scan_can_be_stopped() {
    let is_held = Arc::new(AtomicBool::new(true));
    let own = is_held.clone();
    let server = Running::with(Box::new(move |port| {
        Ok(Hooked::around(fast_bus::connect(port)?, Held(own.clone())))
    }));
    let mut tab = server.tab();
    let stopped = thread::scope(|scope| {
        let scan = scope.spawn(|| server.post("/api/scan", r#"{"port":"demo:is2"}"#));
        tab.wait("status", |status| !status["busy"].is_null());
        assert_eq!(server.post("/api/stop", "{}").status, 200);
        is_held.store(false, Ordering::Relaxed);
        scan.join().expect("an answer")
    });
    assert_eq!((stopped.status, stopped.code().as_str()), (502, "stopped"));
    tab.wait("action", |action| action["state"] == "failed");
}

#[test]
fn progress_of_a_scan_is_an_event_for_each_step() {
    let server = Running::new();
    let mut tab = server.tab();
    let scan = server.post("/api/scan", r#"{"port":"demo:is2","rate":125}"#);
    for done in 1..=10 {
        let step = tab.wait("progress", |_| true);
        assert_eq!((&step["done"], &step["total"]), (&json!(done), &json!(10)));
        let text = step["texts"]["en"].as_str().unwrap_or_default();
        assert!(text.starts_with("listened at 125 kbit/s"), "{step}");
        assert!(text.ends_with("it then sends its address"), "{step}");
    }
    assert_eq!(scan.code(), "asks");
}

#[test]
fn status_has_the_frames_and_errors_of_the_bus_and_a_silence() {
    let (opener, witness) = opener(unknown());
    witness.errors.store(7, Ordering::Relaxed);
    let server = Running::with(opener);
    let mut tab = server.tab();
    let body =
        json!({"port": "can0", "rate": 250, "mode": "active", "protocol": "fsc", "address": "300"});
    assert_eq!(server.post("/api/connect", &body.to_string()).status, 200);
    let status = tab.wait("status", |status| status["errors"] == 7);
    assert_eq!(
        (&status["state"], &status["port"], &status["rate"]),
        (&json!("active"), &json!("can0"), &json!(250))
    );
    tab.wait("frames", |rows| {
        let rows = rows.as_array().cloned().unwrap_or_default();
        rows.iter().any(|row| row["id"] == "123h")
    });
    assert_eq!(status["unread"], json!(null));
    witness.unread.store(19, Ordering::Relaxed);
    let unread = json!({"lines": 19, "first": "y123"});
    tab.wait("status", |status| status["unread"] == unread);
    for (errors, told) in [(8, json!(8)), (0, json!(null))] {
        witness.errors.store(errors, Ordering::Relaxed);
        tab.wait("status", |status| status["errors"] == told);
    }
    witness.is_cut.store(true, Ordering::Relaxed);
    tab.wait("status", |status| status["silent"] == true);
    witness.is_cut.store(false, Ordering::Relaxed);
    tab.wait("status", |status| status["silent"] == false);
    witness.is_out.store(true, Ordering::Relaxed);
    let status = tab.wait("status", |status| status["state"] == "closed");
    assert_eq!(
        status["error"]["en"],
        "the adapter it has failed (unplugged): plug it in again and repeat"
    );
}
