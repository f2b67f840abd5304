//! CANopen and a protocol of a maker in one node. The other protocol transports the SDOs with two identifiers, without node-ID: requests
//! 7A0h, replies 7A1h. It sends 7A2h when it is on the bus.

use super::{Mast, Slope};
use crate::tester::Tester;
use crate::tester::canopen::frame;
use plumbline::can::{CanId, Filter};
use plumbline::canopen::{Canopen, Product};
use plumbline::node::{Action, BusChange, CanNode, Context, Protocol, Restore};
use plumbline::prelude::*;
use plumbline::store::StoreError;
use plumbline::time::Deadline;

/// The identifiers of the other protocol.
const REQUEST: CanId = CanId::standard(0x7A0);
const REPLY: CanId = CanId::standard(0x7A1);
const STARTED: u16 = 0x7A2;

type Cx = Context<Slope>;

/// Both protocols.
struct CanopenOrTunnel {
    canopen: Canopen<Mast>,
    /// The other protocol is on the bus.
    is_on: bool,
}

impl CanopenOrTunnel {
    /// Begins the other protocol after a start that has selected it, or ends it.
    fn follow(&mut self, cx: &mut Cx) {
        let selected = self.canopen.is_hosted();
        if selected && !self.is_on {
            cx.shell.go_online(self.canopen.rate());
            cx.shell
                .send(Frame::data(standard(STARTED), &[]).expect("no data"));
        }
        self.is_on = selected;
    }

    fn reply(&self, cx: &mut Cx, message: Option<[u8; 8]>) {
        if let Some(bytes) = message {
            cx.shell
                .send(Frame::data(standard(0x7A1), &bytes).expect("eight bytes"));
        }
    }
}

impl Restore for CanopenOrTunnel {
    type Application = Slope;
    const IMAGE: ImageId = Mast::IMAGE;

    fn restored(&mut self, parameters: &mut Parameters<Mast>, damaged: bool) {
        self.canopen.restored(parameters, damaged);
    }
}

impl Protocol<Slope> for CanopenOrTunnel {
    const INITIAL: Self = Self {
        canopen: Canopen::INITIAL,
        is_on: false,
    };
    const FRAMES: usize = <Canopen<Mast> as Protocol<Slope>>::FRAMES;
    const FILTERS: usize = <Canopen<Mast> as Protocol<Slope>>::FILTERS;

    fn start(&mut self, cx: &mut Cx, now: Instant) {
        self.canopen.start(cx, now);
        self.follow(cx);
    }

    fn receive(&mut self, cx: &mut Cx, now: Instant, frame: &Frame) {
        if !self.is_on {
            self.canopen.receive(cx, now, frame);
        } else if frame.can_id() == REQUEST {
            self.canopen.serve(cx, now, frame, REPLY);
            cx.shell.wake_up();
        }
    }

    fn published(&mut self, cx: &mut Cx, now: Instant) {
        if !self.is_on {
            self.canopen.published(cx, now);
        }
    }

    fn bus_changed(&mut self, cx: &mut Cx, now: Instant, change: BusChange) {
        self.canopen.bus_changed(cx, now, change);
    }

    fn recovers(&self, parameters: &Parameters<Mast>) -> bool {
        self.canopen.recovers(parameters)
    }

    fn stored(
        &mut self,
        cx: &mut Cx,
        now: Instant,
        saved: &Parameters<Mast>,
        result: Result<(), StoreError>,
    ) {
        if self.is_on {
            let reply = self.canopen.stored_hosted(cx, saved, result);
            self.reply(cx, reply);
        } else {
            self.canopen.stored(cx, now, saved, result);
        }
    }

    fn tick(&mut self, cx: &mut Cx, now: Instant, step: u8) -> bool {
        if !self.is_on {
            let continues = self.canopen.tick(cx, now, step);
            self.follow(cx);
            return continues && !self.is_on;
        }
        if self.canopen.resets_hosted(cx, now) {
            self.follow(cx);
            cx.shell.wake_up();
            return false;
        }
        let message = self.canopen.tick_hosted(cx, now);
        self.reply(cx, message);
        false
    }

    fn proceed(&mut self, cx: &mut Cx) -> bool {
        self.canopen.proceed(cx)
    }

    fn waits_for_room(&self) -> bool {
        !self.is_on && self.canopen.waits_for_room()
    }

    fn deadlines(&self, earliest: &mut Deadline) {
        if self.is_on {
            earliest.consider(self.canopen.deadline_hosted());
        } else {
            self.canopen.deadlines(earliest);
        }
    }

    fn address(&self) -> Option<u32> {
        if self.is_on {
            return None;
        }
        self.canopen.address()
    }

    fn filters(&self, cx: &Cx, accept: &mut dyn FnMut(Filter)) {
        if self.is_on {
            accept(Filter::exact(REQUEST));
        } else {
            self.canopen.filters(cx, accept);
        }
    }
}

type Node = CanNode<Slope, CanopenOrTunnel>;

fn booted() -> Tester<Node> {
    let mut tester = Tester::power_up(Default::default(), Node::new);
    assert_eq!(tester.sent_text(), ["714#00"]);
    tester
}

/// Sends a frame. Returns the frames that follow within 150 ms.
fn ask(t: &mut Tester<Node>, text: &str) -> Vec<String> {
    t.receive(frame(text));
    let frames = t.wait(150).into_iter();
    frames.map(|(_, frame)| format!("{frame:?}")).collect()
}

#[test]
fn other_protocol_transports_the_same_objects_from_the_restart_that_selects_it() {
    let mut t = booted();
    assert_eq!(
        ask(&mut t, "614#2F02200001000000"),
        ["594#6002200000000000"]
    );
    // Not before the restart.
    assert_eq!(
        ask(&mut t, "614#4010600000000000"),
        ["594#4B106000D2040000"]
    );
    assert_eq!(
        ask(&mut t, "614#2310100173617665"),
        ["594#6010100100000000"]
    );
    assert_eq!(
        ask(&mut t, "614#2F03200001000000"),
        ["594#6003200000000000", "7A2#"]
    );
    assert!(t.accepts(standard(0x7A0)));
    assert!(!t.accepts(standard(0x614)));
    assert_eq!(
        ask(&mut t, "7A0#4010600000000000"),
        ["7A1#4B106000D2040000"]
    );
    // After power-up it is there at once, without a boot-up message.
    t.power_cycle();
    assert_eq!(t.sent_text(), ["7A2#"]);
    // An upload of the history that is not continued: the server aborts it, as in CANopen.
    assert_eq!(
        ask(&mut t, "7A0#4003100000000000"),
        ["7A1#4F03100000000000"]
    );
}

#[test]
fn save_and_way_back_are_possible_in_the_other_protocol() {
    let mut t = booted();
    ask(&mut t, "614#2F02200001000000");
    ask(&mut t, "614#2310100173617665");
    ask(&mut t, "614#2F03200001000000");
    assert_eq!(
        ask(&mut t, "7A0#2F02200000000000"),
        ["7A1#6002200000000000"]
    );
    // The reply comes after the save.
    t.memory_works = None;
    assert_eq!(ask(&mut t, "7A0#2310100173617665"), [""; 0]);
    assert_eq!(t.actions.last(), Some(&Action::Save));
    t.finish_save(Ok(()));
    assert_eq!(t.sent_text(), ["7A1#6010100100000000"]);
    assert_eq!(
        ask(&mut t, "7A0#2F03200001000000"),
        ["7A1#6003200000000000", "714#00"]
    );
    assert_eq!(
        ask(&mut t, "614#4002200000000000"),
        ["594#4F02200000000000"]
    );
}
