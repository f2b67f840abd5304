//! One adapter that samples and commands share, one after the other. It stays open between them.

use super::tap::Tap;
use adapter::unread::Unread;
use adapter::{Adapter, AdapterError, Capabilities, Mode};
use plumbline::can::{BitRate, Frame};
use plumbline::time::Instant;
use std::cell::RefCell;
use std::rc::Rc;

/// How an adapter is open.
type Opened = (Option<BitRate>, Mode);

/// The adapter of a port.
pub struct Shared {
    adapter: Box<dyn Adapter>,
    opened: Option<Opened>,
    /// A command that closes the adapter leaves it open like this.
    kept: Option<Opened>,
    /// The copy of the received and sent frames.
    pub tap: Tap,
}

/// A handle of the adapter.
#[derive(Clone)]
pub struct Lease(Rc<RefCell<Shared>>);

impl Lease {
    /// A handle of a new adapter.
    pub fn new(adapter: Box<dyn Adapter>) -> Self {
        Self(Rc::new(RefCell::new(Shared {
            adapter,
            opened: None,
            kept: None,
            tap: Tap::default(),
        })))
    }

    /// Keeps the adapter open as it is when a command closes it.
    pub fn keep(&self) {
        let mut shared = self.0.borrow_mut();
        shared.kept = shared.opened;
    }

    /// Whether the adapter is open as it was kept.
    pub fn is_kept(&self) -> bool {
        let shared = self.0.borrow();
        shared.opened.is_some() && shared.opened == shared.kept
    }

    /// Closes the adapter, independent of its use.
    pub fn end(&self) {
        let mut shared = self.0.borrow_mut();
        (shared.kept, shared.opened) = (None, None);
        shared.adapter.close();
    }

    /// The frames of the adapter.
    pub fn with_tap<T>(&self, run: impl FnOnce(&mut Tap) -> T) -> T {
        run(&mut self.0.borrow_mut().tap)
    }
}

impl Adapter for Lease {
    fn capabilities(&self) -> Capabilities {
        self.0.borrow().adapter.capabilities()
    }

    fn open(&mut self, rate: Option<BitRate>, mode: Mode) -> Result<(), AdapterError> {
        let mut shared = self.0.borrow_mut();
        // An interface has a rate of its own, which need not be given.
        let own = shared.adapter.rate();
        let is_same =
            |(before, of): (Option<BitRate>, Mode)| (before.or(own), of) == (rate.or(own), mode);
        if shared.opened.is_some_and(is_same) {
            return Ok(());
        }
        shared.opened = None;
        shared.adapter.open(rate, mode)?;
        shared.opened = Some((rate, mode));
        Ok(())
    }

    fn close(&mut self) {
        let mut shared = self.0.borrow_mut();
        if shared.opened.is_some() && shared.opened == shared.kept {
            return;
        }
        shared.opened = None;
        shared.adapter.close();
    }

    fn send(&mut self, frame: &Frame) -> Result<(), AdapterError> {
        let mut shared = self.0.borrow_mut();
        shared.adapter.send(frame)?;
        let now = shared.adapter.now();
        shared.tap.sent(now, frame);
        Ok(())
    }

    fn receive(&mut self, until: Instant) -> Result<Option<(Instant, Frame)>, AdapterError> {
        let mut shared = self.0.borrow_mut();
        let received = shared.adapter.receive(until)?;
        if let Some((at, frame)) = &received {
            shared.tap.received(*at, frame);
        }
        Ok(received)
    }

    fn now(&self) -> Instant {
        self.0.borrow().adapter.now()
    }

    fn rate(&self) -> Option<BitRate> {
        self.0.borrow().adapter.rate()
    }

    fn errors(&mut self) -> Option<u64> {
        self.0.borrow_mut().adapter.errors()
    }

    fn overruns(&mut self) -> Option<u64> {
        self.0.borrow_mut().adapter.overruns()
    }

    fn unread(&self) -> Option<Unread> {
        self.0.borrow().adapter.unread()
    }
}
