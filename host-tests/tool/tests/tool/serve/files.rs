//! Files of settings: the name of the sensor in them, and the data sheet that they belong to.

use crate::serve::api::{run, value};
use crate::serve::client::Running;
use crate::serve::data_sheets::{NODE, connect, data_sheet, send};
use serde_json::{Value, json};

#[test]
fn restore_gives_the_name_of_the_sensor_only_if_the_page_says_so() {
    let server = Running::connected("is2");
    run(&server, json!({"label": {"name": "boom left"}}));
    let file = server.post("/api/backup", "{}").json();
    assert_eq!(file["label"], "boom left");
    run(&server, json!({"label": {}}));
    let body = json!({"text": file["text"], "name": "cyclic-time", "value": "100 ms"});
    let file = server.post("/api/file/set", &body.to_string()).json();
    assert_eq!(file["label"], "boom left");
    let restore = |label: bool| {
        let body = json!({"text": file["text"], "name": "crane.toml", "only": ["cyclic-time"], "label": label});
        let restored = server.post("/api/restore", &body.to_string());
        assert_eq!(restored.status, 200, "{restored:?}");
    };
    restore(false);
    assert_eq!(value(&server, "cyclic-time"), 100);
    let device = server.tab().wait("device", |_| true);
    assert_eq!(device["label"], Value::Null);
    let mut tab = server.tab();
    restore(true);
    tab.wait("device", |device| device["label"] == "boom left");
    // Each of the two commands can be copied.
    for line in ["restore crane.toml --only cyclic-time", "label 'boom left'"] {
        let line = format!("plumbline --port demo:is2 --id 300 {line}");
        let mut tab = server.tab();
        tab.wait("action", |action| {
            action["line"] == line && action["state"] == "done"
        });
    }
}

#[test]
fn value_that_does_not_fit_another_value_of_the_file_is_refused() {
    let server = Running::new();
    let file = server.post("/api/file", r#"{"product": "is2"}"#).json();
    let set = |text: &Value, name: &str, value: &str| {
        let body = json!({"text": text, "name": name, "value": value});
        server.post("/api/file/set", &body.to_string())
    };
    // The filter as delivered is critically damped.
    let refused = set(&file["text"], "cut-off", "9000 mHz");
    assert_eq!(refused.code(), "out-of-range");
    let butterworth = set(&file["text"], "filter-type", "Butterworth").json();
    let changed = set(&butterworth["text"], "cut-off", "9000 mHz").json();
    assert_eq!(changed["values"]["cut-off"]["raw"], 9000);
    let body = json!({"text": changed["text"]}).to_string();
    assert_eq!(server.post("/api/file", &body).status, 200);
}

#[test]
fn file_of_a_device_belongs_to_its_data_sheet_and_not_to_a_newer_one_with_its_name() {
    let server = Running::new();
    let text = data_sheet("jn2101");
    let first = send(&server, "one.eds", &text).json();
    // The data sheet of another revision permits other values of the resolution.
    let (limit, other) = ("HighLimit=1000\r\n", "HighLimit=10\r\n");
    assert!(text.contains(limit), "{text}");
    let newer = send(&server, "two.eds", &text.replace(limit, other)).json();
    assert_eq!(
        (&first["sheet"], &newer["sheet"], &first["name"]),
        (&json!("eds:1"), &json!("eds:2"), &newer["name"])
    );
    connect(&server, "jn2101", NODE, &first["sheet"], &[]);
    let file = server.post("/api/backup", "{}").json();
    let set = |sheet: &str| {
        let body =
            json!({"text": file["text"], "name": "resolution", "value": "1000", "sheet": sheet});
        server.post("/api/file/set", &body.to_string())
    };
    assert_eq!(set("eds:2").code(), "out-of-range");
    let changed = set("eds:1").json();
    assert_eq!(
        (&changed["sheet"], &changed["values"]["resolution"]["raw"]),
        (&json!("eds:1"), &json!(1000))
    );
    let open = |sheet: Value| {
        let body = json!({"text": changed["text"], "sheet": sheet});
        server.post("/api/file", &body.to_string())
    };
    assert_eq!(open(json!("eds:1")).json(), changed);
    assert_eq!(open(json!(null)).code(), "bad-file");
    let body = json!({"text": changed["text"]}).to_string();
    let restored = server.post("/api/restore", &body);
    assert_eq!(restored.status, 200, "{restored:?}");
    assert_eq!(value(&server, "resolution"), 1000);
}
