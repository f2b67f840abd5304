//! The identity of a device in its data sheet (EDS).

use super::fields;
use crate::eds::{Values, number};
use crate::error::Fault;
use descriptors::unit::Value;

/// The identity, by the keys of a sheet of values.
pub(super) fn values(text: &str) -> Result<Values, Fault> {
    let (fields, _) = fields(text)?;
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
            let number = number(text);
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
