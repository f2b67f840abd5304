//! The transport protocol: messages of more than eight bytes (SAE J1939-21, 5.10).
//!
//! ```text
//!  TP.CM (60416)  byte 0         1         2         3         4         5              8
//!                      +---------+---------+---------+---------+---------+--------------+
//!                      | 10h RTS | size              | packets | per CTS | PGN          |
//!                      | 11h CTS | packets | next    | FF      | FF      | PGN          |
//!                      | 13h end | size              | packets | FF      | PGN          |
//!                      | 20h BAM | size              | packets | FF      | PGN          |
//!                      | FFh     | reason  | FF      | FF      | FF      | PGN          |
//!                      +---------+---------+---------+---------+---------+--------------+
//!
//!  TP.DT (60160)  byte 0         1                                                      8
//!                      +---------+------------------------------------------------------+
//!                      | number  | 7 bytes of the message, unused bytes are FF          |
//!                      +---------+------------------------------------------------------+
//! ```
//!
//! Packets count from 1. All frames have priority 7.
//!
//! - [`Outgoing`]: a message to one node (RTS/CTS) or to all nodes (BAM);
//! - [`Incoming`]: the messages of one group to this node.

mod incoming;
mod outgoing;

pub use incoming::{Incoming, Reaction, Sender};
pub use outgoing::{MESSAGE, Message, Outgoing};

use super::identifier::{Identifier, Pgn, TRANSPORT_CONTROL, TRANSPORT_DATA, pgn_bytes, pgn_of};
use crate::can::Frame;
use crate::time::{Duration, millis};

/// The priority of all frames of the transport protocol.
const PRIORITY: u8 = 7;

/// Bytes of the message in a packet.
pub const PACKET: usize = 7;

/// The longest time between two received packets.
pub const T1: Duration = millis(750);
/// The longest time from our CTS to the next packet.
pub const T2: Duration = millis(1250);
/// The longest time from our RTS or our last packet to the next CTS, or to the end.
pub const T3: Duration = millis(1250);
/// The longest time from a CTS that holds the connection to the next CTS.
pub const T4: Duration = millis(1050);
/// The time from the transmission of a packet of a BAM to the next packet. 50 to 200 ms are permitted.
pub const BAM_INTERVAL: Duration = millis(60);

/// The reason of an abort.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
#[repr(u8)]
pub enum Reason {
    /// The node has a connection already.
    Busy = 1,
    /// The node has no room for the message.
    Resources = 2,
    /// The next packet or CTS did not come in time.
    TimeOut = 3,
    /// A packet has a wrong number.
    Sequence = 7,
}

/// A message of the connection management (TP.CM).
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Control {
    /// RTS: the sender begins a transfer to one node.
    RequestToSend {
        /// The size of the message in bytes.
        size: u16,
        /// The number of packets of the message.
        packets: u8,
        /// The maximum number of packets that one CTS may request.
        limit: u8,
    },
    /// CTS: the receiver permits the next packets.
    ClearToSend {
        /// The number of requested packets; 0 holds the connection.
        count: u8,
        /// The number of the first one.
        next: u8,
    },
    /// End of message acknowledgement: the receiver has the whole message.
    End {
        /// The size of the message in bytes.
        size: u16,
        /// The number of packets of the message.
        packets: u8,
    },
    /// BAM: the sender begins a transfer to all nodes.
    Broadcast {
        /// The size of the message in bytes.
        size: u16,
        /// The number of packets of the message.
        packets: u8,
    },
    /// Connection abort. The reason of another node is not used.
    Abort(u8),
}

impl Control {
    /// The message in eight bytes, and the PGN of its transfer.
    pub fn parse(bytes: [u8; 8]) -> Option<(Self, Pgn)> {
        let [control, a, b, c, d, pgn @ ..] = bytes;
        let size = u16::from_le_bytes([a, b]);
        let control = match control {
            0x10 => Self::RequestToSend {
                size,
                packets: c,
                limit: d,
            },
            0x11 => Self::ClearToSend { count: a, next: b },
            0x13 => Self::End { size, packets: c },
            0x20 => Self::Broadcast { size, packets: c },
            0xFF => Self::Abort(a),
            _ => return None,
        };
        Some((control, pgn_of(pgn)))
    }

    /// The eight bytes of the message.
    pub fn bytes(self, pgn: Pgn) -> [u8; 8] {
        let sized = |control: u8, size: u16, packets: u8, limit: u8| {
            let [low, high] = size.to_le_bytes();
            [control, low, high, packets, limit]
        };
        let [a, b, c, d, e] = match self {
            Self::RequestToSend {
                size,
                packets,
                limit,
            } => sized(0x10, size, packets, limit),
            Self::ClearToSend { count, next } => [0x11, count, next, 0xFF, 0xFF],
            Self::End { size, packets } => sized(0x13, size, packets, 0xFF),
            Self::Broadcast { size, packets } => sized(0x20, size, packets, 0xFF),
            Self::Abort(reason) => [0xFF, reason, 0xFF, 0xFF, 0xFF],
        };
        let [low, middle, high] = pgn_bytes(pgn);
        [a, b, c, d, e, low, middle, high]
    }
}

/// A frame of a transfer, without its source address.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Packet {
    /// Whether it is a TP.CM message; otherwise it is a packet of data (TP.DT).
    pub is_control: bool,
    /// The address of the receiver, or [`GLOBAL`](super::identifier::GLOBAL).
    pub destination: u8,
    /// The eight bytes of the frame.
    pub bytes: [u8; 8],
}

impl Packet {
    /// A TP.CM message to a node.
    pub fn control(destination: u8, control: Control, pgn: Pgn) -> Self {
        Self {
            is_control: true,
            destination,
            bytes: control.bytes(pgn),
        }
    }

    /// The frame from this address.
    pub fn frame(&self, source: u8) -> Frame {
        let pgn = if self.is_control {
            TRANSPORT_CONTROL
        } else {
            TRANSPORT_DATA
        };
        Identifier::new(pgn, self.destination, source)
            .with_priority(PRIORITY)
            .frame(self.bytes)
    }
}

/// The number of packets of a message.
const fn packets(size: usize) -> u8 {
    size.div_ceil(PACKET) as u8
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn control_messages_have_their_bytes() {
        let rows = [
            (
                Control::RequestToSend {
                    size: 20,
                    packets: 3,
                    limit: 255,
                },
                [0x10, 0x14, 0x00, 0x03, 0xFF],
            ),
            (
                Control::ClearToSend { count: 3, next: 1 },
                [0x11, 3, 1, 0xFF, 0xFF],
            ),
            (
                Control::End {
                    size: 0x0114,
                    packets: 3,
                },
                [0x13, 0x14, 0x01, 0x03, 0xFF],
            ),
            (
                Control::Broadcast {
                    size: 20,
                    packets: 3,
                },
                [0x20, 0x14, 0x00, 0x03, 0xFF],
            ),
            (Control::Abort(3), [0xFF, 3, 0xFF, 0xFF, 0xFF]),
        ];
        for (control, [a, b, c, d, e]) in rows {
            let bytes = [a, b, c, d, e, 0xEB, 0xFE, 0x00];
            assert_eq!(control.bytes(0xFEEB), bytes);
            assert_eq!(Control::parse(bytes), Some((control, 0xFEEB)));
        }
        assert_eq!(Control::parse([0x12; 8]), None);
    }

    #[test]
    fn frames_have_priority_7() {
        let packet = Packet::control(0x21, Control::Abort(3), 0xFEEB);
        let text = std::format!("{:?}", packet.frame(0x80));
        assert_eq!(text, "1CEC2180#FF03FFFFFFEBFE00");
        let data = Packet {
            is_control: false,
            ..packet
        };
        let text = std::format!("{:?}", data.frame(0x80));
        assert!(text.starts_with("1CEB2180#"), "{text}");
    }
}
