//! The requests of the page, with virtual sensors.

use crate::serve::client::Running;
use serde_json::{Value, json};

pub fn run(server: &Running, body: Value) -> Value {
    let answer = server.post("/api/run", &body.to_string());
    assert_eq!(answer.status, 200, "{body} {answer:?}");
    answer.json()
}

pub fn value(server: &Running, name: &str) -> Value {
    run(server, json!({"get": {"names": [name]}}))[name]["value"].clone()
}

#[test]
fn catalogue_is_the_one_of_the_command_line() {
    let server = Running::new();
    let products = server.get("/api/products").json();
    let names: Vec<&str> = products
        .as_array()
        .expect("a list")
        .iter()
        .filter_map(|product| product["name"].as_str())
        .collect();
    assert!(
        ["is2", "jn2101", "ims360", "tiltix080"]
            .iter()
            .all(|name| names.contains(name))
    );
    let sheet = server.get("/api/parameters/is2").json();
    let entries = sheet["entries"].as_array().expect("a list");
    let cyclic = entries.iter().find(|entry| entry["name"] == "cyclic-time");
    let cyclic = cyclic.expect("a parameter");
    assert_eq!(
        (
            &cyclic["range"],
            &cyclic["factory"]["raw"],
            &cyclic["setting"]
        ),
        (&json!("1..65535 ms"), &json!(250), &json!(true))
    );
    let filter = entries.iter().find(|entry| entry["name"] == "filter-type");
    assert_eq!(
        filter.expect("a parameter")["choices"],
        json!([
            {"name": "off", "raw": 0},
            {"name": "Butterworth", "raw": 1},
            {"name": "critically damped", "raw": 2},
        ])
    );
    let answer = server.get("/api/parameters/is3");
    assert_eq!(
        (answer.status, answer.code().as_str()),
        (400, "unknown-product")
    );
    let ports = server.get("/api/ports").json();
    let demo = ports["ports"]
        .as_array()
        .expect("a list")
        .iter()
        .any(|port| port["port"] == "demo:is2");
    assert!(
        demo && ports["rates"]
            .as_array()
            .is_some_and(|rates| rates.len() == 10),
        "{ports}"
    );
}

#[test]
fn command_without_sensor_names_the_next_step() {
    let server = Running::new();
    for (path, body) in [
        ("/api/run", r#""save""#),
        ("/api/run", r#"{"zero":{}}"#),
        ("/api/backup", "{}"),
    ] {
        let answer = server.post(path, body);
        assert_eq!(
            (answer.status, answer.code().as_str()),
            (400, "not-connected"),
            "{path}"
        );
    }
    for (port, status) in [
        ("demo:is3", 400),
        ("", 400),
        ("slcan:/dev/nonexistent", 502),
        ("nonexistent0", 502),
    ] {
        let answer = server.post(
            "/api/connect",
            &json!({"port": port, "mode": "active"}).to_string(),
        );
        assert_eq!(answer.status, status, "{port} {answer:?}");
        answer.code();
    }
}

#[test]
fn sensor_of_every_protocol_is_set_zeroed_and_stored() {
    for (product, name, text, expected) in [
        ("is2", "cut-off", "2.5Hz", json!(2500)),
        ("jn2101", "filter", "1 Hz", json!(1)),
        ("ims360", "cut-off", "2500mHz", json!(2500)),
        ("tiltix080", "cos-delta", "0.5deg", json!(0.50)),
    ] {
        let server = Running::connected(product);
        let assignment = format!("{name}={text}");
        run(
            &server,
            json!({"set": {"assignments": [assignment], "save": product != "tiltix080"}}),
        );
        assert_eq!(value(&server, name), expected, "{product}");
        run(&server, json!({"zero": {}}));
        if product != "tiltix080" {
            run(&server, json!("save"));
        }
        run(&server, json!("load-factory"));
    }
}

#[test]
fn value_out_of_range_is_refused_and_changes_nothing() {
    let server = Running::connected("is2");
    for (assignment, code) in [
        ("cyclic-time=0", "out-of-range"),
        ("cyclic-time=70000", "out-of-range"),
        ("cyclic-time=quickly", "bad-value"),
        ("nothing=1", "unknown-name"),
        ("angle-x=1", "read-only"),
        ("cyclic-time", "bad-assignment"),
        ("--file=/etc/passwd", "unknown-name"),
        ("set-id=301", "out-of-range"),
    ] {
        let body = json!({"set": {"assignments": ["cyclic-mode=off", assignment]}});
        let answer = server.post("/api/run", &body.to_string());
        assert_eq!(
            (answer.status, answer.code().as_str()),
            (400, code),
            "{assignment}"
        );
    }
    assert_eq!(value(&server, "cyclic-time"), 250);
    assert_eq!(
        run(&server, json!({"raw": {"request": "02"}}))["request"],
        "02"
    );
}

#[test]
fn hostile_bodies_are_refused() {
    let server = Running::new();
    let deep = "[".repeat(100_000);
    for path in [
        "/api/connect",
        "/api/disconnect",
        "/api/scan",
        "/api/stop",
        "/api/run",
        "/api/samples",
        "/api/transmit",
        "/api/backup",
        "/api/calibrate",
        "/api/restore",
        "/api/file",
        "/api/file/set",
        "/api/eds",
    ] {
        for body in [
            "",
            "{",
            "null",
            "\u{0}",
            "[]",
            r#"{"unknown":1}"#,
            r#""zero""#,
            deep.as_str(),
        ] {
            let answer = server.post(path, body);
            assert_eq!(
                (answer.status, answer.code().as_str()),
                (400, "bad-request"),
                "{path} {body:.20}"
            );
        }
    }
    // The longest body has 3 MiB. A longer one is refused before it is sent.
    let head = format!(
        "POST /api/file HTTP/1.1\r\nHost: {}\r\nX-Plumbline-Token: {}\r\nContent-Type: application/json\r\nConnection: close\r\nContent-Length: 3145729\r\n\r\n",
        server.address, server.token
    );
    assert_eq!(server.send(&head).status, 413);
    let long = format!(
        r#"{{"text":"{}"}}"#,
        "x".repeat((3 << 20) - r#"{"text":""}"#.len())
    );
    assert_eq!(server.post("/api/file", &long).code(), "bad-file");
    assert_eq!(server.get("/api/stop").status, 404);
    assert_eq!(
        server.post("/api/samples", r#"{"perSecond":1001}"#).code(),
        "out-of-range"
    );
    assert_eq!(server.send("GET / HTTP/1.1\r\n\r\n").status, 403);
    assert_eq!(server.send("\u{1}\u{2}\r\n\r\n").status, 400);
    assert_eq!(server.get("/api/ports").status, 200);
}

#[test]
fn file_is_edited_without_sensor() {
    let server = Running::new();
    let file = server.post("/api/file", r#"{"product":"jn2101"}"#).json();
    let filter = json!({"value": 5, "unit": "Hz", "raw": 2});
    assert_eq!(file["values"]["filter"], filter);
    let set = |text: &Value, name: &str, value: &str| {
        let body = json!({"text": text, "name": name, "value": value});
        server.post("/api/file/set", &body.to_string())
    };
    let mut tab = server.tab();
    let changed = set(&file["text"], "filter", "1 Hz").json();
    let action = tab.wait("action", |_| true);
    assert_eq!(
        (&action["line"], &action["state"]),
        (
            &json!("plumbline set --file FILE.toml 'filter=1 Hz'"),
            &json!("done")
        )
    );
    assert_eq!(changed["values"]["filter"]["value"], 1);
    let body = json!({"text": changed["text"]}).to_string();
    assert_eq!(
        server.post("/api/file", &body).json()["values"],
        changed["values"]
    );
    for (name, value, code) in [
        ("filter", "3 Hz", "bad-value"),
        ("nothing", "1", "unknown-name"),
        ("slope-long16", "1", "read-only"),
        ("node-id", "128", "out-of-range"),
    ] {
        assert_eq!(
            set(&file["text"], name, value).code(),
            code,
            "{name}={value}"
        );
    }
    // Names are those of the command line: of a group, and the beginnings of words.
    let file = server.post("/api/file", r#"{"product":"is2"}"#).json();
    let changed = set(&file["text"], "filter", "9Hz,butterworth").json();
    let group = ["cut-off", "filter-type"].map(|name| changed["values"][name]["raw"].clone());
    assert_eq!(group, [json!(9000), json!(1)]);
    let changed = set(&file["text"], "cyclic-t", "0,5 S").json();
    assert_eq!(changed["values"]["cyclic-time"]["raw"], 500);
    assert_eq!(set(&file["text"], "filter", "9Hz").code(), "out-of-range");
    for text in [
        "",
        "x",
        "[sensor]",
        "[sensor]\nproduct = \"is3\"\n[parameters]\n",
        "\u{0}",
    ] {
        let body = json!({"text": text}).to_string();
        assert_eq!(server.post("/api/file", &body).code(), "bad-file", "{text}");
    }
}

#[test]
fn differences_of_a_file_are_written_and_stored() {
    for (product, name, text) in [
        ("is2", "cyclic-time", "100 ms"),
        ("jn2101", "heating", "off"),
    ] {
        let server = Running::connected(product);
        let file = server.post("/api/backup", "{}").json();
        assert_eq!(file["product"], product);
        let body = json!({"text": file["text"], "name": name, "value": text});
        let file = server.post("/api/file/set", &body.to_string()).json();
        let body = json!({"text": file["text"], "name": "crane.toml"}).to_string();
        let answer = server.post("/api/restore", &body);
        assert_eq!(answer.status, 200, "{answer:?}");
        let differences = answer.json()["differences"].clone();
        assert_eq!(
            differences.as_object().map(|all| all.len()),
            Some(1),
            "{differences}"
        );
        assert_eq!(value(&server, name), file["values"][name]["value"]);
        let other = server.post("/api/file", r#"{"product":"is1"}"#).json();
        let body = json!({"text": other["text"]}).to_string();
        assert_eq!(server.post("/api/restore", &body).code(), "wrong-file");
        let body = json!({"text": file["text"], "only": ["--yes"]}).to_string();
        assert_eq!(server.post("/api/restore", &body).code(), "unknown-name");
    }
}

#[test]
fn sensor_keeps_its_connection_with_another_address() {
    let server = Running::connected("jn2101");
    run(&server, json!({"node-id": {"new": 11}}));
    assert_eq!(value(&server, "node-id"), 11);
    let answer = server.post("/api/run", r#"{"node-id":{"new":0}}"#);
    assert_eq!(answer.code(), "out-of-range");
    assert_eq!(
        server.post("/api/run", r#"{"mac":{"new":1}}"#).code(),
        "not-offered"
    );
}

#[test]
fn sensor_keeps_its_connection_with_another_bit_rate() {
    for (product, rate) in [
        ("is2", 500),
        ("jn2101", 250),
        ("ims360", 1000),
        ("tiltix080", 500),
    ] {
        let server = Running::connected(product);
        let mut tab = server.tab();
        run(&server, json!({"rate": {"new": rate.to_string()}}));
        let status = tab.wait("status", |status| {
            status["state"] == "active" && status["rate"] == rate
        });
        assert_eq!(status["error"], Value::Null, "{product}");
        tab.wait("samples", |_| true);
        let refused = server.post("/api/run", r#"{"rate":{"new":"126"}}"#);
        assert_eq!(refused.code(), "bad-request");
    }
}

#[test]
fn name_of_the_sensor_is_shown_stored_and_taken_away() {
    let server = Running::connected("is2");
    let mut tab = server.tab();
    run(&server, json!({"label": {"name": "boom left"}}));
    tab.wait("device", |device| device["label"] == "boom left");
    let file = server.config.path().join("labels.toml");
    let text = std::fs::read_to_string(&file).expect("the names");
    assert!(text.contains("boom left"), "{text}");
    // A new connection knows it, and the line of the action can be copied.
    let action = server.tab().wait("action", |action| {
        action["state"] == "done" && action["n"] == 2
    });
    assert_eq!(
        action["line"],
        "plumbline --port demo:is2 --id 300 label 'boom left'"
    );
    let connected = server.post("/api/connect", r#"{"port":"demo:is2","mode":"active"}"#);
    assert_eq!(connected.json()["label"], "boom left");
    let long = json!({"label": {"name": "x".repeat(61)}}).to_string();
    assert_eq!(server.post("/api/run", &long).code(), "bad-value");
    run(&server, json!({"label": {}}));
    tab.wait("device", |device| device["label"].is_null());
    let text = std::fs::read_to_string(&file).expect("the names");
    assert!(!text.contains("boom"), "{text}");
}

#[test]
fn listening_sends_nothing_and_asks_for_the_rate_of_a_silent_bus() {
    let server = Running::new();
    let answer = server.post(
        "/api/connect",
        r#"{"port":"demo:is2","rate":125,"mode":"listen"}"#,
    );
    assert_eq!(answer.status, 200, "{answer:?}");
    let mut tab = server.tab();
    let status = tab.wait("status", |status| status["state"] == "listening");
    assert_eq!((&status["sent"], &status["rate"]), (&json!(0), &json!(125)));
    assert_eq!(server.post("/api/run", r#""save""#).code(), "not-connected");
    assert_eq!(
        server
            .post(
                "/api/connect",
                r#"{"port":"demo:is2","rate":126,"mode":"listen"}"#
            )
            .code(),
        "bad-request"
    );
    assert_eq!(
        server
            .post(
                "/api/connect",
                r#"{"port":"demo:is2","address":"1","mode":"active"}"#
            )
            .code(),
        "bad-request"
    );
    assert_eq!(server.post("/api/disconnect", "{}").status, 200);
}

#[test]
fn request_that_is_not_valid_is_told_in_german_without_english_words() {
    let server = Running::new();
    for (body, german) in [
        ("\"save", "kein JSON, ab Zeile 1, Spalte 5"),
        (
            "\"nothing\"",
            "einen Namen oder einen Wert, den es nicht gibt",
        ),
        (r#"{"node-id":{"new":256}}"#, "den es nicht gibt"),
        (r#"{"rate":{"new":"77"}}"#, "den es nicht gibt"),
    ] {
        let answer = server.post("/api/run", body);
        assert_eq!(answer.code(), "bad-request", "{body}");
        let own = answer.json()["texts"]["de"].to_string();
        assert!(own.contains("die Anfrage ist nicht gültig: sie"), "{own}");
        assert!(own.contains(german), "{own}");
        assert!(!own.contains("expected"), "{own}");
    }
    // The English text lists what there is.
    let answer = server.post("/api/run", "\"nothing\"").json();
    let english = answer["error"]["message"].to_string();
    for name in ["get", "node-id", "mac", "address", "identity"] {
        assert!(english.contains(&format!("`{name}`")), "{english}");
    }
}
