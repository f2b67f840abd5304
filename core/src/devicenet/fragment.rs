//! Fragmented explicit messages: a body that does not fit into a frame, in both directions.
//!
//! ```text
//!              byte 0                   1                      2 ...
//!  fragment    80h + XID + MAC ID       type + count           up to 6 bytes of the body: service, data
//!  acknowledge of the fragment          C0h + count            status
//! ```
//!
//! The types are 00h first, 40h middle, 80h last. The count has 6 bits. Each fragment is acknowledged before the next one is sent. A first
//! fragment with the count 3Fh is a complete message, which is not acknowledged.

use super::explicit::{FRAGMENT, response_to};
use crate::store::Name;
use crate::time::{Deadline, Duration, Instant, millis};

/// Bits of byte 1: the type.
const TYPE: u8 = 0xC0;
const FIRST: u8 = 0x00;
const MIDDLE: u8 = 0x40;
const LAST: u8 = 0x80;
const ACKNOWLEDGE: u8 = 0xC0;
/// Bits of byte 1: the count.
const COUNT: u8 = 0x3F;

/// Byte 1 of a complete message: first, with the highest count.
const WHOLE: u8 = FIRST | COUNT;

/// Status of an acknowledge: the fragment is accepted.
const ACCEPTED: u8 = 0;
/// Status of an acknowledge: the message is too long.
const TOO_MUCH: u8 = 1;

/// The bytes of a body in a fragment.
const PART: usize = 6;

/// The longest body of a request in bytes (attribute 8 of connection 1).
pub(super) const CONSUMED: usize = 32;

/// The longest body of a response in bytes (attribute 7 of connection 1): a text of 32 characters.
pub(super) const PRODUCED: usize = 34;

/// The shortest text of a response in characters: its body needs two fragments.
pub(super) const SHORTEST: usize = PART - 1;

/// The wait for an acknowledge.
const LIMIT: Duration = millis(1000);

/// The contents of a received fragment.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Kind {
    /// An acknowledge of a fragment that this node has sent.
    Acknowledge { count: u8, status: u8 },
    /// A part of a request.
    Part,
    /// A request in one fragment.
    Whole,
}

/// The kind of a fragment with these bytes after its header.
pub(super) fn kind(bytes: &[u8]) -> Option<Kind> {
    let [control, data @ ..] = bytes else {
        return None;
    };
    if *control == WHOLE {
        return Some(Kind::Whole);
    }
    if control & TYPE != ACKNOWLEDGE {
        return Some(Kind::Part);
    }
    let [status, ..] = data else {
        return None;
    };
    Some(Kind::Acknowledge {
        count: control & COUNT,
        status: *status,
    })
}

/// An acknowledge to send: its data and length. `header` is that of the fragment.
pub(super) fn acknowledge(header: u8, answer: Answer) -> (u64, u8) {
    let Answer { count, status } = answer;
    let control = ACKNOWLEDGE | count;
    let data = u64::from(header) | u64::from(control) << 8 | u64::from(status) << 16;
    (data, 3)
}

/// An unfragmented response with this data and length as a complete fragment, if it fits.
pub(super) fn whole((data, length): (u64, u8)) -> Option<(u64, u8)> {
    let [header, body @ ..] = data.to_le_bytes();
    let [a, b, c, d, e, f, _] = body;
    let bytes = [header | FRAGMENT, WHOLE, a, b, c, d, e, f];
    (length < 8).then_some((u64::from_le_bytes(bytes), length + 1))
}

/// The acknowledge of a received fragment.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) struct Answer {
    count: u8,
    status: u8,
}

/// The reception of a fragmented request.
pub(super) struct Receiver {
    body: [u8; CONSUMED],
    length: u8,
    /// The count of the next fragment; 0 before the first one.
    next: u8,
    /// The first fragment is received, and the last one is not.
    running: bool,
}

impl Receiver {
    /// No request is being received.
    pub const IDLE: Self = Self {
        body: [0; CONSUMED],
        length: 0,
        next: 0,
        running: false,
    };

    /// Discards the part of a request that was received.
    pub fn stop(&mut self) {
        self.running = false;
    }

    /// Handles the bytes of a fragment after its header. Returns its acknowledge, and whether the message is complete.
    pub fn receive(&mut self, bytes: &[u8]) -> Option<(Answer, bool)> {
        let [control, part @ ..] = bytes else {
            return None;
        };
        let (kind, count) = (control & TYPE, control & COUNT);
        if kind == FIRST {
            self.running = count == 0;
            self.length = 0;
            self.next = 0;
        }
        if !self.running {
            return None;
        }
        let accepted = Answer {
            count,
            status: ACCEPTED,
        };
        if kind == MIDDLE && count == self.next.wrapping_sub(1) & COUNT {
            return Some((accepted, false));
        }
        if count != self.next {
            self.running = false;
            return None;
        }
        let length = usize::from(self.length);
        let Some(place) = self.body.get_mut(length..length + part.len()) else {
            self.running = false;
            let status = TOO_MUCH;
            return Some((Answer { count, status }, false));
        };
        for (to, from) in place.iter_mut().zip(part) {
            *to = *from;
        }
        self.length += part.len() as u8;
        self.next = (count + 1) & COUNT;
        let complete = kind == LAST;
        self.running = !complete;
        Some((accepted, complete))
    }

    /// The body of the last complete message, and its length.
    pub fn body(&self) -> ([u8; CONSUMED], usize) {
        (self.body, self.length.into())
    }
}

/// The transmission of a text.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sender {
    text: Option<Name>,
    header: u8,
    service: u8,
    /// The count of the present fragment.
    count: u8,
    /// The present fragment must be sent.
    pending: bool,
    repeated: bool,
    until: Deadline,
}

impl Sender {
    /// No response is being sent.
    pub const IDLE: Self = Self {
        text: None,
        header: 0,
        service: 0,
        count: 0,
        pending: false,
        repeated: false,
        until: Deadline::NEVER,
    };

    /// Begins a response: the text with its length in the first byte. `header` is that of the request.
    pub fn start(&mut self, header: u8, service: u8, text: Name) {
        *self = Self {
            text: Some(text),
            header: header | FRAGMENT,
            service: response_to(service),
            pending: true,
            ..Self::IDLE
        };
    }

    /// Sends nothing more of the response.
    pub fn stop(&mut self) {
        *self = Self::IDLE;
    }

    /// Whether a message is being sent.
    pub fn is_running(&self) -> bool {
        self.text.is_some()
    }

    /// Whether a fragment must be sent.
    pub fn is_pending(&self) -> bool {
        self.pending
    }

    /// The byte of the body at `place`: service, length, characters.
    fn byte(&self, place: usize) -> Option<u8> {
        let text = self.text.as_ref()?.bytes();
        match place {
            0 => Some(self.service),
            1 => Some(text.len() as u8),
            _ => text.get(place - 2).copied(),
        }
    }

    /// The data of the present fragment and its length, if it must be sent.
    pub fn take(&mut self, now: Instant) -> Option<([u8; 8], u8)> {
        if !self.pending {
            return None;
        }
        let first = usize::from(self.count) * PART;
        let is_last = self.byte(first + PART).is_none();
        let kind = match self.count {
            0 => FIRST,
            _ if is_last => LAST,
            _ => MIDDLE,
        };
        let mut bytes = [self.header, kind | self.count, 0, 0, 0, 0, 0, 0];
        let mut length = 2;
        for (place, byte) in bytes.iter_mut().skip(2).enumerate() {
            if let Some(next) = self.byte(first + place) {
                *byte = next;
                length += 1;
            }
        }
        self.pending = false;
        self.until = Deadline::after(now, LIMIT);
        Some((bytes, length))
    }

    /// Handles an acknowledge of the master.
    pub fn acknowledge(&mut self, count: u8, status: u8) {
        // While the fragment is not sent, an acknowledge belongs to an earlier one.
        if self.text.is_none() || count != self.count || self.pending {
            return;
        }
        let next = usize::from(self.count + 1) * PART;
        if status != ACCEPTED || self.byte(next).is_none() {
            return self.stop();
        }
        self.count += 1;
        self.pending = true;
        self.repeated = false;
        self.until = Deadline::NEVER;
    }

    /// Repeats the fragment once if the wait for its acknowledge has ended.
    pub fn poll(&mut self, now: Instant) {
        if !self.until.is_reached(now) {
            return;
        }
        if self.repeated {
            return self.stop();
        }
        self.until = Deadline::NEVER;
        self.repeated = true;
        self.pending = true;
    }

    /// The end of the wait for an acknowledge.
    pub fn deadline(&self) -> Deadline {
        self.until
    }
}

#[cfg(test)]
mod tests;
