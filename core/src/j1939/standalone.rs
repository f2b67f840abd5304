//! A node with the J1939 protocol only.

use super::product::{ContextOf, ParametersOf, Product};
use super::protocol::J1939;
use super::timers::Timers;
use crate::can::{Filter, Frame};
use crate::node::{BusChange, BusState, CanNode, Protocol, Restore};
use crate::store::{ImageId, StoreError};
use crate::time::{Deadline, Instant};

/// The J1939 protocol for product `P`, which has no other protocol.
pub struct Standalone<P: Product> {
    j1939: J1939<P>,
    /// An access to the nonvolatile memory failed.
    memory: bool,
    /// The sender of the message that has begun the running save.
    storing: u8,
}

/// A node of product `P` with the J1939 protocol.
pub type J1939Node<P> = CanNode<<P as Product>::Application, Standalone<P>>;

impl<P: Product> Restore for Standalone<P> {
    type Application = P::Application;
    const IMAGE: ImageId = P::IMAGE;

    fn restored(&mut self, _: &mut ParametersOf<P>, damaged: bool) {
        self.memory = damaged;
    }
}

impl<P: Product> Standalone<P> {
    /// Passes the faults of the node to the protocol.
    fn tell(&mut self, cx: &ContextOf<P>) {
        let passive = cx.shell.bus_state() == BusState::Passive;
        self.j1939.tell(self.memory, passive);
    }
}

impl<P: Product> Protocol<P::Application> for Standalone<P> {
    // The groups, DM1, and one claim.
    const FRAMES: usize = P::Timers::COUNT + 2;
    const FILTERS: usize = J1939::<P>::FILTERS;
    const USES_SENT: bool = true;
    const CHANGES_FILTERS: bool = true;

    const INITIAL: Self = Self {
        j1939: J1939::OFF,
        memory: false,
        storing: 0,
    };

    fn start(&mut self, cx: &mut ContextOf<P>, _now: Instant) {
        let rate = P::bit_rate(&cx.parameters);
        self.j1939.start(cx, rate);
    }

    fn receive(&mut self, cx: &mut ContextOf<P>, now: Instant, frame: &Frame) {
        if let Some(message) = self.j1939.receive(cx, now, frame) {
            let was_saving = cx.is_saving();
            let answer = P::proprietary(cx, message.data);
            if cx.is_saving() && !was_saving {
                self.storing = message.source;
            }
            self.j1939.reply(cx, message.source, answer);
            cx.shell.wake_up();
        }
    }

    fn published(&mut self, cx: &mut ContextOf<P>, _now: Instant) {
        self.j1939.published(cx);
    }

    fn bus_changed(&mut self, cx: &mut ContextOf<P>, now: Instant, change: BusChange) {
        self.tell(cx);
        self.j1939.bus_changed(cx, now, change);
    }

    fn sent(&mut self, cx: &mut ContextOf<P>, now: Instant) {
        self.j1939.sent(cx, now);
    }

    fn sends_once(&self) -> bool {
        self.j1939.sends_once()
    }

    fn recovers(&self, parameters: &ParametersOf<P>) -> bool {
        P::recovers(parameters)
    }

    fn stored(
        &mut self,
        cx: &mut ContextOf<P>,
        _now: Instant,
        _saved: &ParametersOf<P>,
        result: Result<(), StoreError>,
    ) {
        self.memory = result.is_err();
        let message = P::stored(cx, result.is_ok());
        self.j1939.reply(cx, self.storing, message);
    }

    fn tick(&mut self, cx: &mut ContextOf<P>, now: Instant, step: u8) -> bool {
        if step == 0 {
            self.tell(cx);
        }
        self.j1939.tick(cx, now, step)
    }

    fn waits_for_room(&self) -> bool {
        self.j1939.waits_for_room()
    }

    fn deadlines(&self, earliest: &mut Deadline) {
        earliest.consider(self.j1939.deadline());
    }

    fn address(&self) -> Option<u32> {
        self.j1939.address().map(u32::from)
    }

    fn filters(&self, _cx: &ContextOf<P>, accept: &mut dyn FnMut(Filter)) {
        self.j1939.filters(accept);
    }
}
