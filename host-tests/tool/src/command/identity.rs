//! `identity`: the identity of a sensor, and the unit record with which a replacement has it.

use super::replaced;
use crate::backup::{Unread, read_file, write_file};
use crate::client::devicenet::{Path as ObjectPath, Response};
use crate::client::sdo::Answer;
use crate::client::{fsc, j1939};
use crate::eds::identity as data_sheet;
use crate::failure::Failure;
use crate::identify;
use crate::output::Terminal;
use crate::session::{Session, Target};
use descriptors::unit::{self, Field, Sheet, Value};
use host_tests::store_file;
use plumbline::devicenet::service;
use plumbline::j1939::identifier::{COMPONENT_IDENTIFICATION, SOFTWARE_IDENTIFICATION};
use plumbline::model::catalog::Product;
use plumbline::param::number;
use plumbline::store::Unit;
use serde_json::{Map, json};
use std::path::Path;

/// The longest file that is read, in bytes.
const LONGEST: u64 = 8 << 20;

/// The number of times a sensor is asked the same.
const TRIES: u8 = 3;

/// Where the identity is written.
#[derive(Clone, Copy, Debug)]
pub(super) struct Into<'a> {
    /// The sheet that is written.
    pub output: Option<&'a Path>,
    /// The store file of the new unit.
    pub store: Option<&'a Path>,
}

/// Takes the identity in a file.
pub(super) fn from_file(
    path: &Path,
    name: Option<&str>,
    into: Into,
    terminal: &mut Terminal,
) -> Result<(), Failure> {
    let shown = path.display().to_string();
    let bytes = read_file(path, LONGEST).map_err(|unread| match unread {
        Unread::Failed(error) => Failure::bus(
            "no-file",
            format!(
                "cannot read {shown} ({error}): --from takes an EDS, a DCF or a sheet of values"
            ),
        ),
        Unread::Unfit(why) => unfit(&shown, why),
    })?;
    let (product, unit) = given(&data_sheet::text(&bytes), &shown, name)?;
    finish(product, &unit, into, terminal)
}

fn unfit(shown: &str, why: &str) -> Failure {
    Failure::usage("bad-file", format!("{shown}: {why}; nothing was written"))
}

/// The product and the identity in the text of a file. `name` is the wanted product.
///
/// # Errors
/// The product is not known, or cannot have this identity.
pub fn given(
    text: &str,
    shown: &str,
    name: Option<&str>,
) -> Result<(&'static Product, Unit), Failure> {
    let bad = |why: &str| unfit(shown, why);
    let wanted = name.map(identify::product).transpose()?;
    let is_data_sheet = data_sheet::is_data_sheet(text);
    let mut sheet = Sheet::default();
    if !is_data_sheet {
        sheet = Sheet::parse(text).map_err(|why| bad(&why))?;
    }
    let product = wanted.or(sheet.product).ok_or_else(|| {
        let message = "an identity belongs to one product: give the product with --product NAME";
        Failure::usage("unknown-product", message)
    })?;
    if is_data_sheet {
        sheet = data_sheet::sheet(text, product).map_err(|why| bad(&why))?;
    }
    let unit = sheet.unit(product).map_err(|why| bad(&why))?;
    Ok((product, unit))
}

/// The identity as JSON: its values, and the sheet with them.
pub fn document(product: &Product, unit: &Unit) -> serde_json::Value {
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
}

/// Takes the identity of the connected sensor.
pub(super) fn from_sensor(
    session: &mut Session,
    into: Into,
    terminal: &mut Terminal,
) -> Result<(), Failure> {
    let product = session.sheet.product;
    if session.sheet.data_sheet.is_some() {
        let message = "an identity belongs to a product of the catalogue: give it with --product NAME, without --eds";
        return Err(Failure::usage("unknown-product", message));
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
    let unit = unit.map_err(|why| Failure::refused("unexpected-answer", why))?;
    finish(product, &unit, into, terminal)
}

/// Prints the identity, and writes the files.
fn finish(
    product: &Product,
    unit: &Unit,
    into: Into,
    terminal: &mut Terminal,
) -> Result<(), Failure> {
    if let Some(path) = into.output {
        replaced(path, terminal)?;
        write_file(path, &unit::sheet(product, unit))?;
    }
    if let Some(path) = into.store {
        store_file::identify(product, unit, path).map_err(|why| Failure::bus("no-file", why))?;
    }
    for field in unit::fields(product) {
        let Field { key, place, .. } = field;
        let value = field.shown(unit);
        let value = value.as_deref().unwrap_or("as the product has it");
        terminal.line(format!("{key:<17} {value:<34} {place}"))?;
    }
    if let Some(path) = into.output {
        terminal.note(format!("the sheet is {}", path.display()));
    }
    if let Some(path) = into.store {
        terminal.note(format!(
            "the identity of a unit of {} is in {}. The download with probe-rs (README of Plumbline, \"Calibrating a unit\") replaces the settings of the unit: `plumbline backup` before and `plumbline restore` after it keep them",
            product.name,
            path.display()
        ));
    }
    terminal.document(&document(product, unit))
}

type Values = Vec<(&'static str, Value)>;

/// What the sensor tells; what it does not have is left out.
fn values(session: &mut Session, product: &Product) -> Result<Values, Failure> {
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
        Target::J1939(address) => j1939_values(session, address)?,
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

fn canopen(session: &mut Session) -> Result<Values, Failure> {
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
fn j1939_values(session: &mut Session, address: u8) -> Result<Values, Failure> {
    let mut group = |pgn| {
        for _ in 0..TRIES {
            match j1939::get(&mut session.link, address, pgn)? {
                j1939::Answer::Data(data) => return Ok(Some(data)),
                j1939::Answer::Refused => break,
                j1939::Answer::Silent => {}
            }
        }
        Ok::<_, Failure>(None)
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

fn devicenet(session: &mut Session) -> Result<Values, Failure> {
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
