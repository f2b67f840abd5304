//! A driver with one thread, for any product. `Wire` is a CAN controller in memory: put the registers of your controller in its place.

use plumbline::can::{Filter, Frame, standard};
use plumbline::measure::{I32x3, ONE_G, Reading};
use plumbline::model::gemac::is2::{BP_CL, Is2};
use plumbline::model::jn2101::Jn2101;
use plumbline::node::driver::{Controller, Driver, OneThread, Phase, Platform};
use plumbline::node::{Action, Boot, BusEvent, BusMode, ProductNode};
use plumbline::{store::StoreError, time::Instant};
use std::cell::{Cell, RefCell};

/// The CAN controller. The mailboxes and the rest of the driver use it.
struct Wire {
    now: Cell<Instant>,
    phase: Cell<Phase>,
    sent: RefCell<Vec<Frame>>,
}

impl Controller for &Wire {
    fn now(&self) -> Instant {
        self.now.get()
    }
    fn phase(&self) -> Phase {
        self.phase.get()
    }
    fn pause(&mut self, phase: Phase) {
        self.phase.set(phase);
    }
    fn has_room(&self) -> bool {
        true // this wire sends at once, so no frame waits
    }
    fn is_idle(&self) -> bool {
        true
    }
    fn put(&mut self, frame: &Frame, _once: bool) {
        self.sent.borrow_mut().push(*frame);
    }
    fn abort(&mut self) {}
    fn lose(&mut self) {}
}

/// The rest of the hardware.
struct Board<'a> {
    wire: &'a Wire,
    change: Option<BusMode>,
    saves: bool,
}

impl Platform for Board<'_> {
    fn step(&mut self, filters: impl FnOnce(&mut dyn FnMut(Filter))) -> bool {
        let Some(mode) = self.change.take() else {
            return false;
        };
        // Set the bit timing and the filters here, and wait for 11 recessive bits in further steps.
        filters(&mut |filter| println!("{filter:?}"));
        self.wire.phase.set(match mode {
            BusMode::Listen => Phase::Listening,
            BusMode::Normal => Phase::Normal,
        });
        true
    }
    fn event(&mut self) -> Option<BusEvent> {
        None // this wire has no errors
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

/// The main loop, for these requests. Returns the sent frames.
fn run<N: ProductNode>(article: &N::Article, requests: &[Frame]) -> Vec<Frame> {
    let wire = Wire {
        now: Cell::new(Instant::from_ticks(0)),
        phase: Cell::new(Phase::Off),
        sent: RefCell::default(),
    };
    let mut board = Board {
        wire: &wire,
        change: None,
        saves: false,
    };
    let mut node = N::INITIAL;
    node.start(article, wire.now.get(), &Boot::default());
    let mut driver = Driver::new(OneThread::new(&mut node, &wire));
    let acceleration = I32x3 {
        z: ONE_G,
        ..I32x3::default()
    };
    for (number, request) in (1..).zip(requests) {
        wire.now.set(Instant::from_ticks(number * 5_000));
        driver.sample(&Reading {
            acceleration,
            ..Reading::default()
        });
        while driver.turn(&mut board) {}
        driver.receive(request);
        while driver.turn(&mut board) {}
        if std::mem::take(&mut board.saves) {
            driver.stored(Err(StoreError)); // this board has no memory
        }
        println!("wait until {:?}", driver.deadline());
    }
    wire.sent.take()
}

fn main() {
    let request = |id, data: &[u8]| Frame::data(standard(id), data).expect("a frame");
    // The bit rate is detected with the first frame. The second one requests the angles.
    let sent = run::<Is2>(&BP_CL, &[request(0x7FF, &[]), request(0x300, &[0])]);
    assert_eq!(sent.len(), 3, "two boot-up messages, one answer");
    // An SDO request for the device type (1000h).
    let sent = run::<Jn2101>(&(), &[request(0x60A, &[0x40, 0x00, 0x10, 0, 0, 0, 0, 0])]);
    assert_eq!(sent.len(), 2, "the boot-up message, one answer");
}
