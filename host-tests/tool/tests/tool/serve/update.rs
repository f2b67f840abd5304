//! Another program for a sensor, by the requests of the page, on the simulated microcontroller.

mod sensors;

use crate::bus::rig::Rig;
use crate::serve::client::Running;
use crate::serve::hooked::{Hook, Hooked, Received};
use crate::update::{Files, SERIAL, elf, rig};
use adapter::bench::BenchAdapter;
use adapter::{Adapter, AdapterError};
use host_tests::effort;
use plumbline::can::Frame;
use plumbline::time::Instant;
use serde_json::{Value, json};
use std::fs;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicI64, Ordering};
use std::thread;
use std::time::Duration;

/// A bus with a sensor. After this number of frames the wire is broken; -1: never.
struct Plugged {
    /// The bus with its devices.
    _rig: Rig,
    left: Arc<AtomicI64>,
}

impl Hook for Plugged {
    fn send(&mut self, adapter: &mut dyn Adapter, frame: &Frame) -> Result<(), AdapterError> {
        // One step: the test sets the number meanwhile.
        let left = self
            .left
            .fetch_update(Ordering::Relaxed, Ordering::Relaxed, |left| {
                (left > 0).then(|| left - 1)
            });
        match left {
            Err(0) => Ok(()),
            _ => adapter.send(frame),
        }
    }

    fn receive(&mut self, adapter: &mut dyn Adapter, until: Instant) -> Received {
        // Leaves the processor to others between polls. No assertion depends on this pause.
        thread::sleep(Duration::from_micros(20));
        adapter.receive(until)
    }
}

/// A server with a JN2101 behind a bootloader, and the number of frames until its wire is broken.
fn server() -> (Running, Arc<AtomicI64>) {
    // Here, because the build of the images can last longer than a request.
    elf("bootloader");
    server_at(|| rig("jn2101"))
}

/// The same with the sensors of a bus.
fn server_at(bus: impl Fn() -> Rig + Send + 'static) -> (Running, Arc<AtomicI64>) {
    let left = Arc::new(AtomicI64::new(-1));
    let own = left.clone();
    let server = Running::with(Box::new(move |_| {
        let rig = bus();
        let adapter = BenchAdapter::new(&rig.bus);
        let left = own.clone();
        Ok(Hooked::new(adapter, Plugged { _rig: rig, left }))
    }));
    (server, left)
}

/// Where the sensor is.
fn place() -> Value {
    json!({"port": "bench", "mode": "active", "rate": 500, "protocol": "canopen", "address": "10"})
}

fn connect(server: &Running) {
    // Without samples, the simulation rests between the requests.
    assert_eq!(
        server.post("/api/samples", r#"{"perSecond":0}"#).status,
        200
    );
    let answer = server.post("/api/connect", &place().to_string());
    assert_eq!(answer.status, 200, "{answer:?}");
}

/// The request with this file.
fn body(path: &Path, more: Value) -> String {
    let image = fs::read(path).expect("the file");
    let mut body = json!({"name": "FILE.plu", "image": image});
    for (name, value) in more.as_object().into_iter().flatten() {
        body[name] = value.clone();
    }
    body.to_string()
}

#[test]
fn update_in_the_page_loads_the_file_and_compares_the_settings() {
    let (server, _) = server();
    let files = Files::new("jn2101", "page");
    let newer = files.image(1);
    let about = server.post("/api/image", &body(&newer, json!({})));
    let version = about.json()["version"].as_str().map(str::to_owned);
    assert_eq!(about.json()["product"], "jn2101");
    assert_eq!(about.json()["board"], "bluepill");
    connect(&server);
    let backup = server.post("/api/backup", "{}").json();
    assert_eq!(backup["serial"], SERIAL);
    let mut tab = server.tab();
    let wanted = json!({"backup": backup["text"]});
    let answer = server.post("/api/update", &body(&newer, wanted));
    let done = answer.json();
    assert_eq!(done["loaded"], true, "{done}");
    assert_eq!(done["version"].as_str().map(str::to_owned), version);
    assert_ne!(done["before"], done["version"], "{done}");
    assert!(done["before"].is_string(), "{done}");
    assert_eq!(done["different"], 0);
    let progress = tab.wait("progress", |progress| progress["done"] == progress["total"]);
    assert!(progress["texts"]["de"].is_string());
    let line = "plumbline --port bench --rate 500 --node 10 update --no-backup FILE.plu";
    tab.wait("action", |action| {
        action["line"] == line && action["state"] == "done"
    });
    // The sensor is connected again.
    let read = r#"{"get":{"names":["heartbeat-time"]}}"#;
    assert_eq!(server.post("/api/run", read).status, 200);
    let again = server.post("/api/update", &body(&newer, json!({}))).json();
    assert_eq!(
        (&again["loaded"], &again["different"]),
        (&json!(false), &Value::Null)
    );
}

#[test]
fn older_file_is_a_question_and_a_file_for_another_product_an_error() {
    let (server, _) = server();
    connect(&server);
    let other = Files::new("is2", "page-other").image(1);
    let refused = server.post("/api/update", &body(&other, json!({})));
    assert_eq!(refused.code(), "wrong-image");
    let files = Files::new("jn2101", "page-older");
    let older = files.image(-1);
    let asked = server.post("/api/update", &body(&older, json!({})));
    assert_eq!(asked.code(), "asks");
    let question = &asked.json()["asks"][0]["question"];
    assert_eq!(question["id"], "downgrade");
    // The program of before runs again.
    let same = server.post("/api/update", &body(&files.same(), json!({})));
    assert_eq!(same.json()["loaded"], false, "{same:?}");
    if effort::choose(false, true) {
        let done = server.post("/api/update", &body(&older, json!({"yes": [question]})));
        assert_eq!(done.json()["before"], question["own"]);
        assert_eq!(done.json()["version"], question["file"]);
    }
    let damaged = json!({"name": "FILE.plu", "image": [1, 2, 3]}).to_string();
    for path in ["/api/image", "/api/update"] {
        let refused = server.post(path, &damaged);
        assert_eq!(refused.code(), "bad-file");
        let texts = refused.json()["texts"].clone();
        assert!(
            texts["de"]
                .as_str()
                .unwrap()
                .starts_with("FILE.plu ist nicht gültig")
        );
    }
}

#[test]
fn sensor_that_waits_in_its_bootloader_takes_the_file() {
    let (server, left) = server();
    let files = Files::new("jn2101", "page-waits");
    let newer = files.image(1);
    connect(&server);
    // Its program runs: no bootloader waits.
    let refused = server.post("/api/update", &body(&newer, json!({"waiting": place()})));
    assert_eq!(refused.code(), "no-answer");
    connect(&server);
    left.store(400, Ordering::Relaxed);
    let failed = server.post("/api/update", &body(&newer, json!({})));
    assert_eq!((failed.status, failed.code().as_str()), (504, "no-answer"));
    left.store(-1, Ordering::Relaxed);
    let waiting = json!({"waiting": place()});
    let done = server.post("/api/update", &body(&newer, waiting)).json();
    // The download was not complete, so there is no program before.
    assert_eq!(
        (&done["loaded"], &done["before"]),
        (&json!(true), &Value::Null),
        "{done}"
    );
    let mut tab = server.tab();
    tab.wait("device", |device| device["product"] == "jn2101");
}
