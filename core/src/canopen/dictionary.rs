//! How a product describes its object dictionary, and what the device keeps of it.
//!
//! An [`Object`] maps an index and a sub-index to a parameter, a published value, a constant or a service of the node. Name, type,
//! unit and permitted values of parameters and values come from their own description. Descriptors (EDS) and documents on a PC
//! are written from it. The device keeps [`Row`]s, eight bytes each, which
//! [`project_objects!`](crate::project_objects) derives from it:
//!
//! ```text
//!  byte 0                                                  4                    8
//!       +--------------------------------------------------+--------------------+
//!       | bits 16..31 index, 8..15 sub-index, 5..7 kind,   | constant, ids or   |
//!       |      2..4 type, 0 readable, 1 writable           | place of a text    |
//!       +--------------------------------------------------+--------------------+
//! ```

use super::Abort;
use super::sdo::message::Address;
use crate::param::{DataType, Parameter, ParameterId, ParameterSet, Quantity, ValueId};

/// Who may do what with an object.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
#[repr(u8)]
pub enum Access {
    /// It never changes.
    Const,
    /// Read only.
    Ro,
    /// Written only.
    Wo,
    /// Read and written.
    Rw,
}

impl Access {
    /// Bit 0: readable, bit 1: writable.
    const fn bits(self) -> u32 {
        match self {
            Self::Const | Self::Ro => 1,
            Self::Wo => 2,
            Self::Rw => 3,
        }
    }

    /// Whether an object with it can be written.
    pub const fn is_writable(self) -> bool {
        self.bits() & 2 != 0
    }
}

/// What the node itself does.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
#[repr(u8)]
pub enum Service {
    /// The error register (1001h).
    ErrorRegister,
    /// The number of errors in the history (1003h:00); written 0 clears it.
    ErrorCount,
    /// The errors, newest first (1003h:01 and on).
    ErrorHistory,
    /// "save" stores all parameters (1010h:01).
    Store,
    /// "load" restores the factory values of the communication profile (1011h:01).
    RestoreCommunication,
    /// The serial number (1018h:04).
    SerialNumber,
    /// 1 restarts the device, 0 does nothing.
    Restart,
    /// 1 restores the factory values of all other parameters; reads 1 when that has succeeded, otherwise 0.
    RestoreApplication,
    /// A text that the product composes and understands.
    Text,
}

impl Service {
    const ALL: [Self; 9] = [
        Self::ErrorRegister,
        Self::ErrorCount,
        Self::ErrorHistory,
        Self::Store,
        Self::RestoreCommunication,
        Self::SerialNumber,
        Self::Restart,
        Self::RestoreApplication,
        Self::Text,
    ];
}

/// What an object is.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Target {
    /// Always this number.
    Constant(u32),
    /// This number plus the node-ID (`$NODEID+...`).
    NodeRelative(u32),
    /// Always this text.
    Text(&'static str),
    /// A parameter.
    Parameter(ParameterId),
    /// A parameter to whose stored or factory value the node-ID is added at each start: a COB-ID.
    CobId(ParameterId),
    /// A published value.
    Value(ValueId),
    /// Writing it writes the parameter, reading it reads the value: a command and its state.
    Command(ParameterId, ValueId),
    /// A service of the node.
    Service(Service),
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
    /// What it is; empty for a parameter or a value, which have a name of their own.
    pub name: &'static str,
    /// The type of a constant or a service; parameters and values have a type of their own.
    pub data_type: DataType,
    /// Who may do what with it.
    pub access: Access,
    /// It can be mapped into a PDO.
    pub mappable: bool,
    /// What it is.
    pub target: Target,
}

impl Object {
    /// A byte that is always 0: what a row does not say.
    pub const PLAIN: Self = Self {
        index: 0,
        sub: 0,
        count: 1,
        group: "",
        name: "",
        data_type: DataType::U8,
        access: Access::Ro,
        mappable: false,
        target: Target::Constant(0),
    };

    /// A parameter that can be read and written.
    pub const fn parameter(index: u16, sub: u8, id: ParameterId) -> Self {
        Self {
            index,
            sub,
            access: Access::Rw,
            target: Target::Parameter(id),
            ..Self::PLAIN
        }
    }

    /// A published value that can be mapped into a PDO.
    pub const fn value(index: u16, sub: u8, id: ValueId) -> Self {
        Self {
            index,
            sub,
            mappable: true,
            target: Target::Value(id),
            ..Self::PLAIN
        }
    }

    /// Its type; parameters and values have that of their description.
    #[allow(clippy::indexing_slicing)] // evaluated at compile time, or with tables that were checked then
    pub const fn data_type(&self, parameters: &[Parameter], quantities: &[Quantity]) -> DataType {
        match self.target {
            Target::Parameter(id) | Target::CobId(id) | Target::Command(id, _) => {
                parameters[id.0 as usize].data_type
            }
            Target::Value(id) => quantities[id.0 as usize].data_type,
            Target::Text(_) => DataType::Text,
            Target::Constant(_) | Target::NodeRelative(_) | Target::Service(_) => self.data_type,
        }
    }
}

/// Where a number, text or action of a [`Row`] is.
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

/// What the device keeps of an [`Object`].
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Row {
    columns: u32,
    target: u32,
}

const KIND: u32 = 5;
const DATA_TYPE: u32 = 2;

impl Row {
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
        DataType::of((self.columns >> DATA_TYPE & 7) as u8)
    }

    /// The size of a number in bytes; 0 for a text.
    pub const fn size(&self) -> u8 {
        self.data_type().size()
    }

    /// Whether it can be read.
    pub const fn is_readable(&self) -> bool {
        self.columns & 1 != 0
    }

    /// Whether it can be written.
    pub const fn is_writable(&self) -> bool {
        self.columns & 2 != 0
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

    /// The number of a constant, or the place of a text.
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

    /// The parameter, when there is one in the communication profile that starts anew with the communication.
    pub(super) const fn communication_parameter(&self) -> Option<ParameterId> {
        match self.kind() {
            Kind::Parameter | Kind::CobId if self.is_communication() => Some(self.id()),
            _ => None,
        }
    }
}

/// Looks an object up; `history` is the number of errors in 1003h, the only object with several sub-indices in one row.
pub(super) fn find(
    rows: &'static [Row],
    history: usize,
    address: Address,
) -> Result<&'static Row, Abort> {
    let wanted = key(address.index, address.sub);
    // The first row behind it; the rows are sorted.
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
        matches!(self.kind(), Kind::Service) && self.target == Service::ErrorHistory as u32
    }
}

const fn key(index: u16, sub: u8) -> u32 {
    (index as u32) << 8 | sub as u32
}

/// Derives what the device keeps of an object dictionary; belongs into an `impl` of
/// [`Product`](crate::canopen::Product) for a type without generic parameters.
#[macro_export]
macro_rules! project_objects {
    () => {
        const ROWS: &'static [$crate::canopen::dictionary::Row] =
            &$crate::canopen::dictionary::rows::<
                { <Self as $crate::canopen::Product>::OBJECTS.len() },
            >(
                <Self as $crate::canopen::Product>::OBJECTS,
                <<<Self as $crate::canopen::Product>::Application as $crate::application::Application>::Table as $crate::param::Table>::PARAMETERS,
                <<Self as $crate::canopen::Product>::Application as $crate::application::Application>::QUANTITIES,
            );
        const TEXTS: &'static [&'static str] = &$crate::canopen::dictionary::texts::<
            {
                $crate::canopen::dictionary::text_count(
                    <Self as $crate::canopen::Product>::OBJECTS,
                )
            },
        >(<Self as $crate::canopen::Product>::OBJECTS);
        const TPDO_SETTINGS: &'static [$crate::canopen::setting::TpdoSettings] =
            &$crate::canopen::setting::tpdo_settings::<
                {
                    <<Self as $crate::canopen::Product>::Tpdos as $crate::canopen::Tpdos>::COUNT
                },
            >(<Self as $crate::canopen::Product>::OBJECTS);
    };
}

/// Projects an object dictionary. A row in the wrong place (duplicate, unsorted), a parameter in two rows, or a row that cannot be
/// is a compile error.
#[allow(clippy::indexing_slicing, clippy::panic)] // evaluated at compile time only
pub const fn rows<const N: usize>(
    objects: &[Object],
    parameters: &[Parameter],
    quantities: &[Quantity],
) -> [Row; N] {
    assert!(objects.len() == N, "one row for each object");
    let mut rows = [Row {
        columns: 0,
        target: 0,
    }; N];
    let mut mapped = ParameterSet::EMPTY;
    let mut texts = 0;
    let mut row = 0;
    while row < N {
        let object = &objects[row];
        check(object);
        assert!(
            row == 0 || end(&objects[row - 1]) <= key(object.index, object.sub),
            "rows must be sorted"
        );
        let (kind, target) = match object.target {
            Target::Constant(number) => (Kind::Constant, number),
            Target::NodeRelative(number) => (Kind::NodeRelative, number),
            Target::Text(_) => (Kind::Text, texts),
            Target::Parameter(id) => (Kind::Parameter, id.0 as u32),
            Target::CobId(id) => (Kind::CobId, id.0 as u32),
            Target::Value(id) => (Kind::Value, (id.0 as u32) << 8),
            Target::Command(id, value) => (Kind::Command, id.0 as u32 | (value.0 as u32) << 8),
            Target::Service(service) => (Kind::Service, service as u32),
        };
        if let Target::Text(_) = object.target {
            texts += 1;
        }
        if let Target::Parameter(id) | Target::CobId(id) | Target::Command(id, _) = object.target {
            assert!(!mapped.contains(id), "a parameter in two rows");
            mapped = mapped.with(id);
        }
        let mut columns = key(object.index, object.sub) << 8 | object.access.bits();
        columns |= (kind as u32) << KIND;
        columns |= (object.data_type(parameters, quantities) as u32) << DATA_TYPE;
        rows[row] = Row { columns, target };
        row += 1;
    }
    rows
}

/// A row must make sense.
const fn check(object: &Object) {
    assert!(object.count >= 1 && object.sub as u32 + object.count as u32 <= 256);
    let several = matches!(object.target, Target::Service(Service::ErrorHistory));
    assert!(
        object.count == 1 || several,
        "only the error history has several sub-indices in one row"
    );
    let text = matches!(
        object.target,
        Target::Text(_) | Target::Service(Service::Text)
    );
    assert!(!(text && object.mappable), "a text cannot be mapped");
    if let Target::Constant(_) | Target::NodeRelative(_) | Target::Text(_) | Target::Value(_) =
        object.target
    {
        assert!(!object.access.is_writable(), "it cannot be written");
    }
    if let Target::Constant(number) = object.target {
        let size = object.data_type.size();
        assert!(
            size == 4 || number >> (8 * size) == 0,
            "the constant must fit its type"
        );
    }
}

/// The key behind the last sub-index of a row.
const fn end(object: &Object) -> u32 {
    key(object.index, object.sub) + object.count as u32
}

/// The number of constant texts.
#[allow(clippy::indexing_slicing)] // evaluated at compile time only
pub const fn text_count(objects: &[Object]) -> usize {
    let (mut count, mut row) = (0, 0);
    while row < objects.len() {
        if let Target::Text(_) = objects[row].target {
            count += 1;
        }
        row += 1;
    }
    count
}

/// The constant texts.
#[allow(clippy::indexing_slicing)] // evaluated at compile time only
pub const fn texts<const N: usize>(objects: &[Object]) -> [&'static str; N] {
    let mut texts = [""; N];
    let (mut place, mut row) = (0, 0);
    while row < objects.len() {
        if let Target::Text(text) = objects[row].target {
            texts[place] = text;
            place += 1;
        }
        row += 1;
    }
    texts
}

/// The object at an address.
#[allow(clippy::indexing_slicing)] // evaluated at compile time only
pub(super) const fn object_at(objects: &[Object], index: u16, sub: u8) -> Option<&Object> {
    let mut row = 0;
    while row < objects.len() {
        if objects[row].index == index && objects[row].sub == sub {
            return Some(&objects[row]);
        }
        row += 1;
    }
    None
}

/// The parameters of the communication profile.
#[allow(clippy::indexing_slicing)] // evaluated at compile time only
pub(super) const fn communication(objects: &[Object]) -> ParameterSet {
    let mut set = ParameterSet::EMPTY;
    let mut row = 0;
    while row < objects.len() {
        if let Target::Parameter(id) | Target::CobId(id) = objects[row].target
            && objects[row].index < 0x2000
        {
            set = set.with(id);
        }
        row += 1;
    }
    set
}
