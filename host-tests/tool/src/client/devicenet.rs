//! Explicit messages of DeviceNet over the predefined master/slave connection set (Group 2 Only).
//!
//! ```text
//!  identifier            byte 0   1         2        3          4 ..
//!  406h + 8 x MAC        master   4Bh       3        1          choice, master     allocate
//!  404h + 8 x MAC        master   service   class    instance   data               request
//!  403h + 8 x MAC        master   service + 80h      data                          response
//!                        master   94h       code     additional code               error response
//!                        80h + .. fragment  data                                   a part of a longer response
//! ```

use super::Link;
use crate::failure::Failure;
use plumbline::can::{CanId, Frame};
use plumbline::devicenet::identifiers::{group_2, group_2_id};
use plumbline::time::{Duration, millis};

/// The wait for a response.
const ANSWER: Duration = millis(500);

/// The longest response that is put together, in bytes.
const LONGEST: usize = 1024;

/// The choice of the explicit connection.
const EXPLICIT: u8 = 0x01;

/// The service "get attribute".
pub const GET: u8 = 0x0E;
/// The service "set attribute".
pub const SET: u8 = 0x10;
/// The service "reset".
pub const RESET: u8 = 0x05;
const ALLOCATE: u8 = 0x4B;
const RELEASE: u8 = 0x4C;
const ERROR: u8 = 0x14;

/// General error code: the choice is allocated already, or does not exist.
const ALREADY: u8 = 0x0B;
/// General error code: the connections belong to another master, or another state forbids the service.
const STATE: u8 = 0x0C;

/// An attribute, or an instance of a class for other services.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Path {
    /// The class.
    pub class: u8,
    /// The instance.
    pub instance: u8,
}

/// The body of a response.
#[derive(Clone, PartialEq, Eq, Debug)]
pub enum Response {
    /// The data behind the service.
    Done(Vec<u8>),
    /// The general and the additional error code.
    Refused(u8, u8),
    /// Nobody answers.
    Silent,
}

impl Response {
    /// The data of a request that must succeed; `what` names it for the message.
    ///
    /// # Errors
    /// It was refused, or nobody answers.
    pub fn must(self, mac: u8, what: &str) -> Result<Vec<u8>, Failure> {
        match self {
            Self::Done(data) => Ok(data),
            Self::Refused(code, more) => Err(Failure::refused(
                "refused",
                format!(
                    "the sensor refused {what}: {} ({code:02X}h, {more:02X}h)",
                    reason(code)
                ),
            )),
            Self::Silent => Err(Failure::silent(
                "no-answer",
                format!("MAC ID {mac} does not answer: `plumbline scan` finds the sensor"),
            )),
        }
    }
}

/// A slave, and the MAC ID of the tool.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Slave {
    /// Its MAC ID, 0 to 63.
    pub mac: u8,
}

impl Slave {
    /// The MAC ID of the tool: 62, which masters leave to tools, or 61.
    pub fn master(self) -> u8 {
        if self.mac == 62 { 61 } else { 62 }
    }

    fn id(self, message: u16) -> CanId {
        CanId::standard(group_2_id(self.mac, message))
    }

    /// Allocates the explicit connection. If an earlier run has left it open, releases it first.
    ///
    /// # Errors
    /// Another master owns the sensor, nobody answers, or those of the adapter.
    pub fn allocate(self, link: &mut Link) -> Result<(), Failure> {
        self.allocate_within(link, ANSWER)
    }

    /// The same with another wait for the response.
    ///
    /// # Errors
    /// See [`allocate`](Self::allocate).
    pub fn allocate_within(self, link: &mut Link, time: Duration) -> Result<(), Failure> {
        let choice = [EXPLICIT, self.master()];
        let mut response = self.unconnected(link, ALLOCATE, &choice, time)?;
        if let Response::Refused(ALREADY, _) = response {
            self.release(link)?;
            response = self.unconnected(link, ALLOCATE, &choice, time)?;
        }
        if let Response::Refused(STATE, _) = response {
            let mac = self.mac;
            let message = format!(
                "another master owns the sensor with MAC ID {mac}: it is only listened to; stop that master and repeat"
            );
            return Err(Failure::refused("owned", message));
        }
        response.must(self.mac, "the allocation").map(|_| ())
    }

    /// Releases the explicit connection.
    ///
    /// # Errors
    /// Those of the adapter.
    pub fn release(self, link: &mut Link) -> Result<(), Failure> {
        self.unconnected(link, RELEASE, &[EXPLICIT], ANSWER)
            .map(|_| ())
    }

    /// A request to the unconnected port.
    fn unconnected(
        self,
        link: &mut Link,
        service: u8,
        data: &[u8],
        time: Duration,
    ) -> Result<Response, Failure> {
        let port = Path {
            class: 3,
            instance: 1,
        };
        self.request(link, (group_2::UNCONNECTED, time), service, port, data)
    }

    /// A request on the explicit connection, with at most four bytes of data.
    ///
    /// # Errors
    /// The data is too long, or those of the adapter.
    pub fn explicit(
        self,
        link: &mut Link,
        service: u8,
        path: Path,
        data: &[u8],
    ) -> Result<Response, Failure> {
        self.request(link, (group_2::REQUEST, ANSWER), service, path, data)
    }

    /// Reads an attribute.
    ///
    /// # Errors
    /// Those of the adapter.
    pub fn get(self, link: &mut Link, path: Path, attribute: u8) -> Result<Response, Failure> {
        self.explicit(link, GET, path, &[attribute])
    }

    /// Sets an attribute; its value has at most three bytes.
    ///
    /// # Errors
    /// The value is too long, or those of the adapter.
    pub fn set(
        self,
        link: &mut Link,
        path: Path,
        attribute: u8,
        value: &[u8],
    ) -> Result<Response, Failure> {
        let data: Vec<u8> = std::iter::once(attribute)
            .chain(value.iter().copied())
            .collect();
        self.explicit(link, SET, path, &data)
    }

    fn request(
        self,
        link: &mut Link,
        (message, time): (u16, Duration),
        service: u8,
        path: Path,
        data: &[u8],
    ) -> Result<Response, Failure> {
        let mut bytes = vec![self.master(), service, path.class, path.instance];
        bytes.extend_from_slice(data);
        let request = Frame::data(self.id(message).into(), &bytes).ok_or_else(|| {
            Failure::usage(
                "too-long",
                "an explicit request has at most four bytes of data",
            )
        })?;
        let (master, answer) = (self.master(), self.id(group_2::RESPONSE));
        let is_own = |frame: &Frame| {
            let header = frame.bytes().first().map(|header| header & 0x3F);
            (frame.can_id() == answer && header == Some(master)).then(|| frame.bytes().to_vec())
        };
        let Some(first) = link.ask(&request, time, is_own)? else {
            return Ok(Response::Silent);
        };
        if first[0] & 0x80 == 0 {
            return Ok(response(service, &first[1..]));
        }
        // Fragments: each is acknowledged before the next one.
        let mut body = Vec::new();
        let mut part = first;
        loop {
            let &[header, control, ref data @ ..] = &part[..] else {
                return Ok(Response::Silent);
            };
            body.extend_from_slice(data);
            if body.len() > LONGEST {
                return Ok(Response::Silent);
            }
            let acknowledge = [header, 0xC0 | control & 0x3F, 0, 0, 0, 0, 0, 0];
            let acknowledge = Frame::of(self.id(group_2::REQUEST), acknowledge, 3);
            if control & 0xC0 == 0x80 {
                link.send(&acknowledge)?;
                return Ok(response(service, &body));
            }
            match link.ask(&acknowledge, ANSWER, is_own)? {
                Some(next) => part = next,
                None => return Ok(Response::Silent),
            }
        }
    }
}

/// The response to a service with this body.
fn response(service: u8, body: &[u8]) -> Response {
    match body {
        [answered, code, more, ..] if *answered == ERROR | 0x80 => Response::Refused(*code, *more),
        [answered, data @ ..] if *answered == service | 0x80 => Response::Done(data.to_vec()),
        _ => Response::Silent,
    }
}

/// The meaning of a general error code.
pub fn reason(code: u8) -> &'static str {
    match code {
        0x02 => "the resource is not available",
        0x08 => "there is no such service",
        0x09 => "the value is not permitted",
        0x0B => "already in this state",
        0x0C => "not in the present state of the device",
        0x0E => "the attribute can only be read",
        0x0F => "the permission is missing",
        0x10 => "not in the present state of the device",
        0x13 => "there is not enough data",
        0x14 => "there is no such attribute",
        0x15 => "there is too much data",
        0x16 => "there is no such object",
        0x1F => "a vendor specific error",
        0x20 => "a parameter of the service is not permitted",
        _ => "general error",
    }
}
