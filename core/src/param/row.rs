//! The description of a parameter in the form that the device uses: four bytes. The factory value is stored separately.
//!
//! ```text
//!  byte 0           1           2                                                           4
//!       +-----------+-----------+-----------------------------------------------------------+
//!       | first, u8 | count, u8 | form, u16: bits 0..2 type, 3..4 persistence, 5..6 number  |
//!       |           |           |            of highest bits that are ignored               |
//!       +-----------+-----------+-----------------------------------------------------------+
//! ```
//!
//! `first` and `count` select the permitted ranges in the pool of the table. Without a range, all numbers are permitted. The
//! limits in the pool are ordered numbers: for signed types the sign bit is inverted, so that they can be compared as unsigned
//! numbers.

use super::{DataType, Persistence, real};

/// The lowest and the highest number of a range, as ordered numbers.
pub type Limits = (u32, u32);

/// The type, persistence and permitted ranges of a parameter.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct ParameterRow {
    first: u8,
    count: u8,
    form: u16,
}

/// The reason why a value of a parameter is refused.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Refused {
    /// It is below the permitted range.
    TooLow,
    /// It is above the permitted range.
    TooHigh,
    /// It is not one of the permitted values.
    NotPermitted,
    /// Not possible in the present state of the device.
    State,
}

const PERSISTENCE: u32 = 3;
const IGNORED_BITS: u32 = 5;
/// In the form: a real number of 32 bits.
const REAL: u16 = 1 << 7;

/// The type in the form: a row of a parameter of 64 bits has 32 bits.
const fn form_of(data_type: DataType) -> u16 {
    match data_type {
        DataType::Real32 => DataType::U32 as u16 | REAL,
        DataType::U64 | DataType::I64 | DataType::Real64 => DataType::U32 as u16,
        _ => data_type as u16,
    }
}

impl ParameterRow {
    pub(super) const fn new(
        data_type: DataType,
        persistence: Persistence,
        ignored_bits: u8,
        (first, count): (usize, usize),
    ) -> Self {
        assert!(ignored_bits < 4);
        assert!(first + count < 256, "too many permitted ranges");
        let form = form_of(data_type) | (persistence as u16) << PERSISTENCE;
        Self {
            first: first as u8,
            count: count as u8,
            form: form | (ignored_bits as u16) << IGNORED_BITS,
        }
    }

    /// The size in bytes: 1, 2 or 4.
    pub const fn size(self) -> u8 {
        1 << (self.form & 3)
    }

    /// The type in which the device handles the parameter.
    pub const fn data_type(self) -> DataType {
        DataType::of((self.form & 7) as u8)
    }

    /// Whether it is a real number of 32 bits.
    pub(super) const fn is_real(self) -> bool {
        self.form & REAL != 0
    }

    /// Whether it is part of the stored image.
    pub const fn is_stored(self) -> bool {
        self.form >> PERSISTENCE & 3 != Persistence::Volatile as u16
    }

    /// Whether it is stored when it is written.
    pub const fn is_stored_at_once(self) -> bool {
        self.form >> PERSISTENCE & 3 == Persistence::AtOnce as u16
    }

    /// Whether `value` is permitted, independent of the other parameters.
    pub(super) fn check(self, value: u32, pool: &'static [Limits]) -> Result<(), Refused> {
        self.check_ordered(self.ordered(value), pool)
    }

    /// The same for a real number. NaN is refused.
    pub(super) fn check_real(self, value: u32, pool: &'static [Limits]) -> Result<(), Refused> {
        if real::is_nan(value) {
            return Err(Refused::NotPermitted);
        }
        self.check_ordered(real::ordered(value), pool)
    }

    #[inline]
    fn check_ordered(self, value: u32, pool: &'static [Limits]) -> Result<(), Refused> {
        let (first, count) = (usize::from(self.first), usize::from(self.count));
        let ranges = pool.get(first..first + count).unwrap_or(&[]);
        match ranges {
            [] => Ok(()),
            [(low, _)] if value < *low => Err(Refused::TooLow),
            [(_, high)] if value > *high => Err(Refused::TooHigh),
            _ if ranges
                .iter()
                .any(|(low, high)| (low..=high).contains(&&value)) =>
            {
                Ok(())
            }
            _ => Err(Refused::NotPermitted),
        }
    }

    /// The value as an ordered number, without the ignored bits.
    fn ordered(self, value: u32) -> u32 {
        let ignored = u32::from(self.form >> IGNORED_BITS & 3);
        let value = value.wrapping_shl(ignored).wrapping_shr(ignored);
        ordered(self.data_type(), value)
    }
}

/// The ordered number of `value`: unsigned, with the same order as the values of the type.
pub(super) const fn ordered(data_type: DataType, value: u32) -> u32 {
    if matches!(data_type, DataType::Real32) {
        real::ordered(value)
    } else if data_type.is_signed() {
        data_type.value(value) as u32 ^ 1 << 31
    } else {
        value
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const fn row(data_type: DataType, ignored_bits: u8, count: usize) -> ParameterRow {
        ParameterRow::new(data_type, Persistence::OnSave, ignored_bits, (0, count))
    }

    const fn limits(data_type: DataType, low: i64, high: i64) -> Limits {
        (
            ordered(data_type, low as u32),
            ordered(data_type, high as u32),
        )
    }

    #[test]
    fn value_outside_single_range_is_too_low_or_too_high() {
        static SIGNED: [Limits; 1] = [limits(DataType::I16, -9000, 9000)];
        let signed = row(DataType::I16, 0, 1);
        for (value, expected) in [
            (-9001, Err(Refused::TooLow)),
            (-9000, Ok(())),
            (0, Ok(())),
            (9000, Ok(())),
            (9001, Err(Refused::TooHigh)),
        ] {
            // The raw number of the two bytes on the bus.
            let bytes = u32::from(value as i16 as u16);
            assert_eq!(signed.check(bytes, &SIGNED), expected, "{value}");
        }
        static UNSIGNED: [Limits; 1] = [(1, u32::MAX - 1)];
        let unsigned = row(DataType::U32, 0, 1);
        assert_eq!(unsigned.check(0, &UNSIGNED), Err(Refused::TooLow));
        assert_eq!(unsigned.check(u32::MAX, &UNSIGNED), Err(Refused::TooHigh));
        assert_eq!(unsigned.check(u32::MAX - 1, &UNSIGNED), Ok(()));
    }

    #[test]
    fn value_outside_several_ranges_is_not_permitted() {
        static POOL: [Limits; 2] = [(0, 240), (252, 255)];
        let row = row(DataType::U8, 0, 2);
        for value in 0..=255 {
            let expected = match value {
                0..=240 | 252..=255 => Ok(()),
                _ => Err(Refused::NotPermitted),
            };
            assert_eq!(row.check(value, &POOL), expected);
        }
    }

    #[test]
    fn check_ignores_highest_bits_set_in_row() {
        static POOL: [Limits; 2] = [(0x80, 0x80), (0x181, 0x1FF)];
        let row = row(DataType::U32, 2, 2);
        for flags in [0, 1 << 31, 1 << 30, 3 << 30] {
            assert_eq!(row.check(0x80 | flags, &POOL), Ok(()));
        }
        assert_eq!(row.check(0x80 | 1 << 29, &POOL), Err(Refused::NotPermitted));
    }

    #[test]
    fn real_number_is_compared_by_value_and_nan_is_refused() {
        static POOL: [Limits; 1] = [(
            real::ordered((-90.0_f32).to_bits()),
            real::ordered(90.0_f32.to_bits()),
        )];
        let limited = row(DataType::Real32, 0, 1);
        for (value, expected) in [
            (-90.0_f32, Ok(())),
            (90.0, Ok(())),
            (-0.0, Ok(())),
            (90.00001, Err(Refused::TooHigh)),
            (-90.00001, Err(Refused::TooLow)),
            (f32::INFINITY, Err(Refused::TooHigh)),
            (f32::NEG_INFINITY, Err(Refused::TooLow)),
            (f32::NAN, Err(Refused::NotPermitted)),
            (-f32::NAN, Err(Refused::NotPermitted)),
        ] {
            assert_eq!(
                limited.check_real(value.to_bits(), &POOL),
                expected,
                "{value}"
            );
        }
        let any = row(DataType::Real32, 0, 0);
        assert_eq!(any.check_real(f32::INFINITY.to_bits(), &[]), Ok(()));
        let refused = Err(Refused::NotPermitted);
        assert_eq!(any.check_real(f32::NAN.to_bits(), &[]), refused);
    }

    #[test]
    fn row_without_range_permits_all_values() {
        assert_eq!(row(DataType::I32, 0, 0).check(u32::MAX, &[]), Ok(()));
    }
}
