//! Numbers as users read and write them: `2.5Hz`, `1.25deg`, `300h`, `butterworth`, or `raw:2`.
//!
//! A number of the table has a scale: 250 with two decimals in deg is 2.5 deg; 10 in the unit `100 us` is 1000 us. All arithmetic is
//! in integers, so that a value is either exact or refused.

mod scale;

pub use scale::Scale;

use crate::error::{Meant, NumberError};
use crate::known::meant;
use crate::meaning::{Language, Named, german};
use crate::sheet::{Entry, Form};
use plumbline::can::CanId;
use plumbline::param::{DataType, Meaning, Permitted};
use scale::{is_same_quantity, number_and_unit, quantity};
use serde_json::{Number, Value, json};

impl Entry {
    /// The value of raw bytes as text with its unit, for example `1.25 deg`.
    pub fn text(&self, raw: u32) -> String {
        self.text_in(raw, |name| name)
    }

    /// The same for texts in both languages.
    pub fn named_text(&self, raw: u32) -> Named {
        Named::of(|language| self.text_in(raw, language))
    }

    fn text_in(&self, raw: u32, language: Language) -> String {
        match self.form {
            Form::Identifier => shown(CanId::from_bits(raw)),
            Form::Hexadecimal if raw > 9 => format!("{raw:X}h"),
            Form::Version => version(raw),
            Form::Decimal | Form::Hexadecimal => match self.meaning(raw) {
                Some(name) => language(name).to_owned(),
                None => self.scale.with_unit(self.data_type.value(raw)),
            },
        }
    }

    /// The value of raw bytes as JSON: a number, or a text for names and identifiers. A name such as `0.01 deg` is a number with a unit.
    pub fn json(&self, raw: u32) -> Value {
        let number = self.data_type.value(raw);
        let as_number = |text: &str| {
            let value = text.parse::<Number>();
            value.map_or_else(|_| Value::from(text), Value::Number)
        };
        let (value, unit) = match (self.form, self.meaning(raw)) {
            (Form::Decimal, Some(name)) => match number_and_unit(name) {
                Some((value, unit)) => (as_number(value), unit),
                None => (Value::from(name), ""),
            },
            (Form::Decimal, None) => {
                let (value, unit) = self.scale.quantity(number);
                (as_number(&value), unit)
            }
            _ => (Value::from(self.text(raw)), self.scale.unit),
        };
        json!({"value": value, "unit": unit, "raw": number})
    }

    fn meaning(&self, raw: u32) -> Option<&'static str> {
        let is = |(number, name): &&Meaning| *number == raw && !name.is_empty();
        self.meanings.iter().find(is).map(|(_, name)| *name)
    }

    /// The raw bytes of a value that a user writes.
    ///
    /// # Errors
    /// One sentence, why it is no value of this entry.
    pub fn parse(&self, text: &str) -> Result<u32, NumberError> {
        self.raw(self.number(text)?, &self.scale)
    }

    /// The same within the permitted values. `scale` is the scale in force, which can differ from the scale of the table.
    ///
    /// # Errors
    /// One sentence with the permitted values.
    pub fn accept(&self, text: &str, scale: &Scale) -> Result<u32, NumberError> {
        let scaled = Self {
            scale: scale.clone(),
            ..self.clone()
        };
        let number = scaled.number(text).map_err(|wrong| {
            if wrong.is_out_of_range() {
                return self.not_permitted(text.trim());
            }
            let meant = match wrong {
                NumberError::Names(_) => {
                    let names = self.meanings.iter().map(|(_, name)| *name);
                    meant(text.trim(), names)
                }
                _ => Meant::Nothing,
            };
            let (name, why) = (self.name.clone(), Box::new(wrong));
            NumberError::NoValue(name, text.to_owned(), why, self.range(), meant)
        })?;
        let raw = self.raw(number, scale)?;
        self.check(raw, scale)?;
        Ok(raw)
    }

    /// The number of a value that a user writes.
    fn number(&self, text: &str) -> Result<i64, NumberError> {
        let text = text.trim();
        let rate = self.rate(text);
        let text = rate.as_deref().unwrap_or(text);
        match text.strip_prefix("raw:") {
            Some(raw) => integer(raw).ok_or(NumberError::NoInteger),
            None if self.form == Form::Identifier => identifier(text).map(i64::from),
            None if !self.meanings.is_empty() => self.named(text),
            None => self.scaled(text),
        }
    }

    /// A bit rate with its unit, as users write it: `250k`, or `250` where the numbers of the protocol are bit rates. Elsewhere a number
    /// without a unit can be a number of the protocol.
    fn rate(&self, text: &str) -> Option<String> {
        let is_own = self.scale.unit.ends_with("bit/s");
        let can_be_code = text.parse::<u8>().is_ok();
        let is_rate = |(_, name): &Meaning| name.ends_with("bit/s");
        let is_named = !can_be_code && self.meanings.iter().any(is_rate);
        let bits = bench::in_bits(text).filter(|_| is_own || is_named)?;
        Some(format!("{}.{:03} kbit/s", bits / 1000, bits % 1000))
    }

    /// The raw bytes of a number in a scale.
    fn raw(&self, number: i64, scale: &Scale) -> Result<u32, NumberError> {
        let (low, high) = self.data_type.range();
        if number < low || high < number {
            let value = scale.with_unit(number);
            return Err(self.not_permitted(&value));
        }
        let size = u32::from(self.data_type.size());
        Ok(number as u32 & (u32::MAX >> (32 - 8 * size)))
    }

    pub(crate) fn read_only(&self) -> NumberError {
        NumberError::ReadOnly(self.name.clone())
    }

    fn not_permitted(&self, value: &str) -> NumberError {
        NumberError::NotPermitted(value.to_owned(), self.name.clone(), self.range())
    }

    fn scaled(&self, text: &str) -> Result<i64, NumberError> {
        // With a unit, `10h` is 10 hours or a mistake.
        if self.scale.unit.is_empty()
            && let Some(number) = integer(text)
        {
            return Ok(number);
        }
        let is_digits = text.bytes().all(|byte| byte.is_ascii_hexdigit());
        let has_letter = text.bytes().any(|byte| byte.is_ascii_alphabetic());
        if self.form == Form::Hexadecimal && is_digits && has_letter {
            return Err(NumberError::Hexadecimal(text.to_owned()));
        }
        let (number, unit) = quantity(text).ok_or(NumberError::NoNumber)?;
        self.scale.number(number, unit)
    }

    /// The number of a name, or a number that is permitted. A number that is both is ambiguous.
    fn named(&self, text: &str) -> Result<i64, NumberError> {
        let names = || {
            Named::of(|language| {
                let names = self.meanings.iter().map(|(_, name)| language(name));
                names.collect::<Vec<_>>().join(", ")
            })
        };
        let found = |is: &dyn Fn(&str) -> bool| -> Vec<u32> {
            let is = |name: &'static str| is(name) || is(german(name));
            let rows = self.meanings.iter().filter(|(_, name)| is(name));
            rows.map(|(number, _)| *number).collect()
        };
        let wanted = plain(text);
        let mut matches = found(&|name| plain(name) == wanted && !wanted.is_empty());
        if matches.is_empty() && !text.starts_with(|letter: char| !letter.is_alphabetic()) {
            // `butterworth` is `Butterworth 8th order`: whole words, but no part of a word.
            matches = found(&|name| has_first_words(name, &wanted));
        }
        if matches.is_empty() && text.starts_with(char::is_alphabetic) {
            // `j1939` is `SAE J1939`: a word with a number is a name of its own, but `change` is not `no change`.
            let is_own = |word: &str| word.contains(|letter: char| letter.is_ascii_digit());
            matches = found(&|name| is_own(&wanted) && plain(last_word(name)) == wanted);
        }
        if matches.is_empty() {
            // `250` and `0.25 Mbit/s` are `250 kbit/s`.
            matches = found(&|name| is_same_quantity(text, name));
        }
        // `10h` is no number of a name: its unit can be missing, or stand in another entry of a group.
        let number = match self.form {
            Form::Hexadecimal => integer(text),
            _ => text.parse().ok(),
        };
        let own = number.filter(|number| {
            self.meanings
                .iter()
                .any(|(own, _)| i64::from(*own) == *number)
        });
        match (own, &matches[..]) {
            (Some(own), []) => Ok(own),
            (Some(own), [only]) if i64::from(*only) == own => Ok(own),
            (None, [only]) => Ok((*only).into()),
            (Some(own), _) => Err(NumberError::RawOrName(text.to_owned(), own, names())),
            (None, []) => Err(NumberError::Names(names())),
            (None, _) => Err(NumberError::Ambiguous(text.to_owned(), names())),
        }
    }

    /// Checks a raw number against the permitted values. `scale` is the scale in force, which can differ from the scale of the table.
    ///
    /// # Errors
    /// One sentence with the permitted values.
    pub fn check(&self, raw: u32, scale: &Scale) -> Result<(), NumberError> {
        let number = self.data_type.value(raw);
        let permitted = match self.permitted {
            Permitted::Any => true,
            Permitted::Range(low, high) => {
                let value = i128::from(number) * self.ratio(scale).0;
                let one = self.ratio(scale).1;
                i128::from(low) * one <= value && value <= i128::from(high) * one
            }
            Permitted::Named => self.meanings.iter().any(|(own, _)| *own == raw),
            Permitted::OneOf(numbers) => numbers.contains(&raw),
            Permitted::Ranges(ranges) => ranges.contain(raw),
        };
        if permitted {
            return Ok(());
        }
        let value = Self {
            scale: scale.clone(),
            ..self.clone()
        }
        .text(raw);
        Err(self.not_permitted(&value))
    }

    /// A number in `scale` as a fraction of a number in the scale of the table.
    fn ratio(&self, scale: &Scale) -> (i128, i128) {
        let tens = |decimals: u8| 10_i128.pow(decimals.into());
        (
            i128::from(scale.multiplier) * tens(self.scale.decimals),
            i128::from(self.scale.multiplier) * tens(scale.decimals),
        )
    }

    /// The permitted values as text.
    pub fn range(&self) -> Named {
        Named::of(|language| self.range_in(language))
    }

    pub(crate) fn range_in(&self, language: Language) -> String {
        if self.data_type == DataType::Text {
            return language("a text").to_owned();
        }
        if !self.meanings.is_empty() {
            let names = self.meanings.iter().map(|(number, name)| match *name {
                "" => number.to_string(),
                name => format!("{} ({number})", language(name)),
            });
            return names.collect::<Vec<_>>().join(", ");
        }
        let (low, high) = match self.permitted {
            Permitted::Range(low, high) => (low, high),
            Permitted::OneOf(numbers) => {
                let numbers = numbers.iter().map(|number| self.text(*number));
                return numbers.collect::<Vec<_>>().join(", ");
            }
            Permitted::Ranges(ranges) if !ranges.text.is_empty() => {
                return language(ranges.text).to_owned();
            }
            Permitted::Ranges(ranges) => {
                let texts = ranges.ranges.iter();
                let texts = texts.map(|(low, high)| match low == high {
                    true => self.text(*low),
                    false => format!("{}..{}", self.text(*low), self.text(*high)),
                });
                return texts.collect::<Vec<_>>().join(", ");
            }
            Permitted::Any | Permitted::Named if self.form == Form::Hexadecimal => {
                return "0..FFFFFFFFh".to_owned();
            }
            Permitted::Any | Permitted::Named => self.data_type.range(),
        };
        format!("{}..{}", self.scale.value(low), self.scale.with_unit(high))
    }
}

/// Whether these are the first words of a name.
fn has_first_words(name: &str, wanted: &str) -> bool {
    let ends = name.match_indices(' ').map(|(end, _)| end);
    let mut beginnings = ends.map(|end| plain(&name[..end]));
    beginnings.any(|own| own == wanted)
}

/// The last word of a name.
fn last_word(name: &str) -> &str {
    name.rsplit(' ').next().unwrap_or_default()
}

/// Letters and digits in small letters: names are compared without spaces, hyphens and capitals.
fn plain(text: &str) -> String {
    let kept = text.chars().filter(|letter| !" -_".contains(*letter));
    kept.collect::<String>().to_lowercase()
}

/// An integer: decimal, `0x1F` or `1Fh`.
pub fn integer(text: &str) -> Option<i64> {
    let hexadecimal = |digits: &str| {
        let is_valid = !digits.is_empty() && digits.bytes().all(|byte| byte.is_ascii_hexdigit());
        is_valid.then(|| i64::from_str_radix(digits, 16).ok())?
    };
    if let Some(digits) = text.strip_prefix("0x").or_else(|| text.strip_prefix("0X")) {
        return hexadecimal(digits);
    }
    match text.strip_suffix(['h', 'H']) {
        Some(digits) => hexadecimal(digits),
        None => text.parse().ok(),
    }
}

/// A CAN identifier as raw bytes: `300h` or `300` has 11 bits, 8 digits as `00000361h` are 29 bits.
///
/// # Errors
/// One sentence, why it is none.
pub fn identifier(text: &str) -> Result<u32, NumberError> {
    let digits = text.strip_prefix("0x").unwrap_or(text);
    let digits = digits.strip_suffix(['h', 'H']).unwrap_or(digits);
    let is_valid = digits.bytes().all(|byte| byte.is_ascii_hexdigit());
    let number = u32::from_str_radix(digits, 16).ok().filter(|_| is_valid);
    match (digits.len(), number) {
        (1..=3, Some(number)) if number <= 0x7FF => Ok(CanId::standard(number as u16).bits()),
        (8, Some(number)) if number <= 0x1FFF_FFFF => Ok(CanId::extended(number).bits()),
        _ => Err(NumberError::NoIdentifier),
    }
}

/// An identifier as text: 3 hexadecimal digits for 11 bits, 8 for 29 bits.
pub fn shown(id: CanId) -> String {
    match id.bits() >> 31 {
        0 => format!("{:03X}h", id.bits()),
        _ => format!("{:08X}h", id.bits() & 0x1FFF_FFFF),
    }
}

/// A software version as text: binary-coded decimal (v3.44 is 0344h), or a number (v01.03 is 103).
pub fn version_text(raw: u16) -> String {
    version(raw.into())
}

fn version(raw: u32) -> String {
    let (major, minor) = (raw >> 8, raw & 0xFF);
    if major == 0 {
        format!("{}.{:02}", raw / 100, raw % 100)
    } else {
        format!("{major:X}.{minor:02X}")
    }
}

#[cfg(test)]
mod tests;
