//! A driver with two priorities, for any product: the receive interrupt, here a thread, answers frames while the main loop measures.

use plumbline::can::{BitRate, Frame, standard};
use plumbline::measure::Reading;
use plumbline::model::jn2101::Jn2101;
use plumbline::node::driver::{
    Controller, Driver, Filters, Line, Link, LinkOf, Mailboxes, Output, Platform, Shared,
    TwoPriorities,
};
use plumbline::node::{Boot, BusEvent, BusMode, CommunicationOf, ProductNode};
use plumbline::{store::StoreError, time::Instant};
use std::sync::Mutex;

/// The mailboxes of the controller. It sends a frame at once.
#[derive(Default)]
struct Sent(Vec<Frame>);
impl Mailboxes for Sent {
    fn now(&self) -> Instant {
        Instant::from_ticks(5_000)
    }
    fn is_idle(&self) -> bool {
        true
    }
    fn put(&mut self, frame: &Frame, _once: bool) {
        self.0.push(*frame);
    }
    fn abort(&mut self) {}
}

/// The link of the node. On a microcontroller, the lock masks the interrupts.
struct Memory<N: ProductNode>(Mutex<(&'static mut CommunicationOf<N>, Line<Sent>)>);
impl<N: ProductNode> Shared for &Memory<N> {
    type Node = N;
    type Mailboxes = Sent;
    fn with<R>(&self, f: impl FnOnce(&mut LinkOf<'_, N, Sent>) -> R) -> R {
        let (node, line) = &mut *self.0.lock().expect("no panic");
        f(&mut Link::new(&mut **node, line))
    }
}

/// The rest of the controller, and of the board, which has no memory.
struct Board;
impl Controller for Board {
    fn open(&mut self, mode: BusMode, rate: BitRate, filters: Filters<'_>) {
        println!("{mode:?} at {rate:?}");
        filters.for_each(|filter| println!("{filter:?}"));
    }
    fn recover(&mut self) {}
    fn event(&mut self) -> Option<BusEvent> {
        None // this controller has no errors
    }
}
impl Platform for Board {
    fn perform(&mut self, output: Output) {
        println!("{output:?}");
    }
    fn save(&mut self, _image: impl FnOnce(&mut [u8]) -> Option<usize>) {}
    fn stored(&mut self) -> Option<Result<(), StoreError>> {
        Some(Err(StoreError))
    }
    fn restart(&mut self, _kept: u32) {}
}

/// The main loop. `interrupt` is the receive interrupt.
fn run<N: ProductNode>(article: &N::Article, interrupt: impl Fn(&Memory<N>) + Sync) -> Vec<Frame> {
    let node = Box::leak(Box::new(N::INITIAL));
    node.start(article, Instant::from_ticks(0), &Boot::default());
    let (communication, acquisition) = node.halves();
    let memory = Memory(Mutex::new((communication, Line::new(Sent::default()))));
    let mut driver = Driver::new(TwoPriorities::new(acquisition, &memory, Board));
    driver.sample(&Reading::default()); // put that of your accelerometer here
    while driver.turn(&mut Board) {}
    std::thread::scope(|threads| {
        threads.spawn(|| interrupt(&memory));
    });
    while driver.turn(&mut Board) {}
    (&memory).with(|link| std::mem::take(&mut link.mailboxes().0))
}

fn main() {
    // An SDO request for the device type (1000h).
    let request = Frame::of(standard(0x60A), [0x40, 0x00, 0x10, 0, 0, 0, 0, 0], 8);
    let sent = run::<Jn2101>(&(), |memory| memory.with(|link| link.receive(&request)));
    let answers = |frame: &Frame| frame.bytes().starts_with(&[0x43, 0x00, 0x10, 0]);
    assert!(sent.iter().any(answers), "{sent:?}");
}
