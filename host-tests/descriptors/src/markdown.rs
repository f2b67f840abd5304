//! The tables in the documents of the products, written from the products' own tables.

use crate::devicenet::Described as Attribute;
use crate::number::{Number, named, permitted};
use crate::objects::Described;
use embedded_can::Id;
use plumbline::can::CanId;
use plumbline::canopen::dictionary::{Access, Target};
use plumbline::devicenet::Source;
use plumbline::model::catalog::{Product, Protocol};
use plumbline::model::listing::{canopen, devicenet, fsc, j1939};
use plumbline::param::{DataType, Parameter, Persistence};
use std::fmt::Write;

/// The table of a product for its document.
pub struct Table {
    /// What its rows are, for example `parameters`.
    pub title: &'static str,
    /// The table as Markdown, without a heading.
    pub text: String,
}

/// The table of a product for its document: the device parameters, or the object dictionary.
pub fn table(product: &Product) -> Table {
    let (title, text) = match &product.protocol {
        Protocol::Fsc(tables) => ("parameters", parameters(product, tables)),
        Protocol::Canopen(tables) => ("objects", object_table(product, tables)),
        Protocol::Devicenet(tables) => ("attributes", attributes(product, tables)),
        Protocol::J1939(tables) => ("groups", groups(product, tables)),
    };
    Table { title, text }
}

/// The groups of a product that speaks J1939 only as a Markdown table.
fn groups(product: &Product, tables: &j1939::Tables) -> String {
    let mut text = String::from("| group | PGN | rate in ms | priority |\n|---|---|---|---|\n");
    let settings = (0..).map_while(tables.j1939.settings);
    for (group, (rate, priority)) in tables.j1939.groups.iter().zip(settings) {
        let [rate, priority] = [rate, priority].map(|own| own.factory(product.parameters));
        let (name, pgn) = (group.name, group.pgn);
        writeln!(text, "| {name} | {pgn} | {rate} | {priority} |").unwrap();
    }
    text
}

/// The device parameters of a product that speaks FSC as a Markdown table.
fn parameters(product: &Product, tables: &fsc::Tables) -> String {
    let mut text =
        String::from("| read | write | parameter | values | factory |\n|---|---|---|---|---|\n");
    for access in tables.access {
        let parameters: Vec<&Parameter> = access
            .parameters
            .iter()
            .map(|id| &product.parameters[usize::from(id.0)])
            .collect();
        let is_identifier = access.parameters.iter().any(|id| {
            let roles = &tables.roles;
            [roles.set_id, roles.reply_id, roles.sync_id].contains(id)
        });
        let (values, defaults): (Vec<_>, Vec<_>) = parameters
            .into_iter()
            .map(|parameter| {
                if is_identifier {
                    (permitted(parameter), identifier(parameter.factory))
                } else {
                    (range(parameter), factory(parameter))
                }
            })
            .unzip();
        let (values, defaults) = (values.join("; "), defaults.join("; "));
        let (read, write, name) = (access.read, access.write, access.name);
        writeln!(
            text,
            "| {read:02X}h | {write:02X}h | {name} | {values} | {defaults} |"
        )
        .unwrap();
    }
    text
}

/// An identifier in the four bytes of a parameter.
fn identifier(number: u32) -> String {
    match CanId::from_bits(number).into() {
        Id::Standard(id) => format!("{:X}h, 11 bit", id.as_raw()),
        Id::Extended(id) => format!("{:X}h, 29 bit", id.as_raw()),
    }
}

/// The permitted values: their names, or the range with the unit.
fn range(parameter: &Parameter) -> String {
    if !parameter.meanings.is_empty() {
        return named(parameter.meanings);
    }
    let number = Number::from(parameter);
    let (low, high) = number.limits;
    let (low, high) = (number.value(low), number.value(high));
    format!("{low}..{high} {}", parameter.unit)
        .trim_end()
        .to_owned()
}

/// The factory value with its name, or with the unit.
fn factory(parameter: &Parameter) -> String {
    let factory = parameter.data_type.value(parameter.factory);
    let value = Number::from(parameter).value(factory);
    let mut meanings = parameter.meanings.iter();
    match meanings.find(|(number, _)| *number == parameter.factory) {
        Some((_, name)) => format!("{value} ({name})"),
        None => format!("{value} {}", parameter.unit).trim_end().to_owned(),
    }
}

/// The object dictionary of a product that speaks CANopen as a Markdown table.
fn object_table(product: &Product, tables: &canopen::Tables) -> String {
    let mut text = String::from(
        "| index | sub | object | type | access | values | unit | factory | stored |\n\
         |---|---|---|---|---|---|---|---|---|\n",
    );
    for row in Described::all(tables.objects, product, None) {
        let object = row.object;
        let last = object.sub + object.count - 1;
        let subs = match object.count {
            1 => format!("{last}"),
            _ => format!("{}..{last}", object.sub),
        };
        let name = match object.group {
            "" => row.name().to_owned(),
            group => format!("{group}: {}", row.name()),
        };
        writeln!(
            text,
            "| {:04X}h | {subs} | {name} | {} | {} | {} | {} | {} | {} |",
            object.index,
            data_type(row.data_type()),
            access(object.access),
            row.permitted(),
            row.unit(),
            delivered(&row),
            if row.is_stored() { "yes" } else { "" }
        )
        .unwrap();
    }
    text
}

/// The attributes of the objects of the vendor of a product that speaks DeviceNet as a Markdown table.
fn attributes(product: &Product, tables: &devicenet::Tables) -> String {
    let mut text = String::from(
        "| class | attribute | name | type | access | values | factory | stored |\n|---|---|---|---|---|---|---|---|\n",
    );
    for row in Attribute::all(product, tables) {
        let (class, number) = (row.object.class, row.attribute.number);
        let access = if row.attribute.settable {
            "get/set"
        } else {
            "get"
        };
        let stored = |parameter: &Parameter| parameter.persistence != Persistence::Volatile;
        let values = match row.attribute.source {
            Source::Parameter(_) if row.attribute.settable => {
                row.parameter.map_or(String::new(), range)
            }
            _ => row.number.unit.to_owned(),
        };
        let factory = row.factory().map(|factory| factory.to_string());
        writeln!(
            text,
            "| {class:02X}h | {number:02X}h | {} | {} | {access} | {values} | {} | {} |",
            row.number.name,
            data_type(row.number.data_type),
            factory.unwrap_or_default(),
            if row.parameter.is_some_and(stored) {
                "yes"
            } else {
                ""
            }
        )
        .unwrap();
    }
    text
}

fn data_type(data_type: DataType) -> &'static str {
    match data_type {
        DataType::U8 => "u8",
        DataType::U16 => "u16",
        DataType::U32 => "u32",
        DataType::I8 => "i8",
        DataType::I16 => "i16",
        DataType::I32 => "i32",
        DataType::U64 => "u64",
        DataType::I64 => "i64",
        DataType::Real32 => "f32",
        DataType::Real64 => "f64",
        DataType::Text => "text",
    }
}

fn access(access: Access) -> &'static str {
    match access {
        Access::Const => "const",
        Access::Ro => "ro",
        Access::Rw => "rw",
        Access::Wo => "wo",
    }
}

/// The factory value; empty for what is measured, composed or differs between units.
fn delivered(row: &Described) -> String {
    if let Target::Text(text) = row.object.target {
        return text.to_owned();
    }
    let Some(number) = row.factory() else {
        return String::new();
    };
    match row.data_type() {
        DataType::U32 if row.is_node_relative() => format!("{number:X}h + node-ID"),
        DataType::U32 if number > 9 => format!("{number:X}h"),
        data_type => data_type.value(number).to_string(),
    }
}
