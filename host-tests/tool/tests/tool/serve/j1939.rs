//! A sensor in J1939, by the requests of the page.

use crate::serve::api::{run, value};
use crate::serve::client::Running;
use serde_json::json;

#[test]
fn sensor_in_j1939_is_read_set_zeroed_and_stored() {
    let server = Running::connected("ims360/j1939");
    let mut tab = server.tab();
    let device = tab.wait("device", |device| !device.is_null());
    assert_eq!(
        (&device["protocol"], &device["address"], &device["product"]),
        (&json!("j1939"), &json!("128"), &json!("ims360"))
    );
    assert_eq!(device["angles"].as_array().map(Vec::len), Some(2));
    let values = tab.wait("values", |values| !values.is_null());
    assert_eq!(values["preferred-address"]["raw"], 128);
    let samples = tab.wait("samples", |samples| {
        samples["rows"]
            .as_array()
            .is_some_and(|rows| rows.len() > 1)
    });
    assert_eq!(samples["rows"][0].as_array().map(Vec::len), Some(3));
    run(
        &server,
        json!({"set": {"assignments": ["cut-off=2500mHz"], "save": true}}),
    );
    assert_eq!(value(&server, "cut-off"), 2500);
    run(&server, json!({"zero": {}}));
    run(&server, json!("save"));
    // A parameter group, and an object.
    let claim = run(&server, json!({"raw": {"request": "EE00"}}));
    assert_eq!(claim["answer"].as_str().map(str::len), Some(16), "{claim}");
    run(&server, json!({"raw": {"request": "1018:1"}}));
    let refused = server.post("/api/run", r#"{"node-id":{"new":11}}"#);
    assert_eq!(refused.code(), "not-offered");
}

#[test]
fn sensor_in_j1939_keeps_its_connection_with_another_address() {
    let server = Running::connected("ims360/j1939");
    run(&server, json!({"address": {"new": 160}}));
    let mut tab = server.tab();
    tab.wait("device", |device| device["address"] == "160");
    let action = tab.wait("action", |action| {
        action["state"] == "done"
            && action["line"]
                .as_str()
                .is_some_and(|line| line.contains(" address "))
    });
    assert_eq!(
        action["line"],
        "plumbline --port demo:ims360/j1939 --address 128 address 160"
    );
    tab.wait("samples", |_| true);
    assert_eq!(value(&server, "preferred-address"), 160);
    let out_of_range = server.post("/api/run", r#"{"address":{"new":255}}"#);
    assert_eq!(out_of_range.code(), "out-of-range");
    // The connection with the number that the user types.
    let connect = |address: &str| {
        let body = json!({
            "port": "demo:ims360/j1939", "rate": 250, "mode": "active", "protocol": "j1939", "address": address,
        });
        server.post("/api/connect", &body.to_string())
    };
    assert_eq!(connect("160").json()["address"], "160");
    assert_eq!(connect("254").code(), "out-of-range");
    assert_eq!(connect("128").code(), "no-answer");
    let canopen = Running::connected("jn2101");
    let refused = canopen.post("/api/run", r#"{"address":{"new":160}}"#);
    assert_eq!(refused.code(), "not-offered");
}

#[test]
fn sensor_in_j1939_that_a_scan_finds_can_be_connected() {
    let server = Running::new();
    let scan = server.post("/api/scan", r#"{"port":"demo:ims360/j1939","rate":250}"#);
    let rows = scan.json();
    assert_eq!(
        (&rows[0]["protocol"], &rows[0]["product"]),
        (&json!("j1939"), &json!("ims360")),
        "{rows}"
    );
    let body = json!({
        "port": "demo:ims360/j1939", "rate": rows[0]["rate"], "mode": "active",
        "protocol": rows[0]["protocol"], "address": rows[0]["address"],
    });
    let connected = server.post("/api/connect", &body.to_string());
    assert_eq!(connected.status, 200, "{connected:?}");
    let ports = server.get("/api/ports").json();
    let ports = ports["ports"].as_array().cloned().unwrap_or_default();
    assert!(ports.iter().any(|port| port["port"] == "demo:ims360/j1939"));
}
