//! The requests that need no bus: ports, products, and the parameters of a product.

use super::{Answer, App};
use crate::connect::RATES;
use crate::image::ImageFile;
use crate::last::Last;
use crate::master::{PROTOCOLS, Protocol, j1939};
use crate::meaning::{self, Named};
use crate::scan::kbits;
use crate::sheet::{Entry, Origin, Sheet};
use adapter::ports;
use axum::extract::{Path, State};
use plumbline::model::catalog::PRODUCTS;
use plumbline::param::{DataType, Permitted};
use serde_json::{Map, Value, json};
use std::sync::Arc;
use texts::Text;

/// The ports of this computer, and what the command line says.
pub(super) async fn ports(State(app): State<Arc<App>>) -> Answer {
    let mut ports: Vec<Value> = ports::ports().iter().map(|listed| json!(listed)).collect();
    if !ports.iter().any(|listed| {
        listed["port"]
            .as_str()
            .is_some_and(|port| port.starts_with("usb"))
    }) {
        ports.push(json!({"port": "usb", "kind": "candleLight (gs_usb)"}));
    }
    for product in PRODUCTS {
        let demo = |name: &str| json!({"port": format!("demo:{name}"), "kind": "demo", "maker": product.maker});
        ports.push(demo(product.name));
        if j1939::tables(product).is_some() {
            ports.push(demo(&format!("{}{}", product.name, crate::demo::J1939)));
        }
    }
    let first = &app.start.connect;
    let port = match &*first.port {
        "" => Last::open(app.config.as_deref()).port().map(str::to_owned),
        port => Some(port.to_owned()),
    };
    let mut rates: Vec<Value> = RATES.into_iter().map(kbits).collect();
    rates.sort_by(|one, other| {
        one.as_f64()
            .partial_cmp(&other.as_f64())
            .unwrap_or(std::cmp::Ordering::Equal)
    });
    Ok(axum::Json(json!({
        "ports": ports,
        "rates": rates,
        "first": {
            "port": port.unwrap_or_default(),
            "rate": first.rate.map(kbits),
            "protocol": first.protocol,
            "address": first.address,
            "product": first.product,
            "connects": app.start.connects,
        },
        "store": app.store,
        "longestImage": ImageFile::LONGEST,
    })))
}

/// The protocols, each with the numbers of its addresses and the command that changes the address.
pub(super) async fn protocols() -> Answer {
    let protocols = PROTOCOLS.iter().map(|protocol| {
        json!({
            "name": protocol.name,
            "command": protocol.command.as_ref().map(|own| own.name),
            "least": protocol.range.start(),
            "most": protocol.range.end(),
        })
    });
    Ok(axum::Json(protocols.collect()))
}

/// The products of the catalogue, then the data sheets.
pub(super) async fn products(State(app): State<Arc<App>>) -> Answer {
    let products = PRODUCTS.iter().map(|product| {
        json!({
            "sheet": product.name,
            "name": product.name,
            "maker": product.maker,
            "protocol": Protocol::of(product).name,
        })
    });
    let mut rows: Vec<Value> = products.collect();
    rows.extend(app.sheets.rows());
    Ok(axum::Json(rows.into()))
}

/// Everything that can be read and written, in the order of the tables.
pub(super) async fn parameters(State(app): State<Arc<App>>, Path(key): Path<String>) -> Answer {
    let sheet = app.sheets.sheet(&key)?;
    let rows = sheet.entries.iter().map(|entry| row(&sheet, entry));
    let names = sheet.entries.iter().flat_map(|entry| entry.meanings);
    let names = names.map(|(_, name)| *name);
    let german = names.map(|name| (name.to_owned(), meaning::german(name).into()));
    let german = german.filter(|(name, german): &(String, Value)| german != name);
    Ok(axum::Json(json!({
        "sheet": key,
        "product": sheet.product.name,
        "german": german.collect::<Map<_, _>>(),
        "entries": rows.collect::<Vec<_>>(),
    })))
}

fn row(sheet: &Sheet, entry: &Entry) -> Value {
    let is_setting = entry.readable && entry.writable && entry.stored && !entry.command;
    let kind = match entry.origin {
        Origin::Parameter(_) => "parameter",
        Origin::Value(_) => "value",
        Origin::Fact | Origin::DataSheet => "fact",
    };
    let named = entry.meanings.iter().filter(|(_, name)| !name.is_empty());
    let choices: Vec<Value> = named
        .map(|(raw, name)| json!({"name": name, "raw": entry.data_type.value(*raw)}))
        .collect();
    // A number beside its names can be typed.
    let is_closed = match entry.permitted {
        Permitted::Named => true,
        Permitted::OneOf(numbers) => numbers.len() == choices.len(),
        Permitted::Range(low, high) => high - low + 1 == choices.len() as i64,
        _ => false,
    };
    let range = entry.writable.then(|| entry.range());
    json!({
        "name": entry.name,
        "title": entry.title,
        "kind": kind,
        "unit": entry.scale.unit,
        "range": range.as_ref().map(Named::to_string).unwrap_or_default(),
        "ranges": range.as_ref().map(Text::texts),
        "follows": sheet.follows_resolution(entry),
        "factory": entry.factory.map(|factory| entry.json(factory)),
        "plusNode": entry.node_relative,
        "readable": entry.readable,
        "writable": entry.writable,
        "setting": is_setting,
        "text": entry.data_type == DataType::Text,
        "choices": if is_closed { choices } else { Vec::new() },
    })
}
