//! The operations on a sensor, as the command line and the page ask for them.

use super::rate::{NewRate, new_rate};
use crate::error::{Error, RequestError};
use crate::known::{assignments, known, new_rates, parameters, text};
use crate::master::NewAddress;
use clap::{Subcommand, ValueEnum};
use serde::de::Error as _;
use serde::{Deserialize, Deserializer};
use std::path::PathBuf;

/// What to zero.
#[derive(Clone, Copy, PartialEq, Eq, Debug, ValueEnum, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Axis {
    /// The first axis
    X,
    /// The second axis
    Y,
}

impl Axis {
    /// The name in the guide of a product.
    pub fn name(self) -> &'static str {
        match self {
            Self::X => "x",
            Self::Y => "y",
        }
    }
}

/// An operation on a sensor. Its documentation is the help of the command line.
#[derive(Clone, PartialEq, Eq, Debug, Subcommand, Deserialize)]
#[serde(remote = "Self", rename_all = "kebab-case", deny_unknown_fields)]
pub enum Request {
    /// Read parameters and values; without a name all of them
    Get {
        /// Names, or beginnings of their words
        #[arg(value_parser = known(text, parameters), hide_possible_values = true)]
        #[serde(default)]
        names: Vec<String>,
    },
    /// Write parameters, for example filter=2.5Hz,butterworth zero-x=1.25deg
    Set {
        /// NAME=VALUE; raw:N is the number of the protocol
        #[arg(required = true, value_parser = known(text, assignments), hide_possible_values = true)]
        assignments: Vec<String>,
        /// Store them afterwards
        #[arg(long, conflicts_with = "file")]
        #[serde(default)]
        save: bool,
        /// Change a file of `backup` instead of a sensor
        #[arg(long, value_name = "FILE")]
        #[serde(skip)]
        file: Option<PathBuf>,
    },
    /// Store the parameters in the sensor
    Save,
    /// Load the factory values
    LoadFactory,
    /// Make the present position zero
    Zero {
        /// One axis only
        #[serde(default)]
        axis: Option<Axis>,
        /// Store it afterwards
        #[arg(long)]
        #[serde(default)]
        save: bool,
    },
    /// Make the present position the reference frame of the machine (JN2101)
    Teach {
        /// Store it afterwards
        #[arg(long)]
        #[serde(default)]
        save: bool,
    },
    /// Restart the sensor
    Restart,
    /// The commands of the protocols that change the address
    #[command(flatten)]
    #[serde(skip)]
    Address(NewAddress),
    /// Change the bit rate: writes, stores, restarts, checks
    Rate {
        /// The new bit rate in kbit/s; auto: automatic detection (GEMAC)
        #[arg(value_name = "KBITS", value_parser = known(new_rate, new_rates))]
        #[serde(deserialize_with = "rate")]
        new: NewRate,
    },
    /// Show the name of the sensor on this computer, or give it one
    Label {
        /// The new name
        #[serde(default)]
        name: Option<String>,
        /// Remove the name
        #[arg(long, conflicts_with = "name")]
        #[serde(skip, default = "removes")]
        remove: bool,
    },
    /// What the sensor tells about itself
    #[command(skip)]
    Identity,
    /// One request: code and data (GEMAC), INDEX:SUB[=DATA] (CANopen, J1939), service class instance data (DeviceNet), parameter group (J1939), hexadecimal
    Raw {
        /// The request
        request: String,
    },
}

/// The page removes a name that it does not give.
fn removes() -> bool {
    true
}

fn rate<'de, D: Deserializer<'de>>(from: D) -> Result<NewRate, D::Error> {
    let text = String::deserialize(from)?;
    new_rate(&text).map_err(serde::de::Error::custom)
}

impl<'de> Deserialize<'de> for Request {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        let request = serde_json::Value::deserialize(from)?;
        let name = match &request {
            serde_json::Value::Object(own) => own.keys().next().cloned(),
            other => other.as_str().map(str::to_owned),
        };
        if let Some(name) = name.filter(|name| !names().contains(name)) {
            let names: Vec<String> = names().iter().map(|own| format!("`{own}`")).collect();
            let names = names.join(", ");
            return Err(D::Error::custom(format!(
                "unknown variant `{name}`, expected one of {names}"
            )));
        }
        match NewAddress::of(&request) {
            Some(address) => address.map(Self::Address).map_err(D::Error::custom),
            None => Self::deserialize(request).map_err(D::Error::custom),
        }
    }
}

/// The names of all requests.
fn names() -> Vec<String> {
    let command = Request::augment_subcommands(clap::Command::new(""));
    let names = command
        .get_subcommands()
        .map(|own| own.get_name().to_owned());
    names.chain(["identity".to_owned()]).collect()
}

impl Request {
    /// Refuses an operation that a data sheet does not describe.
    ///
    /// # Errors
    /// It is one.
    pub fn check_described(&self) -> Result<(), Error> {
        match self {
            Self::Address(address) if address.new.is_none() => Ok(()),
            Self::Address(_) | Self::Rate { .. } | Self::Zero { .. } | Self::Teach { .. } => {
                Err(RequestError::NotDescribed.into())
            }
            _ => Ok(()),
        }
    }

    /// The words of the command line.
    pub fn words(&self) -> Vec<String> {
        let (name, save, values) = match self {
            Self::Get { names } => ("get", false, names.clone()),
            Self::Set {
                assignments, save, ..
            } => ("set", *save, assignments.clone()),
            Self::Save => ("save", false, Vec::new()),
            Self::LoadFactory => ("load-factory", false, Vec::new()),
            Self::Zero { axis, save } => {
                let axis = axis.map(|axis| axis.name().to_owned());
                ("zero", *save, axis.into_iter().collect())
            }
            Self::Teach { save } => ("teach", *save, Vec::new()),
            Self::Restart => ("restart", false, Vec::new()),
            Self::Address(address) => {
                let new = address.new.map(|new| new.to_string());
                (address.name(), false, new.into_iter().collect())
            }
            Self::Rate { new } => ("rate", false, vec![new.word()]),
            Self::Label { name: None, remove } => {
                let remove = remove.then(|| "--remove".to_owned());
                return ["label".to_owned()].into_iter().chain(remove).collect();
            }
            Self::Label { name, .. } => ("label", false, name.iter().cloned().collect()),
            Self::Raw { request } => ("raw", false, vec![request.clone()]),
            Self::Identity => ("identity", false, Vec::new()),
        };
        let mut words = vec![name.to_owned()];
        if save {
            words.push("--save".to_owned());
        }
        crate::serve::line::positional(&mut words, &values);
        words
    }
}

#[cfg(test)]
mod tests {
    use super::Request;
    use crate::cli::{Cli, Command};
    use clap::Parser;

    fn request(body: &str) -> Result<Request, serde_json::Error> {
        serde_json::from_str(body)
    }

    #[test]
    fn page_and_command_line_have_the_same_operations() {
        for (body, expected) in [
            (r#""save""#, "save"),
            (r#""load-factory""#, "load-factory"),
            (r#""restart""#, "restart"),
            (r#"{"get":{}}"#, "get"),
            (r#"{"get":{"names":["filter"]}}"#, "get filter"),
            (
                r#"{"set":{"assignments":["zero-x=-1deg","b=2"],"save":true}}"#,
                "set --save zero-x=-1deg b=2",
            ),
            (r#"{"zero":{}}"#, "zero"),
            (r#"{"zero":{"axis":"x","save":true}}"#, "zero --save x"),
            (r#"{"teach":{}}"#, "teach"),
            (r#"{"node-id":{"new":11}}"#, "node-id 11"),
            (r#"{"mac":{"new":7}}"#, "mac 7"),
            (r#"{"address":{"new":160}}"#, "address 160"),
            (r#"{"address":{}}"#, "address"),
            (r#"{"rate":{"new":"500"}}"#, "rate 500"),
            (r#"{"rate":{"new":"62.5"}}"#, "rate 62.5"),
            (r#"{"rate":{"new":"auto"}}"#, "rate auto"),
            (r#"{"label":{"name":"boom"}}"#, "label boom"),
            (r#"{"label":{"name":"--remove"}}"#, "label -- --remove"),
            (r#"{"label":{}}"#, "label --remove"),
            (r#"{"raw":{"request":"1018:1"}}"#, "raw 1018:1"),
            (r#"{"raw":{"request":"--help"}}"#, "raw -- --help"),
        ] {
            let mut request = request(body).unwrap_or_else(|error| panic!("{body}: {error}"));
            assert_eq!(request.words().join(" "), expected);
            let all = format!("plumbline {expected}");
            let cli = Cli::try_parse_from(all.split(' ')).unwrap();
            let Command::Operation(own) = cli.command else {
                panic!("{all}");
            };
            if let Request::Label {
                name: Some(_),
                remove,
            } = &mut request
            {
                *remove = false;
            }
            assert_eq!(own, request);
        }
        assert_eq!(
            request(r#""identity""#).unwrap().words(),
            ["identity"].map(str::to_owned)
        );
    }

    #[test]
    fn unknown_operations_and_fields_are_refused() {
        for body in [
            "",
            "null",
            "{}",
            "[]",
            r#""serve""#,
            r#""man""#,
            r#"{"set":{}}"#,
            r#"{"set":{"assignments":"a=1"}}"#,
            r#"{"set":{"assignments":[],"file":"/etc/passwd"}}"#,
            r#"{"zero":{"axis":1}}"#,
            r#"{"node-id":{"new":256}}"#,
            r#"{"node-id":{"new":-1}}"#,
            r#"{"node-id":{}}"#,
            r#"{"mac":{"new":null}}"#,
            r#"{"mac":{"new":7,"save":true}}"#,
            r#"{"address":7}"#,
            r#"{"address":{"new":"7"}}"#,
            r#"{"node-id":{"new":7},"mac":{"new":7}}"#,
            r#"{"rate":{"new":"77"}}"#,
            r#"{"zero":{},"save":{}}"#,
        ] {
            assert!(request(body).is_err(), "{body}");
        }
    }
}
