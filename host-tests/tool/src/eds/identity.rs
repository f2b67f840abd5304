//! The identity of a device in its data sheet (EDS), or in a configuration file (DCF), which also has the serial number.

use super::{devicenet, ini, text_of};
use crate::error::Fault;
use descriptors::unit::{Sheet, Value};
use plumbline::model::catalog::{Product, Protocol};

/// Whether a text is a data sheet: it has sections, which a sheet of values has not.
pub fn is_data_sheet(text: &str) -> bool {
    text.lines().any(|line| line.trim_start().starts_with('['))
}

/// The text of a file in UTF-8, UTF-16 or Latin-1.
pub fn text(bytes: &[u8]) -> String {
    text_of(bytes)
}

/// The identity in a data sheet, for a unit of this product.
///
/// # Errors
/// One sentence: it cannot be read, is of another protocol, or has no identity.
pub fn sheet(text: &str, product: &Product) -> Result<Sheet, Fault> {
    let is_devicenet = devicenet::is_devicenet(text);
    let name = product.name;
    let values = match (&product.protocol, is_devicenet) {
        (Protocol::Canopen(_), false) => canopen(text)?,
        (Protocol::Devicenet(_), true) => devicenet_values(text)?,
        (Protocol::Fsc(_) | Protocol::J1939(_), _) => {
            return Err(Fault::NoDataSheet(name));
        }
        (_, true) => {
            return Err(Fault::OfDevicenet(name));
        }
        (_, false) => {
            return Err(Fault::OfCanopen(name));
        }
    };
    if values.is_empty() {
        return Err(Fault::NoIdentity);
    }
    Ok(Sheet {
        product: None,
        values,
    })
}

fn canopen(text: &str) -> Result<Vec<(&'static str, Value)>, Fault> {
    let (sections, _) = ini::sections(text)?;
    let entry = |section: &str, key: &str| sections.get(section)?.get(key);
    let number = |section: &'static str, key: &'static str| {
        entry(section, key).map(|text| {
            let number = ini::number(text).map(Value::Number);
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

fn devicenet_values(text: &str) -> Result<Vec<(&'static str, Value)>, Fault> {
    let (fields, _) = devicenet::fields(text)?;
    let entry = |key: &str| {
        let fields = fields.get(&("device".to_owned(), key.to_owned()))?;
        fields.first().filter(|text| !text.is_empty())
    };
    let mut values = Vec::new();
    for (key, own) in [
        ("vendor", "vendcode"),
        ("device-type", "prodtype"),
        ("product-code", "prodcode"),
    ] {
        if let Some(text) = entry(own) {
            let number = ini::number(text);
            let number = number.ok_or_else(|| Fault::NoNumber(own, text.clone()))?;
            values.push((key, Value::Number(number)));
        }
    }
    if let (Some(major), Some(minor)) = (entry("majrev"), entry("minrev")) {
        values.push(("revision", Value::Text(format!("{major}.{minor}"))));
    }
    let name = entry("prodname").map(|name| ("name", Value::Text(name.clone())));
    values.extend(name);
    Ok(values)
}
