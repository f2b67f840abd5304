//! A server with sensors whose program is updated. The wire can break.

use super::client::Running;
use super::hooked::{Hook, Hooked, Received};
use crate::rig::Rig;
use adapter::bench::BenchAdapter;
use adapter::{Adapter, AdapterError};
use plumbline::can::Frame;
use plumbline::time::Instant;
use serde_json::{Value, json};
use std::fs;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicI64, Ordering};
use std::thread;
use std::time::Duration;

/// A bus with a sensor. After this number of frames the wire is broken; -1: never.
struct Plugged {
    /// The bus with its devices.
    _rig: Rig,
    left: Arc<AtomicI64>,
}

impl Hook for Plugged {
    fn send(&mut self, adapter: &mut dyn Adapter, frame: &Frame) -> Result<(), AdapterError> {
        // An atomic step, because the test sets the number in another thread.
        let left = self
            .left
            .fetch_update(Ordering::Relaxed, Ordering::Relaxed, |left| {
                (left > 0).then(|| left - 1)
            });
        match left {
            Err(0) => Ok(()),
            _ => adapter.send(frame),
        }
    }

    fn receive(&mut self, adapter: &mut dyn Adapter, until: Instant) -> Received {
        // Leaves the processor to others between polls. No assertion depends on this pause.
        thread::sleep(Duration::from_micros(20));
        adapter.receive(until)
    }
}

/// A server with the sensors of a bus, and the number of frames until its wire is broken.
pub fn server_at(bus: impl Fn() -> Rig + Send + 'static) -> (Running, Arc<AtomicI64>) {
    let left = Arc::new(AtomicI64::new(-1));
    let own = left.clone();
    let server = Running::with(Box::new(move |_| {
        let rig = bus();
        let adapter = BenchAdapter::new(&rig.bus);
        let left = own.clone();
        Ok(Hooked::new(adapter, Plugged { _rig: rig, left }))
    }));
    (server, left)
}

/// The request with this file.
pub fn body(path: &Path, more: Value) -> String {
    let image = fs::read(path).expect("the file");
    let mut body = json!({"name": "FILE.plu", "image": image});
    for (name, value) in more.as_object().into_iter().flatten() {
        body[name] = value.clone();
    }
    body.to_string()
}
