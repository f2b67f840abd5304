//! The identity of a unit as a sheet of values, and the numbers and texts that a product can have.
//!
//! ```text
//! product = "tiltix080"
//! vendor = 354
//! device-type = 0
//! product-code = 8
//! revision = "1.2"
//! serial = 0x00A1B2C3
//! name = "INCLINOMETER 080 degree"
//! ```
//!
//! A sheet is TOML without sections. Everything but the product is optional: what is not there stays as the product has it.

use plumbline::canopen::dictionary::{Object, Target};
use plumbline::model::catalog::{Product, Protocol, find};
use plumbline::store::unit::NAME;
use plumbline::store::{Name, Unit};

/// What a sheet can contain besides the product.
pub const KEYS: [&str; 9] = [
    "vendor",
    "device-type",
    "product-code",
    "revision",
    "serial",
    "article",
    "name",
    "hardware-version",
    "software-version",
];

/// A part of the identity of a product.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Field {
    /// Its key in a sheet.
    pub key: &'static str,
    /// Where the sensor has it.
    pub place: &'static str,
    kind: Kind,
}

#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Kind {
    /// A number from the first to the second one.
    Number(u32, u32),
    /// Major and minor revision (DeviceNet).
    Revision,
    /// A number of digits, also written as an article number.
    Article,
    /// A text that must not contain this character.
    Text(Option<char>),
}

const ANY: Kind = Kind::Number(0, u32::MAX);
const WORD: Kind = Kind::Number(0, u16::MAX as u32);
const POSITIVE_WORD: Kind = Kind::Number(1, u16::MAX as u32);

const fn field(key: &'static str, place: &'static str, kind: Kind) -> Field {
    Field { key, place, kind }
}

const CANOPEN: [Field; 4] = [
    field("vendor", "1018h:01", Kind::Number(1, u32::MAX)),
    field("product-code", "1018h:02", ANY),
    field("revision", "1018h:03", ANY),
    field("serial", "1018h:04", ANY),
];

/// The texts of CANopen: index, key and place.
const TEXTS: [(u16, &str, &str); 3] = [
    (0x1008, "name", "1008h"),
    (0x1009, "hardware-version", "1009h"),
    (0x100A, "software-version", "100Ah"),
];

const DEVICENET: [Field; 6] = [
    field("vendor", "attribute 1 of class 1", POSITIVE_WORD),
    field("device-type", "attribute 2 of class 1", WORD),
    field("product-code", "attribute 3 of class 1", POSITIVE_WORD),
    field("revision", "attribute 4 of class 1", Kind::Revision),
    field("serial", "attribute 6 of class 1", ANY),
    field("name", "attribute 7 of class 1", Kind::Text(None)),
];

const FSC: [Field; 3] = [
    field("article", "code 03h", Kind::Article),
    field("revision", "code 03h", WORD),
    field("serial", "code 04h", ANY),
];

/// The identity of a product, in the order of a sheet.
pub fn fields(product: &Product) -> Vec<Field> {
    match &product.protocol {
        Protocol::Fsc(_) => FSC.to_vec(),
        Protocol::Devicenet(_) => DEVICENET.to_vec(),
        Protocol::Canopen(tables) => {
            // In the identification of J1939 it ends a field.
            let excluded = tables.j1939.is_some().then_some('*');
            let has = |index: u16| tables.objects.iter().any(|object| object.index == index);
            let texts = TEXTS.iter().filter(|(index, ..)| has(*index));
            let texts = texts.map(|(_, key, place)| field(key, place, Kind::Text(excluded)));
            CANOPEN.into_iter().chain(texts).collect()
        }
    }
}

/// A value of a sheet.
#[derive(Clone, PartialEq, Eq, Debug)]
pub enum Value {
    /// A number.
    Number(i64),
    /// A text.
    Text(String),
}

/// A sheet of values that are not checked yet.
#[derive(Clone, Debug, Default)]
pub struct Sheet {
    /// The product in it.
    pub product: Option<&'static Product>,
    /// The values by their keys.
    pub values: Vec<(&'static str, Value)>,
}

impl Sheet {
    /// Reads a sheet.
    ///
    /// # Errors
    /// One sentence: it is no sheet, or a key or product is unknown.
    pub fn parse(text: &str) -> Result<Self, String> {
        let table: toml::Table = text.parse().map_err(|error: toml::de::Error| {
            let line = error
                .span()
                .map_or(1, |span| 1 + text[..span.start].matches('\n').count());
            format!("line {line}: {}", error.message())
        })?;
        let mut sheet = Self::default();
        for (key, value) in table {
            if key == "product" {
                let name = value.as_str().unwrap_or_default();
                let product = find(name).ok_or_else(|| format!("there is no product {value}"))?;
                sheet.product = Some(product);
                continue;
            }
            let own = KEYS.iter().find(|own| **own == key).ok_or_else(|| {
                format!("{key} is unknown: a sheet has product, {}", KEYS.join(", "))
            })?;
            let value = match value {
                toml::Value::Integer(number) => Value::Number(number),
                toml::Value::String(text) => Value::Text(text),
                other => return Err(format!("{key} = {other} is neither a number nor a text")),
            };
            sheet.values.push((own, value));
        }
        Ok(sheet)
    }

    /// The identity of a unit of this product.
    ///
    /// # Errors
    /// One sentence that names the key, the value and what the product takes.
    pub fn unit(&self, product: &Product) -> Result<Unit, String> {
        if let Some(own) = self.product.filter(|own| own.name != product.name) {
            return Err(format!(
                "the sheet is for {}, not for {}",
                own.name, product.name
            ));
        }
        let fields = fields(product);
        let mut unit = Unit::NONE;
        for (key, value) in &self.values {
            let field = fields.iter().find(|field| field.key == *key);
            let field = field.ok_or_else(|| {
                let own: Vec<&str> = fields.iter().map(|field| field.key).collect();
                format!("{} has no {key}: it has {}", product.name, own.join(", "))
            })?;
            field.set(&mut unit, value)?;
        }
        Ok(unit)
    }
}

impl Field {
    /// Checks a value and gives it to a unit.
    fn set(&self, unit: &mut Unit, value: &Value) -> Result<(), String> {
        let refused = |limit: &str| {
            let shown = match value {
                Value::Number(number) => number.to_string(),
                Value::Text(text) => format!("{text:?}"),
            };
            format!("{} = {shown}: {} takes {limit}", self.key, self.place)
        };
        match self.kind {
            Kind::Text(excluded) => {
                let own = match value {
                    Value::Text(text) => Name::new(text),
                    Value::Number(_) => None,
                };
                let is_excluded =
                    |name: &Name| excluded.is_some_and(|own| name.text().contains(own));
                let limit = match excluded {
                    Some(own) => format!(" without {own}"),
                    None => String::new(),
                };
                let limit = format!("a text of 1 to {NAME} characters of ASCII{limit}");
                let name = own
                    .filter(|name| !is_excluded(name))
                    .ok_or_else(|| refused(&limit))?;
                match self.key {
                    "name" => unit.name = Some(name),
                    "hardware-version" => unit.hardware = Some(name),
                    _ => unit.software = Some(name),
                }
            }
            Kind::Number(low, high) => {
                let limit = format!("{low} to {high}");
                let number = match value {
                    Value::Number(number) => u32::try_from(*number).ok(),
                    Value::Text(_) => None,
                };
                let number = number.filter(|number| (low..=high).contains(number));
                self.set_number(unit, number.ok_or_else(|| refused(&limit))?);
            }
            Kind::Revision => {
                let number = revision(value);
                let limit = "\"MAJOR.MINOR\" with a major revision of 1 to 127 and a minor revision of 1 to 255";
                self.set_number(unit, number.ok_or_else(|| refused(limit))?);
            }
            Kind::Article => {
                let limit =
                    "the 1 to 9 digits of an article number, such as 2305430 or \"PR-23054-30\"";
                self.set_number(unit, article(value).ok_or_else(|| refused(limit))?);
            }
        }
        Ok(())
    }

    fn set_number(&self, unit: &mut Unit, number: u32) {
        match self.key {
            "vendor" => unit.vendor = Some(number),
            // The limits of the field are those of its type.
            "device-type" => unit.device_type = Some(number as u16),
            "product-code" => unit.product_code = Some(number),
            "revision" => unit.revision = Some(number),
            "serial" => unit.serial = Some(number),
            _ => unit.article = Some(number),
        }
    }

    /// The value of a unit as a sheet has it; None if it is not given.
    pub fn shown(&self, unit: &Unit) -> Option<String> {
        let shown = match self.value(unit)? {
            Value::Number(number) => number.to_string(),
            Value::Text(text) => toml::Value::String(text).to_string(),
        };
        Some(shown)
    }

    /// The value of a unit; None if it is not given.
    pub fn value(&self, unit: &Unit) -> Option<Value> {
        let text = |name: Option<Name>| name.map(|name| Value::Text(name.text().to_owned()));
        let number = match self.key {
            "vendor" => unit.vendor,
            "device-type" => unit.device_type.map(u32::from),
            "product-code" => unit.product_code,
            "revision" => unit.revision,
            "serial" => unit.serial,
            "article" => unit.article,
            "name" => return text(unit.name),
            "hardware-version" => return text(unit.hardware),
            _ => return text(unit.software),
        };
        number.map(|number| match self.kind {
            Kind::Revision => Value::Text(format!("{}.{}", number >> 8, number & 0xFF)),
            _ => Value::Number(number.into()),
        })
    }
}

/// Major and minor revision of DeviceNet as one number.
fn revision(value: &Value) -> Option<u32> {
    let (major, minor) = match value {
        Value::Number(number) => (number >> 8, number & 0xFF),
        Value::Text(text) => {
            let (major, minor) = text.split_once('.')?;
            (major.parse().ok()?, minor.parse().ok()?)
        }
    };
    let is_valid = (1..=127).contains(&major) && (1..=255).contains(&minor);
    is_valid.then_some((major << 8 | minor) as u32)
}

/// The digits of an article number.
fn article(value: &Value) -> Option<u32> {
    let number = match value {
        Value::Number(number) => *number,
        Value::Text(text) => {
            let is_part = |letter: char| letter == '-' || letter.is_ascii_uppercase();
            if !text
                .chars()
                .all(|letter| is_part(letter) || letter.is_ascii_digit())
            {
                return None;
            }
            text.replace(is_part, "").parse().ok()?
        }
    };
    u32::try_from(number)
        .ok()
        .filter(|number| (1..1_000_000_000).contains(number))
}

/// The sheet of a unit of a product.
pub fn sheet(product: &Product, unit: &Unit) -> String {
    let mut text = format!(
        "# The identity of a unit: `plumbline identity --from` and `descriptors --unit` take it. A line that is left out\n# stays as the product has it.\nproduct = \"{}\"\n",
        product.name
    );
    for field in fields(product) {
        if let Some(value) = field.shown(unit) {
            text += &format!("{} = {value} # {}\n", field.key, field.place);
        }
    }
    text
}

/// The product with the identity of a unit. Its tables stay until the end of the program.
pub fn with_unit(product: &Product, unit: &Unit) -> Product {
    let mut own = *product;
    match &mut own.protocol {
        Protocol::Fsc(_) => {}
        Protocol::Canopen(tables) => {
            let objects = tables.objects.iter().map(|object| object_of(*object, unit));
            tables.objects = Vec::leak(objects.collect());
        }
        Protocol::Devicenet(tables) => {
            let identity = &mut tables.identity;
            let word = |number: u32| u16::try_from(number).ok();
            identity.vendor = unit.vendor.and_then(word).unwrap_or(identity.vendor);
            identity.device_type = unit.device_type.unwrap_or(identity.device_type);
            let code = unit.product_code.and_then(word);
            identity.product_code = code.unwrap_or(identity.product_code);
            if let Some([_, _, major, minor]) = unit.revision.map(u32::to_be_bytes) {
                identity.revision = (major, minor);
            }
            identity.name = unit.name.map_or(identity.name, leaked);
        }
    }
    own
}

/// An object with the identity of a unit.
fn object_of(object: Object, unit: &Unit) -> Object {
    let number = |number: Option<u32>| number.map(Target::Constant);
    let text = |name: Option<Name>| name.map(|name| Target::Text(leaked(name)));
    let target = match (object.index, object.sub) {
        (0x1018, 1) => number(unit.vendor),
        (0x1018, 2) => number(unit.product_code),
        (0x1018, 3) => number(unit.revision),
        (0x1018, 4) => number(unit.serial),
        (0x1008, 0) => text(unit.name),
        (0x1009, 0) => text(unit.hardware),
        (0x100A, 0) => text(unit.software),
        _ => None,
    };
    Object {
        target: target.unwrap_or(object.target),
        ..object
    }
}

fn leaked(name: Name) -> &'static str {
    String::leak(name.text().to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::describe;

    fn unit_of(name: &str, text: &str) -> Result<Unit, String> {
        Sheet::parse(text)?.unit(find(name).unwrap())
    }

    /// A sheet with everything that the product has.
    const FULL: [(&str, &str); 4] = [
        (
            "is2",
            "product = \"is2\"\narticle = \"PR-23022-20\"\nrevision = 3\nserial = 0xA1B2C3\n",
        ),
        (
            "jn2101",
            "product = \"jn2101\"\nvendor = 0x195\nproduct-code = 0x1234\nrevision = 0x10002\nserial = 77\nname = \"Old one\"\nhardware-version = \"7\"\nsoftware-version = \"8\"\n",
        ),
        (
            "ims360",
            "product = \"ims360\"\nvendor = 1\nproduct-code = 0\nrevision = 0\nserial = 0\nname = \"Old\"\nhardware-version = \"7\"\nsoftware-version = \"8\"\n",
        ),
        (
            "tiltix080",
            "product = \"tiltix080\"\nvendor = 9\ndevice-type = 34\nproduct-code = 12\nrevision = \"3.4\"\nserial = 5\nname = \"Old TILTIX\"\n",
        ),
    ];

    #[test]
    fn sheet_of_a_unit_is_read_as_the_same_unit() {
        for (name, text) in FULL {
            let product = find(name).unwrap();
            let unit = unit_of(name, text).unwrap();
            let own = sheet(product, &unit);
            assert_eq!(unit_of(name, &own), Ok(unit), "{own}");
            let given = fields(product)
                .iter()
                .filter(|field| field.shown(&unit).is_some())
                .count();
            assert_eq!(given, fields(product).len(), "{own}");
        }
        let unit = unit_of("tiltix080", FULL[3].1).unwrap();
        assert_eq!((unit.revision, unit.device_type), (Some(0x304), Some(34)));
        assert_eq!(unit_of("is2", FULL[0].1).unwrap().article, Some(2_302_220));
    }

    #[test]
    fn value_that_does_not_fit_is_refused_with_key_value_and_limit() {
        let long = "x".repeat(33);
        for (name, line, parts) in [
            (
                "jn2101",
                "vendor = 0",
                ["vendor = 0", "1018h:01", "1 to 4294967295"],
            ),
            (
                "jn2101",
                "serial = 4294967296",
                ["serial = 4294967296", "1018h:04", "0 to 4294967295"],
            ),
            (
                "jn2101",
                "revision = -1",
                ["revision = -1", "1018h:03", "0 to 4294967295"],
            ),
            (
                "jn2101",
                "name = 5",
                ["name = 5", "1008h", "1 to 32 characters"],
            ),
            (
                "jn2101",
                "vendor = \"ifm\"",
                ["vendor = \"ifm\"", "1018h:01", "1 to 4294967295"],
            ),
            (
                "ims360",
                "name = \"a*b\"",
                ["name = \"a*b\"", "1008h", "without *"],
            ),
            (
                "tiltix080",
                "product-code = 65536",
                ["product-code = 65536", "attribute 3", "1 to 65535"],
            ),
            (
                "tiltix080",
                "vendor = 0",
                ["vendor = 0", "attribute 1", "1 to 65535"],
            ),
            (
                "tiltix080",
                "device-type = 65536",
                ["device-type = 65536", "attribute 2", "0 to 65535"],
            ),
            (
                "tiltix080",
                "revision = \"128.1\"",
                ["revision = \"128.1\"", "attribute 4", "1 to 127"],
            ),
            (
                "tiltix080",
                "revision = \"1.0\"",
                ["revision = \"1.0\"", "attribute 4", "1 to 255"],
            ),
            (
                "is2",
                "revision = 65536",
                ["revision = 65536", "code 03h", "0 to 65535"],
            ),
            (
                "is2",
                "article = \"IS2\u{e4}\"",
                ["article = ", "code 03h", "1 to 9 digits"],
            ),
            (
                "is2",
                "article = 1000000000",
                ["article = 1000000000", "code 03h", "1 to 9 digits"],
            ),
        ] {
            let error = unit_of(name, line).unwrap_err();
            for part in parts {
                assert!(error.contains(part), "{line}: {error}");
            }
        }
        let error = unit_of("tiltix080", &format!("name = \"{long}\"")).unwrap_err();
        assert!(error.contains("1 to 32 characters"), "{error}");
    }

    #[test]
    fn sheet_with_a_wrong_line_is_refused() {
        for (line, part) in [
            ("vendor 1", "line 1"),
            ("serial = 1\nvendor = ", "line 2"),
            ("producer = 1", "producer is unknown"),
            ("product = \"is9\"", "no product \"is9\""),
            ("product = \"is1\"", "is for is1, not for is2"),
            (
                "vendor = 1",
                "is2 has no vendor: it has article, revision, serial",
            ),
            ("serial = 1.5", "neither a number nor a text"),
            ("[unit]\nserial = 1", "unit is unknown"),
        ] {
            let error = unit_of("is2", line).unwrap_err();
            assert!(error.contains(part), "{line}: {error}");
        }
        assert_eq!(unit_of("is2", ""), Ok(Unit::NONE));
    }

    #[test]
    fn data_sheet_has_the_identity_of_the_unit() {
        let text = |name: &str, sheet: &str| {
            let product = find(name).unwrap();
            describe(&with_unit(product, &unit_of(name, sheet).unwrap()))
                .text
                .replace('\r', "")
        };
        let canopen = text("jn2101", FULL[1].1);
        for part in [
            "VendorNumber=0x00000195\nProductName=Old one\nProductNumber=0x1234\nRevisionNumber=0x10002\n",
            "ParameterName=Vendor ID\nObjectType=0x7\nDataType=0x0007\nAccessType=ro\nDefaultValue=0x195\n",
        ] {
            assert!(canopen.contains(part), "{part}");
        }
        let devicenet = text("tiltix080", FULL[3].1);
        for part in [
            "VendCode = 9;",
            "ProdType = 34;",
            "ProdCode = 12;",
            "MajRev = 3;",
            "MinRev = 4;",
            "ProdName = \"Old TILTIX\";",
        ] {
            let part = part.replace(' ', "");
            assert!(devicenet.replace(' ', "").contains(&part), "{part}");
        }
        // What is not given is that of the product.
        let product = find("jn2101").unwrap();
        assert_eq!(
            text("jn2101", "product = \"jn2101\""),
            describe(product).text.replace('\r', "")
        );
    }
}
