//! A set of parameters.

use super::{Constraint, ParameterId};

/// A set of parameters: one bit for each.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct ParameterSet {
    words: [u32; WORDS],
}

const WORDS: usize = 4;

#[allow(clippy::indexing_slicing)] // the index is below the number of words
impl ParameterSet {
    /// The parameters that are part of one of these constraints.
    #[allow(clippy::indexing_slicing)] // evaluated at compile time only
    pub const fn constrained(constraints: &[Constraint]) -> Self {
        let (mut set, mut row) = (Self::EMPTY, 0);
        while row < constraints.len() {
            let (Constraint::Different(one, other)
            | Constraint::AtMost {
                parameter: one,
                other,
                ..
            }) = constraints[row];
            set = set.with(one).with(other);
            row += 1;
        }
        set
    }

    /// The number of ids that a set can contain: 0 to `CAPACITY` - 1.
    pub const CAPACITY: usize = 32 * WORDS;

    /// The empty set.
    pub const EMPTY: Self = Self { words: [0; WORDS] };

    /// All parameters.
    pub const ALL: Self = Self {
        words: [u32::MAX; WORDS],
    };

    /// The set of these parameters.
    pub const fn of(ids: &[ParameterId]) -> Self {
        let mut set = Self::EMPTY;
        let mut place = 0;
        while place < ids.len() {
            set = set.with(ids[place]);
            place += 1;
        }
        set
    }

    /// This set with one more parameter.
    pub const fn with(mut self, id: ParameterId) -> Self {
        self.words[word(id)] |= bit(id);
        self
    }

    /// Adds a parameter.
    pub fn insert(&mut self, id: ParameterId) {
        *self = self.with(id);
    }

    /// Whether a parameter is in the set.
    pub const fn contains(&self, id: ParameterId) -> bool {
        self.words[word(id)] & bit(id) != 0
    }

    /// Whether the sets have a common parameter.
    pub const fn intersects(&self, other: &Self) -> bool {
        let [a, b, c, d] = self.words;
        let [e, f, g, h] = other.words;
        (a & e) | (b & f) | (c & g) | (d & h) != 0
    }

    /// The parameters of both sets.
    pub const fn union(&self, other: &Self) -> Self {
        let [a, b, c, d] = self.words;
        let [e, f, g, h] = other.words;
        Self {
            words: [a | e, b | f, c | g, d | h],
        }
    }

    /// Whether the set is empty.
    pub const fn is_empty(&self) -> bool {
        let [a, b, c, d] = self.words;
        a | b | c | d == 0
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
        let ids = [0, 31, 32, 63, 64, 127].map(ParameterId);
        let set = ParameterSet::of(&ids);
        for id in 0..ParameterSet::CAPACITY as u8 {
            let id = ParameterId(id);
            assert_eq!(set.contains(id), ids.contains(&id));
            assert!(ParameterSet::ALL.contains(id));
            assert!(!ParameterSet::EMPTY.contains(id));
        }
        assert!(ParameterSet::EMPTY.is_empty() && !set.is_empty());
    }

    /// The first and the last id of each word.
    const IDS: [u8; 8] = [0, 31, 32, 63, 64, 95, 96, 127];

    #[test]
    fn inserted_ids_are_in_the_set() {
        let mut set = ParameterSet::EMPTY;
        for (number, id) in IDS.into_iter().enumerate() {
            assert!(!set.contains(ParameterId(id)));
            set.insert(ParameterId(id));
            assert_eq!(set, ParameterSet::of(&IDS.map(ParameterId)[..=number]));
        }
    }

    #[test]
    fn set_with_any_id_is_not_empty() {
        for id in IDS {
            assert!(!ParameterSet::of(&[ParameterId(id)]).is_empty());
        }
        assert_eq!(ParameterSet::CAPACITY, 128);
    }

    #[test]
    fn sets_intersect_exactly_if_they_have_a_common_id() {
        for one in IDS {
            for other in IDS {
                let set = ParameterSet::of(&[ParameterId(one)]);
                let more = ParameterSet::of(&[ParameterId(other)]);
                assert_eq!(set.intersects(&more), one == other);
                assert_eq!(set.union(&more), set.with(ParameterId(other)));
            }
        }
        let all = ParameterSet::of(&IDS.map(ParameterId));
        assert_eq!(all.union(&all), all);
        assert!(all.intersects(&all));
        assert!(!all.intersects(&ParameterSet::EMPTY));
    }

    #[test]
    fn both_parameters_of_a_constraint_are_constrained() {
        let [a, b, c, d] = [3, 40, 70, 100].map(ParameterId);
        let constraints = [
            Constraint::Different(a, b),
            Constraint::AtMost {
                parameter: c,
                high: 8,
                other: d,
                number: 2,
            },
        ];
        let set = ParameterSet::constrained(&constraints);
        assert_eq!(set, ParameterSet::of(&[a, b, c, d]));
    }
}
