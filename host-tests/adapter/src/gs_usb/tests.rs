pub mod fake;

use super::*;
use crate::bench::{BenchAdapter, SharedBus};
use bench::{Bus, BusRate, Device, Flash, Geometry, NodeType};
use fake::Fake;
use plumbline::can::{extended, standard};
use plumbline::measure::{I32x3, ONE_G, Reading};
use plumbline::time::{after, millis};
use std::cell::RefCell;
use std::rc::Rc;
use texts::Cause as _;

/// Features: listen-only; with all errors of the bus; with its counters.
const LISTENS: u32 = 0x0001;
const REPORTS: u32 = 0x1001;
const COUNTS: u32 = 0x2001;

/// The request 03h (article) to the identifier 300h, with the echo number 0.
const QUESTION: [u8; 20] = [
    0, 0, 0, 0, 0x00, 0x03, 0, 0, 1, 0, 0, 0, 3, 0, 0, 0, 0, 0, 0, 0,
];

fn adapter(features: u32) -> (GsUsb<Fake>, Fake) {
    let fake = Fake::new(features);
    (GsUsb::new(fake.clone(), "usb:1").unwrap(), fake)
}

fn opened(features: u32, mode: Mode) -> (GsUsb<Fake>, Fake) {
    let (mut adapter, fake) = adapter(features);
    adapter.open(Some(BitRate::K250), mode).unwrap();
    fake.requests();
    (adapter, fake)
}

fn bytes(words: &[u32]) -> Vec<u8> {
    words.iter().flat_map(|word| word.to_le_bytes()).collect()
}

/// A transfer with a received frame: 32 bits of identifier, length, channel, flags, data.
fn received(id: u32, length: u8, channel: u8, flags: u8, data: [u8; 8]) -> Vec<u8> {
    let mut transfer = bytes(&[0xFFFF_FFFF, id]);
    transfer.extend([length, channel, flags, 0]);
    transfer.extend(data);
    transfer
}

/// An error frame with these classes and the state of the controller.
fn error(class: u32, state: u8) -> Vec<u8> {
    received(0x2000_0000 | class, 8, 0, 0, [0, state, 0, 0, 0, 0, 0, 0])
}

fn frames(adapter: &mut GsUsb<Fake>) -> Vec<String> {
    let until = adapter.now();
    let mut frames = Vec::new();
    while let Some((_, frame)) = adapter.receive(until).unwrap() {
        frames.push(format!("{frame:?}"));
    }
    frames
}

/// A bus with a sensor at rest, which has started.
fn bus(product: &str, rate: BusRate) -> SharedBus {
    let level = Reading {
        acceleration: I32x3 {
            x: 0,
            y: 0,
            z: ONE_G,
        },
        temperature: 25_00,
        ..Reading::default()
    };
    let mut bus = Bus::new(rate);
    let flash = Flash::blank(Geometry::STM32F103);
    let node_type = NodeType::find(product).unwrap();
    bus.attach(Device::new(&node_type, 1, flash, Box::new(level)));
    bus.run_until(after(bus.now(), millis(500)));
    Rc::new(RefCell::new(bus))
}

fn question() -> Frame {
    Frame::data(standard(0x300), &[3]).unwrap()
}

#[test]
fn opening_resets_sets_the_bit_timing_and_starts() {
    let (mut adapter, fake) = adapter(LISTENS);
    assert_eq!(fake.requests(), [(0, 1, bytes(&[0xBEEF]))]);
    assert_eq!(fake.0.borrow().layout.map(|own| own.output), Some(0x02));
    adapter.open(Some(BitRate::K250), Mode::Active).unwrap();
    let active = [
        (2, 0, bytes(&[0, 0])),
        (1, 0, bytes(&[6, 7, 2, 1, 12])),
        (2, 0, bytes(&[1, 0])),
    ];
    assert_eq!(fake.requests(), active);
    adapter.open(Some(BitRate::K800), Mode::Listen).unwrap();
    let listening = [
        (2, 0, bytes(&[0, 0])),
        (1, 0, bytes(&[6, 6, 2, 1, 4])),
        (2, 0, bytes(&[1, 1])),
    ];
    assert_eq!(fake.requests(), listening);
    adapter.close();
    assert_eq!(fake.requests(), [(2, 0, bytes(&[0, 0]))]);
}

#[test]
fn adapter_is_stopped_when_the_program_ends() {
    let (adapter, fake) = opened(LISTENS, Mode::Active);
    drop(adapter);
    assert_eq!(fake.requests(), [(2, 0, bytes(&[0, 0]))]);
}

#[test]
fn listening_without_the_feature_is_refused_and_starts_nothing() {
    let (mut adapter, fake) = adapter(0x2000);
    assert!(!adapter.capabilities().listen_only);
    fake.requests();
    let failure = adapter.open(Some(BitRate::K250), Mode::Listen).unwrap_err();
    assert_eq!(
        (failure.code(), failure.kind().exit_code()),
        ("no-listen-only", 4)
    );
    assert_eq!(fake.requests(), []);
    assert!(adapter.send(&question()).is_err());
    assert_eq!(fake.written(), Vec::<Vec<u8>>::new());
}

#[test]
fn listening_adapter_sends_nothing() {
    let (mut adapter, fake) = opened(LISTENS, Mode::Listen);
    assert_eq!(adapter.send(&question()).unwrap_err().code(), "not-open");
    assert_eq!(fake.written(), Vec::<Vec<u8>>::new());
}

#[test]
fn rate_without_exact_bit_timing_is_refused_and_starts_nothing() {
    let fake = Fake::new(LISTENS);
    fake.0.borrow_mut().constants[1] = 25_000_000;
    let mut adapter = GsUsb::new(fake.clone(), "usb:1").unwrap();
    fake.requests();
    let failure = adapter.open(Some(BitRate::K800), Mode::Active).unwrap_err();
    assert_eq!(
        (failure.code(), failure.kind().exit_code()),
        ("rate-refused", 4)
    );
    assert!(failure.to_string().contains("800 kbit/s"), "{failure}");
    assert!(failure.to_string().contains("25000000 Hz"), "{failure}");
    assert_eq!(fake.requests(), []);
    adapter.open(Some(BitRate::K500), Mode::Active).unwrap();
}

#[test]
fn frames_are_sent_with_echo_number_identifier_length_and_data() {
    let (mut adapter, fake) = opened(LISTENS, Mode::Active);
    fake.0.borrow_mut().is_acknowledged = false;
    adapter.send(&question()).unwrap();
    let data = [1, 2, 3, 4, 5, 6, 7, 8];
    let frame = Frame::data(extended(0x18EA_FFFE), &data).unwrap();
    adapter.send(&frame).unwrap();
    adapter
        .send(&Frame::remote(standard(0x701), 2).unwrap())
        .unwrap();
    let long = [
        1, 0, 0, 0, 0xFE, 0xFF, 0xEA, 0x98, 8, 0, 0, 0, 1, 2, 3, 4, 5, 6, 7, 8,
    ];
    let remote = [
        2, 0, 0, 0, 0x01, 0x07, 0, 0x40, 2, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0,
    ];
    assert_eq!(fake.written(), [QUESTION, long, remote]);
}

#[test]
fn adapter_that_needs_longer_frames_has_them() {
    let (mut adapter, fake) = opened(0x0201, Mode::Active);
    adapter.send(&question()).unwrap();
    assert_eq!(fake.written(), [[&QUESTION[..], &[0]].concat()]);
}

#[test]
fn received_frames_are_returned_and_echoes_are_not() {
    let (mut adapter, fake) = opened(LISTENS, Mode::Active);
    adapter.send(&question()).unwrap();
    let data = [0x10, 2, 3, 4, 5, 6, 7, 8];
    fake.transfer(&received(0x301, 2, 0, 0, data));
    fake.transfer(&received(0x98EA_FFFE, 8, 0, 0, data));
    fake.transfer(&received(0x4000_0701, 1, 0, 0, [0; 8]));
    // With a time stamp, or filled up to the size of a packet.
    let stamped = [received(0x302, 0, 0, 0, data), vec![9, 9, 9, 9]].concat();
    fake.transfer(&stamped);
    assert_eq!(
        frames(&mut adapter),
        ["301#1002", "18EAFFFE#1002030405060708", "701#R1", "302#"]
    );
    assert_eq!(adapter.errors(), Some(0));
}

#[test]
fn invalid_transfers_are_ignored() {
    let (mut adapter, fake) = opened(LISTENS, Mode::Active);
    let data = [1; 8];
    let good = received(0x301, 1, 0, 0, data);
    for length in 0..20 {
        fake.transfer(&good[..length]);
    }
    fake.transfer(&received(0x301, 9, 0, 0, data));
    fake.transfer(&received(0x301, 255, 0, 0, data));
    fake.transfer(&received(0x801, 1, 0, 0, data));
    fake.transfer(&received(0x4000_0301, 9, 0, 0, data));
    // Another channel, and CAN FD.
    fake.transfer(&received(0x301, 1, 1, 0, data));
    fake.transfer(&received(0x301, 1, 0, 2, data));
    // The echo of a frame that was never sent.
    fake.transfer(&[77; 20].map(|byte| if byte == 77 { 0xFE } else { 0 }));
    fake.transfer(&good);
    assert_eq!(frames(&mut adapter), ["301#01"]);
}

#[test]
fn errors_of_the_bus_are_counted() {
    let (mut adapter, fake) = opened(REPORTS, Mode::Listen);
    assert_eq!(adapter.errors(), Some(0));
    // A bit error, a missing acknowledgement, and that the controller is passive.
    fake.transfer(&error(0x0008, 0));
    fake.transfer(&error(0x0020, 0));
    fake.transfer(&error(0x0004, 0x10));
    // It is active again.
    fake.transfer(&error(0x0004, 0x40));
    fake.transfer(&error(0x0100, 0));
    assert_eq!(frames(&mut adapter), Vec::<String>::new());
    assert_eq!(adapter.errors(), Some(3));
    // Frames were lost.
    fake.transfer(&received(0x301, 0, 0, 1, [0; 8]));
    assert_eq!(frames(&mut adapter), ["301#"]);
    assert_eq!(adapter.errors(), Some(4));
}

#[test]
fn all_errors_are_requested_for_listening_from_adapters_that_have_them() {
    for (features, mode, flags) in [
        (REPORTS, Mode::Listen, 0x1001),
        (REPORTS, Mode::Active, 0),
        (COUNTS, Mode::Listen, 1),
    ] {
        let (mut adapter, fake) = adapter(features);
        adapter.open(Some(BitRate::K250), mode).unwrap();
        let last = fake.requests().pop();
        assert_eq!(last, Some((2, 0, bytes(&[1, flags]))));
    }
}

#[test]
fn error_counters_show_errors_without_error_frames() {
    let (mut adapter, fake) = opened(COUNTS, Mode::Listen);
    assert_eq!(adapter.errors(), Some(0));
    fake.0.borrow_mut().counters = [1, 97, 0];
    assert_eq!(adapter.errors(), Some(1));
    fake.0.borrow_mut().counters = [0, 0, 0];
    assert_eq!(adapter.errors(), Some(1));
    adapter.open(Some(BitRate::K125), Mode::Listen).unwrap();
    assert_eq!(adapter.errors(), Some(0));
}

#[test]
fn adapter_restarts_at_the_frame_after_bus_off() {
    let (mut adapter, fake) = opened(LISTENS, Mode::Active);
    fake.transfer(&error(0x0040, 0));
    assert_eq!(frames(&mut adapter), Vec::<String>::new());
    assert_eq!(fake.requests(), []);
    adapter.send(&question()).unwrap();
    let restart = [
        (2, 0, bytes(&[0, 0])),
        (1, 0, bytes(&[6, 7, 2, 1, 12])),
        (2, 0, bytes(&[1, 0])),
    ];
    assert_eq!(fake.requests(), restart);
    assert_eq!(fake.written(), [QUESTION]);
    adapter.send(&question()).unwrap();
    assert_eq!(fake.requests(), []);
}

#[test]
fn frames_that_nobody_acknowledges_are_dropped_when_the_adapter_is_full() {
    let (mut adapter, fake) = opened(LISTENS, Mode::Active);
    fake.0.borrow_mut().is_acknowledged = false;
    for _ in 0..IN_FLIGHT {
        adapter.send(&question()).unwrap();
    }
    assert_eq!(fake.requests(), []);
    let numbers: Vec<u8> = fake.written().iter().map(|bytes| bytes[0]).collect();
    assert_eq!(numbers, [0, 1, 2, 3, 4, 5, 6, 7, 8, 9]);
    adapter.send(&question()).unwrap();
    assert_eq!(fake.requests().first(), Some(&(2, 0, bytes(&[0, 0]))));
    assert_eq!(fake.written(), [QUESTION]);
    assert_eq!(adapter.errors(), Some(1));
}

#[test]
fn acknowledged_frames_never_fill_the_adapter() {
    let (mut adapter, fake) = opened(LISTENS, Mode::Active);
    for _ in 0..100 {
        adapter.send(&question()).unwrap();
    }
    assert_eq!(fake.written().len(), 100);
    assert_eq!(fake.requests(), []);
}

#[test]
fn adapter_that_takes_no_frames_restarts_once_and_then_has_failed() {
    let (mut adapter, fake) = opened(LISTENS, Mode::Active);
    fake.0.borrow_mut().is_stuck = true;
    assert_eq!(
        adapter.send(&question()).unwrap_err().code(),
        "adapter-lost"
    );
    assert_eq!(fake.requests().len(), 3);
}

#[test]
fn frames_received_before_opening_are_dropped() {
    let (mut adapter, fake) = opened(LISTENS, Mode::Active);
    fake.transfer(&received(0x301, 0, 0, 0, [0; 8]));
    fake.transfer(&error(0x0040, 0));
    adapter.open(Some(BitRate::K250), Mode::Active).unwrap();
    assert_eq!(frames(&mut adapter), Vec::<String>::new());
    assert_eq!(adapter.errors(), Some(0));
    fake.requests();
    adapter.send(&question()).unwrap();
    assert_eq!(fake.requests(), []);
}

#[test]
fn unplugged_adapter_is_reported_with_the_next_step() {
    let (mut adapter, fake) = opened(COUNTS, Mode::Active);
    fake.0.borrow_mut().is_unplugged = true;
    let until = after(adapter.now(), millis(50));
    let failures = [
        adapter.receive(until).unwrap_err(),
        adapter.send(&question()).unwrap_err(),
        adapter.open(Some(BitRate::K250), Mode::Listen).unwrap_err(),
        GsUsb::new(fake.clone(), "usb:1").err().unwrap(),
    ];
    for failure in failures {
        assert_eq!(
            (failure.code(), failure.kind().exit_code()),
            ("adapter-lost", 4)
        );
        assert!(
            failure.to_string().contains("plug it in again"),
            "{failure}"
        );
    }
    assert_eq!(adapter.errors(), None);
    adapter.close();
}

#[test]
fn device_that_does_not_tell_its_limits_is_refused() {
    for constants in [vec![1, 48_000_000, 1, 16], vec![0; 10]] {
        let fake = Fake::new(LISTENS);
        fake.0.borrow_mut().constants = constants;
        let failure = GsUsb::new(fake, "usb:1").err().unwrap();
        assert_eq!(failure.code(), "adapter-silent");
    }
}

#[test]
fn sensor_answers_at_its_rate_only() {
    for rate in BitRate::ALL {
        let fake = Fake::on(&bus("is2", BusRate::Fixed(rate)));
        let mut adapter = GsUsb::new(fake, "usb:1").unwrap();
        // Another rate is one that is near to it.
        let place = BitRate::ALL.iter().position(|own| *own == rate).unwrap();
        let near = BitRate::ALL[if place == 0 { 1 } else { place - 1 }];
        for own in [rate, near] {
            adapter.open(Some(own), Mode::Active).unwrap();
            let is_answered = (0..3).any(|_| {
                adapter.send(&question()).unwrap();
                let until = after(adapter.now(), millis(20));
                let mut answer = std::iter::from_fn(|| adapter.receive(until).unwrap());
                answer.any(|(_, frame)| frame.id() == standard(0x301))
            });
            assert_eq!(is_answered, own == rate, "{own:?} on a bus with {rate:?}");
        }
    }
}

#[test]
fn listening_adapter_hears_the_sensor() {
    let bus = bus("jn2101", BusRate::Follow);
    let mut witness = BenchAdapter::new(&bus);
    witness.open(None, Mode::Active).unwrap();
    let mut adapter = GsUsb::new(Fake::on(&bus), "usb:1").unwrap();
    adapter.open(Some(BitRate::K125), Mode::Listen).unwrap();
    // SYNC, to which nothing has to answer.
    let sync = Frame::data(standard(0x80), &[]).unwrap();
    witness.send(&sync).unwrap();
    let until = after(adapter.now(), millis(60_000));
    let (_, frame) = adapter.receive(until).unwrap().unwrap();
    assert_eq!(frame, sync);
}
