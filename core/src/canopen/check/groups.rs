//! Checks of the groups of stored parameters (1010h, 1011h).

use super::{Mistake, Object, Parameter, ParameterId, Service, Target, mistake_at, object_at};
use crate::canopen::group::Group;
use crate::canopen::ranges::MAKER;
use crate::param::Persistence;
use crate::walk::{at, each};

/// Checks that a group of parameters exists for each sub-index of 1010h and 1011h that stores or restores a group.
#[track_caller]
pub(super) const fn check(objects: &[Object], groups: &[Group], parameters: &[Parameter]) {
    each!(object in objects => {
        let Object { index, sub, .. } = *object;
        if let Target::Service(Service::StoreGroup | Service::RestoreGroup) = object.target {
            let is_group = sub >= 1 && (sub as usize) < MAKER as usize + groups.len();
            mistake_at(objects, index, sub).unless(
                matches!(index, 0x1010 | 0x1011) && is_group,
                "there is no group of parameters for this sub-index",
            );
            mistake_at(objects, index, 1).unless(
                object_at(objects, index, 1).is_some(),
                "an object with groups has sub-index 1, all parameters",
            );
        }
    });
    each!(place, group in groups => {
        let Group { first, last, origin } = *group;
        let mistake = Mistake::row("GROUPS", place).at(origin);
        mistake.unless(
            first <= last && first >= 0x2000 && last < 0x6000,
            "a manufacturer-specific index is 2000h to 5FFFh",
        );
        each!(other in groups.split_at(place).0 => {
            mistake.unless(
                last < other.first || other.last < first,
                "another group has some of these indices",
            );
        });
        let sub = MAKER as usize + place;
        mistake.unless(
            place == 0 || is_service(objects, 0x1010, sub) || is_service(objects, 0x1011, sub),
            "neither 1010h nor 1011h has a sub-index for this group",
        );
        // The hidden parameters are in the first group.
        mistake.unless(
            place == 0 || has_stored(objects, (first, last), parameters),
            "no object of this group is a stored parameter",
        );
    });
    if is_service(objects, 0x1010, MAKER as usize) {
        check_all(objects, groups, parameters);
    }
}

/// Checks that a group has each stored parameter of the manufacturer.
#[track_caller]
const fn check_all(objects: &[Object], groups: &[Group], parameters: &[Parameter]) {
    each!(object in objects => {
        if matches!(object.index, 0x2000..0x6000) && is_stored(object, parameters) {
            let mut found = false;
            each!(group in groups => {
                found |= group.first <= object.index && object.index <= group.last;
            });
            object.mistake()
                .unless(found, "no group in `GROUPS` has this stored parameter");
        }
    });
}

/// Whether one of these objects is a stored parameter.
const fn has_stored(
    objects: &[Object],
    (first, last): (u16, u16),
    parameters: &[Parameter],
) -> bool {
    each!(object in objects => {
        if first <= object.index && object.index <= last && is_stored(object, parameters) {
            return true;
        }
    });
    false
}

/// Whether an object is a stored parameter.
const fn is_stored(object: &Object, parameters: &[Parameter]) -> bool {
    match object.target {
        Target::Parameter(ParameterId(id)) => {
            let persistence = at(parameters, id as usize).persistence;
            !matches!(persistence, Persistence::Volatile)
        }
        _ => false,
    }
}

/// Whether an object with groups has this sub-index.
const fn is_service(objects: &[Object], index: u16, sub: usize) -> bool {
    sub <= u8::MAX as usize && object_at(objects, index, sub as u8).is_some()
}
