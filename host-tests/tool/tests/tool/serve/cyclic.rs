//! The samples of the page on a bus with another master: angles that a sensor sends by itself, and those of several sensors.

use crate::bus::rig::Rig;
use crate::serve::api::run;
use crate::serve::client::{Running, Tab};
use crate::serve::hooked::{Hook, Hooked, Received, paced};
use adapter::Adapter;
use adapter::bench::BenchAdapter;
use plumbline::can::{Frame, standard};
use plumbline::time::Instant;
use serde_json::{Value, json};

/// The computer is late each time after this number of waits, for this time in ms.
const LATE: (u32, u32) = (40, 35);

/// A computer that is late again and again. The adapter keeps the frames meanwhile.
struct Late {
    rig: Rig,
    waits: u32,
}

impl Hook for Late {
    fn receive(&mut self, adapter: &mut dyn Adapter, until: Instant) -> Received {
        self.waits += 1;
        let (often, time) = LATE;
        if self.waits.is_multiple_of(often) {
            self.rig.run(time);
        }
        paced(adapter, until)
    }
}

/// A server on a bus with a sensor that is operational if it has states (NMT), and perhaps another sensor.
fn beside(product: &'static str, other: Option<&'static str>) -> Running {
    Running::with(Box::new(move |_| {
        let mut rig = Rig::with(product);
        if let Some(other) = other {
            rig.attach(other, 2);
            rig.run(3000);
        }
        let master = rig.bus.borrow_mut().adapter();
        rig.bus.borrow_mut().open(master, None, false);
        let start = Frame::data(standard(0), &[1, 0]).expect("a frame");
        rig.bus.borrow_mut().send(master, start);
        rig.run(20);
        let adapter = BenchAdapter::new(&rig.bus);
        Ok(Hooked::new(adapter, Late { rig, waits: 0 }))
    }))
}

/// A server that is connected to this sensor.
fn served(product: &'static str) -> Running {
    let server = beside(product, None);
    connect(
        &server,
        json!({"port": "bench", "rate": 250, "mode": "active"}),
    );
    server
}

fn connect(server: &Running, body: Value) {
    let answer = server.post("/api/connect", &body.to_string());
    assert_eq!(answer.status, 200, "{answer:?}");
}

/// The number of samples until there are enough, and the polls that are lost meanwhile. Each sample is later than the one before.
fn samples(tab: &mut Tab, enough: usize) -> (usize, u64) {
    let (mut count, mut last, mut first_lost) = (0, f64::MIN, None);
    loop {
        let samples = tab.wait("samples", |_| true);
        let lost = samples["lost"].as_u64().expect("a number");
        for row in samples["rows"].as_array().expect("rows") {
            let time = row[0].as_f64().expect("a time");
            assert!(time > last, "{time} after {last}");
            last = time;
            count += 1;
        }
        let first = *first_lost.get_or_insert(lost);
        if count >= enough {
            return (count, lost - first);
        }
    }
}

#[test]
fn angles_that_the_sensor_sends_are_taken_and_not_polled_so_a_late_computer_loses_none() {
    for (product, assignments) in [
        ("is2", &["cyclic-time=10ms", "cyclic-mode=on"][..]),
        (
            "jn2101",
            &["tpdo1-transmission-type=254", "tpdo1-event-timer=10ms"],
        ),
        (
            "ims360",
            &["tpdo1-transmission-type=254", "tpdo1-event-timer=10ms"],
        ),
    ] {
        let server = served(product);
        server.post("/api/samples", r#"{"perSecond":100}"#);
        let mut tab = server.tab();
        samples(&mut tab, 100);
        // The polls of a computer that is late are lost.
        let (_, lost) = samples(&mut tab, 300);
        assert!(lost > 5, "{product}: {lost} polls lost");
        run(&server, json!({"set": {"assignments": assignments}}));
        let mut tab = server.tab();
        tab.wait("status", |status| {
            status["sendsEvery"]
                .as_f64()
                .is_some_and(|ms| (9.5..10.5).contains(&ms))
        });
        let sent = |tab: &mut Tab| {
            tab.wait("status", |_| true)["sent"]
                .as_u64()
                .expect("a number")
        };
        let before = sent(&mut tab);
        let (count, lost) = samples(&mut tab, 500);
        assert_eq!(lost, 0, "{product}");
        // The status of a CANopen sensor (1001h) is read each second.
        let polls = sent(&mut tab) - before;
        assert!(polls < count as u64 / 20, "{product}: {polls} frames sent");
    }
}

#[test]
fn sensor_that_does_not_send_any_more_is_polled() {
    let server = served("is2");
    run(
        &server,
        json!({"set": {"assignments": ["cyclic-time=10ms", "cyclic-mode=on"]}}),
    );
    let mut tab = server.tab();
    tab.wait("status", |status| !status["sendsEvery"].is_null());
    run(
        &server,
        json!({"set": {"assignments": ["cyclic-mode=off"]}}),
    );
    let mut tab = server.tab();
    tab.wait("status", |status| status["sendsEvery"].is_null());
    samples(&mut tab, 100);
}

#[test]
fn angles_of_another_sensor_on_the_bus_are_shown_beside_those_of_the_connected_one() {
    let server = beside("jn2101", Some("ims360"));
    let body = json!({"port": "bench", "rate": 250, "mode": "active", "protocol": "canopen", "address": "10"});
    connect(&server, body);
    let add = |address: &str| {
        let body = json!({"add": {"protocol": "canopen", "address": address}});
        server.post("/api/chart", &body.to_string())
    };
    assert_eq!(add("10").code(), "already-shown");
    assert_eq!(add("77").status, 504);
    assert_eq!(add("50").status, 200);
    assert_eq!(add("50").code(), "already-shown");
    let mut tab = server.tab();
    let device = tab.wait("device", |device| !device.is_null());
    let others = tab.wait("others", |others| !others[0].is_null());
    assert_eq!(
        (&device["product"], &others[0]["product"]),
        (&json!("jn2101"), &json!("ims360"))
    );
    let number = &others[0]["connection"];
    assert_ne!(*number, device["connection"]);
    // Both have one axis of time.
    let time = |samples: Value| samples["rows"][0][0].as_f64().expect("a time");
    for _ in 0..10 {
        let own = time(tab.wait("samples", |_| true));
        let other = tab.wait("other-samples", |samples| samples["sensor"] == *number);
        let other = time(other);
        assert!((own - other).abs() < 1.0, "{own} {other}");
    }
    // A command reaches the connected one.
    assert_eq!(
        run(&server, json!({"get": {"names": ["node-id"]}}))["node-id"]["value"],
        10
    );
    let removed = server.post("/api/chart", &json!({"remove": number}).to_string());
    assert_eq!(removed.status, 200);
    server.tab().wait("others", |others| *others == json!([]));
    assert_eq!(add("50").status, 200);
    // They end with the connection.
    server.post("/api/disconnect", "{}");
    server.tab().wait("others", |others| *others == json!([]));
    assert_eq!(add("50").code(), "not-connected");
}
