//! The requests of control clients as JSON. `README.md` describes them.

use bench::fault::Fault;
use serde::{Deserialize, Deserializer, de};
use serde_json::{Map, Value};
use std::path::PathBuf;

/// What a line asks for.
#[derive(Debug, Deserialize)]
#[serde(tag = "do", rename_all = "kebab-case", deny_unknown_fields)]
pub(super) enum Request {
    Sensors {},
    State {},
    Image {},
    Tilt {
        x: f64,
        y: f64,
    },
    Rate {
        x: f64,
        y: f64,
        seconds: Option<f64>,
    },
    Sine {
        x: f64,
        y: f64,
        hertz: f64,
    },
    Scene {
        file: Option<PathBuf>,
        csv: Option<String>,
    },
    Temperature {
        celsius: Option<f64>,
    },
    Supply {
        volts: Option<f64>,
    },
    Accelerometer {
        #[serde(default, deserialize_with = "accelerometer_fault")]
        fault: Option<Fault>,
    },
    Memory {
        fault: Option<MemoryFault>,
    },
    Damage {},
    Power {
        on: bool,
    },
    Restart {},
    CutInSave {
        operations: u64,
        #[serde(default)]
        seed: u64,
    },
    BusOff {},
    Corrupt {
        count: u32,
    },
    HideAcknowledge {
        count: u32,
    },
    Lose {
        count: u32,
        from: Side,
        identifier: Option<String>,
    },
    Delay {
        count: u32,
        from: Side,
        identifier: Option<String>,
        seconds: f64,
    },
    Send {
        frame: String,
    },
    Advance {
        seconds: f64,
    },
    Subscribe {
        events: Vec<Topic>,
    },
}

impl Request {
    /// True if it concerns all sensors, so that it cannot name one.
    pub(super) fn is_of_all(&self) -> bool {
        matches!(
            self,
            Self::Sensors {}
                | Self::HideAcknowledge { .. }
                | Self::Lose { .. }
                | Self::Delay { .. }
                | Self::Send { .. }
                | Self::Advance { .. }
                | Self::Subscribe { .. }
        )
    }
}

/// A fault of the nonvolatile memory.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(super) enum MemoryFault {
    Programming,
    Erasing,
}

/// Who has sent a frame.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(in crate::server) enum Side {
    Sensors,
    Clients,
}

/// A kind of event.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(super) enum Topic {
    Leds,
    State,
    Stored,
    Frames,
}

impl Topic {
    /// Events have this name.
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Leds => "leds",
            Self::State => "state",
            Self::Stored => "stored",
            Self::Frames => "frame",
        }
    }
}

fn accelerometer_fault<'de, D: Deserializer<'de>>(from: D) -> Result<Option<Fault>, D::Error> {
    let Some(name) = Option::<String>::deserialize(from)? else {
        return Ok(None);
    };
    let unknown = || {
        let names = Fault::names();
        de::Error::custom(format!(
            "there is no fault {name:?}: it is {names}, or null"
        ))
    };
    Fault::named(&name).map(Some).ok_or_else(unknown)
}

/// The request in a line, and the sensor that it names. The error is one sentence.
pub(super) fn parse(line: &[u8]) -> Result<(Request, Option<String>), String> {
    let invalid = |error: serde_json::Error| format!("this is not a request: {error}");
    let mut members: Map<String, Value> = serde_json::from_slice(line).map_err(invalid)?;
    let sensor = match members.remove("sensor") {
        None => None,
        Some(Value::String(name)) => Some(name),
        Some(other) => return Err(format!("the sensor is a name, not {other}")),
    };
    let request = Request::deserialize(Value::Object(members)).map_err(invalid)?;
    Ok((request, sensor))
}
