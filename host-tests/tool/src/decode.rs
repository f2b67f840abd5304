//! What the frames on a bus are: protocol, address, product, message, and values with their units.
//!
//! Each protocol has a [`Decoder`], which keeps the nodes that it has recognised. Identifiers of different protocols are the same, so a
//! frame belongs first to the protocol that has recognised its node, and otherwise to the first one in which it has a meaning.
//!
//! A node that has not told its product can be any product of its protocol. A value is decoded if it is the same in all of them.

pub mod database;
pub mod filter;
pub mod list;
pub mod log;

use crate::master::{PROTOCOLS, Protocol};
use crate::ops::get::shown_text;
use crate::ops::report::Shown;
use crate::sheet::{Address, Entry, Sheet};
use database::Database;
use plumbline::can::Frame;
use plumbline::model::catalog::{PRODUCTS, Product};
use plumbline::param::{DataType, ValueId, number};
use serde_json::{Map, Value, json};
use std::fmt::{self, Display, Formatter};
use std::rc::Rc;

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
    pub fn told(name: &str, bytes: &[u8]) -> Self {
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
            return Self::told(&name, bytes);
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

/// The products that a decoder knows.
#[derive(Clone, Debug)]
pub struct Known {
    sheets: Rc<[Sheet]>,
    /// The user has named the product.
    is_given: bool,
}

impl Known {
    /// All products of a protocol.
    fn all(protocol: &Protocol) -> Self {
        let products = PRODUCTS.iter().filter(|product| protocol.is_of(product));
        Self {
            sheets: products.map(Sheet::of).collect(),
            is_given: false,
        }
    }

    /// A device that can be each of them.
    pub fn device(&self) -> Device {
        Device {
            known: self.clone(),
            possible: (0..self.sheets.len()).collect(),
            is_told: self.is_given,
            resolution: None,
        }
    }

    /// The same products, for devices of which nobody has told that they are one of them.
    pub fn untold(self) -> Self {
        Self {
            is_given: false,
            ..self
        }
    }

    /// The products.
    pub fn products(&self) -> impl Iterator<Item = &'static Product> {
        self.sheets.iter().map(|sheet| sheet.product)
    }
}

/// A device on the bus: the products that it can be.
#[derive(Clone, Debug)]
pub struct Device {
    known: Known,
    possible: Vec<usize>,
    /// The device or the user has named the product.
    is_told: bool,
    /// The number of the parameter that selects the unit of others, if it was read or written.
    resolution: Option<u32>,
}

impl Device {
    /// Whether its product was told, by itself or by the user, or some of its products.
    pub fn is_told(&self) -> bool {
        self.is_told
    }

    /// The name of the product, if it was told.
    pub fn product(&self) -> Option<&'static str> {
        match self.possible[..] {
            [only] if self.is_told => Some(self.known.sheets[only].product.name),
            _ => None,
        }
    }

    fn sheets(&self) -> impl Iterator<Item = &Sheet> {
        self.possible.iter().map(|place| &self.known.sheets[*place])
    }

    /// The possible products.
    pub fn products(&self) -> impl Iterator<Item = &'static Product> {
        self.sheets().map(|sheet| sheet.product)
    }

    /// The device has told something that only some products have. A device that is none of them stays as it is.
    pub fn keep(&mut self, is: impl Fn(&Product) -> bool) {
        let is = |place: &usize| is(self.known.sheets[*place].product);
        let possible: Vec<usize> = self.possible.iter().copied().filter(is).collect();
        if !possible.is_empty() {
            self.is_told = true;
            self.possible = possible;
        }
    }

    /// What all possible products have that have it, if it is the same.
    pub fn agreed<T: PartialEq>(&self, get: impl Fn(&'static Product) -> Option<T>) -> Option<T> {
        let mut all = self.products().filter_map(get);
        let first = all.next()?;
        all.all(|other| other == first).then_some(first)
    }

    /// The entries at addresses, if they are the same in all possible products that have some.
    pub fn entries(&self, is: impl Fn(Address) -> bool) -> Vec<Entry> {
        let own = |sheet: &Sheet| -> Vec<Entry> {
            let entries = sheet.entries.iter().filter(|entry| is(entry.address));
            entries.map(|entry| self.scaled(sheet, entry)).collect()
        };
        let mut all = self.sheets().map(own).filter(|own| !own.is_empty());
        let Some(first) = all.next() else {
            return Vec::new();
        };
        match all.all(|other| is_same(&first, &other)) {
            true => first,
            false => Vec::new(),
        }
    }

    /// The entry at an address.
    pub fn entry(&self, address: Address) -> Option<Entry> {
        self.entries(|own| own == address).into_iter().next()
    }

    /// The entry of a published value, if it is the same in all possible products.
    pub fn published(&self, id: ValueId) -> Option<Entry> {
        let mut all = self.sheets();
        let first = all.next()?;
        let entry = first.value(id)?;
        let is_own = |sheet: &Sheet| {
            let other = sheet.value(id);
            other.is_some_and(|other| {
                is_same(std::slice::from_ref(entry), std::slice::from_ref(other))
            })
        };
        all.all(is_own).then(|| self.scaled(first, entry))
    }

    /// An entry with the unit in force.
    fn scaled(&self, sheet: &Sheet, entry: &Entry) -> Entry {
        let mut entry = entry.clone();
        let own = sheet.product.guide.resolution;
        let own = own.and_then(|resolution| sheet.parameter(resolution.parameter));
        if let (Some(own), Some(raw)) = (own, self.resolution)
            && sheet.follows_resolution(&entry)
        {
            entry.scale = own.scale.times(raw);
        }
        entry
    }

    /// The value of an entry that was read, written or sent. A unit that it selects is in force from now on.
    pub fn value(&mut self, entry: &Entry, bytes: &[u8]) -> Named {
        let is_resolution = self.sheets().any(|sheet| sheet.is_resolution(entry));
        if is_resolution && bytes.len() == usize::from(entry.data_type.size()) {
            self.resolution = Some(number(bytes));
        }
        Named::of(entry, bytes)
    }
}

/// Whether entries of two products are shown alike.
fn is_same(one: &[Entry], other: &[Entry]) -> bool {
    let is_same = |(one, other): (&Entry, &Entry)| {
        (&one.name, one.address, one.data_type, &one.scale, one.form)
            == (
                &other.name,
                other.address,
                other.data_type,
                &other.scale,
                other.form,
            )
            && one.meanings == other.meanings
    };
    one.len() == other.len() && one.iter().zip(other).all(is_same)
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
        let known = Known {
            sheets: [sheet.clone()].into(),
            is_given: true,
        };
        let own = own.map(|protocol| (protocol.decoder)(known.clone()));
        Self {
            decoders: own.collect(),
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
