//! An adapter with faults, on a bus with another device.

use adapter::bench::{BenchAdapter, SharedBus};
use adapter::unread::Unread;
use adapter::{Adapter, AdapterError, Capabilities, Mode};
use bench::{AdapterId, Bus};
use plumbline::can::{BitRate, Frame};
use plumbline::time::{Instant, after, millis};
use std::cell::RefCell;
use std::rc::Rc;

/// An adapter that is unplugged after some requests, or does not have a rate.
pub(super) struct Unplugged {
    pub adapter: BenchAdapter,
    pub bus: SharedBus,
    pub left: usize,
    pub refused: Option<BitRate>,
    pub refuses_all: bool,
    pub cyclic: Option<Cyclic>,
    pub deaf: Option<(Instant, Instant)>,
    pub lost: fn(&Frame) -> bool,
    pub altered: Option<Altered>,
    pub events: Vec<Event>,
    pub overruns: Option<u64>,
    pub unread: Unread,
    pub only_active: bool,
    pub modes: Rc<RefCell<Vec<Mode>>>,
    pub interface: Option<BitRate>,
    pub opening: u32,
}

/// What happens to each frame that is received between these times.
pub type Altered = (Instant, Instant, fn(Frame) -> Frame);

/// What happens on the bus at a time.
pub type Event = (Instant, Rc<dyn Fn(&mut Bus)>);

/// Another device that sends a frame all the time.
pub(super) struct Cyclic {
    pub bus: SharedBus,
    pub id: AdapterId,
    pub frame: Frame,
    pub cycle: u32,
    pub next: Instant,
}

impl Cyclic {
    /// Sends the frame if it is time.
    fn run(&mut self, now: Instant) {
        if now >= self.next {
            self.bus.borrow_mut().send(self.id, self.frame);
            self.next = after(now, millis(self.cycle));
        }
    }
}

impl Unplugged {
    fn check(&self) -> Result<(), AdapterError> {
        match self.left {
            0 => Err(AdapterError::Lost("it".to_owned(), "unplugged".to_owned())),
            _ => Ok(()),
        }
    }
}

impl Adapter for Unplugged {
    fn capabilities(&self) -> Capabilities {
        let own = self.adapter.capabilities();
        Capabilities {
            listen_only: !self.only_active,
            sets_rate: own.sets_rate && self.interface.is_none(),
            needs_rate: own.needs_rate && self.interface.is_none(),
            ..own
        }
    }

    fn open(&mut self, rate: Option<BitRate>, mode: Mode) -> Result<(), AdapterError> {
        self.check()?;
        let rate = rate.or(self.interface);
        if rate.is_some() && (rate == self.refused || self.refuses_all) {
            return Err(AdapterError::RateRefused("it".to_owned(), "this rate"));
        }
        if self.only_active && mode == Mode::Listen {
            return Err(AdapterError::NoListenOnly("it".to_owned()));
        }
        self.modes.borrow_mut().push(mode);
        if self.opening > 0 {
            self.adapter.close();
            let until = after(self.now(), millis(self.opening));
            while self.receive(until)?.is_some() {}
        }
        self.adapter.open(rate, mode)
    }

    fn close(&mut self) {
        self.adapter.close();
    }

    fn send(&mut self, frame: &Frame) -> Result<(), AdapterError> {
        self.check()?;
        self.left -= 1;
        if (self.lost)(frame) {
            return Ok(());
        }
        self.adapter.send(frame)
    }

    fn receive(&mut self, until: Instant) -> Result<Option<(Instant, Frame)>, AdapterError> {
        self.check()?;
        loop {
            let now = self.adapter.now();
            let mut step = until;
            if let Some(cyclic) = &mut self.cyclic {
                cyclic.run(now);
                step = until.min(cyclic.next);
            }
            if let Some((at, happens)) = self.events.first().cloned() {
                if now >= at {
                    happens(&mut self.bus.borrow_mut());
                    self.events.remove(0);
                    continue;
                }
                step = step.min(at);
            }
            let mut received = self.adapter.receive(step)?;
            if let (Some((at, frame)), Some((from, to, altered))) = (&mut received, self.altered)
                && (from..to).contains(at)
            {
                *frame = altered(*frame);
            }
            if let (Some((at, _)), Some((from, to))) = (&received, self.deaf)
                && (from..to).contains(at)
            {
                continue;
            }
            if received.is_some() || step == until {
                return Ok(received);
            }
        }
    }

    fn now(&self) -> Instant {
        self.adapter.now()
    }

    fn rate(&self) -> Option<BitRate> {
        self.interface
    }

    fn errors(&mut self) -> Option<u64> {
        self.adapter.errors()
    }

    fn overruns(&mut self) -> Option<u64> {
        self.overruns
    }

    fn unread(&self) -> Option<Unread> {
        Some(self.unread.clone())
    }
}
