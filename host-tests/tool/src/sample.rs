//! Samples of the angles, by polling: the settings of the sensor stay as they are.

use crate::client::fsc;
use crate::failure::Failure;
use crate::number::Scale;
use crate::session::{Session, Target};
use crate::sheet::{Address, Entry};
use plumbline::model::catalog::Protocol;
use plumbline::param::number;
use plumbline::time::{Duration, Instant, after, millis};
use serde_json::{Map, Number, Value, json};

/// The longest wait without a look at Ctrl-C.
const SLICE: Duration = millis(50);

/// A sample.
#[derive(Clone, Debug)]
pub struct Sample {
    /// The time since the first sample.
    pub time: Duration,
    /// The raw numbers, in the order of the columns.
    pub numbers: Vec<i64>,
    /// The status byte of a sensor with function select codes.
    pub status: Option<u8>,
}

/// The angles of a sensor.
pub struct Sampler {
    angles: Vec<(Entry, Scale)>,
    start: Instant,
    /// The polls until now.
    pub polls: u64,
    /// The polls without an answer.
    pub lost: u64,
}

impl Sampler {
    /// The angles of the sensor of a session.
    ///
    /// # Errors
    /// The sensor refuses, nobody answers, or those of the adapter.
    pub fn new(session: &mut Session) -> Result<Self, Failure> {
        let mut angles = Vec::new();
        for id in session.sheet.product.guide.angles {
            if let Some(entry) = session.sheet.value(*id).cloned() {
                let scale = session.scale_of(&entry)?;
                angles.push((entry, scale));
            }
        }
        Ok(Self {
            angles,
            start: session.link.now(),
            polls: 0,
            lost: 0,
        })
    }

    /// Polls once; None if nobody answers.
    ///
    /// # Errors
    /// The sensor refuses, or those of the adapter.
    pub fn poll(&mut self, session: &mut Session) -> Result<Option<Sample>, Failure> {
        self.polls += 1;
        let time = Duration::from_ticks(session.link.now().ticks() - self.start.ticks());
        let read = match session.target {
            Target::Fsc(sensor) => self.poll_fsc(session, sensor),
            _ => self.poll_each(session),
        };
        match read {
            Ok((numbers, status)) => Ok(Some(Sample {
                time,
                numbers,
                status,
            })),
            Err(failure) if failure.code == "no-answer" => {
                self.lost += 1;
                Ok(None)
            }
            Err(failure) => Err(failure),
        }
    }

    /// All angles are in one reply.
    fn poll_fsc(
        &self,
        session: &mut Session,
        sensor: fsc::Sensor,
    ) -> Result<(Vec<i64>, Option<u8>), Failure> {
        let silent = || Failure::silent("no-answer", "the sensor does not answer");
        let Some((
            Entry {
                address: Address::Fsc { read, .. },
                ..
            },
            _,
        )) = self.angles.first()
        else {
            return Err(silent());
        };
        let reply =
            fsc::ask(&mut session.link, sensor, *read, &[], fsc::ANSWER)?.ok_or_else(silent)?;
        let mut numbers = Vec::new();
        for (entry, _) in &self.angles {
            let Address::Fsc { offset, .. } = entry.address else {
                continue;
            };
            let from = usize::from(offset);
            let bytes = reply
                .data
                .get(from..from + usize::from(entry.data_type.size()));
            numbers.push(entry.data_type.value(number(bytes.ok_or_else(silent)?)));
        }
        Ok((numbers, Some(reply.status)))
    }

    fn poll_each(&self, session: &mut Session) -> Result<(Vec<i64>, Option<u8>), Failure> {
        let mut numbers = Vec::new();
        for (entry, _) in &self.angles {
            numbers.push(entry.data_type.value(session.read(entry)?));
        }
        Ok((numbers, None))
    }

    /// The heading of a table of samples.
    pub fn heading(&self, session: &Session) -> String {
        let mut columns = vec!["time_s".to_owned()];
        for (entry, scale) in &self.angles {
            columns.push(format!("{}_{}", entry.name, scale.unit));
        }
        if let Target::Fsc(_) = session.target {
            columns.push("status".to_owned());
        }
        columns.join(",")
    }

    /// A row of a table of samples.
    pub fn row(&self, sample: &Sample) -> String {
        let mut columns = vec![seconds(sample.time)];
        for ((_, scale), number) in self.angles.iter().zip(&sample.numbers) {
            columns.push(scale.value(*number));
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
            document.insert(entry.name.clone(), float(&scale.value(*number)));
        }
        if sample.status.is_some() {
            document.insert("status".to_owned(), json!(status(session, sample)));
        }
        Value::Object(document)
    }

    /// A sample as a line.
    pub fn line(&self, session: &Session, sample: &Sample) -> String {
        let angles = self.angles.iter().zip(&sample.numbers);
        let mut parts: Vec<String> = angles
            .map(|((entry, scale), number)| {
                format!("{} {:>11}", entry.name, scale.with_unit(*number))
            })
            .collect();
        parts.insert(0, format!("{:>8} s", seconds(sample.time)));
        parts.push(status(session, sample).join(" "));
        parts.join("  ").trim_end().to_owned()
    }

    /// Waits until the next poll of a grid with this period. False: `stopped` has returned true.
    ///
    /// # Errors
    /// Those of the adapter.
    pub fn wait(
        &self,
        session: &mut Session,
        every: Duration,
        stopped: &dyn Fn() -> bool,
    ) -> Result<bool, Failure> {
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

    /// The polls without an answer, as a sentence.
    pub fn summary(&self) -> String {
        format!("{} of {} samples lost", self.lost, self.polls)
    }
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
