//! Which product answers at an address: its article, serial number and firmware, and the products of the catalogue that fit.

use crate::connect;
use crate::error::{Error, RequestError, SensorError};
use crate::known::meant;
use crate::link::Link;
use crate::master::{Target, canopen};
use crate::session::Session;
use plumbline::can::BitRate;
use plumbline::model::catalog::{PRODUCTS, Product, find};
use plumbline::time::{Duration, millis};
use texts::Kind;

mod found;

pub use found::{About, Found, Identity};

/// How long an answer may take, in addition to the time on the bus, at an address that perhaps no node has.
pub const QUICK: Duration = millis(30);

/// The same at an address that was heard or given.
pub const PATIENT: Duration = millis(100);

/// The number of times an identified sensor is asked the same.
pub(crate) const TRIES: u8 = 3;

/// The bits of the frames until a sensor that detects the bit rate has answered: the adapter repeats the first frame
/// until it is error passive, then come two boot-up messages.
const DETECTION: u32 = 3500;

/// The bits of a question and its answer.
const EXCHANGE: u32 = 300;

/// The wait for the answer to a question at the bit rate of a link; `latency` is the latency of the adapter.
pub fn question(link: &Link, latency: Duration) -> Duration {
    let rate = link.rate().map_or(250_000, BitRate::bits_per_second);
    // A sensor that detects the bit rate takes the first rate at which a node sends.
    let is_first = link.sent().iter().all(|(rate, _)| *rate == link.rate());
    let bits = if is_first { DETECTION } else { EXCHANGE };
    latency + millis(bits * 1000 / rate)
}

/// The time of a question and an answer at the bit rate of a link.
pub(crate) fn exchange(link: &Link, latency: Duration) -> Duration {
    let rate = link.rate().map_or(250_000, BitRate::bits_per_second);
    latency + millis(EXCHANGE * 1000 / rate)
}

/// The product with this name.
///
/// # Errors
/// There is none.
pub fn product(name: &str) -> Result<&'static Product, Error> {
    find(&name.to_lowercase()).ok_or_else(|| {
        let names: Vec<&str> = PRODUCTS.iter().map(|product| product.name).collect();
        RequestError::UnknownProduct(
            name.to_owned(),
            names.join(", "),
            meant(name, names.iter().copied()),
        )
        .into()
    })
}

/// Asks at an address; None if nobody answers. Only reads, which change nothing. A connection of DeviceNet is allocated and released
/// again. `latency` is [`QUICK`] or [`PATIENT`].
///
/// # Errors
/// The adapter fails.
pub fn ask(link: &mut Link, target: Target, latency: Duration) -> Result<Option<Found>, Error> {
    let time = question(link, latency);
    target.identify(link, time)
}

/// The same, and the other sensors that have the same address: a command for one of them would act on all.
///
/// # Errors
/// The adapter fails.
pub fn ask_all(link: &mut Link, target: Target, latency: Duration) -> Result<Option<Found>, Error> {
    let mut found = ask(link, target, latency)?;
    if let Some(found) = &mut found
        && let Some(node) = found.target.node_id()
    {
        found.twins = canopen::identify::others(link, node, found.serial)?;
    }
    Ok(found)
}

/// Refuses another sensor at the address of a session: the serial number differs, or what it tells if it has none.
///
/// # Errors
/// Another sensor answers, nobody answers, or the adapter fails.
pub fn same(session: &mut Session, found: &Found) -> Result<(), Error> {
    let own = found.identity().serial();
    let target = session.target;
    if target.is_connected(session)? {
        return Ok(());
    }
    if own.is_some() {
        match session.serial() {
            Err(failure) if failure.kind() != Kind::Refused => return Err(failure),
            Ok(serial) if serial == own => return Ok(()),
            _ => {}
        }
    }
    is_same(session, found)
}

/// The same with all that the sensor tells.
///
/// # Errors
/// See [`same`].
pub fn is_same(session: &mut Session, found: &Found) -> Result<(), Error> {
    session.release()?;
    let rate = session.link.rate();
    match ask(&mut session.link, session.target, PATIENT)? {
        None => Err(connect::silent(&[session.target], &[rate])),
        Some(other) if other.identity() != found.identity() => {
            Err(SensorError::Other(other.line(rate)).into())
        }
        Some(_) => Ok(()),
    }
}

/// A text of the sensor, if it is printable.
pub(crate) fn text_of(bytes: &[u8]) -> Option<String> {
    let text = std::str::from_utf8(bytes).ok()?.trim_end_matches('\0');
    let printable = text.chars().all(|letter| !letter.is_control());
    printable.then(|| text.to_owned())
}
