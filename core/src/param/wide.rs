//! The permitted range of a parameter of 64 bits, in the form that the device uses.

use super::row::Refused;
use super::{DataType, Parameter, ParameterId, Permitted, is_nan_64};

/// The limits of a parameter of 64 bits that does not permit all numbers, as ordered numbers.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct WideLimits {
    /// The parameter with the lower 32 bits.
    pub(super) id: ParameterId,
    data_type: DataType,
    low: u64,
    high: u64,
}

impl WideLimits {
    /// All numbers.
    pub(super) const ANY: Self = Self {
        id: ParameterId(0),
        data_type: DataType::U64,
        low: 0,
        high: u64::MAX,
    };

    /// The limits of a parameter. A real number is never a NaN. None: it permits all numbers, or has not 64 bits.
    pub(super) const fn of(parameter: &Parameter) -> Option<Self> {
        let data_type = parameter.data_type;
        let (low, high) = match (parameter.permitted, data_type) {
            (Permitted::Range(low, high), DataType::Real64) => {
                ((low as f64).to_bits(), (high as f64).to_bits())
            }
            (Permitted::Range(low, high), _) => (low as u64, high as u64),
            (_, DataType::Real64) => (f64::NEG_INFINITY.to_bits(), f64::INFINITY.to_bits()),
            _ => return None,
        };
        if !data_type.is_wide() {
            return None;
        }
        Some(Self {
            id: parameter.id,
            data_type,
            low: ordered(data_type, low),
            high: ordered(data_type, high),
        })
    }

    /// Checks a number.
    pub(super) const fn check(&self, value: u64) -> Result<(), Refused> {
        if matches!(self.data_type, DataType::Real64) && is_nan_64(value) {
            return Err(Refused::NotPermitted);
        }
        let value = ordered(self.data_type, value);
        if value < self.low {
            return Err(Refused::TooLow);
        }
        if value > self.high {
            return Err(Refused::TooHigh);
        }
        Ok(())
    }

    /// Whether a number is permitted.
    pub(super) const fn permit(&self, value: u64) -> bool {
        self.check(value).is_ok()
    }
}

/// Converts a number into an unsigned number with the same order. Both zeros of real numbers are equal.
const fn ordered(data_type: DataType, value: u64) -> u64 {
    const SIGN: u64 = 1 << 63;
    match data_type {
        DataType::U64 => value,
        DataType::Real64 if value > SIGN => !value,
        DataType::Real64 => value | SIGN,
        _ => value ^ SIGN,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn value_outside_of_the_range_is_refused_by_its_side() {
        let [count, _] = Parameter::new(ParameterId(0), "", DataType::U64).wide_within(5, 90, 7);
        let [balance, _] = Parameter::new(ParameterId(0), "", DataType::I64).wide_within(-5, 90, 7);
        let [scale, _] =
            Parameter::new(ParameterId(0), "", DataType::Real64).wide_within(-5, 90, 7);
        let bits = |number: f64| number.to_bits();
        for (parameter, value, checked) in [
            (&count, 4, Err(Refused::TooLow)),
            (&count, 5, Ok(())),
            (&count, 90, Ok(())),
            (&count, 91, Err(Refused::TooHigh)),
            (&count, 1 << 63, Err(Refused::TooHigh)),
            (&count, u64::MAX, Err(Refused::TooHigh)),
            (&balance, -6_i64 as u64, Err(Refused::TooLow)),
            (&balance, -5_i64 as u64, Ok(())),
            (&balance, 90, Ok(())),
            (&balance, i64::MAX as u64, Err(Refused::TooHigh)),
            (&balance, i64::MIN as u64, Err(Refused::TooLow)),
            (&scale, bits(-5.1), Err(Refused::TooLow)),
            (&scale, bits(-5.0), Ok(())),
            (&scale, bits(-0.0), Ok(())),
            (&scale, bits(90.0), Ok(())),
            (&scale, bits(90.1), Err(Refused::TooHigh)),
            (&scale, bits(f64::NAN), Err(Refused::NotPermitted)),
        ] {
            let limits = WideLimits::of(parameter).unwrap();
            assert_eq!(limits.check(value), checked, "{value:#x}");
        }
    }
}
