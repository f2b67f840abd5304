//! An Electronic Data Sheet (CiA 306) of a CANopen product, generated from its object dictionary.
//!
//! Every object and every sub-index has its own section. Comments before the sections state unit and permitted values, for which
//! CiA 306 has no entries. Measured values have no default value. Commands, node-ID, bit rate and protocol have none either, and the flag
//! that a tool must not write them when it downloads a configuration: it would clear errors, take a zero point, reset the sensor or lose
//! it.

use crate::objects::Described;
use crate::{description, notice};
use plumbline::canopen::dictionary::{Access, Object, Target};
use plumbline::model::catalog::Product;
use plumbline::model::listing::canopen::Tables;
use plumbline::model::listing::canopen::Variant;
use plumbline::param::{DataType, Permitted};
use std::fmt::Write;

/// CiA 306 requires a date and a time; they are fixed, so that the same table always gives the same file.
const TIME: &str = "12:00PM";
/// In the format MM-DD-YYYY of CiA 306.
const DATE: &str = "11-21-2026";

/// The flag of an object that is not written when a configuration is downloaded (CiA 306, ObjFlags).
const REFUSE_WRITE: u8 = 1;

/// The bit rates of CiA 306, in kbit/s.
const BIT_RATES: [u32; 8] = [10, 20, 50, 125, 250, 500, 800, 1000];

/// The mandatory objects of a CANopen device (CiA 301, 7.5.1).
const MANDATORY: [u16; 3] = [0x1000, 0x1001, 0x1018];

/// The data sheet `name` of a product, or of a variant of it.
pub fn eds(name: &str, product: &Product, tables: &Tables, variant: Option<&Variant>) -> String {
    let file = format!("{name}.eds");
    let described = Described::all(tables.objects, product, variant);
    let objects: Vec<&[Described]> = described
        .chunk_by(|one, next| one.object.index == next.object.index)
        .collect();
    let name = designation(tables);
    let mut text = String::new();
    file_info(&mut text, &file, &description(product, name));
    let rates = bit_rates(product, tables);
    device_info(&mut text, product, tables, name, &objects, &rates);
    dummy_usage(&mut text);
    comments(&mut text, product, name);
    let indices = || {
        objects
            .iter()
            .filter_map(|rows| Some(rows.first()?.object.index))
    };
    let is_mandatory = |index: &u16| MANDATORY.contains(index);
    let is_manufacturers = |index: &u16| (0x2000..0x6000).contains(index);
    let is_optional = |index: &u16| !is_mandatory(index) && !is_manufacturers(index);
    list(
        &mut text,
        "MandatoryObjects",
        indices().filter(is_mandatory),
    );
    list(&mut text, "OptionalObjects", indices().filter(is_optional));
    list(
        &mut text,
        "ManufacturerObjects",
        indices().filter(is_manufacturers),
    );
    for rows in &objects {
        object(&mut text, rows);
    }
    // One empty line separates sections; there is none after the last.
    text.trim_end().replace('\n', "\r\n") + "\r\n"
}

fn section(text: &mut String, name: &str) {
    writeln!(text, "[{name}]").unwrap();
}

fn entry(text: &mut String, key: &str, value: impl std::fmt::Display) {
    writeln!(text, "{key}={value}").unwrap();
}

fn end(text: &mut String) {
    text.push('\n');
}

fn file_info(text: &mut String, file: &str, description: &str) {
    section(text, "FileInfo");
    entry(text, "FileName", file);
    entry(text, "FileVersion", 1);
    entry(text, "FileRevision", 0);
    entry(text, "EDSVersion", "4.0");
    entry(text, "Description", description);
    for what in ["Creation", "Modification"] {
        entry(text, &format!("{what}Time"), TIME);
        entry(text, &format!("{what}Date"), DATE);
    }
    entry(text, "CreatedBy", "Plumbline");
    entry(text, "ModifiedBy", "Plumbline");
    end(text);
}

fn device_info(
    text: &mut String,
    product: &Product,
    tables: &Tables,
    name: &str,
    objects: &[&[Described]],
    rates: &[u32],
) {
    let identity = |sub| constant(tables.objects, 0x1018, sub);
    let count = |first: u16| {
        let indices = first..first + 512;
        let is = |rows: &&&[Described]| rows.iter().any(|row| indices.contains(&row.object.index));
        objects.iter().filter(is).count()
    };
    let mapping = |row: &&Object| (0x1A00..0x1C00).contains(&row.index);
    let mut maps = tables.objects.iter().filter(mapping);
    let is_fixed = maps.all(|row| !row.access.is_writable());
    section(text, "DeviceInfo");
    entry(text, "VendorName", product.vendor);
    entry(text, "VendorNumber", format!("0x{:08X}", identity(1)));
    entry(text, "ProductName", name);
    entry(text, "ProductNumber", format!("0x{:X}", identity(2)));
    entry(text, "RevisionNumber", format!("0x{:X}", identity(3)));
    entry(text, "OrderCode", name);
    for kbits in BIT_RATES {
        let offered = rates.contains(&(1000 * kbits));
        entry(text, &format!("BaudRate_{kbits}"), u8::from(offered));
    }
    entry(text, "SimpleBootUpMaster", 0);
    entry(text, "SimpleBootUpSlave", 1);
    // 0: the mapping cannot be changed.
    entry(text, "Granularity", if is_fixed { 0 } else { 8 });
    entry(text, "DynamicChannelsSupported", 0);
    entry(text, "GroupMessaging", 0);
    entry(text, "NrOfRXPDO", count(0x1400));
    entry(text, "NrOfTXPDO", count(0x1800));
    entry(text, "LSS_Supported", u8::from(tables.lss));
    end(text);
}

/// The bit rates that the parameter of the bit rate permits, in bit/s.
fn bit_rates(product: &Product, tables: &Tables) -> Vec<u32> {
    let parameter = &product.parameters[usize::from(tables.bit_rate.0)];
    let is_permitted = |code: u32| match parameter.permitted {
        Permitted::OneOf(list) => list.contains(&code),
        _ => true,
    };
    let permitted = tables
        .bit_rates
        .iter()
        .filter(|(code, _)| is_permitted(*code));
    permitted.map(|(_, rate)| rate.bits_per_second()).collect()
}

/// No receive PDO needs dummy entries.
fn dummy_usage(text: &mut String) {
    section(text, "DummyUsage");
    for data_type in 1..=7 {
        entry(text, &format!("Dummy{data_type:04X}"), 0);
    }
    end(text);
}

fn comments(text: &mut String, product: &Product, name: &str) {
    let mut lines = notice(product, name);
    if product.is_replacement() {
        let numbers = "Vendor and product number are those that the compatible sensor shows.";
        lines.push(numbers.to_owned());
    }
    lines.push("Written from the object dictionary of the firmware. Do not edit.".to_owned());
    section(text, "Comments");
    entry(text, "Lines", lines.len());
    for (number, line) in (1..).zip(lines) {
        entry(text, &format!("Line{number}"), line);
    }
    end(text);
}

fn list(text: &mut String, name: &str, indices: impl Iterator<Item = u16>) {
    let indices: Vec<_> = indices.collect();
    section(text, name);
    entry(text, "SupportedObjects", indices.len());
    for (number, index) in (1..).zip(indices) {
        entry(text, &format!("{number}"), format!("0x{index:04X}"));
    }
    end(text);
}

/// The sections of an object: one for a variable, otherwise one for the object and one for each sub-index.
fn object(text: &mut String, rows: &[Described]) {
    let [first, ..] = rows else { return };
    let Object { index, group, .. } = *first.object;
    if group.is_empty() {
        variable(text, &format!("{index:04X}"), first.name(), first);
        return;
    }
    let subs: usize = rows.iter().map(|row| usize::from(row.object.count)).sum();
    section(text, &format!("{index:04X}"));
    entry(text, "ParameterName", group);
    entry(text, "ObjectType", object_type(index));
    entry(text, "SubNumber", subs);
    end(text);
    for row in rows {
        for number in 0..row.object.count {
            let name = match row.object.count {
                1 => row.name().to_owned(),
                _ => format!("{} {}", row.name(), number + 1),
            };
            let section = format!("{index:04X}sub{:X}", row.object.sub + number);
            variable(text, &section, &name, row);
        }
    }
}

fn variable(text: &mut String, name: &str, parameter: &str, described: &Described) {
    let notes = [
        ("unit", described.unit_of_one()),
        ("values", described.permitted()),
    ];
    for (what, note) in notes.iter().filter(|(_, note)| !note.is_empty()) {
        writeln!(text, "; {what}: {note}").unwrap();
    }
    section(text, name);
    entry(text, "ParameterName", parameter);
    entry(text, "ObjectType", "0x7");
    entry(text, "DataType", data_type(described.data_type()));
    entry(text, "AccessType", access(described.object.access));
    let is_downloaded = described.is_downloaded();
    if let Some(value) = default(described).filter(|_| is_downloaded) {
        entry(text, "DefaultValue", value);
    }
    if let Some((low, high)) = described.limits() {
        entry(text, "LowLimit", number(described.data_type(), low));
        entry(text, "HighLimit", number(described.data_type(), high));
    }
    entry(text, "PDOMapping", u8::from(described.object.mappable));
    end(text);
    if !is_downloaded {
        // Behind the empty line, which has no meaning in this format: eds-validate (eds-utils 0.3.1) does not know the entry, and
        // takes it there for a comment of the next section.
        entry(text, "ObjFlags", REFUSE_WRITE);
    }
}

/// ARRAY or RECORD: as defined for the objects of CiA 301 (7.5.2); all others are records.
fn object_type(index: u16) -> &'static str {
    match index {
        0x1003 | 0x1010 | 0x1011 | 0x1016 | 0x1029 => "0x8",
        _ => "0x9",
    }
}

fn data_type(data_type: DataType) -> &'static str {
    match data_type {
        DataType::I8 => "0x0002",
        DataType::I16 => "0x0003",
        DataType::I32 => "0x0004",
        DataType::U8 => "0x0005",
        DataType::U16 => "0x0006",
        DataType::U32 => "0x0007",
        DataType::Real32 => "0x0008",
        DataType::Text => "0x0009",
        DataType::Real64 => "0x0011",
        DataType::I64 => "0x0015",
        DataType::U64 => "0x001B",
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

fn default(described: &Described) -> Option<String> {
    if let Target::Text(text) = described.object.target {
        return Some(text.to_owned());
    }
    let data_type = described.data_type();
    if let Some(bits) = described.bits() {
        // A real number is decimal, which python-canopen and most data sheets have. No public text of CiA 306 says another form. dcfchk
        // (dcf-tools) reads the bits in hexadecimal digits without 0x, but refuses those with letters; it cannot check such a data sheet.
        return Some(match data_type {
            DataType::Real32 => format!("{:?}", f32::from_bits(bits as u32)),
            DataType::Real64 => format!("{:?}", f64::from_bits(bits)),
            DataType::I64 => (bits as i64).to_string(),
            _ => format!("0x{bits:X}"),
        });
    }
    let factory = described.factory()?;
    if is_entry(described.object) {
        return Some(format!("0x{factory:08X}"));
    }
    let value = number(data_type, data_type.value(factory));
    Some(if described.is_node_relative() {
        format!("$NODEID+{value}")
    } else {
        value
    })
}

/// Whether an object is an entry of a mapping. It has eight digits: index, sub-index and length.
fn is_entry(object: &Object) -> bool {
    (0x1A00..0x1C00).contains(&object.index) && object.sub > 0
}

/// UNSIGNED32 is written in hexadecimal, because most values are identifiers, signatures and bit fields.
fn number(data_type: DataType, number: i64) -> String {
    match data_type {
        DataType::U32 => format!("0x{number:X}"),
        _ => number.to_string(),
    }
}

/// The constant value of an object; 0 when it has none.
fn constant(objects: &[Object], index: u16, sub: u8) -> u32 {
    let at = |row: &&Object| (row.index, row.sub) == (index, sub);
    match objects.iter().find(at).map(|row| row.target) {
        Some(Target::Constant(number)) => number,
        _ => 0,
    }
}

/// The name of the device in 1008h, or that of the article.
fn designation(tables: &Tables) -> &'static str {
    let row = tables.objects.iter().find(|row| row.index == 0x1008);
    match row.map(|row| row.target) {
        Some(Target::Text(text)) => text,
        _ => tables.article.name,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::describe;
    use plumbline::model::catalog::find;

    fn jn2101() -> String {
        describe(find("jn2101").unwrap()).text.replace("\r\n", "\n")
    }

    #[test]
    fn eds_has_all_bit_rates_of_manual() {
        let text = jn2101();
        for rate in BIT_RATES {
            assert!(text.contains(&format!("BaudRate_{rate}=1\n")), "{rate}");
        }
    }

    #[test]
    fn eds_has_fixed_mapping_and_no_lss() {
        let text = jn2101();
        assert!(text.contains("Granularity=0\n"));
        assert!(text.contains("NrOfRXPDO=0\nNrOfTXPDO=2\nLSS_Supported=0\n"));
    }

    #[test]
    fn sub_index_sections_are_hexadecimal() {
        let text = jn2101();
        assert!(text.contains("[1003sub32]\nParameterName=Error code 50\n"));
        assert!(!text.contains("[1003sub33]"));
    }

    #[test]
    fn command_has_no_default_value_and_is_not_downloaded() {
        let expected = "; values: 0 = no change, 1 = relative measurement, 2 = absolute measurement\n[2042]\n\
            ParameterName=Teach index\nObjectType=0x7\nDataType=0x0005\nAccessType=rw\nLowLimit=0\n\
            HighLimit=2\nPDOMapping=0\n\nObjFlags=1\n";
        assert!(jn2101().contains(expected));
    }

    #[test]
    fn node_id_has_no_default_value_and_is_not_downloaded() {
        let expected = "[2000]\nParameterName=Node ID\nObjectType=0x7\nDataType=0x0005\nAccessType=rw\nLowLimit=1\n\
            HighLimit=127\nPDOMapping=0\n\nObjFlags=1\n";
        assert!(jn2101().contains(expected));
    }

    #[test]
    fn comment_before_section_has_unit_and_values() {
        let expected = "; unit: 0.001 deg\n; values: 1, 10, 100, 1000\n[6000]\nParameterName=Resolution\nObjectType=0x7\n\
            DataType=0x0006\nAccessType=rw\nDefaultValue=10\nLowLimit=1\nHighLimit=1000\nPDOMapping=0\n";
        assert!(jn2101().contains(expected));
    }
}
