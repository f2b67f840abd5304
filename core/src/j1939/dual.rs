//! CANopen and J1939 in one node: a parameter selects one of them at a restart, and both have the same objects and application.

use super::product::Product;
use super::protocol::{ContextOf, J1939};
use crate::application::Application;
use crate::can::{Filter, Frame};
use crate::canopen::{self, Canopen};
use crate::node::{Boot, BusChange, CanNode, Protocol};
use crate::param::Parameters;
use crate::store::{ImageId, StoreError};
use crate::time::{Deadline, Instant};

/// The protocols CANopen and J1939 for product `P`.
pub struct CanopenOrJ1939<P: Product> {
    canopen: Canopen<P>,
    j1939: J1939<P>,
}

/// A node of product `P` with both protocols.
pub type DualNode<P> = CanNode<<P as canopen::Product>::Application, CanopenOrJ1939<P>>;

type Table<P> = <<P as canopen::Product>::Application as Application>::Table;

impl<P: Product> CanNode<P::Application, CanopenOrJ1939<P>> {
    /// The identification of the stored images of this product.
    pub const IMAGE: ImageId = P::IMAGE;

    /// A node after power-up or a restart. If the stored parameters are not usable, it has the factory values and the memory
    /// fault is active.
    pub fn new(now: Instant, boot: &Boot) -> Self {
        let mut node = Self::INITIAL;
        node.start(now, boot);
        node
    }

    /// Starts an [`INITIAL`](Self::INITIAL) node in place.
    pub fn start(&mut self, now: Instant, boot: &Boot) {
        self.start_with(now, boot, |_, protocol, parameters: &mut _, damaged| {
            protocol.canopen.restored(parameters, damaged);
        });
    }
}

impl<P: Product> CanopenOrJ1939<P> {
    /// Handles a restart that has selected the other protocol. Returns true if J1939 is on the bus.
    fn is_j1939(&mut self, cx: &mut ContextOf<P>) -> bool {
        let hosted = self.canopen.is_hosted();
        if hosted && !self.j1939.is_started() {
            self.j1939.start(cx, self.canopen.rate());
        }
        hosted
    }

    /// Performs a reset that an object has requested. Returns true if there was one.
    fn resets(&mut self, cx: &mut ContextOf<P>, now: Instant) -> bool {
        let resets = self.canopen.resets_hosted(cx, now);
        if resets {
            self.j1939.stop();
            // It starts again, unless CANopen is selected.
            self.is_j1939(cx);
            cx.shell.wake_up();
        }
        resets
    }
}

impl<P: Product> Protocol<P::Application> for CanopenOrJ1939<P> {
    // J1939 has the groups with process data, DM1, and one claim.
    const FRAMES: usize = {
        let canopen = <Canopen<P> as Protocol<P::Application>>::FRAMES;
        let j1939 = super::groups::COUNT + 2;
        if canopen > j1939 { canopen } else { j1939 }
    };
    const FILTERS: usize = {
        let canopen = <Canopen<P> as Protocol<P::Application>>::FILTERS;
        let j1939 = J1939::<P>::FILTERS;
        if canopen > j1939 { canopen } else { j1939 }
    };
    const USES_SENT: bool = true;
    const CHANGES_FILTERS: bool = true;

    const INITIAL: Self = Self {
        canopen: Canopen::INITIAL,
        j1939: J1939::OFF,
    };

    fn start(&mut self, cx: &mut ContextOf<P>, now: Instant) {
        self.canopen.start(cx, now);
        self.is_j1939(cx);
    }

    fn receive(&mut self, cx: &mut ContextOf<P>, now: Instant, frame: &Frame) {
        let request = if self.canopen.is_hosted() {
            self.j1939.receive(cx, now, frame, &mut self.canopen)
        } else {
            self.canopen.route(cx, now, frame)
        };
        // In one place for both protocols: measured, 2 us less.
        if let Some(reply) = request {
            self.canopen.serve(cx, now, frame, reply);
            if self.canopen.is_hosted() && self.canopen.is_resetting() {
                // The reply is the last frame before the reset.
                self.j1939.be_silent();
            }
        }
    }

    fn published(&mut self, cx: &mut ContextOf<P>, now: Instant) {
        if self.canopen.is_hosted() {
            self.j1939.published(cx, &self.canopen);
        } else {
            self.canopen.published(cx, now);
        }
    }

    fn bus_changed(&mut self, cx: &mut ContextOf<P>, now: Instant, change: BusChange) {
        self.canopen.bus_changed(cx, now, change);
        if self.canopen.is_hosted() {
            self.j1939.bus_changed(cx, now, change, &mut self.canopen);
        }
    }

    fn sent(&mut self, cx: &mut ContextOf<P>, now: Instant) {
        if self.canopen.is_hosted() {
            self.j1939.sent(cx, now);
        }
    }

    fn sends_once(&self) -> bool {
        self.canopen.is_hosted() && self.j1939.claim.is_queued()
    }

    fn recovers(&self, parameters: &Parameters<Table<P>>) -> bool {
        self.canopen.recovers(parameters)
    }

    fn stored(
        &mut self,
        cx: &mut ContextOf<P>,
        now: Instant,
        saved: &Parameters<Table<P>>,
        result: Result<(), StoreError>,
    ) {
        if self.canopen.is_hosted() {
            let reply = self.canopen.stored_hosted(cx, saved, result);
            self.j1939.reply(cx, self.j1939.storing, reply);
        } else {
            self.canopen.stored(cx, now, saved, result);
        }
    }

    fn tick(&mut self, cx: &mut ContextOf<P>, now: Instant, step: u8) -> bool {
        if !self.is_j1939(cx) {
            return self.canopen.tick(cx, now, step);
        }
        if step == 0 && self.resets(cx, now) {
            return false;
        }
        self.j1939.tick(cx, now, step, &mut self.canopen)
    }

    fn proceed(&mut self, cx: &mut ContextOf<P>) -> bool {
        self.canopen.proceed(cx)
    }

    fn waits_for_room(&self) -> bool {
        if self.canopen.is_hosted() {
            return self.j1939.waits_for_room();
        }
        self.canopen.waits_for_room()
    }

    fn deadlines(&self, earliest: &mut Deadline) {
        if self.canopen.is_hosted() {
            earliest.consider(self.j1939.deadline());
        } else {
            self.canopen.deadlines(earliest);
        }
    }

    fn filters(&self, cx: &ContextOf<P>, accept: &mut dyn FnMut(Filter)) {
        if self.canopen.is_hosted() {
            self.j1939.filters(accept);
        } else {
            self.canopen.filters(cx, accept);
        }
    }
}
