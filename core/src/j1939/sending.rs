//! The frames and messages of the present values, and the LEDs.

use super::claim::State;
use super::groups;
use super::identification;
use super::identifier::{ACTIVE_CODES, GLOBAL, Identifier, PROPRIETARY_A, Pgn};
use super::product::Product;
use super::protocol::{ContextOf, J1939};
use super::transport::Message;
use crate::can::Frame;
use crate::node::{Pattern, Patterns};

impl<P: Product> J1939<P> {
    /// The present frame of a group; None without an address.
    pub(super) fn group(&self, cx: &ContextOf<P>, place: usize) -> Option<Frame> {
        let source = self.claim.address()?;
        let motion = P::motion(&cx.values, &cx.parameters);
        let (pgn, bytes) = groups::frame(place, &motion)?;
        let priority = cx.parameters.get(*P::PRIORITIES.get(place)?) as u8;
        let id = Identifier::new(pgn, GLOBAL, source).with_priority(priority);
        Some(id.frame(bytes))
    }

    /// The message of a group that is not process data; None if it is not supported.
    pub(super) fn message(&self, cx: &ContextOf<P>, pgn: Pgn) -> Option<Message> {
        if pgn == ACTIVE_CODES {
            let active = self.diagnostics.active();
            return Some(self.diagnostics.message(P::TROUBLES, active));
        }
        identification::message::<P>(pgn, &cx.shell)
    }

    /// Queues the bytes of an SDO message for a client.
    pub(super) fn reply(&self, cx: &mut ContextOf<P>, client: u8, message: Option<[u8; 8]>) {
        if let Some(bytes) = message
            && let Some(source) = self.claim.address()
        {
            cx.shell
                .send(Identifier::new(PROPRIETARY_A, client, source).frame(bytes));
        }
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
            error: P::LEDS.error.of(cx.shell.bus_state()),
            ..Patterns::default()
        });
    }
}
