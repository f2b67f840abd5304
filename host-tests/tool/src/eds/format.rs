//! The formats of data sheets: a protocol has one if its devices have data sheets.

use super::Parts;
use crate::error::Fault;
use crate::master::{PROTOCOLS, Protocol};
use crate::sheet::Address;
use descriptors::unit::Value;
use plumbline::param::DataType;

/// The format of the data sheets of a protocol.
#[derive(Debug)]
pub struct Format {
    /// What the protocol is called.
    pub name: &'static str,
    /// Whether a text has this format; None: it has, if it has no other one.
    pub is_own: Option<fn(&str) -> bool>,
    /// The parts of the sheet.
    pub(crate) parts: fn(&str) -> Result<Parts, Fault>,
    /// The identity of a unit, by the keys of its sheet of values.
    pub(crate) values: fn(&str) -> Result<Values, Fault>,
    /// Where a device tells its vendor and its product code.
    pub(crate) identity: [(Address, DataType); 2],
}

/// Values by the keys of a sheet of values.
pub(crate) type Values = Vec<(&'static str, Value)>;

/// The protocol and the format of a text.
pub(super) fn of(text: &str) -> Option<(&'static Protocol, &'static Format)> {
    let all = PROTOCOLS.into_iter();
    let all = all.filter_map(|own| Some((own, own.data_sheet.as_ref()?)));
    let mut own = all.clone();
    let own = own.find(|(_, format)| format.is_own.is_some_and(|is_own| is_own(text)));
    own.or_else(|| all.clone().find(|(_, format)| format.is_own.is_none()))
}

/// An integer: decimal, hexadecimal with `0x`, octal with a leading 0.
pub(crate) fn number(text: &str) -> Option<i64> {
    let text = text.trim();
    let (sign, digits) = match text.strip_prefix('-') {
        Some(digits) => (-1, digits),
        None => (1, text),
    };
    let small = digits.to_ascii_lowercase();
    let (radix, digits) = match small.strip_prefix("0x") {
        Some(digits) => (16, digits),
        None if small.len() > 1 && small.starts_with('0') => (8, &small[1..]),
        None => (10, &small[..]),
    };
    let is_digit = |letter: char| letter.is_digit(radix);
    if digits.is_empty() || digits.len() > 16 || !digits.chars().all(is_digit) {
        return None;
    }
    Some(sign * i64::from_str_radix(digits, radix).ok()?)
}
