//! Sends a message: to one node (RTS/CTS), or to all nodes (BAM).

use super::{BAM_INTERVAL, Control, PACKET, Packet, Reason, T3, T4, packets};
use crate::j1939::identifier::{GLOBAL, Pgn};
use crate::time::{Deadline, Instant};

/// The length of the longest message.
pub const MESSAGE: usize = 80;

/// The bytes of a message that this node sends.
pub type Message = heapless::Vec<u8, MESSAGE>;

/// The progress of a transfer.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
#[repr(u8)] // idle is 0, so that it needs no flash in static memory
enum Stage {
    /// No message is being sent.
    Idle,
    /// RTS or BAM must be sent.
    Announce,
    /// The receiver must answer with CTS or the end of message acknowledgement.
    Wait,
    /// Packets of data are sent.
    Send {
        /// The number of the next packet.
        next: u8,
        /// The number of the last packet that the receiver permits.
        last: u8,
    },
}

/// The transfer of a message.
#[derive(Clone, Debug)]
pub struct Outgoing {
    stage: Stage,
    destination: u8,
    pgn: Pgn,
    /// The time of the next packet to all nodes, or of a time-out. In a transfer to all nodes it is not set while the previous packet waits
    /// for the bus.
    due: Deadline,
    message: Message,
}

impl Outgoing {
    /// No transfer. All bits are 0.
    pub const IDLE: Self = Self {
        stage: Stage::Idle,
        destination: 0,
        pgn: 0,
        due: Deadline::NEVER,
        message: Message::new(),
    };

    /// Begins to send a message to a node, or to [`GLOBAL`].
    pub fn begin(&mut self, destination: u8, pgn: Pgn, message: Message) {
        self.stage = Stage::Announce;
        self.destination = destination;
        self.pgn = pgn;
        self.due = Deadline::NEVER;
        self.message = message;
    }

    /// Ends the transfer without a message.
    pub fn end(&mut self) {
        self.stage = Stage::Idle;
        self.due = Deadline::NEVER;
    }

    /// Whether a transfer is in progress.
    pub fn is_active(&self) -> bool {
        self.stage != Stage::Idle
    }

    /// The group of the message, also after its end.
    pub fn pgn(&self) -> Pgn {
        self.pgn
    }

    /// Whether a transfer of this group is in progress.
    pub fn is_of(&self, pgn: Pgn) -> bool {
        self.is_active() && self.pgn == pgn
    }

    /// Whether a transfer to this node is in progress.
    pub fn is_to(&self, destination: u8) -> bool {
        self.is_active() && self.destination == destination
    }

    /// Whether [`next`](Self::next) has a frame as soon as there is room.
    pub fn is_pending(&self) -> bool {
        match self.stage {
            Stage::Announce => true,
            Stage::Send { .. } => self.destination != GLOBAL,
            Stage::Idle | Stage::Wait => false,
        }
    }

    /// The time of the next frame that does not depend on room, or of a time-out.
    pub fn deadline(&self) -> Deadline {
        self.due
    }

    /// Handles a TP.CM message to us.
    pub fn receive(&mut self, now: Instant, source: u8, control: Control, pgn: Pgn) {
        let is_ours = self.destination == source && self.pgn == pgn && source != GLOBAL;
        if !is_ours || matches!(self.stage, Stage::Idle | Stage::Announce) {
            return;
        }
        match control {
            Control::ClearToSend { count: 0, .. } => {
                self.stage = Stage::Wait;
                self.due = Deadline::after(now, T4);
            }
            Control::ClearToSend { count, next } => {
                if (1..=self.packets()).contains(&next) {
                    // More packets than remain: those that remain.
                    let last = next.saturating_add(count - 1).min(self.packets());
                    self.stage = Stage::Send { next, last };
                    self.due = Deadline::NEVER;
                }
            }
            Control::End { .. } | Control::Abort(_) => self.end(),
            Control::RequestToSend { .. } | Control::Broadcast { .. } => {}
        }
    }

    /// All frames are on their way: begins the time before the next packet to all nodes, or in which the receiver must answer. Returns
    /// true if a time has begun.
    pub fn sent(&mut self, now: Instant) -> bool {
        let time = match self.stage {
            Stage::Send { .. } if self.destination == GLOBAL => BAM_INTERVAL,
            Stage::Wait => T3,
            _ => return false,
        };
        let begins = !self.due.is_set();
        if begins {
            self.due = Deadline::after(now, time);
        }
        begins
    }

    /// The next frame to send, if there is one now. [`sent`](Self::sent) must follow.
    pub fn next(&mut self, now: Instant) -> Option<Packet> {
        let is_global = self.destination == GLOBAL;
        match self.stage {
            Stage::Announce => {
                let (size, packets) = (self.message.len() as u16, self.packets());
                let control = if is_global {
                    self.stage = Stage::Send {
                        next: 1,
                        last: packets,
                    };
                    self.due = Deadline::NEVER;
                    Control::Broadcast { size, packets }
                } else {
                    self.wait();
                    Control::RequestToSend {
                        size,
                        packets,
                        limit: u8::MAX,
                    }
                };
                Some(self.control(control))
            }
            Stage::Send { next, last } if !is_global || self.due.is_reached(now) => {
                let packet = self.packet(next);
                match (next < last, is_global) {
                    (true, _) => {
                        self.stage = Stage::Send {
                            next: next + 1,
                            last,
                        };
                        self.due = Deadline::NEVER;
                    }
                    (false, true) => self.end(),
                    (false, false) => self.wait(),
                }
                Some(packet)
            }
            Stage::Wait if self.due.is_reached(now) => {
                self.end();
                Some(self.control(Control::Abort(Reason::TimeOut as u8)))
            }
            _ => None,
        }
    }

    /// Waits for an answer. Its time begins when the frame is sent.
    fn wait(&mut self) {
        self.stage = Stage::Wait;
        self.due = Deadline::NEVER;
    }

    fn packets(&self) -> u8 {
        packets(self.message.len())
    }

    fn control(&self, control: Control) -> Packet {
        Packet::control(self.destination, control, self.pgn)
    }

    /// A packet, counted from 1.
    fn packet(&self, number: u8) -> Packet {
        let mut bytes = [0xFF; 8];
        let first = PACKET * usize::from(number.saturating_sub(1));
        let rest = self.message.get(first..).unwrap_or(&[]);
        if let Some((place, data)) = bytes.split_first_mut() {
            *place = number;
            for (to, from) in data.iter_mut().zip(rest) {
                *to = *from;
            }
        }
        Packet {
            is_control: false,
            destination: self.destination,
            bytes,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::string::String;
    use std::vec::Vec;

    const PGN: Pgn = 0xFEEB;

    fn at(ms: u64) -> Instant {
        Instant::from_ticks(ms * 1000)
    }

    fn sending(destination: u8) -> Outgoing {
        let mut outgoing = Outgoing::IDLE;
        let message = Message::from_slice(b"Plumbline*IMS360*1**").unwrap();
        outgoing.begin(destination, PGN, message);
        outgoing
    }

    fn all(outgoing: &mut Outgoing, now: Instant) -> Vec<String> {
        let frames = std::iter::from_fn(|| outgoing.next(now));
        frames
            .map(|packet| std::format!("{:?}", packet.frame(0x80)))
            .collect()
    }

    fn cts(count: u8, next: u8) -> Control {
        Control::ClearToSend { count, next }
    }

    const PACKETS: [&str; 3] = [
        "1CEB2180#01506C756D626C69",
        "1CEB2180#026E652A494D5333",
        "1CEB2180#0336302A312A2AFF",
    ];

    #[test]
    fn packets_to_all_begin_60_ms_after_the_one_before_is_sent() {
        let mut outgoing = sending(GLOBAL);
        assert!(outgoing.is_pending() && !outgoing.sent(at(0)));
        assert_eq!(all(&mut outgoing, at(0)), ["1CECFF80#20140003FFEBFE00"]);
        assert!(!outgoing.is_pending());
        for (place, packet) in PACKETS.iter().enumerate() {
            let sent = 72 * (place as u64) + 12;
            let due = sent + 60;
            assert_eq!(all(&mut outgoing, at(sent)), Vec::<String>::new());
            assert!(!outgoing.deadline().is_set());
            assert!(outgoing.sent(at(sent)) && !outgoing.sent(at(sent + 1)));
            assert_eq!(all(&mut outgoing, at(due - 1)), Vec::<String>::new());
            assert_eq!(outgoing.deadline().time(), Some(at(due)));
            let expected = packet.replace("EB21", "EBFF");
            assert_eq!(all(&mut outgoing, at(due)), [expected]);
        }
        assert!(!outgoing.is_active() && !outgoing.deadline().is_set());
        assert!(!outgoing.sent(at(999)));
    }

    #[test]
    fn receiver_requests_all_packets_at_once() {
        let mut outgoing = sending(0x21);
        assert_eq!(all(&mut outgoing, at(0)), ["1CEC2180#10140003FFEBFE00"]);
        outgoing.receive(at(10), 0x21, cts(3, 1), PGN);
        assert!(outgoing.is_pending());
        assert_eq!(all(&mut outgoing, at(10)), PACKETS);
        let end = Control::End {
            size: 20,
            packets: 3,
        };
        outgoing.receive(at(20), 0x21, end, PGN);
        assert!(!outgoing.is_active());
        assert_eq!(all(&mut outgoing, at(9999)), Vec::<String>::new());
    }

    #[test]
    fn receiver_requests_packets_again_and_backwards() {
        let mut outgoing = sending(0x21);
        all(&mut outgoing, at(0));
        for (count, next) in [(1, 1), (2, 2), (1, 2), (1, 1), (1, 3)] {
            outgoing.receive(at(10), 0x21, cts(count, next), PGN);
            let first = usize::from(next) - 1;
            let expected = &PACKETS[first..first + usize::from(count)];
            assert_eq!(all(&mut outgoing, at(10)), expected);
        }
    }

    #[test]
    fn request_for_more_packets_than_remain_gets_those_that_remain() {
        for (count, next) in [(4, 1), (255, 1), (3, 2), (255, 3), (2, 3)] {
            let mut outgoing = sending(0x21);
            all(&mut outgoing, at(0));
            outgoing.receive(at(1), 0x21, cts(count, next), PGN);
            let expected = &PACKETS[usize::from(next) - 1..];
            assert_eq!(all(&mut outgoing, at(1)), expected, "{count} {next}");
        }
    }

    #[test]
    fn request_from_a_packet_that_does_not_exist_is_ignored() {
        let mut outgoing = sending(0x21);
        all(&mut outgoing, at(0));
        assert!(outgoing.sent(at(0)));
        outgoing.receive(at(1), 0x22, cts(3, 1), PGN);
        outgoing.receive(at(1), 0x21, cts(3, 1), PGN + 1);
        for (count, next) in [(1, 4), (3, 4), (1, 0), (255, 0), (255, 255)] {
            outgoing.receive(at(1), 0x21, cts(count, next), PGN);
        }
        assert_eq!(all(&mut outgoing, at(1)), Vec::<String>::new());
        assert_eq!(outgoing.deadline().time(), Some(at(1250)));
    }

    #[test]
    fn receiver_that_is_silent_is_aborted_after_t3() {
        let abort = ["1CEC2180#FF03FFFFFFEBFE00"];
        let mut outgoing = sending(0x21);
        all(&mut outgoing, at(0));
        // The time begins when the frame is sent.
        assert!(outgoing.sent(at(7)) && !outgoing.sent(at(9)));
        assert_eq!(all(&mut outgoing, at(1256)), Vec::<String>::new());
        assert_eq!(all(&mut outgoing, at(1257)), abort);
        assert!(!outgoing.is_active());
        let mut outgoing = sending(0x21);
        all(&mut outgoing, at(0));
        outgoing.receive(at(1000), 0x21, cts(1, 1), PGN);
        assert_eq!(all(&mut outgoing, at(1000)), [PACKETS[0]]);
        assert!(outgoing.sent(at(1001)));
        assert_eq!(all(&mut outgoing, at(2250)), Vec::<String>::new());
        assert_eq!(all(&mut outgoing, at(2251)), abort);
    }

    #[test]
    fn receiver_holds_the_connection_for_t4() {
        let mut outgoing = sending(0x21);
        all(&mut outgoing, at(0));
        for time in [1000, 2000, 3000] {
            outgoing.receive(at(time), 0x21, cts(0, 255), PGN);
            assert_eq!(all(&mut outgoing, at(time + 1049)), Vec::<String>::new());
        }
        assert_eq!(all(&mut outgoing, at(4050)), ["1CEC2180#FF03FFFFFFEBFE00"]);
    }

    #[test]
    fn receiver_aborts() {
        let mut outgoing = sending(0x21);
        all(&mut outgoing, at(0));
        outgoing.receive(at(1), 0x22, Control::Abort(1), PGN);
        assert!(outgoing.is_to(0x21) && !outgoing.is_to(0x22));
        outgoing.receive(at(1), 0x21, Control::Abort(1), PGN);
        assert!(!outgoing.is_active());
    }
}
