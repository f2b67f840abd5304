//! The messages that are on their way to the broker.

use std::collections::{BTreeSet, HashMap, VecDeque};
use std::time::Instant;

/// A message.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Entry {
    /// A record with this number.
    Record(u64),
    /// A document that the broker keeps.
    Kept,
}

/// The messages on their way.
#[derive(Default)]
pub struct Window {
    /// When the broker has accepted the connection.
    pub connected: Option<Instant>,
    /// Those that have no packet identifier yet, in their order.
    submitted: VecDeque<Entry>,
    /// By packet identifier.
    sent: HashMap<u16, Entry>,
    /// The numbers of the records, and the highest one so far.
    records: BTreeSet<u64>,
    last: u64,
}

impl Window {
    /// The number of messages that are not acknowledged.
    pub fn under_way(&self) -> usize {
        self.submitted.len() + self.sent.len()
    }

    /// A message is handed to the client.
    pub fn submit(&mut self, entry: Entry) {
        self.submitted.push_back(entry);
        if let Entry::Record(number) = entry {
            self.records.insert(number);
            self.last = self.last.max(number);
        }
    }

    /// The next message has left with this packet identifier.
    pub fn sent(&mut self, packet: u16) {
        if let Some(entry) = self.submitted.pop_front() {
            self.sent.insert(packet, entry);
        }
    }

    /// The broker has acknowledged a message. All records before the result are acknowledged; None: it was none.
    pub fn acknowledged(&mut self, packet: u16) -> Option<u64> {
        let Some(Entry::Record(number)) = self.sent.remove(&packet) else {
            return None;
        };
        self.records.remove(&number);
        Some(self.records.first().copied().unwrap_or(self.last + 1))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn records_are_acknowledged_up_to_the_first_that_is_not() {
        let mut window = Window::default();
        for entry in [
            Entry::Record(5),
            Entry::Kept,
            Entry::Record(6),
            Entry::Record(9),
        ] {
            window.submit(entry);
        }
        for packet in 1..=4 {
            window.sent(packet);
        }
        let acknowledged = [3, 2, 1, 4].map(|packet| window.acknowledged(packet));
        assert_eq!(acknowledged, [Some(5), None, Some(9), Some(10)]);
        assert_eq!((window.under_way(), window.acknowledged(1)), (0, None));
    }
}
