//! A driver with one thread: an IS2 on a wire that exists in memory only. Replace `Wire` by the registers of your CAN controller.
//! Run it with `cargo run -p core --example driver_one_thread`.

use plumbline::can::{BitRate, Filter, Frame, standard};
use plumbline::measure::{I32x3, ONE_G, Reading};
use plumbline::model::gemac::is2::{BP_CL, Is2};
use plumbline::node::driver::{Controller, Driver, OneThread, Phase, Platform};
use plumbline::node::{Action, Boot, BusEvent, BusMode};
use plumbline::time::Instant;
use std::cell::{Cell, RefCell};

/// The registers. The mailboxes and the rest of the driver use them at the same time.
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
    fn is_at(&self, _: BitRate) -> bool {
        false // an IS2 does not change its filters on the bus
    }
    fn has_room(&self) -> bool {
        true // this wire sends at once
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

/// The rest of the hardware: no LEDs, no memory.
struct Board<'a>(&'a Wire, Option<BusMode>);

impl Platform for Board<'_> {
    fn step(&mut self, _filters: impl FnOnce(&mut dyn FnMut(Filter))) -> bool {
        let Some(mode) = self.1.take() else {
            return false;
        };
        // Set the filters and the bit timing here, and wait for 11 recessive bits in further steps.
        self.0.phase.set(match mode {
            BusMode::Listen => Phase::Listening,
            BusMode::Normal => Phase::Normal,
        });
        true
    }
    fn event(&mut self) -> Option<BusEvent> {
        None
    }
    fn refilter(&mut self, _: impl FnOnce(&mut dyn FnMut(Filter))) {}
    fn perform(&mut self, action: Action) {
        println!("{action:?}");
        if let Action::Bus(mode, _) = action {
            self.1 = Some(mode);
        }
    }
    fn save(&mut self, _: impl FnOnce(&mut [u8]) -> Option<usize>) {}
    fn restart(&mut self, _: u32) {}
}

fn main() {
    let wire = Wire {
        now: Cell::new(Instant::from_ticks(0)),
        phase: Cell::new(Phase::Off),
        sent: RefCell::default(),
    };
    let mut sensor = Is2::new(&BP_CL, wire.now.get(), &Boot::default());
    let mut driver = Driver::new(OneThread::new(&mut sensor, &wire));
    let mut board = Board(&wire, None);
    let force = I32x3 {
        x: 0,
        y: 0,
        z: ONE_G,
    };
    let level = Reading {
        acceleration: force,
        ..Reading::default()
    };
    // The bit rate is detected with the first frame. The second one requests the angles.
    for (ms, id) in [(5, 0x7FF), (10, 0x300)] {
        wire.now.set(Instant::from_ticks(ms * 1000));
        driver.sample(&level);
        while driver.turn(&mut board) {}
        driver.receive(&Frame::data(standard(id), &[0]).expect("a frame"));
        while driver.turn(&mut board) {}
    }
    let sent = wire.sent.borrow();
    println!("{sent:?}, next turn at {:?}", driver.deadline());
    assert_eq!(sent.len(), 3, "two boot-up messages, one answer");
    assert_eq!(sent.last().map(|answer| answer.bytes()[0]), Some(0));
}

#[test]
fn answer_follows_boot_up_messages() {
    main();
}
