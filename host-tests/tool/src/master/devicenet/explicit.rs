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

use crate::error::{Error, Next, Reason, Refusal, SensorError, Silence, What};
use crate::link::Link;
use plumbline::can::{CanId, Frame};
use plumbline::devicenet::choice::{EXPLICIT, POLL};
use plumbline::devicenet::identifiers::{Group1, group_2, group_2_id};
use plumbline::devicenet::{general, service};
use plumbline::time::{Duration, millis};

/// The wait for a response.
const ANSWER: Duration = millis(500);

/// The longest response that is put together, in bytes.
const LONGEST: usize = 1024;

/// An attribute, or an instance of a class for other services.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Path {
    /// The class of the object.
    pub class: u8,
    /// The instance; 0 is the class itself.
    pub instance: u8,
}

/// The body of a response.
#[derive(Clone, PartialEq, Eq, Debug)]
pub enum Response {
    /// The data behind the service.
    Done(Vec<u8>),
    /// The general and the additional error code.
    Refused(u8, u8),
    /// There is no answer in time.
    Silent,
}

impl Response {
    /// The data of a request that must succeed; `what` names it for the message.
    ///
    /// # Errors
    /// It was refused, or nobody answers.
    pub fn must(self, mac: u8, what: What) -> Result<Vec<u8>, Error> {
        match self {
            Self::Done(data) => Ok(data),
            Self::Refused(code, more) => {
                Err(Refusal::Explicit(what, reason(code), code, more, next_step(code)).into())
            }
            Self::Silent => Err(Silence::MacId(mac).into()),
        }
    }
}

/// The number of times a slave can repeat a fragment.
const REPETITIONS: u8 = 3;

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
    /// Another master owns the sensor, nobody answers, or the adapter fails.
    pub fn allocate(self, link: &mut Link) -> Result<(), Error> {
        self.allocate_within(link, ANSWER)
    }

    /// The same with another wait for the response.
    ///
    /// # Errors
    /// See [`allocate`](Self::allocate).
    pub fn allocate_within(self, link: &mut Link, time: Duration) -> Result<(), Error> {
        self.allocate_choice(link, EXPLICIT, time)
    }

    /// Allocates the poll connection in addition to the explicit connection.
    ///
    /// # Errors
    /// See [`allocate`](Self::allocate).
    pub fn allocate_poll(self, link: &mut Link) -> Result<(), Error> {
        self.allocate_choice(link, POLL, ANSWER)
    }

    fn allocate_choice(self, link: &mut Link, choice: u8, time: Duration) -> Result<(), Error> {
        let data = [choice, self.master()];
        let mut response = self.unconnected(link, service::ALLOCATE, &data, time)?;
        if let Response::Refused(general::ALREADY, _) = response {
            self.release_choice(link, choice)?;
            response = self.unconnected(link, service::ALLOCATE, &data, time)?;
        }
        if let Response::Refused(general::STATE, _) = response {
            let mac = self.mac;
            return Err(SensorError::Owned(mac).into());
        }
        response.must(self.mac, What::Allocation).map(|_| ())
    }

    /// Releases the explicit connection, also if the user wants to stop.
    ///
    /// # Errors
    /// The adapter fails.
    pub fn release(self, link: &mut Link) -> Result<(), Error> {
        self.release_choice(link, EXPLICIT).map(|_| ())
    }

    /// Releases the poll connection, also if the user wants to stop. A sensor that has released it by itself refuses, which is no failure.
    ///
    /// # Errors
    /// Nobody answers, or the adapter fails.
    pub fn release_poll(self, link: &mut Link) -> Result<(), Error> {
        match self.release_choice(link, POLL)? {
            Response::Refused(general::ALREADY, _) => Ok(()),
            response => response.must(self.mac, What::Release).map(|_| ()),
        }
    }

    fn release_choice(self, link: &mut Link, choice: u8) -> Result<Response, Error> {
        let was_ending = link.set_ending(true);
        let released = self.unconnected(link, service::RELEASE, &[choice], ANSWER);
        link.set_ending(was_ending);
        released
    }

    /// Sends a poll command. The response comes with the identifier of [`poll_response`](Self::poll_response).
    ///
    /// # Errors
    /// The adapter fails.
    pub fn poll(self, link: &mut Link) -> Result<(), Error> {
        link.send(&Frame::of(self.id(group_2::POLL), [0; 8], 0))
    }

    /// The identifier of the responses to polls, independent of the master.
    pub fn poll_response(self) -> CanId {
        CanId::standard(Group1::PollResponse.id(self.mac))
    }

    /// The identifiers of the I/O messages that the slave sends. The responses to polls are first.
    pub fn io(self) -> [CanId; 2] {
        let change = CanId::standard(Group1::ChangeOrCyclic.id(self.mac));
        [self.poll_response(), change]
    }

    /// A request to the unconnected port.
    fn unconnected(
        self,
        link: &mut Link,
        code: u8,
        data: &[u8],
        time: Duration,
    ) -> Result<Response, Error> {
        let port = Path {
            class: 3,
            instance: 1,
        };
        self.request(link, (group_2::UNCONNECTED, time), code, port, data)
    }

    /// A request on the explicit connection, with at most four bytes of data.
    ///
    /// # Errors
    /// The data is too long, or the adapter fails.
    pub fn explicit(
        self,
        link: &mut Link,
        code: u8,
        path: Path,
        data: &[u8],
    ) -> Result<Response, Error> {
        self.request(link, (group_2::REQUEST, ANSWER), code, path, data)
    }

    /// Reads an attribute.
    ///
    /// # Errors
    /// The adapter fails.
    pub fn get(self, link: &mut Link, path: Path, attribute: u8) -> Result<Response, Error> {
        self.explicit(link, service::GET, path, &[attribute])
    }

    fn request(
        self,
        link: &mut Link,
        (message, time): (u16, Duration),
        code: u8,
        path: Path,
        data: &[u8],
    ) -> Result<Response, Error> {
        let mut bytes = vec![self.master(), code, path.class, path.instance];
        bytes.extend_from_slice(data);
        let request =
            Frame::data(self.id(message).into(), &bytes).ok_or(SensorError::LongRequest)?;
        let (master, answer) = (self.master(), self.id(group_2::RESPONSE));
        let is_own = |frame: &Frame| {
            let header = frame.bytes().first().map(|header| header & 0x3F);
            (frame.can_id() == answer && header == Some(master)).then(|| frame.bytes().to_vec())
        };
        let Some(first) = link.ask(&request, time, is_own)? else {
            return Ok(Response::Silent);
        };
        if first[0] & 0x80 == 0 {
            return Ok(response(code, &first[1..]));
        }
        // Fragments: each is acknowledged before the next one. A slave that has lost the acknowledge repeats its fragment.
        let mut body = Vec::new();
        let mut part = first;
        let (mut before, mut repetitions) = (None, 0);
        loop {
            let &[header, control, ref data @ ..] = &part[..] else {
                return Ok(Response::Silent);
            };
            let count = control & 0x3F;
            match before {
                Some(before) if count == before => repetitions += 1,
                Some(before) if count != (before + 1) & 0x3F => return Ok(Response::Silent),
                _ => body.extend_from_slice(data),
            }
            before = Some(count);
            if data.is_empty() || body.len() > LONGEST || repetitions > REPETITIONS {
                return Ok(Response::Silent);
            }
            let acknowledge = [header, 0xC0 | control & 0x3F, 0, 0, 0, 0, 0, 0];
            let acknowledge = Frame::of(self.id(group_2::REQUEST), acknowledge, 3);
            if control & 0xC0 == 0x80 {
                link.send(&acknowledge)?;
                return Ok(response(code, &body));
            }
            match link.ask(&acknowledge, ANSWER, is_own)? {
                Some(next) => part = next,
                None => return Ok(Response::Silent),
            }
        }
    }
}

/// The response to a service with this body.
fn response(code: u8, body: &[u8]) -> Response {
    match body {
        [answered, code, more, ..] if *answered == service::ERROR | 0x80 => {
            Response::Refused(*code, *more)
        }
        [answered, data @ ..] if *answered == code | 0x80 => Response::Done(data.to_vec()),
        _ => Response::Silent,
    }
}

/// What to do after an error with this code.
fn next_step(code: u8) -> Next {
    match code {
        general::ALREADY | general::STATE | 0x10 => Next::State,
        general::RESOURCE => Next::Repeat,
        _ => Next::List,
    }
}

/// The meaning of a general error code. The codes that the sensors of the core do not use come from the CIP specification.
pub fn reason(code: u8) -> Reason {
    match code {
        general::RESOURCE => Reason::Resource,
        general::SERVICE => Reason::Service,
        general::VALUE => Reason::Value,
        general::ALREADY => Reason::Already,
        general::STATE | 0x10 => Reason::State,
        general::NOT_SETTABLE => Reason::AttributeReadOnly,
        0x0F => Reason::Permission,
        general::TOO_LITTLE => Reason::TooLittle,
        general::ATTRIBUTE => Reason::NoAttribute,
        general::TOO_MUCH => Reason::TooMuch,
        general::OBJECT => Reason::NoObject,
        0x1F => Reason::Vendor,
        general::PARAMETER => Reason::Parameter,
        _ => Reason::General,
    }
}
