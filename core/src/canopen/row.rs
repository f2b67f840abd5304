//! The compact form of an object dictionary in the device.
//!
//! The device uses [`Row`]s of eight bytes, which [`project!(objects)`](crate::project) derives from the
//! [objects](super::dictionary):
//!
//! ```text
//!  byte 0                                                  4                    8
//!       +--------------------------------------------------+--------------------+
//!       | bits 16..31 index, 8..15 sub-index, 5..7 kind,   | constant, ids or   |
//!       |      2..4 type, 0 readable, 1 writable           | index of a text    |
//!       +--------------------------------------------------+--------------------+
//!
//!  ids  bits 0..7 parameter, 8..15 value, 16 mappable
//!  service  bits 0..7 service, or 0..7 place in the own objects and 17 own, 16 mappable
//! ```

use super::Abort;
use super::dictionary::{Access, Object, Service, Target};
use super::pdo::{Entry, Source};
use super::sdo::message::Address;
use crate::param::{DataType, Parameter, ParameterId, ParameterSet, Quantity, ValueId};
use crate::walk::{each, put};

/// The kind of contents of a [`Row`].
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
#[repr(u8)]
pub(super) enum Kind {
    Constant,
    NodeRelative,
    Text,
    Parameter,
    CobId,
    Value,
    Command,
    Service,
}

/// An [`Object`] in the form that the device uses.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Row {
    columns: u32,
    target: u32,
}

const KIND: u32 = 5;
const DATA_TYPE: u32 = 2;
/// In the target of a parameter, a value or an own object: it can be mapped.
const MAPPABLE: u32 = 1 << 16;
/// In the target of a service: it is an own object of the product.
const OWN: u32 = 1 << 17;

impl Row {
    /// The index in the object dictionary.
    pub const fn index(&self) -> u16 {
        (self.columns >> 16) as u16
    }

    /// The index and the sub-index, or the first one.
    pub(super) const fn address(&self) -> Address {
        Address {
            index: self.index(),
            sub: (self.columns >> 8) as u8,
        }
    }

    /// The type of a number as the device handles it.
    pub const fn data_type(&self) -> DataType {
        DataType::of((self.columns >> DATA_TYPE & 7) as u8)
    }

    /// The size of a number in bytes; 0 for a text.
    pub const fn size(&self) -> u8 {
        DataType::size_of((self.columns >> DATA_TYPE) as u8)
    }

    /// Whether the object has 64 bits. Its row has the type of a text.
    pub(super) const fn is_wide(&self) -> bool {
        self.size() == 0 && matches!(self.kind(), Kind::Parameter | Kind::Value)
    }

    /// Whether it can be read.
    pub const fn is_readable(&self) -> bool {
        self.columns & 1 != 0
    }

    /// Whether the server accepts writes. Those of a constant, which is part of a mapping, and of a
    /// read-only COB-ID must not change it.
    pub const fn is_writable(&self) -> bool {
        self.columns & 2 != 0
    }

    /// Whether it is the number of mapped objects: sub-index 0 of 1A00h and following.
    pub(super) const fn is_mapped_count(&self) -> bool {
        self.is_writable()
            && self.columns as u8 >> KIND == Kind::Constant as u8
            && self.columns >> 8 & 0xFF == 0
    }

    /// True for the objects of the communication profile (1000h to 1FFFh).
    pub const fn is_communication(&self) -> bool {
        self.index() < 0x2000
    }

    pub(super) const fn kind(&self) -> Kind {
        match self.columns >> KIND & 7 {
            0 => Kind::Constant,
            1 => Kind::NodeRelative,
            2 => Kind::Text,
            3 => Kind::Parameter,
            4 => Kind::CobId,
            5 => Kind::Value,
            6 => Kind::Command,
            _ => Kind::Service,
        }
    }

    /// The number of a constant, or the index of a text.
    pub(super) const fn number(&self) -> u32 {
        self.target
    }

    /// The parameter of a [`Kind::Parameter`], [`Kind::CobId`] or [`Kind::Command`].
    pub(super) const fn id(&self) -> ParameterId {
        ParameterId(self.target as u8)
    }

    /// The value of a [`Kind::Value`] or [`Kind::Command`].
    pub(super) const fn value_id(&self) -> ValueId {
        ValueId((self.target >> 8) as u8)
    }

    /// The service of a [`Kind::Service`].
    pub(super) fn service(&self) -> Option<Service> {
        Service::ALL.get(self.target as usize).copied()
    }

    /// The place of an own object in those of the product; None if it is another object.
    pub(super) const fn own(&self) -> Option<u8> {
        match self.kind() {
            Kind::Service if self.target & OWN != 0 => Some(self.target as u8),
            _ => None,
        }
    }

    /// The published value, mapped into a PDO.
    pub(super) const fn mapped_value(&self) -> Entry {
        Entry {
            source: Source::Value,
            id: self.value_id().0,
            size: self.size(),
        }
    }

    /// The object, mapped into a PDO; None if it cannot be mapped.
    pub(super) const fn mapped(&self) -> Option<Entry> {
        let value = self.mapped_value();
        let source = match self.kind() {
            Kind::Value if self.target & MAPPABLE != 0 => return Some(value),
            Kind::Parameter if self.target & MAPPABLE != 0 => Source::Parameter,
            Kind::Service if self.target & MAPPABLE != 0 => Source::Own,
            _ => return None,
        };
        let id = self.target as u8;
        Some(Entry {
            source,
            id,
            ..value
        })
    }

    /// The parameter, if the object is one of the communication profile. Reset communication restores it.
    pub(super) const fn communication_parameter(&self) -> Option<ParameterId> {
        match self.kind() {
            Kind::Parameter | Kind::CobId if self.is_communication() => Some(self.id()),
            _ => None,
        }
    }
}

/// Finds an object. `history` is the number of errors in 1003h, the only object with several sub-indices in one row.
pub(super) fn find(
    rows: &'static [Row],
    history: usize,
    address: Address,
) -> Result<&'static Row, Abort> {
    let wanted = key(address.index, address.sub);
    // The first row after it. The rows are sorted.
    let next = rows.partition_point(|row| row.columns >> 8 <= wanted);
    let row = next.checked_sub(1).and_then(|row| rows.get(row));
    let same = |row: &&Row| row.index() == address.index;
    match row.filter(same) {
        Some(row) if row.columns >> 8 == wanted => Ok(row),
        Some(row) if row.is_history() && usize::from(address.sub) <= history => Ok(row),
        Some(_) => Err(Abort::NoSubIndex),
        None if rows.get(next).is_some_and(|row| same(&row)) => Err(Abort::NoSubIndex),
        None => Err(Abort::NoObject),
    }
}

impl Row {
    const fn is_history(&self) -> bool {
        matches!(self.kind(), Kind::Service)
            && (self.target == Service::ErrorHistory as u32
                || self.target == Service::ErrorHistoryOrZero as u32)
    }
}

const fn key(index: u16, sub: u8) -> u32 {
    (index as u32) << 8 | sub as u32
}

/// Projects an object dictionary. A duplicate or unsorted row, a parameter in two rows, and an inconsistent row are compile
/// errors.
#[track_caller]
pub const fn rows<const N: usize>(
    objects: &[Object],
    parameters: &[Parameter],
    quantities: &[Quantity],
) -> [Row; N] {
    let mut rows = [Row {
        columns: 0,
        target: 0,
    }; N];
    let mut mapped = ParameterSet::EMPTY;
    let mut after = 0;
    let mut texts = 0;
    let mut own = 0;
    each!(row, object in objects => {
        check(object);
        let mistake = object.mistake();
        mistake.unless(after <= key(object.index, object.sub), "rows must be sorted");
        after = end(object);
        let mappable = if object.mappable { MAPPABLE } else { 0 };
        let (kind, target) = match object.target {
            Target::Constant(number) => (Kind::Constant, number),
            Target::NodeRelative(number) => (Kind::NodeRelative, number),
            Target::Text(_) => (Kind::Text, texts),
            Target::Parameter(id) => (Kind::Parameter, id.0 as u32 | mappable),
            Target::CobId(id) | Target::FreeCobId(id) => (Kind::CobId, id.0 as u32),
            Target::Value(id) => (Kind::Value, (id.0 as u32) << 8 | mappable),
            Target::Command(id, value) => (Kind::Command, id.0 as u32 | (value.0 as u32) << 8),
            Target::Service(service) => (Kind::Service, service as u32),
            Target::Own(_) => (Kind::Service, own | OWN | mappable),
        };
        if let Target::Own(_) = object.target {
            own += 1;
        }
        if let Target::Text(_) = object.target {
            texts += 1;
        }
        let data_type = object.data_type(parameters, quantities);
        if let Target::Parameter(id)
        | Target::CobId(id)
        | Target::FreeCobId(id)
        | Target::Command(id, _) = object.target
        {
            mistake.unless(!mapped.contains(id), "this parameter is in two rows");
            mapped = mapped.with(id);
            if data_type.is_wide() {
                mapped = mapped.with(ParameterId(id.0 + 1));
            }
        }
        let mut columns = key(object.index, object.sub) << 8 | object.access.bits();
        // A configuration tool writes them back, although they are read-only.
        if let (0x1A00..0x1C00, Target::Constant(_)) | (_, Target::CobId(_)) =
            (object.index, object.target)
        {
            columns |= Access::Wo.bits();
        }
        columns |= (kind as u32) << KIND;
        // Bits 0 to 2 are the form in which the device handles it.
        columns |= (data_type as u32 & 7) << DATA_TYPE;
        mistake.unless(
            !data_type.is_wide()
                || matches!(object.target, Target::Parameter(_) | Target::Value(_)),
            "only a parameter or a value has 64 bits",
        );
        put(&mut rows, row, Row { columns, target });
    });
    rows
}

/// Checks that a row is consistent.
#[track_caller]
const fn check(object: &Object) {
    let mistake = object.mistake();
    mistake.unless(
        object.count >= 1 && object.sub as u32 + object.count as u32 <= 256,
        "there is no sub-index, or one above 255",
    );
    let several = object.is_history();
    mistake.unless(
        object.count == 1 || several,
        "only the error history has several sub-indices in one row",
    );
    let text = matches!(object.target, Target::Text(_))
        || matches!(
            (object.target, object.data_type),
            (Target::Own(_), DataType::Text)
        );
    mistake.unless(!(text && object.mappable), "a text cannot be mapped");
    mistake.unless(
        object.access.is_readable() || !object.mappable,
        "an object that cannot be read cannot be mapped",
    );
    if let Target::Constant(_) | Target::NodeRelative(_) | Target::Text(_) | Target::Value(_) =
        object.target
    {
        mistake.unless(
            !object.access.is_writable(),
            "a constant or a value cannot be written",
        );
    }
    if let Target::Constant(number) = object.target {
        let size = object.data_type.size();
        mistake.unless(
            size >= 4 || size > 0 && number >> (8 * size) == 0,
            "the constant must fit its type",
        );
    }
}

/// The key after the last sub-index of a row.
const fn end(object: &Object) -> u32 {
    key(object.index, object.sub) + object.count as u32
}

/// The number of constant texts.
pub const fn text_count(objects: &[Object]) -> usize {
    let mut count = 0;
    each!(object in objects => { count += matches!(object.target, Target::Text(_)) as usize });
    count
}

/// The texts of all rows with a constant text.
pub const fn texts<const N: usize>(objects: &[Object]) -> [&'static str; N] {
    let (mut texts, mut place) = ([""; N], 0);
    each!(object in objects => {
        if let Target::Text(text) = object.target {
            put(&mut texts, place, text);
            place += 1;
        }
    });
    texts
}

#[cfg(test)]
mod tests;
