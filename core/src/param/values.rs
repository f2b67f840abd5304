//! The values of the parameters of a product: range checks, factory values and the stored image.
//!
//! The image contains the stored values in the order of the table, each in the size of its type, little-endian. New parameters
//! may be added only at the end of a table. Then the image of an older firmware is a prefix of the image of a newer one, and the
//! missing values get their factory values. Any other change of the table requires another [`Table::LAYOUT`].

use super::row::{Limits, ParameterRow, Refused};
use super::wide::WideLimits;
use super::{Constraint, Parameter, ParameterId, Relation};
use crate::store::Buffer;
use core::fmt;
use core::marker::PhantomData;

/// The parameters of a product: their description, and the form that the device uses.
///
/// [`project!(parameters)`](crate::project) derives `Numbers`, `FACTORY`, `PARAMETER_ROWS`, `RELATIONS`, `POOL`, `STORED_SIZE`, `REALS` and
/// `WIDE_LIMITS` from `PARAMETERS` and `CONSTRAINTS`, so that they always match.
pub trait Table: Send + 'static {
    /// The description; the id of each row is its index.
    const PARAMETERS: &'static [Parameter];
    /// The conditions for two parameters together, which each write must keep.
    const CONSTRAINTS: &'static [Constraint] = &[];
    /// The version of the stored layout, from 1 to 255. It must change if the table changes other than by new rows at its end.
    const LAYOUT: u8 = 1;
    /// Whether a device stores its usage beside its parameters, and has [diagnostic data](crate::diagnosis). If not, an image does not contain
    /// the code for it.
    const KEEPS_USAGE: bool = true;

    /// An array with a number for each parameter.
    type Numbers: Numbers;
    /// The factory value of each parameter.
    const FACTORY: &'static Self::Numbers;
    /// The parameters in the form that the device uses.
    const PARAMETER_ROWS: &'static [ParameterRow];
    /// The relations of the constraints.
    const RELATIONS: &'static [Relation];
    /// The permitted ranges of the rows.
    const POOL: &'static [Limits];
    /// The size in bytes of the stored values.
    const STORED_SIZE: usize;
    /// The buffer of a [`Store`](crate::store::Store) for the parameters.
    type Buffer: Buffer;
    /// Whether a parameter is a real number.
    const REALS: bool;
    /// The limits of the parameters of 64 bits.
    const WIDE_LIMITS: &'static [WideLimits];
}

/// An array with a number for each parameter.
pub trait Numbers: Copy + Send + AsRef<[u32]> + AsMut<[u32]> {
    /// The number 0 for each parameter.
    const ZERO: Self;
}

impl<const N: usize> Numbers for [u32; N] {
    const ZERO: Self = [0; N];
}

/// The values of all parameters of a product, as raw numbers: FFFFh is -1 in an [`I16`](crate::param::DataType::I16).
pub struct Parameters<T: Table> {
    numbers: T::Numbers,
    /// The number of parameters that do not have their factory value, so that `is_factory` is short.
    changed: u8,
    table: PhantomData<T>,
}

impl<T: Table> Parameters<T> {
    /// All values 0, before the start.
    pub(crate) const INITIAL: Self = Self {
        numbers: T::Numbers::ZERO,
        changed: 0,
        table: PhantomData,
    };

    /// All parameters with their factory values; none is changed.
    pub fn factory() -> Self {
        Self {
            numbers: *T::FACTORY,
            changed: 0,
            table: PhantomData,
        }
    }

    /// The value of a parameter; 0 for one that the product does not have.
    pub fn get(&self, id: ParameterId) -> u32 {
        let number = self.numbers.as_ref().get(usize::from(id.0));
        number.copied().unwrap_or(0)
    }

    /// The row of a parameter; None if the product does not have it.
    pub fn row(id: ParameterId) -> Option<ParameterRow> {
        T::PARAMETER_ROWS.get(usize::from(id.0)).copied()
    }

    /// The factory value of a parameter; 0 for one that the product does not have.
    pub fn factory_value(id: ParameterId) -> u32 {
        let number = T::FACTORY.as_ref().get(usize::from(id.0));
        number.copied().unwrap_or(0)
    }

    /// Whether `value` is permitted for a parameter, independent of the other parameters.
    pub fn check(id: ParameterId, value: u32) -> Result<(), Refused> {
        match Self::row(id) {
            Some(row) => Self::check_row(row, value),
            None => Err(Refused::NotPermitted),
        }
    }

    /// Whether a number is permitted for a parameter of 64 bits, without regard to the others.
    pub fn check_wide(id: ParameterId, value: u64) -> Result<(), Refused> {
        let limits = T::WIDE_LIMITS.iter().find(|limits| limits.id == id);
        limits.map_or(Ok(()), |limits| limits.check(value))
    }

    /// The number of a parameter of 64 bits: that of its row and of the next one.
    pub fn get_wide(&self, id: ParameterId) -> u64 {
        let upper = ParameterId(id.0.wrapping_add(1));
        u64::from(self.get(upper)) << 32 | u64::from(self.get(id))
    }

    fn check_row(row: ParameterRow, value: u32) -> Result<(), Refused> {
        if T::REALS && row.is_real() {
            return row.check_real(value, T::POOL);
        }
        row.check(value, T::POOL)
    }

    /// Whether the values fulfil the constraints of the table.
    pub fn is_consistent(&self) -> bool {
        T::RELATIONS.iter().all(|relation| match *relation {
            Relation::Different(one, other) => self.get(one) != self.get(other),
            Relation::AtMost {
                parameter,
                high,
                other,
                number,
            } => self.get(other) != number.into() || self.get(parameter) <= high.into(),
        })
    }

    /// Sets a parameter. The value must have passed [`check`](Self::check).
    #[inline(never)] // measured: it is called in many places, and the answers do not take longer
    pub fn set(&mut self, id: ParameterId, value: u32) {
        let place = usize::from(id.0);
        let number = self.numbers.as_mut().get_mut(place);
        if let (Some(number), Some(&factory)) = (number, T::FACTORY.as_ref().get(place)) {
            let before = *number != factory;
            let now = value != factory;
            *number = value;
            // Each parameter counts at most once.
            self.changed = self
                .changed
                .wrapping_add(now.into())
                .wrapping_sub(before.into());
        }
    }

    /// True if all parameters have their factory values.
    pub fn is_factory(&self) -> bool {
        self.changed == 0
    }

    /// Copies the values of these parameters from `other`.
    pub fn copy(&mut self, other: &Self, ids: impl IntoIterator<Item = ParameterId>) {
        for id in ids {
            self.set(id, other.get(id));
        }
    }

    /// The parameters that are stored when they are written.
    pub fn stored_at_once() -> impl Iterator<Item = ParameterId> {
        let at_once = Self::rows().filter(|(_, row)| row.is_stored_at_once());
        at_once.map(|(id, _)| id)
    }

    /// The ids of all parameters with their rows.
    pub fn rows() -> impl Iterator<Item = (ParameterId, ParameterRow)> {
        (0..)
            .map(ParameterId)
            .zip(T::PARAMETER_ROWS.iter().copied())
    }

    /// Writes the stored values into `buffer`. Returns their length, which is [`Table::STORED_SIZE`] bytes; None if the buffer is
    /// too small.
    pub fn encode(&self, buffer: &mut [u8]) -> Option<usize> {
        let mut length = 0;
        for (id, row) in Self::rows().filter(|(_, row)| row.is_stored()) {
            let size = usize::from(row.size());
            let place = buffer.get_mut(length..length + size)?;
            for (to, from) in place.iter_mut().zip(self.get(id).to_le_bytes()) {
                *to = from;
            }
            length += size;
        }
        Some(length)
    }

    /// The values of an image; parameters that are not in the image get their factory values. None if a value is not permitted,
    /// if the values do not fulfil the constraints, or if the image ends within a value.
    pub fn decode(bytes: &[u8]) -> Option<Self> {
        let mut parameters = Self::factory();
        parameters.restore(bytes)?;
        Some(parameters)
    }

    /// Sets the values of an image, like [`decode`](Self::decode). If it returns None, the values are undefined: some of them may
    /// have changed.
    pub(crate) fn restore(&mut self, mut bytes: &[u8]) -> Option<()> {
        for (id, row) in Self::rows().filter(|(_, row)| row.is_stored()) {
            if bytes.is_empty() {
                break;
            }
            let (value, rest) = bytes.split_at_checked(row.size().into())?;
            let value = number(value);
            Self::check_row(row, value).ok()?;
            self.set(id, value);
            bytes = rest;
        }
        let mut wide = T::WIDE_LIMITS.iter();
        let fit = wide.all(|limits| limits.permit(self.get_wide(limits.id)));
        (fit && self.is_consistent()).then_some(())
    }
}

/// The little-endian number in at most four bytes.
pub fn number(bytes: &[u8]) -> u32 {
    let digits = bytes.iter().rev();
    digits.fold(0, |number, &byte| number << 8 | u32::from(byte))
}

impl<T: Table> Clone for Parameters<T> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<T: Table> Copy for Parameters<T> {}

impl<T: Table> PartialEq for Parameters<T> {
    fn eq(&self, other: &Self) -> bool {
        self.numbers.as_ref() == other.numbers.as_ref()
    }
}

impl<T: Table> Eq for Parameters<T> {}

impl<T: Table> fmt::Debug for Parameters<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let numbers = self.numbers.as_ref().iter();
        let named = T::PARAMETERS.iter().map(|parameter| parameter.name);
        f.debug_map().entries(named.zip(numbers)).finish()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::param::{DataType, Persistence};

    const A: ParameterId = ParameterId(0);
    const B: ParameterId = ParameterId(1);
    const VOLATILE: ParameterId = ParameterId(2);
    const C: ParameterId = ParameterId(3);

    const PARAMETERS: [Parameter; 4] = [
        Parameter::new(A, "a", DataType::U8).within(1, 9, 1),
        Parameter::new(B, "b", DataType::U16).within(0, 1000, 2),
        Parameter {
            persistence: Persistence::Volatile,
            ..Parameter::new(VOLATILE, "volatile", DataType::U8)
        },
        Parameter::new(C, "c", DataType::U8).within(1, 9, 3),
    ];

    /// The firmware before `c` was added.
    struct Older;

    impl Table for Older {
        const PARAMETERS: &'static [Parameter] = {
            let [a, b, volatile, _] = PARAMETERS;
            &[a, b, volatile]
        };
        crate::project!(parameters);
    }

    struct Newer;

    impl Table for Newer {
        const PARAMETERS: &'static [Parameter] = &PARAMETERS;
        const CONSTRAINTS: &'static [Constraint] = &[Constraint::different(A, C)];
        crate::project!(parameters);
    }

    fn values<T: Table>(bytes: &[u8]) -> Option<[u32; 3]> {
        let parameters = Parameters::<T>::decode(bytes)?;
        Some([A, B, C].map(|id| parameters.get(id)))
    }

    #[test]
    fn newer_firmware_keeps_the_values_of_an_older_image() {
        let mut older = Parameters::<Older>::factory();
        older.set(A, 7);
        older.set(B, 500);
        let mut image = [0; Older::STORED_SIZE];
        assert_eq!(older.encode(&mut image), Some(3));
        assert_eq!(image, [7, 0xF4, 0x01]);
        assert_eq!(values::<Newer>(&image), Some([7, 500, 3]));
        assert_eq!(values::<Newer>(&[]), Some([1, 2, 3]));
    }

    #[test]
    fn older_firmware_ignores_the_values_that_it_does_not_know() {
        let mut newer = Parameters::<Newer>::factory();
        newer.set(B, 500);
        newer.set(C, 9);
        let mut image = [0; Newer::STORED_SIZE];
        assert_eq!(newer.encode(&mut image), Some(4));
        let older = Parameters::<Older>::decode(&image).unwrap();
        assert_eq!((older.get(A), older.get(B)), (1, 500));
    }

    #[test]
    fn image_with_a_value_that_is_not_permitted_is_refused() {
        assert_eq!(values::<Newer>(&[0, 0, 0, 3]), None, "a is too low");
        assert_eq!(values::<Newer>(&[1, 0xE9, 0x03, 3]), None, "b is too high");
        assert_eq!(values::<Newer>(&[1, 0]), None, "b is cut off");
        assert_eq!(values::<Newer>(&[5, 0, 0, 5]), None, "a and c are equal");
        // The factory value of c contradicts a.
        assert_eq!(values::<Newer>(&[3, 0, 0]), None);
        assert_eq!(values::<Newer>(&[5, 0, 0, 6]), Some([5, 0, 6]));
    }

    #[test]
    fn image_does_not_fit_into_a_shorter_buffer() {
        let newer = Parameters::<Newer>::factory();
        assert_eq!(newer.encode(&mut [0; 3]), None);
        assert_eq!(newer.encode(&mut [0; 5]), Some(4));
    }

    #[test]
    fn parameters_are_equal_exactly_if_all_values_are() {
        let factory = Parameters::<Newer>::factory();
        for id in [A, B, VOLATILE, C] {
            let mut changed = factory;
            assert_eq!(changed, factory);
            changed.set(id, 5);
            assert_ne!(changed, factory, "{id:?}");
        }
    }

    #[test]
    fn debug_format_names_each_parameter() {
        let factory = Parameters::<Newer>::factory();
        let text = std::format!("{factory:?}");
        assert_eq!(text, r#"{"a": 1, "b": 2, "volatile": 0, "c": 3}"#);
    }
}
