//! The transmit queue: first in, first out; a reply is never lost, a cyclic value is replaced by a newer one.

use crate::can::Frame;
use embedded_can::Id;
use heapless::Deque;

/// Places in the queue.
const CAPACITY: usize = 16;
/// Places that only replies already begun (and cyclic values) may take: see [`TransmitQueue::has_room`].
const RESERVE: usize = 7;

/// What becomes of a frame that waits.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Kind {
    /// It is sent.
    Reply,
    /// It is sent, unless a newer one takes its place.
    Cyclic,
    /// It is not sent.
    Withdrawn,
}

#[derive(Clone, Copy, Debug)]
struct Entry {
    frame: Frame,
    kind: Kind,
}

/// Frames waiting for a mailbox.
#[derive(Debug, Default)]
pub struct TransmitQueue {
    entries: Deque<Entry, CAPACITY>,
    /// How many of them are cyclic values: mostly none, and nothing has to be searched.
    cyclic: u8,
}

impl TransmitQueue {
    /// True while a further request may be taken in: its answer (at most two frames), an event and four cyclic values will fit.
    pub fn has_room(&self) -> bool {
        self.entries.len() <= CAPACITY - RESERVE
    }

    /// True when nothing waits.
    pub fn is_empty(&self) -> bool {
        self.entries.is_empty()
    }

    /// Appends a reply. The caller has seen [`has_room`](Self::has_room) before it took the request in.
    pub fn reply(&mut self, frame: Frame) {
        self.push(frame, Kind::Reply);
    }

    /// Appends a cyclic value, or puts it in the place of the one with the same identifier that still waits.
    pub fn cyclic(&mut self, frame: Frame) {
        if self.cyclic > 0
            && let Some(stale) = self.waiting(frame.id())
        {
            stale.frame = frame;
            return;
        }
        self.cyclic += 1;
        self.push(frame, Kind::Cyclic);
    }

    /// The cyclic value with this identifier.
    #[inline(never)] // seldom
    fn waiting(&mut self, id: Id) -> Option<&mut Entry> {
        let same = |waiting: &&mut Entry| waiting.kind == Kind::Cyclic && waiting.frame.id() == id;
        self.entries.iter_mut().find(same)
    }

    fn push(&mut self, frame: Frame, kind: Kind) {
        // Cannot fail, thanks to the reserve; a frame too many would be dropped rather than panic.
        let _ = self.entries.push_back(Entry { frame, kind });
    }

    /// Drops the cyclic value with this identifier.
    pub fn withdraw(&mut self, id: Id) {
        if let Some(entry) = self.waiting(id) {
            entry.kind = Kind::Withdrawn;
            self.cyclic -= 1;
        }
    }

    /// Drops everything.
    pub fn clear(&mut self) {
        self.entries.clear();
        self.cyclic = 0;
    }

    /// The next frame to send.
    pub fn pop(&mut self) -> Option<Frame> {
        loop {
            let Entry { frame, kind } = self.entries.pop_front()?;
            match kind {
                Kind::Withdrawn => continue,
                Kind::Cyclic => self.cyclic -= 1,
                Kind::Reply => {}
            }
            return Some(frame);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::can::standard;

    fn frame(byte: u8) -> Frame {
        Frame::data(standard(0x301), &[byte]).unwrap()
    }

    #[test]
    fn a_newer_cyclic_value_takes_the_place_of_the_stale_one() {
        let mut queue = TransmitQueue::default();
        queue.reply(frame(1));
        queue.cyclic(frame(2));
        queue.reply(frame(3));
        queue.cyclic(frame(4));
        let order: std::vec::Vec<_> = std::iter::from_fn(|| queue.pop()).collect();
        assert_eq!(order, [frame(1), frame(4), frame(3)]);
        assert!(queue.is_empty());
    }

    #[test]
    fn cyclic_values_of_different_identifiers_do_not_replace_each_other() {
        let other = |byte| Frame::data(standard(0x302), &[byte]).unwrap();
        let mut queue = TransmitQueue::default();
        queue.cyclic(frame(1));
        queue.cyclic(other(2));
        queue.cyclic(frame(3));
        queue.reply(frame(4));
        queue.withdraw(standard(0x302));
        let order: std::vec::Vec<_> = std::iter::from_fn(|| queue.pop()).collect();
        assert_eq!(order, [frame(3), frame(4)]);
    }

    #[test]
    fn while_there_is_room_two_replies_an_event_and_four_cyclic_values_fit() {
        let mut queue = TransmitQueue::default();
        let mut sent = 0;
        while queue.has_room() {
            queue.reply(frame(sent));
            queue.reply(frame(sent + 1));
            sent += 2;
        }
        queue.reply(frame(sent));
        let values = [1, 2, 3, 4].map(|id| Frame::data(standard(id), &[]).unwrap());
        for value in values {
            queue.cyclic(value);
        }
        let order: std::vec::Vec<_> = std::iter::from_fn(|| queue.pop()).collect();
        let expected: std::vec::Vec<_> = (0..=sent).map(frame).chain(values).collect();
        assert_eq!(order, expected);
    }
}
