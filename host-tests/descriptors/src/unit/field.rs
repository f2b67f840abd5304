//! The numbers and texts that are the identity of a product, and which of their values it takes.

use plumbline::model::catalog::{Product, Protocol};
use plumbline::store::unit::NAME;
use plumbline::store::{Name, Unit};

/// A part of the identity of a product.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Field {
    /// Its key in a sheet.
    pub key: &'static str,
    /// The object or attribute in which the sensor has it.
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

const J1939: [Field; 1] = [field("serial", "identity number of the NAME", ANY)];

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
        Protocol::J1939(_) => J1939.to_vec(),
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
    /// A number, decimal or hexadecimal.
    Number(i64),
    /// A text in quotation marks.
    Text(String),
}

impl Field {
    /// Checks a value and stores it in a unit.
    pub(super) fn set(&self, unit: &mut Unit, value: &Value) -> Result<(), String> {
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
