//! The network access: the start of the duplicate MAC ID check, its messages, and leaving the network after a request.

use super::allocation::ConnectionSet;
use super::duplicate_check::{self, Step};
use super::identifiers::group_2;
use super::objects::identity::vendor;
use super::protocol::{ContextOf, Devicenet, Leaving};
use super::table::Product;
use crate::can::Frame;
use crate::time::{Deadline, Duration, Instant, millis};

/// The longest time that a change of the MAC ID waits until its answer is sent.
const READDRESS_LIMIT: Duration = millis(250);

impl<P: Product> Devicenet<P> {
    /// Leaves the network after the answer to the present request: all connections are released at once.
    pub(super) fn leave_network(&mut self, cx: &mut ContextOf<P>, now: Instant, leaving: Leaving) {
        self.leaving = leaving;
        self.leaves_until = Deadline::after(now, READDRESS_LIMIT);
        self.check.stop();
        self.release_all(cx);
    }

    pub(super) fn release_all(&mut self, cx: &mut ContextOf<P>) {
        self.connections = ConnectionSet::EMPTY;
        self.update_io(cx);
    }

    /// Takes the MAC ID from the parameters, and checks it.
    pub(super) fn readdress(&mut self, cx: &mut ContextOf<P>) {
        self.leaving = Leaving::None;
        self.mac = cx.parameters.get(P::ROLES.mac_id) as u8;
        self.discard(cx);
        self.check.start();
        self.send_check(cx, false);
        cx.shell.wake_up();
    }

    /// Discards all frames that are not sent yet, also those in mailboxes, and sets the filters.
    pub(super) fn discard(&self, cx: &mut ContextOf<P>) {
        cx.shell.clear_queue();
        cx.shell.go_online(self.rate);
    }

    /// Sends a message of the duplicate MAC ID check.
    pub(super) fn send_check(&self, cx: &mut ContextOf<P>, is_response: bool) {
        let vendor = vendor::<P>(cx.shell.unit());
        let (data, length) = duplicate_check::message(is_response, vendor, cx.shell.serial());
        self.send(cx, group_2::DUPLICATE_CHECK, data, length);
    }

    /// Handles a message of the duplicate MAC ID check.
    pub(super) fn check_duplicate(&mut self, cx: &mut ContextOf<P>, frame: &Frame) {
        match self.check.receive(frame) {
            Step::Respond => self.send_check(cx, true),
            Step::Fault => {
                self.release_all(cx);
                self.discard(cx);
            }
            Step::None | Step::Request | Step::Online => {}
        }
    }

    /// Continues to leave the network.
    pub(super) fn continue_leaving(&mut self, cx: &mut ContextOf<P>, now: Instant) {
        match self.leaving {
            Leaving::None => {}
            Leaving::Readdress => {
                if self.leaves_until.is_reached(now) {
                    self.readdress(cx);
                } else {
                    self.earliest.consider(self.leaves_until);
                }
            }
            Leaving::Restart => {
                if !self.saving.save(cx) && !cx.shell.is_leaving() {
                    cx.shell.restart(now);
                }
            }
        }
    }
}
