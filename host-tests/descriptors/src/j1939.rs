//! A CAN database (DBC) of the groups with process data of a product with J1939, generated from the definitions that compose the
//! frames. Identifiers have the factory priority and address.

use plumbline::j1939::identifier::{GLOBAL, Identifier};
use plumbline::j1939::signal::{Contents, Group, Signal};
use plumbline::model::catalog::Product;
use plumbline::model::listing::canopen::J1939Tables;
use plumbline::param::ParameterId;
use std::fmt::Write;

/// The figures of merit.
const MERITS: &str = "0 \"fully functional\" 1 \"degraded\" 2 \"error\" 3 \"not available\"";

/// The database of a product.
pub fn dbc(product: &Product, tables: &J1939Tables) -> String {
    let factory = |id: ParameterId| product.parameters[usize::from(id.0)].factory;
    let source = factory(tables.address) as u8;
    let mut text = String::from("VERSION \"\"\n\nNS_ :\n\nBS_:\n\nBU_: Sensor\n\n");
    let (mut attributes, mut values) = (String::new(), String::new());
    for (group, priority) in tables.groups.iter().zip(tables.priorities) {
        let id = Identifier::new(group.pgn, GLOBAL, source);
        // Bit 31: the identifier has 29 bits.
        let id = id.with_priority(factory(priority) as u8).can_id().bits();
        message(&mut text, id, group);
        for signal in group.signals {
            if signal.spn > 0 {
                let line = format!("BA_ \"SPN\" SG_ {id} {} {};", signal.name, signal.spn);
                writeln!(attributes, "{line}").unwrap();
            }
            if let Contents::Merit(_) = signal.contents {
                writeln!(values, "VAL_ {id} {} {MERITS} ;", signal.name).unwrap();
            }
        }
        writeln!(attributes, "BA_ \"PGN\" BO_ {id} {};", group.pgn).unwrap();
        writeln!(attributes, "BA_ \"VFrameFormat\" BO_ {id} 3;").unwrap();
    }
    text += "BA_DEF_ BO_ \"PGN\" INT 0 262143;\n";
    text += "BA_DEF_ BO_ \"VFrameFormat\" ENUM \"StandardCAN\",\"ExtendedCAN\",\"reserved\",\"J1939PG\";\n";
    text += "BA_DEF_ SG_ \"SPN\" INT 0 524287;\n";
    text += "BA_DEF_ \"ProtocolType\" STRING ;\n";
    text += "BA_DEF_DEF_ \"PGN\" 0;\nBA_DEF_DEF_ \"VFrameFormat\" \"J1939PG\";\n";
    text += "BA_DEF_DEF_ \"SPN\" 0;\nBA_DEF_DEF_ \"ProtocolType\" \"\";\n";
    text += "BA_ \"ProtocolType\" \"J1939\";\n";
    text + &attributes + &values
}

fn message(text: &mut String, id: u32, group: &Group) {
    writeln!(text, "BO_ {id} {}: 8 Sensor", group.name).unwrap();
    for signal in group.signals {
        let (factor, offset, unit) = scale(signal);
        let (start, bits) = (signal.start, signal.bits);
        let highest = match signal.contents {
            // FAh in the most significant byte is the last valid value.
            Contents::Value { .. } => offset + f64::from((0xFB << (bits - 8)) - 1) * factor,
            Contents::Latency | Contents::Unavailable => 250.0 * factor,
            _ => 3.0,
        };
        let name = signal.name;
        writeln!(
            text,
            " SG_ {name} : {start}|{bits}@1+ ({factor},{offset}) [{offset}|{highest}] \"{unit}\" Vector__XXX"
        )
        .unwrap();
    }
    text.push('\n');
}

/// Factor, offset and unit.
fn scale(signal: &Signal) -> (f64, f64, &'static str) {
    match signal.contents {
        Contents::Value {
            resolution: (value, divisor),
            offset,
            unit,
            ..
        } => (value as f64 / divisor as f64, offset.into(), unit),
        // A latency that is not known.
        Contents::Latency | Contents::Unavailable => (0.5, 0.0, "ms"),
        Contents::Merit(_) | Contents::Compensation => (1.0, 0.0, ""),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use plumbline::model::catalog::{Protocol, find};

    #[test]
    fn database_has_identifier_signal_and_numbers_of_ssi2() {
        let product = find("ims360").unwrap();
        let Protocol::Canopen(tables) = &product.protocol else {
            panic!("IMS360 is a CANopen product");
        };
        let text = dbc(product, &tables.j1939.unwrap());
        let id = 0x8CF0_2980_u32;
        for line in [
            format!("BO_ {id} SSI2: 8 Sensor"),
            " SG_ PitchAngleExRange : 0|24@1+ (0.000030517578125,-250) [-250|251.99996948242188] \"deg\" Vector__XXX".into(),
            " SG_ AngularRateMeasurementLatency : 56|8@1+ (0.5,0) [0|125] \"ms\" Vector__XXX".into(),
            format!("BA_ \"SPN\" SG_ {id} PitchAngleExRange 4976;"),
            format!("BA_ \"PGN\" BO_ {id} 61481;"),
        ] {
            assert!(text.lines().any(|own| own == line), "{line}\n{text}");
        }
        assert_eq!(text.matches("BO_ 2").count(), 4 * 3);
    }
}
