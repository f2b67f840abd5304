//! The requests that need no bus: ports, products, and the parameters of a product.

use super::{Answer, App};
use crate::adapter::gs_usb::{self, Port};
use crate::connect::RATES;
use crate::identify::{j1939_of, protocol_of};
use crate::scan::kbits;
use crate::sheet::{Entry, Origin, Sheet};
use axum::extract::{Path, State};
use plumbline::model::catalog::PRODUCTS;
use plumbline::param::{DataType, Permitted};
use serde_json::{Value, json};
use std::sync::Arc;

/// The ports of this computer, and what the command line says.
pub(super) async fn ports(State(app): State<Arc<App>>) -> Answer {
    let serial = serial2::SerialPort::available_ports().unwrap_or_default();
    let mut ports: Vec<Value> = serial
        .iter()
        .map(|path| json!({"port": format!("slcan:{}", path.display()), "kind": "serial"}))
        .collect();
    // Without a list of the devices the other ports can be chosen.
    ports.extend(candidates(
        &interfaces(),
        &gs_usb::ports().unwrap_or_default(),
    ));
    for product in PRODUCTS {
        let demo = |name: &str| json!({"port": format!("demo:{name}"), "kind": "demo", "maker": product.maker});
        ports.push(demo(product.name));
        if j1939_of(product).is_some() {
            ports.push(demo(&format!(
                "{}{}",
                product.name,
                crate::adapter::demo::J1939
            )));
        }
    }
    let first = &app.start.connect;
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
            "port": first.port,
            "rate": first.rate,
            "protocol": first.protocol,
            "address": first.address,
            "product": first.product,
            "connects": app.start.connects,
        },
        "store": app.store,
    })))
}

/// The interfaces of SocketCAN and the adapters on USB; an adapter that the kernel uses is listed only as an interface.
fn candidates(interfaces: &[String], usb: &[Port]) -> Vec<Value> {
    let kind = |port: &Port| {
        let serial = port.serial.as_deref().unwrap_or_default();
        format!("candleLight (gs_usb) {serial}")
            .trim_end()
            .to_owned()
    };
    let of = |name: &String| {
        let own = usb.iter().find(|own| own.port == *name);
        let kind = own.map_or("socketcan".to_owned(), |own| {
            format!("socketcan, {}", kind(own))
        });
        json!({"port": name, "kind": kind})
    };
    let mut ports: Vec<Value> = interfaces.iter().map(of).collect();
    let others = usb.iter().filter(|own| !interfaces.contains(&own.port));
    ports.extend(others.map(|own| json!({"port": own.port, "kind": kind(own)})));
    if usb.is_empty() {
        ports.push(json!({"port": "usb", "kind": "candleLight (gs_usb)"}));
    }
    ports
}

/// The CAN interfaces of Linux.
fn interfaces() -> Vec<String> {
    /// The type of a CAN interface (ARPHRD_CAN).
    const CAN: &str = "280";
    let entries = std::fs::read_dir("/sys/class/net").into_iter().flatten();
    let entries = entries.flatten().filter(|entry| {
        let kind = std::fs::read_to_string(entry.path().join("type"));
        kind.is_ok_and(|kind| kind.trim() == CAN)
    });
    let mut names: Vec<String> = entries
        .map(|entry| entry.file_name().to_string_lossy().into_owned())
        .collect();
    names.sort();
    names
}

/// The products of the catalogue, then the data sheets.
pub(super) async fn products(State(app): State<Arc<App>>) -> Answer {
    let products = PRODUCTS.iter().map(|product| {
        json!({
            "sheet": product.name,
            "name": product.name,
            "maker": product.maker,
            "protocol": protocol_of(product),
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
    Ok(axum::Json(json!({
        "sheet": key,
        "product": sheet.product.name,
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
    json!({
        "name": entry.name,
        "title": entry.title,
        "kind": kind,
        "unit": entry.scale.unit,
        "range": if entry.writable { entry.range() } else { String::new() },
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn adapters_on_usb_are_offered_with_their_serial_numbers() {
        let port = |port: &str, serial: &str| Port {
            port: port.to_owned(),
            serial: Some(serial.to_owned()),
        };
        let interfaces = ["can0", "vcan0"].map(str::to_owned);
        let usb = [port("can0", "0031001A"), port("usb:0042003B", "0042003B")];
        assert_eq!(
            candidates(&interfaces, &usb),
            [
                json!({"port": "can0", "kind": "socketcan, candleLight (gs_usb) 0031001A"}),
                json!({"port": "vcan0", "kind": "socketcan"}),
                json!({"port": "usb:0042003B", "kind": "candleLight (gs_usb) 0042003B"}),
            ]
        );
        assert_eq!(candidates(&[], &[])[0]["port"], "usb");
    }
}
