//! The transmit mailboxes of a simulated CAN controller.

use plumbline::can::Frame;
use std::collections::VecDeque;

/// The number of mailboxes that the driver uses, as on the boards.
const MAILBOXES: usize = 2;

/// A frame in a mailbox.
#[derive(Clone, Copy, Debug)]
struct Mailbox {
    frame: Frame,
    /// It is not repeated after a bit error.
    once: bool,
    /// It is being sent, and dropped if it fails.
    aborted: bool,
}

/// The frames in the mailboxes, in the order of their transmission.
#[derive(Debug, Default)]
pub(super) struct Mailboxes(VecDeque<Mailbox>);

impl Mailboxes {
    /// The frame that is sent next, or being sent.
    pub(super) fn first(&self) -> Option<Frame> {
        self.0.front().map(|mailbox| mailbox.frame)
    }

    pub(super) fn has_room(&self) -> bool {
        self.0.len() < MAILBOXES
    }

    pub(super) fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    pub(super) fn put(&mut self, frame: &Frame, once: bool) {
        self.0.push_back(Mailbox {
            frame: *frame,
            once,
            aborted: false,
        });
    }

    /// Aborts the frames. The first one is completed if it is on the wire.
    pub(super) fn abort(&mut self, is_transmitting: bool) {
        self.0.truncate(is_transmitting.into());
        for first in &mut self.0 {
            first.aborted = true;
        }
    }

    /// Removes all frames.
    pub(super) fn clear(&mut self) {
        self.0.clear();
    }

    /// The first frame was sent.
    pub(super) fn sent(&mut self) {
        self.0.pop_front();
    }

    /// The first frame ended in a bit error. Returns true if it is not repeated.
    pub(super) fn failed(&mut self) -> bool {
        self.0.pop_front_if(|first| first.once).is_some()
    }

    /// The first frame is not on the wire any more. Returns true if it was aborted.
    pub(super) fn drop_aborted(&mut self) -> bool {
        self.0.pop_front_if(|first| first.aborted).is_some()
    }
}
