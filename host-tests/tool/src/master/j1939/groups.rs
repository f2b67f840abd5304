//! J1939: the nodes on the bus, requests for groups, and Commanded Address.
//!
//! ```text
//!  18EAFFFE   00 EE 00                        who is there? From 254, so it needs no address
//!  18EA<node><own>   PGN                      request for a group
//!  18E8FF<node>   01 FF FF FF <own> PGN       it is not supported
//!  18EEFF<node>   NAME                        address claimed
//! ```
//!
//! - [`own`]: the address of the tool. It is claimed before the first frame that must have one
//! - [`transport`]: messages of more than eight bytes

pub mod own;
pub mod transport;

use crate::error::{Error, SensorError};
use crate::link::Link;
use plumbline::can::Frame;
use plumbline::j1939::identifier::{
    ACKNOWLEDGEMENT, ADDRESS_CLAIMED, COMMANDED_ADDRESS, GLOBAL, Identifier, NO_ADDRESS, Pgn,
    REQUEST, pgn_bytes,
};
use plumbline::j1939::name::Name;
use plumbline::j1939::request::{refused, request};
use plumbline::j1939::transport::{Message, Outgoing};
use plumbline::time::{Duration, after, millis};
use transport::Opening;

/// The wait for the answer to a request: a node must answer within 200 ms.
pub const ANSWER: Duration = millis(300);

/// The wait for the claims of all nodes.
const CLAIMS: Duration = millis(250);

/// The wait between two looks whether the next packet of a message to all nodes is due.
const STEP: Duration = millis(5);

/// The answer to a request for a group.
#[derive(Clone, PartialEq, Eq, Debug)]
pub enum Answer {
    /// The data of the group.
    Data(Vec<u8>),
    /// The node does not support it, or cannot send it now.
    Refused,
    /// There is no answer in time.
    Silent,
}

/// Address and NAME in a claim. A node without address claims 254.
fn claim(frame: &Frame) -> Option<(u8, Name)> {
    let id = Identifier::of(frame).filter(|id| id.pgn == ADDRESS_CLAIMED)?;
    let name = frame.bytes().try_into().ok()?;
    Some((id.source, Name::from_bytes(name)))
}

/// The nodes with an address, in the order of their claims.
///
/// # Errors
/// The adapter fails, or the user wants to stop.
pub fn nodes(link: &mut Link) -> Result<Vec<(u8, Name)>, Error> {
    let mut nodes = Vec::new();
    let source = link.source();
    let question = request(ADDRESS_CLAIMED, GLOBAL, source);
    link.ask(&question, CLAIMS, |frame| {
        let claim = claim(frame).filter(|(address, _)| *address < NO_ADDRESS);
        nodes.extend(claim.filter(|claim| !nodes.contains(claim)));
        None::<()>
    })?;
    Ok(nodes)
}

/// The NAME of the node with this address; None: nobody has it.
///
/// # Errors
/// The adapter fails, or the user wants to stop.
pub fn name(link: &mut Link, address: u8, time: Duration) -> Result<Option<Name>, Error> {
    let source = link.source();
    let question = request(ADDRESS_CLAIMED, address, source);
    link.ask(&question, time, |frame| {
        let claim = claim(frame).filter(|(own, _)| *own == address);
        claim.map(|(_, name)| name)
    })
}

/// The first part of the answer to a request.
enum First {
    Data(Vec<u8>),
    Refused,
    Long(Opening),
}

/// Requests a group of a node.
///
/// # Errors
/// The tool finds no address for itself, the adapter fails, or the user wants to stop.
pub fn get(link: &mut Link, node: u8, pgn: Pgn) -> Result<Answer, Error> {
    let own = link.own_address()?;
    let judge = |frame: &Frame| {
        let id = Identifier::of(frame).filter(|id| id.source == node)?;
        if ![own, GLOBAL].contains(&id.destination) {
            return None;
        }
        if id.pgn == pgn {
            return Some(First::Data(frame.bytes().to_vec()));
        }
        if id.pgn == ACKNOWLEDGEMENT {
            let is_ours = refused(frame.bytes(), own) == Some(pgn);
            return is_ours.then_some(First::Refused);
        }
        let opening = Opening::of(frame)?;
        (opening.pgn == pgn).then_some(First::Long(opening))
    };
    match link.ask(&request(pgn, node, own), ANSWER, judge)? {
        Some(First::Data(data)) => Ok(Answer::Data(data)),
        Some(First::Refused) => Ok(Answer::Refused),
        Some(First::Long(opening)) => {
            let message = transport::receive(link, opening, own)?;
            Ok(message.map_or(Answer::Silent, Answer::Data))
        }
        None => Ok(Answer::Silent),
    }
}

/// Gives the node with a NAME another address (Commanded Address, a message of nine bytes to all). Returns the address at which it
/// claims within a second; None: it does not.
///
/// # Errors
/// The tool finds no address for itself, the adapter fails, or the user wants to stop.
pub fn command_address(link: &mut Link, node: Name, new: u8) -> Result<Option<u8>, Error> {
    const CLAIMED: Duration = millis(1000);
    let own = link.own_address()?;
    let is_claim = |frame: &Frame| {
        let claim = claim(frame).filter(|(_, name)| *name == node);
        claim.map(|(address, _)| address)
    };
    let name = node.to_bytes();
    let message: Message = name.into_iter().chain([new]).collect();
    let mut outgoing = Outgoing::IDLE;
    outgoing.begin(GLOBAL, COMMANDED_ADDRESS, message);
    while outgoing.is_active() {
        if let Some(packet) = outgoing.next(link.now()) {
            let frame = packet.frame(own);
            if !outgoing.is_active() {
                return link.ask(&frame, CLAIMED, is_claim);
            }
            link.send(&frame)?;
            outgoing.sent(link.now());
        }
        link.wait_for(STEP, |_| None::<()>)?;
    }
    Ok(None)
}

/// The data of a group in a frame of a node; None: it is another frame.
pub fn group(frame: &Frame, node: u8, pgn: Pgn) -> Option<&[u8]> {
    let id = Identifier::of(frame)?;
    (id.source == node && id.pgn == pgn).then(|| frame.bytes())
}

/// Whether a frame is the claim of a node, which it also sends when it is switched on.
pub fn is_claim_of(frame: &Frame, node: u8) -> bool {
    claim(frame).is_some_and(|(address, _)| address == node)
}

/// Whether a frame requests the claim of a node, or of all nodes.
pub fn is_request_for_claim(frame: &Frame, node: u8) -> bool {
    let is_to = |id: Identifier| id.pgn == REQUEST && [node, GLOBAL].contains(&id.destination);
    Identifier::of(frame).is_some_and(is_to) && frame.bytes() == pgn_bytes(ADDRESS_CLAIMED)
}

impl Link {
    /// The source of a request for claims: the address of the tool, or none.
    fn source(&self) -> u8 {
        let own = self.own.as_ref().and_then(own::Own::address);
        own.unwrap_or(NO_ADDRESS)
    }

    /// The J1939 address of the tool. The first call finds the nodes on the bus, and claims an address that no node uses.
    ///
    /// # Errors
    /// There is no free address, the adapter fails, or the user wants to stop.
    pub fn own_address(&mut self) -> Result<u8, Error> {
        if let Some(address) = self.own.as_ref().and_then(own::Own::address) {
            return Ok(address);
        }
        // After a contention, the claim for another address runs already.
        if self.own.is_none() {
            let used: Vec<u8> = nodes(self)?.iter().map(|(address, _)| *address).collect();
            let own = own::Own::new(self.now(), &used);
            self.send(&own.claim())?;
            self.own = Some(own);
        }
        let end = after(self.now(), own::LONGEST);
        while self.now() < end {
            let until = after(self.now(), own::STEP);
            self.receive(until)?;
            let now = self.now();
            let Some(own) = &mut self.own else {
                break;
            };
            match own.poll(now) {
                Some(address) => return Ok(address),
                None if own.has_lost() => break,
                None => {}
            }
        }
        self.own = None;
        Err(SensorError::NoOwnAddress.into())
    }
}

#[cfg(test)]
mod tests;
