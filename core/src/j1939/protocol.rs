//! The protocol: address, timers and transmission. The received frames are in `receive.rs`, the sent ones in `sending.rs`, DM1 and the
//! messages of the transport protocol in `messages.rs`.

use super::claim::{Claim, State};
use super::diagnostics::Diagnostics;
use super::name::Name;
use super::product::{ContextOf, Product};
use super::timers::{Timer, Timers};
use super::transport::{Incoming, Outgoing};
use crate::application::{Faults, Values};
use crate::can::BitRate;
use crate::node::{BusChange, BusState};
use crate::time::{Deadline, Instant};
use core::marker::PhantomData;

/// The number of messages to different nodes at a time.
const CONNECTIONS: usize = 2;

/// The services of J1939 for product `P`. The node that has them handles the messages of Proprietary A, and tells the faults of the node.
pub struct J1939<P: Product> {
    pub(super) claim: Claim,
    pub(super) rate: BitRate,
    timers: P::Timers,
    pub(super) diagnostics: Diagnostics,
    /// Received frames were lost since the last message with trouble codes.
    pub(super) overrun: bool,
    pub(super) broadcast: Outgoing,
    /// The messages of [`LONG`](super::messages::LONG) to all nodes that wait for the end of another one, a bit for each.
    pub(super) waiting: u8,
    pub(super) connections: [Outgoing; CONNECTIONS],
    /// Commanded Address: a NAME and an address.
    pub(super) commanded: Incoming<9>,
    /// A reset of the node follows. Until then the node sends nothing and does not change its address.
    pub(super) resetting: bool,
    /// The node has left its address since the last [`has_left`](Self::has_left).
    left: bool,
    /// An access to the nonvolatile memory failed.
    pub(super) memory: bool,
    /// The CAN controller is error passive.
    pub(super) passive: bool,
    /// A frame waits for room in the queue.
    pub(super) pending: bool,
    earliest: Deadline,
    product: PhantomData<P>,
}

impl<P: Product> J1939<P> {
    /// Not started. All bits are 0.
    pub const OFF: Self = Self {
        claim: Claim::OFF,
        rate: BitRate::K10,
        timers: P::Timers::OFF,
        diagnostics: Diagnostics::OFF,
        overrun: false,
        broadcast: Outgoing::IDLE,
        waiting: 0,
        connections: [Outgoing::IDLE; CONNECTIONS],
        commanded: Incoming::IDLE,
        resetting: false,
        left: false,
        memory: false,
        passive: false,
        pending: false,
        earliest: Deadline::NEVER,
        product: PhantomData,
    };

    /// Whether it is on the bus.
    pub fn is_started(&self) -> bool {
        self.claim.state() != State::Off
    }

    /// Starts with the parameters of a start: claims the preferred address.
    pub fn start(&mut self, cx: &mut ContextOf<P>, rate: BitRate) {
        self.stop();
        self.rate = rate;
        self.diagnostics = Diagnostics::OFF;
        self.overrun = false;
        let name = Name::new(
            P::NAME.map(|field| field.get(&cx.parameters)),
            cx.shell.serial(),
        );
        let preferred = cx.parameters.get(P::ADDRESS) as u8;
        self.claim.start(name, preferred, cx.shell.serial());
        self.move_on(cx);
    }

    /// Leaves the address and ends all transfers. Nothing more is sent until the next start.
    pub fn stop(&mut self) {
        self.claim.stop();
        self.be_silent();
        self.resetting = false;
    }

    /// Stops sending until the reset of the node that follows.
    pub fn prepare_reset(&mut self) {
        self.be_silent();
        self.resetting = true;
    }

    fn be_silent(&mut self) {
        self.end_traffic();
        self.commanded.end();
    }

    /// Returns true once after the node has left its address. All transfers of Proprietary A have ended.
    pub fn has_left(&mut self) -> bool {
        core::mem::take(&mut self.left)
    }

    /// Sets the present faults of the node: the nonvolatile memory, and error passive.
    pub fn tell(&mut self, memory: bool, passive: bool) {
        self.memory = memory;
        self.passive = passive;
    }

    /// Ends everything that needs an address.
    fn end_traffic(&mut self) {
        self.timers.as_mut().iter_mut().for_each(Timer::stop);
        self.diagnostics.stop();
        self.broadcast.end();
        self.connections.iter_mut().for_each(Outgoing::end);
        self.waiting = 0;
    }

    /// The node has left the address, or claims it again: it sends nothing more from this address.
    pub(super) fn leave(&mut self, cx: &mut ContextOf<P>) {
        self.end_traffic();
        self.commanded.end_addressed();
        self.left = true;
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

    /// Starts the messages when the address is ours.
    fn begin_traffic(&mut self, cx: &mut ContextOf<P>, now: Instant) {
        for (timer, sent) in self.timers.as_mut().iter_mut().zip(P::SENT) {
            timer.start(now, sent.rate.get(&cx.parameters));
        }
        self.diagnostics.start(now);
        self.overrun = false;
        self.show(cx);
    }

    /// All frames were sent: a claim, or a packet to all nodes. In bus-off they were discarded.
    pub fn sent(&mut self, cx: &mut ContextOf<P>, now: Instant) {
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
    pub fn published(&mut self, cx: &mut ContextOf<P>) {
        let before = self.diagnostics.active();
        let faults = cx.values.faults();
        if before != 0 || faults != Faults::NONE {
            let active = self.active(cx);
            if active != before {
                self.diagnostics.set(active);
                cx.shell.wake_up();
            }
        }
    }

    /// The bus state of the node has changed.
    pub fn bus_changed(&mut self, cx: &mut ContextOf<P>, now: Instant, change: BusChange) {
        match change {
            BusChange::Overrun => self.overrun = true,
            BusChange::State if cx.shell.bus_state() == BusState::BusOff => {
                self.claim.suspend();
                self.leave(cx);
                if P::recovers(&cx.parameters) {
                    // The recovery, without the frames in the mailboxes: the claim is the first frame after it.
                    cx.shell.go_online(self.rate);
                }
            }
            BusChange::Recovered => {
                self.leave(cx);
                // Before a reset, the start that follows claims the address.
                if !self.resetting && self.claim.resume(now) {
                    self.move_on(cx);
                }
            }
            BusChange::Unsent => self.claim.failed(now),
            BusChange::State | BusChange::Online => {}
        }
        self.show(cx);
        cx.shell.wake_up();
    }

    /// Performs a step of the actions of expired timers. Returns true if there is another step. Step 1 is for the messages of
    /// Proprietary A, which the node that has these services sends.
    pub fn tick(&mut self, cx: &mut ContextOf<P>, now: Instant, step: u8) -> bool {
        match step {
            0 => {
                self.earliest = Deadline::NEVER;
                self.pending = false;
                if self.resetting {
                    return false;
                }
                self.tick_claim(cx, now);
            }
            1 => {}
            _ => {
                let place = usize::from(step - 2);
                if place < P::Timers::COUNT {
                    self.tick_group(cx, now, place);
                } else if place == P::Timers::COUNT {
                    self.tick_diagnostics(cx, now);
                } else {
                    self.tick_transport(cx, now);
                    return false;
                }
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

    fn tick_group(&mut self, cx: &mut ContextOf<P>, now: Instant, place: usize) {
        let (Some(timer), Some(sent)) = (self.timers.as_mut().get_mut(place), P::SENT.get(place))
        else {
            return;
        };
        if self.claim.address().is_some() {
            timer.change(now, sent.rate.get(&cx.parameters));
        }
        let due = timer.poll(now);
        self.earliest.consider(timer.deadline());
        if due
            && cx.shell.is_online()
            && let Some(frame) = self.group(cx, sent)
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
    pub fn waits_for_room(&self) -> bool {
        self.pending
    }

    /// The time of the next [`tick`](Self::tick).
    pub fn deadline(&self) -> Deadline {
        self.earliest
    }

    /// Performs the next [`tick`](Self::tick) at this time at the latest.
    pub fn wait_until(&mut self, deadline: Deadline) {
        self.earliest.consider(deadline);
    }

    /// Performs the next [`tick`](Self::tick) when a frame has left the queue.
    pub fn wait_for_room(&mut self) {
        self.pending = true;
    }
}
