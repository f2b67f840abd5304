//! The description of a product with the DeviceNet protocol: identity, objects of the vendor, and assemblies.
//!
//! The description is the source of the electronic data sheet and of documents on a PC. The device uses the rows that
//! [`project!(attributes)`](crate::project) derives from it. The objects of the protocol (classes 1 to 5 and 2Bh) follow
//! from the identity, the roles and the assemblies.

use super::projection::{AssemblyRow, AttributeRow, ObjectRow};
use crate::application::Application;
use crate::can::BitRate;
use crate::mistake::{Mistake, Origin};
use crate::node::Context;
use crate::param::{DataType, Parameter, ParameterId, Parameters, Quantity, Refused, ValueId};
use crate::store::ImageId;

/// The source of the value of an attribute.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Source {
    /// The value in force of this parameter.
    Parameter(ParameterId),
    /// A value that the application has published.
    Value(ValueId),
    /// A constant number of this type.
    Constant(DataType, u32),
    /// A number of this type that a function of the product returns ([`Product::OWN`]).
    Own(DataType),
}

/// The functions of an attribute with [`Source::Own`].
pub struct Own<A: Application> {
    /// The class of the object in [`Product::OBJECTS`].
    pub class: u8,
    /// The number of the attribute.
    pub attribute: u8,
    /// Returns the number. A signed number can have more bits than its type.
    pub read: fn(&Context<A>) -> u32,
    /// Sets the number of a settable attribute. A refused number changes nothing. The node applies and stores changed parameters.
    pub write: fn(&mut Context<A>, u32) -> Result<(), Refused>,
}

impl<A: Application> Own<A> {
    /// An attribute that can only be read.
    pub const fn read_only(class: u8, attribute: u8, read: fn(&Context<A>) -> u32) -> Self {
        Self {
            class,
            attribute,
            read,
            write: |_, _| Err(Refused::NotPermitted),
        }
    }
}

impl Source {
    /// The type of the number.
    pub const fn data_type(self, parameters: &[Parameter], quantities: &[Quantity]) -> DataType {
        match self {
            Self::Parameter(id) => id.data_type(parameters),
            Self::Value(id) => id.data_type(quantities),
            Self::Constant(data_type, _) | Self::Own(data_type) => data_type,
        }
    }
}

/// An attribute of an object of the vendor.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Attribute {
    /// Its number, 1 to 255.
    pub number: u8,
    /// The name in the manual, for the electronic data sheet.
    pub name: &'static str,
    /// A short explanation for the electronic data sheet.
    pub help: &'static str,
    /// The source of its value.
    pub source: Source,
    /// Whether a master can set it. Only a parameter or an own attribute is settable.
    pub settable: bool,
    /// The line of the row, for the message of a mistake.
    pub origin: Origin,
}

impl Attribute {
    /// An attribute that can only be read.
    #[track_caller]
    pub const fn new(number: u8, name: &'static str, source: Source) -> Self {
        Self {
            number,
            name,
            help: "",
            source,
            settable: false,
            origin: Origin::here(),
        }
    }

    /// The same as a settable attribute.
    pub const fn settable(self) -> Self {
        Self {
            settable: true,
            ..self
        }
    }

    /// The same with an explanation.
    pub const fn with_help(self, help: &'static str) -> Self {
        Self { help, ..self }
    }

    /// A mistake in this row of a class.
    pub(super) const fn mistake(&self, class: u8) -> Mistake<'_> {
        Mistake::attribute(class, self.number).at(self.origin)
    }
}

/// An object of the vendor: instance 1 of a class.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Object {
    /// The class, 64h to C7h.
    pub class: u8,
    /// The name in the manual, for the electronic data sheet.
    pub name: &'static str,
    /// The revision of the class (class attribute 1).
    pub revision: u16,
    /// Its attributes, sorted by number.
    pub attributes: &'static [Attribute],
    /// The line of the row, for the message of a mistake.
    pub origin: Origin,
}

impl Object {
    /// An object with these attributes and revision 1.
    #[track_caller]
    pub const fn new(class: u8, name: &'static str, attributes: &'static [Attribute]) -> Self {
        Self {
            class,
            name,
            revision: 1,
            attributes,
            origin: Origin::here(),
        }
    }

    /// A mistake in this row.
    pub(super) const fn mistake(&self) -> Mistake<'_> {
        Mistake::class(self.class).at(self.origin)
    }
}

/// The class of the assembly object.
pub(super) const ASSEMBLY: u8 = 4;
/// The attribute of an assembly with its data.
pub(super) const DATA: u8 = 3;

/// The path of the data of an assembly: class, instance, attribute.
pub(super) const fn path(instance: u8) -> [u8; 6] {
    [0x20, ASSEMBLY, 0x24, instance, 0x30, DATA]
}

/// An input assembly: the data of an I/O message, and attribute 3 of an instance of class 4.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Assembly {
    /// The instance of class 4, from 1 on.
    pub instance: u8,
    /// A name for the electronic data sheet.
    pub name: &'static str,
    /// The published values, at most four. Each is a word of 16 bits, low byte first.
    pub words: &'static [ValueId],
    /// The line of the row, for the message of a mistake.
    pub origin: Origin,
}

impl Assembly {
    /// An assembly of these values.
    #[track_caller]
    pub const fn new(instance: u8, name: &'static str, words: &'static [ValueId]) -> Self {
        Self {
            instance,
            name,
            words,
            origin: Origin::here(),
        }
    }

    /// A mistake in this row.
    pub(super) const fn mistake(&self) -> Mistake<'_> {
        Mistake::row("assembly", self.instance as usize).at(self.origin)
    }

    /// The size of the data in bytes.
    pub const fn size(&self) -> u8 {
        2 * self.words.len() as u8
    }

    /// The path of the data (EPATH): class 4, the instance, attribute 3.
    pub const fn path(&self) -> [u8; 6] {
        path(self.instance)
    }
}

/// The identity of the product (class 1).
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Identity {
    /// Attribute 1: the number of the vendor.
    pub vendor: u16,
    /// The name of the vendor, for the electronic data sheet.
    pub vendor_name: &'static str,
    /// Attribute 2: the device type.
    pub device_type: u16,
    /// The name of the device type, for the electronic data sheet.
    pub device_type_name: &'static str,
    /// Attribute 3: the product code, at least 1.
    pub product_code: u16,
    /// Attribute 4: major revision, 1 to 127, and minor revision, 1 to 255.
    pub revision: (u8, u8),
    /// Attribute 7: the product name, 1 to 32 characters.
    pub name: &'static str,
    /// The catalogue number, for the electronic data sheet.
    pub catalog: &'static str,
}

/// The parameters that the protocol itself uses.
#[derive(Clone, Copy, Debug)]
pub struct Roles {
    /// The MAC ID, 0 to 63.
    pub mac_id: ParameterId,
    /// The code of the bit rate.
    pub baud_rate: ParameterId,
    /// The bit rates of its codes, from code 0.
    pub bit_rates: &'static [BitRate],
    /// The bus-off interrupt: 0 holds the node in bus-off.
    pub bus_off_interrupt: ParameterId,
    /// The instance of the assembly in poll responses.
    pub polled_assembly: ParameterId,
    /// The instance of the assembly in COS and cyclic messages.
    pub cyclic_assembly: ParameterId,
    /// The least change of a word that causes a COS message; 0: each change.
    pub cos_delta: ParameterId,
}

/// A product with the DeviceNet protocol.
///
/// [`project!(attributes)`](crate::project) derives the last constants from the description.
pub trait Product: Send + 'static {
    /// Its measurement and actions. Each stored parameter must have
    /// [`Persistence::AtOnce`](crate::param::Persistence::AtOnce).
    type Application: Application;

    /// Vendor, device type, product code, revision and name: attributes of class 1.
    const IDENTITY: Identity;
    /// The parameters that the protocol uses.
    const ROLES: Roles;
    /// The objects of the vendor.
    const OBJECTS: &'static [Object];
    /// The functions of the attributes with [`Source::Own`], in the order of the objects.
    const OWN: &'static [Own<Self::Application>] = &[];
    /// The assemblies that poll responses, COS and cyclic messages can contain.
    const ASSEMBLIES: &'static [Assembly];
    /// The identification of the stored parameters of this product.
    const IMAGE: ImageId;

    /// The distance between two values of a word of an assembly, for [`Roles::cos_delta`].
    fn distance(
        parameters: &Parameters<<Self::Application as Application>::Table>,
        one: u16,
        other: u16,
    ) -> u16;

    /// The objects of the vendor in the form that the device uses.
    const OBJECT_ROWS: &'static [ObjectRow];
    /// The attributes of all objects of the vendor in the form that the device uses.
    const ATTRIBUTE_ROWS: &'static [AttributeRow];
    /// The numbers of the constant attributes.
    const CONSTANTS: &'static [u32];
    /// The assemblies in the form that the device uses.
    const ASSEMBLY_ROWS: &'static [AssemblyRow];
}
