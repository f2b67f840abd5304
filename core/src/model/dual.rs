//! CANopen and J1939 in one node: a parameter selects one of them at a restart, and both have the same objects and application.
//!
//! In J1939, the group Proprietary A transports the SDOs of CANopen: one transfer at a time, of the client that has begun the last one.
//!
//! A product of another crate has, besides the tables of both protocols for one application:
//!
//! - a parameter that selects the protocol, and [`HOSTED`](canopen::Product::HOSTED), a function of it, which is true in J1939;
//! - an own object whose write returns [`Then::Restart`](canopen::Then::Restart), or another way to a restart: the parameter acts then;
//! - the type [`DualNode`], also for `firmware!`;
//! - for a PC, [`Product::with_j1939`](super::listing::Product::with_j1939).
//!
//! The restart follows 100 ms after the reply that has requested it. Then the node claims its address, sends its trouble codes 250 ms later
//! (SAE J1939-81), and each group after its first period: a group of 100 ms comes 450 ms after the reply.

use crate::can::{CanId, Filter, Frame};
use crate::canopen::{self, Canopen};
use crate::j1939::{self, J1939, Proprietary, Timers};
use crate::mistake::Mistake;
use crate::node::{BusChange, CanNode, Context, Protocol, Restore};
use crate::param::Parameters;
use crate::store::{ImageId, StoreError};
use crate::time::{Deadline, Instant};
use crate::update::Contact;

/// A product with both protocols.
pub trait Both:
    canopen::Product + j1939::Product<Application = <Self as canopen::Product>::Application>
{
}

impl<P> Both for P where
    P: canopen::Product + j1939::Product<Application = <P as canopen::Product>::Application>
{
}

/// The protocols CANopen and J1939 for product `P`.
pub struct CanopenOrJ1939<P: Both> {
    canopen: Canopen<P>,
    j1939: J1939<P>,
    /// The address of the client with the SDO transfer.
    client: u8,
    /// The address of the client whose write waits for the end of a save.
    storing: u8,
}

/// The application of product `P`, which both protocols share.
pub type ApplicationOf<P> = <P as canopen::Product>::Application;
type ContextOf<P> = Context<ApplicationOf<P>>;
type ParametersOf<P> = Parameters<<ApplicationOf<P> as crate::application::Application>::Table>;

/// A node of product `P` with both protocols.
pub type DualNode<P> = CanNode<ApplicationOf<P>, CanopenOrJ1939<P>>;

impl<P: Both> Restore for CanopenOrJ1939<P> {
    type Application = ApplicationOf<P>;
    const IMAGE: ImageId = <P as canopen::Product>::IMAGE;

    fn restored(&mut self, parameters: &mut ParametersOf<P>, damaged: bool) {
        self.canopen.restored(parameters, damaged);
    }
}

impl<P: Both> CanopenOrJ1939<P> {
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

    /// Passes the faults of the node to J1939.
    fn tell(&mut self) {
        let (memory, passive) = self.canopen.own_faults();
        self.j1939.tell(memory, passive);
    }

    /// Ends the SDO transfers if the node has left its address.
    fn follow(&mut self) {
        if self.j1939.has_left() {
            self.canopen.end_transfers();
        }
    }

    /// Accepts an SDO request. Returns the identifier of the reply, or None if the SDO server does not get the request.
    fn admit(&mut self, cx: &mut ContextOf<P>, message: Proprietary) -> Option<CanId> {
        let Proprietary {
            source: client,
            data,
        } = message;
        if client != self.client {
            if !Canopen::<P>::begins_transfer(data) {
                self.j1939.reply(cx, client, Canopen::<P>::refusal(data));
                return None;
            }
            self.canopen.end_transfer();
            self.client = client;
        }
        if cx.is_saving() && client != self.storing && Canopen::<P>::is_abort(data) {
            // The abort does not end the write of the other client, which waits for the save.
            self.canopen.end_transfer();
            return None;
        }
        if !cx.is_saving() {
            // This request may begin a save.
            self.storing = client;
        }
        cx.shell.wake_up();
        Some(self.j1939.proprietary_id(client))
    }

    /// Sends a message of the SDO server that does not answer a request.
    fn tick_objects(&mut self, cx: &mut ContextOf<P>, now: Instant) {
        let mut message = self.canopen.tick_hosted(cx, now);
        if message.is_none() && self.canopen.is_streaming() {
            // The segments of a block do not delay other frames.
            if cx.shell.is_sending() {
                self.j1939.wait_for_room();
            } else {
                message = self.canopen.next_segment(now);
                if self.canopen.is_streaming() {
                    self.j1939.wait_for_room();
                }
            }
        }
        self.j1939.reply(cx, self.client, message);
        self.j1939.wait_until(self.canopen.deadline_hosted());
    }
}

impl<P: Both> Protocol<ApplicationOf<P>> for CanopenOrJ1939<P> {
    // J1939 has the groups, DM1, and one claim.
    const FRAMES: usize = {
        let canopen = <Canopen<P> as Protocol<ApplicationOf<P>>>::FRAMES;
        let j1939 = P::Timers::COUNT + 2;
        if canopen > j1939 { canopen } else { j1939 }
    };
    const FILTERS: usize = {
        let canopen = <Canopen<P> as Protocol<ApplicationOf<P>>>::FILTERS;
        let j1939 = J1939::<P>::FILTERS;
        if canopen > j1939 { canopen } else { j1939 }
    };
    const USES_SENT: bool = true;
    const CHANGES_FILTERS: bool = true;

    const INITIAL: Self = {
        Mistake::item("HOSTED").unless(
            <P as canopen::Product>::HOSTED.is_some(),
            "without this function, a product with both protocols is never in J1939",
        );
        Self {
            canopen: Canopen::INITIAL,
            j1939: J1939::OFF,
            client: 0,
            storing: 0,
        }
    };

    fn start(&mut self, cx: &mut ContextOf<P>, now: Instant) {
        self.canopen.start(cx, now);
        self.is_j1939(cx);
    }

    fn receive(&mut self, cx: &mut ContextOf<P>, now: Instant, frame: &Frame) {
        let request = if self.canopen.is_hosted() {
            let message = self.j1939.receive(cx, now, frame);
            self.follow();
            message.and_then(|message| self.admit(cx, message))
        } else {
            self.canopen.route(cx, now, frame)
        };
        // In one place for both protocols: measured, 2 us less.
        if let Some(reply) = request {
            self.canopen.serve(cx, now, frame, reply);
            if self.canopen.is_hosted() && self.canopen.is_resetting() {
                // The reply is the last frame before the reset.
                self.j1939.prepare_reset();
            }
        }
    }

    fn contact(&self, cx: &ContextOf<P>) -> Option<Contact> {
        let contact = self.canopen.contact(cx)?;
        if !self.canopen.is_hosted() {
            return Some(contact);
        }
        let (request, reply) = self.j1939.proprietary_ids(self.client);
        Some(Contact {
            request,
            reply,
            boot_up: reply,
            ..contact
        })
    }

    fn published(&mut self, cx: &mut ContextOf<P>, now: Instant) {
        if self.canopen.is_hosted() {
            self.tell();
            self.j1939.published(cx);
        } else {
            self.canopen.published(cx, now);
        }
    }

    fn bus_changed(&mut self, cx: &mut ContextOf<P>, now: Instant, change: BusChange) {
        self.canopen.bus_changed(cx, now, change);
        if self.canopen.is_hosted() {
            self.tell();
            self.j1939.bus_changed(cx, now, change);
            self.follow();
        }
    }

    fn sent(&mut self, cx: &mut ContextOf<P>, now: Instant) {
        if self.canopen.is_hosted() {
            self.j1939.sent(cx, now);
        }
    }

    fn sends_once(&self) -> bool {
        self.canopen.is_hosted() && self.j1939.sends_once()
    }

    fn recovers(&self, parameters: &ParametersOf<P>) -> bool {
        self.canopen.recovers(parameters)
    }

    fn stored(
        &mut self,
        cx: &mut ContextOf<P>,
        now: Instant,
        saved: &ParametersOf<P>,
        result: Result<(), StoreError>,
    ) {
        if self.canopen.is_hosted() {
            let reply = self.canopen.stored_hosted(cx, saved, result);
            self.j1939.reply(cx, self.storing, reply);
        } else {
            self.canopen.stored(cx, now, saved, result);
        }
    }

    fn tick(&mut self, cx: &mut ContextOf<P>, now: Instant, step: u8) -> bool {
        if !self.is_j1939(cx) {
            return self.canopen.tick(cx, now, step);
        }
        match step {
            0 if self.resets(cx, now) => return false,
            0 => self.tell(),
            1 => self.tick_objects(cx, now),
            _ => {}
        }
        let continues = self.j1939.tick(cx, now, step);
        if step == 0 && self.canopen.is_resetting() {
            self.j1939.wait_until(self.canopen.deadline_hosted());
        }
        continues
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

    fn address(&self) -> Option<u32> {
        if self.canopen.is_hosted() {
            return self.j1939.address().map(u32::from);
        }
        self.canopen.address()
    }

    fn filters(&self, cx: &ContextOf<P>, accept: &mut dyn FnMut(Filter)) {
        if self.canopen.is_hosted() {
            self.j1939.filters(accept);
        } else {
            self.canopen.filters(cx, accept);
        }
    }
}
