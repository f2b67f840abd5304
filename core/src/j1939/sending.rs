//! The frames and messages of the present values, and the LEDs.

use super::claim::State;
use super::identification;
use super::identifier::{ACTIVE_CODES, GLOBAL, Identifier, PROPRIETARY_A, Pgn};
use super::product::{ContextOf, Product, Sent};
use super::protocol::J1939;
use super::transport::Message;
use crate::can::{CanId, Frame};
use crate::node::{Pattern, Patterns};

impl<P: Product> J1939<P> {
    /// The present frame of a group; None without an address.
    pub(super) fn group(
        &self,
        cx: &ContextOf<P>,
        sent: &'static Sent<P::Application>,
    ) -> Option<Frame> {
        let source = self.claim.address()?;
        let priority = sent.priority.get(&cx.parameters) as u8;
        let id = Identifier::new(sent.pgn, GLOBAL, source).with_priority(priority);
        Some(id.frame((sent.data)(cx)))
    }

    /// The message of a group that is not process data; None if it is not supported.
    pub(super) fn message(&self, cx: &ContextOf<P>, pgn: Pgn) -> Option<Message> {
        if pgn == ACTIVE_CODES {
            let active = self.diagnostics.active();
            return Some(self.diagnostics.message(P::TROUBLE_CODES, active));
        }
        identification::message::<P>(pgn, &cx.shell)
    }

    /// Queues a message of Proprietary A to a node. Does nothing if there is no message.
    pub fn reply(&self, cx: &mut ContextOf<P>, destination: u8, message: Option<[u8; 8]>) {
        if let Some(bytes) = message
            && let Some(source) = self.claim.address()
        {
            cx.shell
                .send(Identifier::new(PROPRIETARY_A, destination, source).frame(bytes));
        }
    }

    /// Whether the controller must not repeat the next frame after a bit error: it is a claim.
    pub fn sends_once(&self) -> bool {
        self.claim.is_queued()
    }

    /// The identifier of a message of Proprietary A to a node.
    pub fn proprietary_id(&self, destination: u8) -> CanId {
        Identifier::new(PROPRIETARY_A, destination, self.claim.source()).can_id()
    }

    /// The identifiers of messages of Proprietary A from a node, and of those to it.
    pub fn proprietary_ids(&self, node: u8) -> (CanId, CanId) {
        let request = Identifier::new(PROPRIETARY_A, self.claim.source(), node);
        (request.can_id(), self.proprietary_id(node))
    }

    /// Shows the LED patterns of the present state.
    pub(super) fn show(&self, cx: &mut ContextOf<P>) {
        let run = match self.claim.state() {
            State::Claiming => Pattern::Blinking,
            State::Claimed => Pattern::On,
            State::CannotClaim => Pattern::SingleFlash,
            State::Off => Pattern::Off,
        };
        cx.shell.show(Patterns {
            run,
            error: P::ERROR_LED.of(cx.shell.bus_state()),
            ..Patterns::default()
        });
    }
}
