//! The rows of the tables of a product as entries with names.

use super::{Address, Entry, Form, Origin, kebab};
use crate::number::Scale;
use plumbline::canopen::dictionary::{Access, Service, Target, Use};
use plumbline::devicenet::Source as AttributeSource;
use plumbline::fsc::table::{Operation, Source as FieldSource};
use plumbline::model::catalog::{Product, Protocol};
use plumbline::model::listing::{canopen, devicenet, fsc};
use plumbline::param::{
    DataType, Parameter, ParameterId, Permitted, Persistence, Quantity, ValueId,
};
use std::collections::HashMap;

/// All entries of a product, in the order of its tables.
pub(super) fn entries(product: &'static Product) -> Vec<Entry> {
    let mut builder = Builder {
        product,
        entries: Vec::new(),
    };
    match &product.protocol {
        Protocol::Fsc(tables) => builder.fsc(tables),
        Protocol::Canopen(tables) => builder.canopen(tables),
        Protocol::Devicenet(tables) => builder.devicenet(tables),
        // Its parameters have no addresses that a tool knows.
        Protocol::J1939(_) => {}
    }
    named(builder.entries, |entry| {
        let Origin::Parameter(id) = entry.origin else {
            return None;
        };
        let mut names = product.guide.short_names.iter();
        names.find(|(own, _)| *own == id).map(|(_, name)| *name)
    })
}

/// An entry before it has its name: its group is the name of the object that it is a part of.
pub(crate) struct Row {
    pub group: String,
    pub entry: Entry,
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
                Target::Service(Service::ErrorRegister | Service::SerialNumber) => {
                    fact(object.name, address, object.data_type)
                }
                Target::Own(Use::Data) => Entry {
                    writable: true,
                    ..fact(object.name, address, object.data_type)
                },
                Target::Constant(_)
                | Target::NodeRelative(_)
                | Target::Service(_)
                | Target::Own(Use::Command(_) | Use::Service(_)) => continue,
            };
            entry.readable = object.access != Access::Wo;
            entry.writable &= object.access.is_writable();
            entry.node_relative = matches!(object.target, Target::CobId(_) | Target::FreeCobId(_));
            // A write refers to the present position, or starts something.
            entry.command = !entry.readable
                || matches!(
                    object.target,
                    Target::Command(..) | Target::Service(_) | Target::Own(_)
                )
                || self.is_at_once(&entry);
            // A serial number is decimal, as on the label of the sensor.
            let is_serial = object.target == Target::Service(Service::SerialNumber);
            let is_plain = entry.scale.unit.is_empty() && entry.meanings.is_empty() && !is_serial;
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
                    AttributeSource::Own(data_type) => Entry {
                        writable: true,
                        ..fact(attribute.name, address, data_type)
                    },
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
pub(crate) fn fact(title: &str, address: Address, data_type: DataType) -> Entry {
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

/// The name of a group of sub-indices. PDOs have many rows with the same names, so their group is short.
pub(crate) fn group_of(index: u16, name: &str) -> String {
    match index {
        0x1400..=0x15FF => format!("rpdo{}", index - 0x13FF),
        0x1600..=0x17FF => format!("rpdo{}", index - 0x15FF),
        0x1800..=0x19FF => format!("tpdo{}", index - 0x17FF),
        0x1A00..=0x1BFF => format!("tpdo{}", index - 0x19FF),
        _ => name.to_owned(),
    }
}

/// Gives every row its name: the short name, or the name from its title. If several rows have the same name, the group or the address is
/// added.
pub(crate) fn named(rows: Vec<Row>, short: impl Fn(&Entry) -> Option<&'static str>) -> Vec<Entry> {
    let own = |entry: &Entry| match short(entry) {
        Some(name) => name.to_owned(),
        None => kebab(&entry.title),
    };
    let plain: Vec<(String, String)> = rows
        .iter()
        .map(|row| (own(&row.entry), row.group.clone()))
        .collect();
    let (mut names, mut in_group) = (HashMap::new(), HashMap::new());
    for both in &plain {
        *names.entry(&both.0).or_insert(0) += 1;
        *in_group.entry(both).or_insert(0) += 1;
    }
    let name = |both: &(String, String), address: Address| {
        let (own, group) = both;
        if names.get(own) == Some(&1) {
            return own.clone();
        }
        match address {
            _ if in_group.get(both) == Some(&1) && !group.is_empty() => {
                format!("{}-{own}", kebab(group))
            }
            Address::Object { index, sub } => format!("{own}-{index:04x}-{sub}"),
            _ => own.clone(),
        }
    };
    let named: Vec<String> = plain
        .iter()
        .zip(&rows)
        .map(|(both, row)| name(both, row.entry.address))
        .collect();
    let entries = rows.into_iter().zip(named);
    entries
        .map(|(row, name)| Entry { name, ..row.entry })
        .collect()
}
