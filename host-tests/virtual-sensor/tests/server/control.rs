//! Clients that control the sensor (`--control`).

use crate::process::assert_fails;
use crate::process::client::{BOOT_UP, Client, POLL, REPLY};
use crate::process::control::{Control, start};
use crate::process::sensor::Sensor;
use serde_json::{Value, json};
use std::net::Shutdown;

#[test]
fn dialogs_of_readme_are_those_of_the_program() {
    let readme = include_str!("../../README.md");
    let mut current: Option<(Sensor, Control)> = None;
    let mut dialogs = 0;
    for line in readme.lines() {
        if let Some(command) = line.strip_prefix("$ virtual-sensor --control 0 ") {
            let arguments = shlex::split(command).expect("a command line");
            let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
            let (sensor, port) = start(&arguments);
            current = Some((sensor, Control::connect(port)));
            dialogs += 1;
        } else if let Some(request) = line.strip_prefix("> ") {
            let (_, control) = current.as_mut().expect("a command line");
            control.say(format!("{request}\n").as_bytes());
        } else if let Some(expected) = line.strip_prefix("< ") {
            let (_, control) = current.as_mut().expect("a command line");
            let expected: Value = serde_json::from_str(expected).expect("JSON");
            assert_eq!(control.next(), Some(expected));
        }
    }
    assert!(dialogs > 4);
}

#[test]
fn lost_and_late_frames_are_on_the_bus_but_not_at_the_client() {
    let (sensor, port) = start(&["--clock", "client", "--scene", "tilt=3,4"]);
    let mut control = Control::connect(port);
    let mut client = Client::open(&sensor);
    control.ok(&json!({ "do": "subscribe", "events": ["frames"] }));
    client.expect(POLL, "z");
    control.frames(0.2);
    client.find(BOOT_UP);
    client.find(BOOT_UP);
    let lose = json!({ "do": "lose", "count": 1, "from": "sensors", "identifier": "301" });
    assert_eq!(control.ok(&lose)["clients"], 1);
    let delay = json!({ "do": "delay", "count": 1, "from": "sensors", "seconds": 0.5 });
    control.ok(&delay);
    for _ in 0..2 {
        client.expect(POLL, "z");
        let frames = control.frames(0.1);
        assert!(
            frames.iter().any(|frame| frame.starts_with("301#00")),
            "{frames:?}"
        );
    }
    // Nothing has come before the answer.
    client.expect("V", "V1010");
    control.frames(0.6);
    assert!(client.next().is_some_and(|line| line.starts_with('#')));
    assert!(client.next().is_some_and(|line| line.starts_with(REPLY)));
    control.ok(&json!({ "do": "lose", "count": 1, "from": "clients" }));
    client.expect(POLL, "z");
    assert_eq!(control.frames(0.1), [""; 0]);
    control.ok(&json!({ "do": "delay", "count": 1, "from": "clients", "seconds": 0.2 }));
    client.expect(POLL, "z");
    assert_eq!(control.frames(0.19), [""; 0]);
    assert_eq!(control.frames(0.1).len(), 2);
}

#[test]
fn nonsense_gets_an_error_and_changes_nothing() {
    let (sensor, port) = start(&["--clock", "client", "--scene", "tilt=3,4"]);
    let mut control = Control::connect(port);
    let before = control.ok(&json!({ "do": "state" }));
    for bad in [
        "{",
        "[]",
        "null",
        "\"do\"",
        "{}",
        r#"{"do":1}"#,
        r#"{"do":"tilt","x":1}"#,
        r#"{"do":"tilt","x":"1","y":2}"#,
        r#"{"do":"tilt","x":1e999,"y":2}"#,
        r#"{"do":"tilt","x":1,"y":2,"sensor":5}"#,
        r#"{"do":"tilt","x":1,"y":2,"sensor":"is1"}"#,
        r#"{"do":"tilt","x":1,"y":2,"x":3}"#,
        r#"{"do":"state","do":"restart"}"#,
        r#"{"do":"state","all":true}"#,
        r#"{"do":"rate","x":1,"y":2,"seconds":-1}"#,
        r#"{"do":"scene"}"#,
        r#"{"do":"scene","file":"/dev/zero"}"#,
        r#"{"do":"scene","file":"a","csv":"b"}"#,
        r#"{"do":"temperature","celsius":1e9}"#,
        r#"{"do":"temperature"}"#,
        r#"{"do":"supply","volts":-1}"#,
        r#"{"do":"supply"}"#,
        r#"{"do":"accelerometer"}"#,
        r#"{"do":"memory"}"#,
        r#"{"do":"memory","fault":"broken"}"#,
        r#"{"do":"damage"}"#,
        r#"{"do":"bus-off"}"#,
        r#"{"do":"corrupt","count":-1}"#,
        r#"{"do":"send","frame":"300"}"#,
        r#"{"do":"send","frame":"800#"}"#,
        r#"{"do":"advance","seconds":1,"sensor":"is2"}"#,
        r#"{"do":"advance","seconds":-1}"#,
        r#"{"do":"subscribe","events":"leds"}"#,
        "\u{0}\u{1}\u{7f}",
    ] {
        let (events, answer) = control.ask(bad);
        assert!(
            answer["error"].is_string() && events.is_empty(),
            "{bad}: {answer}"
        );
    }
    control.say(b"\xFF\xFE{\"do\"\n");
    assert!(control.next().expect("an answer")["error"].is_string());
    // Lines of 1 MiB and more, and empty lines, which are no requests.
    for length in [1 << 20, 5 << 20] {
        control.say(&vec![b'['; length]);
        control.say(b"\r\n\r\n\n");
        assert!(control.next().expect("an answer")["error"].is_string());
    }
    // A client that leaves in the middle of a line, and one that does not read.
    let mut half = Control::connect(port);
    half.say(br#"{"do":"tilt","x":50"#);
    half.0
        .get_mut()
        .shutdown(Shutdown::Write)
        .expect("a socket");
    assert_eq!(half.next(), None);
    assert_eq!(control.ok(&json!({ "do": "state" })), before);
    Client::open(&sensor);
}

#[test]
fn each_client_sees_its_events_and_what_the_others_do() {
    let (_sensor, port) = start(&["--clock", "client", "--scene", "tilt=3,4"]);
    let (mut one, mut other) = (Control::connect(port), Control::connect(port));
    one.ok(&json!({ "do": "subscribe", "events": ["state"] }));
    other.ok(&json!({ "do": "power", "on": false }));
    let event = one.next().expect("an event");
    assert_eq!(
        (&event["event"], &event["on"]),
        (&json!("state"), &json!(false))
    );
    one.ok(&json!({ "do": "subscribe", "events": [] }));
    other.ok(&json!({ "do": "power", "on": true }));
    let (events, _) = one.ask(r#"{"do":"sensors"}"#);
    assert_eq!(events, [Value::Null; 0]);
}

#[test]
fn time_of_the_computer_cannot_be_advanced() {
    let (_sensor, port) = start(&[]);
    let (_, answer) = Control::connect(port).ask(r#"{"do":"advance","seconds":1}"#);
    let error = answer["error"].as_str().expect("an error");
    assert!(error.contains("--clock client"), "{error}");
}

#[test]
fn place_for_control_that_is_in_use_or_wrong_is_named() {
    let (_sensor, port) = start(&[]);
    let used = port.to_string();
    for place in [&used, "nonsense", "99999"] {
        let arguments = ["--listen", "127.0.0.1:0", "--control", place];
        let message = format!("cannot listen at {place} for control");
        assert_fails(&arguments, 1, &[&message]);
    }
}
