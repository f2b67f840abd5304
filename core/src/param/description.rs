//! The description of a parameter.

use crate::mistake::{Mistake, Origin};
use crate::walk::{each, get, put};

/// The id of a parameter: its index in the table of the product.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ParameterId(pub u8);

impl ParameterId {
    /// The type of its number; a text, which no parameter is, if the table does not have it.
    pub(crate) const fn data_type(self, parameters: &[Parameter]) -> DataType {
        match get(parameters, self.0 as usize) {
            Some(parameter) => parameter.data_type,
            None => DataType::Text,
        }
    }
}

/// The type of a number, or a text.
///
/// Bits 0 and 1 of the discriminant are the base-2 logarithm of the size in bytes; bit 2 is set for signed types. Bits 0 to 2 of the types
/// with bit 3 are those of the form in which the device handles them: 32 bits, or as a text of 8 bytes.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
#[repr(u8)]
pub enum DataType {
    /// 8 bits, unsigned.
    U8 = 0,
    /// 16 bits, unsigned.
    U16 = 1,
    /// 32 bits, unsigned.
    U32 = 2,
    /// A text; no parameter has this type.
    Text = 3,
    /// 8 bits, signed (two's complement).
    I8 = 4,
    /// 16 bits, signed (two's complement).
    I16 = 5,
    /// 32 bits, signed (two's complement).
    I32 = 6,
    /// 64 bits, unsigned. A parameter of 64 bits has two rows ([`Parameter::wide`]).
    U64 = 11,
    /// 32 bits, a real number (IEEE 754). A parameter refuses NaN.
    Real32 = 14,
    /// 64 bits, signed (two's complement).
    I64 = 15,
    /// 64 bits, a real number (IEEE 754).
    Real64 = 31,
}

impl DataType {
    /// The type with this discriminant.
    pub(crate) const fn of(number: u8) -> Self {
        match number {
            0 => Self::U8,
            1 => Self::U16,
            2 => Self::U32,
            4 => Self::I8,
            5 => Self::I16,
            6 => Self::I32,
            _ => Self::Text,
        }
    }

    /// The [size](Self::size) of the type with this discriminant: shorter than with the type.
    pub(crate) const fn size_of(number: u8) -> u8 {
        // 1, 2, 4, and of a text 8, which is masked.
        1 << (number & 3) & 7
    }

    /// The size of a number in bytes; 0 for a text.
    pub const fn size(self) -> u8 {
        match self {
            Self::Text => 0,
            _ => 1 << (self as u8 & 3),
        }
    }

    /// Whether numbers of this type have 64 bits.
    pub const fn is_wide(self) -> bool {
        self.size() == 8
    }

    /// Whether numbers of this type are real numbers.
    pub const fn is_real(self) -> bool {
        matches!(self, Self::Real32 | Self::Real64)
    }

    /// Whether numbers of this type are signed.
    pub const fn is_signed(self) -> bool {
        self as u8 & 4 != 0
    }

    /// The value of the raw number `bytes`, for example -1 for FFFFh in an [`I16`](Self::I16).
    pub const fn value(self, bytes: u32) -> i64 {
        let unused = 32_u32.saturating_sub(8 * self.size() as u32);
        if self.is_signed() {
            (((bytes << unused) as i32) >> unused) as i64
        } else {
            bytes as i64
        }
    }

    /// The lowest and the highest value of this type, limited to the range of `i64`. For real numbers they are whole numbers.
    pub const fn range(self) -> (i64, i64) {
        match self {
            Self::U64 => return (0, i64::MAX),
            Self::I64 | Self::Real32 | Self::Real64 => return (i64::MIN, i64::MAX),
            _ => {}
        }
        let bits = 8 * self.size() as u32;
        if self.is_signed() {
            (-(1 << (bits - 1)), (1 << (bits - 1)) - 1)
        } else {
            (0, (1 << bits) - 1)
        }
    }
}

/// A number and its name.
pub type Meaning = (u32, &'static str);

/// The permitted values of a parameter.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Permitted {
    /// All numbers of the type.
    Any,
    /// From the first to the second number, both included.
    Range(i64, i64),
    /// The numbers that have a name in [`Parameter::meanings`].
    Named,
    /// Only these numbers, in any order.
    OneOf(&'static [u32]),
    /// The numbers in these ranges.
    Ranges(&'static Ranges),
}

/// Several ranges of unsigned numbers.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Ranges {
    /// A description of these numbers; empty if the ranges are sufficient.
    pub text: &'static str,
    /// The number of highest bits (of 32) that are ignored, 0 to 3.
    pub ignored_bits: u8,
    /// The first and the last number of each range.
    pub ranges: &'static [(u32, u32)],
}

impl Ranges {
    /// Whether `number` is in one of the ranges.
    pub const fn contain(&self, number: u32) -> bool {
        let number = number << self.ignored_bits >> self.ignored_bits;
        each!((low, high) in self.ranges => {
            if *low <= number && number <= *high {
                return true;
            }
        });
        false
    }
}

/// The persistence of a parameter: its value after a power cycle.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
#[repr(u8)]
pub enum Persistence {
    /// Not stored: it starts with its factory value.
    Volatile,
    /// Stored by the save command of the protocol.
    OnSave,
    /// Stored when it is written.
    AtOnce,
}

/// The description of a parameter.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Parameter {
    /// Its id: the index in the table.
    pub id: ParameterId,
    /// The name in the manual. Descriptors and tools use it.
    pub name: &'static str,
    /// The type of the raw number. The size on the bus follows from it.
    pub data_type: DataType,
    /// The unit of the value, empty if it has none.
    pub unit: &'static str,
    /// Digits after the decimal point: the value is the number divided by 10 to this power.
    pub decimals: u8,
    /// The numbers that a write accepts.
    pub permitted: Permitted,
    /// Numbers that stand for something, with its name: 2 is "5 Hz". They need not be all permitted numbers.
    pub meanings: &'static [Meaning],
    /// The factory value as a raw number: FFFFh is -1 in an [`I16`](DataType::I16), `1.5_f32.to_bits()` is 1.5 in a
    /// [`Real32`](DataType::Real32).
    pub factory: u32,
    /// When it is stored, and whether at all.
    pub persistence: Persistence,
    /// The line of the row, for the message of a mistake.
    pub origin: Origin,
}

impl Parameter {
    /// The default for a description: a byte without unit and names, stored on save.
    #[track_caller]
    pub const fn plain() -> Self {
        Self {
            id: ParameterId(0),
            name: "",
            data_type: DataType::U8,
            unit: "",
            decimals: 0,
            permitted: Permitted::Any,
            meanings: &[],
            factory: 0,
            persistence: Persistence::OnSave,
            origin: Origin::here(),
        }
    }

    /// A stored parameter without unit that takes every value of its type; its factory value is 0.
    #[track_caller]
    pub const fn new(id: ParameterId, name: &'static str, data_type: DataType) -> Self {
        Self {
            id,
            name,
            data_type,
            ..Self::plain()
        }
    }

    /// The same with a unit and digits after the decimal point.
    pub const fn in_unit(self, unit: &'static str, decimals: u8) -> Self {
        Self {
            unit,
            decimals,
            ..self
        }
    }

    /// Sets the permitted range and the factory value, as numbers without a decimal point. For a real number they are whole numbers.
    pub const fn within(self, low: i64, high: i64, factory: i32) -> Self {
        let (least, most) = self.data_type.range();
        let fits = least <= factory as i64 && factory as i64 <= most;
        let unused = match self.data_type.size() {
            size @ 1..4 if fits => 32 - 8 * size as u32,
            // The check of the table refuses a number that does not fit.
            _ => 0,
        };
        Self {
            permitted: Permitted::Range(low, high),
            factory: match self.data_type {
                DataType::Real32 => (factory as f32).to_bits(),
                _ => factory as u32 & (u32::MAX >> unused),
            },
            ..self
        }
    }

    /// The two rows of a parameter of 64 bits with these bits as its factory value: the lower and the upper 32 bits, which has the next id
    /// and no object.
    pub const fn wide(self, factory: u64) -> [Self; 2] {
        let lower = Self {
            factory: factory as u32,
            ..self
        };
        let upper = Self {
            id: ParameterId(self.id.0 + 1),
            name: "",
            data_type: DataType::U32,
            unit: "",
            permitted: Permitted::Any,
            factory: (factory >> 32) as u32,
            ..self
        };
        [lower, upper]
    }

    /// The same with a permitted range and the factory value, as numbers without a decimal point. For a real number they are whole numbers.
    /// The limits of an unsigned number are at most 2^63 - 1.
    pub const fn wide_within(self, low: i64, high: i64, factory: i64) -> [Self; 2] {
        let limited = Self {
            permitted: Permitted::Range(low, high),
            ..self
        };
        limited.wide(match self.data_type {
            DataType::Real64 => (factory as f64).to_bits(),
            _ => factory as u64,
        })
    }

    /// A mistake in this row.
    pub(crate) const fn mistake(&self) -> Mistake<'_> {
        Mistake::parameter(self.id.0 as usize, self.name).at(self.origin)
    }
}

/// A relation that two parameters of a table must have.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Constraint {
    /// The relation.
    pub relation: Relation,
    /// The line of the row, for the message of a mistake.
    pub origin: Origin,
}

/// A relation between two parameters.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Relation {
    /// They must have different values.
    Different(ParameterId, ParameterId),
    /// `parameter` must not exceed `high` while `other` has the value `number`. Both are unsigned.
    AtMost {
        /// The parameter that is limited.
        parameter: ParameterId,
        /// The highest value of `parameter`.
        high: u16,
        /// The parameter that limits it.
        other: ParameterId,
        /// The value of `other` that limits it.
        number: u16,
    },
}

impl Constraint {
    /// The parameters must have this relation.
    #[track_caller]
    pub const fn new(relation: Relation) -> Self {
        Self {
            relation,
            origin: Origin::here(),
        }
    }

    /// Two parameters must have different values.
    #[track_caller]
    pub const fn different(one: ParameterId, other: ParameterId) -> Self {
        Self::new(Relation::Different(one, other))
    }

    /// The relations, in the form that the device uses.
    pub const fn relations<const N: usize>(constraints: &[Self]) -> [Relation; N] {
        let nothing = Relation::Different(ParameterId(0), ParameterId(0));
        let mut relations = [nothing; N];
        each!(place, constraint in constraints => { put(&mut relations, place, constraint.relation) });
        relations
    }
}

/// The id of a published value: its index in the quantities of the application.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ValueId(pub u8);

impl ValueId {
    /// The type of its number. If the application does not have the quantity, a text: no value has this type.
    pub(crate) const fn data_type(self, quantities: &[Quantity]) -> DataType {
        match get(quantities, self.0 as usize) {
            Some(quantity) => quantity.data_type,
            None => DataType::Text,
        }
    }
}

/// The description of a published value.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Quantity {
    /// The index in the table of the quantities.
    pub id: ValueId,
    /// The name in the manual. Descriptors and tools use it.
    pub name: &'static str,
    /// The type of the raw number.
    pub data_type: DataType,
    /// The unit of the value, empty if it has none.
    pub unit: &'static str,
    /// Digits after the decimal point.
    pub decimals: u8,
    /// The lowest and the highest number.
    pub range: (i64, i64),
    /// The line of the row, for the message of a mistake.
    pub origin: Origin,
}

impl Quantity {
    /// A quantity without unit that takes all values of its type.
    #[track_caller]
    pub const fn new(id: ValueId, name: &'static str, data_type: DataType) -> Self {
        Self {
            id,
            name,
            data_type,
            unit: "",
            decimals: 0,
            range: data_type.range(),
            origin: Origin::here(),
        }
    }

    /// The same with a unit and digits after the decimal point.
    pub const fn in_unit(self, unit: &'static str, decimals: u8) -> Self {
        Self {
            unit,
            decimals,
            ..self
        }
    }

    /// The same with a lowest and a highest number.
    pub const fn within(self, low: i64, high: i64) -> Self {
        Self {
            range: (low, high),
            ..self
        }
    }

    /// A mistake in this row.
    pub(crate) const fn mistake(&self) -> Mistake<'_> {
        Mistake::row("quantity", self.id.0 as usize).at(self.origin)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// All types of numbers, with their size in bytes and their range.
    const TYPES: [(DataType, u8, (i64, i64)); 6] = [
        (DataType::U8, 1, (0, 0xFF)),
        (DataType::U16, 2, (0, 0xFFFF)),
        (DataType::U32, 4, (0, 0xFFFF_FFFF)),
        (DataType::I8, 1, (-0x80, 0x7F)),
        (DataType::I16, 2, (-0x8000, 0x7FFF)),
        (DataType::I32, 4, (-0x8000_0000, 0x7FFF_FFFF)),
    ];

    #[test]
    fn size_and_range_are_those_of_two_s_complement() {
        for (data_type, size, (low, high)) in TYPES {
            assert_eq!(data_type.size(), size);
            assert_eq!(data_type.range(), (low, high));
            assert_eq!(data_type.is_signed(), low < 0);
            let mask = u32::MAX >> (32 - 8 * u32::from(size));
            assert_eq!(data_type.value(low as u32 & mask), low);
            assert_eq!(data_type.value(high as u32 & mask), high);
        }
        assert_eq!(DataType::Text.size(), 0);
    }

    #[test]
    fn discriminant_gives_the_same_type() {
        for data_type in TYPES.map(|(data_type, ..)| data_type) {
            assert_eq!(DataType::of(data_type as u8), data_type);
            assert_eq!(DataType::size_of(data_type as u8), data_type.size());
        }
        assert_eq!(DataType::of(DataType::Text as u8), DataType::Text);
        assert_eq!(DataType::size_of(DataType::Text as u8), 0);
    }

    #[test]
    fn wide_and_real_types_have_the_form_of_the_device() {
        for (data_type, size, form) in [
            (DataType::Real32, 4, DataType::I32),
            (DataType::U64, 8, DataType::Text),
            (DataType::I64, 8, DataType::Text),
            (DataType::Real64, 8, DataType::Text),
        ] {
            assert_eq!(data_type.size(), size);
            assert_eq!(data_type.is_wide(), size == 8);
            assert_eq!(DataType::of(data_type as u8 & 7), form);
            assert_eq!(DataType::size_of(data_type as u8 & 7), form.size());
        }
    }

    #[test]
    fn parameter_of_64_bits_has_two_rows() {
        let parameter = Parameter::new(ParameterId(3), "count", DataType::U64).in_unit("h", 0);
        let [lower, upper] = parameter.wide(0x0000_0002_8000_0001);
        assert_eq!((lower.id, lower.factory), (ParameterId(3), 0x8000_0001));
        assert_eq!((upper.id, upper.factory), (ParameterId(4), 2));
        assert_eq!((upper.data_type, upper.unit), (DataType::U32, ""));
    }

    #[test]
    fn builders_set_unit_decimals_range_and_factory_value() {
        let parameter = Parameter::new(ParameterId(3), "offset", DataType::I16)
            .in_unit("deg", 2)
            .within(-9000, 9000, -1);
        assert_eq!((parameter.unit, parameter.decimals), ("deg", 2));
        assert_eq!(parameter.permitted, Permitted::Range(-9000, 9000));
        assert_eq!(parameter.factory, 0xFFFF);
        let wide = Parameter::new(ParameterId(3), "offset", DataType::I32).within(-1, 1, -1);
        assert_eq!(wide.factory, 0xFFFF_FFFF);
        let quantity = Quantity::new(ValueId(1), "slope", DataType::I16).in_unit("deg", 2);
        assert_eq!((quantity.unit, quantity.decimals), ("deg", 2));
        assert_eq!(quantity.range, (-0x8000, 0x7FFF));
    }
}
