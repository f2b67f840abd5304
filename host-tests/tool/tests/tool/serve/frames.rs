//! The frames of each action of the page, counted by a second client on the bus.

use crate::bus::rig::Rig;
use crate::serve::api::run;
use crate::serve::client::{Running, until};
use crate::serve::hooked::{Hook, Hooked, Received};
use adapter::bench::BenchAdapter;
use adapter::{Adapter, AdapterError};
use plumbline::can::Frame;
use plumbline::time::{Duration, Instant, after, millis, reached};
use serde_json::{Value, json};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};

/// What the test and the thread of the adapter share.
#[derive(Default)]
struct Shared {
    seen: Mutex<Vec<Frame>>,
    /// The sensor is exchanged for another one, which does not have the connection.
    is_other: AtomicBool,
    /// Time passes only from a request to its answer, so nothing happens between two actions.
    is_still: AtomicBool,
}

/// A bus with a sensor and a witness.
struct Witnessed {
    rig: Rig,
    shared: Arc<Shared>,
    waits: bool,
    /// The time of the last request, or of the start.
    asked: Instant,
    is_exchanged: bool,
}

/// Time stands still so long after a request. A connection of DeviceNet ends after 10 s, and a busy computer is late with the first action.
const IDLE: Duration = millis(5000);

impl Hook for Witnessed {
    fn send(&mut self, adapter: &mut dyn Adapter, frame: &Frame) -> Result<(), AdapterError> {
        self.waits = true;
        self.asked = adapter.now();
        adapter.send(frame)
    }

    fn receive(&mut self, adapter: &mut dyn Adapter, until: Instant) -> Received {
        let is_other = self.shared.is_other.load(Ordering::Relaxed);
        let is_idle = !is_other && reached(adapter.now(), after(self.asked, IDLE));
        let is_still = is_idle || self.shared.is_still.load(Ordering::Relaxed);
        if is_still && !self.waits {
            return Ok(None);
        }
        let received = adapter.receive(until)?;
        self.waits &= received.is_none();
        let mut received = received;
        if is_other {
            if !std::mem::replace(&mut self.is_exchanged, true) {
                let id = self.rig.first();
                self.rig.bus.borrow_mut().power_cycle(id);
            }
            if let Some((_, frame)) = &mut received
                && let [0x3E, 0x8E, _, a, b, c] = *frame.bytes()
            {
                let bytes = [0x3E, 0x8E, OTHER, a, b, c, 0, 0];
                *frame = Frame::of(frame.can_id(), bytes, 6);
            }
        }
        let seen = self.rig.witnessed();
        self.shared.seen.lock().expect("frames").extend(seen);
        Ok(received)
    }
}

/// The serial number of another sensor.
const OTHER: u8 = 77;

/// A server that is connected to a sensor, without samples.
fn served(product: &'static str) -> (Running, Arc<Shared>) {
    let shared = Arc::new(Shared::default());
    let own = shared.clone();
    let server = Running::with(Box::new(move |_| {
        let rig = Rig::with(product);
        let adapter = BenchAdapter::new(&rig.bus);
        let hook = Witnessed {
            asked: adapter.now(),
            rig,
            shared: own.clone(),
            waits: false,
            is_exchanged: false,
        };
        Ok(Hooked::new(adapter, hook))
    }));
    let body = json!({"port": "bench", "rate": 250, "mode": "active"});
    let answer = server.post("/api/connect", &body.to_string());
    assert_eq!(answer.status, 200, "{answer:?}");
    assert_eq!(
        server.post("/api/samples", r#"{"perSecond":0}"#).status,
        200
    );
    (server, shared)
}

#[test]
fn zero_for_a_devicenet_sensor_that_was_exchanged_is_refused() {
    let (server, shared) = served("tiltix080");
    run(&server, json!("save"));
    shared.is_other.store(true, Ordering::Relaxed);
    // The new sensor makes its duplicate MAC ID check first.
    let mut answer = server.post("/api/run", r#"{"zero":{}}"#);
    until("sensor that answers", || {
        answer = server.post_for(Some(1), "/api/run", r#"{"zero":{}}"#);
        answer.status != 504
    });
    assert_eq!(answer.status, 409, "{answer:?}");
    // The page notices it by the action, or by its own reading before it.
    let code = answer.code();
    assert!(
        ["other-sensor", "sensor-changed"].contains(&&code[..]),
        "{code}"
    );
}

#[test]
fn action_of_the_page_needs_few_frames() {
    // The columns: label, get, set, save, zero, zero again.
    for (product, name, value, most) in [
        ("is2", "cyclic-time", "100", [0, 4, 8, 4, 16, 16]),
        ("is2", "cut-off", "2.5Hz", [0, 4, 8, 4, 16, 16]),
        ("jn2101", "filter", "1Hz", [0, 4, 8, 4, 16, 16]),
        ("ims360", "cut-off", "2.5Hz", [0, 4, 8, 4, 16, 16]),
        ("tiltix080", "cos-delta", "0.5deg", [0, 4, 8, 4, 24, 24]),
    ] {
        let (server, shared) = served(product);
        shared.is_still.store(true, Ordering::Relaxed);
        let actions: [Value; 6] = [
            json!({"label": {"name": "boom"}}),
            json!({"get": {"names": [name]}}),
            json!({"set": {"assignments": [format!("{name}={value}")]}}),
            json!("save"),
            json!({"zero": {}}),
            json!({"zero": {}}),
        ];
        for (action, most) in actions.into_iter().zip(most) {
            shared.seen.lock().expect("frames").clear();
            run(&server, action.clone());
            let mut seen = std::mem::take(&mut *shared.seen.lock().expect("frames"));
            // The status of the sensor (1001h) is polled.
            seen.retain(|frame| !matches!(frame.bytes(), [_, 0x01, 0x10, 0x00, ..]));
            assert!(
                seen.len() <= most,
                "{product} {action}: {} frames, at most {most}: {seen:X?}",
                seen.len()
            );
        }
    }
}
