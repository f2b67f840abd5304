//! The angles in the reply to a function select code, which the sensor also sends by itself in cyclic mode.

use super::tables;
use crate::cyclic::{Message, Source, Started, Stream};
use crate::error::{Error, Silence, What};
use crate::master::fsc::request::{self as fsc, Reply, Sensor};
use crate::number::Scale;
use crate::sample::{Poller, Read, Sampler};
use crate::session::{Session, unexpected};
use crate::sheet::{Address, Entry};
use plumbline::can::Frame;
use plumbline::param::number;
use plumbline::time::{Duration, Instant, millis};

/// The angles of a sensor, which are all in one reply.
#[derive(Clone)]
pub(super) struct Angles {
    sensor: Sensor,
    code: u8,
    entries: Vec<Entry>,
    /// The bytes of the angles in the reply. The counter of cyclic mode is behind them.
    size: usize,
}

impl Angles {
    pub(super) fn of(sensor: Sensor, entries: Vec<Entry>) -> Option<Self> {
        let Address::Fsc { read, .. } = entries.first()?.address else {
            return None;
        };
        let ends = entries.iter().map(|entry| match entry.address {
            Address::Fsc { offset, .. } => offset + entry.data_type.size(),
            _ => 0,
        });
        Some(Self {
            sensor,
            code: read,
            size: ends.max().unwrap_or(0).into(),
            entries,
        })
    }

    /// The angles in a reply; None: it is too short.
    fn decode(&self, reply: &Reply) -> Option<Vec<i64>> {
        let angles = self.entries.iter().map(|entry| {
            let Address::Fsc { offset, .. } = entry.address else {
                return None;
            };
            let from = usize::from(offset);
            let to = from + usize::from(entry.data_type.size());
            let bytes = reply.data.get(from..to)?;
            Some(entry.data_type.value(number(bytes)))
        });
        angles.collect()
    }

    /// The angles of cyclic mode in a frame. A reply to a request has no counter.
    fn message(&self, at: Instant, frame: &Frame) -> Option<Message> {
        let reply = fsc::reply(frame, self.sensor, self.code)?;
        let counter = reply.data.get(self.size..self.size + 2).map(number)?;
        Some(Message {
            status: Some(reply.status),
            counter: Some(counter as u16),
            ..Message::plain((at, self.decode(&reply)?))
        })
    }

    /// The messages of cyclic mode.
    pub(super) fn source(self) -> Source {
        Source {
            message: Box::new(move |at, frame| self.message(at, frame)),
            others: None,
        }
    }

    /// Cyclic mode with this period in ms.
    pub(super) fn start(self, session: &Session, every: u32) -> Result<Started, Error> {
        let tables = tables(session.sheet.product).ok_or_else(|| unexpected(What::CyclicMode))?;
        let roles = &tables.roles;
        Ok(Started {
            stream: Box::new(self),
            every: Some(millis(every)),
            settings: vec![(roles.cyclic_time, every), (roles.cyclic_mode, 1)],
        })
    }
}

impl Stream for Angles {
    fn next(
        &mut self,
        session: &mut Session,
        _sampler: &Sampler,
        _wanted: &[(Entry, u32)],
        time: Duration,
    ) -> Result<Option<Message>, Error> {
        let judge = |frame: &Frame| self.message(Instant::from_ticks(0), frame);
        let message = session.link.wait_for_at(time, judge)?;
        Ok(message.map(|(at, message)| Message { at, ..message }))
    }

    fn period(&self, before: &[(Entry, u32)]) -> Option<u32> {
        match before {
            [(_, period), (_, 1)] => Some(*period),
            _ => None,
        }
    }
}

/// Polls all angles and the status with one request.
pub(super) struct Polled(pub Sensor);

impl Poller for Polled {
    fn poll(&mut self, session: &mut Session, angles: &[(Entry, Scale)]) -> Result<Read, Error> {
        let silent = || Error::from(Silence::Request);
        let entries = angles.iter().map(|(entry, _)| entry.clone());
        let angles = Angles::of(self.0, entries.collect()).ok_or_else(silent)?;
        let reply = fsc::ask(&mut session.link, self.0, angles.code, &[], fsc::ANSWER)?;
        let reply = reply.ok_or_else(silent)?;
        let numbers = angles.decode(&reply).ok_or_else(silent)?;
        Ok((numbers.into_iter().map(Some).collect(), Some(reply.status)))
    }

    fn has_status(&self) -> bool {
        true
    }
}
