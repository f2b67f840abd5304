//! The offset of the mounting by the requests of the page: each question ends a request, and the next one has its yes.

use crate::bus::rig::{Rig, tilt};
use crate::serve::client::Running;
use crate::serve::hooked::{Hook, Hooked, Received, paced};
use adapter::Adapter;
use adapter::bench::BenchAdapter;
use plumbline::time::Instant;
use serde_json::{Value, json};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// A bus with a sensor that somebody turns: it is mounted with X = 1 deg and Y = -0.5 deg, on a surface with X = 2 deg.
struct Mounted {
    rig: Rig,
    is_turned: Arc<AtomicBool>,
    was_turned: bool,
}

impl Hook for Mounted {
    fn receive(&mut self, adapter: &mut dyn Adapter, until: Instant) -> Received {
        let is_turned = self.is_turned.load(Ordering::Relaxed);
        if is_turned && !self.was_turned {
            self.was_turned = true;
            let id = self.rig.first();
            let motion = tilt(-1.0, -0.5);
            self.rig.bus.borrow_mut().device_mut(id).set_motion(motion);
            // Until the filters of the sensor have settled.
            self.rig.run(3000);
        }
        paced(adapter, until)
    }
}

/// A server that is connected to the sensor, and the switch that turns it.
fn mounted() -> (Running, Arc<AtomicBool>) {
    let is_turned = Arc::new(AtomicBool::new(false));
    let own = is_turned.clone();
    let server = Running::with(Box::new(move |_| {
        let mut rig = Rig::with("is2");
        let id = rig.first();
        rig.bus
            .borrow_mut()
            .device_mut(id)
            .set_motion(tilt(3.0, -0.5));
        rig.run(3000);
        let adapter = BenchAdapter::new(&rig.bus);
        let hook = Mounted {
            rig,
            is_turned: own.clone(),
            was_turned: false,
        };
        Ok(Hooked::new(adapter, hook))
    }));
    let wanted = json!({"port": "bench", "mode": "active", "rate": 125, "protocol": "fsc", "address": "300"});
    let answer = server.post("/api/connect", &wanted.to_string());
    assert_eq!(answer.status, 200, "{answer:?}");
    (server, is_turned)
}

/// The question of the request with these answers, with its texts.
#[track_caller]
fn asked(server: &Running, yes: &[Value]) -> (Value, Value) {
    let answer = server.post("/api/align", &json!({"yes": yes}).to_string());
    assert_eq!(answer.code(), "asks");
    let asks = &answer.json()["asks"][0];
    (asks["question"].clone(), asks["texts"].clone())
}

#[test]
fn align_by_two_answers_makes_the_offset_of_the_mounting_zero() {
    let (server, is_turned) = mounted();
    let (turn, texts) = asked(&server, &[]);
    assert_eq!(turn["id"], "turn");
    for (language, start) in [
        ("en", "angle-x 3.00 deg, spread 0.00 deg; angle-y -0.50 deg"),
        ("de", "angle-x 3,00 deg, Spanne 0,00 deg; angle-y -0,50 deg"),
    ] {
        let text = texts[language].as_str().unwrap();
        assert!(text.starts_with(start), "{text}");
    }
    is_turned.store(true, Ordering::Relaxed);
    // Each question measures nothing anew: the angles of the first position are those of the turned sensor now.
    let yes = [turn.clone()];
    let (zero, texts) = asked(&server, &yes);
    assert_eq!(zero["id"], "align");
    let text = texts["de"].as_str().unwrap();
    assert!(text.contains("Montage 1,00 deg, Fläche 2,00 deg"), "{text}");
    let read = json!({"get": {"names": ["zero-x"]}}).to_string();
    assert_eq!(
        server.post("/api/run", &read).json()["zero-x"]["value"],
        0.0
    );
    let mut tab = server.tab();
    let body = json!({"yes": [turn, zero]}).to_string();
    let report = server.post("/api/align", &body).json();
    assert_eq!(report["offsets"]["zero-x"]["value"], -1.0, "{report}");
    let status = tab.wait("status", |status| status["unsaved"] != json!([]));
    assert_eq!(status["unsaved"], json!(["zero-x", "zero-y"]));
}

#[test]
fn answer_to_a_question_of_another_measurement_measures_again() {
    let (server, is_turned) = mounted();
    let (turn, _) = asked(&server, &[]);
    is_turned.store(true, Ordering::Relaxed);
    // A new request forgets what was measured before.
    let (other, _) = asked(&server, &[]);
    assert_ne!(other, turn);
    assert_eq!(asked(&server, &[turn]).0, other);
    let sensor = server.post_for(Some(99), "/api/align", r#"{"save":true}"#);
    assert_eq!(sensor.code(), "sensor-changed");
    assert_eq!(server.post("/api/disconnect", "{}").status, 200);
    assert_eq!(server.post("/api/align", "{}").code(), "not-connected");
}

/// The page ends without a question. `bus/align.rs` has all products.
#[test]
fn sensor_that_reports_an_error_is_not_aligned() {
    let server = Running::connected("tiltix080");
    for request in [
        json!({"do": "tilt", "x": 3, "y": -1}),
        json!({"do": "accelerometer", "fault": "axis-z"}),
    ] {
        let answer = server.post("/api/stand-in", &request.to_string());
        assert_eq!(answer.status, 200, "{request}: {answer:?}");
    }
    let answer = server.post("/api/align", "{}");
    assert_eq!(answer.code(), "no-angle", "{answer:?}");
    let texts = &answer.json()["texts"];
    for (language, start) in [
        (
            "en",
            "the sensor reports an error, so its angles are not valid",
        ),
        (
            "de",
            "der Sensor meldet einen Fehler, deshalb sind seine Winkel nicht gültig",
        ),
    ] {
        let text = texts[language].as_str().unwrap_or_default();
        assert!(text.starts_with(start), "{language}: {texts}");
    }
}
