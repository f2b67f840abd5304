//! The parameter tables of the README, written from the models' tables.

use super::objects::{factory, permitted, signed};
use super::value;
use plumbline::canopen;
use plumbline::canopen::dictionary::{Access, DataType, Home, Object};
use plumbline::fsc::table::{Check, Field, Model};
use plumbline::fsc::wire;
use std::fmt::Write;

/// The device parameters of model `M` as a Markdown table.
pub fn parameters<M: Model>() -> String {
    let mut text =
        String::from("| read | write | parameter | values | factory |\n|---|---|---|---|---|\n");
    for parameter in M::PARAMETERS {
        let mut factory = parameter.factory;
        let (mut permitted, mut defaults) = (Vec::new(), Vec::new());
        for field in parameter.fields {
            let bits = u32::from(field.size) * 8;
            let number = factory & (u32::MAX >> (32 - bits));
            factory = factory.checked_shr(bits).unwrap_or(0);
            if parameter.check == Check::Identifier {
                permitted.push("11 or 29 bit".to_owned());
                let extended = matches!(
                    wire::identifier(number),
                    Some(embedded_can::Id::Extended(_))
                );
                let format = if extended { "29 bit" } else { "11 bit" };
                defaults.push(format!("{:X}h, {format}", number & 0x1FFF_FFFF));
            } else {
                permitted.push(range(field));
                defaults.push(named(field, number));
            }
        }
        let (read, write) = (parameter.read_code(), parameter.write_code());
        let (permitted, defaults) = (permitted.join("; "), defaults.join("; "));
        writeln!(
            text,
            "| {read:02X}h | {write:02X}h | {} | {permitted} | {defaults} |",
            parameter.name
        )
        .unwrap();
    }
    text
}

/// The permitted values of a field: its named values, or its range with the unit.
fn range(field: &Field) -> String {
    if field.meanings.is_empty() {
        let [min, max] = [field.min, field.max].map(|number| value(field, number));
        return format!("{min}..{max} {}", field.unit).trim_end().to_owned();
    }
    let names: Vec<_> = field
        .meanings
        .iter()
        .map(|(number, name)| format!("{number} = {name}"))
        .collect();
    names.join(", ")
}

fn named(field: &Field, number: u32) -> String {
    let value = value(field, number.into());
    match field.meanings.iter().find(|(of, _)| *of == number) {
        Some((_, name)) => format!("{value} ({name})"),
        None => format!("{value} {}", field.unit).trim_end().to_owned(),
    }
}

/// The object dictionary of model `M` as a Markdown table.
pub fn object_table<M: canopen::Model>() -> String {
    let mut text = String::from(
        "| index | sub | object | type | access | values | unit | factory | stored |\n\
         |---|---|---|---|---|---|---|---|---|\n",
    );
    for row in M::OBJECTS {
        let last = row.sub + row.count - 1;
        let subs = match row.count {
            1 => format!("{last}"),
            _ => format!("{}..{last}", row.sub),
        };
        let name = match row.group {
            "" => row.name.to_owned(),
            group => format!("{group}: {}", row.name),
        };
        writeln!(
            text,
            "| {:04X}h | {subs} | {name} | {} | {} | {} | {} | {} | {} |",
            row.index,
            data_type(row.data_type),
            access(row.access),
            permitted(row),
            row.unit,
            delivered(row),
            if row.stored { "yes" } else { "" }
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
        DataType::I16 => "i16",
        DataType::I32 => "i32",
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
fn delivered(object: &Object) -> String {
    if let Home::Text(text) = object.home {
        return (*text).to_owned();
    }
    let Some(number) = factory(object) else {
        return String::new();
    };
    match object.data_type {
        DataType::U32 if object.node_relative => format!("{number:X}h + node id"),
        DataType::U32 if number > 9 => format!("{number:X}h"),
        data_type => signed(data_type, number).to_string(),
    }
}
