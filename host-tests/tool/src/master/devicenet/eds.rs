//! The data sheet of a DeviceNet device (ODVA): sections with entries that end with a semicolon. A comment is from `$` to the end of the
//! line.
//!
//! ```text
//! Param1 = 0, 6, "20 65 24 01 30 71", 0x0002, 0xC7, 2, "Resolution", "0.001 deg", "help", 10, 1000, 10, 1,1,1,0, 0,0,0,0, 0;
//!          -  -  path                 flags   type  size  name        unit         help   low high default  scale   links  decimals
//! ```

mod fields;
mod identity;

use crate::eds::{
    DECIMALS, Draft, Factor, Format, GREATEST, MOST, NO_ARTICLE, NO_PARAMETER, Parts, Texts, entry,
    number, too_many,
};
use crate::error::Fault;
use crate::sheet::rows::Row;
use crate::sheet::{Address, Entry};
use fields::{Fields, fields};
use plumbline::devicenet::{Identity, Roles};
use plumbline::model::catalog::Protocol;
use plumbline::model::listing::devicenet::Tables;
use plumbline::param::{DataType, Permitted};
use texts::{SHOWN, shown};

/// The flags of a parameter: its scale can be in other parameters; it can only be read; it is a measured value; the decimals are a part of its
/// scale.
const LINKS: i64 = 1 << 3;
const READ_ONLY: i64 = 1 << 4;
const MONITOR: i64 = 1 << 5;
const PRECISION: i64 = 1 << 6;

pub(super) const FORMAT: Format = Format {
    name: "DeviceNet",
    is_own: Some(is_devicenet),
    parts,
    values: identity::values,
    identity: [(identity(1), DataType::U16), (identity(3), DataType::U16)],
};

/// An attribute of the identity object.
const fn identity(attribute: u8) -> Address {
    Address::Attribute {
        class: 1,
        instance: 1,
        attribute,
    }
}

/// Whether a file has the sections of this format.
fn is_devicenet(text: &str) -> bool {
    text.lines().any(|line| {
        let line = line.trim().to_ascii_lowercase();
        line.starts_with("[params]") || line.starts_with("[device]")
    })
}

/// The parts of the sheet.
fn parts(text: &str) -> Result<Parts, Fault> {
    let (fields, ignored) = fields(text)?;
    let device = |key: &str| {
        let fields = fields.get(&("device".to_owned(), key.to_owned()))?;
        fields.first().map(String::as_str)
    };
    let (mut rows, mut left_out) = (Vec::new(), 0);
    let mut places: Vec<usize> = fields
        .keys()
        .filter(|(section, _)| section == "params")
        .filter_map(|(_, key)| key.strip_prefix("param")?.parse().ok())
        .collect();
    places.sort_unstable();
    places.dedup();
    if places.len() > MOST {
        return Err(too_many());
    }
    for place in places {
        match parameter(&fields, place) {
            Some((entry, texts)) => {
                let group = String::new();
                rows.push(Draft {
                    row: Row { group, entry },
                    texts: Some(texts),
                });
            }
            None => left_out += 1,
        }
    }
    let identity = ["vendcode", "prodcode"].map(|key| {
        let number = number(device(key)?)?;
        u32::try_from(number).ok()
    });
    Ok(Parts {
        name: device("prodname").unwrap_or_default().to_owned(),
        maker: device("vendname").unwrap_or_default().to_owned(),
        protocol: protocol(),
        identity,
        rows,
        left_out,
        ignored,
    })
}

/// A parameter as an entry; None if its type or path is not known.
fn parameter(all: &Fields, place: usize) -> Option<(Entry, Texts)> {
    let fields = all.get(&("params".to_owned(), format!("param{place}")))?;
    let text = |place: usize| fields.get(place).map_or("", String::as_str);
    let integer = |place: usize| number(text(place));
    let data_type = match integer(4)? {
        // The codes of CIP, then the codes of the parameter object of DeviceNet.
        0xC1 | 0xC6 | 0xD1 | 4 | 8 => DataType::U8,
        0xC7 | 0xD2 | 1 | 2 => DataType::U16,
        0xC8 | 0xD3 | 9 => DataType::U32,
        0xC2 | 5 => DataType::I8,
        0xC3 | 3 => DataType::I16,
        0xC4 | 6 => DataType::I32,
        _ => return None,
    };
    let flags = integer(3)?;
    let writable = flags & READ_ONLY == 0;
    let mask = u32::MAX >> (32 - 8 * u32::from(data_type.size()));
    let (least, most) = data_type.range();
    let within = |number: &i64| (least..=most).contains(number);
    let limits = (integer(9).filter(within), integer(10).filter(within));
    let meanings = meanings(all, place, limits.0.unwrap_or(0), mask);
    let permitted = match limits {
        _ if !meanings.is_empty() => Permitted::Named,
        (Some(low), Some(high)) if low < high => Permitted::Range(low, high),
        _ => Permitted::Any,
    };
    let address = path(text(2), place)?;
    // The unit belongs to the scaled value, so a number without a known scale has no unit.
    let (scale, unit, title) = match factor(fields, flags) {
        Some(factor) => (factor, shown(text(7)), text(6).to_owned()),
        None => (Factor::ONE, String::new(), raw_title(text(6))),
    };
    let texts = Texts {
        unit,
        scale,
        meanings,
    };
    let entry = Entry {
        permitted,
        factory: integer(11)
            .filter(within)
            .map(|number| number as u32 & mask),
        writable,
        stored: writable,
        command: flags & MONITOR != 0,
        ..entry(&title, address, data_type)
    };
    Some((entry, texts))
}

/// The address in a path: class, instance and attribute, each in one byte. Without a path it is attribute 1 of the parameter object.
fn path(text: &str, place: usize) -> Option<Address> {
    let mut bytes = Vec::new();
    for part in text.split_whitespace() {
        bytes.push(u8::from_str_radix(part, 16).ok()?);
    }
    let (class, instance, attribute) = match bytes[..] {
        [] => (0x0F, u8::try_from(place).ok()?, 1),
        [0x20, class, 0x24, instance, 0x30, attribute] => (class, instance, attribute),
        _ => return None,
    };
    Some(Address::Attribute {
        class,
        instance,
        attribute,
    })
}

/// The names of numbers: pairs in `Enum1`, or one after the other from the minimum in the section `EnumPar`.
fn meanings(all: &Fields, place: usize, low: i64, mask: u32) -> Vec<(u32, String)> {
    if let Some(pairs) = all.get(&("params".to_owned(), format!("enum{place}"))) {
        let pairs = pairs.chunks_exact(2).filter_map(|pair| {
            let number = number(&pair[0])?;
            Some((number as u32 & mask, shown(&pair[1])))
        });
        return pairs.collect();
    }
    let names = all.get(&("enumpar".to_owned(), format!("param{place}")));
    let names = names.map_or(&[][..], Vec::as_slice);
    let numbered = (low..).zip(names.iter().filter(|name| !name.is_empty()));
    numbered
        .map(|(number, name)| (number as u32 & mask, shown(name)))
        .collect()
}

/// The title of a parameter that is shown as the number of the protocol.
fn raw_title(title: &str) -> String {
    let title: String = shown(title).chars().take(SHOWN - 6).collect();
    format!("{title} (raw)")
}

/// The factor of a parameter: value = (number + offset) x multiplier x base / divisor. None if it has an offset, is no power of ten below,
/// or depends on other parameters by its links.
///
/// The decimals are the digits that are shown. They are a part of the factor with [`PRECISION`], and also if the file has no other one,
/// because many files give only them.
fn factor(fields: &[String], flags: i64) -> Option<Factor> {
    // A field that is empty or missing has its default; one that is no number is not known.
    let field = |place: usize, default: i64| match fields.get(place).map(String::as_str) {
        None | Some("") => Some(default),
        Some(text) => number(text),
    };
    let has_link = (16..20).any(|place| field(place, flags & LINKS) != Some(0));
    if has_link || field(15, 0)? != 0 {
        return None;
    }
    let multiplier = field(12, 1)?.checked_mul(field(14, 1)?)?;
    let divisor = field(13, 1)?;
    let mut powers = (0..=DECIMALS).map(|power| (power, 10_i64.pow(power.into())));
    let (power, _) = powers.find(|(_, power)| *power == divisor)?;
    let digits = u8::try_from(field(20, 0)?).ok()?;
    let decimals = match (multiplier, divisor) {
        (1, 1) => digits,
        _ if flags & PRECISION != 0 => power.checked_add(digits)?,
        _ => power,
    };
    let is_shown = (1..=GREATEST).contains(&multiplier) && decimals <= DECIMALS;
    is_shown.then_some(Factor {
        multiplier,
        decimals,
    })
}

/// The tables of a device of which only the data sheet is known.
fn protocol() -> Protocol {
    Protocol::Devicenet(Tables {
        article: NO_ARTICLE,
        identity: Identity {
            vendor: 0,
            vendor_name: "",
            device_type: 0,
            device_type_name: "",
            product_code: 0,
            revision: (0, 0),
            name: "",
            catalog: "",
        },
        roles: Roles {
            mac_id: NO_PARAMETER,
            baud_rate: NO_PARAMETER,
            bit_rates: &[],
            bus_off_interrupt: NO_PARAMETER,
            polled_assembly: NO_PARAMETER,
            cyclic_assembly: NO_PARAMETER,
            cos_delta: NO_PARAMETER,
        },
        objects: &[],
        assemblies: &[],
    })
}
