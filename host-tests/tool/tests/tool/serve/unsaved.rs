//! The values that are written, but not stored: the status names them until they are stored or lost.

use crate::serve::api::run;
use crate::serve::client::{Running, Tab};
use serde_json::{Value, json};

/// Waits until the status names these values.
#[track_caller]
fn wait(tab: &mut Tab, names: &[&str]) {
    tab.wait("status", |status| {
        status["busy"].is_null() && status["unsaved"] == json!(names)
    });
}

#[test]
fn value_that_is_written_is_unsaved_until_a_save_or_a_restart() {
    for (product, name, text, other, second) in [
        ("is2", "cut-off", "2.5Hz", "cyclic-time", "100"),
        ("jn2101", "filter", "1 Hz", "heartbeat-interval-time", "500"),
        ("ims360", "cut-off", "2500mHz", "filter-type", "Butterworth"),
    ] {
        let server = Running::connected(product);
        let mut tab = server.tab();
        let set = |name: &str, text: &str, save: bool| json!({"set": {"assignments": [format!("{name}={text}")], "save": save}});
        for end in [
            json!("save"),
            json!("restart"),
            json!("load-factory"),
            set(name, text, true),
        ] {
            wait(&mut tab, &[]);
            run(&server, set(name, text, false));
            wait(&mut tab, &[name]);
            run(&server, json!({"get": {"names": [other]}}));
            run(&server, end);
        }
        wait(&mut tab, &[]);
        run(&server, set(name, text, false));
        run(&server, set(other, second, false));
        wait(&mut tab, &[name, other]);
        // Another sensor has none of them.
        let body = json!({"port": "demo:is1", "mode": "active"});
        assert_eq!(server.post("/api/connect", &body.to_string()).status, 200);
        wait(&mut tab, &[]);
    }
}

#[test]
fn value_that_the_sensor_stores_by_itself_is_not_unsaved() {
    let server = Running::connected("tiltix080");
    let mut tab = server.tab();
    for action in [
        json!({"set": {"assignments": ["cos-delta=0.5deg"]}}),
        json!({"zero": {}}),
    ] {
        run(&server, action);
        tab.wait("action", |action| action["state"] == "done");
        let status = tab.wait("status", |status| status["busy"].is_null());
        assert_eq!(status["unsaved"], json!([]));
    }
}

#[test]
fn zero_point_that_is_not_stored_is_unsaved() {
    let server = Running::connected("is2");
    let mut tab = server.tab();
    run(&server, json!({"zero": {"save": false}}));
    let status = tab.wait("status", |status| status["unsaved"] != json!([]));
    let names: Vec<&str> = status["unsaved"]
        .as_array()
        .into_iter()
        .flatten()
        .filter_map(Value::as_str)
        .collect();
    assert!(names.iter().all(|name| name.contains("zero")), "{names:?}");
    run(&server, json!({"zero": {"save": true}}));
    wait(&mut tab, &[]);
}

#[test]
fn value_that_the_sensor_has_no_longer_is_not_unsaved() {
    let server = Running::connected("jn2101");
    let mut tab = server.tab();
    let assignments = ["heartbeat-interval-time=500", "filter=1 Hz"];
    run(&server, json!({"set": {"assignments": assignments}}));
    wait(&mut tab, &["heartbeat-interval-time", "filter"]);
    run(&server, json!({"raw": {"request": "1017:0=0000"}}));
    wait(&mut tab, &["filter"]);
}
