//! The protocol: address, timers and transmission. The received frames are in `receive.rs`, the sent ones in `sending.rs`, DM1 and the
//! messages of the transport protocol in `messages.rs`.

use super::claim::{Claim, State};
use super::diagnostics::Diagnostics;
use super::groups::COUNT;
use super::name::Name;
use super::product::{Product, check};
use super::transport::{Incoming, Outgoing};
use crate::application::{Faults, Values};
use crate::can::BitRate;
use crate::canopen::{self, Canopen};
use crate::node::{BusChange, BusState, Context, Protocol};
use crate::time::{Deadline, Instant, Periodic};
use core::marker::PhantomData;

/// The part of the node of product `P` that the protocol can access.
pub(super) type ContextOf<P> = Context<<P as canopen::Product>::Application>;

/// The number of messages to different nodes at a time.
const CONNECTIONS: usize = 2;

/// The J1939 protocol for product `P`. The parameters are the parameters of its CANopen objects, which each method takes as `objects`.
pub struct J1939<P: Product> {
    pub(super) claim: Claim,
    pub(super) rate: BitRate,
    timers: [Periodic; COUNT],
    /// The transmission rates in force, in ms.
    periods: [u32; COUNT],
    pub(super) diagnostics: Diagnostics,
    /// Received frames were lost since the last message with trouble codes.
    pub(super) overrun: bool,
    pub(super) broadcast: Outgoing,
    /// The messages of [`LONG`](super::messages::LONG) to all nodes that wait for the end of another one, a bit for each.
    pub(super) waiting: u8,
    pub(super) connections: [Outgoing; CONNECTIONS],
    /// Commanded Address: a NAME and an address.
    pub(super) commanded: Incoming<9>,
    /// The address of the client with the SDO transfer.
    pub(super) client: u8,
    /// The address of the client whose write waits for the end of a save.
    pub(super) storing: u8,
    /// A frame waits for room in the queue.
    pub(super) pending: bool,
    earliest: Deadline,
    product: PhantomData<P>,
}

impl<P: Product> J1939<P> {
    /// Not started. All bits are 0.
    pub(super) const OFF: Self = Self {
        claim: Claim::OFF,
        rate: BitRate::K10,
        timers: [Periodic::OFF; COUNT],
        periods: [0; COUNT],
        diagnostics: Diagnostics::OFF,
        overrun: false,
        broadcast: Outgoing::IDLE,
        waiting: 0,
        connections: [Outgoing::IDLE; CONNECTIONS],
        commanded: Incoming::IDLE,
        client: 0,
        storing: 0,
        pending: false,
        earliest: Deadline::NEVER,
        product: PhantomData,
    };

    /// Checks the tables of the product. Inconsistent tables are a compile error.
    const CHECKED: () = check::<P>();

    /// Whether it is on the bus.
    pub(super) fn is_started(&self) -> bool {
        self.claim.state() != State::Off
    }

    /// Starts with the parameters of a start: claims the preferred address.
    pub(super) fn start(&mut self, cx: &mut ContextOf<P>, rate: BitRate) {
        let () = Self::CHECKED;
        self.stop();
        self.rate = rate;
        self.diagnostics = Diagnostics::OFF;
        self.overrun = false;
        let name = Name::new(
            P::NAME.map(|field| cx.parameters.get(field)),
            cx.shell.serial(),
        );
        let preferred = cx.parameters.get(P::ADDRESS) as u8;
        self.claim.start(name, preferred, cx.shell.serial());
        self.move_on(cx);
    }

    /// Ends all activity.
    pub(super) fn stop(&mut self) {
        self.claim.stop();
        self.be_silent();
    }

    /// Sends nothing more until it starts again.
    pub(super) fn be_silent(&mut self) {
        self.end_traffic();
        self.commanded.end();
    }

    /// Ends everything that needs an address.
    fn end_traffic(&mut self) {
        self.timers = [Periodic::OFF; COUNT];
        self.diagnostics.stop();
        self.broadcast.end();
        self.connections.iter_mut().for_each(Outgoing::end);
        self.waiting = 0;
    }

    /// The node has left the address, or claims it again: it sends nothing more from this address.
    pub(super) fn leave(&mut self, cx: &mut ContextOf<P>, objects: &mut Canopen<P>) {
        self.end_traffic();
        self.commanded.end_addressed();
        objects.end_transfers();
        cx.shell.clear_queue();
    }

    /// Begins to claim an address, or has none: the acceptance filters change, and frames in the mailboxes must not be sent any more.
    pub(super) fn move_on(&mut self, cx: &mut ContextOf<P>) {
        cx.shell.go_online(self.rate);
        self.announce(cx);
    }

    /// Sends the claim, if there is an address.
    pub(super) fn announce(&mut self, cx: &mut ContextOf<P>) {
        if self.claim.state() != State::CannotClaim {
            cx.shell.send(self.claim.frame());
        }
        self.show(cx);
        cx.shell.wake_up();
    }

    /// The address is ours.
    fn begin_traffic(&mut self, cx: &mut ContextOf<P>, now: Instant) {
        for ((timer, period), id) in self.timers.iter_mut().zip(&mut self.periods).zip(P::RATES) {
            *period = cx.parameters.get(id);
            timer.start(now, *period);
        }
        self.diagnostics.start(now);
        self.overrun = false;
        self.show(cx);
    }

    /// All frames were sent: a claim, or a packet to all nodes. In bus-off they were discarded.
    pub(super) fn sent(&mut self, cx: &mut ContextOf<P>, now: Instant) {
        if self.claim.is_queued() && cx.shell.is_online() {
            self.claim.sent(now);
            cx.shell.wake_up();
        }
        let transfers = [&mut self.broadcast].into_iter();
        for transfer in transfers.chain(&mut self.connections) {
            if transfer.sent(now) {
                cx.shell.wake_up();
            }
        }
    }

    /// The application has published new values.
    pub(super) fn published(&mut self, cx: &mut ContextOf<P>, objects: &Canopen<P>) {
        let before = self.diagnostics.active();
        let faults = cx.values.faults();
        if before != 0 || faults != Faults::NONE {
            let active = self.active(cx, objects);
            if active != before {
                self.diagnostics.set(active);
                cx.shell.wake_up();
            }
        }
    }

    /// The bus state of the node has changed.
    pub(super) fn bus_changed(
        &mut self,
        cx: &mut ContextOf<P>,
        now: Instant,
        change: BusChange,
        objects: &mut Canopen<P>,
    ) {
        match change {
            BusChange::Overrun => self.overrun = true,
            BusChange::State if cx.shell.bus_state() == BusState::BusOff => {
                self.claim.suspend();
                self.leave(cx, objects);
                if objects.recovers(&cx.parameters) {
                    // The recovery, without the frames in the mailboxes: the claim is the first frame after it.
                    cx.shell.go_online(self.rate);
                }
            }
            BusChange::Recovered => {
                self.leave(cx, objects);
                // Before a reset, the start that follows claims the address.
                if !objects.is_resetting() && self.claim.resume(now) {
                    self.move_on(cx);
                }
            }
            BusChange::Unsent => self.claim.failed(now),
            BusChange::State | BusChange::Online => {}
        }
        self.show(cx);
        cx.shell.wake_up();
    }

    /// Performs a step of the actions of expired timers. Returns true if there is another step.
    pub(super) fn tick(
        &mut self,
        cx: &mut ContextOf<P>,
        now: Instant,
        step: u8,
        objects: &mut Canopen<P>,
    ) -> bool {
        const GROUPS_END: u8 = 2 + COUNT as u8;
        match step {
            0 => {
                self.earliest = Deadline::NEVER;
                self.pending = false;
                if objects.is_resetting() {
                    self.earliest.consider(objects.deadline_hosted());
                    return false;
                }
                self.tick_claim(cx, now);
            }
            1 => self.tick_objects(cx, now, objects),
            2..GROUPS_END => self.tick_group(cx, now, usize::from(step - 2)),
            GROUPS_END => self.tick_diagnostics(cx, now, objects),
            _ => {
                self.tick_transport(cx, now, objects);
                return false;
            }
        }
        true
    }

    fn tick_claim(&mut self, cx: &mut ContextOf<P>, now: Instant) {
        if self.claim.poll(now) {
            match self.claim.state() {
                State::Claimed => self.begin_traffic(cx, now),
                _ => cx.shell.send(self.claim.frame()),
            }
        }
        self.earliest.consider(self.claim.deadline());
    }

    fn tick_objects(&mut self, cx: &mut ContextOf<P>, now: Instant, objects: &mut Canopen<P>) {
        let mut message = objects.tick_hosted(cx, now);
        if message.is_none() && objects.is_streaming() {
            // The segments of a block do not delay other frames.
            if cx.shell.is_sending() {
                self.pending = true;
            } else {
                message = objects.next_segment(now);
                self.pending = objects.is_streaming();
            }
        }
        self.reply(cx, self.client, message);
        self.earliest.consider(objects.deadline_hosted());
    }

    fn tick_group(&mut self, cx: &mut ContextOf<P>, now: Instant, place: usize) {
        let (Some(timer), Some(period), Some(rate)) = (
            self.timers.get_mut(place),
            self.periods.get_mut(place),
            P::RATES.get(place),
        ) else {
            return;
        };
        if self.claim.address().is_some() {
            let wanted = cx.parameters.get(*rate);
            if *period != wanted {
                *period = wanted;
                timer.start(now, wanted);
            }
        }
        let due = timer.poll(now);
        self.earliest.consider(timer.deadline());
        if due
            && cx.shell.is_online()
            && let Some(frame) = self.group(cx, place)
        {
            cx.shell.send_cyclic(frame);
        }
    }

    /// Adds a deadline. A deadline that has passed means that a frame waits for room in the queue.
    pub(super) fn consider(&mut self, now: Instant, deadline: Deadline) {
        if deadline.is_reached(now) {
            self.pending = true;
        } else {
            self.earliest.consider(deadline);
        }
    }

    /// Whether a frame waits for room in the queue.
    pub(super) fn waits_for_room(&self) -> bool {
        self.pending
    }

    /// The next deadline.
    pub(super) fn deadline(&self) -> Deadline {
        self.earliest
    }
}
