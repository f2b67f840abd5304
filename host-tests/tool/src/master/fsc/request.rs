//! GEMAC function select codes: a request on the Set-Parameter-ID, a reply on the Reply-Parameter-ID.
//!
//! ```text
//!            byte 0   1        2 ..
//!  request   code     data
//!  reply     code     status   data
//! ```

use crate::error::{Error, Next, Refusal, SensorError, Silence};
use crate::link::Link;
use crate::number::shown;
use plumbline::can::{CanId, Frame};
use plumbline::fsc::{Condition, StatusBit};
use plumbline::model::listing::fsc::Tables;
use plumbline::time::{Duration, millis};

/// The wait for a reply.
pub const ANSWER: Duration = millis(200);

/// The wait for the reply to a write, which is not repeated.
pub const WRITTEN: Duration = millis(1000);

/// The wait for the reply to SAVE and LOAD, which comes when the memory is written.
pub const SAVED: Duration = millis(3000);

/// The number of times a request that changes nothing is sent.
const TRIES: u8 = 3;

/// The identifiers of a GEMAC sensor.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Sensor {
    /// The Set-Parameter-ID in force, for requests.
    pub request: CanId,
    /// Its Reply-Parameter-ID in force; None: any other identifier.
    pub reply: Option<CanId>,
}

/// A reply to a request.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Reply {
    /// The identifier of the frame.
    pub id: CanId,
    /// The status byte (byte 1).
    pub status: u8,
    /// The bytes after the status byte.
    pub data: Vec<u8>,
}

/// Sends a request and returns its reply; None after `time`.
///
/// # Errors
/// The adapter fails.
pub fn ask(
    link: &mut Link,
    sensor: Sensor,
    code: u8,
    data: &[u8],
    time: Duration,
) -> Result<Option<Reply>, Error> {
    let request = request(sensor.request, code, data)?;
    link.ask(&request, time, |frame| reply(frame, sensor, code))
}

/// Sends a request that has no reply.
///
/// # Errors
/// The adapter fails.
pub fn send(link: &mut Link, sensor: Sensor, code: u8, data: &[u8]) -> Result<(), Error> {
    link.send(&request(sensor.request, code, data)?)
}

fn request(id: CanId, code: u8, data: &[u8]) -> Result<Frame, Error> {
    let bytes: Vec<u8> = std::iter::once(code).chain(data.iter().copied()).collect();
    Frame::data(id.into(), &bytes).ok_or_else(|| SensorError::LongCode.into())
}

/// The reply to a code in a frame, or a cyclic value.
pub fn reply(frame: &Frame, sensor: Sensor, code: u8) -> Option<Reply> {
    let id = frame.can_id();
    let own = sensor
        .reply
        .map_or(id != sensor.request, |reply| reply == id);
    match frame.bytes() {
        [first, status, data @ ..] if own && *first == code => Some(Reply {
            id,
            status: *status,
            data: data.to_vec(),
        }),
        _ => None,
    }
}

/// Sends a request that changes nothing and that the sensor must answer, with repetitions: a sensor that detects the bit rate does not
/// answer the first one.
///
/// # Errors
/// Nobody answers, or the adapter fails.
pub fn must(link: &mut Link, sensor: Sensor, code: u8, time: Duration) -> Result<Reply, Error> {
    let mut reply = once(link, sensor, code, &[], time);
    for _ in 1..TRIES {
        match &reply {
            Err(Error::Silent(_)) => {
                reply = once(link, sensor, code, &[], time);
            }
            _ => break,
        }
    }
    reply
}

/// Sends a request once that the sensor must answer.
///
/// # Errors
/// Nobody answers, or the adapter fails.
pub fn once(
    link: &mut Link,
    sensor: Sensor,
    code: u8,
    data: &[u8],
    time: Duration,
) -> Result<Reply, Error> {
    ask(link, sensor, code, data, time)?.ok_or_else(|| {
        let id = shown(sensor.request);
        Silence::Code(code, id).into()
    })
}

/// The names of the errors that the sensor has had before a request that changes something, which clears them. The bits stay until the
/// status is read: an earlier refusal does not belong to that request.
///
/// # Errors
/// Nobody answers, or the adapter fails.
pub fn earlier(
    link: &mut Link,
    sensor: Sensor,
    tables: &Tables,
) -> Result<Vec<&'static str>, Error> {
    let earlier = must(link, sensor, status_code(tables), ANSWER)?;
    let memory = mask(tables, |condition| condition == Condition::EepromError);
    Ok(names(&tables.status, earlier.status & memory))
}

/// The bits of the status byte that are set by a refused request.
pub fn errors(tables: &Tables) -> u8 {
    mask(tables, |condition| {
        matches!(condition, Condition::CmdParamError | Condition::EepromError)
    })
}

/// Sends a request that changes something, after [`earlier`]. A status with the bits of an error is a refusal.
///
/// # Errors
/// The sensor refuses it, nobody answers, or the adapter fails.
pub fn command(
    link: &mut Link,
    sensor: Sensor,
    tables: &Tables,
    code: u8,
    data: &[u8],
    time: Duration,
) -> Result<(), Error> {
    let errors = errors(tables);
    let memory = mask(tables, |condition| condition == Condition::EepromError);
    // The request is sent once: if only its reply is lost, a second request sets the zero point at a later position.
    let reply = once(link, sensor, code, data, time)?;
    if reply.status & errors == 0 {
        return Ok(());
    }
    // Reading the status clears the bits.
    let names = names(&tables.status, reply.status & errors);
    must(link, sensor, status_code(tables), ANSWER)?;
    let next_step = match reply.status & memory {
        0 => Next::List,
        _ => Next::Failed,
    };
    Err(Refusal::Code(code, names.join(", "), next_step).into())
}

/// The bits of the status byte with these conditions.
fn mask(tables: &Tables, is: impl Fn(Condition) -> bool) -> u8 {
    let bits = tables.status.iter().enumerate();
    bits.filter(|(_, bit)| is(bit.condition))
        .fold(0, |mask, (place, _)| mask | 1 << place)
}

/// The code of the request for the status.
fn status_code(tables: &Tables) -> u8 {
    let status = plumbline::fsc::table::Operation::ReadStatus;
    let mut functions = tables.functions.iter();
    functions
        .find(|function| function.operation == status)
        .map_or(0x02, |function| function.code)
}

/// The names of the bits of a status byte.
pub fn names(bits: &[StatusBit; 8], status: u8) -> Vec<&'static str> {
    let set = |place: &usize| status >> place & 1 != 0;
    let places = (0..8).filter(set);
    places
        .map(|place| bits[place].name)
        .filter(|name| !name.is_empty())
        .collect()
}
