//! Receives the messages of one group: to all nodes (BAM), or to us (RTS/CTS).
//!
//! Only transfers of this group with the expected size need room, so that messages of other groups can be sent at the same time. A
//! transfer is identified by its sender and by whether it is to us.

use super::{Control, PACKET, Packet, Reason, T1, T2, packets};
use crate::j1939::identifier::Pgn;
use crate::time::{Deadline, Instant};

/// The number of transfers at a time.
const TRANSFERS: usize = 3;

/// A transfer in progress.
#[derive(Clone, Copy, Debug)]
struct Transfer<const N: usize> {
    /// The end of the time for the next packet; none: no transfer.
    due: Deadline,
    source: u8,
    /// The message is to us, not to all nodes.
    addressed: bool,
    /// The number of received packets.
    received: u8,
    /// The number of the last packet that the sender may send before the next CTS.
    granted: u8,
    /// The most packets that one CTS may request.
    limit: u8,
    data: [u8; N],
}

impl<const N: usize> Transfer<N> {
    const NONE: Self = Self {
        due: Deadline::NEVER,
        source: 0,
        addressed: false,
        received: 0,
        granted: 0,
        limit: 0,
        data: [0; N],
    };
}

/// What follows from a received frame.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Reaction {
    /// Nothing.
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

    /// The last complete message.
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
        for transfer in self.transfers.iter_mut().filter(|one| one.addressed) {
            transfer.due = Deadline::NEVER;
        }
    }

    /// Handles a TP.CM message. `wanted` is our group, `addressed` whether the message is to us.
    pub fn control(
        &mut self,
        now: Instant,
        (source, addressed): (u8, bool),
        (control, pgn): (Control, Pgn),
        wanted: Pgn,
    ) -> Reaction {
        let (size, count, limit) = match control {
            Control::RequestToSend {
                size,
                packets,
                limit,
            } if addressed => (size, packets, limit.max(1)),
            Control::Broadcast { size, packets } if !addressed => (size, packets, Self::PACKETS),
            Control::Abort(_) => {
                if pgn == wanted {
                    self.forget(source, addressed);
                }
                return Reaction::None;
            }
            _ => return Reaction::None,
        };
        // A sender has one transfer at a time.
        self.forget(source, addressed);
        let fits = pgn == wanted && usize::from(size) == N && count == Self::PACKETS;
        let free = self
            .transfers
            .iter_mut()
            .find(|transfer| !transfer.due.is_set());
        match free.filter(|_| fits) {
            Some(transfer) => {
                *transfer = Transfer {
                    due: Deadline::after(now, if addressed { T2 } else { T1 }),
                    source,
                    addressed,
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
    pub fn data(
        &mut self,
        now: Instant,
        (source, addressed): (u8, bool),
        bytes: [u8; 8],
        pgn: Pgn,
    ) -> Reaction {
        let Some((place, transfer)) = self.find(source, addressed) else {
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

    /// Ends one transfer that has timed out. Returns its abort message if it is to us.
    pub fn poll(&mut self, now: Instant, pgn: Pgn) -> Option<Packet> {
        let mut transfers = self.transfers.iter_mut();
        let expired = transfers.find(|transfer| transfer.due.is_reached(now))?;
        expired.due = Deadline::NEVER;
        expired
            .addressed
            .then(|| abort(expired.source, Reason::TimeOut, pgn))
    }

    /// The time of the next [`poll`](Self::poll).
    pub fn deadline(&self) -> Deadline {
        let mut earliest = Deadline::NEVER;
        for transfer in &self.transfers {
            earliest.consider(transfer.due);
        }
        earliest
    }

    fn find(&mut self, source: u8, addressed: bool) -> Option<(usize, &mut Transfer<N>)> {
        self.transfers.iter_mut().enumerate().find(|(_, transfer)| {
            transfer.due.is_set() && transfer.source == source && transfer.addressed == addressed
        })
    }

    fn forget(&mut self, source: u8, addressed: bool) {
        if let Some((_, transfer)) = self.find(source, addressed) {
            transfer.due = Deadline::NEVER;
        }
    }
}

fn abort(destination: u8, reason: Reason, pgn: Pgn) -> Packet {
    Packet::control(destination, Control::Abort(reason as u8), pgn)
}

#[cfg(test)]
mod tests {
    use super::*;

    const PGN: Pgn = 0xFED8;
    const MESSAGE: [u8; 9] = [1, 2, 3, 4, 5, 6, 7, 8, 9];
    const FIRST: [u8; 8] = [1, 1, 2, 3, 4, 5, 6, 7];
    const SECOND: [u8; 8] = [2, 8, 9, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF];
    const TO_ALL: (u8, bool) = (0x21, false);
    const TO_US: (u8, bool) = (0x21, true);

    fn at(ms: u64) -> Instant {
        Instant::from_ticks(ms * 1000)
    }

    fn bam(pgn: Pgn) -> (Control, Pgn) {
        let control = Control::Broadcast {
            size: 9,
            packets: 2,
        };
        (control, pgn)
    }

    fn rts(limit: u8) -> (Control, Pgn) {
        let control = Control::RequestToSend {
            size: 9,
            packets: 2,
            limit,
        };
        (control, PGN)
    }

    fn answer(control: Control) -> Reaction {
        Reaction::Answer(Packet::control(0x21, control, PGN))
    }

    fn cts(count: u8, next: u8) -> Reaction {
        answer(Control::ClearToSend { count, next })
    }

    fn begun(who: (u8, bool), control: (Control, Pgn)) -> Incoming<9> {
        let mut incoming = Incoming::IDLE;
        incoming.control(at(0), who, control, PGN);
        incoming
    }

    #[test]
    fn message_to_all_is_received_between_messages_of_others() {
        let mut incoming = Incoming::<9>::IDLE;
        for source in 0..100 {
            let other = incoming.control(at(0), (source, false), bam(0xFECA), PGN);
            assert_eq!(other, Reaction::None);
        }
        incoming.control(at(0), TO_ALL, bam(PGN), PGN);
        incoming.data(at(10), (0x22, false), FIRST, PGN);
        assert_eq!(incoming.data(at(20), TO_ALL, FIRST, PGN), Reaction::None);
        incoming.data(at(30), (0x22, false), SECOND, PGN);
        let complete = incoming.data(at(40), TO_ALL, SECOND, PGN);
        assert_eq!(complete, Reaction::Complete(None));
        assert_eq!(incoming.message(), MESSAGE);
        let repeated = incoming.data(at(50), TO_ALL, SECOND, PGN);
        assert_eq!(repeated, Reaction::None);
    }

    #[test]
    fn message_to_us_is_acknowledged() {
        let mut incoming = Incoming::IDLE;
        assert_eq!(incoming.control(at(0), TO_US, rts(255), PGN), cts(2, 1));
        assert_eq!(incoming.data(at(1), TO_US, FIRST, PGN), Reaction::None);
        let end = Control::End {
            size: 9,
            packets: 2,
        };
        let end = Packet::control(0x21, end, PGN);
        let complete = incoming.data(at(2), TO_US, SECOND, PGN);
        assert_eq!(complete, Reaction::Complete(Some(end)));
        assert_eq!(incoming.message(), MESSAGE);
    }

    #[test]
    fn sender_limits_the_packets_of_a_request() {
        let mut incoming = Incoming::IDLE;
        assert_eq!(incoming.control(at(0), TO_US, rts(1), PGN), cts(1, 1));
        assert_eq!(incoming.data(at(1), TO_US, FIRST, PGN), cts(1, 2));
        let complete = incoming.data(at(2), TO_US, SECOND, PGN);
        assert!(matches!(complete, Reaction::Complete(Some(_))));
        assert_eq!(incoming.message(), MESSAGE);
    }

    #[test]
    fn other_messages_to_us_are_aborted() {
        let mut incoming = Incoming::<9>::IDLE;
        let refused = answer(Control::Abort(2));
        for (size, packets) in [(10, 2), (8, 2), (9, 1), (9, 3)] {
            let control = Control::RequestToSend {
                size,
                packets,
                limit: 255,
            };
            assert_eq!(incoming.control(at(0), TO_US, (control, PGN), PGN), refused);
        }
        let (control, _) = rts(255);
        let other = incoming.control(at(0), TO_US, (control, 0xFECA), PGN);
        let abort = Packet::control(0x21, Control::Abort(2), 0xFECA);
        assert_eq!(other, Reaction::Answer(abort));
        for source in 1..=3 {
            incoming.control(at(0), (source, true), rts(255), PGN);
        }
        let busy = incoming.control(at(0), TO_US, rts(255), PGN);
        assert_eq!(busy, answer(Control::Abort(1)));
    }

    #[test]
    fn wrong_packet_number_ends_the_transfer() {
        let mut incoming = begun(TO_ALL, bam(PGN));
        assert_eq!(incoming.data(at(1), TO_ALL, SECOND, PGN), Reaction::None);
        assert_eq!(incoming.data(at(2), TO_ALL, FIRST, PGN), Reaction::None);
        assert_eq!(incoming.data(at(3), TO_ALL, SECOND, PGN), Reaction::None);
        let mut incoming = begun(TO_US, rts(255));
        incoming.data(at(1), TO_US, FIRST, PGN);
        let repeated = incoming.data(at(2), TO_US, FIRST, PGN);
        assert_eq!(repeated, answer(Control::Abort(7)));
        assert_eq!(incoming.data(at(3), TO_US, SECOND, PGN), Reaction::None);
    }

    #[test]
    fn transfer_ends_after_t1_and_t2() {
        let mut incoming = begun(TO_ALL, bam(PGN));
        assert_eq!(incoming.deadline().time(), Some(at(750)));
        assert_eq!(incoming.poll(at(750), PGN), None);
        assert!(!incoming.deadline().is_set());
        let mut incoming = begun(TO_US, rts(255));
        assert_eq!(incoming.poll(at(1249), PGN), None);
        let abort = Packet::control(0x21, Control::Abort(3), PGN);
        assert_eq!(incoming.poll(at(1250), PGN), Some(abort));
        assert_eq!(incoming.data(at(1251), TO_US, FIRST, PGN), Reaction::None);
        let mut incoming = begun(TO_US, rts(255));
        incoming.data(at(1000), TO_US, FIRST, PGN);
        assert_eq!(incoming.deadline().time(), Some(at(1750)));
    }

    #[test]
    fn sender_ends_or_repeats_its_transfer() {
        let mut incoming = begun(TO_US, rts(255));
        incoming.control(at(1), TO_US, (Control::Abort(1), PGN), PGN);
        assert_eq!(incoming.data(at(2), TO_US, FIRST, PGN), Reaction::None);
        let mut incoming = begun(TO_ALL, bam(PGN));
        incoming.data(at(1), TO_ALL, FIRST, PGN);
        incoming.control(at(2), TO_ALL, bam(PGN), PGN);
        incoming.data(at(3), TO_ALL, FIRST, PGN);
        let complete = incoming.data(at(4), TO_ALL, SECOND, PGN);
        assert_eq!(complete, Reaction::Complete(None));
        assert_eq!(incoming.message(), MESSAGE);
        // Another message of the same sender.
        let mut incoming = begun(TO_ALL, bam(PGN));
        incoming.control(at(2), TO_ALL, bam(0xFECA), PGN);
        assert!(!incoming.deadline().is_set());
    }
}
