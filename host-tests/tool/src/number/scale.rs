//! The scale of a number: multiplier, decimals and unit.

use crate::error::NumberError;

/// The scale of a number: value = number x multiplier / 10^decimals, in the unit.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Scale {
    /// The number is multiplied by this.
    pub multiplier: i64,
    /// Digits after the decimal point.
    pub decimals: u8,
    /// The unit without a number.
    pub unit: &'static str,
}

impl Scale {
    /// A number without unit and decimals.
    pub const PLAIN: Self = Self {
        multiplier: 1,
        decimals: 0,
        unit: "",
    };

    /// The scale of a unit of the table, which can begin with a number: `100 us`, `0.001 deg`.
    pub fn of(unit: &'static str, decimals: u8) -> Self {
        let split = unit
            .split_once(' ')
            .and_then(|(factor, unit)| Some((decimal(factor)?, unit)));
        let Some(((multiplier, more), unit)) = split else {
            return Self {
                decimals,
                unit,
                ..Self::PLAIN
            };
        };
        let scale = Self {
            multiplier: multiplier as i64,
            decimals: decimals + more,
            unit,
        };
        scale.reduced()
    }

    /// The scale of numbers whose unit is this number in this scale.
    pub fn times(&self, number: u32) -> Self {
        let multiplier = self.multiplier * i64::from(number.max(1));
        Self {
            multiplier,
            ..self.clone()
        }
        .reduced()
    }

    fn reduced(mut self) -> Self {
        while self.decimals > 0 && self.multiplier % 10 == 0 {
            self.multiplier /= 10;
            self.decimals -= 1;
        }
        self
    }

    /// The value of a number without the unit, for example `-12.34`.
    pub fn value(&self, number: i64) -> String {
        let scaled = i128::from(number) * i128::from(self.multiplier);
        let power = 10_i128.pow(self.decimals.into());
        let (size, sign) = (scaled.unsigned_abs(), if scaled < 0 { "-" } else { "" });
        let (whole, part) = (size / power as u128, size % power as u128);
        match usize::from(self.decimals) {
            0 => format!("{sign}{whole}"),
            decimals => format!("{sign}{whole}.{part:0decimals$}"),
        }
    }

    /// The value of a number and its unit. A bit rate is in kbit/s, as all products have it.
    pub(super) fn quantity(&self, number: i64) -> (String, &'static str) {
        match (self.unit, self.decimals) {
            ("bit/s", 0) if number % 1000 == 0 => (self.value(number / 1000), "kbit/s"),
            _ => (self.value(number), self.unit),
        }
    }

    /// The value of a number with the unit, for example `-12.34 deg`.
    pub fn with_unit(&self, number: i64) -> String {
        let (value, unit) = self.quantity(number);
        format!("{value} {unit}").trim_end().to_owned()
    }

    /// The number of a value in another spelling of the unit.
    pub(super) fn number(
        &self,
        (mantissa, exponent): (i128, u8),
        unit: &str,
    ) -> Result<i64, NumberError> {
        let (factor, divisor, power) = match unit {
            "" => (1, 1, 0),
            unit => conversion(unit, self.unit).ok_or(match self.unit {
                "" => NumberError::NoUnit,
                own => NumberError::Unit(own),
            })?,
        };
        // mantissa / 10^exponent x factor / divisor x 10^power = number x multiplier / 10^decimals
        let shift = i32::from(self.decimals) - i32::from(exponent) + power;
        let tens = 10_i128
            .checked_pow(shift.unsigned_abs())
            .ok_or(NumberError::TooLarge)?;
        let over = mantissa.checked_mul(factor);
        let under = i128::from(self.multiplier).checked_mul(divisor);
        let (over, under) = if shift < 0 {
            (over, under.and_then(|under| under.checked_mul(tens)))
        } else {
            (over.and_then(|over| over.checked_mul(tens)), under)
        };
        let (Some(over), Some(under)) = (over, under) else {
            return Err(NumberError::TooLarge);
        };
        if over % under != 0 {
            return Err(NumberError::Step(self.with_unit(1)));
        }
        i64::try_from(over / under).map_err(|_| NumberError::TooLarge)
    }
}

/// A decimal number: its digits as an integer, and the number of digits after the point or comma.
pub(super) fn decimal(text: &str) -> Option<(i128, u8)> {
    let (sign, digits) = match text.strip_prefix(['-', '+']) {
        Some(digits) if text.starts_with('-') => (-1, digits),
        Some(digits) => (1, digits),
        None => (1, text),
    };
    let (whole, part) = digits.split_once(['.', ',']).unwrap_or((digits, ""));
    let is_number = |text: &str| text.bytes().all(|byte| byte.is_ascii_digit());
    let has_digits = !(whole.is_empty() && part.is_empty());
    if !is_number(whole) || !is_number(part) || !has_digits || text.len() > 30 {
        return None;
    }
    let number: i128 = format!("{whole}{part}").parse().ok()?;
    Some((sign * number, part.len() as u8))
}

/// The number and the unit of a text such as `2.5Hz`. The unit can be empty.
pub(super) fn quantity(text: &str) -> Option<((i128, u8), &str)> {
    let is_number = |letter: char| letter.is_ascii_digit() || ".,-+".contains(letter);
    let end = text.find(|letter| !is_number(letter)).unwrap_or(text.len());
    let (number, unit) = text.split_at(end);
    Some((decimal(number)?, unit.trim()))
}

/// Whether a text is the number of a name such as `250 kbit/s`, without a unit or in any spelling of the unit.
pub(super) fn is_same_quantity(text: &str, name: &str) -> bool {
    let own = name.split_once(' ');
    let own = own.and_then(|(number, unit)| Some((decimal(number)?, unit)));
    let (Some(((number, decimals), unit)), Some(((wanted, exponent), other))) =
        (own, quantity(text))
    else {
        return false;
    };
    let Some((factor, divisor, power)) = (match other {
        "" => Some((1, 1, 0)),
        other => conversion(other, unit),
    }) else {
        return false;
    };
    // number / 10^decimals = wanted / 10^exponent x factor / divisor x 10^power
    let shift = i32::from(decimals) - i32::from(exponent) + power;
    let tens = |power: i32| 10_i128.checked_pow(power.max(0).unsigned_abs());
    let product = |number: i128, factor: i128, power: i32| {
        number.checked_mul(factor)?.checked_mul(tens(power)?)
    };
    let left = product(number, divisor, -shift);
    left.is_some() && left == product(wanted, factor, shift)
}

/// A value in one unit is this value in another one with the same base: x factor / divisor x 10^power.
fn conversion(from: &str, to: &str) -> Option<(i128, i128, i32)> {
    let (from, to) = (Unit::of(from), Unit::of(to));
    let is_same = from.base.eq_ignore_ascii_case(&to.base);
    is_same.then_some((from.factor, to.factor, from.power - to.power))
}

/// The units that can have a prefix.
const BASES: [&str; 7] = ["Hz", "s", "bit/s", "V", "W", "A", "g"];

/// The number and the unit of a name such as `0.01 deg`.
pub(super) fn number_and_unit(name: &str) -> Option<(&str, &str)> {
    let (number, unit) = name.split_once(' ')?;
    let base = Unit::of(unit).base;
    let is_unit = base == "deg" || BASES.contains(&base.as_str());
    decimal(number).filter(|_| is_unit)?;
    Some((number, unit))
}

/// A unit: factor x 10^power of its base.
struct Unit {
    factor: i128,
    power: i32,
    base: String,
}

impl Unit {
    /// The unit in any case. A small m is never mega, except for a bit rate, which no one measures in mbit/s. A large M is mega only for
    /// a frequency and a bit rate.
    fn of(unit: &str) -> Self {
        let unit = unit.trim().replace('°', "deg").replace(['µ', 'μ'], "u");
        let (factor, power, base) = match unit.to_ascii_lowercase().as_str() {
            "min" => (60, 0, "s"),
            "h" => (3600, 0, "s"),
            _ => (1, 0, unit.as_str()),
        };
        let own = |factor, power, base: &str| Self {
            factor,
            power,
            base: base.to_owned(),
        };
        let is = |base: &str, text: &str| base.eq_ignore_ascii_case(text);
        let known = |text: &str| BASES.into_iter().find(|base| is(base, text));
        if let Some(base) = known(base) {
            return own(factor, power, base);
        }
        let mut letters = base.chars();
        let prefix = letters.next().unwrap_or(' ');
        let Some(rest) = known(letters.as_str()) else {
            return own(factor, power, base);
        };
        let power = match (prefix, rest) {
            ('u' | 'U', _) => -6,
            ('m' | 'M', "bit/s") | ('M', "Hz") => 6,
            ('m' | 'M', _) => -3,
            ('k' | 'K', _) => 3,
            _ => return own(factor, power, base),
        };
        own(factor, power, rest)
    }
}
