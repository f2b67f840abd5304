//! How the object dictionary of a model is described: one table is the truth.
//!
//! The rich description ([`Object`]) carries names, units and limits; descriptors (EDS) and documents on a PC come from it. The
//! device itself only keeps the [`Rule`]s, 12 bytes each, which [`rules`] projects from it at compile time. Dispatch, type and
//! range checks, factory values and the image in nonvolatile memory work on those.

use super::emcy::HISTORY;
use super::values::SLOTS;

/// The data types of CiA 301 that the sensors use.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
#[repr(u8)]
pub enum DataType {
    /// UNSIGNED8 (0005h).
    U8,
    /// UNSIGNED16 (0006h).
    U16,
    /// UNSIGNED32 (0007h).
    U32,
    /// INTEGER16 (0003h).
    I16,
    /// INTEGER32 (0004h).
    I32,
    /// VISIBLE_STRING (0009h).
    Text,
}

impl DataType {
    /// The size of a number in bytes; 0 for a text.
    pub const fn size(self) -> u8 {
        match self {
            Self::U8 => 1,
            Self::U16 | Self::I16 => 2,
            Self::U32 | Self::I32 => 4,
            Self::Text => 0,
        }
    }
}

/// Who may do what with an object.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
#[repr(u8)]
pub enum Access {
    /// It never changes.
    Const,
    /// Read only.
    Ro,
    /// Read and written.
    Rw,
    /// Written only.
    Wo,
}

/// What the node itself keeps besides the values.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
#[repr(u8)]
pub enum Live {
    /// The error register (1001h).
    ErrorRegister,
    /// The number of errors in the history (1003h:00); written 0 clears it.
    ErrorCount,
    /// The errors, newest first (1003h:01 and on).
    ErrorHistory,
    /// Stores the parameters (1010h:01).
    Store,
    /// Restores the factory values of the communication profile (1011h:01).
    Restore,
    /// The serial number (1018h:04).
    Serial,
}

/// Where the value of an object lives, and what may be written to it.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Home {
    /// Nowhere: it is always this number.
    Constant(u32),
    /// It is always this text.
    Text(&'static &'static str),
    /// In this slot of the [`Values`](super::Values); any number of its type.
    Any(u8),
    /// In this slot; from the second to the third number, both included.
    Range(u8, u8, u8),
    /// In this slot; one of these numbers.
    OneOf(u8, &'static &'static [u16]),
    /// In this slot; a transmission type of a TPDO.
    Transmission(u8),
    /// In this slot; the COB-ID of a SYNC that is consumed.
    SyncId(u8),
    /// In the node.
    Live(Live),
    /// In the model: a number that it measures.
    Measured(u8),
    /// In the model: a text that it composes and understands.
    Key,
}

impl Home {
    /// The slot of the value.
    pub const fn slot(self) -> Option<u8> {
        match self {
            Self::Any(slot)
            | Self::Range(slot, ..)
            | Self::OneOf(slot, _)
            | Self::Transmission(slot)
            | Self::SyncId(slot) => Some(slot),
            _ => None,
        }
    }
}

/// An object, or several in a row with the same description.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Object {
    /// The index.
    pub index: u16,
    /// The sub-index, or the first one.
    pub sub: u8,
    /// How many sub-indices in a row this describes.
    pub count: u8,
    /// The name of the whole object; empty in rows of the same index that follow.
    pub group: &'static str,
    /// What it is.
    pub name: &'static str,
    /// The type.
    pub data_type: DataType,
    /// Who may do what with it.
    pub access: Access,
    /// It can be mapped into a PDO.
    pub mappable: bool,
    /// The unit of the value, empty when it has none.
    pub unit: &'static str,
    /// Where the value lives, and what may be written.
    pub home: Home,
    /// The factory value of a value that lives in a slot.
    pub factory: u32,
    /// The node id is added to the value (`$NODEID+...`).
    pub node_relative: bool,
    /// It outlasts a power cycle when it is stored.
    pub stored: bool,
    /// Names of particular numbers.
    pub meanings: &'static [(u32, &'static str)],
}

impl Object {
    /// An object without name, that reads 0: what a row does not say.
    pub const PLAIN: Self = Self {
        index: 0,
        sub: 0,
        count: 1,
        group: "",
        name: "",
        data_type: DataType::U8,
        access: Access::Ro,
        mappable: false,
        unit: "",
        home: Home::Constant(0),
        factory: 0,
        node_relative: false,
        stored: false,
        meanings: &[],
    };
}

/// What the device keeps of an [`Object`].
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Rule {
    /// Index (bits 16 to 31), first sub-index (8 to 15), type (0 to 2), access (3 and 4), and the flags: these columns in one word,
    /// by which a search compares.
    columns: u32,
    /// Where the value lives, and what may be written.
    pub home: Home,
}

const NODE_RELATIVE: u32 = 1 << 5;
const STORED: u32 = 1 << 6;

impl Rule {
    const fn new(object: &Object) -> Self {
        let mut columns = key(object.index, object.sub) << 8;
        columns |= object.data_type as u32 | (object.access as u32) << 3;
        if object.node_relative {
            columns |= NODE_RELATIVE;
        }
        if object.stored {
            columns |= STORED;
        }
        Self {
            columns,
            home: object.home,
        }
    }

    /// The index.
    pub const fn index(&self) -> u16 {
        (self.columns >> 16) as u16
    }

    /// The first sub-index.
    pub const fn sub(&self) -> u8 {
        (self.columns >> 8) as u8
    }

    /// The type.
    pub const fn data_type(&self) -> DataType {
        match self.columns & 7 {
            0 => DataType::U8,
            1 => DataType::U16,
            2 => DataType::U32,
            3 => DataType::I16,
            4 => DataType::I32,
            _ => DataType::Text,
        }
    }

    /// Whether it can be read.
    pub const fn is_readable(&self) -> bool {
        self.columns >> 3 & 3 != Access::Wo as u32
    }

    /// Whether it can be written.
    pub const fn is_writable(&self) -> bool {
        self.columns >> 3 & 3 >= Access::Rw as u32
    }

    /// The node id is added to the value.
    pub const fn is_node_relative(&self) -> bool {
        self.columns & NODE_RELATIVE != 0
    }

    /// It is part of the image.
    pub const fn is_stored(&self) -> bool {
        self.columns & STORED != 0
    }

    /// The number of sub-indices: the history of errors is the only one that has several in a row.
    pub const fn count(&self) -> u8 {
        match self.home {
            Home::Live(Live::ErrorHistory) => HISTORY as u8,
            _ => 1,
        }
    }

    /// True for the objects of the communication profile (1000h to 1FFFh).
    pub const fn is_communication(&self) -> bool {
        self.index() < 0x2000
    }

    const fn key(&self) -> u32 {
        self.columns >> 8
    }
}

const fn key(index: u16, sub: u8) -> u32 {
    (index as u32) << 8 | sub as u32
}

/// Projects the description of a dictionary onto what the device keeps.
///
/// A row in the wrong place (duplicate, unsorted), two values in one slot, or a row that cannot be is a compile error, because
/// this runs while a `static` is evaluated.
#[allow(clippy::indexing_slicing, clippy::panic)] // evaluated at compile time only
pub const fn rules<const N: usize>(objects: &[Object]) -> [Rule; N] {
    assert!(objects.len() == N, "one rule for each row");
    let mut taken = [false; SLOTS];
    let mut rules = [Rule::new(&Object::PLAIN); N];
    let mut row = 0;
    while row < N {
        let object = &objects[row];
        assert!(object.count >= 1 && object.sub as u32 + object.count as u32 <= 256);
        assert!(
            row == 0 || end(&objects[row - 1]) <= key(object.index, object.sub),
            "rows must be sorted"
        );
        if let Some(slot) = object.home.slot() {
            assert!(!taken[slot as usize], "two values in one slot");
            taken[slot as usize] = true;
            assert!(object.count == 1 && object.data_type.size() > 0);
            assert!(
                object.data_type.size() == 4
                    || object.factory >> (8 * object.data_type.size()) == 0
            );
        } else {
            assert!(!object.stored, "only what lives in a slot is stored");
        }
        if let Home::Range(_, low, high) = object.home {
            assert!(low <= high && low as u32 <= object.factory && object.factory <= high as u32);
        }
        assert!(
            !(object.stored && object.node_relative),
            "such a value follows the node id"
        );
        rules[row] = Rule::new(object);
        assert!(
            rules[row].count() == object.count,
            "only the history has several"
        );
        row += 1;
    }
    rules
}

/// The key behind the last sub-index of a row.
const fn end(object: &Object) -> u32 {
    key(object.index, object.sub) + object.count as u32
}

/// The factory values of all slots, by slot.
#[allow(clippy::indexing_slicing)] // evaluated at compile time only
pub const fn factory(objects: &[Object]) -> [u32; SLOTS] {
    let mut values = [0; SLOTS];
    let mut row = 0;
    while row < objects.len() {
        if let Some(slot) = objects[row].home.slot() {
            values[slot as usize] = objects[row].factory;
        }
        row += 1;
    }
    values
}

/// The bytes that the stored values take in an image, `hidden` ones of four bytes included.
#[allow(clippy::indexing_slicing)] // evaluated at compile time only
pub const fn stored_size(objects: &[Object], hidden: usize) -> usize {
    let mut size = hidden * 4;
    let mut row = 0;
    while row < objects.len() {
        if objects[row].stored {
            size += objects[row].data_type.size() as usize;
        }
        row += 1;
    }
    size
}

/// What a search in the dictionary has found.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Found {
    /// The row.
    Row(&'static Rule),
    /// The object, but not this sub-index of it.
    NoSubIndex,
    /// Nothing.
    NoObject,
}

/// Looks an object up.
pub fn find(rules: &'static [Rule], index: u16, sub: u8) -> Found {
    let wanted = key(index, sub);
    // The first row behind it; the rows are sorted.
    let last = wanted << 8 | 0xFF;
    let next = rules.partition_point(|rule| rule.columns <= last);
    let row = next.checked_sub(1).and_then(|row| rules.get(row));
    let same = |rule: &&Rule| rule.index() == index;
    match row.filter(same) {
        Some(rule) if wanted - rule.key() < rule.count().into() => Found::Row(rule),
        Some(_) => Found::NoSubIndex,
        None if rules.get(next).is_some_and(|rule| same(&rule)) => Found::NoSubIndex,
        None => Found::NoObject,
    }
}
