//! The rows of the tables of a product.

use super::tables;
use crate::sheet::rows::{Builder, fact};
use crate::sheet::{Address, Entry};
use plumbline::devicenet::Source as AttributeSource;
use plumbline::param::DataType;

/// Adds the rows of the tables of a product.
pub(super) fn add(to: &mut Builder) {
    let Some(tables) = tables(to.product) else {
        return;
    };
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
        let entry = to.of_parameter(id, address);
        to.push("DeviceNet", entry);
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
        to.push("Identity", fact(name, address, data_type));
    }
    for object in tables.objects {
        for attribute in object.attributes {
            let address = Address::Attribute {
                class: object.class,
                instance: 1,
                attribute: attribute.number,
            };
            let mut entry = match attribute.source {
                AttributeSource::Parameter(id) => to.of_parameter(id, address),
                AttributeSource::Value(id) => to.of_value(id, address),
                AttributeSource::Own(data_type) => Entry {
                    writable: true,
                    ..fact(attribute.name, address, data_type)
                },
                AttributeSource::Constant(..) => continue,
            };
            entry.writable &= attribute.settable;
            to.push(object.name, entry);
        }
    }
}
