//! The transmit mailboxes of a simulated CAN controller, shared by the driver of the node and the side of the wire.

use plumbline::can::{BitRate, Frame};
use plumbline::node::driver::{Controller, Phase};
use plumbline::time::Instant;
use std::cell::{Cell, RefCell};
use std::collections::VecDeque;
use std::rc::Rc;

/// The number of mailboxes that the driver uses, as on the boards.
const MAILBOXES: usize = 2;

/// A frame in a mailbox.
#[derive(Clone, Copy, Debug)]
struct Mailbox {
    frame: Frame,
    /// It is not repeated after a bit error.
    once: bool,
    /// It is being sent, and dropped if it fails.
    aborted: bool,
}

/// The mailboxes, and the state of the controller that the driver reads.
#[derive(Debug)]
struct Shared {
    now: Cell<Instant>,
    phase: Cell<Phase>,
    /// The phase that the driver has set, until the change that it waits for.
    paused: Cell<Option<Phase>>,
    /// The bit rate, in normal mode and not in bus-off.
    rate: Cell<Option<BitRate>>,
    mailboxes: RefCell<VecDeque<Mailbox>>,
    /// The frame in the first mailbox is on the wire.
    is_transmitting: Cell<bool>,
    lost: Cell<bool>,
}

/// The registers of the mailboxes.
#[derive(Clone, Debug)]
pub(super) struct Registers(Rc<Shared>);

impl Registers {
    /// A controller that is not on the bus.
    pub(super) fn new(now: Instant) -> Self {
        Self(Rc::new(Shared {
            now: Cell::new(now),
            phase: Cell::new(Phase::Off),
            paused: Cell::new(None),
            rate: Cell::new(None),
            mailboxes: RefCell::default(),
            is_transmitting: Cell::new(false),
            lost: Cell::new(false),
        }))
    }

    /// Sets the time that the driver reads.
    pub(super) fn set_time(&self, now: Instant) {
        self.0.now.set(now);
    }

    /// Sets the state of the controller. `rate` is its bit rate in normal mode, None in bus-off.
    pub(super) fn set_state(&self, phase: Phase, rate: Option<BitRate>, is_transmitting: bool) {
        self.0.phase.set(phase);
        self.0.rate.set(rate);
        self.0.is_transmitting.set(is_transmitting);
    }

    /// Ends the pause that the driver has begun.
    pub(super) fn resume(&self) {
        self.0.paused.set(None);
    }

    /// The frame that is sent next, or being sent.
    pub(super) fn first(&self) -> Option<Frame> {
        let mailboxes = self.0.mailboxes.borrow();
        mailboxes.front().map(|mailbox| mailbox.frame)
    }

    /// Removes all frames from the mailboxes.
    pub(super) fn clear(&self) {
        self.0.mailboxes.borrow_mut().clear();
    }

    /// The first frame was sent.
    pub(super) fn sent(&self) {
        self.0.mailboxes.borrow_mut().pop_front();
    }

    /// The first frame ended in a bit error. Returns true if it is not repeated.
    pub(super) fn failed(&self) -> bool {
        self.take_if(|first| first.once)
    }

    /// The first frame is not on the wire any more. Returns true if it was aborted.
    pub(super) fn drop_aborted(&self) -> bool {
        self.take_if(|first| first.aborted)
    }

    fn take_if(&self, condition: impl Fn(&Mailbox) -> bool) -> bool {
        let mut mailboxes = self.0.mailboxes.borrow_mut();
        let takes = mailboxes.front().is_some_and(condition);
        if takes {
            mailboxes.pop_front();
        }
        takes
    }

    /// Whether the driver has lost received frames since the last call.
    pub(super) fn take_lost(&self) -> bool {
        self.0.lost.take()
    }
}

impl Controller for Registers {
    fn now(&self) -> Instant {
        self.0.now.get()
    }

    fn phase(&self) -> Phase {
        self.0.paused.get().unwrap_or(self.0.phase.get())
    }

    fn pause(&mut self, phase: Phase) {
        self.0.paused.set(Some(phase));
    }

    fn is_at(&self, rate: BitRate) -> bool {
        self.0.rate.get() == Some(rate)
    }

    fn has_room(&self) -> bool {
        self.0.mailboxes.borrow().len() < MAILBOXES
    }

    fn is_idle(&self) -> bool {
        self.0.mailboxes.borrow().is_empty()
    }

    fn put(&mut self, frame: &Frame, once: bool) {
        self.0.mailboxes.borrow_mut().push_back(Mailbox {
            frame: *frame,
            once,
            aborted: false,
        });
    }

    fn abort(&mut self) {
        let on_wire = usize::from(self.0.is_transmitting.get());
        let mut mailboxes = self.0.mailboxes.borrow_mut();
        mailboxes.truncate(on_wire);
        for first in &mut *mailboxes {
            first.aborted = true;
        }
    }

    fn lose(&mut self) {
        self.0.lost.set(true);
    }
}
