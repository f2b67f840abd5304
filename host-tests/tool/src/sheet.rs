//! The sheet of a product: everything that a tool can read and write, with one name each, made from the tables of the core.
//!
//! A name is the short name of the guide, or the manual's name in small letters with hyphens. If several rows have the same name,
//! the name of their group comes first.

pub(crate) mod rows;

use crate::eds::DataSheet;
use crate::error::NumberError;
use crate::number::Scale;
use plumbline::model::catalog::Product;
use plumbline::param::{Constraint, DataType, Meaning, ParameterId, Permitted, Relation, ValueId};

/// Where an entry is on the bus.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Address {
    /// Bytes of the reply to a function select code.
    Fsc {
        /// The code that reads it.
        read: u8,
        /// The code that writes it, together with the other parameters of the same code.
        write: Option<u8>,
        /// The place in the data of the reply.
        offset: u8,
    },
    /// An object of the dictionary.
    Object {
        /// The index in the object dictionary.
        index: u16,
        /// The sub-index; 0 for an object without sub-indices.
        sub: u8,
    },
    /// An attribute of an object of DeviceNet.
    Attribute {
        /// The class of the object.
        class: u8,
        /// The instance of the class.
        instance: u8,
        /// The number of the attribute.
        attribute: u8,
    },
}

impl Address {
    /// Whether one request reads both.
    pub fn is_read_with(self, other: Self) -> bool {
        match (self, other) {
            (Self::Fsc { read, .. }, Self::Fsc { read: own, .. }) => read == own,
            _ => self == other,
        }
    }
}

/// Where an entry comes from.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Origin {
    /// A parameter of the table.
    Parameter(ParameterId),
    /// A value that the sensor publishes.
    Value(ValueId),
    /// A fact about the device, for example its serial number.
    Fact,
    /// An entry of a data sheet (EDS).
    DataSheet,
}

/// How a number is shown.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Form {
    /// Decimal, with unit and name.
    Decimal,
    /// A CAN identifier: bit 31 is the format.
    Identifier,
    /// The number in hexadecimal.
    Hexadecimal,
    /// A software version in binary-coded decimal: 0344h is 3.44.
    Version,
}

/// An entry of a sheet.
#[derive(Clone, Debug)]
pub struct Entry {
    /// The name on command lines, in files and documents.
    pub name: String,
    /// The name in the manual.
    pub title: String,
    /// Where the entry comes from.
    pub origin: Origin,
    /// Where the number is in the sensor.
    pub address: Address,
    /// The type of the number.
    pub data_type: DataType,
    /// The scale of the number; the unit can depend on another parameter.
    pub scale: Scale,
    /// The form of the number.
    pub form: Form,
    /// The numbers that a write accepts.
    pub permitted: Permitted,
    /// The names of particular numbers.
    pub meanings: &'static [Meaning],
    /// The factory value as a raw number.
    pub factory: Option<u32>,
    /// The node-ID is added to the factory value.
    pub node_relative: bool,
    /// Whether a read is possible.
    pub readable: bool,
    /// Whether a write is possible.
    pub writable: bool,
    /// It keeps its value after a power cycle.
    pub stored: bool,
    /// A write does more than to change the value, so that a backup does not contain it.
    pub command: bool,
}

/// The sheet of a product.
#[derive(Clone, Debug)]
pub struct Sheet {
    /// The product that these are the entries of.
    pub product: &'static Product,
    /// The entries in the order of the tables.
    pub entries: Vec<Entry>,
    /// The data sheet (EDS) with these entries; None: they are the entries of the product.
    pub data_sheet: Option<DataSheet>,
}

impl Sheet {
    /// The sheet of a product.
    pub fn of(product: &'static Product) -> Self {
        let mut sheet = Self {
            product,
            entries: rows::entries(product),
            data_sheet: None,
        };
        sheet.scale();
        sheet
    }

    /// Gives the numbers in the unit of the resolution their scale as delivered.
    fn scale(&mut self) {
        let resolution = self.product.guide.resolution;
        let own = resolution.and_then(|resolution| self.parameter(resolution.parameter));
        let Some(scale) = own.and_then(|own| Some(own.scale.times(own.factory?))) else {
            return;
        };
        let follows: Vec<bool> = self
            .entries
            .iter()
            .map(|entry| self.follows_resolution(entry))
            .collect();
        for (entry, follows) in self.entries.iter_mut().zip(follows) {
            if follows {
                entry.scale = scale.clone();
            }
        }
    }

    /// The entry whose [`Origin`] is this parameter.
    pub fn parameter(&self, id: ParameterId) -> Option<&Entry> {
        let wanted = Origin::Parameter(id);
        self.entries.iter().find(|entry| entry.origin == wanted)
    }

    /// The entry of a published value.
    pub fn value(&self, id: ValueId) -> Option<&Entry> {
        let wanted = Origin::Value(id);
        self.entries.iter().find(|entry| entry.origin == wanted)
    }

    /// The entries of a backup: stored parameters that can be read and written.
    pub fn settings(&self) -> impl Iterator<Item = &Entry> {
        let is_setting =
            |entry: &&Entry| entry.readable && entry.writable && entry.stored && !entry.command;
        self.entries.iter().filter(is_setting)
    }

    /// What the sensor has taken from its own position, for example a reference frame. It can be read, but no other sensor can be given it.
    pub fn positions(&self) -> impl Iterator<Item = &Entry> {
        let is_taken = |entry: &&Entry| {
            let is_command = entry.writable && entry.command;
            let is_offset = !entry.writable && self.follows_resolution(entry);
            let is_kept = entry.readable && entry.stored && entry.factory.is_some();
            is_kept && (is_command || is_offset) && entry.origin != Origin::DataSheet
        };
        self.entries.iter().filter(is_taken)
    }

    /// The texts that can be written, for example a programming key. A backup shows them to people.
    pub fn texts(&self) -> impl Iterator<Item = &Entry> {
        let is_text = |entry: &&Entry| entry.data_type == DataType::Text && entry.writable;
        self.entries.iter().filter(is_text)
    }

    /// The entries of a data sheet (EDS) that a backup leaves out, although they can be read and written: a write is a command, or
    /// changes process data.
    pub fn commands(&self) -> impl Iterator<Item = &Entry> {
        let is_command = |entry: &&Entry| {
            entry.origin == Origin::DataSheet && entry.readable && entry.stored && entry.command
        };
        self.entries.iter().filter(is_command)
    }

    /// Why two raw numbers do not fit a constraint; None: they do.
    pub fn broken(&self, constraint: &Constraint, first: u32, second: u32) -> Option<NumberError> {
        let (one, other) = parameters(constraint);
        let (one, other) = (self.parameter(one)?, self.parameter(other)?);
        match constraint.relation {
            Relation::Different(..) if first == second => Some(NumberError::Same(
                one.name.clone(),
                other.name.clone(),
                one.text(first),
            )),
            Relation::AtMost { high, number, .. }
                if second == u32::from(number) && first > u32::from(high) =>
            {
                let (limit, with) = (one.text(high.into()), other.named_text(second));
                let (name, other) = (one.name.clone(), other.name.clone());
                Some(NumberError::AtMost(name, limit, other, with))
            }
            _ => None,
        }
    }

    /// Whether an entry is the resolution, which selects the unit of others.
    pub fn is_resolution(&self, entry: &Entry) -> bool {
        let resolution = self.product.guide.resolution;
        resolution.is_some_and(|resolution| entry.origin == Origin::Parameter(resolution.parameter))
    }

    /// Whether the unit of an entry is selected by the resolution of the product.
    pub fn follows_resolution(&self, entry: &Entry) -> bool {
        self.product
            .guide
            .resolution
            .is_some_and(|resolution| match entry.origin {
                Origin::Parameter(id) => resolution.parameters.contains(&id),
                Origin::Value(id) => resolution.values.contains(&id),
                Origin::Fact | Origin::DataSheet => false,
            })
    }
}

/// The two parameters of a constraint.
pub fn parameters(constraint: &Constraint) -> (ParameterId, ParameterId) {
    match constraint.relation {
        Relation::Different(one, other) => (one, other),
        Relation::AtMost {
            parameter, other, ..
        } => (parameter, other),
    }
}

/// A name in small letters with hyphens.
pub fn kebab(name: &str) -> String {
    let parts = name.split(|letter: char| !letter.is_ascii_alphanumeric());
    let parts: Vec<String> = parts
        .filter(|part| !part.is_empty())
        .map(str::to_ascii_lowercase)
        .collect();
    parts.join("-")
}

#[cfg(test)]
mod tests;
