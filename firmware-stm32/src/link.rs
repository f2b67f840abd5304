//! The communicating half of the node with the receive FIFO and the transmit mailboxes. The CAN interrupts and the main loop share
//! it.
//!
//! The receive interrupt passes a frame to the node and puts the answer into a mailbox at once, also while the main loop calculates
//! or reads the accelerometer. Interrupts are masked only while one of both uses the link: each use is short.

use crate::can::transmit::{self, End};
use crate::can::{self, Phase, receive};
use crate::{clock, sleep};
use core::cell::Cell;
use cortex_m::peripheral::SCB;
use critical_section::{CriticalSection, Mutex};
use embedded_can::Frame as _;
use heapless::Deque;
use plumbline::application::Application;
use plumbline::can::Frame;
use plumbline::node::{BusEvent, Communication, Divided, Protocol};
use plumbline::time::Instant;

/// The maximum number of received frames that wait while parameters are applied, or while the bus mode changes: 1.5 ms at 1 Mbit/s
/// with the shortest frames and 100 % bus load.
const QUEUE: usize = 32;

/// Memory for frames.
pub struct Frames {
    /// Received frames that the node cannot take yet.
    received: Deque<Frame, QUEUE>,
    /// The frame in a mailbox for which the controller makes a single attempt.
    once: Option<Frame>,
}

impl Frames {
    /// No frame.
    pub const EMPTY: Self = Self {
        received: Deque::new(),
        once: None,
    };
}

/// The communicating half of a node with its frames.
pub struct Link<A: Application + 'static, P: 'static> {
    /// The communicating half.
    pub node: &'static mut Communication<A, P>,
    // The interrupts move the link, so the frames are not in it.
    frames: &'static mut Frames,
}

impl<A: Application, P: Protocol<A>> Link<A, P> {
    /// Takes the frames in the receive FIFO: passes them to the node, or keeps them until the node can take them.
    fn receive(&mut self) {
        while let Some(received) = receive::next() {
            let phase = can::phase();
            let Some(frame) = received.filter(|_| phase != Phase::Leaving) else {
                continue;
            };
            if phase.receives() && self.frames.received.is_empty() && self.node.ready() {
                self.handle(&frame);
            } else if self.frames.received.push_back(frame).is_err() {
                receive::lose();
            }
        }
    }

    fn handle(&mut self, frame: &Frame) {
        // A frame that the main loop has just built does not wait for this answer. But it waits if the received frame can be a claim that
        // takes the address of this node.
        if self.node.is_sending() && !(P::CHANGES_FILTERS && frame.is_extended()) {
            self.send();
        }
        self.node.receive(clock::now(), frame);
        self.transmit();
        while self.node.proceed() {
            self.transmit();
        }
        self.withdraw();
    }

    /// Discards the frames in the mailboxes if the received frame has made them invalid, before the controller sends one of them.
    fn withdraw(&mut self) {
        if self.node.withdraws() {
            transmit::abort_all();
        }
    }

    /// Discards the frames that wait, at a change of the bit rate.
    pub fn discard(&mut self) {
        self.frames.received.clear();
    }

    /// Passes the frames that waited to the node, as far as it can take them, and sends the frames of the node.
    fn settle(&mut self) {
        if !can::phase().receives() {
            return;
        }
        while !self.frames.received.is_empty()
            && self.node.ready()
            && let Some(frame) = self.frames.received.pop_front()
        {
            self.node.receive(clock::now(), &frame);
            while self.node.proceed() {}
            self.withdraw();
        }
        // Usually nothing: the check is shorter than the call, which saves many registers.
        if self.node.is_sending() {
            self.send();
        }
    }

    /// As [`transmit`](Self::transmit).
    fn send(&mut self) {
        self.transmit();
    }

    /// Puts the frames of the node into the free mailboxes.
    fn transmit(&mut self) {
        while self.node.is_sending() && can::phase() == Phase::Normal && transmit::has_room() {
            let once = self.node.sends_once();
            let Some(frame) = self.node.transmit() else {
                return;
            };
            if P::USES_SENT && (once || self.frames.once.is_some()) {
                transmit::set_single_attempt(once);
                self.frames.once = once.then_some(frame);
            }
            transmit::put(&frame);
        }
    }

    /// Handles the end of the frame for which the controller made a single attempt.
    fn end_attempt(&mut self, frame: &Frame, end: End) {
        // In another phase, the frame was withdrawn.
        let is_normal = can::phase() == Phase::Normal;
        if end == End::Again && is_normal {
            transmit::put(frame);
            return;
        }
        self.frames.once = None;
        transmit::set_single_attempt(false);
        if end == End::Failed && is_normal {
            self.node.bus(clock::now(), BusEvent::Unsent);
        }
    }
}

/// The link of a product, in static memory. It is None before the start, and while it is in use.
pub struct Shared<N: Divided>(Mutex<Cell<Option<LinkOf<N>>>>);

/// The link of node `N`.
pub type LinkOf<N> = Link<<N as Divided>::Application, <N as Divided>::Protocol>;

impl<N: Divided> Shared<N> {
    /// Before the start of the node.
    pub const fn empty() -> Self {
        Self(Mutex::new(Cell::new(None)))
    }

    /// Takes the communicating half of the node, and memory for frames that wait. The CAN interrupts must not be enabled yet.
    pub fn start(
        &self,
        node: &'static mut Communication<N::Application, N::Protocol>,
        frames: &'static mut Frames,
    ) {
        let link = Link { node, frames };
        critical_section::with(|cs| self.0.borrow(cs).set(Some(link)));
    }

    /// Uses the link while the interrupts are masked.
    pub fn with<R>(&self, f: impl FnOnce(&mut LinkOf<N>) -> R) -> R {
        critical_section::with(|cs| {
            let mut link = self.take(cs);
            let result = f(&mut link);
            self.0.borrow(cs).set(Some(link));
            result
        })
    }

    fn take(&self, cs: CriticalSection<'_>) -> LinkOf<N> {
        self.take_at_once(cs)
    }

    fn take_at_once(&self, cs: CriticalSection<'_>) -> LinkOf<N> {
        match self.0.borrow(cs).take() {
            Some(link) => link,
            // Not possible: uses are not nested, and the interrupts are enabled after the start.
            None => SCB::sys_reset(),
        }
    }

    /// Calls a method of the node, then handles the frames that waited for it, and sends its frames.
    pub fn call<R>(
        &self,
        f: impl FnOnce(&mut Communication<N::Application, N::Protocol>, Instant) -> R,
    ) -> R {
        let result = self.with(|link| f(link.node, clock::now()));
        self.settle();
        result
    }

    /// Handles the frames that waited for the node, and sends its frames.
    pub fn settle(&self) {
        self.with(Link::settle);
    }

    /// The receive interrupt.
    ///
    /// # Safety
    /// Call it only in the receive interrupt. The interrupts that use the link, and SysTick, must have the same priority.
    pub unsafe fn on_received(&self) {
        // SAFETY: no other interrupt that uses a `Mutex` interrupts this one, and the main loop does not run.
        let cs = unsafe { CriticalSection::new() };
        let mut link = self.take_at_once(cs);
        link.receive();
        self.0.borrow(cs).set(Some(link));
        sleep::wake();
    }

    /// The transmit interrupt: a mailbox has become free.
    ///
    /// # Safety
    /// Call it only in the transmit interrupt. The priorities must be as for [`on_received`](Self::on_received).
    pub unsafe fn on_transmitted(&self) {
        // SAFETY: as in `on_received`.
        let cs = unsafe { CriticalSection::new() };
        let mut link = self.take(cs);
        let attempt = match link.frames.once {
            Some(frame) if N::Protocol::USES_SENT => Some((frame, transmit::end())),
            _ => None,
        };
        transmit::acknowledge();
        if let Some((frame, end)) = attempt {
            link.end_attempt(&frame, end);
        }
        link.send();
        if N::Protocol::USES_SENT && can::phase() == Phase::Normal && transmit::is_idle() {
            link.node.sent(clock::now());
        }
        self.0.borrow(cs).set(Some(link));
        sleep::wake();
    }
}
