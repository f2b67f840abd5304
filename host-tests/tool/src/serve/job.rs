//! The jobs of the worker, and what they need.

use super::line::Words;
use super::sheets::Sheets;
use crate::adapter::Adapter;
use crate::cli::{Cli, Options};
use crate::error::{Error, PageError};
use crate::master::Protocol;
use crate::ops::Request;
use crate::question::{Name, Question};
use clap::Parser;
use serde::Deserialize;
use serde_json::Value;
use tokio::sync::oneshot;

/// Opens the adapter of a port, in the thread of the worker.
pub type Opener = Box<dyn FnMut(&str) -> Result<Box<dyn Adapter>, Error> + Send>;

/// What the page offers first.
#[derive(Clone, Debug)]
pub struct Start {
    /// The sensor of the command line.
    pub connect: Connect,
    /// It is connected at once.
    pub connects: bool,
}

/// How to take part in the bus.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Part {
    /// Receive frames, and send nothing.
    Listen,
    /// Send requests to a sensor.
    Active,
}

/// The job to connect: to a bus, or to a sensor.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Connect {
    /// The port of the adapter.
    pub port: String,
    /// The bit rate in kbit/s; None: the tool finds it.
    #[serde(default)]
    pub rate: Option<f64>,
    /// Whether something is sent.
    pub mode: Part,
    /// The protocol of the address.
    #[serde(default)]
    pub protocol: Option<String>,
    /// The address, as `scan` shows it.
    #[serde(default)]
    pub address: Option<String>,
    /// The product, or the key of a data sheet.
    #[serde(default)]
    pub product: Option<String>,
    /// The questions that were answered with yes.
    #[serde(default)]
    pub yes: Vec<Question>,
    /// The questions that are answered with yes on the command line.
    #[serde(skip)]
    pub names: Vec<Name>,
}

impl Connect {
    /// The sensor of the options of the command line.
    pub fn of(options: &Options) -> Self {
        let given = options.sensor.first();
        Self {
            port: options.port.clone().unwrap_or_default(),
            rate: options
                .rate
                .map(|rate| f64::from(rate.bits_per_second()) / 1000.0),
            mode: Part::Active,
            protocol: given.map(|(protocol, _)| protocol.name.to_owned()),
            address: given.map(|(_, address)| address.to_owned()),
            product: options.product.clone(),
            yes: Vec::new(),
            names: options.yes.clone(),
        }
    }

    /// The options of the command line.
    ///
    /// # Errors
    /// There is an address without a protocol, or no such data sheet.
    pub fn words(&self, sheets: &Sheets) -> Result<Words, Error> {
        let mut words = vec!["--port".to_owned(), self.port.clone()];
        if let Some(rate) = self.rate {
            words.extend(["--rate".to_owned(), rate.to_string()]);
        }
        if let Some(address) = &self.address {
            let protocol = self.protocol.as_deref().and_then(Protocol::named);
            let protocol = protocol.ok_or(PageError::NoProtocol)?;
            words.push(format!("{}={address}", protocol.option));
        }
        if let Some(product) = &self.product {
            words.push(match sheets.find(product)? {
                Some(kept) => kept.option(),
                None => format!("--product={product}"),
            });
        }
        Ok(words)
    }
}

/// The job to find sensors at a port.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Scan {
    /// The port of the adapter.
    pub port: String,
    /// The bit rate in kbit/s; None: all.
    #[serde(default)]
    pub rate: Option<f64>,
    /// The user wants it to ask at other addresses.
    #[serde(default)]
    pub active: bool,
    /// The same at all identifiers.
    #[serde(default)]
    pub search: bool,
    /// The questions that were answered with yes.
    #[serde(default)]
    pub yes: Vec<Question>,
}

impl Scan {
    /// The words of the command line.
    pub fn words(&self) -> Words {
        let mut words = vec!["--port".to_owned(), self.port.clone()];
        if let Some(rate) = self.rate {
            words.extend(["--rate".to_owned(), rate.to_string()]);
        }
        words.push("scan".to_owned());
        for (name, is_wanted) in [("--active", self.active), ("--search", self.search)] {
            if is_wanted {
                words.push(name.to_owned());
            }
        }
        words
    }
}

/// The job for a sensor in the chart, beside that of the session.
#[derive(Debug, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Chart {
    /// Show this one too.
    Add(Other),
    /// Stops showing the sensor with this number.
    Remove(u64),
}

/// Another sensor on the same bus.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Other {
    /// The protocol of the address.
    pub protocol: String,
    /// The address, as `scan` shows it.
    pub address: String,
    /// The product, or the key of a data sheet.
    #[serde(default)]
    pub product: Option<String>,
    /// The questions that were answered with yes.
    #[serde(default)]
    pub yes: Vec<Question>,
}

/// What the worker is asked to do.
#[derive(Debug)]
pub enum Task {
    /// Connect to a bus or to a sensor.
    Connect(Connect),
    /// Close the adapter, so that other programs can use it.
    Disconnect,
    /// Find sensors at a port.
    Scan(Scan),
    /// Run a command on the sensor.
    Run(Request),
    /// Add or remove a sensor of the chart.
    Chart(Chart),
    /// Read all settings into a file.
    Backup,
    /// Write the settings of a file that differ.
    Restore {
        /// The content of the file.
        text: String,
        /// Its name, for the line.
        name: String,
        /// Only these settings; empty: all.
        only: Vec<String>,
        /// Also the name of the sensor.
        label: bool,
    },
    /// Set the samples per second.
    Samples(u32),
    /// Do it only if this is the number of the sensor.
    For {
        /// The number that the page has.
        sensor: Option<u64>,
        /// The job for that sensor.
        task: Box<Task>,
    },
}

/// A job with the place for its answer.
pub struct Job {
    /// The job to do.
    pub task: Task,
    /// The channel for the answer. If it is closed, nobody waits for the answer.
    pub reply: oneshot::Sender<Result<Value, Error>>,
}

/// A command of these words. The values of the page are never options.
///
/// # Errors
/// The words are no command.
pub fn parse(words: &Words) -> Result<Cli, Error> {
    let all = ["plumbline", "--json"].into_iter().map(str::to_owned);
    Cli::try_parse_from(all.chain(words.iter().cloned())).map_err(|error| {
        let text = error.to_string();
        let line = text.lines().next().unwrap_or_default();
        PageError::Words(line.trim_start_matches("error: ").to_owned()).into()
    })
}

/// The options of these words.
///
/// # Errors
/// The words are no options.
pub fn options(words: &Words) -> Result<Options, Error> {
    let all = [words.clone(), vec!["man".to_owned()]].concat();
    Ok(parse(&all)?.options)
}
