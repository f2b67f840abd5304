//! All sensors on a bus: their angles, their status, and whether they answer. Angles that a sensor sends by itself are taken; it is polled
//! for those that it does not send.

use super::sensor::{About, Sensor};
use crate::error::{Error, SensorError};
use crate::identify::{self, Found};
use crate::link::Link;
use crate::master::Target;
use crate::note::Note;
use crate::output::Terminal;
use crate::scan::listen;
use crate::scan::passive;
use crate::serve::lease::Lease;
use adapter::Mode;
use plumbline::can::{BitRate, Frame};
use plumbline::time::{Duration, Instant, after, millis};
use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};
use std::time::{SystemTime, UNIX_EPOCH};
use texts::Kind;

/// The longest wait without a check for Ctrl-C.
const SLICE: Duration = millis(20);

/// The maximum number of frames that are received before a poll.
const MOST: usize = 1000;

/// The pause between two searches for sensors that were switched on later.
const SEARCH: Duration = millis(30_000);

/// The longest pause between two questions to a node that is not a sensor of the catalogue. The first one is that between two searches.
const LONGEST: u64 = 3_600_000_000;

/// What has happened to a sensor.
pub enum Event {
    /// It has these angles, by their names with their units; None: no valid angle.
    Angles(Vec<(String, Option<Value>)>),
    /// These errors are active now.
    Status(Vec<String>),
    /// It answers, or answers no longer.
    Here(bool),
}

/// A sensor, the time of the event in us since 1970, and the event.
pub type Take<'a> = &'a mut dyn FnMut(&mut Terminal, &About, u64, Event) -> Result<(), Error>;

/// A node that has not answered as a sensor of the catalogue.
struct Stranger {
    target: Target,
    /// When it is asked again, and the pause after that.
    next: Instant,
    pause: u64,
}

/// The sensors on a bus.
pub struct Fleet {
    lease: Lease,
    /// The link of all sessions: only one of them uses it at a time, and a J1939 address of the tool belongs to it.
    link: Link,
    sensors: Vec<Sensor>,
    /// The makers of the sensors of earlier runs, by their names.
    earlier: BTreeMap<String, String>,
    every: Duration,
    /// The frames since the start of a search; None: none runs.
    heard: Option<Vec<(Instant, Frame)>>,
    /// The time of the next one; None: the user has chosen one sensor.
    search: Option<Instant>,
    strangers: Vec<Stranger>,
    /// The user knows that these are left out.
    left_out: BTreeSet<String>,
}

impl Fleet {
    /// The sensors that a scan has found, at this bit rate; or, without `is_open`, the one that the user has chosen, beside which no others are taken.
    ///
    /// # Errors
    /// None of them is of the catalogue, or the adapter fails.
    pub fn new(
        lease: Lease,
        (rate, found): (Option<BitRate>, Vec<Found>),
        earlier: BTreeMap<String, String>,
        is_open: bool,
        every: Duration,
        terminal: &mut Terminal,
    ) -> Result<Self, Error> {
        let mut link = Link::new(Box::new(lease.clone()), &terminal.stopped);
        link.open(rate, Mode::Active)?;
        let search = is_open.then(|| after(link.now(), SEARCH));
        let mut fleet = Self {
            lease,
            link,
            sensors: Vec::new(),
            earlier,
            every,
            heard: None,
            search,
            strangers: Vec::new(),
            left_out: BTreeSet::new(),
        };
        for found in found {
            fleet.add(found, terminal)?;
        }
        match fleet.sensors.is_empty() {
            true => Err(SensorError::NotFound.into()),
            false => Ok(fleet),
        }
    }

    /// The sensors.
    pub fn abouts(&self) -> impl Iterator<Item = &About> {
        self.sensors.iter().map(|sensor| &sensor.about)
    }

    /// Adds a sensor. False: the tool cannot sample it.
    fn add(&mut self, found: Found, terminal: &mut Terminal) -> Result<bool, Error> {
        let line = found.line(self.link.rate());
        let added = Sensor::new(
            &mut self.link,
            found,
            self.lease.clone(),
            self.every,
            terminal,
        );
        match added {
            Err(failure) if is_of_bus(&failure) => Err(failure),
            Err(failure) => {
                self.leave_out(Note::LeftOut(format!("{line}: {failure}")), terminal);
                Ok(false)
            }
            Ok(None) => {
                self.leave_out(Note::NotBridged(line), terminal);
                Ok(false)
            }
            Ok(Some(mut sensor)) => {
                // Only the serial numbers of one maker differ. A name stays with the sensor that has had it first, also over a restart.
                let (name, maker) = (&sensor.about.name, sensor.about.maker);
                let mut abouts = self.abouts();
                let is_other = |own: &About| own.name == *name && own.maker != maker;
                let earlier = self.earlier.get(name);
                let was_other = earlier.is_some_and(|own| !own.is_empty() && own != maker);
                let is_taken = was_other || abouts.any(is_other);
                drop(abouts);
                if is_taken {
                    sensor.name_by_address();
                }
                self.sensors.push(sensor);
                Ok(true)
            }
        }
    }

    /// Tells that a sensor is left out. Each search finds it again, but the user is told once.
    fn leave_out(&mut self, note: Note, terminal: &mut Terminal) {
        if self.left_out.insert(note.to_string()) {
            terminal.note(&note);
        }
    }

    /// Waits a short time, polls the sensor that is due, and passes the events to `take`.
    ///
    /// # Errors
    /// The adapter or `take` fails.
    pub fn turn(&mut self, terminal: &mut Terminal, take: Take) -> Result<(), Error> {
        let now = self.link.now();
        let due = (0..self.sensors.len()).min_by_key(|place| self.sensors[*place].due());
        let until = due.map_or(after(now, SLICE), |place| self.sensors[place].due());
        self.receive(until.min(after(now, SLICE)))?;
        let now = self.link.now();
        for _ in 0..MOST {
            if !self.receive(now)? {
                break;
            }
        }
        for sensor in &mut self.sensors {
            for (at, event) in sensor.heard() {
                take(terminal, &sensor.about, unix(now, at), event)?;
            }
        }
        // A message can have made the poll superfluous.
        let due = due.and_then(|place| self.sensors.get_mut(place));
        if let Some(sensor) = due.filter(|sensor| sensor.due() <= now) {
            let events = sensor.with(&mut self.link, |sensor| {
                let was_ending = sensor.session.link.set_ending(true);
                let polled = sensor.poll();
                sensor.session.link.set_ending(was_ending);
                polled
            });
            let now = self.link.now();
            for event in events? {
                if let Event::Here(is_here) = event {
                    let line = sensor.about.line.clone();
                    terminal.note(&match is_here {
                        true => Note::SensorBack(line),
                        false => Note::SensorLost(line),
                    });
                }
                take(terminal, &sensor.about, unix(now, now), event)?;
            }
        }
        self.look_for_others(terminal, take)
    }

    /// Receives a frame; false: none came until then.
    fn receive(&mut self, until: Instant) -> Result<bool, Error> {
        let received = self.link.receive(until)?;
        if let (Some(heard), Some(frame)) = (&mut self.heard, received) {
            heard.push(frame);
        }
        Ok(received.is_some())
    }

    /// Asks the nodes whose frames were heard, and who are not known.
    fn look_for_others(&mut self, terminal: &mut Terminal, take: Take) -> Result<(), Error> {
        let now = self.link.now();
        if self.search.is_none_or(|at| now < at) {
            return Ok(());
        }
        let Some(heard) = self.heard.take() else {
            self.heard = Some(Vec::new());
            self.search = Some(after(now, listen::LONG));
            return Ok(());
        };
        self.search = Some(after(now, SEARCH));
        for sighting in passive::sightings(&heard) {
            let Some(target) = sighting.target.filter(|_| sighting.is_sure) else {
                continue;
            };
            let is_known = |own: &Sensor| own.session.target.is_at(target);
            if self.sensors.iter().any(is_known) || !self.is_due(target) {
                continue;
            }
            let Some(found) = identify::ask(&mut self.link, target, identify::PATIENT)? else {
                continue;
            };
            if self.add(found, terminal)?
                && let Some(about) = self.sensors.last().map(|own| &own.about)
            {
                self.strangers.retain(|own| !own.target.is_at(target));
                terminal.note(&Note::SensorNew(about.line.clone()));
                take(terminal, about, unix(now, now), Event::Here(true))?;
            }
        }
        Ok(())
    }

    /// Whether a node that was heard is asked now. The pauses grow, because it can be another device.
    fn is_due(&mut self, target: Target) -> bool {
        let now = self.link.now();
        let mut strangers = self.strangers.iter_mut();
        match strangers.find(|own| own.target.is_at(target)) {
            Some(own) if now < own.next => return false,
            Some(own) => {
                own.pause = LONGEST.min(2 * own.pause);
                own.next = after(now, Duration::from_ticks(own.pause));
            }
            None => self.strangers.push(Stranger {
                target,
                next: now,
                pause: SEARCH.ticks(),
            }),
        }
        true
    }

    /// The present time of the bus.
    pub fn now(&self) -> Instant {
        self.link.now()
    }

    /// The time of the bus after this time.
    pub fn end_after(&self, time: Duration) -> Instant {
        after(self.now(), time)
    }

    /// Releases all sensors, and closes the adapter.
    ///
    /// # Errors
    /// The adapter fails.
    pub fn end(mut self) -> Result<(), Error> {
        let mut result = Ok(());
        self.link.end();
        for sensor in &mut self.sensors {
            let released = sensor.with(&mut self.link, |sensor| sensor.session.release());
            result = result.and(released);
        }
        self.lease.end();
        result
    }
}

/// The time of the computer, in us since 1970, at a time of the bus that is over.
fn unix(now: Instant, at: Instant) -> u64 {
    let passed = now.ticks().saturating_sub(at.ticks());
    let unix = SystemTime::now().duration_since(UNIX_EPOCH);
    let micros = unix.unwrap_or_default().as_micros() as u64;
    micros.saturating_sub(passed)
}

/// A failure that is not one of the sensor.
pub(super) fn is_of_bus(failure: &Error) -> bool {
    matches!(failure.kind(), Kind::Bus | Kind::Stopped)
}
