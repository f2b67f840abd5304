//! The sheet of a product: everything that a tool can read and write, with one name each, made from the tables of the core.
//!
//! A name is the short name of the guide, or the manual's name in small letters with hyphens. If several rows have the same name,
//! the name of their group comes first.

use crate::number::Scale;
use plumbline::canopen::dictionary::{Access, Service, Target};
use plumbline::devicenet::Source as AttributeSource;
use plumbline::fsc::table::{Operation, Source as FieldSource};
use plumbline::model::catalog::{Product, Protocol};
use plumbline::model::listing::{canopen, devicenet, fsc};
use plumbline::param::{
    DataType, Meaning, Parameter, ParameterId, Permitted, Persistence, Quantity, ValueId,
};

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
        /// The index.
        index: u16,
        /// The sub-index.
        sub: u8,
    },
    /// An attribute of DeviceNet.
    Attribute {
        /// The class.
        class: u8,
        /// The instance.
        instance: u8,
        /// The attribute.
        attribute: u8,
    },
}

/// What an entry is.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Origin {
    /// A parameter of the table.
    Parameter(ParameterId),
    /// A published value.
    Value(ValueId),
    /// A fact about the device, for example its serial number.
    Fact,
}

/// How a number is shown.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Form {
    /// Decimal, with unit and name.
    Decimal,
    /// A CAN identifier: bit 31 is the format.
    Identifier,
    /// Hexadecimal.
    Hexadecimal,
    /// A software version in binary-coded decimal: 0344h is 3.44.
    Version,
}

/// An entry of a sheet.
#[derive(Clone, Debug)]
pub struct Entry {
    /// The name on command lines, in files and documents.
    pub name: String,
    /// The manual's name.
    pub title: String,
    /// What it is.
    pub origin: Origin,
    /// Where it is.
    pub address: Address,
    /// The type of the number.
    pub data_type: DataType,
    /// The scale of the number; the unit can depend on another parameter.
    pub scale: Scale,
    /// The form of the number.
    pub form: Form,
    /// The permitted values.
    pub permitted: Permitted,
    /// Names of numbers.
    pub meanings: &'static [Meaning],
    /// The factory value as a raw number.
    pub factory: Option<u32>,
    /// The node-ID is added to the factory value.
    pub node_relative: bool,
    /// It can be read.
    pub readable: bool,
    /// It can be written.
    pub writable: bool,
    /// It keeps its value after a power cycle.
    pub stored: bool,
    /// A write does more than to change the value, so that a backup does not contain it.
    pub command: bool,
}

/// The sheet of a product.
#[derive(Clone, Debug)]
pub struct Sheet {
    /// The product.
    pub product: &'static Product,
    /// The entries in the order of the tables.
    pub entries: Vec<Entry>,
}

impl Sheet {
    /// The sheet of a product.
    pub fn of(product: &'static Product) -> Self {
        let mut builder = Builder {
            product,
            entries: Vec::new(),
        };
        match &product.protocol {
            Protocol::Fsc(tables) => builder.fsc(tables),
            Protocol::Canopen(tables) => builder.canopen(tables),
            Protocol::Devicenet(tables) => builder.devicenet(tables),
        }
        let mut sheet = Self {
            product,
            entries: named(product, builder.entries),
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

    /// The entry of a parameter.
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

    /// Whether the unit of an entry is selected by the resolution of the product.
    pub fn follows_resolution(&self, entry: &Entry) -> bool {
        self.product
            .guide
            .resolution
            .is_some_and(|resolution| match entry.origin {
                Origin::Parameter(id) => resolution.parameters.contains(&id),
                Origin::Value(id) => resolution.values.contains(&id),
                Origin::Fact => false,
            })
    }
}

/// An entry before it has its name: its group is the name of the object that it is a part of.
struct Row {
    group: String,
    entry: Entry,
}

struct Builder {
    product: &'static Product,
    entries: Vec<Row>,
}

impl Builder {
    fn push(&mut self, group: impl Into<String>, entry: Entry) {
        let group = group.into();
        self.entries.push(Row { group, entry });
    }

    fn of_parameter(&self, id: ParameterId, address: Address) -> Entry {
        let parameter: &Parameter = &self.product.parameters[usize::from(id.0)];
        Entry {
            title: parameter.name.to_owned(),
            origin: Origin::Parameter(id),
            data_type: parameter.data_type,
            scale: Scale::of(parameter.unit, parameter.decimals),
            permitted: parameter.permitted,
            meanings: parameter.meanings,
            factory: Some(parameter.factory),
            writable: true,
            stored: parameter.persistence != Persistence::Volatile,
            ..fact("", address, parameter.data_type)
        }
    }

    fn of_value(&self, id: ValueId, address: Address) -> Entry {
        let quantity: &Quantity = &self.product.quantities[usize::from(id.0)];
        Entry {
            title: quantity.name.to_owned(),
            origin: Origin::Value(id),
            scale: Scale::of(quantity.unit, quantity.decimals),
            ..fact("", address, quantity.data_type)
        }
    }

    fn fsc(&mut self, tables: &fsc::Tables) {
        for function in tables.functions {
            let reads = matches!(function.operation, Operation::Read | Operation::Inclination);
            let mut offset = 0;
            for field in function.reply.iter().filter(|_| reads) {
                let (parameters, quantities) = (self.product.parameters, self.product.quantities);
                let data_type = field.source.data_type(parameters, quantities);
                let address = Address::Fsc {
                    read: function.code,
                    write: None,
                    offset,
                };
                offset += data_type.size();
                let entry = match field.source {
                    FieldSource::Value(id) => self.of_value(id, address),
                    // While cyclic mode is off, the reply ends before it.
                    FieldSource::Counter => continue,
                    FieldSource::SoftwareVersion => Entry {
                        form: Form::Version,
                        ..fact(field.name, address, data_type)
                    },
                    _ => fact(field.name, address, data_type),
                };
                self.push("", entry);
            }
        }
        let roles = &tables.roles;
        for access in tables.access {
            let mut offset = 0;
            for &id in access.parameters {
                let address = Address::Fsc {
                    read: access.read,
                    write: Some(access.write),
                    offset,
                };
                let mut entry = self.of_parameter(id, address);
                offset += entry.data_type.size();
                if [roles.set_id, roles.reply_id, roles.sync_id].contains(&id) {
                    entry.form = Form::Identifier;
                }
                self.push(access.name, entry);
            }
        }
    }

    fn canopen(&mut self, tables: &canopen::Tables) {
        let mut group = (0, String::new());
        for object in tables.objects {
            if group.0 != object.index {
                group = (object.index, group_of(object.index, object.group));
            }
            let address = Address::Object {
                index: object.index,
                sub: object.sub,
            };
            let mut entry = match object.target {
                Target::Parameter(id)
                | Target::CobId(id)
                | Target::FreeCobId(id)
                | Target::Command(id, _) => self.of_parameter(id, address),
                Target::Value(id) => self.of_value(id, address),
                Target::Text(_) => fact(object.name, address, DataType::Text),
                Target::Service(
                    Service::ErrorRegister
                    | Service::SerialNumber
                    | Service::SerialText
                    | Service::Status,
                ) => fact(object.name, address, object.data_type),
                Target::Service(Service::Text) => Entry {
                    writable: true,
                    ..fact(object.name, address, DataType::Text)
                },
                Target::Constant(_) | Target::NodeRelative(_) | Target::Service(_) => continue,
            };
            entry.readable = object.access != Access::Wo;
            entry.writable &= object.access.is_writable();
            entry.node_relative = matches!(object.target, Target::CobId(_) | Target::FreeCobId(_));
            // A write refers to the present position, or starts something.
            entry.command = !entry.readable
                || matches!(object.target, Target::Command(..) | Target::Service(_))
                || self.is_at_once(&entry);
            let is_plain = entry.scale.unit.is_empty() && entry.meanings.is_empty();
            if entry.data_type == DataType::U32 && is_plain && object.index < 0x2000 {
                entry.form = Form::Hexadecimal;
            }
            self.push(group.1.clone(), entry);
        }
    }

    fn devicenet(&mut self, tables: &devicenet::Tables) {
        const DEVICENET: u8 = 3;
        let roles = &tables.roles;
        let network = [
            (1, roles.mac_id),
            (2, roles.baud_rate),
            (3, roles.bus_off_interrupt),
        ];
        for (attribute, id) in network {
            let address = Address::Attribute {
                class: DEVICENET,
                instance: 1,
                attribute,
            };
            let entry = self.of_parameter(id, address);
            self.push("DeviceNet", entry);
        }
        let identity = [
            ("Serial number", 6, DataType::U32),
            ("Product name", 7, DataType::Text),
        ];
        for (name, attribute, data_type) in identity {
            let address = Address::Attribute {
                class: 1,
                instance: 1,
                attribute,
            };
            self.push("Identity", fact(name, address, data_type));
        }
        for object in tables.objects {
            for attribute in object.attributes {
                let address = Address::Attribute {
                    class: object.class,
                    instance: 1,
                    attribute: attribute.number,
                };
                let mut entry = match attribute.source {
                    AttributeSource::Parameter(id) => self.of_parameter(id, address),
                    AttributeSource::Value(id) => self.of_value(id, address),
                    AttributeSource::Constant(..) => continue,
                };
                entry.writable &= attribute.settable;
                self.push(object.name, entry);
            }
        }
    }

    fn is_at_once(&self, entry: &Entry) -> bool {
        let Origin::Parameter(id) = entry.origin else {
            return false;
        };
        self.product.parameters[usize::from(id.0)].persistence == Persistence::AtOnce
    }
}

/// A fact that can only be read.
fn fact(title: &str, address: Address, data_type: DataType) -> Entry {
    Entry {
        name: String::new(),
        title: title.to_owned(),
        origin: Origin::Fact,
        address,
        data_type,
        scale: Scale::PLAIN,
        form: Form::Decimal,
        permitted: Permitted::Any,
        meanings: &[],
        factory: None,
        node_relative: false,
        readable: true,
        writable: false,
        stored: false,
        command: false,
    }
}

/// The name of a group of sub-indices. TPDOs have many rows with the same names, so their group is short.
fn group_of(index: u16, name: &str) -> String {
    match index {
        0x1800..=0x19FF => format!("tpdo{}", index - 0x17FF),
        0x1A00..=0x1BFF => format!("tpdo{}", index - 0x19FF),
        _ => name.to_owned(),
    }
}

/// Gives every row its name.
fn named(product: &Product, rows: Vec<Row>) -> Vec<Entry> {
    let short = |entry: &Entry| {
        let Origin::Parameter(id) = entry.origin else {
            return None;
        };
        let mut names = product.guide.short_names.iter();
        names
            .find(|(own, _)| *own == id)
            .map(|(_, name)| (*name).to_owned())
    };
    let plain: Vec<String> = rows
        .iter()
        .map(|row| short(&row.entry).unwrap_or_else(|| kebab(&row.entry.title)))
        .collect();
    let name = |place: usize, row: &Row| {
        let own = &plain[place];
        let count = plain.iter().filter(|other| *other == own).count();
        if count == 1 {
            return own.clone();
        }
        let group = format!("{}-{own}", kebab(&row.group));
        let same = |(other, name): (&Row, &String)| name == own && other.group == row.group;
        let is_unique = rows.iter().zip(&plain).filter(|both| same(*both)).count() == 1;
        match (is_unique && !row.group.is_empty(), row.entry.address) {
            (true, _) => group,
            (false, Address::Object { index, sub }) => format!("{own}-{index:04x}-{sub}"),
            (false, _) => own.clone(),
        }
    };
    let names: Vec<String> = rows
        .iter()
        .enumerate()
        .map(|(place, row)| name(place, row))
        .collect();
    let entries = rows.into_iter().zip(names);
    entries
        .map(|(row, name)| Entry { name, ..row.entry })
        .collect()
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
