//! Receives the messages of one group: to all nodes (BAM), or to us (RTS/CTS).
//!
//! Only transfers of this group with the expected size need room, so that messages of other groups can be sent at the same time. A
//! transfer is identified by its sender and by whether it is to us.

use super::{Control, PACKET, Packet, Reason, T1, T2, packets};
use crate::j1939::identifier::Pgn;
use crate::time::{Deadline, Instant};

/// The number of transfers at a time.
const TRANSFERS: usize = 3;

/// The sender of a frame of the transport protocol.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Sender {
    /// The source address of the frame.
    pub source: u8,
    /// The frame is to us, not to all nodes.
    pub addressed: bool,
}

/// The transfer of a message of at most `N` bytes to this node.
#[derive(Clone, Copy, Debug)]
struct Transfer<const N: usize> {
    /// The end of the time for the next packet; none: no transfer.
    due: Deadline,
    sender: Sender,
    /// The number of received packets.
    received: u8,
    /// The number of the last packet that the sender may send before the next CTS.
    granted: u8,
    /// The maximum number of packets that one CTS may request.
    limit: u8,
    data: [u8; N],
}

impl<const N: usize> Transfer<N> {
    const NONE: Self = Self {
        due: Deadline::NEVER,
        sender: Sender {
            source: 0,
            addressed: false,
        },
        received: 0,
        granted: 0,
        limit: 0,
        data: [0; N],
    };
}

/// What follows from a received frame.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Reaction {
    /// The frame needs no answer.
    None,
    /// This frame must be sent.
    Answer(Packet),
    /// The [message](Incoming::message) is complete. This frame must be sent.
    Complete(Option<Packet>),
}

/// Receives messages of `N` bytes of one group.
#[derive(Clone, Debug)]
pub struct Incoming<const N: usize> {
    /// The place of the transfer of the last complete message.
    complete: u8,
    transfers: [Transfer<N>; TRANSFERS],
}

impl<const N: usize> Incoming<N> {
    /// No transfer. All bits are 0.
    pub const IDLE: Self = Self {
        complete: 0,
        transfers: [Transfer::NONE; TRANSFERS],
    };

    const PACKETS: u8 = packets(N);

    /// The message that was completed last.
    pub fn message(&self) -> [u8; N] {
        let transfer = self.transfers.get(usize::from(self.complete));
        transfer.map_or([0; N], |transfer| transfer.data)
    }

    /// Ends all transfers without a message.
    pub fn end(&mut self) {
        for transfer in &mut self.transfers {
            transfer.due = Deadline::NEVER;
        }
    }

    /// Ends the transfers to us without a message.
    pub fn end_addressed(&mut self) {
        let transfers = self.transfers.iter_mut();
        for transfer in transfers.filter(|one| one.sender.addressed) {
            transfer.due = Deadline::NEVER;
        }
    }

    /// Handles a TP.CM message. `wanted` is our group.
    pub fn control(
        &mut self,
        now: Instant,
        sender: Sender,
        (control, pgn): (Control, Pgn),
        wanted: Pgn,
    ) -> Reaction {
        let Sender { source, addressed } = sender;
        let (size, count, limit) = match control {
            Control::RequestToSend {
                size,
                packets,
                limit,
            } if addressed => (size, packets, limit.max(1)),
            Control::Broadcast { size, packets } if !addressed => (size, packets, Self::PACKETS),
            Control::Abort(_) => {
                if pgn == wanted {
                    self.forget(sender);
                }
                return Reaction::None;
            }
            _ => return Reaction::None,
        };
        // A sender has one message to all nodes at a time, and one transfer of a group to us.
        if !addressed || pgn == wanted {
            self.forget(sender);
        }
        self.expire(now);
        let fits = pgn == wanted && usize::from(size) == N && count == Self::PACKETS;
        let free = self
            .transfers
            .iter_mut()
            .find(|transfer| !transfer.due.is_set());
        match free.filter(|_| fits) {
            Some(transfer) => {
                *transfer = Transfer {
                    due: Deadline::after(now, if addressed { T2 } else { T1 }),
                    sender,
                    limit,
                    granted: limit.min(Self::PACKETS),
                    ..Transfer::NONE
                };
                if !addressed {
                    return Reaction::None;
                }
                let granted = Control::ClearToSend {
                    count: transfer.granted,
                    next: 1,
                };
                Reaction::Answer(Packet::control(source, granted, pgn))
            }
            None if addressed => {
                let reason = if fits {
                    Reason::Busy
                } else {
                    Reason::Resources
                };
                Reaction::Answer(abort(source, reason, pgn))
            }
            None => Reaction::None,
        }
    }

    /// Handles a TP.DT packet of a message of our group.
    pub fn data(&mut self, now: Instant, sender: Sender, bytes: [u8; 8], pgn: Pgn) -> Reaction {
        let Sender { source, addressed } = sender;
        let found = self.find(sender);
        let Some((place, transfer)) = found.filter(|(_, one)| !one.due.is_reached(now)) else {
            return Reaction::None;
        };
        let [number, packet @ ..] = bytes;
        if number != transfer.received + 1 {
            transfer.due = Deadline::NEVER;
            return if addressed {
                Reaction::Answer(abort(source, Reason::Sequence, pgn))
            } else {
                Reaction::None
            };
        }
        let first = PACKET * usize::from(transfer.received);
        let rest = transfer.data.iter_mut().skip(first);
        rest.zip(packet).for_each(|(to, from)| *to = from);
        transfer.received = number;
        transfer.due = Deadline::after(now, T1);
        if number == Self::PACKETS {
            transfer.due = Deadline::NEVER;
            let end = Control::End {
                size: N as u16,
                packets: Self::PACKETS,
            };
            let end = addressed.then(|| Packet::control(source, end, pgn));
            self.complete = place as u8;
            return Reaction::Complete(end);
        }
        if addressed && number == transfer.granted {
            let count = transfer.limit.min(Self::PACKETS - number);
            transfer.granted += count;
            transfer.due = Deadline::after(now, T2);
            let next = Control::ClearToSend {
                count,
                next: number + 1,
            };
            return Reaction::Answer(Packet::control(source, next, pgn));
        }
        Reaction::None
    }

    /// Ends every transfer to all nodes that has timed out, and one transfer to this node that has timed out. Returns the abort message for
    /// the transfer to this node.
    pub fn poll(&mut self, now: Instant, pgn: Pgn) -> Option<Packet> {
        self.expire(now);
        let mut transfers = self.transfers.iter_mut();
        let expired = transfers.find(|transfer| transfer.due.is_reached(now))?;
        expired.due = Deadline::NEVER;
        Some(abort(expired.sender.source, Reason::TimeOut, pgn))
    }

    /// Ends the transfers to all nodes that have timed out: they have no abort message.
    fn expire(&mut self, now: Instant) {
        for transfer in &mut self.transfers {
            if !transfer.sender.addressed && transfer.due.is_reached(now) {
                transfer.due = Deadline::NEVER;
            }
        }
    }

    /// The time of the next [`poll`](Self::poll).
    pub fn deadline(&self) -> Deadline {
        let mut earliest = Deadline::NEVER;
        for transfer in &self.transfers {
            earliest.consider(transfer.due);
        }
        earliest
    }

    fn find(&mut self, sender: Sender) -> Option<(usize, &mut Transfer<N>)> {
        let mut transfers = self.transfers.iter_mut().enumerate();
        transfers.find(|(_, transfer)| transfer.due.is_set() && transfer.sender == sender)
    }

    fn forget(&mut self, sender: Sender) {
        if let Some((_, transfer)) = self.find(sender) {
            transfer.due = Deadline::NEVER;
        }
    }
}

fn abort(destination: u8, reason: Reason, pgn: Pgn) -> Packet {
    Packet::control(destination, Control::Abort(reason as u8), pgn)
}

#[cfg(test)]
mod tests;
