//! A set of parameters.

use super::{Constraint, ParameterId, Relation};
use crate::walk::each;

/// A set of parameters: one bit for each.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct ParameterSet {
    words: [u32; WORDS],
}

const WORDS: usize = 4;

#[expect(
    clippy::indexing_slicing,
    reason = "the index is below the number of words"
)]
impl ParameterSet {
    /// The number of ids that a set can contain: 0 to `CAPACITY` - 1.
    pub const CAPACITY: usize = 32 * WORDS;

    /// The set without parameters.
    pub const EMPTY: Self = Self { words: [0; WORDS] };

    /// The set of these parameters.
    pub const fn of(ids: &[ParameterId]) -> Self {
        let mut set = Self::EMPTY;
        each!(id in ids => { set = set.with(*id) });
        set
    }

    /// The parameters that are part of one of these constraints.
    pub const fn constrained(constraints: &[Constraint]) -> Self {
        let mut set = Self::EMPTY;
        each!(constraint in constraints => {
            let (Relation::Different(one, other)
            | Relation::AtMost {
                parameter: one,
                other,
                ..
            }) = constraint.relation;
            set = set.with(one).with(other);
        });
        set
    }

    /// This set with one more parameter.
    pub const fn with(mut self, id: ParameterId) -> Self {
        self.words[word(id)] |= bit(id);
        self
    }

    /// Whether a parameter is in the set.
    pub const fn contains(&self, id: ParameterId) -> bool {
        self.words[word(id)] & bit(id) != 0
    }
}

/// The word of a parameter. Ids above the capacity alias lower ones; no table has them.
const fn word(id: ParameterId) -> usize {
    id.0 as usize / 32 % WORDS
}

const fn bit(id: ParameterId) -> u32 {
    1 << (id.0 % 32)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn set_contains_exactly_the_inserted_ids() {
        let ids = [0, 31, 32, 63, 64, 95, 96, 127].map(ParameterId);
        let set = ParameterSet::of(&ids);
        for id in 0..ParameterSet::CAPACITY as u8 {
            let id = ParameterId(id);
            assert_eq!(set.contains(id), ids.contains(&id));
            assert!(!ParameterSet::EMPTY.contains(id));
        }
        assert_eq!(ParameterSet::CAPACITY, 128);
    }

    #[test]
    fn both_parameters_of_a_constraint_are_constrained() {
        let [a, b, c, d] = [3, 40, 70, 100].map(ParameterId);
        let constraints = [
            Constraint::different(a, b),
            Constraint::new(Relation::AtMost {
                parameter: c,
                high: 8,
                other: d,
                number: 2,
            }),
        ];
        let set = ParameterSet::constrained(&constraints);
        assert_eq!(set, ParameterSet::of(&[a, b, c, d]));
    }
}
