//! The description of a product in the compact form that the device uses.
//!
//! ```text
//!  object     | class      | revision, u8 | index of the first attribute | number of attributes |
//!  attribute  | number     | source       | form: bits 0..2 type, 3 settable, 4..5 kind of the source |
//!  assembly   | instance   | number of words | the value of each word, 4 bytes |
//! ```
//!
//! All functions are evaluated at compile time. An inconsistent description is a compile error.

use super::table::{Assembly, Object, Product, Source};
use crate::param::{Parameter, ParameterId, Quantity, ValueId};

pub use super::consistency::check;

/// The most words of an assembly: they fit into a frame.
const WORDS: usize = 4;

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
#[allow(clippy::indexing_slicing)] // evaluated at compile time only
pub const fn objects<const N: usize>(objects: &[Object]) -> [ObjectRow; N] {
    let mut rows = [ObjectRow {
        class: 0,
        revision: 0,
        first: 0,
        count: 0,
    }; N];
    let (mut place, mut first) = (0, 0);
    while place < N {
        let object = &objects[place];
        assert!(
            object.class >= 0x64 && object.class <= 0xC7,
            "the class of a vendor is 64h to C7h"
        );
        assert!(
            object.revision >= 1 && object.revision <= 255,
            "the revision of a class is 1 to 255"
        );
        let mut other = 0;
        while other < place {
            assert!(
                objects[other].class != object.class,
                "two objects have the same class"
            );
            other += 1;
        }
        rows[place] = ObjectRow {
            class: object.class,
            revision: object.revision as u8,
            first,
            count: object.attributes.len() as u8,
        };
        first += object.attributes.len() as u8;
        place += 1;
    }
    rows
}

/// The number of attributes of all objects.
#[allow(clippy::indexing_slicing)] // evaluated at compile time only
pub const fn attribute_count(objects: &[Object]) -> usize {
    let (mut count, mut place) = (0, 0);
    while place < objects.len() {
        count += objects[place].attributes.len();
        place += 1;
    }
    assert!(count < 256, "too many attributes");
    count
}

/// The number of constant attributes.
#[allow(clippy::indexing_slicing)] // evaluated at compile time only
pub const fn constant_count(objects: &[Object]) -> usize {
    let (mut count, mut place) = (0, 0);
    while place < objects.len() {
        let mut row = 0;
        while row < objects[place].attributes.len() {
            if let Source::Constant(..) = objects[place].attributes[row].source {
                count += 1;
            }
            row += 1;
        }
        place += 1;
    }
    count
}

/// Projects the constants, in the order of the attributes.
#[allow(clippy::indexing_slicing)] // evaluated at compile time only
pub const fn constants<const N: usize>(objects: &[Object]) -> [u32; N] {
    let mut constants = [0; N];
    let (mut count, mut place) = (0, 0);
    while place < objects.len() {
        let mut row = 0;
        while row < objects[place].attributes.len() {
            if let Source::Constant(data_type, number) = objects[place].attributes[row].source {
                let size = data_type.size();
                assert!(size > 0, "a constant attribute is a number");
                assert!(
                    size == 4 || number >> (8 * size) == 0,
                    "a constant does not fit its type"
                );
                constants[count] = number;
                count += 1;
            }
            row += 1;
        }
        place += 1;
    }
    constants
}

/// Projects the attributes of all objects.
#[allow(clippy::indexing_slicing)] // evaluated at compile time only
pub const fn attributes<const N: usize>(
    objects: &[Object],
    parameters: &[Parameter],
    quantities: &[Quantity],
) -> [AttributeRow; N] {
    let mut rows = [AttributeRow::EMPTY; N];
    let (mut count, mut constant, mut own, mut place) = (0, 0, 0, 0);
    while place < objects.len() {
        let (mut row, mut last) = (0, 0);
        while row < objects[place].attributes.len() {
            let attribute = &objects[place].attributes[row];
            assert!(
                attribute.number > last,
                "the attributes of an object must be sorted by number"
            );
            last = attribute.number;
            let data_type = attribute.source.data_type(parameters, quantities);
            assert!(!data_type.is_wide(), "an attribute has at most 32 bits");
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
            assert!(
                kind == PARAMETER || kind == OWN || !attribute.settable,
                "only a parameter or an own attribute is settable"
            );
            rows[count] = AttributeRow {
                number: attribute.number,
                source,
                form: data_type as u8 & 7 | kind | if attribute.settable { SETTABLE } else { 0 },
            };
            count += 1;
            row += 1;
        }
        place += 1;
    }
    rows
}

/// Checks that each attribute with [`Source::Own`] has its functions.
#[allow(clippy::indexing_slicing)] // evaluated at compile time only
pub const fn check_own<P: Product>() {
    let (mut own, mut place) = (0, 0);
    while place < P::OBJECTS.len() {
        let object = &P::OBJECTS[place];
        let mut row = 0;
        while row < object.attributes.len() {
            if let Source::Own(data_type) = object.attributes[row].source {
                assert!(data_type.size() > 0, "an own attribute is a number");
                assert!(
                    own < P::OWN.len()
                        && P::OWN[own].class == object.class
                        && P::OWN[own].attribute == object.attributes[row].number,
                    "an own attribute has no functions in OWN, or not in the order of the objects"
                );
                own += 1;
            }
            row += 1;
        }
        place += 1;
    }
    assert!(
        own == P::OWN.len(),
        "functions in OWN of an attribute that does not exist"
    );
}

/// The assemblies in the form that the device uses. An inconsistent one is a compile error.
#[allow(clippy::indexing_slicing)] // evaluated at compile time only
pub const fn assemblies<const N: usize>(
    assemblies: &[Assembly],
    quantities: &[Quantity],
) -> [AssemblyRow; N] {
    assert!(N > 0, "a product needs an assembly");
    let mut rows = [AssemblyRow {
        instance: 0,
        count: 0,
        words: [0; WORDS],
    }; N];
    let mut place = 0;
    while place < N {
        let Assembly {
            instance, words, ..
        } = assemblies[place];
        assert!(instance >= 1, "the instance of an assembly is 1 to 255");
        assert!(
            !words.is_empty() && words.len() <= WORDS,
            "an assembly has one to four words"
        );
        let mut other = 0;
        while other < place {
            assert!(
                rows[other].instance != instance,
                "two assemblies have the same instance"
            );
            other += 1;
        }
        let mut row = AssemblyRow {
            instance,
            count: words.len() as u8,
            words: [0; WORDS],
        };
        let mut word = 0;
        while word < words.len() {
            let id = words[word];
            assert!(
                quantities[id.0 as usize].data_type.size() == 2,
                "the words of an assembly have 16 bits"
            );
            row.words[word] = id.0;
            word += 1;
        }
        rows[place] = row;
        place += 1;
    }
    rows
}
