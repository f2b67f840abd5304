//! CANopen SDO client: expedited and segmented transfers (CiA 301, 7.2.4.3). A sensor in J1939 has the same bytes in group EF00h.
//!
//! ```text
//!  600h + node         request         580h + node         answer
//!  18EF<node><own>     request         .EF<own><node>      answer of a J1939 node
//!
//!  byte 0              1..2     3          4..7
//!  40h read            index    sub-index
//!  2Fh/2Bh/23h write   index    sub-index  1, 2 or 4 bytes
//!  21h write           index    sub-index  length         then segments: 0tn0c + 7 bytes
//!  80h abort           index    sub-index  abort code
//! ```

mod download;
mod reasons;

use crate::error::{Error, Refusal, SensorError, Silence, What};
use crate::link::Link;
use plumbline::can::{CanId, Frame};
use plumbline::canopen::Abort;
use plumbline::canopen::cob_id::{SDO_REPLY, SDO_REQUEST};
use plumbline::j1939::identifier::{Identifier, PROPRIETARY_A};
use plumbline::time::{Duration, millis};

use reasons::next_step;
pub(crate) use reasons::reason;

/// The wait for an answer.
pub const ANSWER: Duration = millis(500);

/// The wait for the answer to "save", which comes when the memory is written.
pub const SAVED: Duration = millis(3000);

/// The command of an abort.
const ABORT: u8 = 0x80;

/// The abort code of a request that the present state of the device forbids.
const WRONG_STATE: u32 = Abort::DeviceState as u32;

/// The longest text or record that is read, in bytes.
const LONGEST: usize = 4096;

/// The number of times a value is put back.
const TRIES: u8 = 3;

/// An answer of the server.
#[derive(Clone, PartialEq, Eq, Debug)]
pub enum Answer<T> {
    /// The transfer is complete.
    Done(T),
    /// The server aborted the transfer with this code.
    Aborted(u32),
    /// There is no answer in time.
    Silent,
}

impl<T> Answer<T> {
    /// The result of a transfer that must succeed; `what` names the object for the message.
    ///
    /// # Errors
    /// It was aborted, or nobody answers.
    pub fn must(self, peer: impl Into<Peer>, what: What) -> Result<T, Error> {
        match self {
            Self::Done(done) => Ok(done),
            Self::Aborted(code @ WRONG_STATE) => {
                Err(SensorError::WrongState(what, reason(code), code, next_step(code)).into())
            }
            Self::Aborted(code) => {
                Err(Refusal::Sdo(what, reason(code), code, next_step(code)).into())
            }
            Self::Silent => Err(match peer.into() {
                Peer::Node(node) => Silence::Node(node).into(),
                Peer::Address(address) => Silence::J1939Node(address).into(),
                Peer::Bootloader(..) => Silence::Bootloader.into(),
            }),
        }
    }
}

/// The node of an SDO server.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Peer {
    /// A CANopen node, with its node-ID, 1 to 127.
    Node(u8),
    /// A J1939 node, with its address, 0 to 253.
    Address(u8),
    /// A bootloader, with the identifiers of its requests and its replies.
    Bootloader(CanId, CanId),
}

impl From<u8> for Peer {
    fn from(node: u8) -> Self {
        Self::Node(node)
    }
}

impl From<Server> for Peer {
    fn from(server: Server) -> Self {
        server.peer
    }
}

/// The identifier of an answer.
enum Reply {
    Node(CanId),
    Address(Identifier),
}

/// The SDO server of a node, and how long to wait for it.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Server {
    /// The node, and how it is addressed.
    pub peer: Peer,
    /// The wait for each answer.
    pub time: Duration,
}

impl Server {
    /// The server of a CANopen node.
    pub const fn of(node: u8) -> Self {
        Self {
            peer: Peer::Node(node),
            time: ANSWER,
        }
    }

    /// The server of a J1939 node.
    pub const fn j1939(address: u8) -> Self {
        Self {
            peer: Peer::Address(address),
            time: ANSWER,
        }
    }

    /// The server of a bootloader.
    pub const fn bootloader(request: CanId, reply: CanId) -> Self {
        Self {
            peer: Peer::Bootloader(request, reply),
            time: ANSWER,
        }
    }

    /// The same with the wait for an answer that comes when the memory is written.
    pub const fn patient(self) -> Self {
        Self {
            time: SAVED,
            ..self
        }
    }

    /// The identifier of requests, and the identifiers of answers. In J1939 an answer can have any priority.
    fn identifiers(
        self,
        link: &mut Link,
    ) -> Result<(CanId, impl Fn(&Frame) -> bool + use<>), Error> {
        let (request, answer) = match self.peer {
            Peer::Node(node) => {
                let node = u16::from(node);
                let [request, answer] =
                    [SDO_REQUEST, SDO_REPLY].map(|base| CanId::standard(base + node));
                (request, Reply::Node(answer))
            }
            Peer::Bootloader(request, answer) => (request, Reply::Node(answer)),
            Peer::Address(address) => {
                let own = link.own_address()?;
                let request = Identifier::new(PROPRIETARY_A, address, own).can_id();
                let answer = Identifier::new(PROPRIETARY_A, own, address);
                (request, Reply::Address(answer))
            }
        };
        Ok((request, move |frame: &Frame| match answer {
            Reply::Node(id) => frame.can_id() == id,
            Reply::Address(id) => {
                Identifier::of(frame).is_some_and(|own| own.with_priority(0) == id.with_priority(0))
            }
        }))
    }

    /// Sends a request and returns its answer. An answer that belongs to another request, which came late, is ignored.
    fn ask(
        self,
        link: &mut Link,
        bytes: [u8; 8],
        is_own: impl Fn(&[u8; 8]) -> bool,
    ) -> Result<Option<[u8; 8]>, Error> {
        let (request, is_answer) = self.identifiers(link)?;
        link.ask(&Frame::of(request, bytes, 8), self.time, |frame| {
            let bytes = frame.bytes().try_into().ok();
            bytes.filter(|bytes| is_answer(frame) && is_own(bytes))
        })
    }

    /// The first request of a transfer: its answer names the object.
    fn initiate(self, link: &mut Link, request: [u8; 8]) -> Result<Option<[u8; 8]>, Error> {
        self.ask(link, request, |answer| {
            let is_segment = matches!(answer[0] >> 5, 0 | 1);
            !is_segment && answer[1..4] == request[1..4]
        })
    }

    /// The request of a segment: the answer is an abort, or has this command in bits 5 to 7.
    fn segment(
        self,
        link: &mut Link,
        request: [u8; 8],
        command: u8,
    ) -> Result<Option<[u8; 8]>, Error> {
        self.ask(link, request, |answer| {
            answer[0] == ABORT || answer[0] >> 5 == command
        })
    }

    /// Reads an object.
    ///
    /// # Errors
    /// The adapter fails.
    pub fn read(self, link: &mut Link, index: u16, sub: u8) -> Result<Answer<Vec<u8>>, Error> {
        let Some(answer) = self.initiate(link, header(0x40, index, sub))? else {
            return Ok(Answer::Silent);
        };
        if let Some(code) = aborted(&answer) {
            return Ok(Answer::Aborted(code));
        }
        let [command, _, _, _, data @ ..] = answer;
        if command & 0xE0 != 0x40 {
            return self.abort(link, index, sub);
        }
        if command & 2 != 0 {
            let unused = if command & 1 != 0 {
                command >> 2 & 3
            } else {
                0
            };
            return Ok(Answer::Done(data[..4 - usize::from(unused)].to_vec()));
        }
        let mut read = Vec::new();
        let mut toggle = 0;
        loop {
            let request = [0x60 | toggle, 0, 0, 0, 0, 0, 0, 0];
            let Some(answer) = self.segment(link, request, 0)? else {
                return Ok(Answer::Silent);
            };
            if let Some(code) = aborted(&answer) {
                return Ok(Answer::Aborted(code));
            }
            let [command, data @ ..] = answer;
            let unused = usize::from(command >> 1 & 7);
            // A segment without data that is not the last one: the transfer would never end.
            let is_empty = unused == 7 && command & 1 == 0;
            if command & 0xF0 != toggle || is_empty || read.len() > LONGEST {
                return self.abort(link, index, sub);
            }
            read.extend_from_slice(&data[..7 - unused]);
            if command & 1 != 0 {
                return Ok(Answer::Done(read));
            }
            toggle ^= 0x10;
        }
    }

    /// Writes an object: expedited up to 4 bytes, otherwise in segments.
    ///
    /// # Errors
    /// The adapter fails.
    pub fn write(
        self,
        link: &mut Link,
        index: u16,
        sub: u8,
        data: &[u8],
    ) -> Result<Answer<()>, Error> {
        let mut request = header(0x21, index, sub);
        let is_expedited = (1..=4).contains(&data.len());
        if is_expedited {
            request[0] = 0x23 | (4 - data.len() as u8) << 2;
            request[4..4 + data.len()].copy_from_slice(data);
        } else {
            request[4..].copy_from_slice(&(data.len() as u32).to_le_bytes());
        }
        let Some(answer) = self.initiate(link, request)? else {
            return Ok(Answer::Silent);
        };
        if let Some(code) = aborted(&answer) {
            return Ok(Answer::Aborted(code));
        }
        if answer[0] != 0x60 {
            return self.abort(link, index, sub);
        }
        if is_expedited {
            return Ok(Answer::Done(()));
        }
        let mut toggle = 0;
        let segments = data.len().div_ceil(7).max(1);
        for place in 0..segments {
            let part = &data[(7 * place).min(data.len())..data.len().min(7 * place + 7)];
            let last = u8::from(place + 1 == segments);
            let mut request = [
                toggle | (7 - part.len() as u8) << 1 | last,
                0,
                0,
                0,
                0,
                0,
                0,
                0,
            ];
            request[1..1 + part.len()].copy_from_slice(part);
            let Some(answer) = self.segment(link, request, 1)? else {
                return Ok(Answer::Silent);
            };
            if let Some(code) = aborted(&answer) {
                return Ok(Answer::Aborted(code));
            }
            if answer[0] != 0x20 | toggle {
                return self.abort(link, index, sub);
            }
            toggle ^= 0x10;
        }
        Ok(Answer::Done(()))
    }

    /// Writes the value that an object had before the tool changed it for a moment, also if the user wants to stop. A write that is not
    /// done is repeated.
    ///
    /// # Errors
    /// The adapter fails.
    pub fn put_back(
        self,
        link: &mut Link,
        (index, sub): (u16, u8),
        data: &[u8],
    ) -> Result<Answer<()>, Error> {
        let was_ending = link.set_ending(true);
        let mut written = self.write(link, index, sub, data);
        for _ in 1..TRIES {
            if !matches!(written, Ok(Answer::Silent | Answer::Aborted(_))) {
                break;
            }
            written = self.write(link, index, sub, data);
        }
        link.set_ending(was_ending);
        written
    }

    /// Ends a transfer whose answer is not understood.
    fn abort<T>(self, link: &mut Link, index: u16, sub: u8) -> Result<Answer<T>, Error> {
        const UNKNOWN_COMMAND: u32 = Abort::Command as u32;
        let mut bytes = header(ABORT, index, sub);
        bytes[4..].copy_from_slice(&UNKNOWN_COMMAND.to_le_bytes());
        let (id, _) = self.identifiers(link)?;
        link.send(&Frame::of(id, bytes, 8))?;
        Ok(Answer::Aborted(UNKNOWN_COMMAND))
    }
}

fn header(command: u8, index: u16, sub: u8) -> [u8; 8] {
    let [low, high] = index.to_le_bytes();
    [command, low, high, sub, 0, 0, 0, 0]
}

fn aborted(answer: &[u8; 8]) -> Option<u32> {
    let [ABORT, _, _, _, code @ ..] = *answer else {
        return None;
    };
    Some(u32::from_le_bytes(code))
}
