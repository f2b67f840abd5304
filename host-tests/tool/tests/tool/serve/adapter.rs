//! The adapter: what is sent with it, and what happens when it is unplugged.

use crate::serve::client::Running;
use crate::serve::fast_bus;
use crate::serve::hooked::{Hook, Hooked, Received};
use adapter::{Adapter, AdapterError, Mode};
use plumbline::can::{BitRate, Frame};
use plumbline::time::Instant;
use serde_json::json;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex};

/// What a test sees and does.
#[derive(Default)]
struct Plug {
    is_out: AtomicBool,
    sent: AtomicU64,
    /// It was opened so that it takes part in the bus.
    was_active: AtomicBool,
    /// The number of times an adapter was opened.
    opened: AtomicU64,
    /// The adapters that were made.
    made: AtomicU64,
    /// What is done once, as soon as a frame was sent.
    then: Mutex<Option<Box<dyn FnOnce() + Send>>>,
}

impl Plug {
    fn check(&self) -> Result<(), AdapterError> {
        match self.is_out.load(Ordering::Relaxed) {
            true => Err(AdapterError::Lost("it".to_owned(), "unplugged".to_owned())),
            false => Ok(()),
        }
    }
}

impl Hook for Arc<Plug> {
    fn open(
        &mut self,
        adapter: &mut dyn Adapter,
        rate: Option<BitRate>,
        mode: Mode,
    ) -> Result<(), AdapterError> {
        self.check()?;
        self.opened.fetch_add(1, Ordering::Relaxed);
        self.was_active
            .fetch_or(mode == Mode::Active, Ordering::Relaxed);
        adapter.open(rate, mode)
    }

    fn send(&mut self, adapter: &mut dyn Adapter, frame: &Frame) -> Result<(), AdapterError> {
        self.check()?;
        self.sent.fetch_add(1, Ordering::Relaxed);
        adapter.send(frame)?;
        let then = self.then.lock().expect("a place").take();
        then.into_iter().for_each(|run| run());
        Ok(())
    }

    fn receive(&mut self, adapter: &mut dyn Adapter, until: Instant) -> Received {
        self.check()?;
        adapter.receive(until)
    }
}

fn plugged() -> (Running, Arc<Plug>) {
    let plug = Arc::new(Plug::default());
    let own = plug.clone();
    let server = Running::with(Box::new(move |port| {
        own.made.fetch_add(1, Ordering::Relaxed);
        Ok(Hooked::around(fast_bus::connect(port)?, own.clone()))
    }));
    (server, plug)
}

const ACTIVE: &str = r#"{"port":"demo:is2","mode":"active"}"#;

#[test]
fn unplugged_adapter_ends_the_connection_and_works_again_later() {
    let (server, plug) = plugged();
    assert_eq!(server.post("/api/connect", ACTIVE).status, 200);
    let mut tab = server.tab();
    tab.wait("samples", |_| true);
    plug.is_out.store(true, Ordering::Relaxed);
    assert_eq!(tab.wait("device", |_| true), json!(null));
    let status = tab.wait("status", |status| status["state"] == "closed");
    assert_eq!(
        status["error"]["en"],
        "the adapter it has failed (unplugged): plug it in again and repeat"
    );
    assert_eq!(
        server.post("/api/run", r#"{"zero":{}}"#).code(),
        "not-connected"
    );
    let refused = server.post("/api/connect", ACTIVE);
    assert_eq!(
        (refused.status, refused.code().as_str()),
        (502, "adapter-lost")
    );
    plug.is_out.store(false, Ordering::Relaxed);
    assert_eq!(server.post("/api/connect", ACTIVE).status, 200);
    assert_eq!(plug.made.load(Ordering::Relaxed), 3);
}

#[test]
fn listening_opens_no_active_adapter_and_sends_nothing() {
    let (server, plug) = plugged();
    let answer = server.post(
        "/api/connect",
        r#"{"port":"demo:jn2101","rate":125,"mode":"listen"}"#,
    );
    assert_eq!(answer.status, 200, "{answer:?}");
    let mut tab = server.tab();
    // A lone CANopen node repeats its boot-up message.
    let frames = tab.wait("frames", |frames| frames[0].is_object());
    assert_eq!(frames[0]["id"], "70Ah");
    server.post("/api/run", r#"{"raw":{"request":"1018:1"}}"#);
    server.post("/api/samples", r#"{"perSecond":200}"#);
    tab.wait("status", |status| status["samples"] == 200);
    assert_eq!(plug.sent.load(Ordering::Relaxed), 0);
    assert!(!plug.was_active.load(Ordering::Relaxed));
}

#[test]
fn adapter_stays_open_between_commands() {
    let (server, plug) = plugged();
    assert_eq!(server.post("/api/connect", ACTIVE).status, 200);
    let opened = plug.opened.load(Ordering::Relaxed);
    for _ in 0..3 {
        assert_eq!(
            server
                .post("/api/run", r#"{"get":{"names":["cut-off"]}}"#)
                .status,
            200
        );
    }
    assert_eq!(plug.opened.load(Ordering::Relaxed), opened);
}

#[test]
fn stop_during_a_poll_is_no_error_of_the_sensor_and_loses_no_sample() {
    let (server, plug) = plugged();
    let server = Arc::new(server);
    let answer = server.post("/api/connect", r#"{"port":"demo:jn2101","mode":"active"}"#);
    assert_eq!(answer.status, 200, "{answer:?}");
    // A poll that is a second late is a lost sample.
    server.post("/api/samples", r#"{"perSecond":1}"#);
    let mut tab = server.tab();
    let samples = tab.wait("samples", |_| true);
    let own = server.clone();
    // A poll has two requests: the stop comes between them.
    *plug.then.lock().expect("a place") = Some(Box::new(move || {
        assert_eq!(own.post("/api/stop", "{}").status, 200);
    }));
    for _ in 0..3 {
        let (mut next, mut condition) = (json!(null), json!([]));
        while next.is_null() {
            match tab.next() {
                (kind, data) if kind == "condition" => condition = data,
                (kind, data) if kind == "samples" => next = data,
                _ => {}
            }
        }
        assert_eq!((&condition, &next["lost"]), (&json!([]), &samples["lost"]));
    }
    assert!(plug.then.lock().expect("a place").is_none());
}
