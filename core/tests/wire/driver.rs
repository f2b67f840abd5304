//! The order in which a driver drives a node: no frame, no action and no result gets lost between the interrupts and the main loop. The time
//! is always 0.

use crate::tester::canopen::frame;
use plumbline::can::{BitRate, Frame};
use plumbline::measure::{I32x3, ONE_G, Reading};
use plumbline::model::gemac::is1tk::{self, Is1tk};
use plumbline::model::gemac::is2::{self, Is2};
use plumbline::model::ims360::Ims360;
use plumbline::model::jn2101::Jn2101;
use plumbline::node::driver::{
    Change, Controller, Driver, Filters, Line, Link, LinkOf, Mailboxes, Output, Platform, Shared,
    TwoPriorities,
};
use plumbline::node::{BitTime, Boot, BusEvent, BusMode, BusState, CommunicationOf, ProductNode};
use plumbline::store::StoreError;
use plumbline::time::Instant;
use std::cell::{Cell, RefCell};
use std::collections::VecDeque;

const NOW: Instant = Instant::from_ticks(0);

const LEVEL: Reading = Reading {
    acceleration: I32x3 {
        x: 0,
        y: 0,
        z: ONE_G,
    },
    angular_rate: I32x3 { x: 0, y: 0, z: 0 },
    temperature: 20_00,
    clipped: false,
};

/// Requests of FSC: SAVE, LOAD, RESET, a write of the filter (27h), and a read of it (17h).
const SAVE: &str = "300#5053415645";
const LOAD: &str = "300#404C4F4144";
const RESET: &str = "300#FF5245534554";
const WRITE: &str = "300#27D00701";
const READ: &str = "300#17";

/// A claim of the address 80h by a node with a lower NAME.
const LOWER: &str = "18EEFF80#0000000000000000";

/// Mailboxes that send at once, unless the bus is busy.
#[derive(Default)]
struct Sent {
    frames: Vec<Frame>,
    is_busy: bool,
    /// The last frame has a single attempt.
    once: bool,
    aborts: usize,
}

impl Mailboxes for Sent {
    fn now(&self) -> Instant {
        NOW
    }
    fn is_idle(&self) -> bool {
        !self.is_busy
    }
    fn put(&mut self, frame: &Frame, once: bool) {
        self.frames.push(*frame);
        self.once = once;
    }
    fn abort(&mut self) {
        self.aborts += 1;
    }
}

/// The rest of a controller. It discards its errors at a change of the bit rate.
#[derive(Default)]
struct Bus {
    changes: VecDeque<Change>,
    events: VecDeque<BusEvent>,
    opened: Vec<(BusMode, BitRate)>,
    /// The number of changes of the filters on the bus; None if that is not possible.
    refilters: Option<usize>,
}

impl Controller for Bus {
    fn open(&mut self, mode: BusMode, rate: BitRate, _: Filters<'_>) {
        self.opened.push((mode, rate));
        self.events.retain(|event| *event != BusEvent::Error);
    }
    fn change(&mut self) -> Change {
        match self.changes.front() {
            Some(change) => *change,
            None => Change::Done,
        }
    }
    fn refilter(&mut self, _: Filters<'_>) -> bool {
        let Some(number) = &mut self.refilters else {
            return false;
        };
        *number += 1;
        true
    }
    fn recover(&mut self) {}
    fn event(&mut self) -> Option<BusEvent> {
        self.events.pop_front()
    }
}

/// The link. A frame is received before one of its uses.
struct Memory<N: ProductNode> {
    link: RefCell<(&'static mut CommunicationOf<N>, Line<Sent>)>,
    interrupt: Cell<Option<(usize, &'static str)>>,
}

impl<N: ProductNode> Shared for &Memory<N> {
    type Node = N;
    type Mailboxes = Sent;

    fn with<R>(&self, f: impl FnOnce(&mut LinkOf<'_, N, Sent>) -> R) -> R {
        let (node, line) = &mut *self.link.borrow_mut();
        let mut link = Link::new(&mut **node, line);
        match self.interrupt.take() {
            Some((0, text)) => link.receive(&frame(text)),
            other => self
                .interrupt
                .set(other.map(|(uses, text)| (uses - 1, text))),
        }
        f(&mut link)
    }
}

/// The rest of the board.
#[derive(Default)]
struct Board {
    outputs: Vec<Output>,
    saves: usize,
    image: Vec<u8>,
    result: Option<Result<(), StoreError>>,
    restarts: usize,
}

impl Platform for Board {
    fn perform(&mut self, output: Output) {
        self.outputs.push(output);
    }
    fn save(&mut self, image: impl FnOnce(&mut [u8]) -> Option<usize>) {
        self.saves += 1;
        self.image.resize(1000, 0);
        let length = image(&mut self.image).unwrap();
        self.image.truncate(length);
    }
    fn stored(&mut self) -> Option<Result<(), StoreError>> {
        self.result.take()
    }
    fn restart(&mut self, _: u32) {
        self.restarts += 1;
    }
}

/// A node under a driver with two priorities.
struct Rig<N: ProductNode> {
    memory: &'static Memory<N>,
    driver: Driver<TwoPriorities<'static, &'static Memory<N>, Bus>>,
    board: Board,
}

impl<N: ProductNode> Rig<N> {
    /// A node that is started, before the first reading.
    fn new(article: &N::Article) -> Self {
        Self::booted(article, &Boot::default())
    }

    fn booted(article: &N::Article, boot: &Boot) -> Self {
        let node = Box::leak(Box::new(N::INITIAL));
        node.start(article, NOW, boot);
        let (communication, acquisition) = node.halves();
        let memory: &Memory<N> = Box::leak(Box::new(Memory {
            link: RefCell::new((communication, Line::new(Sent::default()))),
            interrupt: Cell::new(None),
        }));
        Self {
            memory,
            driver: Driver::new(TwoPriorities::new(acquisition, memory, Bus::default())),
            board: Board::default(),
        }
    }

    /// A node on the bus, after its first messages.
    fn online(article: &N::Article) -> Self {
        let mut rig = Self::new(article);
        rig.driver.sample(&LEVEL);
        rig.turn();
        rig.receive("7FF#");
        rig.turn();
        rig.sent();
        rig
    }

    fn turn(&mut self) {
        while self.driver.turn(&mut self.board) {}
    }

    fn receive(&mut self, text: &str) {
        let memory = self.memory;
        memory.with(|link| link.receive(&frame(text)));
    }

    /// Ends a save.
    fn stored(&mut self) {
        self.board.result = Some(Ok(()));
        self.turn();
    }

    /// Takes the frames that were sent.
    fn sent(&mut self) -> Vec<String> {
        let memory = self.memory;
        let frames = memory.with(|link| core::mem::take(&mut link.mailboxes().frames));
        frames.iter().map(|frame| format!("{frame:?}")).collect()
    }
}

fn is2() -> Rig<Is2> {
    Rig::online(&is2::BP_CL)
}

/// The read waits until the application has applied the values of an earlier write. Its reply contains these values.
#[test]
fn frame_waits_until_parameters_of_earlier_write_are_applied() {
    let mut rig = is2();
    rig.receive(WRITE);
    rig.receive(READ);
    assert_eq!(rig.sent(), ["301#2702"]);
    rig.turn();
    assert_eq!(rig.sent(), ["301#1702D00701"]);
}

#[test]
fn frame_is_discarded_while_controller_leaves_bus_and_waits_while_it_joins() {
    let mut rig = Rig::<Jn2101>::new(&());
    rig.driver.controller_mut().changes = [Change::Leaving].into();
    rig.driver.sample(&LEVEL);
    rig.turn();
    let opened = [(BusMode::Normal, BitRate::K125)];
    assert_eq!(rig.driver.controller().opened, opened);
    rig.receive("60A#4000100000000000");
    rig.driver.controller_mut().changes = [Change::Joining].into();
    rig.turn();
    rig.receive("60A#4001100000000000");
    assert!(rig.sent().is_empty());
    rig.driver.controller_mut().changes.clear();
    rig.turn();
    assert_eq!(rig.sent(), ["70A#00", "58A#4F01100000000000"]);
}

/// The line has room for 32 frames.
#[test]
fn frames_beyond_queue_are_reported_as_lost() {
    let mut rig = Rig::<Jn2101>::online(&());
    rig.driver.controller_mut().changes = [Change::Joining].into();
    rig.turn();
    for _ in 0..33 {
        rig.receive("60A#4001100000000000");
    }
    rig.driver.controller_mut().changes.clear();
    rig.turn();
    let sent = rig.sent();
    let answers = sent.iter().filter(|text| text.starts_with("58A#"));
    assert_eq!(answers.count(), 32, "{sent:#?}");
    // CAN overrun.
    assert!(
        sent.iter().any(|text| text.starts_with("08A#1081")),
        "{sent:?}"
    );
}

#[test]
fn node_takes_no_frame_during_restart() {
    let mut rig = is2();
    rig.memory.with(|link| link.mailboxes().is_busy = true);
    rig.receive(RESET);
    rig.turn();
    rig.receive(READ);
    rig.turn();
    assert_eq!(rig.board.restarts, 0, "a frame is in a mailbox");
    rig.memory.with(|link| link.mailboxes().is_busy = false);
    rig.turn();
    assert_eq!(rig.board.restarts, 1);
    assert!(rig.sent().is_empty());
}

/// Two requests wait for the end of a save. A later frame must not overtake them.
#[test]
fn frames_that_waited_for_save_are_handled_before_later_frames() {
    let mut rig = is2();
    for request in [SAVE, LOAD, SAVE, READ] {
        rig.receive(request);
        rig.turn();
    }
    assert_eq!(rig.board.saves, 1);
    assert!(rig.sent().is_empty());
    rig.stored();
    assert_eq!(rig.board.saves, 2, "the factory values are saved");
    rig.stored();
    assert_eq!(rig.board.saves, 3);
    rig.stored();
    let replies = ["301#5003", "301#1703D00702", "301#4003", "301#5003"];
    assert_eq!(rig.sent(), replies);
}

/// A frame can be handled between any two uses of the link.
#[test]
fn save_that_begins_between_two_uses_of_link_is_not_lost() {
    for uses in 0..40 {
        let mut rig = is2();
        rig.memory.interrupt.set(Some((uses, SAVE)));
        rig.driver.sample(&LEVEL);
        rig.turn();
        if rig.memory.interrupt.take().is_some() {
            assert!(uses > 5, "the turn uses the link often");
            return;
        }
        assert_eq!(rig.board.saves, 1, "before use {uses}");
    }
    panic!("the turn ends");
}

/// The heater is off during a restart, also if a reading comes after the application has stopped.
#[test]
fn reading_during_restart_does_not_switch_heater_on() {
    let mut rig = Rig::<Is1tk>::online(&is1tk::METAL);
    let is_heating = |output: &Output| matches!(output, Output::Heater(1..));
    rig.driver.sample(&LEVEL);
    rig.turn();
    assert!(rig.board.outputs.iter().any(is_heating));
    rig.memory.with(|link| link.mailboxes().is_busy = true);
    rig.receive(RESET);
    rig.turn();
    assert!(rig.board.outputs.contains(&Output::Heater(0)));
    let before = rig.board.outputs.len();
    rig.driver.sample(&LEVEL);
    rig.turn();
    assert!(!rig.board.outputs[before..].iter().any(is_heating));
}

/// An IMS360 in J1939 on the bus.
fn ims360() -> Rig<Ims360> {
    let mut rig = Rig::<Ims360>::online(&());
    for request in ["632#2F00310101000000", "632#2310100173617665"] {
        rig.receive(request);
        rig.turn();
    }
    let boot = Boot {
        parameters: Some(&rig.board.image),
        ..Boot::default()
    };
    let mut rig = Rig::<Ims360>::booted(&(), &boot);
    rig.driver.sample(&LEVEL);
    rig.turn();
    assert!(rig.sent()[0].starts_with("18EEFF80#"), "a claim");
    rig
}

/// A node with a lower NAME takes the address, so that the node claims another one and changes its filters. A controller that cannot do so
/// on the bus, or that is in bus-off, is opened again.
#[test]
fn filters_change_on_bus_if_controller_can_and_is_not_in_bus_off() {
    let bus_off = BusEvent::State(BusState::BusOff);
    for (refilters, event, expected) in [
        (Some(0), None, (Some(1), 1)),
        (None, None, (None, 2)),
        (Some(0), Some(bus_off), (Some(0), 2)),
    ] {
        let mut rig = ims360();
        let bus = rig.driver.controller_mut();
        bus.refilters = refilters;
        bus.events.extend(event);
        rig.memory.interrupt.set(event.map(|_| (3, LOWER)));
        if event.is_none() {
            rig.receive(LOWER);
        }
        rig.turn();
        assert!(rig.memory.interrupt.take().is_none());
        let bus = rig.driver.controller();
        assert_eq!((bus.refilters, bus.opened.len()), expected);
    }
}

/// A received frame can discard the queue, as a reset of the communication does. A claim can take the address that the queued frame has.
#[test]
fn queued_frame_is_sent_before_the_next_frame_is_handled_unless_it_takes_the_address() {
    let mut rig = Rig::<Jn2101>::online(&());
    rig.memory.with(|link| link.mailboxes().is_busy = true);
    rig.receive("60A#4001100000000000");
    rig.memory.with(|link| link.mailboxes().is_busy = false);
    rig.receive("000#820A");
    assert_eq!(rig.sent(), ["58A#4F01100000000000", "70A#00"]);

    let mut rig = ims360();
    rig.driver.controller_mut().refilters = Some(0);
    rig.memory.with(|link| link.mailboxes().is_busy = true);
    rig.receive("18EA8001#00EE00");
    rig.memory.with(|link| link.mailboxes().is_busy = false);
    rig.receive(LOWER);
    assert!(rig.sent().is_empty());
    rig.turn();
    assert_eq!(rig.sent(), ["18EEFF81#0000E0FF00910080"]);
}

/// The claim is on the bus when a node with a lower NAME takes its address. It is aborted on reception, and ends in a bit error while the
/// filters change: that is not the end of the claim of the next address, which has a single attempt too.
#[test]
fn aborted_claim_is_not_sent_again_and_its_end_does_not_delay_the_next_claim() {
    let mut rig = ims360();
    let bus = rig.driver.controller_mut();
    bus.refilters = Some(0);
    bus.changes = [Change::Joining].into();
    rig.memory.with(|link| link.mailboxes().is_busy = true);
    let aborts = rig.memory.with(|link| link.mailboxes().aborts);
    rig.receive(LOWER);
    let aborted = rig.memory.with(|link| link.mailboxes().aborts) - aborts;
    assert_eq!(aborted, 1, "on reception");
    rig.turn();
    rig.memory.with(|link| link.mailboxes().is_busy = false);
    rig.driver.transmitted(true);
    assert!(rig.sent().is_empty(), "the filters change");
    rig.driver.controller_mut().changes.clear();
    rig.turn();
    assert_eq!(rig.sent(), ["18EEFF81#0000E0FF00910080"]);
    assert!(rig.memory.with(|link| link.mailboxes().once));
}

/// The error comes after the read of the bit time. The next frame has the same bit time. If the error counted at the new bit rate, the node
/// would leave this bit rate.
#[test]
fn error_at_old_bit_rate_does_not_count_at_measured_one() {
    let mut rig = Rig::<Is2>::new(&is2::BP_CL);
    rig.turn();
    let measured = BusEvent::BitTime(BitTime::of(BitRate::K125));
    for events in [vec![measured, BusEvent::Error], vec![measured]] {
        rig.driver.controller_mut().events.extend(events);
        rig.turn();
    }
    let rates: Vec<BitRate> = rig
        .driver
        .controller()
        .opened
        .iter()
        .map(|one| one.1)
        .collect();
    assert_eq!(rates, [BitRate::K250, BitRate::K125]);
}

/// A driver restarts a node that does not serve its controller for long. In bit rate detection the controller only listens.
#[test]
fn node_serves_the_mode_of_the_controller_that_its_state_needs() {
    let mut rig = Rig::<Is2>::new(&is2::BP_CL);
    let serves = |rig: &Rig<Is2>| {
        let memory = rig.memory;
        [BusMode::Listen, BusMode::Normal].map(|mode| memory.with(|link| link.serves(mode)))
    };
    assert_eq!(serves(&rig), [false, false], "before the first reading");
    rig.driver.sample(&LEVEL);
    rig.turn();
    assert_eq!(serves(&rig), [true, false], "detecting");
    rig.receive("7FF#");
    rig.turn();
    assert_eq!(serves(&rig), [false, true], "on-line");
}
