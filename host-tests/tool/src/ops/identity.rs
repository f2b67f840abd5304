//! The identity of a sensor: what it tells about itself.

use crate::client::devicenet::{Path as ObjectPath, Response};
use crate::client::sdo::Answer;
use crate::client::{fsc, j1939};
use crate::error::Error;
use crate::master::{Ca, Target};
use crate::output::Terminal;
use crate::session::Session;
use descriptors::unit::{self, Sheet, Value};
use plumbline::devicenet::service;
use plumbline::j1939::identifier::{COMPONENT_IDENTIFICATION, SOFTWARE_IDENTIFICATION};
use plumbline::model::catalog::Product;
use plumbline::param::number;
use plumbline::store::Unit;
use serde::{Serialize, Serializer};
use serde_json::{Map, json};

/// The number of times a sensor is asked the same.
const TRIES: u8 = 3;

/// The identity of a unit. As JSON: its values, and the sheet with them.
#[derive(Clone, Debug)]
pub struct Told {
    /// What it is.
    pub product: &'static Product,
    /// The identity.
    pub unit: Unit,
}

impl Serialize for Told {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        let Self { product, unit } = self;
        let values = unit::fields(product).into_iter().map(|field| {
            let value = match field.value(unit) {
                Some(Value::Number(number)) => json!(number),
                Some(Value::Text(text)) => json!(text),
                None => json!(null),
            };
            (field.key.to_owned(), value)
        });
        let values: Map<_, _> = values.collect();
        json!({"product": product.name, "identity": values, "sheet": unit::sheet(product, unit)})
            .serialize(to)
    }
}

impl Told {
    pub(super) fn lines(&self) -> Vec<String> {
        let fields = unit::fields(self.product).into_iter();
        let lines = fields.map(|field| {
            let value = field.shown(&self.unit);
            let value = value.as_deref().unwrap_or("as the product has it");
            format!("{:<17} {value:<34} {}", field.key, field.place)
        });
        lines.collect()
    }
}

/// Asks the sensor for its identity.
///
/// # Errors
/// The product is not known, nobody answers, or the adapter fails.
pub fn told(session: &mut Session, terminal: &mut Terminal) -> Result<Told, Error> {
    let product = session.sheet.product;
    if session.sheet.data_sheet.is_some() {
        let message = "an identity belongs to a product of the catalogue: give it with --product NAME, without --eds";
        return Err(Error::usage("unknown-product", message));
    }
    let mut sheet = Sheet::default();
    for value in values(session, product)? {
        let one = Sheet {
            product: None,
            values: vec![value.clone()],
        };
        match one.unit(product) {
            Ok(_) => sheet.values.push(value),
            Err(why) => terminal.note(format!("left out: {why}")),
        }
    }
    let unit = sheet.unit(product);
    let unit = unit.map_err(|why| Error::refused("unexpected-answer", why))?;
    Ok(Told { product, unit })
}

type Values = Vec<(&'static str, Value)>;

/// What the sensor tells; what it does not have is left out.
fn values(session: &mut Session, product: &Product) -> Result<Values, Error> {
    let mut values = match session.target {
        Target::Fsc(sensor) => {
            let article = fsc::must(&mut session.link, sensor, 0x03, fsc::ANSWER)?.data;
            let serial = fsc::must(&mut session.link, sensor, 0x04, fsc::ANSWER)?.data;
            let part = |data: &[u8], from: usize, to: usize| data.get(from..to).map(<[u8]>::to_vec);
            numbers([
                ("article", part(&article, 0, 4)),
                ("revision", part(&article, 4, 6)),
                ("serial", part(&serial, 0, 4)),
            ])
        }
        Target::Canopen(_) => canopen(session)?,
        Target::J1939(Ca(address)) => j1939_values(session, address)?,
        Target::Devicenet(_) => devicenet(session)?,
    };
    let fields = unit::fields(product);
    values.retain(|(key, _)| fields.iter().any(|field| field.key == *key));
    Ok(values)
}

fn numbers<const N: usize>(values: [(&'static str, Option<Vec<u8>>); N]) -> Values {
    let values = values.into_iter();
    let values = values.filter_map(|(key, bytes)| {
        let bytes = bytes.filter(|bytes| (1..=4).contains(&bytes.len()))?;
        Some((key, Value::Number(number(&bytes).into())))
    });
    values.collect()
}

fn texts<const N: usize>(values: [(&'static str, Option<Vec<u8>>); N]) -> Values {
    let values = values.into_iter();
    let values = values.filter_map(|(key, bytes)| {
        let text = String::from_utf8_lossy(&bytes?).into_owned();
        let text = text.trim_end_matches('\0').to_owned();
        (!text.is_empty()).then_some((key, Value::Text(text)))
    });
    values.collect()
}

fn canopen(session: &mut Session) -> Result<Values, Error> {
    let Some(server) = session.target.server() else {
        return Ok(Values::new());
    };
    let mut read = |index, sub| {
        let mut answer = Answer::Silent;
        for _ in 0..TRIES {
            answer = server.read(&mut session.link, index, sub)?;
            if answer != Answer::Silent {
                break;
            }
        }
        match answer {
            Answer::Aborted(_) => Ok(None),
            answer => answer
                .must(server, &format!("to read {index:04X}h"))
                .map(Some),
        }
    };
    let mut values = numbers([
        ("vendor", read(0x1018, 1)?),
        ("product-code", read(0x1018, 2)?),
        ("revision", read(0x1018, 3)?),
        ("serial", read(0x1018, 4)?),
    ]);
    values.extend(texts([
        ("name", read(0x1008, 0)?),
        ("hardware-version", read(0x1009, 0)?),
        ("software-version", read(0x100A, 0)?),
    ]));
    Ok(values)
}

/// Only standard requests: the objects of another maker's sensor are not in the proprietary group.
fn j1939_values(session: &mut Session, address: u8) -> Result<Values, Error> {
    let mut group = |pgn| {
        for _ in 0..TRIES {
            match j1939::get(&mut session.link, address, pgn)? {
                j1939::Answer::Data(data) => return Ok(Some(data)),
                j1939::Answer::Refused => break,
                j1939::Answer::Silent => {}
            }
        }
        Ok::<_, Error>(None)
    };
    let field = |data: &[u8], place: usize| {
        let field = data.split(|byte| *byte == b'*').nth(place);
        field.map(<[u8]>::to_vec)
    };
    let component = group(COMPONENT_IDENTIFICATION)?.unwrap_or_default();
    let software = group(SOFTWARE_IDENTIFICATION)?.unwrap_or_default();
    let serial = field(&component, 2).and_then(|text| String::from_utf8(text).ok());
    let serial = serial.and_then(|text| text.trim().parse().ok());
    let mut values: Values = serial
        .map(|serial| ("serial", Value::Number(serial)))
        .into_iter()
        .collect();
    // The first byte of the software identification is a count.
    let version = software.get(1..).and_then(|data| field(data, 0));
    values.extend(texts([
        ("name", field(&component, 1)),
        ("software-version", version),
    ]));
    Ok(values)
}

fn devicenet(session: &mut Session) -> Result<Values, Error> {
    let Target::Devicenet(slave) = session.target else {
        return Ok(Values::new());
    };
    let path = ObjectPath {
        class: 1,
        instance: 1,
    };
    let mut get = |attribute: u8| {
        let mut response = Response::Silent;
        for _ in 0..TRIES {
            response = session.explicit(slave, service::GET, path, &[attribute])?;
            if response != Response::Silent {
                break;
            }
        }
        match response {
            Response::Refused(..) => Ok(None),
            response => response.must(slave.mac, "to read the identity").map(Some),
        }
    };
    let mut values = numbers([
        ("vendor", get(1)?),
        ("device-type", get(2)?),
        ("product-code", get(3)?),
        ("serial", get(6)?),
    ]);
    if let Some(&[major, minor]) = get(4)?.as_deref() {
        values.push(("revision", Value::Text(format!("{major}.{minor}"))));
    }
    // The first byte is the length.
    let name = get(7)?.and_then(|name| name.get(1..).map(<[u8]>::to_vec));
    values.extend(texts([("name", name)]));
    Ok(values)
}
