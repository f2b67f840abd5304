//! An adapter on the bus of the test bench, in virtual time.

use crate::error::AdapterError;
use crate::{Adapter, Capabilities, Mode};
use bench::{AdapterId, Bus, Source};
use plumbline::can::{BitRate, Frame};
use plumbline::time::{Duration, Instant, after, millis};
use std::cell::RefCell;
use std::collections::VecDeque;
use std::rc::Rc;

/// The shortest step of the bus.
const STEP: Duration = Duration::from_ticks(100);

/// The longest step of the bus.
const STRIDE: Duration = millis(20);

/// The bus, which several adapters share.
pub type SharedBus = Rc<RefCell<Bus>>;

/// An adapter on a shared bus. Waiting runs the bus.
pub struct BenchAdapter {
    bus: SharedBus,
    id: AdapterId,
    mode: Option<Mode>,
    received: VecDeque<(Instant, Frame)>,
    /// The errors before it was opened.
    errors: u64,
}

impl BenchAdapter {
    /// A new adapter on this bus.
    pub fn new(bus: &SharedBus) -> Self {
        let id = bus.borrow_mut().adapter();
        Self {
            bus: bus.clone(),
            id,
            mode: None,
            received: VecDeque::new(),
            errors: 0,
        }
    }

    /// Forgets the frames that the bus has logged: nobody reads them.
    pub fn forget_log(&self) {
        self.bus.borrow_mut().take_log();
    }

    fn disturbed(&self) -> u64 {
        self.bus.borrow().disturbed(Source::Adapter(self.id))
    }
}

impl Adapter for BenchAdapter {
    fn capabilities(&self) -> Capabilities {
        Capabilities {
            listen_only: true,
            sets_rate: true,
            needs_rate: true,
            reports_errors: true,
        }
    }

    fn open(&mut self, rate: Option<BitRate>, mode: Mode) -> Result<(), AdapterError> {
        self.close();
        self.received.clear();
        let mut bus = self.bus.borrow_mut();
        bus.take_received(self.id);
        bus.open(self.id, rate, mode == Mode::Listen);
        drop(bus);
        self.mode = Some(mode);
        self.errors = self.disturbed();
        Ok(())
    }

    fn close(&mut self) {
        self.bus.borrow_mut().close(self.id);
        self.mode = None;
    }

    fn send(&mut self, frame: &Frame) -> Result<(), AdapterError> {
        if self.mode != Some(Mode::Active) {
            return Err(AdapterError::NotOpen);
        }
        self.bus.borrow_mut().send(self.id, *frame);
        Ok(())
    }

    fn receive(&mut self, until: Instant) -> Result<Option<(Instant, Frame)>, AdapterError> {
        loop {
            if let Some(received) = self.received.pop_front() {
                return Ok(Some(received));
            }
            let mut bus = self.bus.borrow_mut();
            let now = bus.now();
            self.received.extend(bus.take_received(self.id));
            if !self.received.is_empty() {
                continue;
            }
            if now >= until {
                return Ok(None);
            }
            let next = bus.next_event().unwrap_or(until);
            let next = next.max(after(now, STEP)).min(after(now, STRIDE));
            bus.run_until(next.min(until));
        }
    }

    fn now(&self) -> Instant {
        self.bus.borrow().now()
    }

    fn errors(&mut self) -> Option<u64> {
        Some(self.disturbed().saturating_sub(self.errors))
    }
}
