//! A CAN database (DBC) of the messages of a product with J1939. Process data and trouble codes (DM1) are generated from the definitions
//! that compose the frames. Identifiers have the factory priority and address.
//!
//! The attributes are those of J1939 in the tools of Vector: `PGN`, `SPN`, `VFrameFormat`, `GenMsgCycleTime` (0: on request) and the NAME
//! of the node (`NmJ1939...`).

mod network;

use crate::dbc::checked;
use network::{Layout, MESSAGES};
use plumbline::j1939::diagnostics::PERIOD;
use plumbline::j1939::identifier::{ACTIVE_CODES, GLOBAL, Identifier, PROPRIETARY_A, Pgn};
use plumbline::j1939::signal::{Contents, Group, Signal};
use plumbline::model::catalog::{Product, Protocol};
use plumbline::model::listing::j1939::J1939Tables;
use plumbline::param::Setting;
use std::fmt::Write;

/// The name of the sensor in the database, which has no other node.
const NODE: &str = "Sensor";

/// The names of the values of a figure of merit.
const MERITS: &str = "0 \"fully functional\" 1 \"degraded\" 2 \"error\" 3 \"not available\"";

/// What 0 and 1 mean as a compensation is not known.
const COMPENSATIONS: &str = "3 \"not available\"";

/// The states of a lamp.
const STATES: &str = "0 \"off\" 1 \"on\" 2 \"error\" 3 \"not available\"";

/// Attributes of the node: the fields of the NAME in the order of [`J1939Tables::name`], and their largest values.
const NAME: [(&str, u32); 8] = [
    ("NmJ1939AAC", 1),
    ("NmJ1939IndustryGroup", 7),
    ("NmJ1939SystemInstance", 15),
    ("NmJ1939System", 127),
    ("NmJ1939Function", 255),
    ("NmJ1939FunctionInstance", 31),
    ("NmJ1939ECUInstance", 7),
    ("NmJ1939ManufacturerCode", 2047),
];

/// The fields of DM1 with one code, and their SPN (SAE J1939-73, 5.7.1): name, SPN, first bit, number of bits.
const CODES: [(&str, u32, u8, u8); 13] = [
    ("ProtectLamp", 987, 0, 2),
    ("AmberWarningLamp", 624, 2, 2),
    ("RedStopLamp", 623, 4, 2),
    ("MalfunctionIndicatorLamp", 1213, 6, 2),
    ("FlashProtectLamp", 3041, 8, 2),
    ("FlashAmberWarningLamp", 3040, 10, 2),
    ("FlashRedStopLamp", 3039, 12, 2),
    ("FlashMalfunctionIndicatorLamp", 3038, 14, 2),
    // The upper three bits of the number are 0 in all codes.
    ("SuspectParameterNumber", 1214, 16, 16),
    ("FailureModeIdentifier", 1215, 32, 5),
    ("SuspectParameterNumberHigh", 1214, 37, 3),
    ("OccurrenceCount", 1216, 40, 7),
    ("ConversionMethod", 1706, 47, 1),
];

/// A database in parts, in the order of the file.
#[derive(Default)]
struct Database {
    messages: String,
    comments: String,
    attributes: String,
    values: String,
}

/// The database of a product.
pub fn dbc(product: &Product, tables: &J1939Tables) -> String {
    let factory = |setting: Setting| setting.factory(product.parameters);
    let source = factory(Setting::Parameter(tables.address)) as u8;
    let mut database = Database::default();
    let settings = (0..).map_while(tables.settings);
    for (group, (rate, priority)) in tables.groups.iter().zip(settings) {
        let id = identifier(group.pgn, factory(priority) as u8, source);
        let cycle = factory(rate);
        database.group(id, group, cycle);
        let sent = if cycle == 0 {
            "on request".into()
        } else {
            format!("every {cycle} ms")
        };
        database.comment(id, &format!("{sent} as delivered"));
    }
    let id = identifier(
        ACTIVE_CODES,
        Identifier::new(ACTIVE_CODES, GLOBAL, source).priority,
        source,
    );
    database.codes(id, tables);
    // Without CANopen, Proprietary A has the messages of the maker.
    let has_objects = !matches!(product.protocol, Protocol::J1939(_));
    for layout in MESSAGES {
        if has_objects || layout.pgn != PROPRIETARY_A {
            database.layout(layout, source);
        }
    }
    database.node(source, tables.name.map(factory));
    let Database {
        messages,
        comments,
        attributes,
        values,
    } = database;
    let head = format!("VERSION \"\"\n\nNS_ :\n\nBS_:\n\nBU_: {NODE}\n\n");
    let about = format!(
        "CM_ \"{}: SAE J1939, factory address and priorities. Other addresses and priorities with cantools: load_file(..., \
         frame_id_mask=0x03FFFF00). A message to one node has its address in bits 8 to 15: get_message_by_name(...).decode(data).\";\n",
        product.name
    );
    head + &messages + &about + &comments + &definitions() + &attributes + &values
}

/// The identifier with bit 31, which marks 29 bits.
fn identifier(pgn: Pgn, priority: u8, source: u8) -> u32 {
    let id = Identifier::new(pgn, GLOBAL, source).with_priority(priority);
    id.can_id().bits()
}

/// The definitions of the attributes.
fn definitions() -> String {
    let mut text = String::new();
    let mut define = |object: &str, name: &str, kind: &str, default: &str| {
        writeln!(text, "BA_DEF_ {object}\"{name}\" {kind};").unwrap();
        writeln!(text, "BA_DEF_DEF_ \"{name}\" {default};").unwrap();
    };
    define("BO_ ", "PGN", "INT 0 262143", "0");
    let formats = "ENUM \"StandardCAN\",\"ExtendedCAN\",\"reserved\",\"J1939PG\"";
    define("BO_ ", "VFrameFormat", formats, "\"J1939PG\"");
    define("BO_ ", "GenMsgCycleTime", "INT 0 65535", "0");
    define("SG_ ", "SPN", "INT 0 524287", "0");
    define("BU_ ", "NmStationAddress", "INT 0 254", "254");
    for (name, highest) in NAME {
        define("BU_ ", name, &format!("INT 0 {highest}"), "0");
    }
    define("", "ProtocolType", "STRING ", "\"\"");
    text + "BA_ \"ProtocolType\" \"J1939\";\n"
}

impl Database {
    /// A message of the sensor with eight bytes, and its attributes.
    fn message(&mut self, id: u32, pgn: Pgn, name: &str, cycle: u32) {
        let name = checked(name.to_owned());
        writeln!(self.messages, "BO_ {id} {name}: 8 {NODE}").unwrap();
        self.attributes(id, pgn, cycle);
    }

    fn attributes(&mut self, id: u32, pgn: Pgn, cycle: u32) {
        for (attribute, value) in [
            ("PGN", pgn),
            ("VFrameFormat", 3),
            ("GenMsgCycleTime", cycle),
        ] {
            writeln!(self.attributes, "BA_ \"{attribute}\" BO_ {id} {value};").unwrap();
        }
    }

    fn comment(&mut self, id: u32, text: &str) {
        writeln!(self.comments, "CM_ BO_ {id} \"{text}\";").unwrap();
    }

    /// The SPN of a signal, if it is known, and the names of its values.
    fn describe(&mut self, id: u32, name: &str, spn: u32, values: &str) {
        if spn > 0 {
            writeln!(self.attributes, "BA_ \"SPN\" SG_ {id} {name} {spn};").unwrap();
        }
        if !values.is_empty() {
            writeln!(self.values, "VAL_ {id} {name} {values} ;").unwrap();
        }
    }

    /// A message of the protocol.
    fn layout(&mut self, layout: &Layout, sensor: u8) {
        let (destination, source) = layout.sent.addresses(sensor);
        let id = Identifier::new(layout.pgn, destination, source).with_priority(layout.priority);
        let id = id.can_id().bits();
        let (sender, receiver) = if source == sensor {
            (NODE, "Vector__XXX")
        } else {
            ("Vector__XXX", NODE)
        };
        let name = checked(layout.name.to_owned());
        writeln!(self.messages, "BO_ {id} {name}: {} {sender}", layout.size).unwrap();
        self.attributes(id, layout.pgn, 0);
        if !layout.comment.is_empty() {
            self.comment(id, layout.comment);
        }
        for (name, start, bits, values) in layout.fields {
            let highest = (1_u64 << bits) - 1;
            writeln!(
                self.messages,
                " SG_ {name} : {start}|{bits}@1+ (1,0) [0|{highest}] \"\" {receiver}"
            )
            .unwrap();
            self.describe(id, name, 0, values);
        }
        self.messages.push('\n');
    }

    /// A group with process data.
    fn group(&mut self, id: u32, group: &Group, cycle: u32) {
        self.message(id, group.pgn, group.name, cycle);
        signals(&mut self.messages, group);
        for signal in group.signals {
            let values = match signal.contents {
                Contents::Merit(_) => MERITS,
                Contents::Compensation => COMPENSATIONS,
                _ => "",
            };
            self.describe(id, signal.name, signal.spn, values);
        }
    }

    /// DM1 with up to one code.
    fn codes(&mut self, id: u32, tables: &J1939Tables) {
        let cycle = PERIOD.ticks() / 1000;
        self.message(id, ACTIVE_CODES, "DM1", cycle as u32);
        self.comment(
            id,
            "Active trouble codes; more than one by the transport protocol",
        );
        let troubles = tables.troubles.iter();
        let numbers = troubles
            .clone()
            .map(|code| (code.spn, spn_name(code.spn, tables)));
        let numbers = named(numbers.chain([(0, "none".to_owned())]));
        let modes = named(troubles.map(|code| (code.fmi.into(), fmi_name(code.fmi).to_owned())));
        for (name, spn, start, bits) in CODES {
            let highest = (1_u32 << bits) - 1;
            writeln!(
                self.messages,
                " SG_ {name} : {start}|{bits}@1+ (1,0) [0|{highest}] \"\" Vector__XXX"
            )
            .unwrap();
            let values = match name {
                "SuspectParameterNumber" => &numbers,
                "FailureModeIdentifier" => &modes,
                _ if name.ends_with("Lamp") && start < 8 => STATES,
                _ => "",
            };
            self.describe(id, name, spn, values);
        }
        self.messages.push('\n');
    }

    /// The address and the fields of the NAME, as attributes of the node.
    fn node(&mut self, address: u8, name: [u32; 8]) {
        let address = ("NmStationAddress", u32::from(address));
        let fields = NAME
            .into_iter()
            .zip(name)
            .map(|((name, _), value)| (name, value));
        for (attribute, value) in [address].into_iter().chain(fields) {
            writeln!(self.attributes, "BA_ \"{attribute}\" BU_ {NODE} {value};").unwrap();
        }
    }
}

/// A table of values, each number once.
fn named(values: impl Iterator<Item = (u32, String)>) -> String {
    let values: std::collections::BTreeMap<u32, String> = values.collect();
    let texts = values
        .into_iter()
        .map(|(number, name)| format!("{number} \"{name}\""));
    texts.collect::<Vec<_>>().join(" ")
}

/// The name of a suspect parameter: of a signal, or of SAE J1939-71 and -73.
fn spn_name(spn: u32, tables: &J1939Tables) -> String {
    let mut signals = tables.groups.iter().flat_map(|group| group.signals);
    if let Some(signal) = signals.find(|signal| signal.spn == spn) {
        return signal.name.to_owned();
    }
    match spn {
        168 => "battery potential".to_owned(),
        630 => "calibration memory".to_owned(),
        639 => "J1939 network 1".to_owned(),
        _ => format!("SPN {spn}"),
    }
}

/// The name of a failure mode (SAE J1939-73, appendix A).
fn fmi_name(fmi: u8) -> &'static str {
    match fmi {
        0 => "above normal",
        1 => "below normal",
        2 => "data erratic",
        3 => "voltage above normal",
        4 => "voltage below normal",
        12 => "bad device",
        _ => "other",
    }
}

/// The signals of a group with process data.
fn signals(text: &mut String, group: &Group) {
    for signal in group.signals {
        let ((value, divisor), offset, unit) = scale(signal);
        let (start, bits) = (signal.start, signal.bits);
        let highest = match signal.contents {
            // FAh in the most significant byte is the last valid value.
            Contents::Value { .. } | Contents::Own { .. } if bits >= 8 => {
                (0xFB_i64 << (bits - 8)) - 1
            }
            Contents::Own { .. } => (1 << bits) - 1,
            Contents::Latency | Contents::UnknownLatency => 250,
            _ => 3,
        };
        let factor = value as f64 / divisor as f64;
        let numerator = i64::from(offset) * divisor as i64 + highest * value as i64;
        let highest = numerator as f64 / divisor as f64;
        let name = checked(signal.name.to_owned());
        writeln!(
            text,
            " SG_ {name} : {start}|{bits}@1+ ({factor},{offset}) [{offset}|{highest}] \"{unit}\" Vector__XXX"
        )
        .unwrap();
    }
    text.push('\n');
}

/// The value of one bit as a fraction, the value of the number 0, and the unit of both.
pub fn scale(signal: &Signal) -> ((u64, u64), i32, &'static str) {
    match signal.contents {
        Contents::Value {
            resolution,
            offset,
            unit,
            ..
        }
        | Contents::Own {
            resolution,
            offset,
            unit,
        } => (resolution, offset, unit),
        Contents::Latency | Contents::UnknownLatency => ((1, 2), 0, "ms"),
        Contents::Merit(_) | Contents::Compensation => ((1, 1), 0, ""),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use plumbline::model::catalog::find;

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
            " SG_ PitchAngle : 0|16@1+ (0.002,-64) [-64|64.51] \"deg\" Vector__XXX".into(),
            format!("BA_ \"SPN\" SG_ {id} PitchAngleExRange 4976;"),
            format!("BA_ \"PGN\" BO_ {id} 61481;"),
        ] {
            assert!(text.lines().any(|own| own == line), "{line}\n{text}");
        }
        // Four groups, DM1 and the messages of the protocol; each has three attributes.
        let messages = text.lines().filter(|line| line.starts_with("BO_ "));
        assert_eq!(messages.count(), 5 + MESSAGES.len());
        let attributes = |line: &&str| line.starts_with("BA_ ") && line.contains(" BO_ ");
        let attributes = text.lines().filter(attributes).count();
        assert_eq!(attributes, 3 * (5 + MESSAGES.len()));
    }
}
