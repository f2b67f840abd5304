//! The masters: one request, one answer, over an adapter.
//!
//! - [`Link`]: the adapter with a count of the frames that were sent
//! - [`fsc`]: GEMAC function select codes
//! - [`sdo`], [`nmt`], [`lss`]: CANopen
//! - [`devicenet`]: explicit messages of DeviceNet

pub mod devicenet;
pub mod fsc;
pub mod lss;
pub mod nmt;
pub mod sdo;

use crate::adapter::{Adapter, Mode};
use crate::failure::Failure;
use crate::identify::boot_up;
use plumbline::can::{BitRate, Frame};
use plumbline::time::{Duration, Instant, after};

/// An adapter, and what was sent with it.
pub struct Link {
    adapter: Box<dyn Adapter>,
    rate: Option<BitRate>,
    /// The frames that were sent at each rate, in the order of the rates.
    sent: Vec<(Option<BitRate>, u64)>,
    /// The sensors whose boot-up message came while another answer was awaited.
    booted: Vec<fsc::Sensor>,
}

impl Link {
    /// A link over an adapter, which is not open yet.
    pub fn new(adapter: Box<dyn Adapter>) -> Self {
        Self {
            adapter,
            rate: None,
            sent: Vec::new(),
            booted: Vec::new(),
        }
    }

    /// The adapter.
    pub fn adapter(&mut self) -> &mut dyn Adapter {
        self.adapter.as_mut()
    }

    /// The bit rate at which it was opened; None: that of the interface.
    pub fn rate(&self) -> Option<BitRate> {
        self.rate
    }

    /// Opens the adapter; see [`Adapter::open`].
    ///
    /// # Errors
    /// Those of the adapter.
    pub fn open(&mut self, rate: Option<BitRate>, mode: Mode) -> Result<(), Failure> {
        self.rate = rate;
        self.adapter.open(rate, mode)
    }

    /// Sends a frame and counts it.
    ///
    /// # Errors
    /// Those of the adapter.
    pub fn send(&mut self, frame: &Frame) -> Result<(), Failure> {
        self.adapter.send(frame)?;
        match self.sent.iter_mut().find(|(rate, _)| *rate == self.rate) {
            Some((_, count)) => *count += 1,
            None => self.sent.push((self.rate, 1)),
        }
        Ok(())
    }

    /// The frames that were sent at each rate.
    pub fn sent(&self) -> &[(Option<BitRate>, u64)] {
        &self.sent
    }

    /// The present time.
    pub fn now(&self) -> Instant {
        self.adapter.now()
    }

    /// The next frame until then.
    ///
    /// # Errors
    /// Those of the adapter.
    pub fn receive(&mut self, until: Instant) -> Result<Option<(Instant, Frame)>, Failure> {
        let received = self.adapter.receive(until)?;
        if let Some(sensor) = received.and_then(|(_, frame)| boot_up(&frame))
            && !self.booted.contains(&sensor)
        {
            self.booted.push(sensor);
        }
        Ok(received)
    }

    /// The GEMAC sensors that have sent a boot-up message since the last call. A sensor that detects the bit rate sends it after a
    /// question to any address.
    pub fn take_booted(&mut self) -> Vec<fsc::Sensor> {
        std::mem::take(&mut self.booted)
    }

    /// Waits this time for the first frame that `judge` takes; others are ignored.
    ///
    /// # Errors
    /// Those of the adapter.
    pub fn wait_for<T>(
        &mut self,
        time: Duration,
        mut judge: impl FnMut(&Frame) -> Option<T>,
    ) -> Result<Option<T>, Failure> {
        let until = after(self.now(), time);
        while let Some((_, frame)) = self.receive(until)? {
            if let Some(answer) = judge(&frame) {
                return Ok(Some(answer));
            }
        }
        Ok(None)
    }

    /// Sends a frame, and waits this time for the first frame that `judge` takes.
    ///
    /// # Errors
    /// Those of the adapter.
    pub fn ask<T>(
        &mut self,
        frame: &Frame,
        time: Duration,
        judge: impl FnMut(&Frame) -> Option<T>,
    ) -> Result<Option<T>, Failure> {
        self.drop_received()?;
        self.send(frame)?;
        self.wait_for(time, judge)
    }

    /// Drops the frames that have been received already: an answer comes after its request.
    fn drop_received(&mut self) -> Result<(), Failure> {
        let now = self.now();
        while let Some((at, _)) = self.receive(now)? {
            if at > now {
                break;
            }
        }
        Ok(())
    }
}
