//! An Electronic Data Sheet (ODVA, volume 1 chapter 7) of a DeviceNet product, generated from its tables.
//!
//! Every attribute of the objects of the vendor has a parameter entry, except constants. Limits and default values are those at the
//! factory values of the other attributes.

use crate::number::Number;
use crate::{description, notice};
use plumbline::devicenet::{Assembly, Attribute, Object, Source};
use plumbline::model::catalog::Product;
use plumbline::model::listing::devicenet::Tables;
use plumbline::param::{DataType, Meaning, Parameter};
use std::fmt::Write;

/// Month, day, year. The date is fixed, so that the same table always gives the same file.
const DATE: &str = "11-23-2026";
const TIME: &str = "12:00:00";
/// The revision of the file.
const REVISION: &str = "1.1";

/// The types of I/O connections in the section `IO_Info`.
const POLL: u16 = 1;
const COS: u16 = 4;
const CYCLIC: u16 = 8;

/// Bits of the descriptor of a parameter.
const ENUMERATED: u16 = 1 << 1;
const READ_ONLY: u16 = 1 << 4;
const MONITOR: u16 = 1 << 5;

/// Descriptor of the class of parameters: they are in nonvolatile memory. The other bits are 0: the device has no parameter objects.
const STORED: u16 = 1 << 3;

/// The longest name of a parameter.
const NAME: usize = 32;

/// Short forms of words in names that are too long.
const SHORT: [(&str, &str); 3] = [
    ("operating parameter", "operating param."),
    ("Differential", "Diff."),
    ("Weighting factor", "Weight factor"),
];

/// A name with at most [`NAME`] characters.
fn short(name: &str) -> String {
    let mut short = name.to_owned();
    for (word, form) in SHORT {
        if short.len() > NAME {
            short = short.replace(word, form);
        }
    }
    assert!(short.len() <= NAME, "{name}: more than {NAME} characters");
    short
}

/// An attribute with its description in the tables of the product.
#[derive(Clone, Debug)]
pub struct Described<'a> {
    pub object: &'a Object,
    pub attribute: &'a Attribute,
    pub number: Number,
    /// The parameter of the attribute; None for a published value and a constant.
    pub parameter: Option<&'a Parameter>,
}

impl<'a> Described<'a> {
    /// All attributes of the objects of the vendor.
    pub fn all(product: &'a Product, tables: &'a Tables) -> Vec<Self> {
        let attributes = tables.objects.iter().flat_map(|object| {
            let attributes = object.attributes.iter();
            attributes.map(move |attribute| (object, attribute))
        });
        attributes
            .map(|(object, attribute)| Self::of(product, object, attribute))
            .collect()
    }

    fn of(product: &'a Product, object: &'a Object, attribute: &'a Attribute) -> Self {
        let (number, parameter) = match attribute.source {
            Source::Parameter(id) => {
                let parameter = &product.parameters[usize::from(id.0)];
                (Number::from(parameter), Some(parameter))
            }
            Source::Value(id) => (Number::from(&product.quantities[usize::from(id.0)]), None),
            Source::Constant(data_type, _) | Source::Own(data_type) => {
                (Number::any(attribute.name, data_type), None)
            }
        };
        Self {
            object,
            attribute,
            number,
            parameter,
        }
    }

    /// The factory value; None for a published value.
    pub fn factory(&self) -> Option<i64> {
        let raw = match (self.attribute.source, self.parameter) {
            (Source::Constant(_, number), _) => number,
            (_, parameter) => parameter?.factory,
        };
        Some(self.number.data_type.value(raw))
    }

    fn is_constant(&self) -> bool {
        matches!(self.attribute.source, Source::Constant(..))
    }

    /// Whether the named values are all values from the minimum on.
    fn is_sequence(&self) -> bool {
        let (low, _) = self.number.limits;
        let numbers = self.number.meanings.iter();
        numbers
            .zip(low..)
            .all(|((number, _), expected)| i64::from(*number) == expected)
    }

    fn descriptor(&self) -> u16 {
        let bit = |bit: u16, set: bool| if set { bit } else { 0 };
        bit(ENUMERATED, !self.number.meanings.is_empty())
            | bit(READ_ONLY, !self.attribute.settable)
            | bit(MONITOR, matches!(self.attribute.source, Source::Value(_)))
    }
}

/// The data sheet of a product.
pub fn eds(product: &Product, tables: &Tables) -> String {
    let described = Described::all(product, tables);
    let parameters: Vec<_> = described.iter().filter(|it| !it.is_constant()).collect();
    let mut text = String::new();
    comments(&mut text, product, tables);
    file(&mut text, product, tables);
    device(&mut text, tables);
    io_info(&mut text, product, tables);
    section(&mut text, "ParamClass");
    entry(&mut text, "MaxInst", parameters.len());
    entry(&mut text, "Descriptor", format!("0x{STORED:04X}"));
    entry(&mut text, "CfgAssembly", 0);
    section(&mut text, "Params");
    for (place, parameter) in (1..).zip(&parameters) {
        param(&mut text, place, parameter);
    }
    section(&mut text, "EnumPar");
    let names = (1..).zip(&parameters);
    for (place, parameter) in names.filter(|(_, it)| it.is_sequence()) {
        let names = parameter.number.meanings.iter();
        let names: Vec<_> = names.map(|(_, name)| quoted(name)).collect();
        if !names.is_empty() {
            entry(&mut text, &format!("Param{place}"), names.join(", "));
        }
    }
    text.replace('\n', "\r\n")
}

fn comments(text: &mut String, product: &Product, tables: &Tables) {
    for line in notice(product, tables.article.name) {
        writeln!(text, "$ {line}").unwrap();
    }
    text.push_str("$ Written from the tables of the firmware. Do not edit.\n");
}

fn file(text: &mut String, product: &Product, tables: &Tables) {
    section(text, "File");
    let description = description(product, tables.article.name);
    entry(text, "DescText", quoted(&description));
    for what in ["Create", "Mod"] {
        entry(text, &format!("{what}Date"), DATE);
        entry(text, &format!("{what}Time"), TIME);
    }
    entry(text, "Revision", REVISION);
}

fn device(text: &mut String, tables: &Tables) {
    let identity = &tables.identity;
    let (major, minor) = identity.revision;
    section(text, "Device");
    entry(text, "VendCode", identity.vendor);
    entry(text, "VendName", quoted(identity.vendor_name));
    entry(text, "ProdType", identity.device_type);
    entry(text, "ProdTypeStr", quoted(identity.device_type_name));
    entry(text, "ProdCode", identity.product_code);
    entry(text, "MajRev", major);
    entry(text, "MinRev", minor);
    entry(text, "ProdName", quoted(identity.name));
    entry(text, "Catalog", quoted(identity.catalog));
    section(text, "Device Classification");
    entry(text, "Class1", "DeviceNet");
}

/// The I/O connections with the assemblies.
fn io_info(text: &mut String, product: &Product, tables: &Tables) {
    let default = |id: plumbline::param::ParameterId| {
        let instance = product.parameters[usize::from(id.0)].factory;
        let is = |assembly: &Assembly| u32::from(assembly.instance) == instance;
        let place = tables.assemblies.iter().position(is);
        place.expect("the factory value is an assembly") + 1
    };
    let polled = default(tables.roles.polled_assembly);
    let cyclic = default(tables.roles.cyclic_assembly);
    section(text, "IO_Info");
    entry(text, "Default", format!("0x{POLL:04X}"));
    for (name, beside, input) in [
        ("PollInfo", POLL | COS | CYCLIC, polled),
        // COS and cyclic share a connection.
        ("COSInfo", POLL | COS, cyclic),
        ("CyclicInfo", POLL | CYCLIC, cyclic),
    ] {
        entry(text, name, format!("0x{beside:04X}, {input}, 0"));
    }
    let all = POLL | COS | CYCLIC;
    for (place, assembly) in (1..).zip(tables.assemblies) {
        let (size, name) = (assembly.size(), quoted(assembly.name));
        let path = assembly.path().map(|byte| format!("{byte:02X}"));
        let (length, path) = (path.len(), quoted(&path.join(" ")));
        let input = format!("{size}, 0, 0x{all:04X}, {name}, {length}, {path}, \"\"");
        entry(text, &format!("Input{place}"), input);
    }
}

fn param(text: &mut String, place: usize, described: &Described) {
    let Described {
        object,
        attribute,
        number,
        ..
    } = described;
    let path = format!("20 {:02X} 24 01 30 {:02X}", object.class, attribute.number);
    let (low, high) = number.limits;
    let fields = [
        "0".to_owned(),
        "6".to_owned(),
        quoted(&path),
        format!("0x{:04X}", described.descriptor()),
        format!("0x{:02X}", data_type(number.data_type)),
        number.data_type.size().to_string(),
        quoted(&short(number.name)),
        quoted(number.unit),
        quoted(attribute.help),
        low.to_string(),
        high.to_string(),
        described.factory().unwrap_or(0).to_string(),
        // Multiplier, divisor, base, offset; then a link for each; then the decimals.
        "1, 1, 1, 0".to_owned(),
        "0, 0, 0, 0".to_owned(),
        number.decimals.to_string(),
    ];
    entry(text, &format!("Param{place}"), fields.join(", "));
    if !described.is_sequence() {
        let value = |(number, name): &Meaning| format!("{number}, {}", quoted(name));
        let values: Vec<_> = number.meanings.iter().map(value).collect();
        entry(text, &format!("Enum{place}"), values.join(", "));
    }
}

/// The code of an elementary type.
fn data_type(data_type: DataType) -> u8 {
    match data_type {
        DataType::I8 => 0xC2,
        DataType::I64 => 0xC5,
        DataType::U64 => 0xC9,
        DataType::Real32 => 0xCA,
        DataType::Real64 => 0xCB,
        DataType::I16 => 0xC3,
        DataType::I32 => 0xC4,
        DataType::U8 => 0xC6,
        DataType::U16 => 0xC7,
        DataType::U32 => 0xC8,
        DataType::Text => 0xDA,
    }
}

fn quoted(text: &str) -> String {
    assert!(text.is_ascii() && !text.contains(['"', '\\']), "{text}");
    format!("\"{text}\"")
}

fn section(text: &mut String, name: &str) {
    writeln!(text, "\n[{name}]").unwrap();
}

fn entry(text: &mut String, key: &str, value: impl std::fmt::Display) {
    writeln!(text, "        {key} = {value};").unwrap();
}

#[cfg(test)]
mod tests {
    use crate::describe;
    use plumbline::model::catalog::find;

    fn sheet(name: &str) -> String {
        let file = describe(find(name).unwrap());
        assert_eq!(file.name, format!("{name}.eds"));
        file.text.replace("\r\n", "\n")
    }

    #[test]
    fn resolution_has_its_values_behind_its_entry() {
        let expected = "Param1 = 0, 6, \"20 65 24 01 30 71\", 0x0002, 0xC7, 2, \"Resolution\", \"0.001 deg\", \
            \"A change converts all numbers with this unit\", 10, 1000, 10, 1, 1, 1, 0, 0, 0, 0, 0, 0;\n        \
            Enum1 = 10, \"0.01 deg\", 100, \"0.1 deg\", 1000, \"1 deg\";\n";
        assert!(sheet("tiltix080").contains(expected));
        assert!(!sheet("tiltix080").contains("[EnumPar]\n        Param1 ="));
    }

    #[test]
    fn slopes_have_the_type_of_the_model() {
        let expected = |data_type: &str, low: i32, high: i32| {
            format!(
                "Param2 = 0, 6, \"20 65 24 01 30 72\", 0x0030, {data_type}, 2, \"Slope long16\", \"\", \
                \"In units of the resolution\", {low}, {high}, 0, 1, 1, 1, 0, 0, 0, 0, 0, 0;\n"
            )
        };
        assert!(sheet("tiltix080").contains(&expected("0xC3", -32768, 32767)));
        assert!(sheet("tiltix360").contains(&expected("0xC7", 0, 35999)));
    }

    #[test]
    fn assembly_103_is_the_default_input() {
        let text = sheet("tiltix360");
        assert!(text.contains(
            "[IO_Info]\n        Default = 0x0001;\n        PollInfo = 0x000D, 3, 0;\n        COSInfo = 0x0005, 3, 0;\n        \
            CyclicInfo = 0x0009, 3, 0;\n"
        ));
        assert!(text.contains(
            "Input3 = 4, 0, 0x000D, \"Slope long16, slope lateral16\", 6, \"20 04 24 67 30 03\", \"\";\n"
        ));
    }

    #[test]
    fn named_values_without_gaps_are_counted_from_the_minimum() {
        let text = sheet("tiltix080");
        let (_, names) = text.split_once("[EnumPar]\n").unwrap();
        assert!(names.contains(
            "Param17 = \"slope long16\", \"slope lateral16\", \"slope long16, slope lateral16\";\n"
        ));
    }
}
