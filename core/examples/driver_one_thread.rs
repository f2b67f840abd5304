//! A driver with one thread, for any product. `Wire` is a CAN controller in memory: put the registers of yours in its place.

use plumbline::can::{BitRate, Filter, Frame, standard};
use plumbline::measure::{Reading, SAMPLE_PERIOD};
use plumbline::model::jn2101::Jn2101;
use plumbline::node::driver::{
    Controller, Driver, Filters, Mailboxes, OneThread, Output, Platform,
};
use plumbline::node::{Boot, BusEvent, BusMode, BusState, ProductNode};
use plumbline::{store::StoreError, time::Instant};

/// The CAN controller. It sends a frame at once.
#[derive(Debug, Default)]
struct Wire {
    clock: u64,
    mode: Option<(BusMode, BitRate)>,
    filters: Vec<Filter>,
    event: Option<BusEvent>,
    sent: Vec<Frame>,
}
impl Mailboxes for Wire {
    fn now(&self) -> Instant {
        Instant::from_ticks(self.clock)
    }
    fn is_idle(&self) -> bool {
        true
    }
    fn put(&mut self, frame: &Frame, _once: bool) {
        self.sent.push(*frame);
    }
    fn abort(&mut self) {}
}
impl Controller for Wire {
    fn open(&mut self, mode: BusMode, rate: BitRate, filters: Filters<'_>) {
        self.mode = Some((mode, rate));
        self.filters.clear();
        filters.for_each(|filter| self.filters.push(filter));
    }
    fn recover(&mut self) {
        self.event = Some(BusEvent::State(BusState::Active));
    }
    fn event(&mut self) -> Option<BusEvent> {
        self.event.take()
    }
}

/// The rest of the board, which has no memory.
struct Board;
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

/// The main loop, for these inputs.
fn run<N: ProductNode>(article: &N::Article, inputs: &[Result<Frame, BusEvent>]) -> Wire {
    let mut node = N::INITIAL;
    node.start(article, Instant::from_ticks(0), &Boot::default());
    let mut driver = Driver::new(OneThread::new(&mut node, Wire::default()));
    for input in inputs {
        driver.controller_mut().clock += SAMPLE_PERIOD.ticks();
        driver.sample(&Reading::default()); // put that of your accelerometer here
        while driver.turn(&mut Board) {}
        match input {
            Ok(frame) => driver.receive(frame),
            Err(event) => driver.controller_mut().event = Some(*event),
        }
        while driver.turn(&mut Board) {}
    }
    std::mem::take(driver.controller_mut())
}

fn main() {
    let frame = |id, data: &[u8]| Ok(Frame::data(standard(id), data).expect("a frame"));
    let inputs = [
        frame(0x60A, &[0x2B, 0x01, 0x20, 0, 0xF4, 1, 0, 0]), // 500 kbit/s
        frame(0x000, &[0x82, 0]),                            // reset communication
        Err(BusEvent::State(BusState::BusOff)),
        frame(0x60A, b"\x23\x10\x10\x01save"),
    ];
    let wire = run::<Jn2101>(&(), &inputs);
    assert_eq!(wire.mode, Some((BusMode::Normal, BitRate::K500)));
    assert!(wire.filters.contains(&Filter::exact(standard(0x60A))));
    let refused = |frame: &Frame| frame.bytes()[0] == 0x80;
    assert!(wire.sent.iter().any(refused), "the board has no memory");
}
