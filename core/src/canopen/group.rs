//! The manufacturer-specific groups of parameters, as a product names them. The file `ranges.rs` stores and restores them.

use crate::mistake::Origin;
use crate::walk::{each, put};

/// A manufacturer-specific group of parameters: those of the objects with these indices.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Group {
    /// The first index.
    pub first: u16,
    /// The last index.
    pub last: u16,
    /// The line of the row, for the message of a mistake.
    pub origin: Origin,
}

impl Group {
    /// The group with the indices from `first` to `last`, 2000h to 5FFFh.
    #[track_caller]
    pub const fn new(first: u16, last: u16) -> Self {
        Self {
            first,
            last,
            origin: Origin::here(),
        }
    }

    /// The indices of these groups, in the form that the device uses.
    pub const fn indices<const N: usize>(groups: &[Self]) -> [(u16, u16); N] {
        let mut indices = [(0, 0); N];
        each!(place, group in groups => { put(&mut indices, place, (group.first, group.last)) });
        indices
    }
}
