//! The adapter of a client, and the adapters of clients that have left.

use super::passage::Passage;
use crate::slcan::{Port, QueueFull};
use bench::{AdapterId, Bus};
use plumbline::can::{BitRate, Frame};
use plumbline::time::{Duration, Instant, after, millis, reached};

/// Frames of one client that may wait for the bus; more are refused with BEL.
pub(super) const QUEUE_MAX: usize = 50_000;

/// How long the frames of a client that has closed its channel or disconnected may still wait for the bus.
const LINGER: Duration = millis(1000);

/// How long its adapter then acknowledges the replies.
const REPLIES: Duration = millis(50);

/// Adapters of clients that have closed their channel or disconnected. A program that sends a command and ends at once expects the
/// command to be sent. Without an acknowledge of the reply, the sensor would become error passive and send it to the next client.
#[derive(Debug, Default)]
pub(super) struct Leaving(Vec<Left>);

#[derive(Debug)]
struct Left {
    adapter: AdapterId,
    /// Its frames wait no longer than this.
    limit: Instant,
    /// It acknowledges until this time. None: it has frames to send.
    until: Option<Instant>,
}

impl Leaving {
    pub(super) fn add(&mut self, bus: &mut Bus, adapter: AdapterId) {
        if !bus.takes_part(adapter) {
            bus.remove(adapter);
            return;
        }
        self.0.push(Left {
            adapter,
            limit: after(bus.now(), LINGER),
            until: None,
        });
        self.remove_done(bus);
    }

    /// True when no such adapter is on the bus.
    pub(super) fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    pub(super) fn remove_done(&mut self, bus: &mut Bus) {
        let now = bus.now();
        self.0.retain_mut(|left| {
            let waits = bus.queued(left.adapter) > 0;
            if !waits && left.until.is_none() {
                left.until = Some(after(now, REPLIES));
            }
            let stays = !reached(now, left.until.unwrap_or(left.limit));
            if !stays {
                bus.remove(left.adapter);
            }
            stays
        });
    }
}

/// The adapter of a client on the bus.
pub(super) struct AdapterPort<'a> {
    pub(super) bus: &'a mut Bus,
    pub(super) adapter: &'a mut AdapterId,
    pub(super) leaving: &'a mut Leaving,
    /// The faults of the frames to the bus.
    pub(super) to_bus: &'a mut Passage,
}

impl Port for AdapterPort<'_> {
    fn open(&mut self, rate: Option<BitRate>, listen_only: bool) {
        self.bus.open(*self.adapter, rate, listen_only);
    }

    fn close(&mut self) {
        self.to_bus.clear();
        let next = self.bus.adapter();
        self.leaving
            .add(self.bus, std::mem::replace(self.adapter, next));
    }

    fn send(&mut self, frame: Frame) -> Result<(), QueueFull> {
        if self.bus.queued(*self.adapter) + self.to_bus.late() >= QUEUE_MAX {
            return Err(QueueFull);
        }
        if let Some(frame) = self.to_bus.pass(self.bus.now(), frame) {
            self.bus.send(*self.adapter, frame);
        }
        Ok(())
    }
}
