//! The identity of a unit in its data sheet (EDS), or in a configuration file (DCF), which also has the serial number.

use super::sections;
use crate::eds::{Values, number as integer};
use crate::error::Fault;
use descriptors::unit::Value;

/// The identity, by the keys of a sheet of values.
pub(super) fn values(text: &str) -> Result<Values, Fault> {
    let (sections, _) = sections(text)?;
    let entry = |section: &str, key: &str| sections.get(section)?.get(key);
    let number = |section: &'static str, key: &'static str| {
        entry(section, key).map(|text| {
            let number = integer(text).map(Value::Number);
            number.ok_or_else(|| Fault::NoNumberIn(key, text.to_owned(), section))
        })
    };
    let mut values = Vec::new();
    for (key, object, info) in [
        ("vendor", "1018sub1", "vendornumber"),
        ("product-code", "1018sub2", "productnumber"),
        ("revision", "1018sub3", "revisionnumber"),
    ] {
        // A default value of 0 is often only a place for the number.
        let default = number(object, "defaultvalue").filter(|own| *own != Ok(Value::Number(0)));
        let own = number(object, "parametervalue")
            .or_else(|| number("deviceinfo", info))
            .or(default);
        if let Some(own) = own {
            values.push((key, own?));
        }
    }
    let serial = number("1018sub4", "parametervalue")
        .or_else(|| number("devicecomissioning", "lss_serialnumber"))
        .or_else(|| number("devicecommissioning", "lss_serialnumber"))
        .filter(|own| *own != Ok(Value::Number(0)));
    if let Some(serial) = serial {
        values.push(("serial", serial?));
    }
    for (key, object) in [
        ("name", "1008"),
        ("hardware-version", "1009"),
        ("software-version", "100a"),
    ] {
        let own = entry(object, "parametervalue").or_else(|| entry(object, "defaultvalue"));
        values.extend(own.map(|text| (key, Value::Text(text.to_owned()))));
    }
    Ok(values)
}
