//! A CAN database (DBC) of an FSC product, generated from its tables.
//!
//! Requests and replies are one message each, multiplexed by the function select code in byte 0. Identifiers are the factory
//! values. A request or reply is shorter than 8 bytes if the function has fewer data: the comments of the file say how to decode it.

use crate::number::Number;
use plumbline::fsc::table::{Access, Field, Operation, Source};
use plumbline::model::catalog::Product;
use plumbline::model::listing::fsc::Tables;
use plumbline::param::{Meaning, ParameterId};
use std::fmt::Write;

/// The first data byte of a request and of a reply.
const REQUEST_DATA: u8 = 1;
const REPLY_DATA: u8 = 2;

/// The database of a product.
pub fn dbc(product: &Product, tables: &Tables) -> String {
    let factory = |id: ParameterId| product.parameters[usize::from(id.0)].factory;
    let set = factory(tables.roles.set_id);
    let reply = factory(tables.roles.reply_id);
    let sync = factory(tables.roles.sync_id);
    let mut text = String::new();
    let mut values = String::new();
    head(&mut text);

    message(&mut text, set, "SetParameter", 8, "Master");
    multiplexor(&mut text, "Sensor");
    let mut request_codes = Vec::new();
    for function in tables.functions {
        request_codes.push((u64::from(function.code), function.name.to_owned()));
        if !function.signature.is_empty() {
            let name = identifier(function.name) + "Signature";
            // A signature is also a number; the last byte of RESET is beyond 32 bits, and a DBC signal has up to 64 bits.
            let bits = function.signature.len() * 8;
            let code = function.code;
            let line = format!(" SG_ {name} m{code} : 8|{bits}@1+ (1,0) [0|0] \"\" Sensor");
            writeln!(text, "{line}").unwrap();
            let letters = function.signature.iter().rev();
            let number = letters.fold(0_u64, |number, &byte| number << 8 | u64::from(byte));
            let meaning = String::from_utf8_lossy(function.signature).into_owned();
            table(&mut values, set, &name, &[(number, meaning)]);
        }
    }
    for access in tables.access {
        request_codes.push((access.read.into(), format!("Read {}", access.name)));
        request_codes.push((access.write.into(), format!("Write {}", access.name)));
        let numbers = numbers(access, product);
        signals(&mut text, access.write, REQUEST_DATA, &numbers, "Sensor");
        meanings(&mut values, set, &numbers);
    }
    table(&mut values, set, "FSC", &request_codes);

    message(&mut text, reply, "ReplyParameter", 8, "Sensor");
    multiplexor(&mut text, "Master");
    for (bit, row) in tables.status.iter().enumerate() {
        if !row.name.is_empty() {
            let (name, bit) = (row.name, 8 + bit);
            writeln!(text, " SG_ {name} : {bit}|1@1+ (1,0) [0|1] \"\" Master").unwrap();
        }
    }
    let mut reply_codes = Vec::new();
    for function in tables.functions {
        reply_codes.push((u64::from(function.code), function.name.to_owned()));
        let fields = function.reply.iter();
        let numbers: Vec<_> = fields.map(|field| number(field, product, tables)).collect();
        signals(&mut text, function.code, REPLY_DATA, &numbers, "Master");
    }
    for access in tables.access {
        reply_codes.push((access.read.into(), access.name.to_owned()));
        reply_codes.push((access.write.into(), format!("{} written", access.name)));
        let numbers = numbers(access, product);
        signals(&mut text, access.read, REPLY_DATA, &numbers, "Master");
        meanings(&mut values, reply, &numbers);
    }
    table(&mut values, reply, "FSC", &reply_codes);

    message(&mut text, sync, "Sync", 0, "Master");
    comments(&mut text, product.name, tables, [set, reply, sync]);
    text + &values
}

/// The parameters of a pair of codes.
fn numbers(access: &Access, product: &Product) -> Vec<Number> {
    let of = |id: &ParameterId| Number::from(&product.parameters[usize::from(id.0)]);
    access.parameters.iter().map(of).collect()
}

/// A field of a reply.
fn number(field: &Field, product: &Product, tables: &Tables) -> Number {
    let number = match field.source {
        Source::Parameter(id) => Number::from(&product.parameters[usize::from(id.0)]),
        Source::Value(id) => Number::from(&product.quantities[usize::from(id.0)]),
        // An identifier, with the description of its parameter.
        Source::ActiveSetId => {
            Number::from(&product.parameters[usize::from(tables.roles.set_id.0)])
        }
        source => {
            let data_type = source.data_type(product.parameters, product.quantities);
            Number::any(field.name, data_type)
        }
    };
    let name = if field.name.is_empty() {
        number.name
    } else {
        field.name
    };
    Number { name, ..number }
}

/// A name as an identifier: `Set-Parameter-ID` becomes `SetParameterID`.
fn identifier(name: &str) -> String {
    checked(name.split([' ', '-']).map(capitalised).collect())
}

/// The longest name of a message or a signal in a database.
const NAME: usize = 32;

/// A name that is not longer than a database permits.
pub fn checked(name: String) -> String {
    assert!(name.len() <= NAME, "{name}: more than {NAME} characters");
    name
}

fn capitalised(word: &str) -> String {
    let mut letters = word.chars();
    letters.next().map_or(String::new(), |first| {
        first.to_ascii_uppercase().to_string() + letters.as_str()
    })
}

fn head(text: &mut String) {
    text.push_str("VERSION \"\"\n\nNS_ :\n\nBS_:\n\nBU_: Master Sensor\n");
}

fn message(text: &mut String, id: u32, name: &str, length: u8, sender: &str) {
    writeln!(text, "\nBO_ {id} {name}: {length} {sender}").unwrap();
}

fn multiplexor(text: &mut String, receiver: &str) {
    writeln!(text, " SG_ FSC M : 0|8@1+ (1,0) [0|255] \"\" {receiver}").unwrap();
}

/// The signals of one code, starting at byte `start`.
fn signals(text: &mut String, code: u8, start: u8, numbers: &[Number], receiver: &str) {
    let mut bit = u32::from(start) * 8;
    for number in numbers {
        let bits = u32::from(number.data_type.size()) * 8;
        let sign = if number.data_type.is_signed() {
            '-'
        } else {
            '+'
        };
        let factor = number.value(1);
        let (min, max) = (number.value(number.limits.0), number.value(number.limits.1));
        let (name, unit) = (identifier(number.name), number.unit);
        writeln!(
            text,
            " SG_ {name} m{code} : {bit}|{bits}@1{sign} ({factor},0) [{min}|{max}] \"{unit}\" {receiver}"
        )
        .unwrap();
        bit += bits;
    }
}

fn meanings(values: &mut String, message: u32, numbers: &[Number]) {
    for number in numbers.iter().filter(|number| !number.meanings.is_empty()) {
        let owned = |&(number, name): &Meaning| (u64::from(number), name.to_owned());
        let names: Vec<_> = number.meanings.iter().map(owned).collect();
        table(values, message, &identifier(number.name), &names);
    }
}

fn table(values: &mut String, message: u32, signal: &str, names: &[(u64, String)]) {
    write!(values, "VAL_ {message} {signal}").unwrap();
    for (number, name) in names {
        write!(values, " {number} \"{name}\"").unwrap();
    }
    values.push_str(" ;\n");
}

/// How to decode a frame with fewer bytes than the message.
const SHORTER: &str = "A frame ends after its last signal: with cantools, decode_message(id, data, allow_truncated=True).";

fn comments(text: &mut String, name: &str, tables: &Tables, [set, reply, sync]: [u32; 3]) {
    let is_alive = |operation| matches!(operation, Operation::Alive);
    let mut functions = tables.functions.iter();
    let alive = functions.find(|function| is_alive(function.operation));
    let alive = alive.map_or(0, |function| function.code);
    for (message, comment) in [
        (
            String::new(),
            format!("{name}: function select codes on raw CAN, factory identifiers"),
        ),
        (
            format!("BO_ {set} "),
            format!("Requests, 1 to 8 bytes. {SHORTER}"),
        ),
        (
            format!("BO_ {reply} "),
            format!(
                "Replies, cyclic values and boot-up (FSC {alive}), 2 to 8 bytes: the inclination has its counter only in \
                 cyclic mode. {SHORTER} A code that is not in the list is a refused request: code and status only"
            ),
        ),
        (
            format!("BO_ {sync} "),
            "Asks every sensor for its inclination".to_owned(),
        ),
    ] {
        let gap = if message.is_empty() { "\n" } else { "" };
        writeln!(text, "{gap}CM_ {message}\"{comment}\";").unwrap();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use plumbline::model::catalog::{Protocol, find};

    fn database(name: &str) -> String {
        let product = find(name).unwrap();
        match &product.protocol {
            Protocol::Fsc(tables) => dbc(product, tables),
            _ => panic!("{name} does not speak FSC"),
        }
    }

    #[test]
    fn angles_have_positions_of_tables_21_and_22() {
        let two = database("is2");
        assert!(two.contains("SG_ AngleX m0 : 16|16@1- (0.01,0) [-90.00|90.00] \"deg\" Master"));
        assert!(two.contains("SG_ AngleY m0 : 32|16@1- (0.01,0) [-90.00|90.00] \"deg\" Master"));
        assert!(two.contains("SG_ CyclicCounter m0 : 48|16@1+"));
        let one = database("is1");
        assert!(one.contains("SG_ Angle m0 : 16|16@1+ (0.01,0) [0.00|359.99] \"deg\" Master"));
        assert!(one.contains("SG_ CyclicCounter m0 : 32|16@1+"));
        assert!(!one.contains("SensorErrorY"));
    }

    #[test]
    fn name_of_32_characters_is_permitted() {
        assert_eq!(identifier(&"x".repeat(32)).len(), 32);
    }

    /// cantools, and the format itself, permit no longer name.
    #[test]
    #[should_panic(expected = "more than 32 characters")]
    fn name_of_33_characters_is_refused() {
        identifier(&"x".repeat(33));
    }

    #[test]
    fn filter_parameter_has_two_signals() {
        let text = database("is2");
        assert!(
            text.contains("SG_ CutOffFrequency m39 : 8|16@1+ (1,0) [100|25000] \"mHz\" Sensor")
        );
        assert!(text.contains("SG_ FilterType m39 : 24|8@1+ (1,0) [0|2] \"\" Sensor"));
        assert!(
            text.contains("SG_ CutOffFrequency m23 : 16|16@1+ (1,0) [100|25000] \"mHz\" Master")
        );
        assert!(
            text.contains(
                "VAL_ 768 FilterType 0 \"off\" 1 \"Butterworth\" 2 \"critically damped\" ;"
            )
        );
    }
}
