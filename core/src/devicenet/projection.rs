//! The description of a product in the compact form that the device uses.
//!
//! ```text
//!  object     | class      | revision, u8 | index of the first attribute | number of attributes |
//!  attribute  | number     | source       | form: bits 0..2 type, 3 settable, 4..5 kind of the source |
//!  assembly   | instance   | number of words | the value of each word, 4 bytes |
//! ```
//!
//! All functions are evaluated at compile time. An inconsistent description is a compile error.

use super::table::{Assembly, Object, Source};
use crate::param::{Parameter, ParameterId, Quantity, ValueId};
use crate::walk::{each, put};

/// The most words of an assembly: they fit into a frame.
pub(super) const WORDS: usize = 4;

/// An object of the vendor.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct ObjectRow {
    pub(super) class: u8,
    pub(super) revision: u8,
    first: u8,
    count: u8,
}

/// An attribute of an object of the vendor.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct AttributeRow {
    number: u8,
    source: u8,
    form: u8,
}

/// An input assembly in the form that the device uses.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct AssemblyRow {
    pub(super) instance: u8,
    count: u8,
    words: [u8; WORDS],
}

/// Bit of `form`: the attribute is settable.
const SETTABLE: u8 = 1 << 3;
/// Bits of `form`: the kind of the source.
const KIND: u8 = 3 << 4;
const PARAMETER: u8 = 0 << 4;
const VALUE: u8 = 1 << 4;
const CONSTANT: u8 = 2 << 4;
const OWN: u8 = 3 << 4;

/// The place of the number of an attribute.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Place {
    Parameter(ParameterId),
    Value(ValueId),
    /// An index in the constants.
    Constant(u8),
    /// An index in the own attributes.
    Own(u8),
}

impl AttributeRow {
    const EMPTY: Self = Self {
        number: 0,
        source: 0,
        form: 0,
    };

    /// The place of its number.
    pub(super) const fn place(self) -> Place {
        match self.form & KIND {
            PARAMETER => Place::Parameter(ParameterId(self.source)),
            VALUE => Place::Value(ValueId(self.source)),
            CONSTANT => Place::Constant(self.source),
            _ => Place::Own(self.source),
        }
    }

    /// The size in bytes: 1, 2 or 4.
    pub(super) const fn size(self) -> u8 {
        1 << (self.form & 3)
    }

    /// Whether a master can set it.
    pub(super) const fn is_settable(self) -> bool {
        self.form & SETTABLE != 0
    }
}

impl ObjectRow {
    /// The attribute with this number.
    pub(super) fn attribute(
        self,
        rows: &'static [AttributeRow],
        number: u8,
    ) -> Option<AttributeRow> {
        let (first, count) = (usize::from(self.first), usize::from(self.count));
        let rows = rows.get(first..first + count)?;
        let place = rows.partition_point(|row| row.number < number);
        rows.get(place).filter(|row| row.number == number).copied()
    }
}

impl AssemblyRow {
    pub(super) fn words(&self) -> impl Iterator<Item = ValueId> {
        self.words
            .iter()
            .take(self.count.into())
            .map(|&id| ValueId(id))
    }

    /// The size of the data in bytes.
    pub(super) const fn size(&self) -> u8 {
        2 * self.count
    }
}

/// The objects of the vendor in the form that the device uses.
pub const fn objects<const N: usize>(objects: &[Object]) -> [ObjectRow; N] {
    let mut rows = [ObjectRow {
        class: 0,
        revision: 0,
        first: 0,
        count: 0,
    }; N];
    let mut first = 0;
    each!(place, object in objects => {
        let count = object.attributes.len() as u8;
        let row = ObjectRow {
            class: object.class,
            revision: object.revision as u8,
            first,
            count,
        };
        put(&mut rows, place, row);
        first += count;
    });
    rows
}

/// The number of attributes of all objects.
pub const fn attribute_count(objects: &[Object]) -> usize {
    let mut count = 0;
    each!(object in objects => { count += object.attributes.len() });
    count
}

/// The number of constant attributes.
pub const fn constant_count(objects: &[Object]) -> usize {
    let mut count = 0;
    each!(object in objects => {
        each!(attribute in object.attributes => {
            count += matches!(attribute.source, Source::Constant(..)) as usize;
        });
    });
    count
}

/// Projects the constants, in the order of the attributes.
pub const fn constants<const N: usize>(objects: &[Object]) -> [u32; N] {
    let (mut constants, mut count) = ([0; N], 0);
    each!(object in objects => {
        each!(attribute in object.attributes => {
            if let Source::Constant(_, number) = attribute.source {
                put(&mut constants, count, number);
                count += 1;
            }
        });
    });
    constants
}

/// Projects the attributes of all objects.
pub const fn attributes<const N: usize>(
    objects: &[Object],
    parameters: &[Parameter],
    quantities: &[Quantity],
) -> [AttributeRow; N] {
    let mut rows = [AttributeRow::EMPTY; N];
    let (mut count, mut constant, mut own) = (0, 0, 0);
    each!(object in objects => {
        each!(attribute in object.attributes => {
            let data_type = attribute.source.data_type(parameters, quantities);
            let (kind, source) = match attribute.source {
                Source::Parameter(id) => (PARAMETER, id.0),
                Source::Value(id) => (VALUE, id.0),
                Source::Constant(..) => {
                    constant += 1;
                    (CONSTANT, constant - 1)
                }
                Source::Own(_) => {
                    own += 1;
                    (OWN, own - 1)
                }
            };
            let row = AttributeRow {
                number: attribute.number,
                source,
                form: data_type as u8 & 7 | kind | if attribute.settable { SETTABLE } else { 0 },
            };
            put(&mut rows, count, row);
            count += 1;
        });
    });
    rows
}

/// The assemblies in the form that the device uses.
pub const fn assemblies<const N: usize>(assemblies: &[Assembly]) -> [AssemblyRow; N] {
    let mut rows = [AssemblyRow {
        instance: 0,
        count: 0,
        words: [0; WORDS],
    }; N];
    each!(place, assembly in assemblies => {
        let mut words = [0; WORDS];
        each!(word, id in assembly.words => {
            // The check refuses more words.
            if word < WORDS {
                put(&mut words, word, id.0);
            }
        });
        let row = AssemblyRow {
            instance: assembly.instance,
            count: assembly.words.len() as u8,
            words,
        };
        put(&mut rows, place, row);
    });
    rows
}

#[cfg(test)]
mod tests;
