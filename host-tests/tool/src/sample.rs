//! Samples of the angles, by polling: the settings of the sensor stay as they are. In J1939 they are in the group SSI2, which the sensor
//! broadcasts, or sends on request.

pub mod ssi2;

use crate::client::fsc;
use crate::error::Error;
use crate::master::{Ca, Target};
use crate::number::Scale;
use crate::session::Session;
use crate::sheet::{Address, Entry};
use plumbline::model::catalog::Protocol;
use plumbline::param::{DataType, number};
use plumbline::time::{Duration, Instant, after, millis};
use serde_json::{Map, Number, Value, json};

/// How long a broadcast is waited for before it is requested.
const BROADCAST: Duration = millis(50);

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
type Read = (Vec<Option<i64>>, Option<u8>);

/// The slopes with 16 bits (CiA 410).
const SHORT: [u16; 2] = [0x6010, 0x6020];

/// The largest inclination in degrees. At a fine resolution, 16 bits cannot represent it.
const LARGEST: f64 = 180.0;

/// The angles of a sensor.
pub struct Sampler {
    angles: Vec<(Entry, Scale)>,
    /// All are in the reply to one function select code, with the status, or in one group of J1939.
    in_one_reply: bool,
    /// A sample has the status of the sensor.
    has_status: bool,
    start: Instant,
    /// The place of the last poll on the grid of the period.
    place: Option<u64>,
    /// J1939: nobody broadcasts the angles, so they are requested.
    requests: bool,
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
                let message = "the data sheet does not say which values are angles: give names, `plumbline parameters` lists them";
                return Err(Error::usage("no-angles", message));
            }
            Some(data_sheet) => data_sheet.angles.clone(),
            None => {
                let angles = sheet.product.guide.angles.iter();
                angles.filter_map(|id| sheet.value(*id)).cloned().collect()
            }
        };
        let mut sampler = Self {
            in_one_reply: matches!(session.target, Target::Fsc(_) | Target::J1939(_)),
            has_status: matches!(session.target, Target::Fsc(_)),
            ..Self::of(session, angles)?
        };
        if let Target::J1939(Ca(address)) = session.target {
            let first = sampler.ssi2(session, address)?;
            // A sensor with one axis has one angle. A sensor that measures nothing now does not tell the number of its axes.
            let first = first.filter(|angles| angles.iter().any(Option::is_some));
            let measured = |place: usize| first.is_none_or(|angles| angles[place].is_some());
            let angles = sampler.angles.into_iter().zip(0..ssi2::COUNT);
            let angles = angles.filter(|(_, place)| measured(*place));
            sampler.angles = angles.map(|((entry, _), _)| (entry, ssi2::FINE)).collect();
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
            in_one_reply: false,
            has_status: false,
            angles,
            start: session.link.now(),
            place: None,
            requests: false,
            printed: 0,
            lost: 0,
            invalid: 0,
            unanswered: None,
        })
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
        let read = match session.target {
            Target::Fsc(sensor) if self.in_one_reply => self.poll_fsc(session, sensor),
            Target::J1939(Ca(address)) if self.in_one_reply => self.poll_j1939(session, address),
            _ => self.poll_each(session),
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
            Err(failure) if failure.code == "no-answer" => {
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

    /// All angles are in one reply.
    fn poll_fsc(&self, session: &mut Session, sensor: fsc::Sensor) -> Result<Read, Error> {
        let silent = || Error::silent("no-answer", "the sensor does not answer");
        let code = self.code().ok_or_else(silent)?;
        let reply =
            fsc::ask(&mut session.link, sensor, code, &[], fsc::ANSWER)?.ok_or_else(silent)?;
        let numbers = self.decode(&reply).ok_or_else(silent)?;
        Ok((numbers.into_iter().map(Some).collect(), Some(reply.status)))
    }

    /// The code of the request for the angles.
    pub(crate) fn code(&self) -> Option<u8> {
        let (entry, _) = self.angles.first()?;
        match entry.address {
            Address::Fsc { read, .. } => Some(read),
            _ => None,
        }
    }

    /// The bytes of the angles in a reply. Behind them is the counter of cyclic mode.
    pub(crate) fn size(&self) -> usize {
        let ends = self.angles.iter().map(|(entry, _)| match entry.address {
            Address::Fsc { offset, .. } => offset + entry.data_type.size(),
            _ => 0,
        });
        ends.max().unwrap_or(0).into()
    }

    /// The angles in a reply; None: it is too short.
    pub(crate) fn decode(&self, reply: &fsc::Reply) -> Option<Vec<i64>> {
        angles_in(reply, self.angles.iter().map(|(entry, _)| entry))
    }

    fn poll_j1939(&mut self, session: &mut Session, address: u8) -> Result<Read, Error> {
        let silent = || Error::silent("no-answer", "the sensor does not send its angles");
        let angles = self.ssi2(session, address)?.ok_or_else(silent)?;
        Ok((self.of_group(angles), None))
    }

    /// The angles of SSI2 that this sensor has.
    pub(crate) fn of_group(&self, angles: ssi2::Angles) -> Vec<Option<i64>> {
        angles.into_iter().take(self.angles.len()).collect()
    }

    fn ssi2(&mut self, session: &mut Session, address: u8) -> Result<Option<ssi2::Angles>, Error> {
        let link = &mut session.link;
        if !self.requests {
            if let Some(angles) = ssi2::broadcast(link, address, BROADCAST)? {
                return Ok(Some(angles));
            }
            self.requests = true;
        }
        ssi2::request(link, address)
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
        if self.has_status {
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
    pub fn summary(&self) -> Vec<String> {
        let all = self.printed + self.lost;
        let lost = format!("{} of {all} samples lost", self.lost);
        let invalid = (self.invalid > 0).then(|| {
            let count = self.invalid;
            format!(
                "{count} samples have an empty value: the sensor sent no valid angle, or the angle does not fit in 16 bits at this resolution (in this case set resolution, or leave out --cyclic)"
            )
        });
        invalid.into_iter().chain([lost]).collect()
    }
}

/// The angles in the reply to a function select code; None: it is too short.
pub(crate) fn angles_in<'a>(
    reply: &fsc::Reply,
    angles: impl Iterator<Item = &'a Entry>,
) -> Option<Vec<i64>> {
    let angles = angles.map(|entry| {
        let Address::Fsc { offset, .. } = entry.address else {
            return None;
        };
        let from = usize::from(offset);
        let bytes = reply
            .data
            .get(from..from + usize::from(entry.data_type.size()))?;
        Some(entry.data_type.value(number(bytes)))
    });
    angles.collect()
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
    match (&session.sheet.product.protocol, sample.status) {
        (Protocol::Fsc(tables), Some(status)) => fsc::names(&tables.status, status),
        _ => Vec::new(),
    }
}

#[cfg(test)]
mod tests;
