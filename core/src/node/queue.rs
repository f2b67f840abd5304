//! The transmit queue: first in, first out. A reply is never lost. A newer cyclic value replaces an older one.

use crate::can::{CanId, Frame};

/// The number of frames in a full queue.
const CAPACITY: usize = 16;
/// The maximum number of replies to one request.
const REPLIES: usize = 2;

/// Frames that wait for a mailbox.
#[derive(Debug)]
pub struct TransmitQueue {
    frames: [Frame; CAPACITY],
    /// The place of the oldest frame, modulo the capacity.
    first: u8,
    /// The number of frames that wait.
    length: u8,
    /// The node accepts a request while the queue has at most this many frames.
    limit: u8,
    /// Two bits for each place: the frame is a cyclic value (bits 0 to 15), or it is not sent (bits 16 to 31).
    marks: u32,
}

impl TransmitQueue {
    /// The queue before the first frame: it accepts requests only when it is empty.
    pub const EMPTY: Self = Self {
        frames: [Frame::EMPTY; CAPACITY],
        first: 0,
        length: 0,
        limit: 0,
        marks: 0,
    };

    /// The most frames besides replies that a protocol may have in the queue: cyclic values of different identifiers, and events.
    pub const OTHERS: usize = CAPACITY - 2 * REPLIES;

    /// Keeps room for this number of frames that are not replies, at most [`OTHERS`](Self::OTHERS).
    pub fn reserve(&mut self, others: usize) {
        self.limit = (CAPACITY - REPLIES).saturating_sub(others) as u8;
    }

    /// True while a further request can be accepted: there is room for its replies and for all [others](Self::reserve).
    pub fn has_room(&self) -> bool {
        self.length <= self.limit
    }

    /// True if the queue is empty.
    pub fn is_empty(&self) -> bool {
        self.length == 0
    }

    /// Appends a reply. The caller must check [`has_room`](Self::has_room) before it takes the request.
    pub fn reply(&mut self, frame: Frame) {
        self.push(frame);
    }

    /// Appends a cyclic value, or replaces the queued one with the same identifier.
    pub fn cyclic(&mut self, frame: Frame) {
        if self.marks != 0
            && let Some(place) = self.waiting(frame.can_id())
        {
            if let Some(stale) = self.frames.get_mut(place) {
                *stale = frame;
            }
            return;
        }
        self.marks |= self.push(frame);
    }

    /// The place of the cyclic value with this identifier.
    fn waiting(&self, id: CanId) -> Option<usize> {
        let mut frames = self.frames.iter().enumerate();
        let same = |(place, frame): &(usize, &Frame)| {
            self.marks & cyclic(*place) != 0 && frame.can_id() == id
        };
        frames.find(same).map(|(place, _)| place)
    }

    /// Appends a frame. Returns the mark of a cyclic value at its place.
    fn push(&mut self, frame: Frame) -> u32 {
        let place = usize::from(self.first.wrapping_add(self.length)) % CAPACITY;
        // The reserve ensures room. Without room, the new frame is dropped and no queued frame is overwritten.
        if usize::from(self.length) < CAPACITY
            && let Some(free) = self.frames.get_mut(place)
        {
            *free = frame;
            self.length += 1;
            return cyclic(place);
        }
        0
    }

    /// Removes the queued cyclic value with this identifier.
    pub fn withdraw(&mut self, id: CanId) {
        if let Some(place) = self.waiting(id) {
            self.marks = self.marks & !cyclic(place) | withdrawn(place);
        }
    }

    /// Removes all frames, also those that must be sent.
    pub fn clear(&mut self) {
        self.length = 0;
        self.marks = 0;
    }

    /// The next frame to send.
    pub fn pop(&mut self) -> Option<Frame> {
        while self.length > 0 {
            let place = usize::from(self.first) % CAPACITY;
            self.first = self.first.wrapping_add(1);
            self.length -= 1;
            let marks = self.marks;
            self.marks = marks & !(cyclic(place) | withdrawn(place));
            if marks & withdrawn(place) == 0 {
                return self.frames.get(place).copied();
            }
        }
        None
    }
}

/// The mark of a cyclic value at a place.
const fn cyclic(place: usize) -> u32 {
    1 << (place % CAPACITY)
}

/// The mark of a frame that is not sent.
const fn withdrawn(place: usize) -> u32 {
    1 << (CAPACITY + place % CAPACITY)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::can::standard;

    fn frame(byte: u8) -> Frame {
        Frame::data(standard(0x301), &[byte]).unwrap()
    }

    #[test]
    fn newer_cyclic_value_replaces_queued_one() {
        let mut queue = TransmitQueue::EMPTY;
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
        let mut queue = TransmitQueue::EMPTY;
        queue.cyclic(frame(1));
        queue.cyclic(other(2));
        queue.cyclic(frame(3));
        queue.reply(frame(4));
        queue.withdraw(CanId::standard(0x302));
        let order: std::vec::Vec<_> = std::iter::from_fn(|| queue.pop()).collect();
        assert_eq!(order, [frame(3), frame(4)]);
    }

    #[test]
    fn queue_with_room_accepts_two_replies_one_event_and_reserved_cyclic_values() {
        for others in [1, 5, TransmitQueue::OTHERS] {
            let mut queue = TransmitQueue::EMPTY;
            queue.reserve(others);
            let mut sent = 0;
            while queue.has_room() {
                queue.reply(frame(sent));
                queue.reply(frame(sent + 1));
                sent += 2;
            }
            queue.reply(frame(sent));
            let value = |id| Frame::data(standard(id as u16), &[]).unwrap();
            let values: std::vec::Vec<_> = (1..others).map(value).collect();
            for value in &values {
                queue.cyclic(*value);
            }
            let order: std::vec::Vec<_> = std::iter::from_fn(|| queue.pop()).collect();
            let expected: std::vec::Vec<_> = (0..=sent).map(frame).chain(values).collect();
            assert_eq!(order, expected, "{others} others");
        }
    }
}
