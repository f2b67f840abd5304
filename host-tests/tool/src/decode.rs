//! What the frames on a bus are: protocol, address, product, message, and values with their units.
//!
//! Each protocol has a [`Decoder`], which keeps the nodes that it has recognised. Identifiers of different protocols are the same, so a
//! frame belongs first to the protocol that has recognised its node, and otherwise to the first one in which it has a meaning.
//!
//! A node that has not told its product can be any product of its protocol, or a device that is not in the catalogue. What the protocol
//! itself defines is decoded if it is the same in all products. What the product defines, for example its process data, is shown as bytes.

pub mod database;
mod device;
pub mod filter;
pub mod list;
pub mod log;

use crate::master::{PROTOCOLS, Protocol};
use crate::ops::get::shown_text;
use crate::ops::report::Shown;
use crate::sheet::{Entry, Sheet};
use database::Database;
pub use device::{Device, Known};
use plumbline::can::Frame;
use plumbline::param::{DataType, number};
use serde_json::{Map, Value, json};
use std::fmt::{self, Display, Formatter};

/// A value in a frame.
#[derive(Clone, PartialEq, Debug)]
pub struct Named {
    /// The name of the entry, or of the field of the protocol.
    pub name: String,
    /// The value with its unit.
    pub text: String,
    /// The same as JSON.
    pub json: Value,
}

impl Named {
    /// A text without a unit.
    pub fn text(name: impl Into<String>, text: impl Into<String>) -> Self {
        let text = text.into();
        Self {
            name: name.into(),
            json: json!({"value": text, "unit": ""}),
            text,
        }
    }

    /// A text of the device.
    pub fn raw(name: &str, bytes: &[u8]) -> Self {
        let Shown { name, text, json } = shown_text(name, bytes);
        Self { name, text, json }
    }

    /// A number without a unit.
    pub fn number(name: impl Into<String>, number: impl Into<u64>) -> Self {
        let number = number.into();
        Self {
            name: name.into(),
            text: number.to_string(),
            json: json!({"value": number, "unit": ""}),
        }
    }

    /// Bytes whose meaning is not known.
    pub fn bytes(bytes: &[u8]) -> Self {
        Self::text("data", hexadecimal(bytes))
    }

    /// The value of an entry in these bytes. Bytes of another length are shown as they are.
    pub fn of(entry: &Entry, bytes: &[u8]) -> Self {
        let name = entry.name.clone();
        if entry.data_type == DataType::Text {
            return Self::raw(&name, bytes);
        }
        if bytes.len() != usize::from(entry.data_type.size()) {
            return Self::text(name, hexadecimal(bytes));
        }
        let raw = number(bytes);
        Self {
            name,
            text: entry.text(raw),
            json: entry.json(raw),
        }
    }
}

/// Bytes as two digits each.
fn hexadecimal(bytes: &[u8]) -> String {
    let digits = bytes.iter().map(|byte| format!("{byte:02X}"));
    digits.collect::<Vec<_>>().join(" ")
}

/// The meaning of a frame.
#[derive(Clone, PartialEq, Debug)]
pub struct Decoded {
    /// The name of the protocol.
    pub protocol: &'static str,
    /// The node is recognised, or no other protocol has such a message.
    pub is_sure: bool,
    /// The address of the sensor, as `scan` shows it; None: the message is for all nodes.
    pub node: Option<String>,
    /// The name of the product, if it is known.
    pub product: Option<&'static str>,
    /// What the message is.
    pub message: String,
    /// The values in it.
    pub values: Vec<Named>,
    /// Its values are bytes, because the product is not known.
    pub needs_product: bool,
}

impl Decoded {
    /// A message without values.
    pub fn new(protocol: &Protocol, message: impl Into<String>) -> Self {
        Self {
            protocol: protocol.name,
            is_sure: true,
            node: None,
            product: None,
            message: message.into(),
            values: Vec::new(),
            needs_product: false,
        }
    }

    /// The same from or to a node.
    pub fn of(self, node: impl Display, device: &Device) -> Self {
        Self {
            node: Some(node.to_string()),
            product: device.product(),
            ..self
        }
    }

    /// The same with these values.
    pub fn with(self, values: Vec<Named>) -> Self {
        Self { values, ..self }
    }

    /// The same with data that only the product of the node explains.
    pub fn needing_product(self, data: &[u8]) -> Self {
        let values = match data {
            [] => Vec::new(),
            data => vec![Named::bytes(data)],
        };
        Self {
            values,
            needs_product: !data.is_empty(),
            ..self
        }
    }

    /// Whether a sensor with this address has sent the message, or receives it.
    pub fn is_of(&self, address: &str) -> bool {
        let node = self.node.as_deref().unwrap_or_default();
        let is_node = node.trim_end_matches('h') == address;
        is_node || self.message.ends_with(&format!(" to {address}"))
    }

    /// As an object of JSON.
    pub fn json(&self) -> Map<String, Value> {
        let values = self.values.iter();
        let values: Map<String, Value> = values
            .map(|value| (value.name.clone(), value.json.clone()))
            .collect();
        let mut document = Map::new();
        document.insert("protocol".to_owned(), self.protocol.into());
        if let Some(node) = &self.node {
            document.insert("address".to_owned(), node.as_str().into());
        }
        if let Some(product) = self.product {
            document.insert("product".to_owned(), product.into());
        }
        document.insert("message".to_owned(), self.message.as_str().into());
        document.insert("values".to_owned(), values.into());
        document
    }
}

impl Display for Decoded {
    fn fmt(&self, f: &mut Formatter) -> fmt::Result {
        f.write_str(self.protocol)?;
        if let Some(node) = &self.node {
            write!(f, " {node}")?;
        }
        if let Some(product) = self.product {
            write!(f, " {product}")?;
        }
        write!(f, ": {}", self.message)?;
        for Named { name, text, .. } in &self.values {
            write!(f, ", {name} = {text}")?;
        }
        Ok(())
    }
}

/// Finds out what the frames of a protocol are.
pub trait Decoder {
    /// The meaning of the next frame on the bus; None: the protocol has no such message.
    fn decode(&mut self, frame: &Frame) -> Option<Decoded>;
}

/// The decoders of a bus.
pub struct Bus {
    decoders: Vec<Box<dyn Decoder>>,
    /// The databases of other devices.
    databases: Vec<Database>,
}

impl Bus {
    /// A bus with nodes of all protocols.
    pub fn new() -> Self {
        let all = PROTOCOLS.map(|protocol| (protocol.decoder)(Known::all(protocol)));
        Self {
            decoders: all.into(),
            databases: Vec::new(),
        }
    }

    /// A bus with nodes of this product, or with this data sheet.
    pub fn of(sheet: Sheet) -> Self {
        let own = PROTOCOLS.into_iter();
        let own = own.filter(|protocol| protocol.is_of(sheet.product));
        let known = Known::given(sheet.clone());
        let own = own.map(|protocol| (protocol.decoder)(known.clone()));
        Self {
            decoders: own.collect(),
            databases: Vec::new(),
        }
    }

    /// A bus with nodes of all protocols, and with CANopen devices with this data sheet.
    pub fn beside(sheet: &Sheet) -> Self {
        let all = PROTOCOLS.map(|protocol| {
            (protocol.decoder)(match protocol.is_of(sheet.product) {
                true => Known::beside(protocol, sheet.clone()),
                false => Known::all(protocol),
            })
        });
        Self {
            decoders: all.into(),
            databases: Vec::new(),
        }
    }

    /// The same bus with other devices, which these databases describe.
    pub fn with(self, databases: Vec<Database>) -> Self {
        Self { databases, ..self }
    }

    /// The meaning of the next frame; None: it is not known.
    pub fn decode(&mut self, frame: &Frame) -> Option<Decoded> {
        // Each decoder takes each frame, because it can recognise its nodes.
        let decoders = self.decoders.iter_mut();
        let all: Vec<Decoded> = decoders
            .filter_map(|decoder| decoder.decode(frame))
            .collect();
        let sure = all.iter().position(|decoded| decoded.is_sure);
        let mut databases = self.databases.iter();
        let other = match sure {
            None => databases.find_map(|database| database.decode(frame)),
            Some(_) => None,
        };
        other.or_else(|| all.into_iter().nth(sure.unwrap_or(0)))
    }
}

impl Default for Bus {
    fn default() -> Self {
        Self::new()
    }
}
