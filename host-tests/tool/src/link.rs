//! The link to the bus: an adapter with a count of the frames that were sent; one request, one answer.

use crate::error::{Error, RequestError};
use crate::master::Target;
use crate::master::fsc::boot_up::BootUps;
use crate::master::j1939::groups::own::Own;
use adapter::{Adapter, AdapterError, Mode};
use plumbline::can::{BitRate, Frame};
use plumbline::time::{Duration, Instant, after, millis};
use std::rc::Rc;

/// The longest time for received frames to be dropped, if more come all the time.
const DROPPING: Duration = millis(10);

/// The time in which a frame leaves the adapter, in addition to its time on the bus.
const LEAVING: Duration = millis(20);

/// How long frames that are here already are looked at after the time for an answer, if more come all the time.
const LOOKING: Duration = millis(100);

/// An adapter, and what was sent with it.
pub struct Link {
    adapter: Box<dyn Adapter>,
    rate: Option<BitRate>,
    /// The frames that were sent at each rate, in the order of the rates.
    sent: Vec<(Option<BitRate>, u64)>,
    /// The boot-up messages of all sensors.
    booted: BootUps,
    /// True when the user wants to stop.
    stopped: Rc<dyn Fn() -> bool>,
    /// The last requests are sent though the user wants to stop.
    is_ending: bool,
    /// When the last frame was sent, if nothing shows that it has left the adapter.
    unanswered: Option<Instant>,
    /// The frames that were sent since the adapter was opened.
    since_open: u64,
    /// The adapter took part in the bus while the tool listened.
    takes_part: bool,
    /// The J1939 address of the tool, from the first frame on that must have one.
    pub(crate) own: Option<Own>,
}

impl Link {
    /// A link over an adapter, which is not open yet. No request is sent as soon as `stopped` returns true.
    pub fn new(adapter: Box<dyn Adapter>, stopped: &Rc<dyn Fn() -> bool>) -> Self {
        Self {
            adapter,
            rate: None,
            sent: Vec::new(),
            booted: BootUps::default(),
            stopped: stopped.clone(),
            is_ending: false,
            unanswered: None,
            since_open: 0,
            takes_part: false,
            own: None,
        }
    }

    /// The requests that follow end the session: they are sent though the user wants to stop.
    pub fn end(&mut self) {
        self.set_ending(true);
    }

    /// Whether requests are sent though the user wants to stop. Returns the old setting.
    pub fn set_ending(&mut self, is_ending: bool) -> bool {
        std::mem::replace(&mut self.is_ending, is_ending)
    }

    /// Whether the user wants to stop.
    pub fn is_stopped(&self) -> bool {
        (self.stopped)()
    }

    /// The adapter of the link.
    pub fn adapter(&mut self) -> &mut dyn Adapter {
        self.adapter.as_mut()
    }

    /// The bit rate at which it was opened; None: the rate of the interface, which does not report its rate.
    pub fn rate(&self) -> Option<BitRate> {
        self.rate
    }

    /// Opens the adapter; see [`Adapter::open`].
    ///
    /// # Errors
    /// The adapter fails.
    pub fn open(&mut self, rate: Option<BitRate>, mode: Mode) -> Result<(), Error> {
        self.leave();
        self.own = None;
        self.rate = rate;
        self.since_open = 0;
        self.adapter.open(rate, mode)?;
        self.rate = rate.or_else(|| self.adapter.rate());
        Ok(())
    }

    /// Remembers that the adapter takes part in the bus while the tool listens. True the first time.
    pub fn take_part(&mut self) -> bool {
        !std::mem::replace(&mut self.takes_part, true)
    }

    /// Whether the adapter took part in the bus while the tool listened.
    pub fn takes_part(&self) -> bool {
        self.takes_part
    }

    /// Opens an adapter again whose queue is full. An adapter keeps the frames that nobody acknowledges, some adapters only three; it drops
    /// them when it is closed. The first frame after it was opened must not be refused.
    fn go_on(&mut self, failure: Error) -> Result<(), Error> {
        use AdapterError::{FrameRefused, QueueFull};
        let is_refused = matches!(failure, Error::Adapter(FrameRefused(_) | QueueFull));
        if !is_refused || self.since_open <= 1 {
            return Err(failure);
        }
        self.adapter.close();
        self.since_open = 0;
        Ok(self.adapter.open(self.rate, Mode::Active)?)
    }

    /// Opens the adapter for questions at one of several rates. False: it does not have this one.
    ///
    /// # Errors
    /// The adapter fails. With a single rate also: the adapter does not have this rate.
    pub fn try_rate(
        &mut self,
        rate: Option<BitRate>,
        rates: &[Option<BitRate>],
    ) -> Result<bool, Error> {
        match self.open(rate, Mode::Active) {
            Err(failure) if failure.is_rate_refused() && rates.len() > 1 => Ok(false),
            opened => opened.map(|()| true),
        }
    }

    /// Closes the adapter. It drops frames that wait, so the last one without an answer is given the time to leave it.
    pub fn close(&mut self) {
        self.leave();
        self.adapter.close();
    }

    /// Waits until the last frame has left the adapter.
    pub fn leave(&mut self) {
        self.leave_within(LEAVING);
    }

    /// Waits until the last frame has left the adapter: this time in addition to its time on the bus. The call does not wait for an adapter
    /// that has failed.
    pub fn leave_within(&mut self, time: Duration) {
        const BITS: u32 = 160;
        let Some(sent) = self.unanswered.take() else {
            return;
        };
        let bits = self.rate.map_or(10_000, BitRate::bits_per_second);
        let until = after(after(sent, time), millis(BITS * 1000 / bits));
        while self.now() < until {
            if self.receive(until).is_err() {
                break;
            }
        }
    }

    /// Sends a frame and counts it.
    ///
    /// # Errors
    /// The adapter fails.
    pub fn send(&mut self, frame: &Frame) -> Result<(), Error> {
        self.since_open += 1;
        self.adapter.send(frame)?;
        self.unanswered = Some(self.now());
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

    /// The present time of the adapter.
    pub fn now(&self) -> Instant {
        self.adapter.now()
    }

    /// The next frame until then.
    ///
    /// # Errors
    /// The adapter fails.
    pub fn receive(&mut self, until: Instant) -> Result<Option<(Instant, Frame)>, Error> {
        let received = self.adapter.receive(until)?;
        if let Some((at, frame)) = &received {
            self.booted.take(*at, frame);
            // A J1939 node tells its address to every node that asks, and defends it.
            if let Some(claim) = self.own.as_mut().and_then(|own| own.hear(*at, frame)) {
                self.send(&claim)?;
            }
        }
        Ok(received)
    }

    /// The GEMAC sensors that have sent their two boot-up messages since the last call. A sensor that detects the bit rate sends them after
    /// a question to any address. The call waits for more frames that look like them: a third frame comes from another device.
    ///
    /// # Errors
    /// The adapter fails.
    pub fn take_booted(&mut self) -> Result<Vec<Target>, Error> {
        while let Some(settled) = self.booted.settled()
            && self.now() < settled
        {
            self.receive(settled)?;
        }
        let now = self.now();
        let booted = self.booted.take_booted(now).into_iter();
        Ok(booted.map(Target::Fsc).collect())
    }

    /// Waits this time for the first frame that `judge` takes; others are ignored. If the computer was late, the answer can be among the
    /// frames that have already arrived: they are checked too.
    ///
    /// # Errors
    /// The adapter fails.
    pub fn wait_for<T>(
        &mut self,
        time: Duration,
        judge: impl FnMut(&Frame) -> Option<T>,
    ) -> Result<Option<T>, Error> {
        let answer = self.wait_for_at(time, judge)?;
        Ok(answer.map(|(_, answer)| answer))
    }

    /// The same with the time of its reception.
    ///
    /// # Errors
    /// The adapter fails.
    pub fn wait_for_at<T>(
        &mut self,
        time: Duration,
        mut judge: impl FnMut(&Frame) -> Option<T>,
    ) -> Result<Option<(Instant, T)>, Error> {
        let until = after(self.now(), time);
        let mut end = None;
        while let Some((at, frame)) = self.receive(until)? {
            if let Some(answer) = judge(&frame) {
                return Ok(Some((at, answer)));
            }
            let now = self.now();
            if now >= until && now >= *end.get_or_insert(after(now, LOOKING)) {
                break;
            }
        }
        Ok(None)
    }

    /// Sends a frame, and waits this time for the first frame that `judge` takes.
    ///
    /// # Errors
    /// The adapter fails, or the user wants to stop.
    pub fn ask<T>(
        &mut self,
        frame: &Frame,
        time: Duration,
        mut judge: impl FnMut(&Frame) -> Option<T>,
    ) -> Result<Option<T>, Error> {
        if !self.is_ending && (self.stopped)() {
            return Err(stopped());
        }
        if let Err(failure) = self.drop_received() {
            self.go_on(failure)?;
        }
        let sent = self.send(frame);
        let answer = match sent.and_then(|()| self.wait_for(time, &mut judge)) {
            Err(failure) => {
                self.go_on(failure)?;
                self.send(frame)?;
                self.wait_for(time, judge)?
            }
            Ok(answer) => answer,
        };
        if answer.is_some() {
            self.unanswered = None;
        }
        Ok(answer)
    }

    /// Drops the frames that have already been received, because an answer comes after its request. Otherwise the tool could accept a late
    /// answer to an earlier request as the answer to this request.
    fn drop_received(&mut self) -> Result<(), Error> {
        let start = self.now();
        // The frames of one read have the same time. So all frames that had arrived are dropped, even if the computer is slow.
        while let Some((at, _)) = self.receive(start)? {
            if at >= after(start, DROPPING) {
                break;
            }
        }
        Ok(())
    }
}

/// The user has pressed Ctrl-C.
pub fn stopped() -> Error {
    RequestError::Stopped.into()
}

#[cfg(test)]
pub(crate) mod tests;
