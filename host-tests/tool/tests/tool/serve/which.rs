//! Which sensor a command of the page reaches, and which question a yes answers.

use crate::serve::api::{run, value};
use crate::serve::client::{Answer, Running};
use crate::serve::fast_bus;
use crate::serve::hooked::{Hook, Hooked, Received};
use adapter::{Adapter, AdapterError, Capabilities, Mode};
use plumbline::can::{BitRate, CanId, Frame};
use plumbline::time::{Instant, after, millis};
use serde_json::{Value, json};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

/// The bus of a test.
#[derive(Default)]
struct Bus {
    /// A sensor with another serial number is plugged in, at the same identifiers.
    is_other: AtomicBool,
    /// No sensor is plugged in.
    is_empty: AtomicBool,
    /// Another device sends frames.
    is_busy: AtomicBool,
    /// The adapter needs a bit rate.
    needs_rate: bool,
    /// The sensor does not answer the question for its software version (04h).
    hides_version: AtomicBool,
    /// The requests to set a zero point (28h, 29h).
    zeros: AtomicU64,
}

/// A virtual sensor that can be exchanged.
struct Exchanged {
    bus: Arc<Bus>,
    mode: Mode,
}

impl Hook for Exchanged {
    fn capabilities(&self, own: Capabilities) -> Capabilities {
        Capabilities {
            needs_rate: self.bus.needs_rate,
            ..own
        }
    }

    fn open(
        &mut self,
        adapter: &mut dyn Adapter,
        rate: Option<BitRate>,
        mode: Mode,
    ) -> Result<(), AdapterError> {
        self.mode = mode;
        adapter.open(rate, mode)
    }

    fn send(&mut self, adapter: &mut dyn Adapter, frame: &Frame) -> Result<(), AdapterError> {
        if matches!(frame.bytes(), [0x28 | 0x29, ..]) {
            self.bus.zeros.fetch_add(1, Ordering::Relaxed);
        }
        adapter.send(frame)
    }

    fn receive(&mut self, adapter: &mut dyn Adapter, until: Instant) -> Received {
        if self.bus.is_busy.load(Ordering::Relaxed) && self.mode == Mode::Listen {
            let next = after(adapter.now(), millis(10)).min(until);
            let received = adapter.receive(next)?;
            let foreign = Frame::of(CanId::standard(0x123), [0; 8], 8);
            let is_over = adapter.now() >= until;
            return Ok(received.or((!is_over).then_some((next, foreign))));
        }
        while let Some((at, frame)) = adapter.receive(until)? {
            let is_version = matches!(frame.bytes(), [0x04, ..]);
            let is_hidden = is_version && self.bus.hides_version.load(Ordering::Relaxed);
            if is_hidden || self.bus.is_empty.load(Ordering::Relaxed) {
                continue;
            }
            if self.bus.is_other.load(Ordering::Relaxed)
                && let [0x04, status, serial, rest @ ..] = frame.bytes()
                && let Ok(rest) = <[u8; 5]>::try_from(rest)
            {
                let [a, b, c, d, e] = rest;
                let bytes = [0x04, *status, serial.wrapping_add(1), a, b, c, d, e];
                return Ok(Some((at, Frame::of(frame.can_id(), bytes, 8))));
            }
            return Ok(Some((at, frame)));
        }
        Ok(None)
    }
}

fn served(bus: Bus) -> (Running, Arc<Bus>) {
    let bus = Arc::new(bus);
    let own = bus.clone();
    let server = Running::with(Box::new(move |_| {
        let hook = Exchanged {
            bus: own.clone(),
            mode: Mode::Active,
        };
        Ok(Hooked::around(fast_bus::connect("demo:is2")?, hook))
    }));
    (server, bus)
}

const ACTIVE: &str = r#"{"port":"demo:is2","mode":"active"}"#;
const ZERO: &str = r#"{"zero":{}}"#;

fn refused(answer: &Answer) -> (u16, String) {
    (answer.status, answer.code())
}

#[test]
fn command_for_a_sensor_that_was_exchanged_is_refused_and_the_page_shows_the_new_one() {
    let (server, bus) = served(Bus::default());
    let device = server.post("/api/connect", ACTIVE).json();
    assert_eq!(
        (&device["serial"], &device["connection"]),
        (&json!(1), &json!(1))
    );
    let file = server.post("/api/backup", "{}").json()["text"].clone();
    let restore = json!({"text": file}).to_string();
    bus.is_other.store(true, Ordering::Relaxed);
    let mut tab = server.tab();
    let answer = server.post("/api/run", ZERO);
    assert_eq!(refused(&answer), (409, "other-sensor".to_owned()));
    let device = tab.wait("device", |device| device["connection"] == 2);
    assert_ne!(device["serial"], 1);
    // The page has shown the first one when the user has pressed the button.
    for (path, body) in [
        ("/api/run", ZERO),
        ("/api/run", r#"{"raw":{"request":"28"}}"#),
        ("/api/backup", "{}"),
        ("/api/restore", &restore),
    ] {
        let answer = server.post_for(Some(1), path, body);
        assert_eq!(refused(&answer), (409, "sensor-changed".to_owned()));
        let answer = server.post_for(None, path, body);
        assert_eq!(refused(&answer), (409, "sensor-changed".to_owned()));
    }
    assert_eq!(bus.zeros.load(Ordering::Relaxed), 0);
    assert_eq!(server.post_for(Some(2), "/api/run", ZERO).status, 200);
    assert!(bus.zeros.load(Ordering::Relaxed) > 0);
    // A request in hexadecimal as well.
    bus.is_other.store(false, Ordering::Relaxed);
    let zeros = bus.zeros.load(Ordering::Relaxed);
    let answer = server.post_for(Some(2), "/api/run", r#"{"raw":{"request":"28"}}"#);
    assert_eq!(refused(&answer), (409, "other-sensor".to_owned()));
    assert_eq!(bus.zeros.load(Ordering::Relaxed), zeros);
}

#[test]
fn sensor_that_answers_after_a_silence_is_identified_again() {
    let (server, bus) = served(Bus::default());
    assert_eq!(server.post("/api/connect", ACTIVE).status, 200);
    let mut tab = server.tab();
    bus.is_empty.store(true, Ordering::Relaxed);
    tab.wait("status", |status| status["silent"] == true);
    bus.is_other.store(true, Ordering::Relaxed);
    bus.is_empty.store(false, Ordering::Relaxed);
    let device = tab.wait("device", |device| device["connection"] == 2);
    assert_ne!(device["serial"], 1);
    tab.wait("samples", |_| true);
}

#[test]
fn command_of_a_page_that_shows_the_previous_sensor_is_refused() {
    let server = Running::connected("is2");
    let connect = |product: &str| {
        let body = json!({"port": format!("demo:{product}"), "mode": "active"}).to_string();
        server.post("/api/connect", &body).json()["connection"].clone()
    };
    // The same sensor keeps its number.
    assert_eq!(connect("is2"), 1);
    assert_eq!(connect("jn2101"), 2);
    let answer = server.post_for(Some(1), "/api/run", ZERO);
    assert_eq!(refused(&answer), (409, "sensor-changed".to_owned()));
    assert!(answer.body.contains("jn2101"), "{answer:?}");
    // Another node-ID does not make another sensor of it.
    run(&server, json!({"node-id": {"new": 11}}));
    assert_eq!(
        server.post_for(Some(2), "/api/run", r#""save""#).status,
        200
    );
}

#[test]
fn yes_answers_only_the_question_that_was_shown() {
    let busy = Bus {
        needs_rate: true,
        ..Bus::default()
    };
    let (server, bus) = served(busy);
    let connect = |yes: &[&Value]| {
        let body = json!({"port": "demo:is2", "mode": "active", "yes": yes});
        let answer = server.post("/api/connect", &body.to_string());
        assert_eq!(answer.code(), "asks", "{answer:?}");
        answer.json()["error"]["questions"][0].clone()
    };
    let silent = connect(&[]);
    assert_eq!(silent, json!({"id": "all-rates"}));
    // The machine is switched on before the user has answered.
    bus.is_busy.store(true, Ordering::Relaxed);
    let traffic = connect(&[&silent]);
    assert_eq!(traffic, json!({"id": "delivered"}));
    let body = json!({"port": "demo:is2", "mode": "active", "yes": [silent, traffic]});
    let answer = server.post("/api/connect", &body.to_string());
    assert_eq!(answer.status, 200, "{answer:?}");
    let body = json!({"port": "demo:is2", "mode": "active", "yes": true});
    let answer = server.post("/api/connect", &body.to_string());
    assert_eq!(answer.code(), "bad-request");
}

#[test]
fn page_asks_which_of_two_products_a_sensor_is() {
    let (server, bus) = served(Bus::default());
    bus.hides_version.store(true, Ordering::Relaxed);
    let asked = server.post("/api/connect", ACTIVE);
    assert_eq!(asked.code(), "asks", "{asked:?}");
    let questions = asked.json()["error"]["questions"].clone();
    for (place, product) in ["is2", "is2d"].into_iter().enumerate() {
        let question = &questions[place];
        assert_eq!(
            (&question["id"], &question["product"]),
            (&json!("which-product"), &json!(product))
        );
        let body = json!({"port": "demo:is2", "mode": "active", "yes": [question]});
        let device = server.post("/api/connect", &body.to_string());
        assert_eq!(device.status, 200, "{device:?}");
        assert_eq!(device.json()["product"], product, "{device:?}");
        assert_eq!(value(&server, "cyclic-time"), 250);
    }
}

#[test]
fn page_asks_before_it_uses_the_tables_of_another_product() {
    let (server, _) = served(Bus::default());
    let connect = |yes: &[&Value]| {
        let body = json!({"port": "demo:is2", "mode": "active", "product": "is1", "yes": yes});
        server.post("/api/connect", &body.to_string())
    };
    let asked = connect(&[]);
    assert_eq!(asked.code(), "asks", "{asked:?}");
    let question = asked.json()["error"]["questions"][0].clone();
    assert_eq!(
        (&question["id"], &question["product"]),
        (&json!("other-product"), &json!("is1"))
    );
    assert_eq!(connect(&[&question]).status, 200);
    // The commands have the same answer, also if the tool connects again.
    assert_eq!(value(&server, "cyclic-time"), 250);
    run(&server, json!({"rate": {"new": "500"}}));
    assert_eq!(value(&server, "cyclic-time"), 250);
}

#[test]
fn sensor_with_another_mac_id_by_set_or_restore_keeps_its_connection() {
    let server = Running::connected("tiltix080");
    let mut tab = server.tab();
    run(&server, json!({"set": {"assignments": ["mac-id=7"]}}));
    tab.wait("device", |device| device["address"] == "7");
    assert_eq!(value(&server, "mac-id"), 7);
    let file = server.post("/api/backup", "{}").json();
    let body = json!({"text": file["text"], "name": "mac-id", "value": "9"});
    let changed = server.post("/api/file/set", &body.to_string()).json();
    let body = json!({"text": changed["text"], "only": ["mac-id"]});
    let restored = server.post("/api/restore", &body.to_string());
    assert_eq!(restored.status, 200, "{restored:?}");
    let device = tab.wait("device", |device| device["address"] == "9");
    assert_eq!(device["connection"], 1);
    tab.wait("samples", |_| true);
    assert_eq!(value(&server, "mac-id"), 9);
}
