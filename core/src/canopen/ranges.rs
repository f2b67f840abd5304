//! Groups of stored parameters by ranges of their indices (1010h, 1011h; CiA 301, 7.5.2.13 and 7.5.2.14).
//!
//! | sub-index       | parameters                                                     |
//! |-----------------|----------------------------------------------------------------|
//! | 1               | all                                                            |
//! | 2               | of the communication profile, 1000h to 1FFFh                   |
//! | 3               | of the device profile, 6000h to 9FFFh                          |
//! | 4 and following | manufacturer-specific, in the ranges of [`Product::GROUPS`]    |
//!
//! Parameters without an object belong to sub-index 4. A restore stores the factory values. They act after a reset: those of the
//! communication profile after reset communication, the others after reset node, node-ID and bit rate after power-up.

use super::dictionary::{Object, Service, Target};
use super::product::{ContextOf, ParametersOf, Product};
use super::protocol::Services;
use super::row::Kind;
use super::sdo::Written;
use crate::param::{ParameterSet, Parameters};
use crate::walk::each;

/// The sub-index with all parameters.
const ALL: u8 = 1;
/// The sub-index of the first manufacturer-specific group.
pub(super) const MAKER: u8 = 4;

/// The indices of a group; None: there is no such group, or it has all parameters.
fn indices(groups: &[(u16, u16)], sub: u8) -> Option<(u16, u16)> {
    match sub {
        2 => Some((0x1000, 0x1FFF)),
        3 => Some((0x6000, 0x9FFF)),
        MAKER.. => groups.get(usize::from(sub - MAKER)).copied(),
        _ => None,
    }
}

/// Whether the dictionary stores or restores groups.
const fn has_groups(objects: &[Object]) -> bool {
    each!(object in objects => {
        if let Target::Service(Service::StoreGroup | Service::RestoreGroup) = object.target {
            return true;
        }
    });
    false
}

impl<P: Product> Services<P> {
    /// Whether the product has groups of parameters.
    pub(super) const HAS_RANGES: bool = has_groups(P::OBJECTS);

    /// Stores the present values of a group of parameters, while no other save is running.
    pub(super) fn store_range(&mut self, cx: &mut ContextOf<P>, sub: u8) -> Written {
        let present = cx.parameters;
        self.save_range(cx, sub, &present)
    }

    /// Stores the factory values of a group of parameters, while no other save is running.
    pub(super) fn restore_range(&mut self, cx: &mut ContextOf<P>, sub: u8) -> Written {
        self.save_range(cx, sub, &Parameters::factory())
    }

    fn save_range(&mut self, cx: &mut ContextOf<P>, sub: u8, from: &ParametersOf<P>) -> Written {
        let group = group::<P>(sub);
        let stored = ParametersOf::<P>::rows().filter(|(_, row)| row.is_stored());
        let members = stored.filter(|(id, _)| sub == ALL || group.contains(*id));
        let mut parameters = self.saved.parameters;
        let mut is_empty = true;
        for (id, _) in members {
            parameters.set(id, from.get(id));
            is_empty = false;
        }
        if is_empty {
            return Written::Done;
        }
        self.save_these(cx, parameters);
        Written::Storing
    }
}

fn group<P: Product>(sub: u8) -> ParameterSet {
    let (mut group, mut described) = (ParameterSet::EMPTY, ParameterSet::EMPTY);
    let indices = indices(P::GROUP_INDICES, sub);
    for row in P::ROWS {
        if matches!(row.kind(), Kind::Parameter | Kind::CobId | Kind::Command) {
            described = described.with(row.id());
            if indices.is_some_and(|(first, last)| (first..=last).contains(&row.index())) {
                group = group.with(row.id());
            }
        }
    }
    if sub == MAKER {
        for (id, _) in ParametersOf::<P>::rows() {
            if !described.contains(id) {
                group = group.with(id);
            }
        }
    }
    group
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn indices_of_each_sub_index_are_those_of_cia_301() {
        let groups = [(0x2000, 0x20FF), (0x2100, 0x5FFF)];
        let expected = [
            (0, None),
            (1, None),
            (2, Some((0x1000, 0x1FFF))),
            (3, Some((0x6000, 0x9FFF))),
            (4, Some((0x2000, 0x20FF))),
            (5, Some((0x2100, 0x5FFF))),
            (6, None),
            (255, None),
        ];
        for (sub, range) in expected {
            assert_eq!(indices(&groups, sub), range, "{sub}");
        }
    }
}
