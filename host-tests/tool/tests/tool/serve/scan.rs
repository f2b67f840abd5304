//! The questions of a scan on a bus that is in use: they go back to the page, and without a yes nothing is sent.

use crate::serve::client::{Answer, Running};
use crate::serve::foreign::{heartbeat, opener, unknown};
use crate::serve::hooked::{Hook, Hooked, Received};
use adapter::{Adapter, AdapterError, Capabilities, Mode};
use plumbline::can::{BitRate, Frame};
use plumbline::time::Instant;
use plumbline_tool::demo;
use serde_json::{Value, json};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

fn scan(server: &Running, boxes: Value, yes: &[Value]) -> Answer {
    let mut body = json!({"port": "demo:is2", "rate": 250, "yes": yes});
    for (name, is_checked) in boxes.as_object().into_iter().flatten() {
        body[name] = is_checked.clone();
    }
    server.post("/api/scan", &body.to_string())
}

#[track_caller]
fn question(answer: &Answer) -> Value {
    assert_eq!((answer.status, answer.code().as_str()), (400, "asks"));
    let questions = answer.json()["error"]["questions"].clone();
    assert_eq!(questions.as_array().map(Vec::len), Some(1), "{questions}");
    questions[0].clone()
}

#[test]
fn bus_with_traffic_is_asked_only_after_the_yes_to_its_question() {
    let (opener, witness) = opener(unknown());
    let server = Running::with(opener);
    for boxes in [json!({"active": true}), json!({"search": true})] {
        let traffic = question(&scan(&server, boxes.clone(), &[]));
        assert_eq!(traffic, json!({"id": "all-addresses"}));
        // A yes to another question is no yes.
        let other = json!({"id": "silent"});
        assert_eq!(question(&scan(&server, boxes.clone(), &[other])), traffic);
        assert_eq!(witness.sent(), [0; 0]);
        let found = scan(&server, boxes, &[traffic]);
        assert_eq!(found.status, 200, "{found:?}");
        assert_eq!(found.json()[0]["address"], "300");
        assert!(witness.sent().contains(&0x300));
    }
    // Without a checked box the answer is no.
    let silent = scan(&server, json!({}), &[]);
    assert_eq!(
        (silent.status, silent.code().as_str()),
        (504, "nothing-found")
    );
    assert_eq!(witness.sent(), [0; 0]);
}

#[test]
fn search_beside_a_node_that_was_heard_runs_after_the_yes() {
    let (opener, witness) = opener(heartbeat());
    let server = Running::with(opener);
    let mut tab = server.tab();
    let boxes = json!({"active": true, "search": true});
    let more = question(&scan(&server, boxes.clone(), &[]));
    assert_eq!(more, json!({"id": "more"}));
    // The node whose heartbeat was heard is asked who it is. The page shows it behind the question.
    assert!(witness.sent().iter().all(|id| *id == 0x622));
    let found = tab.wait("found", |rows| rows != &json!([]));
    assert_eq!(found[0]["address"], "34");
    assert_eq!(scan(&server, boxes, &[more]).status, 200);
    let sent = witness.sent();
    for id in [0x001, 0x305, 0x621, 0x7FF] {
        assert!(sent.contains(&id), "{id:X}");
    }
    // Identifiers of network management, and the identifier of the heartbeat.
    for id in [0x000, 0x080, 0x722] {
        assert!(!sent.contains(&id), "{id:X}");
    }
}

/// The virtual times of a bus, in ms.
#[derive(Default)]
struct Times {
    now: AtomicU64,
    /// The first frame that was received.
    first: AtomicU64,
}

/// A bus at 125 kbit/s with an IS2 as delivered, which sends nothing by itself.
struct Silent {
    rate: Option<BitRate>,
    times: Arc<Times>,
}

impl Hook for Silent {
    fn capabilities(&self, own: Capabilities) -> Capabilities {
        Capabilities {
            needs_rate: true,
            sets_rate: true,
            ..own
        }
    }

    fn open(
        &mut self,
        adapter: &mut dyn Adapter,
        rate: Option<BitRate>,
        mode: Mode,
    ) -> Result<(), AdapterError> {
        self.rate = rate;
        adapter.open(rate, mode)
    }

    fn send(&mut self, adapter: &mut dyn Adapter, frame: &Frame) -> Result<(), AdapterError> {
        match self.rate {
            Some(BitRate::K125) => adapter.send(frame),
            _ => Ok(()),
        }
    }

    fn receive(&mut self, adapter: &mut dyn Adapter, until: Instant) -> Received {
        let mut received = adapter.receive(until)?;
        while received.is_some() && self.rate != Some(BitRate::K125) {
            received = adapter.receive(until)?;
        }
        let now = adapter.now().ticks() / 1000;
        self.times.now.store(now, Ordering::Relaxed);
        if received.is_some() {
            let first = &self.times.first;
            let _ = first.compare_exchange(0, now, Ordering::Relaxed, Ordering::Relaxed);
        }
        Ok(received)
    }

    fn errors(&mut self, _: Option<u64>) -> Option<u64> {
        None
    }
}

fn silent() -> (Running, Arc<Times>) {
    let times = Arc::new(Times::default());
    let own = times.clone();
    let server = Running::with(Box::new(move |_| {
        let times = own.clone();
        let hook = Silent { rate: None, times };
        Ok(Hooked::new(demo::unpaced("is2")?, hook))
    }));
    (server, times)
}

/// The milliseconds after the question until the first frame of the sensor.
#[track_caller]
fn waited(times: &Times, asked: u64) -> u64 {
    let first = times.first.load(Ordering::Relaxed);
    assert!(first > asked, "{first} {asked}");
    first - asked
}

#[test]
fn silent_sensor_is_found_within_5_s_of_the_yes_and_shown_while_the_scan_goes_on() {
    let (server, times) = silent();
    let mut tab = server.tab();
    let scan = |yes: &[Value]| {
        let body = json!({"port": "demo:is2", "yes": yes});
        server.post("/api/scan", &body.to_string())
    };
    let silent = question(&scan(&[]));
    assert_eq!(silent, json!({"id": "silent"}));
    // It is no failure.
    let end = tab.wait("action", |action| action["state"] != "running");
    assert_eq!(end["state"], "asks");
    assert_eq!(times.first.load(Ordering::Relaxed), 0);
    // Without the yes it listens again.
    let asked = times.now.load(Ordering::Relaxed);
    assert_eq!(question(&scan(&[])), silent);
    assert!(times.now.load(Ordering::Relaxed) > asked + 10_000);
    let asked = times.now.load(Ordering::Relaxed);
    let found = scan(std::slice::from_ref(&silent));
    assert_eq!(found.json()[0]["address"], "300", "{found:?}");
    assert!(waited(&times, asked) < 5000);
    let row = tab.wait("found", |rows| rows != &json!([]));
    assert_eq!(row, found.json());
    let next = tab.wait("progress", |_| true);
    assert!(
        next["texts"]["en"]
            .as_str()
            .is_some_and(|text| text.contains("all node-IDs")),
        "{next}"
    );
    // The next scan listens again.
    let asked = times.now.load(Ordering::Relaxed);
    assert_eq!(question(&scan(&[])), silent);
    assert!(times.now.load(Ordering::Relaxed) > asked + 10_000);
}

#[test]
fn connection_to_a_silent_sensor_is_there_within_5_s_of_the_yes() {
    let (server, times) = silent();
    let mut tab = server.tab();
    let connect = |yes: &[Value]| {
        let body = json!({"port": "demo:is2", "mode": "active", "yes": yes});
        server.post("/api/connect", &body.to_string())
    };
    let rates = question(&connect(&[]));
    assert_eq!(rates, json!({"id": "all-rates"}));
    let status = tab.wait("status", |status| status["port"] == "demo:is2");
    assert_eq!(status["error"], json!(null));
    let asked = times.now.load(Ordering::Relaxed);
    let connected = connect(&[rates]);
    assert_eq!(connected.json()["address"], "300", "{connected:?}");
    assert!(waited(&times, asked) < 5000);
}
