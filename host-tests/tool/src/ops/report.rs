//! What an operation has done: a document for programs, and lines for people.

use super::adjust::What;
use super::identity::Told;
use crate::master::j1939::address::Shown as Address;
use crate::sheet::Entry;
use serde::ser::SerializeMap;
use serde::{Serialize, Serializer};
use serde_json::Value;

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
        /// What happened, in one sentence.
        done: String,
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
        stored: Option<&'static str>,
    },
    /// The present position is a reference.
    Adjusted(Adjusted),
    /// The name of the sensor on this computer.
    Label {
        /// The name.
        label: Option<String>,
        /// The same for people.
        #[serde(skip)]
        line: String,
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
    Identity(Box<Told>),
}

/// The angles after the present position has become a reference.
#[derive(Clone, Debug)]
pub struct Adjusted {
    /// Which reference.
    pub what: What,
    /// The angles now.
    pub angles: Values,
    /// What has stored it.
    pub stored: Option<&'static str>,
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
    /// What happened, in one sentence.
    pub fn done(text: impl Into<String>) -> Self {
        Self::Done { done: text.into() }
    }

    /// For people.
    pub fn lines(&self) -> Vec<String> {
        let with = |values: &Values, stored: &Option<&'static str>| {
            let mut lines = values.lines();
            lines.extend(stored.map(str::to_owned));
            lines
        };
        match self {
            Self::Done { done } => vec![done.clone()],
            Self::Values(values) => values.lines(),
            Self::Written { values, stored } => with(values, stored),
            Self::Adjusted(adjusted) => with(&adjusted.angles, &adjusted.stored),
            Self::Label { line, .. } => vec![line.clone()],
            Self::Address(address) => address.lines(),
            Self::Raw { answer, .. } => {
                let bytes = answer.as_bytes().chunks(2);
                let bytes: Vec<_> = bytes.map(String::from_utf8_lossy).collect();
                vec![bytes.join(" ")]
            }
            Self::Identity(told) => told.lines(),
        }
    }
}
