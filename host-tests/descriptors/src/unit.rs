//! The identity of a unit: its sheet, the values that a product takes, and the product that has them.

mod field;
mod sheet;

pub use field::{Field, Value, fields};
pub use sheet::{Sheet, sheet};

use plumbline::canopen::dictionary::{Object, Target};
use plumbline::model::catalog::{Product, Protocol};
use plumbline::store::{Name, Unit};

/// The product with the identity of a unit. Its tables stay until the end of the program.
pub fn with_unit(product: &Product, unit: &Unit) -> Product {
    let mut own = *product;
    match &mut own.protocol {
        Protocol::Fsc(_) | Protocol::J1939(_) => {}
        Protocol::Canopen(tables) => {
            let objects = tables.objects.iter().map(|object| object_of(*object, unit));
            tables.objects = Vec::leak(objects.collect());
        }
        Protocol::Devicenet(tables) => {
            let identity = &mut tables.identity;
            let word = |number: u32| u16::try_from(number).ok();
            identity.vendor = unit.vendor.and_then(word).unwrap_or(identity.vendor);
            identity.device_type = unit.device_type.unwrap_or(identity.device_type);
            let code = unit.product_code.and_then(word);
            identity.product_code = code.unwrap_or(identity.product_code);
            if let Some([_, _, major, minor]) = unit.revision.map(u32::to_be_bytes) {
                identity.revision = (major, minor);
            }
            identity.name = unit.name.map_or(identity.name, leaked);
        }
    }
    own
}

/// An object with the identity of a unit.
fn object_of(object: Object, unit: &Unit) -> Object {
    let number = |number: Option<u32>| number.map(Target::Constant);
    let text = |name: Option<Name>| name.map(|name| Target::Text(leaked(name)));
    let target = match (object.index, object.sub) {
        (0x1018, 1) => number(unit.vendor),
        (0x1018, 2) => number(unit.product_code),
        (0x1018, 3) => number(unit.revision),
        (0x1018, 4) => number(unit.serial),
        (0x1008, 0) => text(unit.name),
        (0x1009, 0) => text(unit.hardware),
        (0x100A, 0) => text(unit.software),
        _ => None,
    };
    Object {
        target: target.unwrap_or(object.target),
        ..object
    }
}

fn leaked(name: Name) -> &'static str {
    String::leak(name.text().to_owned())
}

#[cfg(test)]
mod tests {
    use super::sheet::tests::{FULL, unit_of};
    use super::*;
    use crate::describe;
    use plumbline::model::catalog::find;

    #[test]
    fn data_sheet_has_the_identity_of_the_unit() {
        let text = |name: &str, sheet: &str| {
            let product = find(name).unwrap();
            describe(&with_unit(product, &unit_of(name, sheet).unwrap()))
                .text
                .replace('\r', "")
        };
        let canopen = text("jn2101", FULL[1].1);
        for part in [
            "VendorNumber=0x00000195\nProductName=Old one\nProductNumber=0x1234\nRevisionNumber=0x10002\n",
            "ParameterName=Vendor ID\nObjectType=0x7\nDataType=0x0007\nAccessType=ro\nDefaultValue=0x195\n",
        ] {
            assert!(canopen.contains(part), "{part}");
        }
        let devicenet = text("tiltix080", FULL[3].1);
        for part in [
            "VendCode = 9;",
            "ProdType = 34;",
            "ProdCode = 12;",
            "MajRev = 3;",
            "MinRev = 4;",
            "ProdName = \"Old TILTIX\";",
        ] {
            let part = part.replace(' ', "");
            assert!(devicenet.replace(' ', "").contains(&part), "{part}");
        }
        // What is not given is that of the product.
        let product = find("jn2101").unwrap();
        assert_eq!(
            text("jn2101", "product = \"jn2101\""),
            describe(product).text.replace('\r', "")
        );
    }
}
