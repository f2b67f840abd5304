//! An adapter at which a test does something.

use adapter::unread::Unread;
use adapter::{Adapter, AdapterError, Capabilities, Mode};
use plumbline::can::{BitRate, Frame};
use plumbline::time::Instant;
use std::any::Any;
use std::thread;
use std::time::Duration;

/// What is received until a time.
pub type Received = Result<Option<(Instant, Frame)>, AdapterError>;

/// How much faster the time of the bus passes than that of the computer.
const SPEEDUP: u64 = 20;

/// What a test does at the adapter. What it does not define is done by the adapter alone.
pub trait Hook {
    fn capabilities(&self, own: Capabilities) -> Capabilities {
        own
    }

    fn open(
        &mut self,
        adapter: &mut dyn Adapter,
        rate: Option<BitRate>,
        mode: Mode,
    ) -> Result<(), AdapterError> {
        adapter.open(rate, mode)
    }

    fn send(&mut self, adapter: &mut dyn Adapter, frame: &Frame) -> Result<(), AdapterError> {
        adapter.send(frame)
    }

    fn receive(&mut self, adapter: &mut dyn Adapter, until: Instant) -> Received {
        adapter.receive(until)
    }

    fn errors(&mut self, own: Option<u64>) -> Option<u64> {
        own
    }

    fn unread(&self, own: Option<Unread>) -> Option<Unread> {
        own
    }
}

/// An adapter with a hook.
pub struct Hooked<H> {
    adapter: Box<dyn Adapter>,
    hook: H,
}

impl<H: Hook> Hooked<H> {
    pub fn new(adapter: impl Adapter + 'static, hook: H) -> Box<Self> {
        Self::around(Box::new(adapter), hook)
    }

    pub fn around(adapter: Box<dyn Adapter>, hook: H) -> Box<Self> {
        Box::new(Self { adapter, hook })
    }
}

impl<H: Hook> Adapter for Hooked<H> {
    fn capabilities(&self) -> Capabilities {
        self.hook.capabilities(self.adapter.capabilities())
    }

    fn open(&mut self, rate: Option<BitRate>, mode: Mode) -> Result<(), AdapterError> {
        self.hook.open(&mut *self.adapter, rate, mode)
    }

    fn close(&mut self) {
        self.adapter.close();
    }

    fn send(&mut self, frame: &Frame) -> Result<(), AdapterError> {
        self.hook.send(&mut *self.adapter, frame)
    }

    fn receive(&mut self, until: Instant) -> Received {
        self.hook.receive(&mut *self.adapter, until)
    }

    fn now(&self) -> Instant {
        self.adapter.now()
    }

    fn errors(&mut self) -> Option<u64> {
        let own = self.adapter.errors();
        self.hook.errors(own)
    }

    fn unread(&self) -> Option<Unread> {
        self.hook.unread(self.adapter.unread())
    }

    fn stand_in(&mut self) -> Option<&mut dyn Any> {
        self.adapter.stand_in()
    }
}

/// Receives, and leaves the processor to others, so that the bus does not run far ahead of the one who reads the events. No assertion
/// depends on this pause.
pub fn paced(adapter: &mut dyn Adapter, until: Instant) -> Received {
    let start = adapter.now();
    let received = adapter.receive(until)?;
    let passed = adapter.now().ticks() - start.ticks();
    thread::sleep(Duration::from_micros(passed / SPEEDUP));
    Ok(received)
}
