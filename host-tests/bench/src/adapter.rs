//! An adapter: the interface through which a PLC, a tester or an slcan client sends and receives.

use can_wire::protocol::{BitTiming, Event, Picoseconds, Protocol};
use plumbline::can::{BitRate, Frame};
use std::collections::VecDeque;

/// Received frames that an adapter keeps; then it drops the oldest.
const RECEIVED_MAX: usize = 1_000_000;

/// One adapter on the bus.
#[derive(Debug, Default)]
pub(super) struct Adapter {
    pub(super) protocol: Protocol,
    open: Option<Opened>,
    queue: VecDeque<Frame>,
    /// Received frames with the time of their end.
    received: VecDeque<(Picoseconds, Frame)>,
}

#[derive(Clone, Copy, Debug)]
struct Opened {
    /// None: the rate of the bus.
    rate: Option<BitRate>,
    listen_only: bool,
}

impl Adapter {
    pub(super) fn open(&mut self, rate: Option<BitRate>, listen_only: bool) {
        self.close();
        self.open = Some(Opened { rate, listen_only });
    }

    /// Closes it; a frame that it is sending is aborted.
    pub(super) fn close(&mut self) {
        self.queue.clear();
        self.open = None;
        self.protocol.reset();
    }

    /// The bit rate that it was opened with; None for that of the bus.
    pub(super) fn own_rate(&self) -> Option<BitRate> {
        self.open?.rate
    }

    /// Takes part at this timing, if it is open.
    pub(super) fn join(&mut self, now: Picoseconds, timing: BitTiming) {
        if let Some(open) = self.open {
            self.protocol.join(now, timing, open.listen_only);
        }
    }

    /// Queues a frame, if it is on the bus and may send.
    pub(super) fn push(&mut self, frame: Frame) {
        let sends = self.open.is_some_and(|open| !open.listen_only);
        if sends && self.protocol.is_on() {
            self.queue.push_back(frame);
        }
    }

    pub(super) fn queued(&self) -> usize {
        self.queue.len()
    }

    /// The frame that it sends next.
    pub(super) fn offered(&self) -> Option<Frame> {
        self.queue.front().copied()
    }

    /// Handles an event of its protocol. An adapter recovers from bus-off without a command.
    pub(super) fn note(&mut self, now: Picoseconds, event: Event) {
        match event {
            Event::Transmitted => {
                self.queue.pop_front();
            }
            Event::Received(frame) => {
                if self.received.len() == RECEIVED_MAX {
                    self.received.pop_front();
                }
                // The frame is valid for a receiver at the last bit but one of EOF (ISO 11898-1).
                let end = self.protocol.bit_start() + self.protocol.timing().bit;
                self.received.push_back((end, frame));
            }
            Event::Error { .. } => self.protocol.recover(now),
            Event::Joined | Event::Started | Event::LostArbitration | Event::Recovered => {}
        }
    }

    /// The end of the last received frame, if it is still to come.
    pub(super) fn receives_until(&self, now: Picoseconds) -> Option<Picoseconds> {
        let (end, _) = self.received.back()?;
        Some(*end).filter(|end| *end > now)
    }

    /// Removes and returns the frames that have ended.
    pub(super) fn take_received(&mut self, now: Picoseconds) -> Vec<(Picoseconds, Frame)> {
        let ended = self.received.partition_point(|(end, _)| *end <= now);
        self.received.drain(..ended).collect()
    }
}
