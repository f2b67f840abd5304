//! The virtual sensor of a demonstration, moved and broken by the requests of the page.

use crate::serve::client::{Running, Tab};
use serde_json::{Value, json};
use std::thread;

/// A request that is performed.
#[track_caller]
fn done(server: &Running, request: Value) {
    let answer = server.post("/api/stand-in", &request.to_string());
    assert_eq!(answer.status, 200, "{request}: {answer:?}");
}

/// Waits for a sample that is near these angles.
fn near(tab: &mut Tab, x: f64, y: f64) {
    tab.wait("samples", |samples| {
        let rows = samples["rows"].as_array();
        let mut rows = rows.into_iter().flatten();
        rows.any(|row| {
            let is = |place: usize, angle: f64| {
                let own = row[place].as_f64();
                own.is_some_and(|own| (own - angle).abs() < 0.1)
            };
            is(1, x) && is(2, y)
        })
    });
}

/// Waits for a bit of the status.
fn told(tab: &mut Tab, name: &str) {
    tab.wait("condition", |bits| {
        let mut bits = bits.as_array().into_iter().flatten();
        bits.any(|bit| bit["name"] == name)
    });
}

#[test]
fn demonstration_is_moved_and_broken_by_the_page() {
    let server = Running::connected("is2");
    let mut tab = server.tab();
    let state = tab.wait("stand-in", |state| !state.is_null());
    assert_eq!(state["on"], true);
    assert_eq!(state["temperature"], 25.0);
    done(&server, json!({"do": "tilt", "x": 12.5, "y": -20}));
    near(&mut tab, 12.5, -20.0);
    done(&server, json!({"do": "temperature", "celsius": 60}));
    let state = tab.wait("stand-in", |state| state["temperature"] == 60.0);
    assert_eq!((&state["x"], &state["y"]), (&json!(12.5), &json!(-20.0)));
    done(&server, json!({"do": "accelerometer", "fault": "axis-z"}));
    told(&mut tab, "SensorErrorX");
    done(&server, json!({"do": "accelerometer", "fault": null}));
    near(&mut tab, 12.5, -20.0);
    done(&server, json!({"do": "memory", "fault": "programming"}));
    tab.wait("stand-in", |state| state["memory"] == true);
    assert_eq!(server.post("/api/run", r#""save""#).status, 409);
    done(&server, json!({"do": "memory", "fault": null}));
    done(&server, json!({"do": "power", "on": false}));
    tab.wait("status", |status| status["silent"] == true);
    done(&server, json!({"do": "power", "on": true}));
    tab.wait("status", |status| status["silent"] == false);
}

#[test]
fn frames_of_a_demonstration_are_lost_and_late() {
    let server = Running::connected("is2");
    let mut tab = server.tab();
    tab.wait("samples", |_| true);
    let lost = |tab: &mut Tab, least: u64| {
        let status = tab.wait("status", |status| status["lost"].as_u64() >= Some(least));
        status["lost"].as_u64().unwrap_or_default()
    };
    let before = lost(&mut tab, 0);
    done(
        &server,
        json!({"do": "lose", "count": 2, "from": "sensors"}),
    );
    let before = lost(&mut tab, before + 2);
    let late = json!({"do": "delay", "count": 2, "from": "sensors", "seconds": 0.2});
    done(&server, late);
    lost(&mut tab, before + 2);
    tab.wait("samples", |samples| {
        samples["rows"][0].as_array().map(Vec::len) == Some(3)
    });
}

#[test]
fn demonstration_is_moved_while_an_action_waits_for_it() {
    let server = Running::connected("is2");
    let mut tab = server.tab();
    tab.wait("samples", |_| true);
    let aligned = thread::scope(|scope| {
        let align = scope.spawn(|| server.post("/api/align", "{}"));
        tab.wait("note", |note| {
            let text = note["texts"]["en"].as_str();
            text.is_some_and(|text| text.contains("not at rest"))
        });
        // It sways until it is placed on a surface.
        done(&server, json!({"do": "tilt", "x": 3, "y": -1}));
        align.join().expect("an answer")
    });
    assert_eq!(aligned.code(), "asks", "{aligned:?}");
}

#[test]
fn wrong_requests_to_a_virtual_sensor_change_nothing() {
    let server = Running::connected("is2");
    for (request, code) in [
        (json!({"do": "tilt", "x": 80, "y": 80}), "bad-value"),
        (json!({"do": "temperature", "celsius": 300}), "bad-value"),
        (
            json!({"do": "delay", "count": 1, "from": "sensors", "seconds": 99}),
            "bad-value",
        ),
        (
            json!({"do": "lose", "count": 1, "from": "clients"}),
            "bad-request",
        ),
        // The page reads no file of this computer.
        (json!({"do": "scene", "file": "/etc/passwd"}), "bad-request"),
        (json!({"do": "image"}), "bad-request"),
        (json!({"do": "tilt"}), "bad-request"),
        (json!({"do": "nothing"}), "bad-request"),
    ] {
        let answer = server.post("/api/stand-in", &request.to_string());
        assert_eq!(answer.code(), code, "{request}");
    }
    for (request, german) in [
        (
            json!({"do": "tilt", "x": 80, "y": 80.5}),
            "die Lage X = 80°, Y = 80,5° gibt es nicht",
        ),
        (
            json!({"do": "temperature", "celsius": 300}),
            "die Temperatur in °C ist -100 bis 200",
        ),
    ] {
        let answer = server.post("/api/stand-in", &request.to_string());
        let told = format!("der virtuelle Sensor lehnt ab: {german}");
        assert_eq!(answer.json()["texts"]["de"], told, "{request}");
    }
    let nobody = Running::new();
    let level = r#"{"do":"tilt","x":0,"y":0}"#;
    assert_eq!(nobody.post("/api/stand-in", level).code(), "not-connected");
}
