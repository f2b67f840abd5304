//! Samples that the sensor sends by itself. Its settings for that are written before, in its volatile memory only, and put back afterwards.
//!
//! - GEMAC: cyclic mode. Its counter tells how many values are missing.
//! - J1939: the broadcast of the group SSI2 with this rate.
//! - CANopen: a TPDO with an event timer.
//! - DeviceNet: an I/O connection, which the tool polls.
//!
//! Without a counter, the times of the values tell how many are missing.

mod count;
pub mod pace;

use crate::error::{Error, RequestError, Silence};
use crate::link::Link;
use crate::note::Note;
use crate::output::Terminal;
use crate::question::Question;
use crate::sample::{Sample, Sampler};
use crate::session::Session;
use crate::sheet::Entry;
use count::Count;
use plumbline::can::{CanId, Frame};
use plumbline::param::{DataType, ParameterId};
use plumbline::time::{Duration, Instant, after, millis};

/// The longest wait without a check for Ctrl-C.
pub(crate) const SLICE: Duration = millis(50);

/// The permitted delay of a value: a number of periods plus a time. After it the tool assumes that no value comes any more.
const LATE: (u64, Duration) = (3, millis(1000));

/// How long the messages of a sensor are listened to that sends by itself, and how many are sufficient to know their period.
pub(crate) const LISTENS: (Duration, usize) = (millis(1100), 20);

/// The messages with angles that a sensor sends.
pub trait Stream {
    /// The next angles within this time. `wanted` are the settings that the tool has written.
    ///
    /// # Errors
    /// The sensor has restarted, or the adapter fails.
    fn next(
        &mut self,
        session: &mut Session,
        sampler: &Sampler,
        wanted: &[(Entry, u32)],
        time: Duration,
    ) -> Result<Option<Message>, Error>;

    /// Ends it.
    ///
    /// # Errors
    /// The sensor refuses, nobody answers, or the adapter fails.
    fn stop(&mut self, _session: &mut Session) -> Result<(), Error> {
        Ok(())
    }

    /// What the user must know if it could not be ended.
    fn left(&self) -> Note {
        Note::NotPutBack
    }

    /// The polls that must have been answered; None: the tool does not poll.
    fn polled(&self, _now: Instant) -> Option<u64> {
        None
    }

    /// The period in ms with which the sensor sends already, by the settings before.
    fn period(&self, _before: &[(Entry, u32)]) -> Option<u32> {
        None
    }
}

/// A stream that begins as soon as these settings are written.
pub struct Started {
    /// The messages.
    pub stream: Box<dyn Stream>,
    /// The period; None: it is not known.
    pub every: Option<Duration>,
    /// The parameters and their numbers.
    pub settings: Vec<(ParameterId, u32)>,
}

impl Started {
    /// A stream that has begun.
    pub(crate) fn now(stream: impl Stream + 'static, every: Option<Duration>) -> Self {
        Self {
            stream: Box::new(stream),
            every,
            settings: Vec::new(),
        }
    }
}

/// Decodes the angles in a frame that came at a time.
type Decode = dyn Fn(Instant, &Frame) -> Option<Message>;

/// The messages in which a sensor sends its angles by itself. The tool only receives them: it sends nothing, and changes no setting.
pub struct Source {
    /// The angles in a frame that came at this time; None: it is another message.
    pub(crate) message: Box<Decode>,
    /// The angles in them, if they are other entries than those that are polled.
    pub others: Option<Vec<Entry>>,
}

/// A sensor that sends its angles by itself.
pub struct Cyclic {
    stream: Box<dyn Stream>,
    /// The period; None: it is not known.
    every: Option<Duration>,
    /// The settings while the sensor sends, and the settings before.
    wanted: Vec<(Entry, u32)>,
    before: Vec<(Entry, u32)>,
    count: Count,
}

/// A received message with angles.
pub struct Message {
    pub(crate) at: Instant,
    pub(crate) numbers: Vec<Option<i64>>,
    pub(crate) status: Option<u8>,
    pub(crate) counter: Option<u16>,
}

impl Message {
    pub(crate) fn plain((at, numbers): (Instant, Vec<i64>)) -> Self {
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
        let target = session.target;
        let Started {
            stream,
            every,
            settings,
        } = target.stream(session, sampler, every, terminal)?;
        let (wanted, before) = present(session, settings)?;
        if let Some(own) = stream
            .period(&before)
            .filter(|own| Some(millis(*own)) != every)
            && !terminal.ask(&Question::Period(own))?
        {
            return Err(RequestError::PeriodNotConfirmed(own).into());
        }
        let mut cyclic = Self {
            stream,
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
        let mut written = self.stream.stop(session);
        for (entry, raw) in std::mem::take(&mut self.before).into_iter().rev() {
            let put_back = session.put_back(&entry, raw);
            written = written.and(put_back);
        }
        session.link.set_ending(was_ending);
        if written.is_err() {
            session.note(self.stream.left());
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
        let message = self.stream.next(session, sampler, &self.wanted, time)?;
        let Some(message) = message else {
            return self.silence(session.link.now());
        };
        let restarts = self.count.restarts();
        let time = self.count.take(message.at, message.counter);
        if restarts == 0 && self.count.restarts() > 0 {
            session.note(Note::CounterRestarted);
        }
        Ok(Some(Sample {
            time,
            numbers: sampler.taken(message.numbers),
            status: message.status,
        }))
    }

    /// Counts the values that are missing until the end.
    pub fn end(&self, sampler: &mut Sampler, now: Instant) {
        sampler.lost = match self.stream.polled(now) {
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
        Err(Silence::AnglesEnded.into())
    }
}

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
        permitted?;
        let present = session.read(&entry)?;
        before.push((entry.clone(), present));
        wanted.push((entry, raw));
    }
    Ok((wanted, before))
}

/// Where the values are in a message.
#[derive(Clone, Debug)]
pub(crate) struct Layout {
    pub id: CanId,
    /// The size of the data in bytes, at least.
    pub size: usize,
    /// The first bit and the type of each value.
    pub places: Vec<(u32, DataType)>,
}

impl Layout {
    /// The values in a frame; None: it is another message.
    pub fn decode(&self, frame: &Frame) -> Option<Vec<i64>> {
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
    pub fn next(
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
    pub fn period(layouts: &[Self], link: &mut Link) -> Result<Option<Duration>, Error> {
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
