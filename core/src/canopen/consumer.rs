//! The heartbeat consumer (1016h; CiA 301, 7.2.8.2.2.3 and 7.5.2.19).
//!
//! ```text
//!  entry      bits 31..24   23..16        15..0
//!       +-----------------+-------------+-----------+
//!       | 0               | node-ID     | time, ms  |
//!       +-----------------+-------------+-----------+
//! ```
//!
//! The monitoring of a node begins with its first heartbeat. A boot-up message is not a heartbeat: it neither starts nor restarts the
//! consumer time. When the consumer time elapses without a heartbeat, the fault begins, and the error behaviour (1029h:01) follows. The
//! next heartbeat ends the fault.

use super::Abort;
use super::cob_id;
use super::feature::Absent;
use super::lookup::find_row;
use super::product::Product;
use super::protocol::{Canopen, ContextOf, Services};
use super::row::Row;
use crate::can::{CanId, Frame};
use crate::time::{Deadline, Instant, millis};

/// The object with the entries.
pub(super) const INDEX: u16 = 0x1016;

/// The nodes whose heartbeat a product monitors.
pub trait Consumers: Send + 'static {
    /// The number of entries in 1016h.
    const COUNT: usize;
    /// No entry is in use: no node is monitored.
    const INITIAL: Self;

    /// All entries of 1016h, in the order of their sub-indices.
    fn all(&self) -> &[Consumer];
    /// The entries, to change them.
    fn all_mut(&mut self) -> &mut [Consumer];
}

/// The heartbeats of up to `N` nodes.
#[derive(Clone, Debug)]
pub struct Heartbeats<const N: usize>([Consumer; N]);

impl<const N: usize> Consumers for Heartbeats<N> {
    const COUNT: usize = N;
    const INITIAL: Self = Self([const { Consumer::OFF }; N]);

    fn all(&self) -> &[Consumer] {
        &self.0
    }

    fn all_mut(&mut self) -> &mut [Consumer] {
        &mut self.0
    }
}

impl Consumers for Absent {
    const COUNT: usize = 0;
    const INITIAL: Self = Self;

    fn all(&self) -> &[Consumer] {
        &[]
    }

    fn all_mut(&mut self) -> &mut [Consumer] {
        &mut []
    }
}

/// The monitoring of one node.
#[derive(Clone, Debug)]
pub struct Consumer {
    /// The node-ID; 0: the entry is not used.
    node_id: u8,
    time: u16,
    /// The end of the consumer time; unset before the first heartbeat.
    until: Deadline,
    /// The consumer time has elapsed without a heartbeat.
    failed: bool,
}

impl Consumer {
    /// An entry that monitors no node.
    const OFF: Self = Self {
        node_id: 0,
        time: 0,
        until: Deadline::NEVER,
        failed: false,
    };

    /// Takes an entry and waits for the first heartbeat.
    fn configure(&mut self, entry: u32) {
        *self = Self::OFF;
        if let Some((node_id, time)) = used(entry) {
            self.node_id = node_id;
            self.time = time;
        }
    }

    /// Handles a heartbeat of a node.
    fn hear(&mut self, now: Instant, node_id: u8) {
        if self.node_id == node_id {
            self.until = Deadline::after(now, millis(self.time.into()));
            self.failed = false;
        }
    }

    /// Returns true once when the consumer time has elapsed without a heartbeat.
    fn poll(&mut self, now: Instant) -> bool {
        let over = self.until.is_reached(now);
        if over {
            self.until = Deadline::NEVER;
            self.failed = true;
        }
        over
    }
}

/// The node-ID and the time of an entry that is used.
const fn used(entry: u32) -> Option<(u8, u16)> {
    let (node_id, time) = ((entry >> 16) as u8, entry as u16);
    if node_id >= 1 && node_id <= 127 && time > 0 {
        return Some((node_id, time));
    }
    None
}

impl<P: Product> Services<P> {
    const HEARS: bool = P::Consumers::COUNT > 0;

    /// Takes the entries and waits for the first heartbeat of each node. Returns true if the identifiers may have changed.
    pub(super) fn configure_consumers(&mut self, cx: &mut ContextOf<P>) -> bool {
        for (sub, consumer) in (1..).zip(self.consumers.all_mut()) {
            let entry = find_row::<P>(INDEX, sub).map(|row| cx.parameters.get(row.id()));
            consumer.configure(entry.unwrap_or(0));
        }
        if Self::HEARS {
            self.report_guarding(cx);
        }
        Self::HEARS
    }

    /// Checks a write of an entry: two entries must not have the same node-ID.
    pub(super) fn check_consumer(
        &self,
        cx: &ContextOf<P>,
        row: &Row,
        value: u32,
    ) -> Result<(), Abort> {
        if !Self::HEARS || row.index() != INDEX {
            return Ok(());
        }
        let node_of = |entry| used(entry).map(|(node_id, _)| node_id);
        let Some(node_id) = node_of(value) else {
            return Ok(());
        };
        for sub in (1..).take(P::Consumers::COUNT) {
            if sub != row.address().sub
                && let Some(other) = find_row::<P>(INDEX, sub)
                && node_of(cx.parameters.get(other.id())) == Some(node_id)
            {
                return Err(Abort::Incompatible);
            }
        }
        Ok(())
    }

    /// Handles a frame that can be a heartbeat. Returns false if it is another frame.
    pub(super) fn hear(&mut self, cx: &mut ContextOf<P>, now: Instant, frame: &Frame) -> bool {
        if !Self::HEARS {
            return false;
        }
        let id = |node_id: u8| CanId::standard(cob_id::ERROR_CONTROL + u16::from(node_id));
        let heard = self
            .consumers
            .all()
            .iter()
            .find(|consumer| consumer.node_id != 0 && id(consumer.node_id) == frame.can_id());
        let Some(node_id) = heard.map(|consumer| consumer.node_id) else {
            return false;
        };
        let is_boot_up = frame.bytes().first().is_none_or(|state| *state == 0);
        if frame.is_remote() || is_boot_up {
            return true;
        }
        let had_failed = self.lost();
        for consumer in self.consumers.all_mut() {
            consumer.hear(now, node_id);
        }
        if had_failed {
            self.report_guarding(cx);
        }
        cx.shell.wake_up();
        true
    }

    /// Whether the heartbeat of a node is lost.
    pub(super) fn lost(&self) -> bool {
        self.consumers.all().iter().any(|consumer| consumer.failed)
    }

    /// The identifiers of the monitored nodes.
    pub(super) fn heard_ids(&self) -> impl Iterator<Item = CanId> {
        let used = self.consumers.all().iter().filter(|one| one.node_id != 0);
        used.map(|one| CanId::standard(cob_id::ERROR_CONTROL + u16::from(one.node_id)))
    }
}

impl<P: Product> Canopen<P> {
    /// Handles the times of the monitored nodes.
    pub(super) fn tick_consumers(&mut self, cx: &mut ContextOf<P>, now: Instant) {
        let mut over = false;
        for consumer in self.services.consumers.all_mut() {
            over |= consumer.poll(now);
        }
        if over {
            self.lose_master(cx, now);
        }
        for consumer in self.services.consumers.all() {
            self.services.earliest.consider(consumer.until);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn entry_without_time_or_with_another_node_id_is_not_used() {
        for (entry, expected) in [
            (0, None),
            (0x0001_0000, None),
            (0x0000_0064, None),
            (0x0080_0064, None),
            (0x0001_0001, Some((1, 1))),
            (0x007F_FFFF, Some((127, 0xFFFF))),
        ] {
            assert_eq!(used(entry), expected, "{entry:08X}");
        }
    }
}
