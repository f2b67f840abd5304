//! Messages of more than eight bytes (SAE J1939-21, 5.10): receives one that was announced.
//!
//! ```text
//!  7 EC<dst><src>   10 size size packets limit PGN      request to send, to us
//!                   20 size size packets FF PGN         announcement, to all
//!                   11 packets first FF FF PGN          clear to send
//!                   13 size size packets FF PGN         all received
//!  7 EB<dst><src>   number data x 7                     a packet; the last one is filled with FF
//! ```

use crate::error::Error;
use crate::link::Link;
use plumbline::can::Frame;
use plumbline::j1939::identifier::{GLOBAL, Identifier, Pgn, TRANSPORT_CONTROL, TRANSPORT_DATA};
use plumbline::j1939::transport::{Control, PACKET, Packet, Reason, T1, T2};

/// A message that was announced.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Opening {
    /// The parameter group of the message.
    pub pgn: Pgn,
    source: u8,
    size: usize,
    packets: u8,
    /// It is sent to all nodes, so that nobody asks for the packets.
    is_broadcast: bool,
}

impl Opening {
    /// The announcement in a frame.
    pub fn of(frame: &Frame) -> Option<Self> {
        let id = Identifier::of(frame).filter(|id| id.pgn == TRANSPORT_CONTROL)?;
        let (control, pgn) = Control::parse(frame.bytes().try_into().ok()?)?;
        let (size, packets, is_broadcast) = match control {
            Control::RequestToSend { size, packets, .. } if id.destination != GLOBAL => {
                (size, packets, false)
            }
            Control::Broadcast { size, packets } if id.destination == GLOBAL => {
                (size, packets, true)
            }
            _ => return None,
        };
        let size = usize::from(size);
        (size.div_ceil(PACKET) == usize::from(packets) && size > 0).then_some(Self {
            pgn,
            source: id.source,
            size,
            packets,
            is_broadcast,
        })
    }
}

fn control(control: Control, pgn: Pgn, destination: u8, own: u8) -> Frame {
    Packet::control(destination, control, pgn).frame(own)
}

/// Receives a message that was announced to `own` or to all; None: it was not complete.
///
/// # Errors
/// The adapter fails, or the user wants to stop.
pub fn receive(link: &mut Link, opening: Opening, own: u8) -> Result<Option<Vec<u8>>, Error> {
    let Opening {
        pgn,
        source,
        size,
        packets,
        is_broadcast,
    } = opening;
    let destination = if is_broadcast { GLOBAL } else { own };
    let data = |frame: &Frame| -> Option<[u8; 8]> {
        let id = Identifier::of(frame)?;
        let is_own = id.pgn == TRANSPORT_DATA && id.source == source;
        let is_own = is_own && id.destination == destination;
        frame.bytes().try_into().ok().filter(|_| is_own)
    };
    let mut message = Vec::new();
    for number in 1..=packets {
        let received = match (number, is_broadcast) {
            (1, false) => {
                let clear = Control::ClearToSend {
                    count: packets,
                    next: 1,
                };
                link.ask(&control(clear, pgn, source, own), T2, data)?
            }
            _ => link.wait_for(T1, data)?,
        };
        let reason = match received {
            Some([own, part @ ..]) if own == number => {
                message.extend_from_slice(&part);
                continue;
            }
            Some(_) => Reason::Sequence,
            None => Reason::TimeOut,
        };
        if !is_broadcast {
            link.send(&control(Control::Abort(reason as u8), pgn, source, own))?;
        }
        return Ok(None);
    }
    message.truncate(size);
    if !is_broadcast {
        let end = Control::End {
            size: size as u16,
            packets,
        };
        link.send(&control(end, pgn, source, own))?;
    }
    Ok(Some(message))
}
