//! One adapter that samples and commands share, one after the other. It stays open between them. While they wait for frames, it sends those
//! of the transmit list.

use super::tap::Tap;
use super::transmission::Transmission;
use crate::demo::StandIn;
use adapter::unread::Unread;
use adapter::{Adapter, AdapterError, Capabilities, Mode};
use plumbline::can::{BitRate, Frame};
use plumbline::time::Instant;
use std::any::Any;
use std::cell::RefCell;
use std::rc::Rc;

/// Moves the virtual sensor behind an adapter, as the user has asked meanwhile.
pub type Moves = Box<dyn FnMut(&mut StandIn)>;

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
    /// What is sent while somebody waits for a frame.
    transmission: Rc<RefCell<Transmission>>,
    moves: Moves,
}

impl Shared {
    /// What was sent before is not sent on a bus that was closed, or at another bit rate.
    fn stop(&mut self) {
        self.opened = None;
        self.transmission.borrow_mut().stop();
    }

    fn send(&mut self, frame: &Frame) -> Result<(), AdapterError> {
        self.adapter.send(frame)?;
        let now = self.adapter.now();
        self.tap.sent(now, frame);
        Ok(())
    }

    /// Sends the frame that is due. Returns when the next one is.
    fn transmit(&mut self) -> Result<Option<Instant>, AdapterError> {
        let rate = self.opened.and_then(|(rate, _)| rate);
        let (now, rate) = (self.adapter.now(), rate.or(self.adapter.rate()));
        let frame = self.transmission.borrow().frame(now);
        if let Some(frame) = frame {
            self.send(&frame)?;
            self.transmission.borrow_mut().sent(&frame, now, rate);
        }
        Ok(self.transmission.borrow().due())
    }
}

/// A handle of the adapter.
#[derive(Clone)]
pub struct Lease(Rc<RefCell<Shared>>);

impl Lease {
    /// A handle of a new adapter, which sends this beside what it is asked for.
    pub fn new(
        adapter: Box<dyn Adapter>,
        transmission: Rc<RefCell<Transmission>>,
        moves: Moves,
    ) -> Self {
        Self::with(adapter, Tap::default(), transmission, moves)
    }

    /// A handle of a new adapter, which keeps only the messages of sensors, not the frames.
    pub fn of_messages(adapter: Box<dyn Adapter>) -> Self {
        Self::with(adapter, Tap::hidden(), Rc::default(), Box::new(|_| {}))
    }

    fn with(
        adapter: Box<dyn Adapter>,
        tap: Tap,
        transmission: Rc<RefCell<Transmission>>,
        moves: Moves,
    ) -> Self {
        Self(Rc::new(RefCell::new(Shared {
            adapter,
            opened: None,
            kept: None,
            tap,
            transmission,
            moves,
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
        shared.kept = None;
        shared.stop();
        shared.adapter.close();
    }

    /// Does something with the virtual sensor behind the adapter; None: the bus is real.
    pub fn with_stand_in<T>(&self, run: impl FnOnce(&mut StandIn) -> T) -> Option<T> {
        let mut shared = self.0.borrow_mut();
        let stand_in = shared.adapter.stand_in()?.downcast_mut()?;
        Some(run(stand_in))
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
        shared.stop();
        shared.adapter.open(rate, mode)?;
        shared.opened = Some((rate, mode));
        Ok(())
    }

    fn close(&mut self) {
        let mut shared = self.0.borrow_mut();
        if shared.opened.is_some() && shared.opened == shared.kept {
            return;
        }
        shared.stop();
        shared.adapter.close();
    }

    fn send(&mut self, frame: &Frame) -> Result<(), AdapterError> {
        self.0.borrow_mut().send(frame)
    }

    fn receive(&mut self, until: Instant) -> Result<Option<(Instant, Frame)>, AdapterError> {
        let shared = &mut *self.0.borrow_mut();
        if let Some(stand_in) = shared.adapter.stand_in().and_then(<dyn Any>::downcast_mut) {
            (shared.moves)(stand_in);
        }
        loop {
            let due = shared.transmit()?;
            let slice = due.map_or(until, |due| due.min(until));
            let received = shared.adapter.receive(slice)?;
            if let Some((at, frame)) = &received {
                shared.tap.received(*at, frame);
            }
            // An adapter can return before its time.
            let now = shared.adapter.now();
            if received.is_some() || now >= until || now < slice {
                return Ok(received);
            }
        }
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

#[cfg(test)]
mod tests {
    use super::*;
    use adapter::bench::BenchAdapter;
    use bench::{Bus, BusRate};

    #[test]
    fn adapter_at_another_bit_rate_is_not_open_as_it_was_kept() {
        let bus = Rc::new(RefCell::new(Bus::new(BusRate::Follow)));
        let mut lease = Lease::of_messages(Box::new(BenchAdapter::new(&bus)));
        let rates = [BitRate::K125, BitRate::K250].map(Some);
        lease.open(rates[0], Mode::Active).expect("it opens");
        assert!(!lease.is_kept());
        lease.keep();
        lease.close();
        assert!(lease.is_kept(), "a command leaves it open");
        lease.open(rates[1], Mode::Active).expect("it opens");
        assert!(!lease.is_kept());
    }
}
