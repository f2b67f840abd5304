//! Sends frames at their times, not faster than the bus can carry them.

use super::log::rate_of;
use crate::counted::{self, Errors};
use crate::error::Error;
use crate::link::Link;
use crate::note::{At, Note};
use crate::ops::transmit::{Frames, carried};
use crate::output::Terminal;
use adapter::{Adapter, Mode};
use plumbline::can::{BitRate, Frame};
use plumbline::time::{Duration, Instant, after, millis};
use serde_json::json;

/// The longest wait without a check for Ctrl-C.
const SLICE: Duration = millis(50);

/// A bus on which frames are sent.
pub(super) struct Sender {
    link: Link,
    /// No frame is sent from then on.
    end: Option<Instant>,
    /// When the bus has carried the last frame.
    free: Instant,
    count: u64,
}

impl Sender {
    /// Opens the adapter. Without a bit rate it has that of the traffic.
    ///
    /// # Errors
    /// There is no traffic, or the adapter fails.
    pub(super) fn open(
        adapter: Box<dyn Adapter>,
        rate: Option<BitRate>,
        seconds: Option<Duration>,
        terminal: &mut Terminal,
    ) -> Result<Self, Error> {
        let mut link = Link::new(adapter, &terminal.stopped);
        let rate = rate_of(&mut link, rate, terminal)?;
        link.open(rate, Mode::Active)?;
        let now = link.now();
        Ok(Self {
            link,
            end: seconds.map(|seconds| after(now, seconds)),
            free: now,
            count: 0,
        })
    }

    /// The present time of the adapter.
    pub(super) fn now(&self) -> Instant {
        self.link.now()
    }

    /// Sends all frames at their times, until the user or the time ends it.
    ///
    /// # Errors
    /// The adapter fails.
    pub(super) fn send_all(&mut self, frames: &mut dyn Frames) -> Result<(), Error> {
        while let Some((at, frame)) = frames.next() {
            if !self.send(at, &frame)? {
                break;
            }
            frames.sent(self.now());
        }
        Ok(())
    }

    /// Sends a frame at this time, or as soon as the bus is free. False: the command ends before.
    ///
    /// # Errors
    /// The adapter fails.
    fn send(&mut self, at: Instant, frame: &Frame) -> Result<bool, Error> {
        let at = at.max(self.free);
        loop {
            if self.link.is_stopped() || self.end.is_some_and(|end| self.link.now() >= end) {
                return Ok(false);
            }
            // It receives at least once, because an adapter tells a refused frame when it receives.
            let until = self.end.map_or(at, |end| at.min(end));
            let slice = after(self.link.now(), SLICE);
            self.link.receive(until.min(slice))?;
            let now = self.link.now();
            if now >= at && self.end.is_none_or(|end| now < end) {
                break;
            }
        }
        self.link.send(frame)?;
        self.count += 1;
        self.free = carried(frame, self.link.rate(), self.link.now().max(at));
        Ok(true)
    }

    /// Closes the adapter, and tells how many frames were sent, also if the adapter has failed.
    ///
    /// # Errors
    /// The failure of `result`, or the output is closed.
    pub(super) fn finish(
        mut self,
        result: Result<(), Error>,
        terminal: &mut Terminal,
    ) -> Result<(), Error> {
        let told = Note::Sent(counted::Frames(self.count), At::from(self.link.rate()));
        if result.is_err() {
            terminal.note(&told);
            return result;
        }
        self.link.leave();
        let errors = self.link.adapter().errors();
        self.link.close();
        if let Some(errors @ 1..) = errors {
            terminal.note(&Note::BusErrors(Errors(errors)));
        }
        terminal.line(told.to_string())?;
        terminal.document(&json!({"sent": self.count}))
    }
}
