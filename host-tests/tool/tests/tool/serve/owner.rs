//! One tab is in charge; what the server remembers; and where a sensor is after a restart.

use crate::serve::api::run;
use crate::serve::client::{Running, until};
use crate::serve::fast_bus;
use serde_json::{Value, json};

/// A request of a tab with this name.
fn post(server: &Running, tab: &str, path: &str, body: &Value) -> (u16, Value) {
    let token = server.token.clone();
    let headers = [
        ("X-Plumbline-Token", &*token),
        ("Content-Type", "application/json"),
        ("X-Plumbline-Tab", tab),
    ];
    let answer = server.request(&format!("POST {path}"), &headers, &body.to_string());
    (answer.status, answer.json())
}

#[test]
fn tab_that_is_not_in_charge_is_refused_until_it_takes_over() {
    let server = Running::new();
    let connect = json!({"port": "demo:is2", "mode": "active"});
    let one = server.named_tab("one");
    let mut two = server.named_tab("two");
    two.wait("owner", |owner| owner == "one");
    let (status, refused) = post(&server, "two", "/api/connect", &connect);
    assert_eq!(
        (status, &refused["error"]["code"]),
        (409, &json!("other-tab"))
    );
    // What needs no bus is for all tabs.
    let file = json!({"product": "is2"});
    assert_eq!(post(&server, "two", "/api/file", &file).0, 200);
    assert_eq!(post(&server, "two", "/api/owner", &json!({})).0, 200);
    two.wait("owner", |owner| owner == "two");
    assert_eq!(post(&server, "one", "/api/connect", &connect).0, 409);
    assert_eq!(post(&server, "two", "/api/connect", &connect).0, 200);
    // Another tab can act when this one is closed.
    drop(two);
    until("tab that may act", || {
        post(&server, "one", "/api/disconnect", &json!({})).0 == 200
    });
    drop(one);
}

#[test]
fn port_is_remembered_by_the_program() {
    let server = Running::with(Box::new(|_| fast_bus::connect("demo:is2")));
    let port = |server: &Running| server.get("/api/ports").json()["first"]["port"].clone();
    assert_eq!(port(&server), "");
    let body = json!({"port": "slcan:/dev/ttyACM7", "mode": "active"});
    assert_eq!(server.post("/api/connect", &body.to_string()).status, 200);
    assert_eq!(port(&server), "slcan:/dev/ttyACM7");
    let folder = server.config.path().to_owned();
    let told = std::fs::read_to_string(folder.join("last.toml")).expect("a file");
    assert!(told.contains("port = \"slcan:/dev/ttyACM7\""), "{told}");
}

#[test]
fn new_identifiers_are_followed_after_restart_and_restore() {
    for (product, settings, moved, back) in [
        ("is2", &["set-id=310h", "reply-id=311h"][..], "310", "300"),
        ("jn2101", &["node-id=33"], "33", "10"),
        ("ims360", &["node-id=33"], "33", "50"),
    ] {
        let server = Running::connected(product);
        let delivered = server.post("/api/backup", "{}").json();
        run(
            &server,
            json!({"set": {"assignments": settings, "save": true}}),
        );
        run(&server, json!("restart"));
        let mut tab = server.tab();
        tab.wait("device", |device| device["address"] == moved);
        tab.wait("samples", |_| true);
        let body = json!({"text": delivered["text"], "only": []});
        let answer = server.post("/api/restore", &body.to_string());
        assert_eq!(answer.status, 200, "{product} {answer:?}");
        run(&server, json!("restart"));
        let mut tab = server.tab();
        tab.wait("device", |device| device["address"] == back);
        tab.wait("samples", |_| true);
    }
}
