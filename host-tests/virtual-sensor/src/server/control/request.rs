//! The requests of control clients as JSON. `README.md` describes them.

use bench::fault::Fault;
use serde::{Deserialize, Deserializer, de};
use serde_json::{Map, Value};
use std::fmt::{self, Formatter};
use std::path::PathBuf;

/// What a line asks for.
#[derive(Debug, Deserialize)]
#[serde(tag = "do", rename_all = "kebab-case", deny_unknown_fields)]
pub enum Request {
    /// The names and models of all sensors.
    Sensors {},
    /// The state of a sensor.
    State {},
    /// The nonvolatile memory.
    Image {},
    /// At rest with these angles in degrees.
    Tilt {
        /// The first angle, rate or amplitude.
        x: f64,
        /// The second one.
        y: f64,
    },
    /// Turns with these rates in deg/s.
    Rate {
        /// The first angle, rate or amplitude.
        x: f64,
        /// The second one.
        y: f64,
        /// The time in s.
        seconds: Option<f64>,
    },
    /// Oscillates around the present angles.
    Sine {
        /// The first angle, rate or amplitude.
        x: f64,
        /// The second one.
        y: f64,
        /// The frequency.
        hertz: f64,
    },
    /// Plays a recording.
    Scene {
        /// Its file.
        file: Option<PathBuf>,
        /// Its text.
        csv: Option<String>,
    },
    /// The temperature; None: that of the scene.
    Temperature {
        /// In degC.
        #[serde(deserialize_with = "stated")]
        celsius: Option<f64>,
    },
    /// The supply; None: that of the scene.
    Supply {
        /// In V.
        #[serde(deserialize_with = "stated")]
        volts: Option<f64>,
    },
    /// A fault of the accelerometer; None: it works.
    Accelerometer {
        /// What is wrong.
        #[serde(deserialize_with = "accelerometer_fault")]
        fault: Option<Fault>,
    },
    /// A fault of the nonvolatile memory; None: it works.
    Memory {
        /// What is wrong.
        #[serde(deserialize_with = "stated")]
        fault: Option<MemoryFault>,
    },
    /// Inverts a bit in what was saved last.
    Damage {},
    /// Switches the supply.
    Power {
        /// Whether it is on.
        on: bool,
    },
    /// Switches the supply off and on.
    Restart {},
    /// Cuts the power in an operation of the memory.
    CutInSave {
        /// The operations before.
        operations: u64,
        /// Selects what remains.
        #[serde(default)]
        seed: u64,
    },
    /// Disturbs the frames of the sensor until it is bus-off.
    BusOff {},
    /// Disturbs the next frames.
    Corrupt {
        /// The number of frames.
        count: u32,
    },
    /// Hides the acknowledge of the next frames.
    HideAcknowledge {
        /// The number of frames.
        count: u32,
    },
    /// The next frames get lost.
    Lose {
        /// The number of frames.
        count: u32,
        /// Their sender.
        from: Side,
        /// Only these.
        identifier: Option<String>,
    },
    /// The next frames arrive late.
    Delay {
        /// The number of frames.
        count: u32,
        /// Their sender.
        from: Side,
        /// Only these.
        identifier: Option<String>,
        /// The time in s.
        seconds: f64,
    },
    /// Sends a frame.
    Send {
        /// In the notation of `cansend`.
        frame: String,
    },
    /// Lets time pass.
    Advance {
        /// The time in s.
        seconds: f64,
    },
    /// Selects the events.
    Subscribe {
        /// The wanted ones.
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
pub enum MemoryFault {
    /// Each attempt to program fails.
    Programming,
    /// Each attempt to erase fails.
    Erasing,
}

/// Who has sent a frame.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Side {
    /// The sensors.
    Sensors,
    /// The clients.
    Clients,
}

/// A kind of event.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Topic {
    /// An LED has changed.
    Leds,
    /// Power, mode, bit rate or state of the bus.
    State,
    /// A save has ended.
    Stored,
    /// A frame on the bus.
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

/// A value or null. A request that leaves it out is refused, because it would repair the sensor.
fn stated<'de, D: Deserializer<'de>, T: Deserialize<'de>>(from: D) -> Result<Option<T>, D::Error> {
    Option::deserialize(from)
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

/// The members of an object, each once.
struct Members(Map<String, Value>);

impl<'de> Deserialize<'de> for Members {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        from.deserialize_map(Self(Map::new()))
    }
}

impl<'de> de::Visitor<'de> for Members {
    type Value = Self;

    fn expecting(&self, f: &mut Formatter) -> fmt::Result {
        f.write_str("an object")
    }

    fn visit_map<A: de::MapAccess<'de>>(mut self, mut from: A) -> Result<Self, A::Error> {
        while let Some((name, value)) = from.next_entry::<String, Value>()? {
            if self.0.contains_key(&name) {
                return Err(de::Error::custom(format!("duplicate field `{name}`")));
            }
            self.0.insert(name, value);
        }
        Ok(self)
    }
}

/// The request in a line, and the sensor that it names. The error is one sentence.
pub(super) fn parse(line: &[u8]) -> Result<(Request, Option<String>), String> {
    let invalid = |error: serde_json::Error| format!("this is not a request: {error}");
    let Members(mut members) = serde_json::from_slice(line).map_err(invalid)?;
    let sensor = match members.remove("sensor") {
        None => None,
        Some(Value::String(name)) => Some(name),
        Some(other) => return Err(format!("the sensor is a name, not {other}")),
    };
    let request = Request::deserialize(Value::Object(members)).map_err(invalid)?;
    Ok((request, sensor))
}
