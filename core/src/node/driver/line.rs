//! The frames between the mailboxes and the node.

use super::super::{Action, BusEvent, BusMode, BusState, Communication, Node, Protocol};
use super::{Change, Mailboxes};
use crate::application::Application;
use crate::can::{BitRate, Filter, Frame};
use crate::store::Usage;
use crate::time::Instant;
use crate::update::Contact;
use embedded_can::Frame as _;
use heapless::Deque;

/// The maximum number of received frames that wait while parameters are applied, or while the bus mode changes: 1.5 ms at 1 Mbit/s
/// with the shortest frames and 100 % bus load.
const QUEUE: usize = 32;

/// Receives frames and has the frames to send: the communicating half of a node, or a [`Node`] on one thread.
pub trait Exchange {
    /// Whether [`usage`](Self::usage) can have a value.
    const HAS_DIAGNOSIS: bool;

    /// Whether [`sent`](Self::sent) and [`sends_once`](Self::sends_once) have an effect.
    const USES_SENT: bool;

    /// Whether it can take the next received frame.
    fn ready(&self) -> bool;

    /// Handles a received frame.
    fn receive(&mut self, now: Instant, frame: &Frame);

    /// Continues an answer that consists of several frames. Returns false if it is complete.
    fn proceed(&mut self) -> bool;

    /// Handles an event of the CAN controller.
    fn bus(&mut self, now: Instant, event: BusEvent);

    /// Whether [`transmit`](Self::transmit) can have a frame.
    fn is_sending(&self) -> bool;

    /// Whether the controller must not repeat the next frame of [`transmit`](Self::transmit) after a bit error.
    fn sends_once(&self) -> bool;

    /// The next frame to send. Call it only when a mailbox is free. `now` returns the present time, for a node that needs it.
    fn transmit(&mut self, now: impl FnOnce() -> Instant) -> Option<Frame>;

    /// All mailboxes are empty: their frames were sent.
    fn sent(&mut self, now: Instant);

    /// Whether the frames in the mailboxes must not be sent any more, because they have an old address.
    fn withdraws(&self) -> bool;

    /// Whether a change of the filters at the same bit rate loses no frame.
    fn changes_filters(&self) -> bool;

    /// Calls `accept` for each acceptance filter in force.
    fn filters(&self, accept: &mut dyn FnMut(Filter));

    /// What the bootloader must know, if the restart is that into it.
    fn contact(&self) -> Option<Contact>;

    /// The usage of the device; None: the product does not store it.
    fn usage(&self) -> Option<Usage>;

    /// Replaces the usage.
    fn set_usage(&mut self, usage: &Usage);
}

impl<A: Application, P: Protocol<A>> Exchange for Communication<A, P> {
    const HAS_DIAGNOSIS: bool = A::HAS_DIAGNOSIS;
    const USES_SENT: bool = P::USES_SENT;

    fn ready(&self) -> bool {
        self.ready()
    }

    fn receive(&mut self, now: Instant, frame: &Frame) {
        self.receive(now, frame);
    }

    fn proceed(&mut self) -> bool {
        self.proceed()
    }

    fn bus(&mut self, now: Instant, event: BusEvent) {
        self.bus(now, event);
    }

    fn is_sending(&self) -> bool {
        self.is_sending()
    }

    fn sends_once(&self) -> bool {
        self.sends_once()
    }

    fn transmit(&mut self, _now: impl FnOnce() -> Instant) -> Option<Frame> {
        self.transmit()
    }

    fn sent(&mut self, now: Instant) {
        self.sent(now);
    }

    fn withdraws(&self) -> bool {
        self.withdraws()
    }

    fn changes_filters(&self) -> bool {
        P::CHANGES_FILTERS
    }

    fn filters(&self, accept: &mut dyn FnMut(Filter)) {
        self.filters(accept);
    }

    fn contact(&self) -> Option<Contact> {
        self.contact()
    }

    fn usage(&self) -> Option<Usage> {
        self.usage()
    }

    fn set_usage(&mut self, usage: &Usage) {
        self.set_usage(usage);
    }
}

impl<N: Node + ?Sized> Exchange for N {
    const HAS_DIAGNOSIS: bool = true;
    const USES_SENT: bool = true;

    fn ready(&self) -> bool {
        Node::ready(self)
    }

    fn receive(&mut self, now: Instant, frame: &Frame) {
        Node::receive(self, now, frame);
    }

    fn proceed(&mut self) -> bool {
        false
    }

    fn bus(&mut self, now: Instant, event: BusEvent) {
        Node::bus(self, now, event);
    }

    fn is_sending(&self) -> bool {
        true
    }

    fn sends_once(&self) -> bool {
        Node::sends_once(self)
    }

    fn transmit(&mut self, now: impl FnOnce() -> Instant) -> Option<Frame> {
        Node::transmit(self, now())
    }

    fn sent(&mut self, now: Instant) {
        Node::sent(self, now);
    }

    /// The change of the filters, which follows at once, discards the frames.
    fn withdraws(&self) -> bool {
        false
    }

    fn changes_filters(&self) -> bool {
        Node::changes_filters(self)
    }

    fn filters(&self, accept: &mut dyn FnMut(Filter)) {
        Node::filters(self, accept);
    }

    fn contact(&self) -> Option<Contact> {
        Node::contact(self)
    }

    fn usage(&self) -> Option<Usage> {
        Node::usage(self)
    }

    fn set_usage(&mut self, usage: &Usage) {
        Node::set_usage(self, usage);
    }
}

/// What happens to frames.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Phase {
    /// The controller is off the bus, or leaves it: received frames are discarded.
    Off,
    /// The controller joins the bus, or its filters change: received frames wait.
    Waiting,
    /// Listen-only: frames are received.
    Listening,
    /// Frames are received and sent.
    Normal,
}

/// The mailboxes of a CAN controller, with its mode, and the received frames that the node cannot take yet.
pub struct Line<M> {
    received: Deque<Frame, QUEUE>,
    phase: Phase,
    /// The mode and bit rate that the node has requested last.
    bus: Option<(BusMode, BitRate)>,
    /// The controller is in bus-off.
    is_off: bool,
    /// A received frame was lost, because the queue was full. So there are frames in it, which [`Link::settle`] handles.
    lost: bool,
    pub(super) mailboxes: M,
}

impl<M> Line<M> {
    /// A line without received frames, off the bus.
    pub const fn new(mailboxes: M) -> Self {
        Self {
            received: Deque::new(),
            phase: Phase::Off,
            bus: None,
            is_off: false,
            lost: false,
            mailboxes,
        }
    }

    /// The phase after a change of the mode.
    fn open_phase(&self) -> Phase {
        match self.bus {
            None => Phase::Off,
            Some((BusMode::Listen, _)) => Phase::Listening,
            Some((BusMode::Normal, _)) => Phase::Normal,
        }
    }
}

impl<A: Application, P: Protocol<A>, M> Link<'_, Communication<A, P>, M> {
    /// The node and the line, for a driver that checks them.
    pub fn parts(&self) -> (&Communication<A, P>, &Line<M>) {
        (self.node, self.line)
    }

    /// Whether frames are exchanged with the node as this mode of the controller needs it, and none is lost: see [`Communication::serves`].
    pub fn serves(&self, mode: BusMode) -> bool {
        let phase = match mode {
            BusMode::Listen => Phase::Listening,
            BusMode::Normal => Phase::Normal,
        };
        self.line.phase == phase && !self.line.lost && self.node.serves(mode)
    }
}

/// Exclusive access to a node and its mailboxes: see the [module](super). `H` is the communicating half of the node, or the node.
pub struct Link<'a, H: ?Sized, M> {
    pub(super) node: &'a mut H,
    line: &'a mut Line<M>,
}

impl<'a, H: Exchange + ?Sized, M: Mailboxes> Link<'a, H, M> {
    /// A node with its mailboxes.
    pub fn new(node: &'a mut H, line: &'a mut Line<M>) -> Self {
        Self { node, line }
    }

    /// The mailboxes, for example to read their registers.
    pub fn mailboxes(&mut self) -> &mut M {
        &mut self.line.mailboxes
    }

    pub(super) fn now(&self) -> Instant {
        self.line.mailboxes.now()
    }

    pub(super) fn is_idle(&self) -> bool {
        self.line.mailboxes.is_idle()
    }

    pub(super) fn contact(&self) -> Option<Contact> {
        self.node.contact()
    }

    /// Changes the usage. Returns it with the result of `change`; None: the product does not store it.
    pub(super) fn watch<R>(&mut self, change: impl FnOnce(&mut Usage) -> R) -> Option<(Usage, R)> {
        let mut usage = self.node.usage()?;
        let result = change(&mut usage);
        self.node.set_usage(&usage);
        Some((usage, result))
    }

    fn receives(&self) -> bool {
        matches!(self.line.phase, Phase::Listening | Phase::Normal)
    }

    /// Handles a received frame: passes it to the node, or keeps it until the node can take it.
    pub fn receive(&mut self, frame: &Frame) {
        if self.line.phase == Phase::Off {
            return;
        }
        if self.receives() && self.line.received.is_empty() && self.node.ready() {
            self.handle(frame);
        } else if self.line.received.push_back(*frame).is_err() {
            self.line.lost = true;
        }
    }

    fn handle(&mut self, frame: &Frame) {
        // A frame that the main loop has just built does not wait for this answer. But it waits if the received frame can be a claim that
        // takes the address of this node.
        if self.node.is_sending() && !(self.node.changes_filters() && frame.is_extended()) {
            self.send();
        }
        let now = self.now();
        self.node.receive(now, frame);
        self.transmit();
        while self.node.proceed() {
            self.transmit();
        }
        self.withdraw();
    }

    /// Discards the frames in the mailboxes if the received frame has made them invalid, before the controller sends one of them.
    fn withdraw(&mut self) {
        if self.node.withdraws() {
            self.line.mailboxes.abort();
        }
    }

    /// A mailbox has become free: its frame was sent, or aborted, or is `unsent`: the controller made a single attempt, which ended in a
    /// bit error.
    pub fn transmitted(&mut self, unsent: bool) {
        // In another phase, the frame was aborted.
        if H::USES_SENT && unsent && self.line.phase == Phase::Normal {
            self.bus(BusEvent::Unsent);
        }
        self.send();
        if H::USES_SENT && self.line.phase == Phase::Normal && self.is_idle() {
            let now = self.now();
            self.node.sent(now);
        }
    }

    /// Passes an event to the node.
    pub(super) fn bus(&mut self, event: BusEvent) {
        if let BusEvent::State(state) = event {
            self.line.is_off = state == BusState::BusOff;
        }
        let now = self.now();
        self.node.bus(now, event);
    }

    /// Passes the frames that waited to the node, as far as it can take them, and sends the frames of the node. Returns true if there was
    /// such a frame.
    pub(super) fn settle(&mut self) -> bool {
        // Usually there is no frame: this is the shortest way to find that out, because a received frame waits meanwhile.
        if self.line.received.is_empty() && !self.node.is_sending() || !self.receives() {
            return false;
        }
        if core::mem::take(&mut self.line.lost) {
            self.bus(BusEvent::Overrun);
        }
        let mut moves = false;
        while !self.line.received.is_empty()
            && self.node.ready()
            && let Some(frame) = self.line.received.pop_front()
        {
            let now = self.now();
            self.node.receive(now, &frame);
            while self.node.proceed() {}
            self.withdraw();
            moves = true;
        }
        // Usually there is no frame. The check is shorter than the call, which saves many registers.
        moves | (self.node.is_sending() && self.send())
    }

    /// [`transmit`](Self::transmit) as a call, where no answer is sent. Measured: with both inlined, the slowest answer of the IS2 takes longer;
    /// with both called, that of the IMS360.
    #[inline(never)]
    fn send(&mut self) -> bool {
        self.transmit()
    }

    /// Puts the frames of the node into the free mailboxes. Returns false if there is none.
    fn transmit(&mut self) -> bool {
        let mut moves = false;
        while self.node.is_sending()
            && self.line.phase == Phase::Normal
            && self.line.mailboxes.has_room()
        {
            let once = self.node.sends_once();
            let mailboxes = &mut self.line.mailboxes;
            let Some(frame) = self.node.transmit(|| mailboxes.now()) else {
                break;
            };
            mailboxes.put(&frame, once);
            moves = true;
        }
        moves
    }

    /// Pauses the frames for a change of the bus. Call it in the same use of the link as the call that has returned the action, so that no
    /// frame is put into a mailbox that the change discards.
    pub(super) fn pause_for(&mut self, action: Action) {
        if let Action::Bus(mode, rate) = action {
            let line = &mut *self.line;
            let stays =
                line.phase == Phase::Normal && line.bus == Some((mode, rate)) && !line.is_off;
            line.bus = Some((mode, rate));
            line.mailboxes.abort();
            if stays && self.node.changes_filters() {
                line.phase = Phase::Waiting;
            } else {
                self.discard();
            }
        }
    }

    /// Discards the received frames until the controller has left the bus: they belong to the previous mode.
    pub(super) fn discard(&mut self) {
        self.line.phase = Phase::Off;
        self.line.lost = false;
        self.line.received.clear();
    }

    /// Follows a change of the mode.
    pub(super) fn follow(&mut self, change: Change) {
        self.line.phase = match change {
            Change::Leaving => Phase::Off,
            Change::Joining => Phase::Waiting,
            Change::Done => self.line.open_phase(),
        };
    }

    /// Whether only the filters change.
    pub(super) fn is_held(&self) -> bool {
        self.line.phase == Phase::Waiting
    }
}
