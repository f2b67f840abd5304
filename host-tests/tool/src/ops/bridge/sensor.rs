//! A sensor whose angles are published.

use super::fleet::{Event, is_of_bus};
use crate::cyclic::Message;
use crate::error::Error;
use crate::identify::{self, Found};
use crate::link::Link;
use crate::master::canopen::error_register;
use crate::output::Terminal;
use crate::sample::{Sample, Sampler};
use crate::scan::kbits;
use crate::serve::lease::Lease;
use crate::session::Session;
use crate::sheet::Entry;
use plumbline::time::{Duration, Instant, after, millis};
use serde_json::{Value, json};
use std::sync::atomic::{AtomicU64, Ordering};

/// The polls without an answer after which a sensor is lost.
const STREAK: u32 = 3;

/// The pause between two polls of a sensor that is lost: its time-outs delay the polls of the others.
const LOST: Duration = millis(5000);

/// The pause between two reads of the error register.
const REGISTER: Duration = millis(2000);

/// The pause between two reads of resolution and messages, which another master can change.
const REFRESH: Duration = millis(60_000);

/// The permitted delay of a message that the sensor sends by itself.
const LATE: Duration = millis(10);

/// What a sensor is.
#[derive(Clone, Debug)]
pub struct About {
    /// For topics: the serial number, or protocol and address of a sensor without one.
    pub name: String,
    /// In one line, for people.
    pub line: String,
    /// The maker of the product.
    pub maker: &'static str,
    /// What it has told, as `scan` prints it.
    pub identity: Value,
    /// The names of its angles with their units.
    pub angles: Vec<String>,
}

/// A sensor.
pub struct Sensor {
    pub(super) session: Session,
    pub(super) about: About,
    found: Found,
    lease: Lease,
    /// Its number at the adapter.
    number: u64,
    sampler: Sampler,
    /// The scale of the messages that it sends by itself, if it is another one than that of the replies.
    sent: Option<Sampler>,
    every: Duration,
    /// When the next message is taken, and when the next poll is due.
    next_message: Instant,
    next_poll: Instant,
    streak: u32,
    register: Option<Entry>,
    next_register: Instant,
    next_refresh: Instant,
    status: Vec<String>,
}

/// Protocol and address, for topics.
fn address(found: &Found) -> String {
    format!("{}-{}", found.protocol(), found.target.address())
}

/// Gives each sensor a number of its own.
static NUMBERS: AtomicU64 = AtomicU64::new(0);

impl Sensor {
    /// A sensor that has answered. None: the product is not known, or another master owns the sensor.
    ///
    /// # Errors
    /// The sensor refuses, nobody answers, or the adapter fails.
    pub(super) fn new(
        link: &mut Link,
        found: Found,
        lease: Lease,
        every: Duration,
        terminal: &Terminal,
    ) -> Result<Option<Self>, Error> {
        // Several products with the same answers have the same angles.
        let Some(product) = found.products.first().filter(|_| !found.is_owned) else {
            return Ok(None);
        };
        let spare = Link::new(Box::new(lease.clone()), &terminal.stopped);
        let mut session = Session::new(std::mem::replace(link, spare), found.target, product);
        session.expected = found.identity().serial();
        let sampler = Sampler::new(&mut session);
        std::mem::swap(link, &mut session.link);
        let sampler = sampler?;
        let serial = found.identity().serial();
        let name = serial.map_or_else(|| address(&found), |serial| serial.to_string());
        let about = About {
            name,
            line: found.line(link.rate()),
            maker: product.maker,
            identity: found.json(link.rate().map(kbits)),
            angles: columns(&sampler.heading()),
        };
        let is_register = |own: &&Entry| own.address == error_register::ADDRESS;
        let register = session.sheet.entries.iter().find(is_register).cloned();
        let now = link.now();
        let mut sensor = Self {
            session,
            about,
            found,
            lease,
            number: NUMBERS.fetch_add(1, Ordering::Relaxed),
            sampler,
            sent: None,
            every,
            next_message: now,
            next_poll: now,
            streak: 0,
            next_register: now,
            register,
            next_refresh: after(now, REFRESH),
            status: Vec::new(),
        };
        sensor.with(link, Self::follow)?;
        Ok(Some(sensor))
    }

    /// Takes the name of a sensor without serial number.
    pub(super) fn name_by_address(&mut self) {
        self.about.name = address(&self.found);
    }

    /// Runs something in the session with this link.
    pub(super) fn with<T>(&mut self, link: &mut Link, run: impl FnOnce(&mut Self) -> T) -> T {
        std::mem::swap(link, &mut self.session.link);
        let result = run(self);
        std::mem::swap(link, &mut self.session.link);
        result
    }

    /// Takes the angles that the sensor sends by itself, as it is set now.
    fn follow(&mut self) -> Result<(), Error> {
        let target = self.session.target;
        let source = match target.source(&mut self.session, &self.sampler) {
            Err(failure) if is_of_bus(&failure) => return Err(failure),
            source => source.ok().flatten(),
        };
        let others = source.as_ref().and_then(|source| source.others.clone());
        self.sent = match others {
            Some(angles) => Some(Sampler::of(&mut self.session, angles)?),
            None => None,
        };
        self.lease.with_tap(|tap| tap.follow(self.number, source));
        Ok(())
    }

    /// When the sensor must be asked next.
    pub(super) fn due(&self) -> Instant {
        let due = self.next_poll.min(self.next_refresh);
        match self.register {
            Some(_) => due.min(self.next_register),
            None => due,
        }
    }

    fn is_lost(&self) -> bool {
        self.streak >= STREAK
    }

    /// What it has sent by itself, with the times.
    pub(super) fn heard(&mut self) -> Vec<(Instant, Event)> {
        let messages = self.lease.with_tap(|tap| tap.messages(self.number));
        let mut events = Vec::new();
        for message in messages {
            let at = message.at;
            let pause = self.every.ticks() + (self.every.ticks() / 2).max(LATE.ticks());
            self.next_poll = self.next_poll.max(after(at, Duration::from_ticks(pause)));
            if self.is_lost() {
                // The next poll says whether it is the same sensor.
                self.next_poll = at;
                continue;
            }
            self.streak = 0;
            if self.is_wanted(at) {
                events.extend(self.taken(message).into_iter().map(|event| (at, event)));
            }
        }
        events
    }

    /// Whether a message at this time is taken: one in each period, also if the messages come a little early.
    fn is_wanted(&mut self, at: Instant) -> bool {
        let tolerance = Duration::from_ticks(self.every.ticks() / 4);
        if after(at, tolerance) < self.next_message {
            return false;
        }
        let following = after(self.next_message, self.every);
        self.next_message = match following > at {
            true => following,
            false => after(at, self.every),
        };
        true
    }

    fn taken(&mut self, message: Message) -> Vec<Event> {
        let sampler = self.sent.as_mut().unwrap_or(&mut self.sampler);
        let sample = Sample {
            time: millis(0),
            numbers: sampler.taken(message.numbers),
            status: message.status,
        };
        let document = sampler.json(&self.session, &sample);
        let heading = sampler.heading();
        self.events(&heading, document, sample.status)
    }

    fn events(&mut self, heading: &str, document: Value, status: Option<u8>) -> Vec<Event> {
        let Value::Object(document) = document else {
            return Vec::new();
        };
        let values = document
            .into_iter()
            .filter(|(name, _)| name != "time" && name != "status");
        let values = values.map(|(_, value)| Some(value).filter(|value| !value.is_null()));
        let angles = columns(heading).into_iter().zip(values).collect();
        let mut events = vec![Event::Angles(angles)];
        if let Some(status) = status {
            let product = self.session.sheet.product;
            let bits = self.session.target.conditions(product, status).into_iter();
            let names = bits
                .filter(|bit| bit.is_error)
                .map(|bit| bit.name.to_owned());
            events.extend(self.changed(names.collect()));
        }
        events
    }

    fn changed(&mut self, status: Vec<String>) -> Option<Event> {
        if self.status == status {
            return None;
        }
        self.status.clone_from(&status);
        Some(Event::Status(status))
    }

    /// Asks for what is due.
    ///
    /// # Errors
    /// The adapter fails.
    pub(super) fn poll(&mut self) -> Result<Vec<Event>, Error> {
        let now = self.session.link.now();
        if self.is_lost() {
            return self.look();
        }
        if self.next_poll <= now {
            return self.poll_angles(now);
        }
        if self.next_refresh <= now {
            self.next_refresh = after(now, REFRESH);
            self.refresh()?;
            return Ok(Vec::new());
        }
        self.next_register = after(now, REGISTER);
        let Some(register) = self.register.clone() else {
            return Ok(Vec::new());
        };
        let status = match self.session.read_once(&register) {
            Err(failure) if is_of_bus(&failure) => return Err(failure),
            Err(_) => return Ok(Vec::new()),
            Ok(register) => error_register::names(register).map(str::to_owned),
        };
        Ok(self.changed(status.collect()).into_iter().collect())
    }

    fn poll_angles(&mut self, now: Instant) -> Result<Vec<Event>, Error> {
        let following = after(self.next_poll, self.every);
        self.next_poll = following.max(now);
        match self.sampler.poll(&mut self.session, self.every) {
            Err(failure) if is_of_bus(&failure) => Err(failure),
            Ok(Some(sample)) => {
                self.streak = 0;
                self.next_message = after(now, self.every);
                let document = self.sampler.json(&self.session, &sample);
                let heading = self.sampler.heading();
                Ok(self.events(&heading, document, sample.status))
            }
            // It refuses, or does not answer.
            Ok(None) | Err(_) => {
                self.streak += 1;
                if !self.is_lost() {
                    return Ok(Vec::new());
                }
                // A connection of DeviceNet is gone after a restart.
                self.session.moved(self.session.target);
                self.rest();
                self.status.clear();
                Ok(vec![Event::Here(false)])
            }
        }
    }

    /// Nothing is due for some time.
    fn rest(&mut self) {
        let later = after(self.session.link.now(), LOST);
        (self.next_poll, self.next_register, self.next_refresh) = (later, later, later);
    }

    /// Asks a lost sensor for its identity. A sensor with another serial number does not count.
    fn look(&mut self) -> Result<Vec<Event>, Error> {
        self.rest();
        self.session.release()?;
        let target = self.session.target;
        let answer = identify::ask(&mut self.session.link, target, identify::PATIENT)?;
        let is_same = answer.is_some_and(|own| own.identity() == self.found.identity());
        if !is_same || !self.refresh()? {
            return Ok(Vec::new());
        }
        let now = self.session.link.now();
        self.streak = 0;
        (self.next_poll, self.next_message, self.next_register) = (now, now, now);
        self.next_refresh = after(now, REFRESH);
        Ok(vec![Event::Here(true), Event::Status(Vec::new())])
    }

    /// Reads again in which unit and in which messages the sensor has its angles. False: it does not answer.
    fn refresh(&mut self) -> Result<bool, Error> {
        match Sampler::new(&mut self.session) {
            Err(failure) if is_of_bus(&failure) => Err(failure),
            Err(_) => Ok(false),
            Ok(sampler) => {
                self.sampler = sampler;
                match self.follow() {
                    Err(failure) if is_of_bus(&failure) => Err(failure),
                    followed => Ok(followed.is_ok()),
                }
            }
        }
    }
}

impl Drop for Sensor {
    fn drop(&mut self) {
        self.lease.with_tap(|tap| tap.follow(self.number, None));
    }
}

impl About {
    /// The document of the identity.
    pub fn document(&self) -> Value {
        let mut document = json!({"maker": self.maker});
        if let (Some(own), Value::Object(identity)) = (document.as_object_mut(), &self.identity) {
            own.extend(identity.clone());
            if let Some(rate) = own.remove("rate") {
                own.insert("rate_kbits".to_owned(), rate);
            }
        }
        document
    }
}

/// The names of the angles with their units, in the heading of a table of samples.
fn columns(heading: &str) -> Vec<String> {
    let all = heading.split(',');
    let angles = all.filter(|own| *own != "time_s" && *own != "status");
    angles.map(|own| own.replace('-', "_")).collect()
}
