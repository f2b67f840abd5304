//! The status of the connection, and the newest frames, for the tabs.

use super::{Live, State, Worker};
use crate::scan::kbits;
use crate::serve::events::Kind;
use crate::serve::line;
use adapter::Adapter;
use plumbline::time::{self, millis};
use serde_json::{Value, json};
use std::time::Instant;

/// The pause between two checks of the errors of the adapter, in the time of the bus.
const ERRORS: time::Duration = millis(1000);

/// The status that was reported last.
pub(super) struct Reported {
    pub(super) at: Instant,
    pub(super) frames: u64,
    pub(super) errors_at: Option<time::Instant>,
    pub(super) errors: Option<u64>,
    /// The adapter tells its errors.
    pub(super) tells_errors: bool,
    pub(super) was_silent: bool,
    /// The transmit list that was published last.
    pub(super) transmission: Value,
}

impl Reported {
    pub(super) fn new() -> Self {
        Self {
            at: Instant::now(),
            frames: 0,
            errors_at: None,
            errors: None,
            tells_errors: true,
            was_silent: false,
            transmission: Value::Null,
        }
    }
}

impl Worker {
    /// Publishes the status and the newest frames.
    pub(super) fn report(&mut self) {
        let elapsed = self.status.at.elapsed().as_secs_f64();
        self.status.at = Instant::now();
        let (mut received, mut sent, mut frames) = (0, 0, None);
        if let Some((_, lease)) = &mut self.port {
            (received, sent, frames) = lease.with_tap(|tap| (tap.received, tap.sent, tap.take()));
            let is_open = !matches!(self.state, State::Closed);
            let now = lease.now();
            let last = self.status.errors_at;
            let is_due = last.is_none_or(|last| now.ticks() - last.ticks() >= ERRORS.ticks());
            if is_open && self.status.tells_errors && is_due {
                self.status.errors_at = Some(now);
                self.status.errors = lease.errors();
                self.status.tells_errors = self.status.errors.is_some();
            }
        }
        let unread = Some(self.unread()).filter(|unread| unread.count() > 0);
        if let Some(frames) = frames {
            self.hub.publish(Kind::Frames, &frames);
        }
        self.show_transmission();
        let passed = (received + sent).saturating_sub(self.status.frames);
        self.status.frames = received + sent;
        let (state, lost, silent, every) = match &self.state {
            State::Closed => ("closed", 0, false, None),
            State::Listening(_) => ("listening", 0, false, None),
            State::Open(_) => ("open", 0, false, None),
            State::Active(live) => (
                "active",
                live.lost() + self.others.iter().map(Live::lost).sum::<u64>(),
                live.is_silent(),
                live.sends_every(),
            ),
        };
        let rate = match &self.state {
            State::Listening(link) | State::Open(link) => link.rate(),
            State::Active(live) => live.session.link.rate(),
            State::Closed => None,
        };
        let status = json!({
            "state": state,
            "port": self.port.as_ref().map(|(port, _)| port),
            "rate": rate.map(kbits),
            "received": received,
            "sent": sent,
            "perSecond": (passed as f64 / elapsed.max(0.05)).round(),
            "errors": self.status.errors.filter(|_| self.status.tells_errors),
            "unread": unread.map(|unread| json!({"lines": unread.count(), "first": unread.first()})),
            "samples": self.samples,
            "sendsEvery": every.map(|every| every.ticks() as f64 / 1000.0),
            "lost": lost,
            "silent": silent,
            "unsaved": self.unsaved(),
            "busy": self.busy,
            "error": self.error,
            "line": (!self.selection.is_empty()).then(|| line::shown(&self.selection)),
        });
        self.hub.publish(Kind::Status, &status);
    }
}
