//! An adapter: what a PLC, a tester or an slcan client sends and receives with.

use plumbline::can::{BitRate, Frame};
use plumbline::time::Instant;
use std::collections::VecDeque;

/// Received frames that an adapter keeps; after that the oldest are lost.
const RECEIVED_MAX: usize = 1_000_000;

/// One adapter on the bus.
#[derive(Debug, Default)]
pub(super) struct Adapter {
    open: Option<Opened>,
    queue: VecDeque<Frame>,
    sending: bool,
    received: VecDeque<(Instant, Frame)>,
    /// It has just sent a frame: a device goes first now, before this and every other adapter.
    pub(super) gives_way: bool,
}

#[derive(Clone, Copy, Debug)]
struct Opened {
    /// None: whatever rate the bus has.
    rate: Option<BitRate>,
    listen_only: bool,
    since: Instant,
}

impl Adapter {
    pub(super) fn open(&mut self, now: Instant, rate: Option<BitRate>, listen_only: bool) {
        self.close();
        self.gives_way = false;
        self.open = Some(Opened {
            rate,
            listen_only,
            since: now,
        });
    }

    pub(super) fn close(&mut self) {
        self.queue.clear();
        self.sending = false;
        self.open = None;
    }

    /// The bit rate at which it may send: Some(None) for that of the bus; None when it is closed or only listens.
    pub(super) fn sends_at(&self) -> Option<Option<BitRate>> {
        self.open
            .filter(|open| !open.listen_only)
            .map(|open| open.rate)
    }

    /// Whether it hears a frame that started at `start`; `rate` is the rate that counts, None when none does.
    pub(super) fn hears(&self, rate: Option<BitRate>, start: Instant) -> bool {
        self.open.is_some_and(|open| {
            open.since <= start && (rate.is_none() || open.rate.is_none() || open.rate == rate)
        })
    }

    /// Whether it would acknowledge that frame.
    pub(super) fn acknowledges(&self, rate: Option<BitRate>, start: Instant) -> bool {
        self.sends_at().is_some() && self.hears(rate, start)
    }

    pub(super) fn push(&mut self, frame: Frame) {
        self.queue.push_back(frame);
    }

    pub(super) fn queued(&self) -> usize {
        self.queue.len()
    }

    /// The frame that it sends next.
    pub(super) fn pending(&self) -> Option<Frame> {
        self.queue.front().copied()
    }

    /// The frame at the head of the queue has won arbitration.
    pub(super) fn start(&mut self) {
        self.sending = true;
    }

    /// The frame that was sent has ended well.
    pub(super) fn transmitted(&mut self) {
        if core::mem::take(&mut self.sending) {
            self.queue.pop_front();
        }
        self.gives_way = true;
    }

    pub(super) fn receive(&mut self, at: Instant, frame: Frame) {
        if self.received.len() == RECEIVED_MAX {
            self.received.pop_front();
        }
        self.received.push_back((at, frame));
    }

    pub(super) fn take_received(&mut self) -> Vec<(Instant, Frame)> {
        self.received.drain(..).collect()
    }
}
