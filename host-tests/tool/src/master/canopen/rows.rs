//! The rows of the tables of a product.

use super::tables;
use crate::sheet::rows::{Builder, fact, group_of};
use crate::sheet::{Address, Entry, Form};
use plumbline::canopen::dictionary::{Access, Service, Target, Use};
use plumbline::param::DataType;

/// Adds the rows of the tables of a product.
pub(super) fn add(to: &mut Builder) {
    let Some(tables) = tables(to.product) else {
        return;
    };
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
            | Target::Command(id, _) => to.of_parameter(id, address),
            Target::Value(id) => to.of_value(id, address),
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
            || to.is_at_once(&entry);
        // A serial number is decimal, as on the label of the sensor.
        let is_serial = object.target == Target::Service(Service::SerialNumber);
        let is_plain = entry.scale.unit.is_empty() && entry.meanings.is_empty() && !is_serial;
        if entry.data_type == DataType::U32 && is_plain && object.index < 0x2000 {
            entry.form = Form::Hexadecimal;
        }
        to.push(group.1.clone(), entry);
    }
}
