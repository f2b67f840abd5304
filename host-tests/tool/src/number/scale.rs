//! The scale of a number: multiplier, decimals and unit.

use super::Wrong;

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
    ) -> Result<i64, Wrong> {
        let power = match unit {
            "" => 0,
            unit => conversion(unit, self.unit).ok_or_else(|| match self.unit {
                "" => Wrong::value("it has no unit"),
                own => Wrong::value(format!("its unit is {own}")),
            })?,
        };
        // mantissa / 10^exponent x 10^power = number x multiplier / 10^decimals
        let shift = i32::from(self.decimals) - i32::from(exponent) + power;
        let tens = 10_i128
            .checked_pow(shift.unsigned_abs())
            .ok_or_else(Wrong::too_large)?;
        let multiplier = i128::from(self.multiplier);
        let (over, under) = if shift < 0 {
            (Some(mantissa), multiplier.checked_mul(tens))
        } else {
            (mantissa.checked_mul(tens), Some(multiplier))
        };
        let (Some(over), Some(under)) = (over, under) else {
            return Err(Wrong::too_large());
        };
        if over % under != 0 {
            let step = format!("its step is {}", self.with_unit(1));
            return Err(Wrong::value(step));
        }
        i64::try_from(over / under).map_err(|_| Wrong::too_large())
    }
}

/// A decimal number: its digits as an integer, and the number of digits after the point.
pub(super) fn decimal(text: &str) -> Option<(i128, u8)> {
    let (sign, digits) = match text.strip_prefix(['-', '+']) {
        Some(digits) if text.starts_with('-') => (-1, digits),
        Some(digits) => (1, digits),
        None => (1, text),
    };
    let (whole, part) = digits.split_once('.').unwrap_or((digits, ""));
    let is_number = |text: &str| text.bytes().all(|byte| byte.is_ascii_digit());
    let has_digits = !(whole.is_empty() && part.is_empty());
    if !is_number(whole) || !is_number(part) || !has_digits || text.len() > 30 {
        return None;
    }
    let number: i128 = format!("{whole}{part}").parse().ok()?;
    Some((sign * number, part.len() as u8))
}

/// The power of ten from one unit to another with the same base.
fn conversion(from: &str, to: &str) -> Option<i32> {
    let (from, to) = (split(from), split(to));
    (from.1 == to.1).then_some(from.0 - to.0)
}

/// The units that can have a prefix.
const BASES: [&str; 7] = ["Hz", "s", "bit/s", "V", "W", "A", "g"];

/// The number and the unit of a name such as `0.01 deg`.
pub(super) fn number_and_unit(name: &str) -> Option<(&str, &str)> {
    let (number, unit) = name.split_once(' ')?;
    let base = split(unit).1;
    let is_unit = base == "deg" || BASES.contains(&base.as_str());
    decimal(number).filter(|_| is_unit)?;
    Some((number, unit))
}

/// The power of ten of the prefix of a unit, and its base.
fn split(unit: &str) -> (i32, String) {
    let unit = unit.trim().replace('°', "deg").replace('µ', "u");
    for (prefix, power) in [("u", -6), ("m", -3), ("k", 3), ("M", 6)] {
        if let Some(base) = unit.strip_prefix(prefix)
            && BASES.contains(&base)
        {
            return (power, base.to_owned());
        }
    }
    (0, unit)
}
