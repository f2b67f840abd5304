//! The received frames: claims of other nodes, requests, transport protocol and parameters.

use super::claim::{Outcome, State};
use super::groups;
use super::identifier::{
    ADDRESS_CLAIMED, COMMANDED_ADDRESS, EXTENDED_DATA_PAGE, GLOBAL, Identifier, NO_ADDRESS,
    PROPRIETARY_A, Pgn, REQUEST, TRANSPORT_CONTROL, TRANSPORT_DATA,
};
use super::name::Name;
use super::product::Product;
use super::protocol::{ContextOf, J1939};
use super::request::{self, acknowledgement, requested};
use super::transport::{Control, Outgoing, Reaction};
use crate::can::{Filter, Frame};
use crate::canopen::Canopen;
use crate::time::Instant;

/// The largest address of a node.
const LAST_ADDRESS: u8 = 253;

/// The bits of an identifier that the acceptance filters compare: pages and PF, and the destination.
const FORMAT: u32 = EXTENDED_DATA_PAGE | 0x01FF_0000;
const DESTINATION: u32 = 0xFF00;

impl<P: Product> J1939<P> {
    /// The most acceptance filters.
    pub(super) const FILTERS: usize = 8;

    /// Handles a received frame.
    #[inline(never)] // CANopen must not pay for its stack
    pub(super) fn receive(
        &mut self,
        cx: &mut ContextOf<P>,
        now: Instant,
        frame: &Frame,
        objects: &mut Canopen<P>,
    ) {
        let Some(id) = Identifier::of(frame) else {
            return;
        };
        let data = frame.bytes();
        let own = self.claim.address();
        let to_us = own == Some(id.destination) && id.source < NO_ADDRESS;
        let to_all = id.destination == GLOBAL && id.source < NO_ADDRESS;
        match (id.pgn, <[u8; 8]>::try_from(data)) {
            (REQUEST, _) => {
                if let Some(pgn) = requested(data) {
                    self.request(cx, now, id, pgn);
                }
            }
            (ADDRESS_CLAIMED, Ok(bytes)) if id.destination == GLOBAL => {
                let name = Name::from_bytes(bytes);
                self.contend(cx, now, (id.source, name), objects);
            }
            (TRANSPORT_CONTROL, Ok(bytes)) if to_us || to_all => {
                if let Some(control) = Control::parse(bytes) {
                    self.control(cx, now, (id.source, to_us), control);
                }
            }
            (TRANSPORT_DATA, Ok(bytes)) if to_us || to_all => {
                let who = (id.source, to_us);
                let reaction = self.commanded.data(now, who, bytes, COMMANDED_ADDRESS);
                self.react(cx, reaction, objects);
            }
            (PROPRIETARY_A, Ok(bytes)) if to_us => {
                self.serve(cx, now, id.source, (frame, bytes), objects)
            }
            _ => {}
        }
    }

    /// Handles Address Claimed of another node.
    fn contend(
        &mut self,
        cx: &mut ContextOf<P>,
        now: Instant,
        (source, name): (u8, Name),
        objects: &mut Canopen<P>,
    ) {
        match self.claim.hear(now, source, name) {
            Outcome::None => {}
            Outcome::Defended => self.announce(cx),
            Outcome::Left => {
                self.leave(cx, objects);
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
        if let Some(place) = groups::place(pgn) {
            if let Some(frame) = self.group(cx, place) {
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
        if let Ok(bytes) = <[u8; 8]>::try_from(&*message) {
            cx.shell
                .send(Identifier::new(pgn, GLOBAL, source).frame(bytes));
        } else if to_all {
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

    /// Handles a TP.CM message.
    fn control(
        &mut self,
        cx: &mut ContextOf<P>,
        now: Instant,
        who: (u8, bool),
        (control, pgn): (Control, Pgn),
    ) {
        let (source, to_us) = who;
        let before = self.commanded.deadline();
        let wanted = COMMANDED_ADDRESS;
        if let Reaction::Answer(packet) = self.commanded.control(now, who, (control, pgn), wanted)
            && let Some(own) = self.claim.address()
        {
            cx.shell.send(packet.frame(own));
        }
        if to_us {
            let receive = |one: &mut Outgoing| one.receive(now, source, control, pgn);
            self.connections.iter_mut().for_each(receive);
        }
        // The messages of others to all nodes change nothing.
        if to_us || self.commanded.deadline() != before {
            cx.shell.wake_up();
        }
    }

    /// Handles the reaction to a packet of Commanded Address.
    fn react(&mut self, cx: &mut ContextOf<P>, reaction: Reaction, objects: &mut Canopen<P>) {
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
            self.leave(cx, objects);
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

    /// Handles the bytes of an SDO request.
    fn serve(
        &mut self,
        cx: &mut ContextOf<P>,
        now: Instant,
        client: u8,
        (frame, bytes): (&Frame, [u8; 8]),
        objects: &mut Canopen<P>,
    ) {
        if client != self.client {
            if !Canopen::<P>::begins_transfer(bytes) {
                // An abort has no answer.
                let refusal = (bytes.first() != Some(&0x80)).then(Canopen::<P>::refusal);
                self.reply(cx, client, refusal);
                return;
            }
            objects.end_transfer();
            self.client = client;
        }
        let was_saving = cx.is_saving();
        let id = Identifier::new(PROPRIETARY_A, client, self.claim.source());
        objects.serve_hosted(cx, now, frame, id.can_id());
        if cx.is_saving() && !was_saving {
            self.storing = client;
        }
    }

    /// Calls `accept` for each acceptance filter.
    pub(super) fn filters(&self, accept: &mut dyn FnMut(Filter)) {
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
