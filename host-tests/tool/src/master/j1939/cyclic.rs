//! A J1939 sensor that broadcasts its angles (SSI2).
//!
//! ```text
//!  18EAFF<other>  00 EE 00      another device requests claims: each node sends its own
//!  18EEFF<node>   NAME          a claim without such a request: the sensor was switched off and on
//! ```

use super::ssi2::{self, Angles};
use super::tables;
use crate::cyclic::{Message, Source, Started, Stream};
use crate::error::{Error, SensorError};
use crate::master::j1939::groups as j1939;
use crate::sample::Sampler;
use crate::session::Session;
use crate::sheet::Entry;
use plumbline::can::Frame;
use plumbline::param::Setting;
use plumbline::time::{Duration, Instant, after, millis};
use texts::Kind;

/// The sensor whose process data is received.
#[derive(Debug)]
pub(super) struct Sender {
    address: u8,
    /// The claim of the sensor until this time is an answer.
    asked_until: Option<Instant>,
    /// The sensor has restarted, and its settings are not known since.
    is_unchecked: bool,
}

/// What a frame of the bus is.
enum Heard {
    Angles(Angles),
    /// A device requests the claim of the sensor.
    Request,
    Claim,
}

impl Sender {
    pub(super) fn new(address: u8) -> Self {
        Self {
            address,
            asked_until: None,
            is_unchecked: false,
        }
    }

    /// The broadcast with this period in ms.
    pub(super) fn start(self, session: &Session, every: u32) -> Started {
        let tables = tables(session.sheet.product);
        let rate = tables.and_then(|tables| match (tables.settings)(0) {
            Some((Setting::Parameter(rate), _)) => Some((rate, every)),
            _ => None,
        });
        Started {
            stream: Box::new(self),
            every: Some(millis(every)),
            settings: rate.into_iter().collect(),
        }
    }

    fn judge(&self, frame: &Frame) -> Option<Heard> {
        if let Some(angles) = ssi2::of(frame, self.address) {
            return Some(Heard::Angles(angles));
        }
        if j1939::is_request_for_claim(frame, self.address) {
            return Some(Heard::Request);
        }
        j1939::is_claim_of(frame, self.address).then_some(Heard::Claim)
    }
}

impl Stream for Sender {
    /// The next broadcast. After a restart the sensor sends with its stored period.
    fn next(
        &mut self,
        session: &mut Session,
        sampler: &Sampler,
        wanted: &[(Entry, u32)],
        time: Duration,
    ) -> Result<Option<Message>, Error> {
        let until = after(session.link.now(), time);
        loop {
            if self.is_unchecked {
                self.is_unchecked = !is_as_before(session, wanted)?;
            }
            let left = until.ticks().saturating_sub(session.link.now().ticks());
            let left = Duration::from_ticks(left);
            let judge = |frame: &Frame| self.judge(frame);
            let Some((at, heard)) = session.link.wait_for_at(left, judge)? else {
                return Ok(None);
            };
            match heard {
                Heard::Angles(angles) => {
                    return Ok(Some(message(at, angles, sampler.entries().len())));
                }
                Heard::Request => self.asked_until = Some(after(at, j1939::ANSWER)),
                Heard::Claim if self.asked_until.is_some_and(|until| at < until) => {}
                Heard::Claim => self.is_unchecked = true,
            }
            if session.link.now() >= until {
                return Ok(None);
            }
        }
    }

    fn period(&self, before: &[(Entry, u32)]) -> Option<u32> {
        match before {
            [(_, period @ 1..)] => Some(*period),
            _ => None,
        }
    }
}

/// The broadcasts of a sensor with some angles.
pub(super) fn source(address: u8, count: usize) -> Source {
    Source {
        message: Box::new(move |at, frame| {
            let angles = ssi2::of(frame, address);
            angles.map(|angles| message(at, angles, count))
        }),
        others: None,
    }
}

/// The first angles of a group, as many as the sensor has.
fn message(at: Instant, angles: Angles, count: usize) -> Message {
    Message {
        numbers: angles.into_iter().take(count).collect(),
        ..Message::plain((at, Vec::new()))
    }
}

/// Reads the settings, and fails if they are others. False: the sensor does not answer yet.
fn is_as_before(session: &mut Session, wanted: &[(Entry, u32)]) -> Result<bool, Error> {
    for (entry, raw) in wanted {
        let present = match session.read(entry) {
            Err(failure) if failure.kind() == Kind::Silent => return Ok(false),
            present => present?,
        };
        if present != *raw {
            return Err(SensorError::Restarted.into());
        }
    }
    Ok(true)
}
