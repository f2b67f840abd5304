//! `bridge`: the angles, the status and the identity of all sensors on a bus, for other programs.

pub mod address;
pub mod agopengps;
pub mod broker;
mod failure;
pub mod fleet;
pub mod known;
pub mod queue;
pub mod sensor;
pub mod topics;
mod window;

use crate::counted::Samples;
use crate::error::{BrokerError, Error};
use crate::note::Note;
use crate::output::Terminal;
use agopengps::AgOpenGps;
use broker::{Broker, BrokerEvent};
use fleet::{Event, Fleet};
use known::Known;
use plumbline::time::Duration;
use queue::Lost;
use sensor::About;
use serde_json::{Map, Value, json};
use std::path::{Path, PathBuf};
use std::time::{Duration as Wait, Instant};
use texts::Kind;
use topics::{HERE, Topics};

/// The pause between two notes about samples that are lost.
const LOST: Wait = Wait::from_secs(5);

/// A broker with its topics.
pub struct Mqtt {
    broker: Broker,
    /// As the user has written it.
    url: String,
    topics: Topics,
    buffer: PathBuf,
    known: Known,
    looked: Instant,
}

impl Mqtt {
    /// A broker that was started. The sensors of earlier runs, which are `known`, are offline until they are found.
    pub fn new(broker: Broker, url: String, topics: Topics, buffer: PathBuf, known: Known) -> Self {
        for topic in known.makers().keys() {
            broker.keep(topic.clone(), HERE[0].to_owned());
        }
        Self {
            broker,
            url,
            topics,
            buffer,
            known,
            looked: Instant::now(),
        }
    }

    /// Tells what a sensor is, and that it is there.
    ///
    /// # Errors
    /// The file with the sensors cannot be written.
    fn introduce(&mut self, about: &About) -> Result<(), Error> {
        let topic = self.topics.sensor(about, "availability");
        self.known.add(topic, about.maker)?;
        let keep = |topic: &str, text: String| {
            self.broker.keep(self.topics.sensor(about, topic), text);
        };
        keep("identity", about.document().to_string());
        keep("status", status(&[]).to_string());
        keep("availability", HERE[1].to_owned());
        for (topic, document) in self.topics.discovery(about) {
            self.broker.keep(topic, document.to_string());
        }
        Ok(())
    }

    fn take(&mut self, about: &About, micros: u64, event: &Event) -> Result<(), Error> {
        let keep = |topic: &str, text: String| {
            self.broker.keep(self.topics.sensor(about, topic), text);
        };
        match event {
            Event::Angles(angles) => {
                let topic = self.topics.sensor(about, "angle");
                self.broker.publish(&topic, &angle(micros, angles))?;
            }
            Event::Status(errors) => keep("status", status(errors).to_string()),
            Event::Here(true) => self.introduce(about)?,
            Event::Here(false) => keep("availability", HERE[0].to_owned()),
        }
        Ok(())
    }

    /// Tells the user what has become of the connection.
    ///
    /// # Errors
    /// No connection can succeed.
    fn report_events(&mut self, terminal: &mut Terminal) -> Result<(), Error> {
        for event in self.broker.events() {
            report(event, &self.url, &self.buffer, terminal)?;
        }
        if self.looked.elapsed() < LOST {
            return Ok(());
        }
        self.looked = Instant::now();
        report_lost(self.broker.take_lost(), &self.buffer, terminal);
        // `report_lost` shows that the disk is full.
        let _ = self.known.sync();
        Ok(())
    }

    fn end(self, abouts: &[About], terminal: &mut Terminal) -> Result<(), Error> {
        for about in abouts {
            let topic = self.topics.sensor(about, "availability");
            self.broker.keep(topic, HERE[0].to_owned());
        }
        report_lost(self.broker.take_lost(), &self.buffer, terminal);
        let path = self.buffer.display().to_string();
        let (left, events) = self.broker.end();
        match left {
            Ok(0) => {}
            Ok(left) => terminal.note(&Note::RecordsLeft(Samples(left), path)),
            Err(error) => terminal.note(&Note::NotSynchronised(path, error.to_string())),
        }
        // There is no next try.
        let mut events = events
            .into_iter()
            .filter(|own| !matches!(own, BrokerEvent::Away(..)));
        events.try_for_each(|event| report(event, &self.url, &self.buffer, terminal))
    }
}

fn report_lost(lost: Lost, buffer: &Path, terminal: &mut Terminal) {
    let path = || buffer.display().to_string();
    if lost.limit > 0 {
        terminal.note(&Note::RecordsLost(Samples(lost.limit)));
    }
    if lost.disk > 0 {
        terminal.note(&Note::DiskFull(Samples(lost.disk), path()));
    }
    if lost.is_damaged {
        terminal.note(&Note::BufferDamaged(path()));
    }
}

/// Shows the user what has happened in the thread of the broker.
///
/// # Errors
/// No connection can succeed.
fn report(
    event: BrokerEvent,
    url: &str,
    buffer: &Path,
    terminal: &mut Terminal,
) -> Result<(), Error> {
    let url = url.to_owned();
    match event {
        BrokerEvent::NotSynchronised(reason) => {
            let path = buffer.display().to_string();
            terminal.note(&Note::NotSynchronised(path, reason));
        }
        BrokerEvent::Connected => terminal.note(&Note::BrokerConnected(url)),
        BrokerEvent::Away(reason, seconds) => {
            terminal.note(&Note::BrokerAway(url, reason, seconds))
        }
        BrokerEvent::Failed(failure) => return Err(failure),
    }
    Ok(())
}

/// The document of angles, without its number.
fn angle(micros: u64, angles: &[(String, Option<Value>)]) -> Value {
    let mut document = Map::new();
    document.insert("time_unix_s".to_owned(), json!(micros as f64 / 1e6));
    for (name, value) in angles {
        document.insert(name.clone(), value.clone().unwrap_or_default());
    }
    document.into()
}

/// The document of the errors.
fn status(errors: &[String]) -> Value {
    json!({"errors": errors})
}

/// The roll of one sensor for AgOpenGPS.
pub struct Roll {
    to: AgOpenGps,
    /// The name of the sensor, and the name of its angle with its unit.
    sensor: String,
    angle: String,
}

impl Roll {
    /// The roll of the only sensor; `axis` is the name of an angle, None the first one.
    ///
    /// # Errors
    /// There are several sensors, or the sensor has no such angle.
    pub fn new(to: AgOpenGps, fleet: &Fleet, axis: Option<&str>) -> Result<Self, Error> {
        let abouts: Vec<&About> = fleet.abouts().collect();
        let [about] = abouts[..] else {
            let lines: Vec<&str> = abouts.iter().map(|about| &*about.line).collect();
            return Err(BrokerError::SeveralRolls(lines.join("; ")).into());
        };
        let name = |own: &String| {
            let name = own.rsplit_once('_').map_or(&**own, |(name, _)| name);
            name.replace('_', "-")
        };
        let is_wanted = |own: &&String| axis.is_none_or(|axis| name(own) == axis);
        let angle = about.angles.iter().find(is_wanted).cloned();
        let none = || {
            let axis = axis.unwrap_or_default().to_owned();
            let names: Vec<String> = about.angles.iter().map(name).collect();
            BrokerError::NoRoll(about.line.clone(), axis, names.join(", "))
        };
        Ok(Self {
            to,
            sensor: about.name.clone(),
            angle: angle.ok_or_else(none)?,
        })
    }

    fn take(&mut self, about: &About, event: &Event, terminal: &mut Terminal) {
        let roll = match event {
            Event::Angles(angles) if about.name == self.sensor => {
                let own = angles.iter().find(|(name, _)| *name == self.angle);
                own.and_then(|(_, value)| value.as_ref()?.as_f64())
            }
            Event::Here(false) if about.name == self.sensor => None,
            _ => return,
        };
        if let Some(failure) = self.to.send(roll) {
            terminal.note(&failure);
        }
    }
}

/// Where the events go.
pub struct Outputs {
    /// A broker.
    pub mqtt: Option<Mqtt>,
    /// AgOpenGPS.
    pub roll: Option<Roll>,
}

/// Hands over what the sensors measure, until the time is over or Ctrl-C.
///
/// # Errors
/// The adapter fails, the buffer cannot be written, or no connection with the broker can succeed.
pub fn run(
    mut fleet: Fleet,
    mut outputs: Outputs,
    time: Option<Duration>,
    terminal: &mut Terminal,
) -> Result<(), Error> {
    if let Some(mqtt) = &mut outputs.mqtt {
        let mut abouts = fleet.abouts();
        abouts.try_for_each(|about| mqtt.introduce(about))?;
    }
    let end = time.map(|time| fleet.end_after(time));
    let result = match turns(&mut fleet, &mut outputs, end, terminal) {
        // Ctrl-C in a search for other sensors is the usual end too.
        Err(failure) if failure.kind() == Kind::Stopped => Ok(()),
        result => result,
    };
    let abouts: Vec<About> = fleet.abouts().cloned().collect();
    let released = fleet.end();
    if let Some(roll) = &mut outputs.roll
        && let Some(failure) = roll.to.send(None)
    {
        terminal.note(&failure);
    }
    let ended = match outputs.mqtt {
        Some(mqtt) => mqtt.end(&abouts, terminal),
        None => Ok(()),
    };
    result.and(released).and(ended)
}

fn turns(
    fleet: &mut Fleet,
    outputs: &mut Outputs,
    end: Option<plumbline::time::Instant>,
    terminal: &mut Terminal,
) -> Result<(), Error> {
    while !(terminal.stopped)() && end.is_none_or(|end| fleet.now() < end) {
        fleet.turn(terminal, &mut |terminal, about, micros, event| {
            if let Some(roll) = &mut outputs.roll {
                roll.take(about, &event, terminal);
            }
            match &mut outputs.mqtt {
                Some(mqtt) => mqtt.take(about, micros, &event),
                None => Ok(()),
            }
        })?;
        if let Some(mqtt) = &mut outputs.mqtt {
            mqtt.report_events(terminal)?;
        }
    }
    Ok(())
}
