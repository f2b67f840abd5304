//! A CAN database (DBC) of an FSC model, written from its tables.
//!
//! Requests and replies are one message each, multiplexed by the function select code in byte 0. Identifiers are the factory
//! ones. Replies are shorter than 8 bytes where the function has less to say.

use super::{identifier, value};
use plumbline::fsc::code;
use plumbline::fsc::table::{Field, Model};
use plumbline::fsc::{Key, Values};
use std::fmt::Write;

/// Where the sensor's data begin in a request and in a reply.
const REQUEST_DATA: u8 = 1;
const REPLY_DATA: u8 = 2;

/// The database of model `M` under this name.
pub fn dbc<M: Model>(name: &str) -> String {
    let factory = Values::factory(M::RULES);
    let [set, reply, sync] = [Key::SetId, Key::ReplyId, Key::SyncId].map(|key| factory.get(key));
    let mut text = String::new();
    let mut values = String::new();
    head(&mut text);

    message(&mut text, set, "SetParameter", 8, "Master");
    multiplexor(&mut text, "Sensor");
    let mut request_codes = Vec::new();
    for function in M::FUNCTIONS {
        request_codes.push((u32::from(function.fsc), function.name.to_owned()));
        if !function.signature.is_empty() {
            let name = identifier(function.name) + "Signature";
            // A signature is a number too; the last byte of RESET does not fit into 32 bits and DBC has up to 64.
            let bits = function.signature.len() * 8;
            let line = format!(
                " SG_ {name} m{} : 8|{bits}@1+ (1,0) [0|0] \"\" Sensor",
                function.fsc
            );
            writeln!(text, "{line}").unwrap();
        }
    }
    for parameter in M::PARAMETERS {
        request_codes.push((
            parameter.read_code().into(),
            format!("Read {}", parameter.name),
        ));
        request_codes.push((
            parameter.write_code().into(),
            format!("Write {}", parameter.name),
        ));
        signals(
            &mut text,
            parameter.write_code(),
            REQUEST_DATA,
            parameter.fields,
            "Sensor",
        );
        meanings(&mut values, set, parameter.fields);
    }
    table(&mut values, set, "FSC", &request_codes);

    message(&mut text, reply, "ReplyParameter", 8, "Sensor");
    multiplexor(&mut text, "Master");
    for (bit, name) in M::STATUS_BITS
        .iter()
        .enumerate()
        .filter(|(_, name)| !name.is_empty())
    {
        writeln!(
            text,
            " SG_ {name} : {}|1@1+ (1,0) [0|1] \"\" Master",
            8 + bit
        )
        .unwrap();
    }
    let mut reply_codes = Vec::new();
    for function in M::FUNCTIONS {
        reply_codes.push((u32::from(function.fsc), function.name.to_owned()));
        signals(
            &mut text,
            function.fsc,
            REPLY_DATA,
            function.reply,
            "Master",
        );
    }
    for parameter in M::PARAMETERS {
        reply_codes.push((parameter.read_code().into(), parameter.name.to_owned()));
        reply_codes.push((
            parameter.write_code().into(),
            format!("{} written", parameter.name),
        ));
        signals(
            &mut text,
            parameter.read_code(),
            REPLY_DATA,
            parameter.fields,
            "Master",
        );
        meanings(&mut values, reply, parameter.fields);
    }
    table(&mut values, reply, "FSC", &reply_codes);

    message(&mut text, sync, "Sync", 0, "Master");
    comments(&mut text, name, set, reply, sync);
    text + &values
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

/// The fields of one code, from byte `start` on.
fn signals(text: &mut String, code: u8, start: u8, fields: &[Field], receiver: &str) {
    let mut bit = u32::from(start) * 8;
    for field in fields {
        let bits = u32::from(field.size) * 8;
        let sign = if field.signed { '-' } else { '+' };
        let factor = value(
            &Field {
                decimals: field.decimals,
                ..*field
            },
            1,
        );
        let [min, max] = [field.min, field.max].map(|number| value(field, number));
        let (name, unit) = (identifier(field.name), field.unit);
        writeln!(text, " SG_ {name} m{code} : {bit}|{bits}@1{sign} ({factor},0) [{min}|{max}] \"{unit}\" {receiver}").unwrap();
        bit += bits;
    }
}

fn meanings(values: &mut String, message: u32, fields: &[Field]) {
    for field in fields.iter().filter(|field| !field.meanings.is_empty()) {
        let names: Vec<_> = field
            .meanings
            .iter()
            .map(|&(number, name)| (number, name.to_owned()))
            .collect();
        table(values, message, &identifier(field.name), &names);
    }
}

fn table(values: &mut String, message: u32, signal: &str, names: &[(u32, String)]) {
    write!(values, "VAL_ {message} {signal}").unwrap();
    for (number, name) in names {
        write!(values, " {number} \"{name}\"").unwrap();
    }
    values.push_str(" ;\n");
}

fn comments(text: &mut String, name: &str, set: u32, reply: u32, sync: u32) {
    let alive = code::ALIVE;
    writeln!(
        text,
        "\nCM_ \"{name}: function select codes on raw CAN, factory identifiers\";"
    )
    .unwrap();
    writeln!(
        text,
        "CM_ BO_ {set} \"Requests; a function without data has DLC 1\";"
    )
    .unwrap();
    writeln!(text, "CM_ BO_ {reply} \"Replies, cyclic values and boot-up (FSC {alive}); as long as the function needs\";").unwrap();
    writeln!(
        text,
        "CM_ BO_ {sync} \"Asks every sensor for its inclination\";"
    )
    .unwrap();
}

#[cfg(test)]
mod tests {
    use super::*;
    use plumbline::model::{is1::OneAxis, is2::TwoAxes};

    #[test]
    fn the_angles_stand_where_tables_21_and_22_say() {
        let two = dbc::<TwoAxes>("is2");
        assert!(two.contains("SG_ AngleX m0 : 16|16@1- (0.01,0) [-90.00|90.00] \"deg\" Master"));
        assert!(two.contains("SG_ AngleY m0 : 32|16@1- (0.01,0) [-90.00|90.00] \"deg\" Master"));
        assert!(two.contains("SG_ CyclicCounter m0 : 48|16@1+"));
        let one = dbc::<OneAxis>("is1");
        assert!(one.contains("SG_ Angle m0 : 16|16@1+ (0.01,0) [0.00|359.99] \"deg\" Master"));
        assert!(one.contains("SG_ CyclicCounter m0 : 32|16@1+"));
        assert!(!one.contains("SensorErrorY"));
    }

    #[test]
    fn the_filter_parameter_has_two_signals() {
        let text = dbc::<TwoAxes>("is2");
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
