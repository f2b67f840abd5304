//! The clock and the transmit mailboxes for the driver, with single attempts.

use super::transmit::{self, End};
use crate::clock;
use plumbline::can::Frame;
use plumbline::node::driver;
use plumbline::time::Instant;

/// The three transmit mailboxes of bxCAN.
pub struct Mailboxes {
    /// The frame in a mailbox for which the controller makes a single attempt.
    once: Option<Frame>,
    /// This frame is aborted.
    aborted: bool,
}

impl Mailboxes {
    /// No frame has a single attempt.
    pub const EMPTY: Self = Self {
        once: None,
        aborted: false,
    };

    /// Handles the transmit interrupt. Returns true if the frame for which the controller made a single attempt ended in a bit error.
    pub fn complete(&mut self) -> bool {
        let Some(frame) = &self.once else {
            transmit::acknowledge();
            if transmit::is_single_attempt() {
                // A disturbance of the variable: the controller would not repeat a frame that is disturbed on the bus.
                transmit::set_single_attempt(false);
            }
            return false;
        };
        let end = transmit::end();
        transmit::acknowledge();
        if end == End::Again && !self.aborted {
            transmit::put(frame);
            return false;
        }
        self.once = None;
        transmit::set_single_attempt(false);
        end == End::Failed && !self.aborted
    }
}

impl driver::Mailboxes for Mailboxes {
    fn now(&self) -> Instant {
        clock::now()
    }

    fn is_idle(&self) -> bool {
        transmit::is_idle()
    }

    fn has_room(&self) -> bool {
        transmit::has_room()
    }

    fn put(&mut self, frame: &Frame, once: bool) {
        if once || self.once.is_some() {
            transmit::set_single_attempt(once);
            self.once = once.then_some(*frame);
            self.aborted = false;
        }
        transmit::put(frame);
    }

    fn abort(&mut self) {
        self.aborted = true;
        transmit::abort_all();
    }
}
