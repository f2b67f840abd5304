//! Samples that the sensor sends by itself. Its settings for that are written before, in its volatile memory only, and put back afterwards.
//!
//! - GEMAC: cyclic mode. Its counter tells how many values are missing.
//! - `j1939`: the broadcast of the group SSI2 with this rate.
//! - `canopen`: a TPDO with an event timer.
//! - `devicenet`: an I/O connection, which the tool polls.
//!
//! Without a counter, the times of the values tell how many are missing.

mod canopen;
mod count;
mod devicenet;
mod j1939;
pub mod pace;
pub mod source;

use crate::client::Link;
use crate::client::fsc::{self, Sensor};
use crate::error::Error;
use crate::master;
use crate::master::{Ca, Node, Target};
use crate::output::Terminal;
use crate::question::Question;
use crate::sample::{Sample, Sampler};
use crate::session::Session;
use crate::sheet::Entry;
use count::Count;
use plumbline::can::{CanId, Frame};
use plumbline::model::catalog::Protocol;
use plumbline::param::{DataType, ParameterId, Setting, number};
use plumbline::time::{Duration, Instant, after, millis};

/// The longest wait without a check for Ctrl-C.
const SLICE: Duration = millis(50);

/// The permitted delay of a value: a number of periods plus a time. After it the tool assumes that no value comes any more.
const LATE: (u64, Duration) = (3, millis(1000));

/// How long the messages of a sensor are listened to that sends by itself, and how many are sufficient to know their period.
const LISTENS: (Duration, usize) = (millis(1100), 20);

/// The kind of messages with angles.
enum Kind {
    Fsc(Sensor),
    J1939(j1939::Sender),
    Canopen(canopen::Pdo),
    Devicenet(devicenet::Io),
}

/// A sensor that sends its angles by itself.
pub struct Cyclic {
    kind: Kind,
    /// The period; None: it is not known.
    every: Option<Duration>,
    /// The settings while the sensor sends, and the settings before.
    wanted: Vec<(Entry, u32)>,
    before: Vec<(Entry, u32)>,
    count: Count,
}

/// A received message with angles.
pub(crate) struct Message {
    pub(crate) at: Instant,
    pub(crate) numbers: Vec<Option<i64>>,
    pub(crate) status: Option<u8>,
    counter: Option<u16>,
}

impl Message {
    fn plain((at, numbers): (Instant, Vec<i64>)) -> Self {
        Self {
            at,
            numbers: numbers.into_iter().map(Some).collect(),
            status: None,
            counter: None,
        }
    }
}

impl Cyclic {
    /// Lets the sensor send with a period of `every` ms. The sampler gets the values that the sensor sends.
    ///
    /// # Errors
    /// The sensor cannot do it, refuses it, nobody answers, or the adapter fails.
    pub fn start(
        session: &mut Session,
        sampler: &mut Sampler,
        every: u32,
        terminal: &mut Terminal,
    ) -> Result<Self, Error> {
        let period = Some(millis(every));
        let (kind, every, settings) = match (session.target, &session.sheet.product.protocol) {
            (Target::Fsc(sensor), Protocol::Fsc(tables)) => {
                let roles = &tables.roles;
                let settings = vec![(roles.cyclic_time, every), (roles.cyclic_mode, 1)];
                (Kind::Fsc(sensor), period, settings)
            }
            (Target::J1939(Ca(address)), _) => {
                let tables = master::j1939::tables(session.sheet.product);
                let rate = tables.and_then(|tables| match (tables.settings)(0) {
                    Some((Setting::Parameter(rate), _)) => Some((rate, every)),
                    _ => None,
                });
                let sender = j1939::Sender::new(address);
                (Kind::J1939(sender), period, rate.into_iter().collect())
            }
            (Target::Canopen(Node(node)), _) => {
                let (pdo, every) = canopen::start(session, node, sampler, every, terminal)?;
                (Kind::Canopen(pdo), every, Vec::new())
            }
            (Target::Devicenet(slave), Protocol::Devicenet(tables)) => {
                let place = (slave, tables);
                let (io, every) = devicenet::start(session, place, sampler, every, terminal)?;
                (Kind::Devicenet(io), every, Vec::new())
            }
            _ => {
                let message = "the product does not fit the protocol of the sensor";
                return Err(Error::usage("wrong-product", message));
            }
        };
        let (wanted, before) = present(session, settings)?;
        if let Some(own) = sends_already(&kind, &before).filter(|own| Some(millis(*own)) != every)
            && !terminal.ask(&Question::Period(own))?
        {
            let message = format!(
                "nothing has changed: --every {own} keeps the period, --yes=cyclic answers the question"
            );
            return Err(Error::usage("not-confirmed", message));
        }
        let mut cyclic = Self {
            kind,
            every,
            wanted: wanted.clone(),
            before,
            count: Count::new(every, session.link.now()),
        };
        for setting in wanted {
            if let Err(failure) = session.write(&[setting]) {
                // The cause is the failure of the write.
                let _ = cyclic.stop(session);
                return Err(failure);
            }
        }
        cyclic.count = Count::new(every, session.link.now());
        Ok(cyclic)
    }

    /// The settings as they were, in the reverse order, also if the user wants to stop.
    ///
    /// # Errors
    /// The sensor refuses, nobody answers, or the adapter fails.
    pub fn stop(&mut self, session: &mut Session) -> Result<(), Error> {
        let was_ending = session.link.set_ending(true);
        let mut written = match &mut self.kind {
            Kind::Canopen(pdo) => pdo.stop(session),
            Kind::Devicenet(io) => io.stop(session),
            Kind::Fsc(_) | Kind::J1939(_) => Ok(()),
        };
        for (entry, raw) in std::mem::take(&mut self.before).into_iter().rev() {
            let put_back = session.put_back(&entry, raw);
            written = written.and(put_back);
        }
        session.link.set_ending(was_ending);
        if written.is_err() {
            let note = match self.kind {
                Kind::Devicenet(_) => devicenet::NOT_RELEASED,
                Kind::Fsc(_) | Kind::J1939(_) | Kind::Canopen(_) => NOT_PUT_BACK,
            };
            session.note(note);
        }
        written
    }

    /// The next sample; None if it does not come within some time, after which the caller checks for Ctrl-C.
    ///
    /// # Errors
    /// Nothing comes any more, or the adapter fails.
    pub fn next(
        &mut self,
        session: &mut Session,
        sampler: &mut Sampler,
        until: Instant,
    ) -> Result<Option<Sample>, Error> {
        let now = session.link.now();
        let until = until.min(after(now, SLICE));
        let time = Duration::from_ticks(until.ticks().saturating_sub(now.ticks()));
        let message = match &mut self.kind {
            Kind::Fsc(sensor) => cyclic_mode(session, sampler, *sensor, time)?,
            Kind::J1939(sender) => sender.next(session, sampler, &self.wanted, time)?,
            Kind::Canopen(pdo) => pdo.next(&mut session.link, time)?.map(Message::plain),
            Kind::Devicenet(io) => io.next(&mut session.link, until)?.map(Message::plain),
        };
        let Some(message) = message else {
            return self.silence(session.link.now());
        };
        let restarts = self.count.restarts();
        let time = self.count.take(message.at, message.counter);
        if restarts == 0 && self.count.restarts() > 0 {
            session.note(RESTARTED);
        }
        Ok(Some(Sample {
            time,
            numbers: sampler.taken(message.numbers),
            status: message.status,
        }))
    }

    /// Counts the values that are missing until the end.
    pub fn end(&self, sampler: &mut Sampler, now: Instant) {
        let polled = match &self.kind {
            Kind::Devicenet(io) => io.polled(now),
            Kind::Fsc(_) | Kind::J1939(_) | Kind::Canopen(_) => None,
        };
        sampler.lost = match polled {
            Some(polled) => polled.saturating_sub(sampler.printed),
            None => self.count.missing(now),
        };
    }

    fn silence(&self, now: Instant) -> Result<Option<Sample>, Error> {
        let (periods, time) = LATE;
        let every = self.every.map_or(0, |every| every.ticks());
        let longest = periods * every + time.ticks();
        // A sensor that sends changes only can be silent for any time.
        if self.every.is_none() || self.count.silence(now).ticks() < longest {
            return Ok(None);
        }
        let message = "the sensor does not send its angles any more: check power and wiring. If it was switched off during the command, start the command again";
        Err(Error::silent("no-answer", message))
    }
}

/// The counter of a sensor began again.
const RESTARTED: &str = "the counter of the sensor started again: was the sensor off? The lost samples of this time are calculated from the time";

/// The sensor could not be put back.
const NOT_PUT_BACK: &str = "the settings of the sensor for --cyclic could not be put back. They are not stored: switch the sensor off and on, then it has its previous settings";

/// The settings with their entries, and their present numbers.
#[expect(clippy::type_complexity, reason = "two lists of the same kind")]
fn present(
    session: &mut Session,
    settings: Vec<(ParameterId, u32)>,
) -> Result<(Vec<(Entry, u32)>, Vec<(Entry, u32)>), Error> {
    let (mut wanted, mut before) = (Vec::new(), Vec::new());
    for (id, raw) in settings {
        let entry = session.entry(id)?;
        let permitted = entry.check(raw, &entry.scale);
        permitted.map_err(|why| Error::usage("out-of-range", why))?;
        let present = session.read(&entry)?;
        before.push((entry.clone(), present));
        wanted.push((entry, raw));
    }
    Ok((wanted, before))
}

/// The next reply of cyclic mode.
fn cyclic_mode(
    session: &mut Session,
    sampler: &Sampler,
    sensor: Sensor,
    time: Duration,
) -> Result<Option<Message>, Error> {
    let size = sampler.size();
    let code = sampler.code();
    let judge = |frame: &Frame| fsc::reply(frame, sensor, code?);
    let reply = session.link.wait_for_at(time, judge)?;
    // A reply to a request before cyclic mode was on has no counter.
    Ok(reply.and_then(|(at, reply)| {
        let counter = reply.data.get(size..size + 2).map(number)?;
        Some(Message {
            at,
            numbers: sampler.decode(&reply)?.into_iter().map(Some).collect(),
            status: Some(reply.status),
            counter: Some(counter as u16),
        })
    }))
}

/// The period in ms with which a sensor sends by itself already.
fn sends_already(kind: &Kind, before: &[(Entry, u32)]) -> Option<u32> {
    match (kind, before) {
        (Kind::Fsc(_), [(_, period), (_, 1)]) => Some(*period),
        (Kind::J1939(_), [(_, period @ 1..)]) => Some(*period),
        _ => None,
    }
}

/// Where the values are in a message.
#[derive(Clone, Debug)]
struct Layout {
    id: CanId,
    /// The size of the data in bytes, at least.
    size: usize,
    /// The first bit and the type of each value.
    places: Vec<(u32, DataType)>,
}

impl Layout {
    /// The values in a frame; None: it is another message.
    fn decode(&self, frame: &Frame) -> Option<Vec<i64>> {
        let bytes = frame.bytes();
        if frame.can_id() != self.id || frame.is_remote() || bytes.len() < self.size {
            return None;
        }
        let mut data = [0; 8];
        data[..bytes.len()].copy_from_slice(bytes);
        let data = u64::from_le_bytes(data);
        let values = self.places.iter().map(|(first, data_type)| {
            let bits = 8 * u32::from(data_type.size());
            let raw = data >> first & (u64::MAX >> (64 - bits));
            data_type.value(raw as u32)
        });
        Some(values.collect())
    }

    /// The next message of one of these layouts, with the time of its reception.
    fn next(
        layouts: &[Self],
        link: &mut Link,
        time: Duration,
    ) -> Result<Option<(Instant, Vec<i64>)>, Error> {
        link.wait_for_at(time, |frame| {
            layouts.iter().find_map(|layout| layout.decode(frame))
        })
    }

    /// The period of the messages with the first layout; None: they are too few or not regular. A message with another layout is one that
    /// can be sent on a change, so there is no period then.
    fn period(layouts: &[Self], link: &mut Link) -> Result<Option<Duration>, Error> {
        let (time, sufficient) = LISTENS;
        let until = after(link.now(), time);
        let mut times = Vec::new();
        while times.len() < sufficient && link.now() < until {
            let left = until.ticks().saturating_sub(link.now().ticks());
            let which = |frame: &Frame| {
                let mut layouts = layouts.iter();
                layouts.position(|layout| layout.decode(frame).is_some())
            };
            match link.wait_for_at(Duration::from_ticks(left), which)? {
                Some((at, 0)) => times.push(at),
                Some(_) => return Ok(None),
                None => {}
            }
        }
        Ok(count::period(&times))
    }
}
