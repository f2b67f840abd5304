//! What the tool asks before it goes on. The terminal and the page ask the same questions, each in its own words.

use crate::calibrate::host;
use crate::identify::About;
use crate::texts::Text;
use clap::ValueEnum;
use serde::{Deserialize, Serialize};
use std::fmt::{self, Display, Formatter};
use std::path::PathBuf;

/// A question with what the user must know to answer it. The page gets it as an object with the field `id`, and sends the object back as a
/// yes: a yes is for this question with this data only.
#[derive(Clone, PartialEq, Debug, Serialize, Deserialize)]
#[serde(tag = "id", rename_all = "kebab-case", deny_unknown_fields)]
pub enum Question {
    /// A scan of a bus without traffic: requests at all addresses and bit rates.
    Silent,
    /// A bus without traffic, and no bit rate is given: requests at all bit rates.
    AllRates,
    /// A scan of a bus with traffic, but without a sensor: requests at all addresses.
    AllAddresses,
    /// The same for the addresses as delivered.
    Delivered,
    /// A scan that has found a sensor: requests at all other addresses.
    More,
    /// Frames that can be those of a sensor: a request to it.
    Likely {
        /// The name of the protocol.
        protocol: String,
        /// The address, as the command line takes it.
        address: String,
    },
    /// The adapter has no listen-only mode: it takes part in the bus.
    TakePart {
        /// The bit rate; None: that of the interface.
        rate: Option<String>,
    },
    /// The tables of another product than the sensor says.
    OtherProduct {
        /// The products that it says.
        told: String,
        /// Its article.
        article: String,
        /// Its software version.
        version: Option<String>,
        /// The product of the user.
        product: String,
    },
    /// The article fits several products: whether it is this one. `--yes` does not answer it.
    WhichProduct {
        /// The article of the sensor.
        article: String,
        /// All products that fit.
        products: String,
        /// The product of this question.
        product: String,
    },
    /// The data sheet of another device.
    DataSheet {
        /// What differs.
        doubts: Vec<Doubt>,
    },
    /// A change of the sensor. The page asks it in a dialog of its own, as the following ones.
    #[serde(skip)]
    Change {
        /// What is changed.
        change: Change,
        /// The sensor.
        sensor: About,
        /// Its present angles with their names.
        angles: Vec<(String, String)>,
    },
    /// A sensor that sends its angles already, with this period in ms: another period.
    #[serde(skip)]
    Period(u32),
    /// A TPDO of an operational node that is on; its number from 1.
    #[serde(skip)]
    Tpdo(u16),
    /// A file that exists.
    #[serde(skip)]
    Overwrite(PathBuf),
    /// A position of a calibration.
    #[serde(skip)]
    Calibrate(host::Question),
}

/// What differs between a data sheet and its device.
#[derive(Clone, PartialEq, Eq, Debug, Serialize, Deserialize)]
pub struct Doubt {
    /// The name of the entry.
    pub what: String,
    /// The number in the data sheet, in hexadecimal.
    pub wanted: String,
    /// The number of the device; None: it cannot be read.
    pub own: Option<String>,
}

/// A change of the sensor that needs a yes.
#[derive(Clone, PartialEq, Eq, Debug)]
pub enum Change {
    /// The present position becomes zero.
    Zero,
    /// The present position becomes the reference frame.
    Teach,
    /// The factory values.
    LoadFactory {
        /// The address and the bit rate that it has then, if it is restarted.
        restart: Option<(String, String)>,
    },
    /// Another bit rate.
    Rate {
        /// The new bit rate.
        new: String,
    },
    /// The settings of a sensor with another serial number.
    Restore {
        /// The serial number in the file.
        file: Option<u32>,
        /// That of the sensor.
        own: Option<u32>,
    },
}

/// The names of questions for `--yes`.
#[derive(Clone, Copy, PartialEq, Eq, Debug, ValueEnum)]
pub enum Name {
    /// All of them
    All,
    /// Requests at addresses and bit rates that are not known to be a sensor's
    Ask,
    /// An adapter without listen-only mode takes part in the bus
    Listen,
    /// The tables of another product than the sensor says
    Product,
    /// The data sheet of another device
    DataSheet,
    /// Zero of the angles
    Zero,
    /// The reference frame
    Teach,
    /// The factory values
    LoadFactory,
    /// Another bit rate
    Rate,
    /// The settings of another sensor
    Restore,
    /// Cyclic messages that other devices can need
    Cyclic,
    /// A file that exists
    Overwrite,
}

impl Change {
    /// The name for `--yes`.
    pub const fn name(&self) -> Name {
        match self {
            Self::Zero => Name::Zero,
            Self::Teach => Name::Teach,
            Self::LoadFactory { .. } => Name::LoadFactory,
            Self::Rate { .. } => Name::Rate,
            Self::Restore { .. } => Name::Restore,
        }
    }
}

impl Question {
    /// The name for `--yes`; None: only a user can answer it.
    pub const fn name(&self) -> Option<Name> {
        Some(match self {
            Self::Silent
            | Self::AllRates
            | Self::AllAddresses
            | Self::Delivered
            | Self::More
            | Self::Likely { .. } => Name::Ask,
            Self::TakePart { .. } => Name::Listen,
            Self::OtherProduct { .. } => Name::Product,
            Self::DataSheet { .. } => Name::DataSheet,
            Self::Change { change, .. } => change.name(),
            Self::Period(_) | Self::Tpdo(_) => Name::Cyclic,
            Self::Overwrite(_) => Name::Overwrite,
            Self::WhichProduct { .. } | Self::Calibrate(_) => return None,
        })
    }
}

impl Name {
    /// Whether these names contain this one.
    pub fn is_in(self, names: &[Self]) -> bool {
        names.contains(&Self::All) || names.contains(&self)
    }
}

impl Display for Name {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let value = self.to_possible_value();
        f.write_str(value.as_ref().map_or("", |value| value.get_name()))
    }
}

impl Display for Question {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        match self {
            Self::Silent => f.write_str("There is no traffic. Ask at all addresses and bit rates?"),
            Self::AllRates => f.write_str(
                "There is no traffic at any bit rate. Ask at all bit rates? At a wrong rate the questions destroy the messages of other devices.",
            ),
            Self::AllAddresses => f.write_str(
                "There is traffic, but no sensor was recognised. Ask at all addresses? Other devices can interpret a request as a command.",
            ),
            Self::Delivered => f.write_str(
                "There is traffic, but no sensor was recognised. Ask at the addresses as delivered? Other devices can interpret a request as a command.",
            ),
            Self::More => f.write_str(
                "Search for more sensors? The tool asks at all other addresses. Other devices can interpret a request as a command.",
            ),
            Self::Likely { protocol, address } => write!(
                f,
                "Frames look like those of a sensor ({protocol}, {address}). Ask it? Another device can interpret the request as a command."
            ),
            Self::TakePart { rate } => write!(
                f,
                "The adapter has no listen-only mode. Allow it to take part in the bus at {} while the tool listens? It acknowledges the messages of other devices, and at a wrong bit rate it destroys them.",
                rate.as_deref().unwrap_or("the bit rate of the interface")
            ),
            Self::OtherProduct {
                told,
                article,
                version,
                product,
            } => {
                write!(f, "The sensor says that it is {told} (article {article}")?;
                if let Some(version) = version {
                    write!(f, ", software version {version}")?;
                }
                write!(f, "). Use the tables of {product} anyway?")
            }
            Self::WhichProduct {
                article,
                products,
                product,
            } => write!(
                f,
                "The sensor has the article {article}, which fits several products ({products}), and does not report its software version. Is it {product}?"
            ),
            Self::DataSheet { doubts } => {
                write!(f, "The data sheet {}. Use it anyway?", Doubts(doubts.clone()))
            }
            Self::Change {
                change,
                sensor,
                angles,
            } => {
                let angles: Vec<String> = angles
                    .iter()
                    .map(|(name, angle)| format!("{name}  {angle}"))
                    .collect();
                write!(f, "{change}? {sensor}; {}", angles.join(", "))
            }
            Self::Period(own) => write!(
                f,
                "The sensor sends its angles already, with a period of {own} ms, and other devices can need them. Change the period until the command ends?"
            ),
            Self::Tpdo(number) => write!(
                f,
                "TPDO {number} of the operational node is on, although no message of it is received now, and other devices can need it. Change it until the command ends?"
            ),
            Self::Overwrite(path) => write!(f, "{} exists. Replace it?", path.display()),
            Self::Calibrate(question) => question.fmt(f),
        }
    }
}

/// All that differs; as a text, in a sentence after "the data sheet".
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Doubts(pub Vec<Doubt>);

impl Display for Doubts {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let texts: Vec<String> = self.0.iter().map(Doubt::to_string).collect();
        f.write_str(&texts.join("; it "))
    }
}

impl Text for Doubts {
    fn german(&self) -> String {
        let texts = self.0.iter().map(|Doubt { what, wanted, own }| {
            let own = own.as_deref().unwrap_or("nicht lesbar");
            format!("{what} {wanted} im Datenblatt, {own} im Gerät")
        });
        texts.collect::<Vec<_>>().join("; ")
    }
}

impl Display for Doubt {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let Self { what, wanted, own } = self;
        write!(f, "is for {what} {wanted}, but the device ")?;
        match own {
            Some(own) => write!(f, "says {own}"),
            None => f.write_str("does not let it be read"),
        }
    }
}

impl Display for Change {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        match self {
            Self::Zero => f.write_str("Make the present position zero"),
            Self::Teach => f.write_str("Make the present position the reference frame"),
            Self::LoadFactory { restart: None } => f.write_str("Load the factory values"),
            Self::LoadFactory {
                restart: Some((address, rate)),
            } => write!(
                f,
                "Load the factory values and restart the sensor (it then has {address} and {rate}; the other devices on the bus must have the same rate)"
            ),
            Self::Rate { new } => write!(
                f,
                "Change the bit rate to {new} (the other devices on the bus must have the same rate)"
            ),
            Self::Restore { file, own } => {
                let number =
                    |serial: &Option<u32>| serial.map_or("none".to_owned(), |own| own.to_string());
                write!(
                    f,
                    "The file is of a sensor with another serial number ({}, this one has {}). Write its settings to this sensor",
                    number(file),
                    number(own)
                )
            }
        }
    }
}
