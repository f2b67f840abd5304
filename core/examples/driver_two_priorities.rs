//! A driver with two priorities, for any product: the receive interrupt, here a thread, answers frames while the main loop measures.

use plumbline::can::{Filter, Frame, standard};
use plumbline::measure::{I32x3, ONE_G, Reading};
use plumbline::model::jn2101::Jn2101;
use plumbline::node::driver::{
    Controller, Driver, Line, Link, LinkOf, Phase, Platform, Shared, TwoPriorities,
};
use plumbline::node::{Action, Boot, BusEvent, BusMode, CommunicationOf, ProductNode};
use plumbline::{store::StoreError, time::Instant};
use std::sync::Mutex;

/// The mailboxes of the controller.
struct Mailboxes(Phase, Vec<Frame>);

impl Controller for Mailboxes {
    fn now(&self) -> Instant {
        Instant::from_ticks(5_000)
    }
    fn phase(&self) -> Phase {
        self.0
    }
    fn pause(&mut self, phase: Phase) {
        self.0 = phase;
    }
    fn has_room(&self) -> bool {
        true // this controller sends at once, so no frame waits
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
struct Memory<N: ProductNode>(Mutex<(&'static mut CommunicationOf<N>, Line<Mailboxes>)>);

impl<N: ProductNode> Shared for &Memory<N> {
    type Node = N;
    type Controller = Mailboxes;

    fn with<R>(&self, f: impl FnOnce(&mut LinkOf<'_, N, Mailboxes>) -> R) -> R {
        let (node, line) = &mut *self.0.lock().expect("no panic");
        f(&mut Link::new(&mut **node, line))
    }
}

/// The rest of the hardware.
struct Board<'a, N: ProductNode> {
    memory: &'a Memory<N>,
    change: Option<BusMode>,
    saves: bool,
}

impl<N: ProductNode> Platform for Board<'_, N> {
    fn step(&mut self, filters: impl FnOnce(&mut dyn FnMut(Filter))) -> bool {
        let Some(mode) = self.change.take() else {
            return false;
        };
        // Set the bit timing and the filters here, and wait for 11 recessive bits in further steps.
        filters(&mut |filter| println!("{filter:?}"));
        let phase = match mode {
            BusMode::Listen => Phase::Listening,
            BusMode::Normal => Phase::Normal,
        };
        self.memory.with(|link| link.controller().0 = phase);
        true
    }
    fn event(&mut self) -> Option<BusEvent> {
        None // this controller has no errors
    }
    fn perform(&mut self, action: Action) {
        match action {
            Action::Bus(mode, _) => self.change = Some(mode),
            other => println!("{other:?}"),
        }
    }
    fn save(&mut self, _: impl FnOnce(&mut [u8]) -> Option<usize>) {
        self.saves = true;
    }
    fn restart(&mut self, _: u32) {}
}

/// The main loop. `interrupt` is the receive interrupt.
fn run<N: ProductNode>(article: &N::Article, interrupt: impl Fn(&Memory<N>) + Sync) -> Vec<Frame> {
    let node = Box::leak(Box::new(N::INITIAL));
    node.start(article, Instant::from_ticks(0), &Boot::default());
    let (communication, acquisition) = node.halves();
    let line = Line::new(Mailboxes(Phase::Off, Vec::new()));
    let memory = Memory(Mutex::new((communication, line)));
    let mut driver = Driver::new(TwoPriorities::new(acquisition, &memory));
    let mut board = Board {
        memory: &memory,
        change: None,
        saves: false,
    };
    let acceleration = I32x3 {
        z: ONE_G,
        ..I32x3::default()
    };
    driver.sample(&Reading {
        acceleration,
        ..Reading::default()
    });
    while driver.turn(&mut board) {}
    std::thread::scope(|threads| {
        threads.spawn(|| interrupt(&memory));
    });
    while driver.turn(&mut board) {}
    if std::mem::take(&mut board.saves) {
        driver.stored(Err(StoreError)); // this board has no memory
    }
    println!("wait until {:?}", driver.deadline());
    (&memory).with(|link| link.controller().1.clone())
}

fn main() {
    // An SDO request for the device type (1000h).
    let request = Frame::data(standard(0x60A), &[0x40, 0x00, 0x10, 0, 0, 0, 0, 0]);
    let request = request.expect("a frame");
    let sent = run::<Jn2101>(&(), |memory| memory.with(|link| link.receive(&request)));
    assert_eq!(sent.len(), 2, "the boot-up message and the answer");
    assert_eq!(sent[1].bytes()[..4], [0x43, 0x00, 0x10, 0]);
}
