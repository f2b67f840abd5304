//! The rows of the tables of a product.

use super::tables;
use crate::sheet::rows::{Builder, fact};
use crate::sheet::{Address, Entry, Form};
use plumbline::fsc::table::{Operation, Source as FieldSource};

/// Adds the rows of the tables of a product.
pub(super) fn add(to: &mut Builder) {
    let Some(tables) = tables(to.product) else {
        return;
    };
    for function in tables.functions {
        let reads = matches!(function.operation, Operation::Read | Operation::Inclination);
        let mut offset = 0;
        for field in function.reply.iter().filter(|_| reads) {
            let (parameters, quantities) = (to.product.parameters, to.product.quantities);
            let data_type = field.source.data_type(parameters, quantities);
            let address = Address::Fsc {
                read: function.code,
                write: None,
                offset,
            };
            offset += data_type.size();
            let entry = match field.source {
                FieldSource::Value(id) => to.of_value(id, address),
                // While cyclic mode is off, the reply ends before it.
                FieldSource::Counter => continue,
                FieldSource::SoftwareVersion => Entry {
                    form: Form::Version,
                    ..fact(field.name, address, data_type)
                },
                _ => fact(field.name, address, data_type),
            };
            to.push("", entry);
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
            let mut entry = to.of_parameter(id, address);
            offset += entry.data_type.size();
            if [roles.set_id, roles.reply_id, roles.sync_id].contains(&id) {
                entry.form = Form::Identifier;
            }
            to.push(access.name, entry);
        }
    }
}
