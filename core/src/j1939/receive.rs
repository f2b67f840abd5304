//! The received frames: claims of other nodes, requests, transport protocol and parameters.

use super::claim::{Outcome, State};
use super::identifier::{
    ADDRESS_CLAIMED, COMMANDED_ADDRESS, EXTENDED_DATA_PAGE, GLOBAL, Identifier, LAST_ADDRESS,
    NO_ADDRESS, PROPRIETARY_A, Pgn, REQUEST, TRANSPORT_CONTROL, TRANSPORT_DATA,
};
use super::name::Name;
use super::product::{ContextOf, Product};
use super::protocol::J1939;
use super::request::{self, acknowledgement, requested};
use super::transport::{Control, Outgoing, Reaction, Sender};
use crate::can::{Filter, Frame};
use crate::time::Instant;

/// The bits of an identifier that the acceptance filters compare: pages and PF, and the destination.
const FORMAT: u32 = EXTENDED_DATA_PAGE | 0x01FF_0000;
const DESTINATION: u32 = 0xFF00;

/// A message of the group Proprietary A to this node.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Proprietary {
    /// The address of the sender.
    pub source: u8,
    /// The eight bytes of the frame.
    pub data: [u8; 8],
}

impl<P: Product> J1939<P> {
    /// The maximum number of acceptance filters.
    pub const FILTERS: usize = 8;

    /// Handles a received frame. Returns a message of Proprietary A, which is not handled here.
    pub fn receive(
        &mut self,
        cx: &mut ContextOf<P>,
        now: Instant,
        frame: &Frame,
    ) -> Option<Proprietary> {
        let id = Identifier::of(frame)?;
        let data = frame.bytes();
        let own = self.claim.address();
        let to_us = own == Some(id.destination) && id.source < NO_ADDRESS;
        let to_all = id.destination == GLOBAL && id.source < NO_ADDRESS;
        let sender = Sender {
            source: id.source,
            addressed: to_us,
        };
        let message = <[u8; 8]>::try_from(data);
        if self.resetting && id.pgn != ADDRESS_CLAIMED {
            return None;
        }
        match (id.pgn, message) {
            (REQUEST, _) => {
                if let Some(pgn) = requested(data) {
                    self.request(cx, now, id, pgn);
                }
            }
            (ADDRESS_CLAIMED, Ok(bytes)) if id.destination == GLOBAL => {
                let name = Name::from_bytes(bytes);
                self.contend(cx, now, (id.source, name));
            }
            (TRANSPORT_CONTROL, Ok(bytes)) if to_us || to_all => {
                if let Some(control) = Control::parse(bytes) {
                    self.control(cx, now, sender, control);
                }
            }
            (TRANSPORT_DATA, Ok(bytes)) if to_us || to_all => {
                let before = self.commanded.deadline();
                let reaction = self.commanded.data(now, sender, bytes, COMMANDED_ADDRESS);
                // After a packet, the time to the next one is shorter than after a CTS.
                if self.commanded.deadline() != before {
                    cx.shell.wake_up();
                }
                self.react(cx, reaction);
            }
            (PROPRIETARY_A, Ok(bytes)) if to_us => {
                return Some(Proprietary {
                    source: id.source,
                    data: bytes,
                });
            }
            _ => {}
        }
        None
    }

    /// Handles Address Claimed of another node.
    fn contend(&mut self, cx: &mut ContextOf<P>, now: Instant, (source, name): (u8, Name)) {
        if self.resetting {
            // Only frames that wait must not be sent from a lost address.
            if self.claim.address() == Some(source) && name < self.claim.name() {
                self.leave(cx);
                cx.shell.go_online(self.rate);
            }
            return;
        }
        match self.claim.hear(now, source, name) {
            Outcome::None => {}
            Outcome::Defended => self.announce(cx),
            Outcome::Left => {
                self.leave(cx);
                self.move_on(cx);
            }
        }
    }

    /// Handles a request for a group.
    fn request(&mut self, cx: &mut ContextOf<P>, now: Instant, id: Identifier, pgn: Pgn) {
        let to_all = id.destination == GLOBAL;
        if !to_all && id.destination != self.claim.source() {
            return;
        }
        if pgn == ADDRESS_CLAIMED {
            if self.claim.requested(now) {
                cx.shell.send(self.claim.frame());
            }
            cx.shell.wake_up();
            return;
        }
        let Some(source) = self.claim.address().filter(|_| id.source < NO_ADDRESS) else {
            return;
        };
        if let Some(sent) = P::SENT.iter().find(|sent| sent.pgn == pgn) {
            if let Some(frame) = self.group(cx, sent) {
                cx.shell.send(frame);
            }
            return;
        }
        let Some(message) = self.message(cx, pgn) else {
            if !to_all {
                let control = request::Control::Negative;
                cx.shell
                    .send(acknowledgement(control, pgn, id.source, source));
            }
            return;
        };
        let bytes = <[u8; 8]>::try_from(&*message).ok();
        // A frame follows the end of an older message of the same group.
        let follows = bytes.is_some() && self.broadcast.is_of(pgn);
        if let Some(bytes) = bytes.filter(|_| !follows) {
            cx.shell
                .send(Identifier::new(pgn, GLOBAL, source).frame(bytes));
        } else if to_all || follows {
            self.broadcast(pgn);
        } else if self.connections.iter().any(|one| one.is_to(id.source)) {
            self.refuse(cx, pgn, id.source, source);
        } else {
            match self.connections.iter_mut().find(|one| !one.is_active()) {
                Some(free) => free.begin(id.source, pgn, message),
                None => self.refuse(cx, pgn, id.source, source),
            }
        }
        cx.shell.wake_up();
    }

    fn refuse(&self, cx: &mut ContextOf<P>, pgn: Pgn, requester: u8, source: u8) {
        let control = request::Control::Busy;
        cx.shell
            .send(acknowledgement(control, pgn, requester, source));
    }

    /// Handles a message of the connection management (TP.CM).
    fn control(
        &mut self,
        cx: &mut ContextOf<P>,
        now: Instant,
        sender: Sender,
        (control, pgn): (Control, Pgn),
    ) {
        let before = self.commanded.deadline();
        let wanted = COMMANDED_ADDRESS;
        let reaction = self.commanded.control(now, sender, (control, pgn), wanted);
        if let Reaction::Answer(packet) = reaction
            && let Some(own) = self.claim.address()
        {
            cx.shell.send(packet.frame(own));
        }
        if sender.addressed {
            let receive = |one: &mut Outgoing| one.receive(now, sender.source, control, pgn);
            self.connections.iter_mut().for_each(receive);
        }
        // Other messages to all nodes have no effect on this node.
        if sender.addressed || self.commanded.deadline() != before {
            cx.shell.wake_up();
        }
    }

    /// Handles the reaction to a packet of Commanded Address.
    fn react(&mut self, cx: &mut ContextOf<P>, reaction: Reaction) {
        let (packet, message) = match reaction {
            Reaction::None => return,
            Reaction::Answer(packet) => (Some(packet), None),
            Reaction::Complete(packet) => (packet, Some(self.commanded.message())),
        };
        let own = self.claim.address();
        let answer = packet.and_then(|packet| Some(packet.frame(own?)));
        cx.shell.wake_up();
        if let Some([name @ .., address]) = message
            && Name::from_bytes(name) == self.claim.name()
            && address <= LAST_ADDRESS
        {
            self.leave(cx);
            if let Some(frame) = answer {
                cx.shell.send(frame);
            }
            // Without a save, the next start claims the stored address again.
            cx.parameters.set(P::ADDRESS, address.into());
            self.claim.take(address);
            self.move_on(cx);
        } else if let Some(frame) = answer {
            cx.shell.send(frame);
        }
    }

    /// The address that is ours.
    pub fn address(&self) -> Option<u8> {
        self.claim.address()
    }

    /// Calls `accept` for each acceptance filter.
    pub fn filters(&self, accept: &mut dyn FnMut(Filter)) {
        let mut add = |pgn: Pgn, destination: u8, mask: u32| {
            let id = Identifier::new(pgn, destination, 0).can_id();
            accept(Filter {
                id: id.into(),
                mask,
            });
        };
        let exact = FORMAT | DESTINATION;
        add(ADDRESS_CLAIMED, GLOBAL, exact);
        add(TRANSPORT_CONTROL, GLOBAL, exact);
        add(TRANSPORT_DATA, GLOBAL, exact);
        add(REQUEST, GLOBAL, exact);
        let own = self.claim.source();
        add(REQUEST, own, exact);
        if self.claim.state() != State::CannotClaim {
            for pgn in [TRANSPORT_CONTROL, TRANSPORT_DATA, PROPRIETARY_A] {
                add(pgn, own, exact);
            }
        }
    }
}
