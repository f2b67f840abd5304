//! Samples of the angles, by polling: the settings of the sensor stay as they are. In J1939 they are in the group SSI2, which the sensor
//! broadcasts, or sends on request.

use crate::counted::{OfSamples, Samples};
use crate::error::{Error, RequestError};
use crate::note::Note;
use crate::number::Scale;
use crate::session::Session;
use crate::sheet::{Address, Entry};
use plumbline::param::DataType;
use plumbline::time::{Duration, Instant, after, millis};
use serde_json::{Map, Number, Value, json};

/// The longest wait without a check for Ctrl-C.
const SLICE: Duration = millis(50);

/// The numbers of all values at one time.
#[derive(Clone, Debug)]
pub struct Sample {
    /// The time since the first sample.
    pub time: Duration,
    /// The raw numbers, in the order of the columns; None: the sensor has no valid angle, or its number has no room for it.
    pub numbers: Vec<Option<i64>>,
    /// The status byte of a sensor with function select codes.
    pub status: Option<u8>,
}

/// The numbers of a sample, and the status.
pub type Read = (Vec<Option<i64>>, Option<u8>);

/// Reads all angles of a sensor at once.
pub trait Poller {
    /// The angles that the sensor has, of those in its sheet.
    ///
    /// # Errors
    /// Nobody answers, or the adapter fails.
    fn begin(
        &mut self,
        _session: &mut Session,
        angles: Vec<(Entry, Scale)>,
    ) -> Result<Vec<(Entry, Scale)>, Error> {
        Ok(angles)
    }

    /// Reads them.
    ///
    /// # Errors
    /// The sensor refuses, nobody answers, or the adapter fails.
    fn poll(&mut self, session: &mut Session, angles: &[(Entry, Scale)]) -> Result<Read, Error>;

    /// Whether a sample has the status of the sensor.
    fn has_status(&self) -> bool {
        false
    }
}

/// The slopes with 16 bits (CiA 410).
const SHORT: [u16; 2] = [0x6010, 0x6020];

/// The largest inclination in degrees. At a fine resolution, 16 bits cannot represent it.
const LARGEST: f64 = 180.0;

/// The angles of a sensor.
pub struct Sampler {
    angles: Vec<(Entry, Scale)>,
    /// What reads all at once; None: each is read by itself.
    poller: Option<Box<dyn Poller>>,
    start: Instant,
    /// The place of the last poll on the grid of the period.
    place: Option<u64>,
    /// The samples that were read.
    pub printed: u64,
    /// The samples that are missing: polls without an answer, and polls whose time passed while the program waited for an earlier answer.
    pub lost: u64,
    /// The samples with a value that is not valid.
    invalid: u64,
    /// The time of the first poll without an answer since the last answer.
    unanswered: Option<Instant>,
}

impl Sampler {
    /// The angles of the sensor of a session.
    ///
    /// # Errors
    /// The sensor refuses, nobody answers, or the adapter fails.
    pub fn new(session: &mut Session) -> Result<Self, Error> {
        let sheet = &session.sheet;
        let angles: Vec<Entry> = match &sheet.data_sheet {
            Some(data_sheet) if data_sheet.angles.is_empty() => {
                return Err(RequestError::NoAngles.into());
            }
            Some(data_sheet) => data_sheet.angles.clone(),
            None => {
                let angles = sheet.product.guide.angles.iter();
                angles.filter_map(|id| sheet.value(*id)).cloned().collect()
            }
        };
        let mut sampler = Self::of(session, angles)?;
        let target = session.target;
        if let Some(mut poller) = target.poller() {
            sampler.angles = poller.begin(session, sampler.angles)?;
            sampler.poller = Some(poller);
        }
        sampler.start = session.link.now();
        Ok(sampler)
    }

    /// These values of the sensor of a session. Each is read by itself.
    ///
    /// # Errors
    /// The sensor refuses, nobody answers, or the adapter fails.
    pub fn of(session: &mut Session, entries: Vec<Entry>) -> Result<Self, Error> {
        let mut angles = Vec::new();
        for entry in entries {
            let scale = session.scale_of(&entry)?;
            angles.push((entry, scale));
        }
        Ok(Self {
            poller: None,
            angles,
            start: session.link.now(),
            place: None,
            printed: 0,
            lost: 0,
            invalid: 0,
            unanswered: None,
        })
    }

    /// The angles with the scales of the samples.
    pub(crate) fn angles(&self) -> &[(Entry, Scale)] {
        &self.angles
    }

    pub(crate) fn entries(&self) -> Vec<Entry> {
        self.angles.iter().map(|(entry, _)| entry.clone()).collect()
    }

    /// Takes the values that the sensor sends instead.
    ///
    /// # Errors
    /// The sensor refuses, nobody answers, or the adapter fails.
    pub(crate) fn take(&mut self, session: &mut Session, entries: Vec<Entry>) -> Result<(), Error> {
        self.angles = Self::of(session, entries)?.angles;
        Ok(())
    }

    /// Polls once, on a grid with this period; None if nobody answers.
    ///
    /// # Errors
    /// The sensor refuses, or the adapter fails.
    pub fn poll(
        &mut self,
        session: &mut Session,
        every: Duration,
    ) -> Result<Option<Sample>, Error> {
        let time = Duration::from_ticks(session.link.now().ticks() - self.start.ticks());
        let place = time.ticks() / every.ticks().max(1);
        let next = self.place.map_or(0, |last| last + 1);
        self.lost += place.saturating_sub(next);
        self.place = Some(place);
        let read = match &mut self.poller {
            Some(poller) => poller.poll(session, &self.angles),
            None => self.poll_each(session),
        };
        match read {
            Ok((numbers, status)) => {
                self.unanswered = None;
                Ok(Some(Sample {
                    time,
                    numbers: self.taken(numbers),
                    status,
                }))
            }
            Err(Error::Silent(_)) => {
                self.lost += 1;
                self.unanswered.get_or_insert(after(self.start, time));
                Ok(None)
            }
            Err(failure) => Err(failure),
        }
    }

    /// Counts a sample. A number that is not valid becomes None.
    pub(crate) fn taken(&mut self, numbers: Vec<Option<i64>>) -> Vec<Option<i64>> {
        let valid = |((entry, scale), number): (&(Entry, Scale), Option<i64>)| {
            number.filter(|number| !is_clipped(entry, scale, *number))
        };
        let numbers: Vec<Option<i64>> = self.angles.iter().zip(numbers).map(valid).collect();
        self.printed += 1;
        self.invalid += u64::from(numbers.contains(&None));
        numbers
    }

    fn poll_each(&self, session: &mut Session) -> Result<Read, Error> {
        let mut numbers = Vec::new();
        for (entry, _) in &self.angles {
            numbers.push(Some(entry.data_type.value(session.read_once(entry)?)));
        }
        Ok((numbers, None))
    }

    /// The heading of a table of samples.
    pub fn heading(&self) -> String {
        let mut columns = vec!["time_s".to_owned()];
        for (entry, scale) in &self.angles {
            columns.push(match scale.unit {
                "" => entry.name.clone(),
                unit => format!("{}_{unit}", entry.name),
            });
        }
        if self
            .poller
            .as_ref()
            .is_some_and(|poller| poller.has_status())
        {
            columns.push("status".to_owned());
        }
        columns.join(",")
    }

    /// A row of a table of samples.
    pub fn row(&self, sample: &Sample) -> String {
        let mut columns = vec![seconds(sample.time)];
        for ((_, scale), number) in self.angles.iter().zip(&sample.numbers) {
            columns.push(number.map_or(String::new(), |number| scale.value(number)));
        }
        if let Some(status) = sample.status {
            columns.push(format!("{status:02X}"));
        }
        columns.join(",")
    }

    /// A sample as a document.
    pub fn json(&self, session: &Session, sample: &Sample) -> Value {
        let float = |text: &str| text.parse::<Number>().map_or(Value::Null, Value::Number);
        let mut document = Map::new();
        document.insert("time".to_owned(), float(&seconds(sample.time)));
        for ((entry, scale), number) in self.angles.iter().zip(&sample.numbers) {
            let value = number.map_or(Value::Null, |number| float(&scale.value(number)));
            document.insert(entry.name.clone(), value);
        }
        if sample.status.is_some() {
            document.insert("status".to_owned(), json!(status(session, sample)));
        }
        Value::Object(document)
    }

    /// A sample as a line of text.
    pub fn line(&self, session: &Session, sample: &Sample) -> String {
        let angles = self.angles.iter().zip(&sample.numbers);
        let mut parts: Vec<String> = angles
            .map(|((entry, scale), number)| {
                let value = number.map_or("-".to_owned(), |number| scale.with_unit(number));
                format!("{} {value:>11}", entry.name)
            })
            .collect();
        parts.insert(0, format!("{:>8} s", seconds(sample.time)));
        parts.push(status(session, sample).join(" "));
        parts.join("  ").trim_end().to_owned()
    }

    /// Waits until the next poll of a grid with this period. False: `stopped` has returned true.
    ///
    /// # Errors
    /// The adapter fails.
    pub fn wait(
        &self,
        session: &mut Session,
        every: Duration,
        stopped: &dyn Fn() -> bool,
    ) -> Result<bool, Error> {
        let passed = session.link.now().ticks() - self.start.ticks();
        let period = every.ticks().max(1);
        let next = Instant::from_ticks(self.start.ticks() + (passed / period + 1) * period);
        while session.link.now() < next {
            if stopped() {
                return Ok(false);
            }
            let until = after(session.link.now(), SLICE).min(next);
            session.link.receive(until)?;
        }
        Ok(!stopped())
    }

    /// How long the sensor has answered no poll; 0: it has answered the last one.
    pub fn silence(&self, now: Instant) -> Duration {
        let since = self.unanswered.unwrap_or(now);
        Duration::from_ticks(now.ticks().saturating_sub(since.ticks()))
    }

    /// The end of polls that last this long. It is on the grid of the polls, so a poll at the end is not expected.
    #[must_use]
    pub fn end_after(&self, seconds: Duration) -> Instant {
        after(self.start, seconds)
    }

    /// Counts the polls that are missing until the end: the last answer came after their time.
    pub fn end(&mut self, until: Instant, every: Duration) {
        let passed = until.ticks().saturating_sub(self.start.ticks());
        let polls = passed.div_ceil(every.ticks().max(1));
        let next = self.place.map_or(0, |last| last + 1);
        self.lost += polls.saturating_sub(next);
    }

    /// What the user must know of the samples at the end: values that are not valid, and the missing samples.
    pub fn summary(&self) -> Vec<Note> {
        let lost = Note::LostSamples(self.lost, OfSamples(self.printed + self.lost));
        let invalid = (self.invalid > 0).then_some(Note::NoValue(Samples(self.invalid)));
        invalid.into_iter().chain([lost]).collect()
    }
}

/// Whether a number is the end of 16 bits that have no room for all angles: the sensor sends it for larger ones too.
fn is_clipped(entry: &Entry, scale: &Scale, number: i64) -> bool {
    let is_short = matches!(entry.address, Address::Object { index, sub: 0 } if SHORT.contains(&index))
        && entry.data_type == DataType::I16;
    let (low, high) = entry.data_type.range();
    // Without a unit the resolution is not known.
    let largest = scale.value(high).parse().unwrap_or(0.0);
    let has_room = scale.unit == "deg" && largest >= LARGEST;
    is_short && !has_room && (number <= low || number >= high)
}

fn seconds(time: Duration) -> String {
    let ticks = time.ticks();
    format!("{}.{:03}", ticks / 1_000_000, ticks / 1000 % 1000)
}

/// The names of the bits of the status byte.
fn status(session: &Session, sample: &Sample) -> Vec<&'static str> {
    let conditions = sample
        .status
        .map(|status| session.target.conditions(session.sheet.product, status));
    let names = conditions.into_iter().flatten().map(|bit| bit.name);
    names.collect()
}

#[cfg(test)]
mod tests;
