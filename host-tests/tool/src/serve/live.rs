//! The session whose angles are shown. Angles that the sensor sends by itself are taken; it is polled for those that it does not send.

mod condition;
mod sends;

use super::events::{Hub, Kind};
use super::lease::Lease;
use super::sheets::Sheets;
use crate::cyclic::pace::Pace;
use crate::error::{Error, RequestError};
use crate::identify::Found;
use crate::master::Storing;
use crate::master::canopen::error_register;
use crate::sample::{Sample, Sampler};
use crate::scan::kbits;
use crate::session::Session;
use crate::sheet::Entry;
use plumbline::time::{Duration, Instant, after, millis};
use serde_json::{Value, json};
use texts::{Kind as Refusal, Text};

/// The longest wait without a check for jobs.
const SLICE: Duration = millis(20);

/// The pause between two events with samples.
const BATCH: Duration = millis(50);

/// The pause between two polls of a sensor that does not answer.
const SILENT: Duration = millis(500);

/// The same for another sensor in the chart: its time-outs delay the polls of the sensor of the session.
const OTHER_SILENT: Duration = millis(5000);

/// The pause between two reads of the error register.
const CONDITION: Duration = millis(1000);

/// The polls without an answer after which a sensor is silent.
const STREAK: u32 = 3;

/// A session with its samples.
pub struct Live {
    /// The session with the sensor.
    pub session: Session,
    /// What the sensor has told.
    pub found: Found,
    /// It is the sensor of the session, not another one in the chart.
    is_main: bool,
    /// The number of the sensor, for the page: another sensor has another one.
    pub connection: u64,
    /// None: the data sheet of the device does not say which values are angles.
    sampler: Option<Sampler>,
    /// The adapter, which keeps the messages that the sensor sends by itself.
    lease: Lease,
    /// The scale of these messages, if it is another one than that of the replies.
    sent: Option<Sampler>,
    pace: Pace,
    /// The start of the time axis.
    origin: Instant,
    /// The start of the time of the sampler, from the origin.
    offset: Duration,
    next: Instant,
    /// The pause between two samples; None: no samples.
    period: Option<Duration>,
    /// The number of the next sample.
    number: u64,
    rows: Vec<Value>,
    flushed: Instant,
    /// The polls that are missing.
    lost: u64,
    streak: u32,
    /// The error register of CANopen. A reply of GEMAC has a status byte; DeviceNet has no status.
    register: Option<Entry>,
    condition_at: Instant,
    condition: Value,
}

impl Live {
    /// Samples of a new session.
    ///
    /// # Errors
    /// The sensor refuses, nobody answers, or the adapter fails.
    pub fn new(
        mut session: Session,
        (found, connection): (Found, u64),
        lease: Lease,
        samples_per_second: u32,
    ) -> Result<Self, Error> {
        session.expected = found.identity().serial();
        let sampler = sampler(&mut session)?;
        let now = session.link.now();
        let is_register = |entry: &&Entry| entry.address == error_register::ADDRESS;
        let register = session.sheet.entries.iter().find(is_register).cloned();
        let mut live = Self {
            session,
            found,
            is_main: true,
            connection,
            sampler,
            lease,
            sent: None,
            pace: Pace::default(),
            origin: now,
            offset: millis(0),
            next: now,
            period: None,
            number: 0,
            rows: Vec::new(),
            flushed: now,
            lost: 0,
            streak: 0,
            register,
            condition_at: now,
            condition: Value::Null,
        };
        live.follow()?;
        live.set_rate(samples_per_second);
        Ok(live)
    }

    /// Shows the samples on the time axis of the sensor of the session, as those of another one.
    ///
    /// # Errors
    /// The adapter fails.
    pub fn join(&mut self, main: &Self) -> Result<(), Error> {
        (self.is_main, self.origin) = (false, main.origin);
        self.resume()
    }

    /// When the next sample is due, or must be published.
    pub fn due(&self) -> Instant {
        let flush = after(self.flushed, BATCH);
        self.period.map_or(flush, |_| self.next.min(flush))
    }

    /// The samples that are missing.
    pub fn lost(&self) -> u64 {
        self.lost + self.pace.missing()
    }

    /// Sets the samples per second; 0 is none.
    pub fn set_rate(&mut self, samples_per_second: u32) {
        let period = 1_000_000_u64.checked_div(samples_per_second.into());
        let period = period.filter(|_| self.sampler.is_some());
        self.period = period.map(|period| Duration::from_ticks(period.max(1)));
        self.next = self.session.link.now();
    }

    /// Releases the sensor for a command, also if the user has stopped the one before.
    ///
    /// # Errors
    /// The adapter fails.
    pub fn release(&mut self) -> Result<(), Error> {
        let was_ending = self.session.link.set_ending(true);
        let released = self.session.release();
        self.session.link.set_ending(was_ending);
        released
    }

    /// Whether the sensor does not answer.
    pub fn is_silent(&self) -> bool {
        self.streak >= STREAK
    }

    /// A command has run: the scale can differ, and the pause is not a loss.
    ///
    /// # Errors
    /// The adapter fails.
    pub fn resume(&mut self) -> Result<(), Error> {
        let now = self.session.link.now();
        match sampler(&mut self.session) {
            Ok(sampler) => {
                self.sampler = sampler;
                self.offset = Duration::from_ticks(now.ticks() - self.origin.ticks());
            }
            Err(failure) if failure.kind() == Refusal::Bus => return Err(failure),
            // It restarts.
            Err(_) => {}
        }
        self.follow()?;
        self.next = self.session.link.now();
        if !self.rows.is_empty() || self.number > 0 {
            // A gap in the chart.
            self.push(json!([self.seconds(now)]));
        }
        Ok(())
    }

    /// An operation has run that changes no scale: its time is not a loss.
    pub fn go_on(&mut self) {
        self.pace.restart();
        self.next = self.session.link.now();
    }

    fn seconds(&self, at: Instant) -> f64 {
        (at.ticks() - self.origin.ticks()) as f64 / 1e6
    }

    fn push(&mut self, row: Value) {
        self.rows.push(row);
        self.number += 1;
    }

    /// Waits a short time, at most until then, polls when it is due, and publishes.
    ///
    /// # Errors
    /// The adapter fails.
    pub fn turn(&mut self, hub: &Hub, until: Option<Instant>) -> Result<(), Error> {
        // A stop is for a command: a poll is short, and is not stopped in its middle.
        let was_ending = self.session.link.set_ending(true);
        let result = self.turned(hub, until);
        self.session.link.set_ending(was_ending);
        result
    }

    fn turned(&mut self, hub: &Hub, latest: Option<Instant>) -> Result<(), Error> {
        self.hear(hub);
        let now = self.session.link.now();
        match self.period {
            Some(period) if now >= self.next => {
                // What has come while the computer was late is not polled.
                self.drain(now)?;
                self.hear(hub);
                if now >= self.next {
                    self.poll(period, hub)?;
                }
            }
            period => {
                let slice = after(now, SLICE);
                let until = period.map_or(slice, |_| slice.min(self.next));
                let until = latest.map_or(until, |latest| until.min(latest));
                // The link defends the J1939 address of the tool.
                while self.session.link.receive(until)?.is_some() {}
            }
        }
        let now = self.session.link.now();
        if now.ticks() - self.flushed.ticks() >= BATCH.ticks() {
            self.flush(hub);
            self.flushed = now;
        }
        let is_asked = self.is_main && (!self.is_silent() || self.sampler.is_none());
        if now >= self.condition_at && is_asked {
            self.condition_at = after(now, CONDITION);
            self.read_register(hub)?;
        }
        Ok(())
    }

    fn poll(&mut self, period: Duration, hub: &Hub) -> Result<(), Error> {
        let Some(sampler) = &mut self.sampler else {
            return Ok(());
        };
        let polled = sampler.poll(&mut self.session, period);
        let sample = match polled {
            Err(failure) if failure.kind() == Refusal::Bus => return Err(failure),
            Err(failure) => {
                let bit = json!({"name": failure.code(), "texts": failure.texts(), "error": true});
                self.show_condition(json!([bit]), hub);
                None
            }
            Ok(sample) => sample,
        };
        match sample {
            Some(sample) => {
                self.streak = 0;
                self.take(sample, hub);
            }
            None => {
                self.lost += 1;
                self.streak = self.streak.saturating_add(1);
                if self.is_silent() {
                    // A connection of DeviceNet is gone after a restart.
                    self.session.moved(self.session.target);
                }
            }
        }
        let now = self.session.link.now();
        if self.is_silent() {
            let pause = if self.is_main { SILENT } else { OTHER_SILENT };
            self.next = after(now, pause);
            return Ok(());
        }
        self.next = after(self.next, period);
        if self.next < now {
            let missed = (now.ticks() - self.next.ticks()) / period.ticks() + 1;
            self.next = after(self.next, Duration::from_ticks(missed * period.ticks()));
            self.lost += missed;
        }
        Ok(())
    }

    fn take(&mut self, sample: Sample, hub: &Hub) {
        let Some(sampler) = &self.sampler else {
            return;
        };
        let document = sampler.json(&self.session, &sample);
        let time = self.offset.ticks() + sample.time.ticks();
        let sample = Sample {
            time: Duration::from_ticks(time),
            ..sample
        };
        self.show(&sample, &document, hub);
    }

    /// A sample whose time is that since the origin.
    fn show(&mut self, sample: &Sample, document: &Value, hub: &Hub) {
        let mut row = vec![json!(sample.time.ticks() as f64 / 1e6)];
        for (name, value) in document.as_object().into_iter().flatten() {
            match name.as_str() {
                "time" => {}
                // Read from the byte below.
                "status" => {}
                _ => row.push(value.clone()),
            }
        }
        self.push(Value::Array(row));
        if let Some(status) = sample.status {
            let product = self.session.sheet.product;
            let bits = self.session.target.conditions(product, status).into_iter();
            let bits = bits.map(|bit| json!({"name": bit.name, "error": bit.is_error}));
            self.show_condition(bits.collect(), hub);
        }
    }

    fn flush(&mut self, hub: &Hub) {
        if self.rows.is_empty() {
            return;
        }
        let rows = std::mem::take(&mut self.rows);
        let first = self.number - rows.len() as u64;
        let mut samples = json!({"first": first, "lost": self.lost(), "rows": rows});
        let kind = match self.is_main {
            true => Kind::Samples,
            false => {
                samples["sensor"] = json!(self.connection);
                Kind::OtherSamples
            }
        };
        hub.publish(kind, &samples);
    }

    /// The sensor, for the page.
    pub fn device(&self, sheets: &Sheets) -> Value {
        let rate = self.session.link.rate().map(kbits);
        let product = self.session.sheet.product;
        let heading = self.sampler.as_ref().map(Sampler::heading);
        let heading = heading.unwrap_or_default();
        let angles: Vec<Value> = heading
            .split(',')
            .filter_map(|column| column.rsplit_once('_'))
            .filter(|(name, _)| *name != "time")
            .map(|(name, unit)| json!({"name": name, "unit": unit}))
            .collect();
        let axes: Vec<&str> = product.guide.zero.iter().map(|one| one.axis).collect();
        let mut device = self.found.json(rate);
        device["connection"] = json!(self.connection);
        device["product"] = json!(product.name);
        device["sheet"] = json!(sheets.key(&self.session.sheet));
        device["foreign"] = json!(self.session.sheet.data_sheet.is_some());
        device["maker"] = json!(product.maker);
        device["angles"] = json!(angles);
        device["zero"] = json!(axes);
        let mut zero = product.guide.zero.iter();
        device["align"] = json!(!axes.is_empty() && zero.all(|one| one.offset.is_some()));
        device["teach"] = json!(!product.guide.teach.is_empty());
        device["saves"] = json!(self.session.storing() != Storing::Itself);
        device
    }
}

/// The angles of a sensor; None: its data sheet does not say which values they are.
fn sampler(session: &mut Session) -> Result<Option<Sampler>, Error> {
    match Sampler::new(session) {
        Err(Error::Request(RequestError::NoAngles)) => Ok(None),
        sampler => sampler.map(Some),
    }
}
