//! CANopen SDO client: expedited and segmented transfers (CiA 301, 7.2.4.3).
//!
//! ```text
//!  byte 0              1..2     3          4..7
//!  40h read            index    sub-index
//!  2Fh/2Bh/23h write   index    sub-index  1, 2 or 4 bytes
//!  21h write           index    sub-index  length         then segments: 0tn0c + 7 bytes
//!  80h abort           index    sub-index  abort code
//! ```

use super::Link;
use crate::failure::Failure;
use plumbline::can::{CanId, Frame};
use plumbline::time::{Duration, millis};

/// The wait for an answer.
pub const ANSWER: Duration = millis(500);

/// The wait for the answer to "save", which comes when the memory is written.
pub const SAVED: Duration = millis(3000);

/// The longest text or record that is read, in bytes.
const LONGEST: usize = 4096;

/// An answer of the server.
#[derive(Clone, PartialEq, Eq, Debug)]
pub enum Answer<T> {
    /// The transfer is done.
    Done(T),
    /// The server aborted the transfer with this code.
    Aborted(u32),
    /// Nobody answers.
    Silent,
}

impl<T> Answer<T> {
    /// The result of a transfer that must succeed; `what` names the object for the message.
    ///
    /// # Errors
    /// It was aborted, or nobody answers.
    pub fn must(self, node: u8, what: &str) -> Result<T, Failure> {
        match self {
            Self::Done(done) => Ok(done),
            Self::Aborted(code) => Err(Failure::refused(
                "refused",
                format!("the sensor refused {what}: {} ({code:08X}h)", reason(code)),
            )),
            Self::Silent => Err(Failure::silent(
                "no-answer",
                format!("node {node} does not answer: `plumbline scan` finds the sensor"),
            )),
        }
    }
}

/// An SDO server.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Server {
    /// Its node-ID, 1 to 127.
    pub node: u8,
    /// The wait for each answer.
    pub time: Duration,
}

impl Server {
    /// The server of a node.
    pub const fn of(node: u8) -> Self {
        Self { node, time: ANSWER }
    }

    fn ask(self, link: &mut Link, bytes: [u8; 8]) -> Result<Option<[u8; 8]>, Failure> {
        let request = Frame::of(CanId::standard(0x600 + u16::from(self.node)), bytes, 8);
        let answer = CanId::standard(0x580 + u16::from(self.node));
        link.ask(&request, self.time, |frame| {
            let bytes = frame.bytes().try_into().ok();
            bytes.filter(|_| frame.can_id() == answer)
        })
    }

    /// Reads an object.
    ///
    /// # Errors
    /// Those of the adapter.
    pub fn read(self, link: &mut Link, index: u16, sub: u8) -> Result<Answer<Vec<u8>>, Failure> {
        let Some(answer) = self.ask(link, header(0x40, index, sub))? else {
            return Ok(Answer::Silent);
        };
        if let Some(code) = aborted(&answer) {
            return Ok(Answer::Aborted(code));
        }
        let [command, _, _, _, data @ ..] = answer;
        if answer[1..4] != header(0, index, sub)[1..4] || command & 0xE0 != 0x40 {
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
            let Some(answer) = self.ask(link, request)? else {
                return Ok(Answer::Silent);
            };
            if let Some(code) = aborted(&answer) {
                return Ok(Answer::Aborted(code));
            }
            let [command, data @ ..] = answer;
            if command & 0xF0 != toggle || read.len() > LONGEST {
                return self.abort(link, index, sub);
            }
            let unused = usize::from(command >> 1 & 7);
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
    /// Those of the adapter.
    pub fn write(
        self,
        link: &mut Link,
        index: u16,
        sub: u8,
        data: &[u8],
    ) -> Result<Answer<()>, Failure> {
        let mut request = header(0x21, index, sub);
        let is_expedited = (1..=4).contains(&data.len());
        if is_expedited {
            request[0] = 0x23 | (4 - data.len() as u8) << 2;
            request[4..4 + data.len()].copy_from_slice(data);
        } else {
            request[4..].copy_from_slice(&(data.len() as u32).to_le_bytes());
        }
        let Some(answer) = self.ask(link, request)? else {
            return Ok(Answer::Silent);
        };
        if let Some(code) = aborted(&answer) {
            return Ok(Answer::Aborted(code));
        }
        if answer[0] != 0x60 || answer[1..4] != request[1..4] {
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
            let Some(answer) = self.ask(link, request)? else {
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

    /// Ends a transfer whose answer is not understood.
    fn abort<T>(self, link: &mut Link, index: u16, sub: u8) -> Result<Answer<T>, Failure> {
        const UNKNOWN_COMMAND: u32 = 0x0504_0001;
        let mut bytes = header(0x80, index, sub);
        bytes[4..].copy_from_slice(&UNKNOWN_COMMAND.to_le_bytes());
        let id = CanId::standard(0x600 + u16::from(self.node));
        link.send(&Frame::of(id, bytes, 8))?;
        Ok(Answer::Aborted(UNKNOWN_COMMAND))
    }
}

fn header(command: u8, index: u16, sub: u8) -> [u8; 8] {
    let [low, high] = index.to_le_bytes();
    [command, low, high, sub, 0, 0, 0, 0]
}

fn aborted(answer: &[u8; 8]) -> Option<u32> {
    let [0x80, _, _, _, code @ ..] = *answer else {
        return None;
    };
    Some(u32::from_le_bytes(code))
}

/// The meaning of an abort code (CiA 301, table 22).
pub fn reason(code: u32) -> &'static str {
    match code {
        0x0503_0000 => "toggle bit not alternated",
        0x0504_0000 => "time-out of the protocol",
        0x0504_0001 => "unknown command",
        0x0504_0005 => "out of memory",
        0x0601_0000 => "unsupported access",
        0x0601_0001 => "the object can only be written",
        0x0601_0002 => "the object can only be read",
        0x0602_0000 => "there is no such object",
        0x0604_0041 => "the object cannot be mapped",
        0x0604_0042 => "the mapping is too long for a PDO",
        0x0604_0043 => "parameters do not fit each other",
        0x0606_0000 => "a hardware error",
        0x0607_0010 => "the length does not match the type",
        0x0607_0012 => "the value is too long",
        0x0607_0013 => "the value is too short",
        0x0609_0011 => "there is no such sub-index",
        0x0609_0030 => "the value is not permitted",
        0x0609_0031 => "the value is too high",
        0x0609_0032 => "the value is too low",
        0x0800_0020 => "the value cannot be stored",
        0x0800_0022 => "not in the present state of the device",
        0x0800_0024 => "there is no data",
        _ => "general error",
    }
}
