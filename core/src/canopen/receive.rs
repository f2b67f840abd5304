//! The received frames: SYNC, SDO requests, NMT commands, node guarding and remote frames.

use super::cob_id;
use super::diagnosis;
use super::nmt::{Command, State};
use super::objects::View;
use super::pdo::Tpdos;
use super::product::{ContextOf, Product};
use super::program;
use super::protocol::{Canopen, Services, send, send_reply};
use crate::application::Application;
use crate::can::{CanId, Frame};
use crate::time::Instant;

impl<P: Product> Canopen<P> {
    /// Handles a received frame. If it is an SDO request, returns the identifier of the reply instead: [`serve`](Self::serve) must
    /// follow.
    pub fn route(&mut self, cx: &mut ContextOf<P>, now: Instant, frame: &Frame) -> Option<CanId> {
        if self.layer_setting(cx, now, frame) {
            return None;
        }
        let services = &mut self.services;
        let id = frame.can_id();
        let node_id = u16::from(services.node_id);
        if Some(id) == services.sync {
            if is_sync(frame) {
                services.unsynchronised = P::Tpdos::COUNT as u8;
                services.synchronise_next(cx);
            }
        } else if id == CanId::standard(cob_id::SDO_REQUEST + node_id) {
            return Some(CanId::standard(cob_id::SDO_REPLY + node_id));
        } else if id == CanId::standard(cob_id::NMT) {
            self.nmt(cx, now, frame);
        } else if Services::<P>::HAS_GUARDING
            && id == CanId::standard(cob_id::ERROR_CONTROL + node_id)
        {
            services.guard(cx, now, frame);
        } else if services.hear(cx, now, frame) {
            return None;
        } else if frame.is_remote() {
            services.request(cx, now, id);
        }
        None
    }

    /// Handles an SDO request and queues the reply, if there is one now, with this identifier.
    pub fn serve(&mut self, cx: &mut ContextOf<P>, now: Instant, frame: &Frame, reply: CanId) {
        let Some(bytes) = frame.eight_bytes() else {
            return;
        };
        if !self.services.state.communicates() {
            return;
        }
        let [_, _, group, ..] = bytes;
        if (group == program::GROUP || P::Application::HAS_DIAGNOSIS && group == diagnosis::GROUP)
            && let Some(answer) = self.services.answer_extra(cx, now, bytes)
        {
            // An initiate request ends the previous transfer.
            self.sdo.finish();
            send_reply(cx, reply, Some(answer));
            return;
        }
        let services = &mut self.services;
        let answer = self.sdo.serve(&mut View { services, cx }, now, bytes);
        match P::HOSTED {
            // The identifier differs between the protocols.
            Some(_) => send_reply(cx, reply, answer),
            None => self.services.send_sdo(cx, answer),
        }
        // A read of a number has no deadline.
        if self.sdo.deadline().is_set() {
            cx.shell.wake_up();
        }
    }

    fn nmt(&mut self, cx: &mut ContextOf<P>, now: Instant, frame: &Frame) {
        let Some(command) = Command::parse(frame, self.services.node_id) else {
            return;
        };
        match command {
            Command::Enter(state) => self.enter(cx, now, state),
            // An object has requested a reset of the node, which the reset communication must not cancel.
            Command::ResetCommunication if self.services.state != State::Initialising => {
                self.services.reset_lss();
                self.reset_communication(cx, now);
            }
            Command::ResetNode | Command::ResetCommunication => self.reset_node(cx, now),
        }
        cx.shell.wake_up();
    }

    /// Changes the NMT state with all that depends on it. During the initialization, nothing happens.
    pub(super) fn enter(&mut self, cx: &mut ContextOf<P>, now: Instant, state: State) {
        if state == self.services.state || self.services.state == State::Initialising {
            return;
        }
        let emergency = &mut self.services.emergency;
        if !state.communicates() {
            emergency.silence();
        } else if !self.services.state.communicates() {
            emergency.resume();
        }
        self.services.state = state;
        self.services.operate(now, state == State::Operational);
        self.services.withdraw(cx);
        if !state.communicates() {
            self.sdo.end();
        }
        self.services.show(cx);
    }
}

impl<P: Product> Services<P> {
    /// Handles a node guarding request. The heartbeat overrides node guarding.
    fn guard(&mut self, cx: &mut ContextOf<P>, now: Instant, frame: &Frame) {
        if !frame.is_remote() || self.heartbeat.deadline().is_set() {
            return;
        }
        let failed = self.guarding.failed();
        let answer = self.guarding.answer(now, self.state);
        let id = cob_id::ERROR_CONTROL + u16::from(self.node_id);
        send(cx, id, &[answer]);
        if failed {
            self.report_guarding(cx);
        }
        cx.shell.wake_up();
    }
}

/// Whether a frame with the identifier of the SYNC is a SYNC (CiA 301, 7.2.5): without data, or with a counter.
///
/// No sensor supports the SYNC start value (sub-index 6 of a TPDO), so the counter is ignored.
fn is_sync(frame: &Frame) -> bool {
    !frame.is_remote() && frame.dlc() <= 1
}
