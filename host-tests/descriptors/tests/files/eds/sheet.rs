//! A parser for Electronic Data Sheets.

use ini::{Ini, ParseOption};
use std::collections::BTreeMap;

/// The sections of a data sheet with their entries, in order, with duplicates.
pub struct Sheet {
    pub sections: Vec<(String, Vec<(String, String)>)>,
}

/// The index and the sub-index of an object.
pub type Address = (u16, u8);

/// An object or sub-index that can be read or written.
#[derive(Clone, Debug)]
pub struct Variable {
    pub section: String,
    pub address: Address,
    pub data_type: DataType,
    pub access: String,
    pub default: Option<String>,
    pub low: Option<i64>,
    pub high: Option<i64>,
    pub mappable: bool,
}

/// The types of CiA 301, table 44, that a sensor may use.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum DataType {
    Unsigned(u32),
    Signed(u32),
    Real(u32),
    Text,
}

impl DataType {
    /// The type with this index.
    pub fn of(code: i64) -> Option<Self> {
        Some(match code {
            0x0002 => Self::Signed(8),
            0x0003 => Self::Signed(16),
            0x0004 => Self::Signed(32),
            0x0005 => Self::Unsigned(8),
            0x0006 => Self::Unsigned(16),
            0x0007 => Self::Unsigned(32),
            0x0008 => Self::Real(32),
            0x0009 => Self::Text,
            0x0011 => Self::Real(64),
            0x0015 => Self::Signed(64),
            0x001B => Self::Unsigned(64),
            _ => return None,
        })
    }

    /// The length of a number; 0 for a text.
    pub fn bits(self) -> u32 {
        match self {
            Self::Unsigned(bits) | Self::Signed(bits) | Self::Real(bits) => bits,
            Self::Text => 0,
        }
    }

    pub fn bytes(self, number: i64) -> Vec<u8> {
        number.to_le_bytes()[..self.bits() as usize / 8].to_vec()
    }

    /// The lowest and the highest number.
    pub fn limits(self) -> [i64; 2] {
        match self {
            Self::Unsigned(64) => [0, i64::MAX],
            Self::Signed(64) | Self::Real(_) => [i64::MIN, i64::MAX],
            Self::Unsigned(bits) => [0, (1 << bits) - 1],
            Self::Signed(bits) => [-(1 << (bits - 1)), (1 << (bits - 1)) - 1],
            Self::Text => [0, 0],
        }
    }
}

impl Sheet {
    pub fn parse(text: &str) -> Self {
        let plain = ParseOption {
            enabled_quote: false,
            enabled_escape: false,
            ..ParseOption::default()
        };
        let ini = Ini::load_from_str_opt(text, plain).expect("an ini file");
        let sections = ini.iter().filter_map(|(name, entries)| {
            let entries = entries
                .iter()
                .map(|(key, value)| (key.to_owned(), value.to_owned()))
                .collect();
            Some((name?.to_owned(), entries))
        });
        Self {
            sections: sections.collect(),
        }
    }

    /// The first entry with this name in the first section with this name.
    pub fn get(&self, section: &str, key: &str) -> Option<&str> {
        let (_, entries) = self.sections.iter().find(|(name, _)| name == section)?;
        let (_, value) = entries.iter().find(|(name, _)| name == key)?;
        Some(value)
    }

    pub fn number(&self, section: &str, key: &str) -> Option<i64> {
        number(self.get(section, key)?)
    }

    /// The indices of the sections of objects.
    pub fn indices(&self) -> Vec<u16> {
        let is_object = |name: &&String| name.len() == 4;
        self.sections
            .iter()
            .map(|(name, _)| name)
            .filter(is_object)
            .filter_map(|name| u16::from_str_radix(name, 16).ok())
            .collect()
    }

    /// The sections of the sub-indices of an object.
    pub fn subs(&self, index: u16) -> BTreeMap<u8, String> {
        let prefix = format!("{index:04X}sub");
        self.sections
            .iter()
            .filter_map(|(name, _)| {
                let sub = u8::from_str_radix(name.strip_prefix(&prefix)?, 16).ok()?;
                Some((sub, name.clone()))
            })
            .collect()
    }

    /// Everything that can be read or written; variables with an incomplete description are missing.
    pub fn variables(&self) -> Vec<Variable> {
        let mut variables = Vec::new();
        for index in self.indices() {
            let object = format!("{index:04X}");
            let subs = match self.number(&object, "ObjectType") {
                Some(8 | 9) => self.subs(index),
                _ => BTreeMap::from([(0, object)]),
            };
            let found = subs
                .iter()
                .filter_map(|(sub, section)| self.variable((index, *sub), section));
            variables.extend(found);
        }
        variables
    }

    fn variable(&self, address: Address, section: &str) -> Option<Variable> {
        Some(Variable {
            section: section.to_owned(),
            address,
            data_type: DataType::of(self.number(section, "DataType")?)?,
            access: self.get(section, "AccessType")?.to_owned(),
            default: self.get(section, "DefaultValue").map(str::to_owned),
            low: self.number(section, "LowLimit"),
            high: self.number(section, "HighLimit"),
            mappable: self.number(section, "PDOMapping")? != 0,
        })
    }
}

impl Variable {
    /// The factory value of a sensor with this node id.
    pub fn default_at(&self, node_id: i64) -> Option<i64> {
        let text = self.default.as_deref()?;
        match text.strip_prefix("$NODEID+") {
            Some(base) => Some(number(base)? + node_id),
            None => number(text),
        }
    }
}

/// A number in CiA 306 format: decimal or hexadecimal.
pub fn number(text: &str) -> Option<i64> {
    match text.strip_prefix("0x") {
        Some(digits) => i64::from_str_radix(digits, 16).ok(),
        None => text.parse().ok(),
    }
}
