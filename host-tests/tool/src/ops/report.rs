//! What an operation has done: a document for programs, and lines for people.

use super::adjust::What;
use super::align::Aligned;
use super::commission::Commissioned;
use super::doctor;
use super::identity::SensorIdentity;
use super::rate::NewRate;
use super::replace::report::Replaced;
use crate::master::j1939::address::Shown as Address;
use crate::sheet::Entry;
use serde::ser::SerializeMap;
use serde::{Serialize, Serializer};
use serde_json::Value;
use texts::texts;

texts! {
    /// What happened, in one sentence.
    Done {
        AddressAlready(kind: &'static str, new: u8) = "the {kind} is {new} already", "{kind} ist schon {new}";
        Address(kind: &'static str, new: u8) = "the {kind} is {new} now, and stored", "{kind} ist jetzt {new} und gespeichert";
        RateAlready(new: NewRate) = "the bit rate is {new} already", "die Bitrate ist schon {new}";
        Rate(new: NewRate) = "the bit rate is {new} now, and stored", "die Bitrate ist jetzt {new} und gespeichert";
        RestartsWith(new: NewRate) = "the sensor restarts with {new}", "der Sensor startet neu mit {new}";
        Restarts = "the sensor restarts", "der Sensor startet neu";
        Stored = "stored", "gespeichert";
        StoresItself = "the sensor stores each change by itself within one second",
            "der Sensor speichert jede Änderung von selbst innerhalb einer Sekunde";
        FactoryAtRestart = "factory values, including node-ID and bit rate, take effect after a restart; then `save` stores them",
            "Werkswerte, auch Node-ID und Bitrate, gelten nach einem Neustart; dann müssen Sie sie im Sensor speichern",
            "factory values, including node-ID and bit rate, take effect after a restart; then press Save in sensor";
        FactoryLoaded = "factory values are loaded; node-ID and bit rate act after a restart",
            "Werkswerte sind geladen; Node-ID und Bitrate gelten nach einem Neustart";
        FactoryStored = "factory values are loaded and stored; identifiers and bit rate act after a restart",
            "Werkswerte sind geladen und gespeichert; Identifier und Bitrate gelten nach einem Neustart";
        FactoryRestarts = "the sensor restarts with factory values, including MAC ID and bit rate",
            "der Sensor startet neu mit Werkswerten, auch MAC ID und Bitrate";
        FactoryRestartsAt = "the sensor restarts with its factory values", "der Sensor startet neu mit seinen Werkswerten";
        Factory(address: String, rate: &'static str) = "factory values are loaded and stored; the sensor has {address} and {rate} now",
            "Werkswerte sind geladen und gespeichert; der Sensor hat jetzt {address} und {rate}";
        Label(name: String) = "{name}", "{name}";
        LabelRemoved(name: String) = "the name {name} was removed", "der Name {name} wurde entfernt";
        NoLabel = "the sensor has no name", "der Sensor hat keinen Namen";
    }
}

impl From<Done> for Report {
    fn from(done: Done) -> Self {
        Self::Done { done }
    }
}

fn sentence<S: Serializer>(done: &Done, to: S) -> Result<S::Ok, S::Error> {
    to.collect_str(done)
}

/// A parameter or value that has been read.
#[derive(Clone, Debug)]
pub struct Shown {
    /// Its name.
    pub name: String,
    /// For people.
    pub text: String,
    /// For programs.
    pub json: Value,
}

/// Parameters and values that have been read, in their order.
#[derive(Clone, Default, Debug)]
pub struct Values(pub Vec<Shown>);

impl Serialize for Values {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        to.collect_map(self.0.iter().map(|shown| (&shown.name, &shown.json)))
    }
}

impl Values {
    /// A line for each, the values in one column.
    pub fn lines(&self) -> Vec<String> {
        let width = self.0.iter().map(|shown| shown.name.len()).max();
        let width = width.unwrap_or(0);
        let lines = self.0.iter();
        let lines = lines.map(|Shown { name, text, .. }| format!("{name:width$}  {text}"));
        lines.collect()
    }
}

/// What an operation has done.
#[derive(Clone, Debug, Serialize)]
#[serde(untagged)]
pub enum Report {
    /// It is done.
    Done {
        /// What happened.
        #[serde(serialize_with = "sentence")]
        done: Done,
    },
    /// These values were read.
    Values(Values),
    /// These values were written.
    Written {
        /// What the sensor has now.
        #[serde(flatten)]
        values: Values,
        /// What has stored them.
        #[serde(skip)]
        stored: Option<Done>,
    },
    /// The present position is a reference.
    Adjusted(Adjusted),
    /// The name of the sensor on this computer.
    Label {
        /// The name.
        label: Option<String>,
        /// The same for people.
        #[serde(skip)]
        line: Done,
    },
    /// The address of a J1939 sensor.
    Address(Address),
    /// The answer to a request.
    Raw {
        /// The request as it was given.
        request: String,
        /// The bytes of the answer, hexadecimal.
        answer: String,
    },
    /// The identity of the sensor.
    Identity(Box<SensorIdentity>),
    /// The offset of the mounting is zero.
    Aligned(Aligned),
    /// The sensors of a plan are commissioned.
    Commissioned(Commissioned),
    /// The new sensor has the settings of the old one.
    Replaced(Box<Replaced>),
    /// What is wrong with the bus.
    Doctor(doctor::Report),
}

/// The angles after the present position has become a reference.
#[derive(Clone, Debug)]
pub struct Adjusted {
    /// Which reference.
    pub what: What,
    /// The angles now.
    pub angles: Values,
    /// What has stored it.
    pub stored: Option<Done>,
    /// The parameters that have been written, with their numbers.
    pub written: Vec<(Entry, u32)>,
}

impl Serialize for Adjusted {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        let mut map = to.serialize_map(Some(1))?;
        map.serialize_entry(self.what.name(), &self.angles)?;
        map.end()
    }
}

impl Report {
    /// For people.
    pub fn lines(&self) -> Vec<String> {
        let with = |values: &Values, stored: &Option<Done>| {
            let mut lines = values.lines();
            lines.extend(stored.as_ref().map(Done::to_string));
            lines
        };
        match self {
            Self::Done { done } => vec![done.to_string()],
            Self::Values(values) => values.lines(),
            Self::Written { values, stored } => with(values, stored),
            Self::Adjusted(adjusted) => with(&adjusted.angles, &adjusted.stored),
            Self::Label { line, .. } => vec![line.to_string()],
            Self::Address(address) => address.lines(),
            Self::Raw { answer, .. } => {
                let bytes = answer.as_bytes().chunks(2);
                let bytes: Vec<_> = bytes.map(String::from_utf8_lossy).collect();
                vec![bytes.join(" ")]
            }
            Self::Identity(identity) => identity.lines(),
            Self::Aligned(aligned) => aligned.lines(),
            Self::Doctor(report) => report.lines(),
            Self::Commissioned(done) => done.lines(),
            Self::Replaced(done) => done.lines(),
        }
    }
}
