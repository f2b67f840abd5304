//! What a sensor has told about itself.

use crate::error::RequestError;
use crate::master::Target;
use plumbline::can::BitRate;
use plumbline::model::catalog::Product;
use serde_json::{Value, json};
use std::fmt::{self, Display, Formatter};

/// A sensor that has answered.
#[derive(Clone, Debug)]
pub struct Found {
    /// The protocol and the address of the sensor.
    pub target: Target,
    /// The products that it can be; empty for a foreign device.
    pub products: Vec<&'static Product>,
    /// The order number, or what is known of it.
    pub article: Option<String>,
    /// The serial number of the sensor.
    pub serial: Option<u32>,
    /// The version of the firmware.
    pub firmware: Option<String>,
    /// The name that the user has given to it.
    pub label: Option<String>,
    /// Another master owns it (DeviceNet), so it has told nothing.
    pub is_owned: bool,
    /// The serial numbers of other sensors that have answered at the same address.
    pub twins: Vec<u32>,
}

/// What a user tells a sensor apart by; as a text, it is one line.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct About {
    /// The product, or the article of an unknown one.
    pub product: String,
    /// The name that the user has given to it.
    pub label: Option<String>,
    /// The serial number.
    pub serial: Option<u32>,
    /// The address with its kind.
    pub address: String,
    /// The bit rate.
    pub rate: Option<&'static str>,
}

impl Display for About {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        f.write_str(&self.product)?;
        if let Some(label) = &self.label {
            write!(f, " {label:?}")?;
        }
        if let Some(serial) = self.serial {
            write!(f, ", serial {serial}")?;
        }
        write!(f, ", {}", self.address)?;
        self.rate.map_or(Ok(()), |rate| write!(f, " at {rate}"))
    }
}

/// The serial numbers of devices that have none.
const NO_SERIAL: [u32; 2] = [0, u32::MAX];

/// What tells a sensor from others, wherever it is.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Identity {
    article: Option<String>,
    serial: Option<u32>,
}

impl Identity {
    /// The serial number; None: the sensor does not have one of its own.
    pub fn serial(&self) -> Option<u32> {
        self.serial
    }

    /// Whether no other sensor has it.
    pub fn is_unique(&self) -> bool {
        self.serial.is_some()
    }
}

impl Found {
    /// A sensor that has told nothing yet.
    pub(crate) fn at(target: Target) -> Self {
        Self {
            target,
            products: Vec::new(),
            article: None,
            serial: None,
            firmware: None,
            label: None,
            is_owned: false,
            twins: Vec::new(),
        }
    }

    /// What tells it from other sensors.
    pub fn identity(&self) -> Identity {
        Identity {
            article: self.article.clone(),
            serial: self.serial.filter(|serial| !NO_SERIAL.contains(serial)),
        }
    }

    /// The name of the protocol in documents.
    pub fn protocol(&self) -> &'static str {
        self.target.protocol().name
    }

    /// In one line, for people.
    pub fn line(&self, rate: Option<BitRate>) -> String {
        self.about(rate).to_string()
    }

    /// What a user tells it apart by.
    pub fn about(&self, rate: Option<BitRate>) -> About {
        let product = match (self.product(), &self.article) {
            (Some(product), _) => product.name.to_owned(),
            (None, Some(article)) => format!("article {article}"),
            (None, None) => "unknown product".to_owned(),
        };
        About {
            product,
            label: self.label.clone(),
            serial: self.serial,
            address: self.target.named(),
            rate: rate.map(BitRate::name),
        }
    }

    /// That several sensors have answered, for people; None: only one has.
    pub fn twins(&self) -> RequestError {
        let all = self.serial.iter().chain(&self.twins);
        let all: Vec<String> = all.map(u32::to_string).collect();
        let (count, address) = (all.len(), self.target.named());
        match self.target.node_id() {
            Some(_) => RequestError::TwinNodes(count, address, all.join(" and ")),
            None => RequestError::Twins(count, address, all.join(" and ")),
        }
    }

    /// The only product that it can be.
    pub fn product(&self) -> Option<&'static Product> {
        match self.products[..] {
            [only] => Some(only),
            _ => None,
        }
    }

    /// As `scan` prints it; `rate` in kbit/s.
    pub fn json(&self, rate: Option<Value>) -> Value {
        let mut document = json!({
            "rate": rate,
            "protocol": self.protocol(),
            "product": self.product().map(|product| product.name),
            "address": self.target.address(),
            "serial": self.serial,
            "article": self.article,
            "firmware": self.firmware,
        });
        if let Some(label) = &self.label {
            document["label"] = json!(label);
        }
        document
    }
}
