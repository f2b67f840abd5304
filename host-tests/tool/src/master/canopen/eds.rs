//! The data sheet of a CANopen device (CiA 306): sections with the index of an object, `[2000]`, and its sub-indices, `[1018sub1]`.

pub mod dcf;
mod identity;
pub(crate) mod sections;

use crate::eds::{Draft, Format, MOST, NO_ARTICLE, NO_PARAMETER, Parts, entry, number, too_many};
use crate::error::Fault;
use crate::sheet::rows::{Row, group_of};
use crate::sheet::{Address, Entry, Form};
use plumbline::canopen::LedTable;
use plumbline::canopen::dictionary::{Access, Object, Service, Target};
use plumbline::canopen::emcy::FaultBit;
use plumbline::model::catalog::Protocol;
use plumbline::model::listing::canopen::Tables;
use plumbline::param::{DataType, Permitted};
use sections::{Section, sections};
use std::collections::{BTreeMap, HashMap};
use texts::shown;

/// The object types that have a value: a variable, an array, a record.
const VARIABLE: i64 = 7;
const ARRAY: i64 = 8;
const RECORD: i64 = 9;

/// Store and restore parameters.
const STORE: u16 = 0x1010;
const RESTORE: u16 = 0x1011;

/// Objects whose write is a command: error history, store, restore, time stamps that the device sends, operating system, program download,
/// NMT start-up and the state of other nodes.
const COMMANDS: [u16; 16] = [
    0x1003, STORE, RESTORE, 0x1012, 0x1013, 0x1023, 0x1024, 0x1025, 0x1026, 0x1F50, 0x1F51, 0x1F57,
    0x1F80, 0x1F81, 0x1F82, 0x1F83,
];

/// Store and restore all parameters, as the services of a product.
const SERVICES: [Object; 2] = [
    service(STORE, Service::StoreGroup),
    service(RESTORE, Service::RestoreGroup),
];

const fn service(index: u16, service: Service) -> Object {
    Object {
        index,
        sub: 1,
        data_type: DataType::U32,
        access: Access::Rw,
        target: Target::Service(service),
        ..Object::plain()
    }
}

pub(super) const FORMAT: Format = Format {
    name: "CANopen",
    is_own: None,
    parts,
    values: identity::values,
    identity: [
        (
            Address::Object {
                index: 0x1018,
                sub: 1,
            },
            DataType::U32,
        ),
        (
            Address::Object {
                index: 0x1018,
                sub: 2,
            },
            DataType::U32,
        ),
    ],
};

/// The parts of the sheet.
fn parts(text: &str) -> Result<Parts, Fault> {
    let (sections, ignored) = sections(text)?;
    let none = Section::default();
    let info = sections.get("deviceinfo").unwrap_or(&none);
    let mut objects: BTreeMap<u16, &Section> = BTreeMap::new();
    let mut subs: BTreeMap<(u16, u8), &Section> = BTreeMap::new();
    for (name, section) in &sections {
        match address(name) {
            Some((index, None)) => {
                objects.insert(index, section);
            }
            Some((index, Some(sub))) => {
                subs.insert((index, sub), section);
            }
            None => {}
        }
    }
    // Without an object that has sub-indices, they are not known.
    let has_subs = |index: &u16| {
        let object = objects.get(index).and_then(|own| own.number("objecttype"));
        matches!(object, Some(ARRAY | RECORD))
    };
    let lonely = subs.iter().filter(|((index, _), _)| !has_subs(index));
    let mut left_out = lonely
        .filter(|((_, sub), own)| *sub > 0 || !is_constant(own))
        .count();
    let mut rows = Vec::new();
    for (index, object) in objects {
        let title = object.get("parametername").unwrap_or_default();
        let group = group_of(index, &shown(title));
        let found: Vec<Option<Row>> = match object.number("objecttype").unwrap_or(VARIABLE) {
            VARIABLE => vec![variable((index, 0), title, String::new(), object)],
            ARRAY | RECORD => {
                let compact = compact(index, object, &sections).into_iter();
                let compact = compact
                    .map(|(sub, title)| variable((index, sub), &title, group.clone(), object));
                let subs = subs.range((index, 0)..=(index, u8::MAX));
                let subs = subs.filter(|((_, sub), own)| *sub > 0 || !is_constant(own));
                let subs = subs.map(|((_, sub), own)| {
                    let title = own.get("parametername").unwrap_or_default();
                    variable((index, *sub), title, group.clone(), own)
                });
                compact.chain(subs).collect()
            }
            _ => vec![None],
        };
        left_out += found.iter().filter(|row| row.is_none()).count();
        rows.extend(found.into_iter().flatten());
        if rows.len() + left_out > MOST {
            return Err(too_many());
        }
    }
    let has = |index: u16| {
        let is = |row: &Row| {
            row.entry.writable && row.entry.address == Address::Object { index, sub: 1 }
        };
        rows.iter().any(is)
    };
    let services: &'static [Object] = match (has(STORE), has(RESTORE)) {
        (true, true) => &SERVICES,
        (true, false) => &SERVICES[..1],
        (false, true) => &SERVICES[1..],
        (false, false) => &[],
    };
    let identity = ["vendornumber", "productnumber"].map(|key| {
        let number = info.number(key)?;
        u32::try_from(number).ok().filter(|number| *number > 0)
    });
    let text = |key: &str| info.get(key).unwrap_or_default().to_owned();
    Ok(Parts {
        name: text("productname"),
        maker: text("vendorname"),
        protocol: protocol(services),
        identity,
        rows: rows.into_iter().map(Draft::from).collect(),
        left_out,
        ignored,
    })
}

/// The index and the sub-index in the name of a section: `1a00`, `1a00sub1`.
pub(super) fn address(name: &str) -> Option<(u16, Option<u8>)> {
    let name = name.trim().to_ascii_lowercase();
    let hexadecimal = |text: &str| {
        let is_valid = !text.is_empty() && text.bytes().all(|byte| byte.is_ascii_hexdigit());
        is_valid.then(|| u16::from_str_radix(text, 16).ok())?
    };
    let (index, sub) = match name.split_once("sub") {
        Some((index, sub)) => (index, Some(u8::try_from(hexadecimal(sub)?).ok()?)),
        None => (&name[..], None),
    };
    let index = hexadecimal(index).filter(|_| index.len() == 4)?;
    Some((index, sub))
}

/// The sub-indices of an object that describes them all, with their names: `CompactSubObj=8`, names in the section `[2000Name]`.
fn compact(index: u16, object: &Section, sections: &HashMap<String, Section>) -> Vec<(u8, String)> {
    let count = object.number("compactsubobj").unwrap_or(0);
    let Some(count @ 1..) = u8::try_from(count).ok().filter(|count| *count < u8::MAX) else {
        return Vec::new();
    };
    let names = sections.get(&format!("{index:04x}name"));
    let group = object.get("parametername").unwrap_or_default();
    let subs = (1..=count).map(|sub| {
        let name = names.and_then(|names| names.get(&sub.to_string()));
        let name = match name {
            Some(name) => name.to_owned(),
            None => format!("{group} {sub}"),
        };
        (sub, name)
    });
    subs.collect()
}

/// Whether a sub-index 0 is only the number of the others.
fn is_constant(section: &Section) -> bool {
    let access = section.get("accesstype").unwrap_or_default();
    ["ro", "const"].contains(&&access.to_ascii_lowercase()[..])
}

/// The serial number, which is decimal.
const SERIAL_NUMBER: (u16, u8) = (0x1018, 4);

/// A variable as a row; None if its type or access is not known.
fn variable((index, sub): (u16, u8), title: &str, group: String, section: &Section) -> Option<Row> {
    let (data_type, permitted) = match section.number("datatype")? {
        1 => (DataType::U8, Permitted::Range(0, 1)),
        2 => (DataType::I8, Permitted::Any),
        3 => (DataType::I16, Permitted::Any),
        4 => (DataType::I32, Permitted::Any),
        5 => (DataType::U8, Permitted::Any),
        6 => (DataType::U16, Permitted::Any),
        7 => (DataType::U32, Permitted::Any),
        9 => (DataType::Text, Permitted::Any),
        _ => return None,
    };
    let access = section.get("accesstype").unwrap_or_default();
    let access = access.to_ascii_lowercase();
    let (readable, writable) = match &access[..] {
        "ro" | "const" => (true, false),
        "wo" => (false, true),
        "rw" | "rwr" | "rww" => (true, true),
        _ => return None,
    };
    // Process data is written by PDOs all the time, so it is no setting: control words, set values, outputs.
    let is_mapped = section.number("pdomapping").unwrap_or(0) != 0;
    let is_process_data = is_mapped || ["rwr", "rww"].contains(&&access[..]);
    let (factory, node_relative) = match section.get("defaultvalue") {
        Some(text) if data_type != DataType::Text => default(text, data_type),
        _ => (None, false),
    };
    let is_refused = section.number("objflags").unwrap_or(0) & 1 != 0;
    let is_serial = (index, sub) == SERIAL_NUMBER;
    let is_bits = data_type == DataType::U32 && index < 0x2000 && !is_serial;
    let entry = Entry {
        permitted: limits(section, data_type).unwrap_or(permitted),
        form: if is_bits {
            Form::Hexadecimal
        } else {
            Form::Decimal
        },
        factory,
        node_relative,
        readable,
        writable,
        stored: writable && data_type != DataType::Text,
        command: is_refused || is_process_data || COMMANDS.contains(&index),
        ..entry(title, Address::Object { index, sub }, data_type)
    };
    Some(Row { group, entry })
}

/// The value of a number, also of a signed one that is written as its bytes: FFFFh is -1.
fn value(number: i64, data_type: DataType) -> Option<i64> {
    let (low, high) = data_type.range();
    let bits = 8 * u32::from(data_type.size());
    match number {
        _ if (low..=high).contains(&number) => Some(number),
        _ if data_type.is_signed() && (0..1 << bits).contains(&number) => {
            Some(data_type.value(number as u32))
        }
        _ => None,
    }
}

/// The default as bytes, and whether the node-ID is added: `$NODEID+0x180`.
fn default(text: &str, data_type: DataType) -> (Option<u32>, bool) {
    let small = text.to_ascii_lowercase();
    let is_relative = small.contains("$nodeid");
    let plain = small.replace("$nodeid", "").replace(['+', ' '], "");
    let number = match &plain[..] {
        "" if is_relative => Some(0),
        plain => number(plain),
    };
    let value = number.and_then(|number| value(number, data_type));
    let mask = u32::MAX >> (32 - 8 * u32::from(data_type.size()));
    let raw = value.map(|value| value as u32 & mask);
    (raw, is_relative && raw.is_some())
}

/// The limits, if they make sense.
fn limits(section: &Section, data_type: DataType) -> Option<Permitted> {
    let limit = |key: &str| section.number(key).and_then(|own| value(own, data_type));
    let (low, high) = (limit("lowlimit"), limit("highlimit"));
    if data_type == DataType::Text || (low.is_none() && high.is_none()) {
        return None;
    }
    let (least, most) = data_type.range();
    let (low, high) = (low.unwrap_or(least), high.unwrap_or(most));
    (low < high).then_some(Permitted::Range(low, high))
}

/// The tables of a device of which only the data sheet is known.
fn protocol(services: &'static [Object]) -> Protocol {
    Protocol::Canopen(Tables {
        article: NO_ARTICLE,
        objects: services,
        faults: [FaultBit::RESERVED; 8],
        events: &[],
        leds: LedTable::CIA_303_3,
        node_id: NO_PARAMETER,
        bit_rate: NO_PARAMETER,
        bit_rates: &[],
        lss: false,
        defect: None,
        variants: &[],
        j1939: None,
    })
}
