//! Checks that the description of a product is consistent. Evaluated at compile time, so an error is a compile error.

use super::table::{Assembly, Identity, Roles};
use crate::param::{DataType, Parameter, ParameterId, Persistence};

/// The longest product name (SHORT_STRING of the identity object).
const NAME_MAX: usize = 32;

/// Checks the identity, the roles, and the persistence of the parameters.
#[allow(clippy::indexing_slicing)] // evaluated at compile time only
pub const fn check(
    identity: &Identity,
    roles: &Roles,
    assemblies: &[Assembly],
    parameters: &[Parameter],
) {
    let name = identity.name;
    assert!(
        !name.is_empty() && name.len() <= NAME_MAX && name.is_ascii(),
        "a product name has 1 to 32 characters"
    );
    assert!(identity.product_code > 0, "the product code is at least 1");
    let (major, minor) = identity.revision;
    assert!(
        major >= 1 && major <= 127 && minor >= 1,
        "the revision is 1 to 127, 1 to 255"
    );
    check_role(parameters, roles.mac_id, 63);
    check_role(
        parameters,
        roles.baud_rate,
        roles.bit_rates.len() as u32 - 1,
    );
    check_role(parameters, roles.bus_off_interrupt, 1);
    check_role(parameters, roles.cos_delta, 255);
    check_selection(parameters, roles.polled_assembly, assemblies);
    check_selection(parameters, roles.cyclic_assembly, assemblies);
    let mut row = 0;
    while row < parameters.len() {
        assert!(
            parameters[row].persistence as u8 != Persistence::OnSave as u8,
            "a parameter is stored when it is written, or never"
        );
        row += 1;
    }
}

/// Checks that a parameter of the protocol is a byte that permits numbers up to `highest` only.
#[allow(clippy::indexing_slicing)] // evaluated at compile time only
const fn check_role(parameters: &[Parameter], id: ParameterId, highest: u32) {
    let parameter = &parameters[id.0 as usize];
    assert!(
        parameter.data_type as u8 == DataType::U8 as u8,
        "a parameter of the protocol is a byte"
    );
    assert!(
        highest == 255 || !crate::param::projection::permits(parameter, highest + 1),
        "a parameter of the protocol permits a number without meaning"
    );
    assert!(
        highest == 255 || crate::param::projection::permits(parameter, highest),
        "a parameter of the protocol does not permit its highest number"
    );
}

/// Checks that a parameter permits exactly the instances of the assemblies.
#[allow(clippy::indexing_slicing)] // evaluated at compile time only
const fn check_selection(parameters: &[Parameter], id: ParameterId, assemblies: &[Assembly]) {
    let parameter = &parameters[id.0 as usize];
    let mut number = 0;
    while number <= 255 {
        let (mut exists, mut place) = (false, 0);
        while place < assemblies.len() {
            exists |= assemblies[place].instance as u32 == number;
            place += 1;
        }
        assert!(
            crate::param::projection::permits(parameter, number) == exists,
            "a parameter with an assembly permits exactly the instances that exist"
        );
        number += 1;
    }
}

#[cfg(test)]
mod tests;
