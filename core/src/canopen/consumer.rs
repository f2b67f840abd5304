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

use super::feature::Absent;
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
    pub(super) node_id: u8,
    time: u16,
    /// The end of the consumer time; unset before the first heartbeat.
    pub(super) until: Deadline,
    /// The consumer time has elapsed without a heartbeat.
    pub(super) failed: bool,
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
    pub(super) fn configure(&mut self, entry: u32) {
        *self = Self::OFF;
        if let Some((node_id, time)) = used(entry) {
            self.node_id = node_id;
            self.time = time;
        }
    }

    /// Handles a heartbeat of a node.
    pub(super) fn hear(&mut self, now: Instant, node_id: u8) {
        if self.node_id == node_id {
            self.until = Deadline::after(now, millis(self.time.into()));
            self.failed = false;
        }
    }

    /// Returns true once when the consumer time has elapsed without a heartbeat.
    pub(super) fn poll(&mut self, now: Instant) -> bool {
        let over = self.until.is_reached(now);
        if over {
            self.until = Deadline::NEVER;
            self.failed = true;
        }
        over
    }
}

/// The node-ID and the time of an entry that is used.
pub(super) const fn used(entry: u32) -> Option<(u8, u16)> {
    let (node_id, time) = ((entry >> 16) as u8, entry as u16);
    if node_id >= 1 && node_id <= 127 && time > 0 {
        return Some((node_id, time));
    }
    None
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
