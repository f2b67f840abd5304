//! The jobs of the worker, and what they need.

use super::line::{self, Words};
use super::sheets::{Kept, Sheets};
use super::transmission::Transmit;
use crate::cli::Options;
use crate::connect::Wanted;
use crate::error::{Error, FileError, PageError};
use crate::identify;
use crate::image::ImageFile;
use crate::labels::Labels;
use crate::master::Protocol;
use crate::ops::Request;
use crate::question::{Name, Question};
use crate::scan::Memory;
use adapter::Adapter;
use plumbline::can::BitRate;
use serde::{Deserialize, Deserializer};
use serde_json::Value;
use std::path::Path;
use std::sync::Arc;
use tokio::sync::oneshot;
use virtual_sensor::server as stand_in;

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
    /// Receive frames, and send only those of the transmit list or of a log.
    Frames,
    /// Send requests to a sensor.
    Active,
}

/// The job to connect: to a bus, or to a sensor.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Connect {
    /// The port of the adapter.
    pub port: String,
    /// The bit rate; None: the tool finds it.
    #[serde(default, deserialize_with = "rate")]
    pub rate: Option<BitRate>,
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
            rate: options.rate,
            mode: Part::Active,
            protocol: given.map(|(protocol, _)| protocol.name.to_owned()),
            address: given.map(|(_, address)| address.to_owned()),
            product: options.product.clone(),
            yes: Vec::new(),
            names: options.yes.clone(),
        }
    }

    fn protocol(&self) -> Result<&'static Protocol, Error> {
        let named = self.protocol.as_deref().and_then(Protocol::named);
        named.ok_or_else(|| PageError::NoProtocol.into())
    }

    /// Where the sensor is, with its data sheet. `config` is the folder with the names of sensors.
    ///
    /// # Errors
    /// There is no such product, data sheet or address.
    pub fn wanted(
        &self,
        sheets: &Sheets,
        config: Option<&Path>,
        memory: Memory,
    ) -> Result<(Wanted, Option<Arc<Kept>>), Error> {
        let named = self.product.as_deref();
        let kept = sheets.find(named.unwrap_or_default())?;
        let product = match &kept {
            Some(kept) => Some(kept.sheet.product),
            None => named.map(identify::product).transpose()?,
        };
        let target = self.address.as_deref();
        let target = target.map(|address| (self.protocol()?.target)(address));
        let wanted = Wanted {
            rate: self.rate,
            target: target.transpose()?,
            product,
            sheet: kept.as_ref().map(|kept| kept.sheet.clone()),
            labels: Labels::open(config).unwrap_or_default(),
            memory,
            ..Wanted::default()
        };
        Ok((wanted, kept))
    }

    /// The options of the command line.
    ///
    /// # Errors
    /// There is an address without a protocol, or no such data sheet.
    pub fn words(&self, sheets: &Sheets) -> Result<Words, Error> {
        let mut words = line::bus(&self.port, self.rate);
        if let Some(address) = &self.address {
            words.push(format!("{}={address}", self.protocol()?.option));
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
    /// The bit rate; None: all.
    #[serde(default, deserialize_with = "rate")]
    pub rate: Option<BitRate>,
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
        let mut words = line::bus(&self.port, self.rate);
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

/// The job to load another program into a sensor.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Update {
    /// The name of the image file, for the line.
    pub name: String,
    /// The image file.
    pub image: Vec<u8>,
    /// The settings before, as a file; they are compared with those after.
    #[serde(default)]
    pub backup: Option<String>,
    /// Where a sensor waits in its bootloader; None: the sensor of the session.
    #[serde(default)]
    pub waiting: Option<Connect>,
    /// The questions that were answered with yes.
    #[serde(default)]
    pub yes: Vec<Question>,
}

impl Update {
    /// The image file.
    ///
    /// # Errors
    /// It is not one, or it is damaged.
    pub fn parse(&self) -> Result<ImageFile, Error> {
        image(&self.name, self.image.clone())
    }
}

/// An image file of a page.
///
/// # Errors
/// It is not one, or it is damaged.
pub fn image(name: &str, bytes: Vec<u8>) -> Result<ImageFile, Error> {
    let bad = |why| FileError::Image(texts::shown(name), why).into();
    ImageFile::parse(bytes).map_err(bad)
}

/// The job to make the offset of the mounting zero.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Align {
    /// Store it afterwards.
    #[serde(default)]
    pub save: bool,
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
    /// Load another program into a sensor.
    Update(Update),
    /// Make the offset of the mounting zero.
    Align(Align),
    /// Add or remove a sensor of the chart.
    Chart(Chart),
    /// Change what is sent beside the requests.
    Transmit(Transmit),
    /// Move or break the virtual sensor.
    StandIn(stand_in::Request),
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

/// A bit rate in kbit/s.
fn rate<'de, D: Deserializer<'de>>(from: D) -> Result<Option<BitRate>, D::Error> {
    let rate = Option::<f64>::deserialize(from)?;
    let rate = rate.map(|rate| bench::bit_rate(&rate.to_string()));
    rate.transpose().map_err(serde::de::Error::custom)
}
