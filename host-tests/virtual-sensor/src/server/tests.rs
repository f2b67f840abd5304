//! The pauses of the main loop. They bound its processor time and its delay, on any computer.

use super::event::Client;
use super::*;
use bench::{BusRate, Device, Flash, NodeType};
use plumbline::can::BitRate;
use plumbline::measure::Reading;
use plumbline::model::catalog;
use plumbline::time::{after, millis};
use std::sync::Arc;

/// A JN2101 that has booted, and repeats its boot-up message until a client acknowledges it.
fn server(rate: BusRate) -> Server {
    let node_type = NodeType::from(catalog::find("jn2101").expect("a product"));
    let mut bus = Bus::new(rate);
    let motion = Box::new(Reading::default());
    let sensor = bus.attach(Device::new(&node_type, 1, Flash::default(), motion));
    bus.run_until(after(bus.now(), millis(1000)));
    Server::new(bus, sensor, Clock::Computer, None, None).0
}

/// A client that has sent these lines.
fn join(server: &mut Server, lines: &[u8]) {
    let id = ClientId::next();
    let client = Client::new(Arc::default(), || {});
    for event in [
        Event::Joined(id, client, Language::Slcan),
        Event::Input(id, lines.to_vec()),
    ] {
        assert!(server.handle(event).is_ok());
    }
}

#[test]
fn loop_without_client_on_the_bus_runs_rarely() {
    let alone = server(BusRate::Follow);
    let mut other_rate = server(BusRate::Fixed(BitRate::K125));
    join(&mut other_rate, b"S6\rO\r");
    for mut server in [alone, other_rate] {
        for _ in 0..50 {
            let pause = server.pause();
            assert!(pause >= Some(Duration::from_millis(20)), "{pause:?}");
            server.bus.run_until(after(server.bus.now(), millis(20)));
        }
    }
}

#[test]
fn loop_with_client_on_the_bus_runs_at_once_for_its_frame() {
    let mut server = server(BusRate::Follow);
    join(&mut server, b"S4\rO\rt60A84000100000000000\r");
    // A frame of 8 bytes has at most 135 bits of 8 us.
    let pause = server.pause();
    assert!(
        pause.is_some_and(|pause| pause < Duration::from_micros(1080)),
        "{pause:?}"
    );
}
