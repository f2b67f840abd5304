//! The description of an object dictionary.
//!
//! An [`Object`] maps an index and a sub-index to a parameter, a published value, a constant or a service of the node. Name,
//! type, unit and permitted values of parameters and values come from their own description. The objects are the source of the
//! descriptors (EDS) and documents on a PC. The device uses the [rows](super::row) that are derived from them.

use crate::mistake::{Mistake, Origin};
use crate::param::{DataType, Parameter, ParameterId, ParameterSet, Quantity, ValueId};
use crate::walk::{at, each};

/// The access type of an object (CiA 306).
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
#[repr(u8)]
pub enum Access {
    /// A master can read it, and it never changes (`const`).
    Const,
    /// A master can only read it (`ro`).
    Ro,
    /// A master can only write it (`wo`).
    Wo,
    /// A master can read and write it (`rw`).
    Rw,
}

impl Access {
    /// Bit 0: readable, bit 1: writable.
    pub(super) const fn bits(self) -> u32 {
        match self {
            Self::Const | Self::Ro => 1,
            Self::Wo => 2,
            Self::Rw => 3,
        }
    }

    /// Whether the object can be read.
    pub const fn is_readable(self) -> bool {
        self.bits() & 1 != 0
    }

    /// Whether the object can be written.
    pub const fn is_writable(self) -> bool {
        self.bits() & 2 != 0
    }
}

/// An object that the node itself implements.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
#[repr(u8)]
pub enum Service {
    /// The error register (1001h): the bits of the active faults.
    ErrorRegister,
    /// The number of errors in the history (1003h:00). Writing 0 clears the history.
    ErrorCount,
    /// The errors, newest first (1003h:01 and following). An error that did not occur has no value (abort 0800 0024h).
    ErrorHistory,
    /// "save" stores all parameters (1010h:01).
    Store,
    /// "load" restores the factory values of the communication profile (1011h:01).
    RestoreCommunication,
    /// The serial number (1018h:04) of the unit record, or of the chip.
    SerialNumber,
    /// "save" stores the group of parameters of the sub-index (1010h): 1 all, 2 communication profile (1000h to 1FFFh), 3 device profile
    /// (6000h to 9FFFh), 4 and following manufacturer-specific groups ([`GROUPS`](super::Product::GROUPS)). Parameters without an object
    /// belong to sub-index 4. Parameters that are in no group are stored by sub-index 1 only.
    StoreGroup,
    /// "load" stores the factory values of the same group (1011h). They act after a reset: those of the communication profile after reset
    /// communication, the others after reset node, node-ID and bit rate after power-up.
    RestoreGroup,
    /// The errors, newest first (1003h:01 and following). An error that did not occur reads 0.
    ErrorHistoryOrZero,
}

impl Service {
    pub(super) const ALL: [Self; 9] = [
        Self::ErrorRegister,
        Self::ErrorCount,
        Self::ErrorHistory,
        Self::Store,
        Self::RestoreCommunication,
        Self::SerialNumber,
        Self::StoreGroup,
        Self::RestoreGroup,
        Self::ErrorHistoryOrZero,
    ];
}

/// The contents of an object.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Target {
    /// This number, which never changes.
    Constant(u32),
    /// This number plus the node-ID (`$NODEID+...`).
    NodeRelative(u32),
    /// This text. With a unit record, 1008h, 1009h and 100Ah have its text.
    Text(&'static str),
    /// The parameter with this id, in its own type.
    Parameter(ParameterId),
    /// A COB-ID: a parameter. The node-ID is added to its stored or factory value at each start.
    CobId(ParameterId),
    /// A COB-ID that a master can change: a parameter. Its default, the factory value plus the node-ID, follows the node-ID.
    FreeCobId(ParameterId),
    /// The present number of this quantity, in its own type.
    Value(ValueId),
    /// A command and its state: a write sets the parameter, a read returns the value.
    Command(ParameterId, ValueId),
    /// A service of the node.
    Service(Service),
    /// An own object of the product. [`Product::OWN`](super::Product::OWN) has its functions.
    Own(Use),
}

/// The use of an own object, for documents and tools.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Use {
    /// A number or a text.
    Data,
    /// A number whose write starts something.
    Command(Command),
    /// The same as this service, with rules of the product.
    Service(Service),
}

/// A command, for documents and tools.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Command {
    /// What a write starts, as far as tools must know it.
    pub starts: Starts,
    /// The numbers that can be written, as text.
    pub numbers: &'static str,
    /// The lowest and the highest of them.
    pub limits: (i64, i64),
}

/// What the number 1 starts.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Starts {
    /// A reset of the device.
    Reset,
    /// A restore of the factory values of the application.
    Restore,
    /// Something that tools need not know.
    Other,
}

/// An object, or several consecutive objects with the same description.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Object {
    /// The index in the object dictionary.
    pub index: u16,
    /// The sub-index, or the first one.
    pub sub: u8,
    /// The number of consecutive sub-indices that this describes.
    pub count: u8,
    /// The name of the index; empty in the following rows of the same index.
    pub group: &'static str,
    /// The name of the sub-index; empty for a parameter or a value, which has its own name.
    pub name: &'static str,
    /// The type of a constant or a service. A parameter or a value has its own type.
    pub data_type: DataType,
    /// Whether a master can read and write it.
    pub access: Access,
    /// Whether it can be mapped into a PDO.
    pub mappable: bool,
    /// Where a read gets the value from, and what a write changes.
    pub target: Target,
    /// The line of the row, for the message of a mistake.
    pub origin: Origin,
}

impl Object {
    /// The default for a row: a constant byte 0.
    #[track_caller]
    pub const fn plain() -> Self {
        Self {
            index: 0,
            sub: 0,
            count: 1,
            group: "",
            name: "",
            data_type: DataType::U8,
            access: Access::Ro,
            mappable: false,
            target: Target::Constant(0),
            origin: Origin::here(),
        }
    }

    /// A parameter that can be read and written.
    #[track_caller]
    pub const fn parameter(index: u16, sub: u8, id: ParameterId) -> Self {
        Self {
            index,
            sub,
            access: Access::Rw,
            target: Target::Parameter(id),
            ..Self::plain()
        }
    }

    /// A published value that can be mapped into a PDO.
    #[track_caller]
    pub const fn value(index: u16, sub: u8, id: ValueId) -> Self {
        Self {
            index,
            sub,
            mappable: true,
            target: Target::Value(id),
            ..Self::plain()
        }
    }

    /// An own object, which has functions of the product.
    #[track_caller]
    pub const fn own(
        index: u16,
        sub: u8,
        name: &'static str,
        data_type: DataType,
        access: Access,
    ) -> Self {
        Self {
            index,
            sub,
            name,
            data_type,
            access,
            target: Target::Own(Use::Data),
            ..Self::plain()
        }
    }

    /// The same as a command.
    pub const fn starting(self, command: Command) -> Self {
        Self {
            target: Target::Own(Use::Command(command)),
            ..self
        }
    }

    /// The same in place of this service.
    pub const fn in_place_of(self, service: Service) -> Self {
        Self {
            target: Target::Own(Use::Service(service)),
            ..self
        }
    }

    /// A mistake in this row.
    pub(super) const fn mistake(&self) -> Mistake<'_> {
        Mistake::object(self.index, self.sub).at(self.origin)
    }

    /// The service that it is, or in place of which it is; None if it is another object.
    pub const fn service(&self) -> Option<Service> {
        match self.target {
            Target::Service(service) | Target::Own(Use::Service(service)) => Some(service),
            _ => None,
        }
    }

    /// Whether it has the errors (1003h:01 and following).
    pub(super) const fn is_history(&self) -> bool {
        matches!(
            self.target,
            Target::Service(Service::ErrorHistory | Service::ErrorHistoryOrZero)
        )
    }

    /// Its type. A parameter or a value has the type of its description.
    pub const fn data_type(&self, parameters: &[Parameter], quantities: &[Quantity]) -> DataType {
        match self.target {
            Target::Parameter(id)
            | Target::CobId(id)
            | Target::FreeCobId(id)
            | Target::Command(id, _) => at(parameters, id.0 as usize).data_type,
            Target::Value(id) => at(quantities, id.0 as usize).data_type,
            Target::Text(_) => DataType::Text,
            Target::Constant(_) | Target::NodeRelative(_) | Target::Service(_) | Target::Own(_) => {
                self.data_type
            }
        }
    }
}

/// The object at an address.
pub(super) const fn object_at(objects: &[Object], index: u16, sub: u8) -> Option<&Object> {
    each!(object in objects => {
        if object.index == index && object.sub == sub {
            return Some(object);
        }
    });
    None
}

/// A mistake at an address, which has the line of this object, or of another sub-index if there is none.
pub(super) const fn mistake_at(objects: &[Object], index: u16, sub: u8) -> Mistake<'_> {
    let mistake = Mistake::object(index, sub);
    if let Some(object) = object_at(objects, index, sub) {
        return object.mistake();
    }
    each!(object in objects => {
        if object.index == index {
            return mistake.at(object.origin);
        }
    });
    mistake
}

/// The constant text at an address.
#[track_caller]
pub(crate) const fn text_at(objects: &[Object], index: u16, sub: u8) -> &'static str {
    match object_at(objects, index, sub) {
        Some(Object {
            target: Target::Text(text),
            ..
        }) => text,
        _ => mistake_at(objects, index, sub)
            .text("there is no constant text")
            .fail(),
    }
}

/// The parameters of the communication profile.
pub const fn communication(objects: &[Object]) -> ParameterSet {
    let mut set = ParameterSet::EMPTY;
    each!(object in objects => {
        if let Target::Parameter(id) | Target::CobId(id) | Target::FreeCobId(id) = object.target
            && object.index < 0x2000
        {
            set = set.with(id);
        }
    });
    set
}

/// Whether a master can change COB-IDs.
pub(super) const fn has_free_cob_ids(objects: &[Object]) -> bool {
    each!(object in objects => {
        if let Target::FreeCobId(_) = object.target {
            return true;
        }
    });
    false
}
