//! A bus with a virtual sensor on which another device sends a frame every 100 ms.

use crate::serve::hooked::{Hook, Hooked, Received};
use adapter::unread::Unread;
use adapter::{Adapter, AdapterError, Mode};
use plumbline::can::{BitRate, CanId, Frame};
use plumbline::time::{Instant, after, millis};
use plumbline_tool::demo;
use plumbline_tool::error::Error;
use plumbline_tool::serve::job::Opener;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// What a test sees and does.
#[derive(Default)]
pub struct Witness {
    sent: Mutex<Vec<u32>>,
    /// The errors that the adapter tells. 0: it tells none.
    pub errors: AtomicU64,
    /// The lines of the adapter that the tool cannot read.
    pub unread: AtomicU64,
    /// Nobody hears the tool, and the tool hears nobody.
    pub is_cut: AtomicBool,
    /// The adapter is unplugged.
    pub is_out: AtomicBool,
}

impl Witness {
    fn kept(&self) -> MutexGuard<'_, Vec<u32>> {
        self.sent.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The identifiers that the tool has sent since the last call.
    pub fn sent(&self) -> Vec<u32> {
        std::mem::take(&mut *self.kept())
    }
}

struct Foreign {
    frame: Frame,
    next: Instant,
    rate: Option<BitRate>,
    witness: Arc<Witness>,
}

impl Foreign {
    fn check(&self) -> Result<(), AdapterError> {
        match self.witness.is_out.load(Ordering::Relaxed) {
            true => Err(AdapterError::Lost("it".to_owned(), "unplugged".to_owned())),
            false => Ok(()),
        }
    }
}

impl Hook for Foreign {
    fn open(
        &mut self,
        adapter: &mut dyn Adapter,
        rate: Option<BitRate>,
        mode: Mode,
    ) -> Result<(), AdapterError> {
        self.check()?;
        self.rate = rate;
        self.next = adapter.now();
        adapter.open(rate, mode)
    }

    fn send(&mut self, adapter: &mut dyn Adapter, frame: &Frame) -> Result<(), AdapterError> {
        self.witness.kept().push(frame.can_id().bits());
        adapter.send(frame)
    }

    fn receive(&mut self, adapter: &mut dyn Adapter, until: Instant) -> Received {
        // The bus has 250 kbit/s.
        self.check()?;
        let is_cut = self.witness.is_cut.load(Ordering::Relaxed);
        let is_heard = !is_cut && self.rate.is_none_or(|rate| rate == BitRate::K250);
        let wait = if is_heard {
            until.min(self.next)
        } else {
            until
        };
        let mut received = adapter.receive(wait)?;
        while is_cut && received.is_some() {
            received = adapter.receive(wait)?;
        }
        if received.is_none() && is_heard && self.next <= until {
            let at = self.next.max(adapter.now());
            self.next = after(at, millis(100));
            return Ok(Some((at, self.frame)));
        }
        Ok(received)
    }

    fn errors(&mut self, _: Option<u64>) -> Option<u64> {
        let errors = self.witness.errors.load(Ordering::Relaxed);
        (errors > 0).then_some(errors)
    }

    fn unread(&self, _: Option<Unread>) -> Option<Unread> {
        let unread = Unread::default();
        for _ in 0..self.witness.unread.load(Ordering::Relaxed) {
            unread.take(b"y123".to_vec());
        }
        Some(unread)
    }
}

/// The heartbeat of CANopen node 34.
pub fn heartbeat() -> Frame {
    Frame::of(CanId::standard(0x722), [5, 0, 0, 0, 0, 0, 0, 0], 1)
}

/// A frame that says nothing of its device.
pub fn unknown() -> Frame {
    Frame::of(CanId::standard(0x123), [0; 8], 8)
}

/// Adapters of a bus with an IS2 and a device that sends this frame.
pub fn opener(frame: Frame) -> (Opener, Arc<Witness>) {
    let witness = Arc::new(Witness::default());
    let own = witness.clone();
    let opener = Box::new(move |_: &str| -> Result<Box<dyn Adapter>, Error> {
        let adapter = Box::new(demo::unpaced("is2")?);
        let hook = Foreign {
            next: adapter.now(),
            frame,
            rate: None,
            witness: own.clone(),
        };
        Ok(Hooked::around(adapter, hook))
    });
    (opener, witness)
}
