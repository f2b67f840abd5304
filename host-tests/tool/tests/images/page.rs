//! Another program for a sensor, by the requests of the page, on the simulated microcontroller.

use crate::client::Running;
use crate::plugged::{body, server_at};
use crate::update::{Files, SERIAL, elf, rig, rig_behind, signed_bootloader};
use host_tests::effort;
use plumbline_tool::image::ImageFile;
use plumbline_tool::signing::KeyFile;
use serde_json::{Value, json};
use std::fs;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicI64, Ordering};

/// A server with a JN2101 behind a bootloader, and the number of frames until its wire is broken.
fn server() -> (Running, Arc<AtomicI64>) {
    // Builds the images first: this can last longer than a request.
    elf("bootloader");
    server_at(|| rig("jn2101"))
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

#[test]
fn sensor_with_a_key_takes_the_signed_file() {
    let files = Files::new("jn2101", "page-signed");
    let unsigned = files.image(1);
    let mut key = KeyFile::create(&unsigned.with_file_name("own.key")).unwrap();
    let public = key.public();
    let image = ImageFile::parse(fs::read(&unsigned).unwrap()).unwrap();
    let signed = unsigned.with_file_name("signed.plu");
    fs::write(&signed, image.signed(&mut key).unwrap().bytes).unwrap();
    let (server, _) = server_at(move || {
        let bootloader = signed_bootloader().with_key(&public).unwrap();
        rig_behind(&bootloader, "jn2101")
    });
    connect(&server);
    let post = |path: &str, file: &PathBuf| server.post(path, &body(file, json!({})));
    assert_eq!(post("/api/image", &unsigned).json()["signed"], false);
    assert_eq!(post("/api/image", &signed).json()["signed"], true);
    assert_eq!(post("/api/update", &unsigned).code(), "unsigned-image");
    // The program of before runs again.
    let backup = server.post("/api/backup", "{}").json();
    assert_eq!(backup["serial"], SERIAL);
    assert_eq!(post("/api/update", &signed).json()["loaded"], true);
}
