//! The values of a product's parameters: range checks, factory values, and their bytes in the stored image.
//!
//! In the image the stored values stand one behind the other in the order of the table, each in the size of its type,
//! little-endian. A table may only grow at its end: an image of an older firmware is then a prefix of the newer one's, and
//! the missing values have their factory value. Any other change of the table needs another [`Table::LAYOUT`].

use super::rule::{Limits, Refused, Rule};
use super::{Constraint, Parameter, ParameterId};
use core::fmt;
use core::marker::PhantomData;

/// The parameters of a product: the description, and what the device keeps of it.
///
/// [`project_parameters!`](crate::project_parameters) derives everything from [`FACTORY`](Self::FACTORY) on from the first two
/// constants, so that none of it can come from another description.
pub trait Table: 'static {
    /// The description; each row stands at the place of its id.
    const PARAMETERS: &'static [Parameter];
    /// What the parameters must fulfil together.
    const CONSTRAINTS: &'static [Constraint] = &[];
    /// The version of the stored layout, from 1 to 127. It changes when the table changes in another way than by new rows at its end.
    const LAYOUT: u8 = 1;

    /// A number for each parameter.
    type Numbers: Numbers;
    /// The factory values.
    const FACTORY: &'static Self::Numbers;
    /// The rules.
    const RULES: &'static [Rule];
    /// The permitted ranges that rules refer to.
    const POOL: &'static [Limits];
    /// The size in bytes of the stored values.
    const STORED_SIZE: usize;
}

/// As many numbers as a table has parameters: an array.
pub trait Numbers: Copy + AsRef<[u32]> + AsMut<[u32]> {
    /// All of them 0.
    const ZERO: Self;
}

impl<const N: usize> Numbers for [u32; N] {
    const ZERO: Self = [0; N];
}

/// Derives what the device keeps of a description of parameters; belongs into an `impl` of [`Table`](crate::param::Table) for
/// a type without generic parameters.
#[macro_export]
macro_rules! project_parameters {
    () => {
        type Numbers = [u32; <Self as $crate::param::Table>::PARAMETERS.len()];
        const FACTORY: &'static Self::Numbers =
            &$crate::param::projection::factory(<Self as $crate::param::Table>::PARAMETERS);
        const RULES: &'static [$crate::param::Rule] = &$crate::param::projection::rules::<
            { <Self as $crate::param::Table>::PARAMETERS.len() },
        >(
            <Self as $crate::param::Table>::PARAMETERS,
            <Self as $crate::param::Table>::CONSTRAINTS,
        );
        const POOL: &'static [$crate::param::Limits] = &$crate::param::projection::pool::<
            { $crate::param::projection::pool_size(<Self as $crate::param::Table>::PARAMETERS) },
        >(
            <Self as $crate::param::Table>::PARAMETERS,
        );
        const STORED_SIZE: usize =
            $crate::param::projection::stored_size(<Self as $crate::param::Table>::PARAMETERS);
    };
}

/// The values of all parameters of a product; a signed number is there as its bytes make it.
pub struct Parameters<T: Table> {
    numbers: T::Numbers,
    /// How many do not have their factory value, so that nobody need compare them all.
    changed: u8,
    table: PhantomData<T>,
}

impl<T: Table> Parameters<T> {
    /// All of them 0, before they get their values.
    pub(crate) const INITIAL: Self = Self {
        numbers: T::Numbers::ZERO,
        changed: 0,
        table: PhantomData,
    };

    /// The factory values.
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

    /// What the device keeps of a parameter's description; None when the product does not have it.
    pub fn rule(id: ParameterId) -> Option<Rule> {
        T::RULES.get(usize::from(id.0)).copied()
    }

    /// The factory value of a parameter; 0 for one that the product does not have.
    pub fn factory_value(id: ParameterId) -> u32 {
        let number = T::FACTORY.as_ref().get(usize::from(id.0));
        number.copied().unwrap_or(0)
    }

    /// Whether a parameter takes `value`, the other parameters aside.
    pub fn check(id: ParameterId, value: u32) -> Result<(), Refused> {
        match Self::rule(id) {
            Some(rule) => rule.check(value, T::POOL),
            None => Err(Refused::NotPermitted),
        }
    }

    /// Whether the values fulfil the constraints of the table.
    pub fn is_consistent(&self) -> bool {
        T::CONSTRAINTS.iter().all(|constraint| match *constraint {
            Constraint::Different(one, other) => self.get(one) != self.get(other),
            Constraint::AtMost {
                parameter,
                high,
                other,
                number,
            } => self.get(other) != number.into() || self.get(parameter) <= high.into(),
        })
    }

    /// Sets a parameter to a value that [`check`](Self::check) has let pass.
    #[inline(never)] // many callers
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

    /// True when every parameter has its factory value.
    pub fn is_factory(&self) -> bool {
        self.changed == 0
    }

    /// Takes the values of these parameters over from `other`.
    pub fn copy(&mut self, other: &Self, ids: impl IntoIterator<Item = ParameterId>) {
        for id in ids {
            self.set(id, other.get(id));
        }
    }

    /// The parameters that are stored as soon as they are written.
    pub fn stored_at_once() -> impl Iterator<Item = ParameterId> {
        let at_once = Self::rules().filter(|(_, rule)| rule.is_stored_at_once());
        at_once.map(|(id, _)| id)
    }

    /// The ids of all parameters with their rules.
    pub fn rules() -> impl Iterator<Item = (ParameterId, Rule)> {
        (0..).map(ParameterId).zip(T::RULES.iter().copied())
    }

    /// Writes the bytes of the stored values into `buffer`, [`Table::STORED_SIZE`] of them; None when it is too small.
    pub fn encode(&self, buffer: &mut [u8]) -> Option<usize> {
        let mut length = 0;
        for (id, rule) in Self::rules().filter(|(_, rule)| rule.is_stored()) {
            let size = usize::from(rule.size());
            let place = buffer.get_mut(length..length + size)?;
            for (to, from) in place.iter_mut().zip(self.get(id).to_le_bytes()) {
                *to = from;
            }
            length += size;
        }
        Some(length)
    }

    /// The values in the bytes of an image: the stored ones that it has, and the factory values of the others. None when one of
    /// them is not permitted, when they do not fulfil the constraints, or when the bytes end within a value.
    pub fn decode(bytes: &[u8]) -> Option<Self> {
        let mut parameters = Self::factory();
        parameters.restore(bytes)?;
        Some(parameters)
    }

    /// Takes the stored values in the bytes of an image over, as [`decode`](Self::decode) does. After a None they are neither what
    /// they were nor those of the image.
    pub(crate) fn restore(&mut self, mut bytes: &[u8]) -> Option<()> {
        for (id, rule) in Self::rules().filter(|(_, rule)| rule.is_stored()) {
            if bytes.is_empty() {
                break;
            }
            let (value, rest) = bytes.split_at_checked(rule.size().into())?;
            let value = number(value);
            rule.check(value, T::POOL).ok()?;
            self.set(id, value);
            bytes = rest;
        }
        self.is_consistent().then_some(())
    }
}

/// The little-endian number of at most four bytes.
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
