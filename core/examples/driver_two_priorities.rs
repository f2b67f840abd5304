//! A driver with two priorities: the receive interrupt, here a thread, answers frames while the main loop measures.
//! Run it with `cargo run -p core --example driver_two_priorities`.

use plumbline::can::{BitRate, Filter, Frame, standard};
use plumbline::measure::{I32x3, ONE_G, Reading};
use plumbline::model::jn2101::Jn2101;
use plumbline::node::driver::{self, Driver, Line, Link, LinkOf, Phase, Platform, TwoPriorities};
use plumbline::node::{Action, Boot, BusEvent, CommunicationOf, ProductNode};
use plumbline::time::Instant;
use std::sync::Mutex;

const NOW: Instant = Instant::from_ticks(5000);

/// The mailboxes of the controller.
struct Mailboxes(Phase, Vec<Frame>);

impl driver::Controller for Mailboxes {
    fn now(&self) -> Instant {
        NOW
    }
    fn phase(&self) -> Phase {
        self.0
    }
    fn pause(&mut self, phase: Phase) {
        self.0 = phase;
    }
    fn is_at(&self, _: BitRate) -> bool {
        false // a JN2101 does not change its filters on the bus
    }
    fn has_room(&self) -> bool {
        true // this controller sends at once
    }
    fn is_idle(&self) -> bool {
        true
    }
    fn put(&mut self, frame: &Frame, _once: bool) {
        self.1.push(*frame);
    }
    fn abort(&mut self) {}
    fn lose(&mut self) {}
}

/// The link of the node. On a microcontroller, the lock masks the interrupts.
struct Memory<'a>(Mutex<(&'a mut CommunicationOf<Jn2101>, Line<Mailboxes>)>);

impl driver::Shared for &Memory<'_> {
    type Node = Jn2101;
    type Controller = Mailboxes;

    fn with<R>(&self, f: impl FnOnce(&mut LinkOf<'_, Jn2101, Mailboxes>) -> R) -> R {
        let (node, line) = &mut *self.0.lock().expect("no panic");
        f(&mut Link::new(node, line))
    }
}

/// The rest of the hardware: no LEDs, no memory.
struct Board<'a, 'b>(&'a Memory<'b>, bool);

impl Platform for Board<'_, '_> {
    fn step(&mut self, _filters: impl FnOnce(&mut dyn FnMut(Filter))) -> bool {
        let changes = std::mem::take(&mut self.1);
        if changes {
            driver::Shared::with(&self.0, |link| link.controller().0 = Phase::Normal);
        }
        changes
    }
    fn event(&mut self) -> Option<BusEvent> {
        None
    }
    fn refilter(&mut self, _: impl FnOnce(&mut dyn FnMut(Filter))) {}
    fn perform(&mut self, action: Action) {
        println!("{action:?}");
        self.1 |= matches!(action, Action::Bus(..));
    }
    fn save(&mut self, _: impl FnOnce(&mut [u8]) -> Option<usize>) {}
    fn restart(&mut self, _: u32) {}
}

fn main() {
    let mut sensor = Jn2101::new(Instant::from_ticks(0), &Boot::default());
    let (communication, acquisition) = sensor.halves();
    let line = Line::new(Mailboxes(Phase::Off, Vec::new()));
    let memory = Memory(Mutex::new((communication, line)));
    let mut main_loop = Driver::new(TwoPriorities::new(acquisition, &memory));
    let mut board = Board(&memory, false);
    let force = I32x3 {
        x: 0,
        y: 0,
        z: ONE_G,
    };
    main_loop.sample(&Reading {
        acceleration: force,
        ..Reading::default()
    });
    while main_loop.turn(&mut board) {}
    // The interrupt: an SDO request for the device type (1000h).
    let request = Frame::data(standard(0x60A), &[0x40, 0x00, 0x10, 0, 0, 0, 0, 0]);
    let request = request.expect("a frame");
    std::thread::scope(|threads| {
        threads.spawn(|| driver::Shared::with(&&memory, |link| link.receive(&request)));
    });
    while main_loop.turn(&mut board) {}
    let sent = driver::Shared::with(&&memory, |link| link.controller().1.clone());
    println!("{sent:?}, next turn at {:?}", main_loop.deadline());
    assert_eq!(sent.len(), 2, "the boot-up message and the answer");
    assert_eq!(sent[1].bytes()[..4], [0x43, 0x00, 0x10, 0]);
}

#[test]
fn interrupt_answers_between_turns() {
    main();
}
