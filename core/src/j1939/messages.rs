//! DM1 and the messages of the transport protocol.
//!
//! A message to all nodes takes more than 60 ms for each packet, and only one is sent at a time. The others wait and are sent one after
//! the other. DM1 gets its codes when its transmission begins. The next DM1 begins after the end of the previous DM1, because a receiver
//! uses the last complete one.

use super::identifier::{
    ACTIVE_CODES, COMMANDED_ADDRESS, COMPONENT_IDENTIFICATION, ECU_IDENTIFICATION, GLOBAL,
    Identifier, Pgn, SOFTWARE_IDENTIFICATION,
};
use super::product::{Conditions, ContextOf, Product};
use super::protocol::J1939;
use crate::time::Instant;

/// The messages that can be too long for a frame.
pub(super) const LONG: [Pgn; 4] = [
    ACTIVE_CODES,
    COMPONENT_IDENTIFICATION,
    ECU_IDENTIFICATION,
    SOFTWARE_IDENTIFICATION,
];

/// The bit of a message of [`LONG`].
fn bit(pgn: Pgn) -> u8 {
    let place = LONG.iter().position(|long| *long == pgn);
    place.map_or(0, |place| 1 << place)
}

impl<P: Product> J1939<P> {
    /// The active trouble codes, as bits, in the order of the product's table.
    pub(super) fn active(&self, cx: &ContextOf<P>) -> u16 {
        let conditions = Conditions {
            memory: self.memory,
            network: self.passive || self.overrun,
        };
        P::active(cx, conditions)
    }

    /// Sends DM1 when it is due and the one before has ended.
    pub(super) fn tick_diagnostics(&mut self, cx: &mut ContextOf<P>, now: Instant) {
        self.diagnostics.set(self.active(cx));
        if self.diagnostics.is_due(now)
            && cx.shell.has_room()
            && self.claim.address().is_some()
            && !self.broadcast.is_of(ACTIVE_CODES)
        {
            if self.diagnostics.reported().count_ones() > 1 {
                self.broadcast(ACTIVE_CODES);
            } else {
                self.report_codes(cx, now);
            }
        }
        self.consider(now, self.diagnostics.deadline());
    }

    /// Sends DM1 in one frame, or starts a BAM. If DM1 has more than one frame, no other BAM is in progress.
    fn report_codes(&mut self, cx: &mut ContextOf<P>, now: Instant) {
        let Some(source) = self.claim.address() else {
            return;
        };
        self.diagnostics.set(self.active(cx));
        let reported = self.diagnostics.reported();
        let message = self.diagnostics.message(P::TROUBLE_CODES, reported);
        match <[u8; 8]>::try_from(&*message) {
            Ok(bytes) => {
                let id = Identifier::new(ACTIVE_CODES, GLOBAL, source);
                // On a bus without another node, only the newest one waits.
                cx.shell.send_cyclic(id.frame(bytes));
            }
            Err(_) => self.broadcast.begin(GLOBAL, ACTIVE_CODES, message),
        }
        self.waiting &= !bit(ACTIVE_CODES);
        self.diagnostics.sent(now);
        // An event is active in one message.
        if core::mem::take(&mut self.overrun) {
            self.diagnostics.set(self.active(cx));
        }
    }

    /// Sends a message to all nodes when the messages before it are sent.
    pub(super) fn broadcast(&mut self, pgn: Pgn) {
        self.waiting |= bit(pgn);
    }

    /// Takes the next waiting message to all nodes. The messages take turns in the order of [`LONG`].
    fn take_waiting(&mut self) -> Option<Pgn> {
        let last = bit(self.broadcast.pgn());
        // The waiting messages after the last one; none if there was no message yet.
        let after = self.waiting & !(last | last.wrapping_sub(1));
        let next = if after == 0 { self.waiting } else { after };
        let pgn = LONG.get(next.trailing_zeros() as usize).copied();
        self.waiting &= !pgn.map_or(0, bit);
        pgn
    }

    /// Sends a frame of a message when all other frames have left the queue, so that they do not wait for it.
    pub(super) fn tick_transport(&mut self, cx: &mut ContextOf<P>, now: Instant) {
        if !cx.shell.is_sending()
            && let Some(source) = self.claim.address()
        {
            if !self.broadcast.is_active()
                && let Some(pgn) = self.take_waiting()
            {
                if pgn == ACTIVE_CODES {
                    self.report_codes(cx, now);
                } else if let Some(message) = self.message(cx, pgn) {
                    self.broadcast.begin(GLOBAL, pgn, message);
                }
            }
            let expired = self.commanded.poll(now, COMMANDED_ADDRESS);
            let transfers = [&mut self.broadcast].into_iter();
            let mut transfers = transfers.chain(&mut self.connections);
            let packet = expired.or_else(|| transfers.find_map(|transfer| transfer.next(now)));
            if let Some(packet) = packet {
                cx.shell.send(packet.frame(source));
            }
        } else if self.claim.address().is_none() {
            // Without an address, there are only transfers to all nodes, which end without a message.
            let _ = self.commanded.poll(now, COMMANDED_ADDRESS);
        }
        self.pending |= self.waiting != 0 && cx.shell.is_sending();
        let transfers = [&self.broadcast].into_iter().chain(&self.connections);
        let mut deadlines = self.commanded.deadline();
        let mut pending = false;
        for transfer in transfers {
            pending |= transfer.is_pending();
            deadlines.consider(transfer.deadline());
        }
        self.pending |= pending;
        self.consider(now, deadlines);
    }
}
