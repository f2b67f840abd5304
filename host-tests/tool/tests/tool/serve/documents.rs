//! The answers of the server: the page reads them, so they do not change. A change that is wanted is recorded with `INSTA_UPDATE=always`.

use crate::serve::client::Running;
use insta::assert_snapshot;
use serde_json::{Value, json};

/// The answers of a server that is connected to a virtual sensor, without what differs from run to run.
fn answers(product: &str, requests: &[Value]) -> String {
    let server = Running::new();
    let mut shown = String::new();
    let mut ask = |path: &str, body: &Value| {
        let answer = server.post(path, &body.to_string());
        shown.push_str(&format!("POST {path} {body} => {}\n", answer.status));
        match answer.json() {
            Value::Object(rows) => {
                // The texts for people can change.
                for (name, value) in rows.into_iter().filter(|(name, _)| name != "texts") {
                    shown.push_str(&format!("  {name}: {value}\n"));
                }
            }
            other => shown.push_str(&format!("  {other}\n")),
        }
        answer
    };
    ask(
        "/api/connect",
        &json!({"port": format!("demo:{product}"), "mode": "active"}),
    );
    for request in requests {
        ask("/api/run", request);
    }
    ask("/api/samples", &json!({"perSecond": 10}));
    ask("/api/restore", &json!({"text": "nothing"}));
    ask("/api/run", &json!("nothing"));
    ask("/api/disconnect", &json!({}));
    ask("/api/run", &json!("save"));
    shown
}

#[test]
fn answers_for_a_sensor_of_each_protocol_are_those_recorded() {
    let set = |assignments: &[&str], save: bool| json!({"set": {"assignments": assignments, "save": save}});
    let label = json!({"label": {"name": "boom"}});
    assert_snapshot!(
        "is2",
        answers(
            "is2",
            &[
                json!({"get": {"names": ["filter", "cyclic-time"]}}),
                json!({"get": {"names": ["nothing"]}}),
                set(&["filter=2.5Hz,butterworth", "cyclic-time=100"], false),
                set(&["cyclic-time=0"], false),
                set(&["cyclic-time=101"], true),
                json!("save"),
                json!({"zero": {"axis": "z"}}),
                json!({"teach": {}}),
                label.clone(),
                json!({"label": {}}),
                json!("identity"),
                json!({"raw": {"request": "99"}}),
                json!({"rate": {"new": "77"}}),
                json!({"rate": {"new": "500"}}),
                json!("restart"),
                json!("load-factory"),
            ]
        )
    );
    assert_snapshot!(
        "jn2101",
        answers(
            "jn2101",
            &[
                json!({"get": {"names": ["filter"]}}),
                set(&["filter=1Hz"], false),
                json!("save"),
                json!({"node-id": {"new": 11}}),
                json!({"mac": {"new": 5}}),
                label.clone(),
                json!({"raw": {"request": "1018:1"}}),
                json!("identity"),
            ]
        )
    );
    assert_snapshot!(
        "tiltix080",
        answers(
            "tiltix080",
            &[
                json!({"get": {"names": ["cos-delta"]}}),
                set(&["cos-delta=0.5deg"], false),
                json!("save"),
                json!({"mac": {"new": 7}}),
                label,
                json!({"raw": {"request": "0E010101"}}),
                json!("restart"),
            ]
        )
    );
}
