//! Checks of node-ID, bit rate and COB-IDs.

use super::{Mistake, Object, Parameter, ParameterId, Permitted, Target, UNCONFIGURED, parameter};
use crate::can::BitRate;
use crate::canopen::cob_id;

/// Checks the default COB-IDs.
#[track_caller]
pub(super) const fn check(objects: &[Object], parameters: &[Parameter]) {
    let mut row = 0;
    while row < objects.len() {
        let Object { index, sub, .. } = objects[row];
        match objects[row].target {
            Target::Parameter(id) if index == 0x1005 => {
                Mistake::in_object(index, sub).unless(
                    cob_id::SYNC.contain(parameters[id.0 as usize].factory),
                    "the default COB-ID of the SYNC is not free",
                );
            }
            Target::CobId(id) | Target::FreeCobId(id) => {
                let base = parameters[id.0 as usize].factory & 0x7FF;
                let mut node_id = 1;
                while node_id <= 127 {
                    if cob_id::in_use(base + node_id).is_none() {
                        Mistake::in_object(index, sub)
                            .text("the default COB-ID is not free with the node-ID ")
                            .number(node_id)
                            .fail();
                    }
                    node_id += 1;
                }
            }
            _ => {}
        }
        row += 1;
    }
}

/// Checks that the node-ID is a parameter whose factory value is a node-ID.
#[track_caller]
pub(super) const fn check_node_id(parameters: &[Parameter], id: ParameterId, lss: bool) {
    let parameter = parameter(parameters, id, "NODE_ID");
    let permits_none = match parameter.permitted {
        Permitted::Ranges(ranges) => ranges.contain(UNCONFIGURED as u32),
        _ => false,
    };
    Mistake::in_parameter(id.0 as usize, parameter.name).unless(
        permits_none || !lss,
        "a product with LSS permits the node-ID 255",
    );
    let factory = parameter.factory;
    Mistake::in_parameter(id.0 as usize, parameter.name).unless(
        (factory >= 1 && factory <= 127) || (lss && factory == UNCONFIGURED as u32),
        "the factory value is not a node-ID",
    );
}

/// Checks that each permitted number of the bit rate has a bit rate.
#[track_caller]
pub(super) const fn check_bit_rate(
    parameters: &[Parameter],
    id: ParameterId,
    codes: &[(u32, BitRate)],
) {
    let parameter = parameter(parameters, id, "BIT_RATE");
    let place = id.0 as usize;
    check_code(place, parameter, parameter.factory, codes);
    match parameter.permitted {
        Permitted::OneOf(numbers) => {
            let mut row = 0;
            while row < numbers.len() {
                check_code(place, parameter, numbers[row], codes);
                row += 1;
            }
        }
        Permitted::Named => {
            let mut row = 0;
            while row < parameter.meanings.len() {
                let (number, _) = parameter.meanings[row];
                check_code(place, parameter, number, codes);
                row += 1;
            }
        }
        Permitted::Range(low, high) => {
            let mut number = low;
            while number <= high {
                check_code(place, parameter, number as u32, codes);
                number += 1;
            }
        }
        Permitted::Any | Permitted::Ranges(_) => Mistake::in_parameter(place, parameter.name)
            .text("the bit rate permits numbers without a bit rate")
            .fail(),
    }
}

/// Checks that a number of the bit rate parameter has a bit rate.
#[track_caller]
const fn check_code(place: usize, parameter: &Parameter, number: u32, codes: &[(u32, BitRate)]) {
    let mut row = 0;
    while row < codes.len() {
        let (code, _) = codes[row];
        if code == number {
            return;
        }
        row += 1;
    }
    Mistake::in_parameter(place, parameter.name)
        .text("BIT_RATES has no bit rate for the permitted number ")
        .number(number)
        .fail();
}
