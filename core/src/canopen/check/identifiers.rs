//! Checks of node-ID, bit rate and COB-IDs.

use super::{LssTable, Mistake, Object, Parameter, ParameterId, Target, UNCONFIGURED, parameter};
use crate::can::BitRate;
use crate::canopen::cob_id;
use crate::param::projection::permits;
use crate::param::{Permitted, Persistence};
use crate::walk::{at, each};

/// Checks the default COB-IDs.
#[track_caller]
pub(super) const fn check(objects: &[Object], parameters: &[Parameter]) {
    each!(object in objects => {
        let mistake = object.mistake();
        match object.target {
            Target::Parameter(id) if object.index == 0x1005 => {
                mistake.unless(
                    cob_id::SYNC.contain(at(parameters, id.0 as usize).factory),
                    "the default COB-ID of the SYNC is not free",
                );
            }
            Target::CobId(id) | Target::FreeCobId(id) => {
                let base = base(parameters, id);
                if base & 0x7F != 0 {
                    mistake
                        .text("the node-ID is added to the default COB-ID, which is without it, for example ")
                        .hexadecimal(base & !0x7F, 3)
                        .text("h")
                        .fail();
                }
                let mut node_id = 1;
                while node_id <= 127 {
                    if cob_id::in_use(base + node_id).is_none() {
                        mistake
                            .text("the default COB-ID is not free with the node-ID ")
                            .number(node_id)
                            .fail();
                    }
                    node_id += 1;
                }
                check_base(mistake, objects, object, parameters, base);
            }
            _ => {}
        }
    });
}

/// The default COB-ID without flags and node-ID.
const fn base(parameters: &[Parameter], id: ParameterId) -> u32 {
    at(parameters, id.0 as usize).factory & 0x7FF
}

/// Checks that the default COB-ID of a service is that of no other service of this or another node.
#[track_caller]
const fn check_base(
    mistake: Mistake,
    objects: &[Object],
    object: &Object,
    parameters: &[Parameter],
    base: u32,
) {
    mistake.unless(
        base >= 0x180 || !matches!(object.index, 0x1800..0x1A00),
        "the default COB-ID is that of an EMCY",
    );
    each!(other in objects => {
        if other.index == object.index {
            break;
        }
        if let Target::CobId(id) | Target::FreeCobId(id) = other.target {
            mistake.unless(
                base != at(parameters, id.0 as usize).factory & 0x7FF,
                "another object has this default COB-ID",
            );
        }
    });
}

/// Checks that the node-ID is a parameter whose factory value is a node-ID.
#[track_caller]
pub(super) const fn check_node_id(parameters: &[Parameter], id: ParameterId, lss: bool) {
    let parameter = parameter(parameters, id, "NODE_ID");
    let permits_none = match parameter.permitted {
        Permitted::Ranges(ranges) => ranges.contain(UNCONFIGURED as u32),
        _ => false,
    };
    parameter.mistake().unless(
        permits_none || !lss,
        "a product with LSS permits the node-ID 255",
    );
    check_stored(parameter, lss);
    let factory = parameter.factory;
    parameter.mistake().unless(
        is_node_id(factory, lss),
        "the factory value is not a node-ID",
    );
    let mut number = 0;
    while number <= u8::MAX as u32 {
        if permits(parameter, number) && !is_node_id(number, lss) {
            parameter
                .mistake()
                .text("it permits ")
                .number(number)
                .text(", which is not a node-ID")
                .fail();
        }
        number += 1;
    }
}

/// Whether a number is a node-ID, or with LSS none.
const fn is_node_id(number: u32, lss: bool) -> bool {
    matches!(number, 1..=127) || lss && number == UNCONFIGURED as u32
}

/// Checks that store configuration of LSS can store a parameter.
#[track_caller]
pub(super) const fn check_stored(parameter: &Parameter, lss: bool) {
    parameter.mistake().unless(
        !lss || !matches!(parameter.persistence, Persistence::Volatile),
        "a product with LSS stores node-ID and bit rate",
    );
}

/// Checks that LSS can set each bit rate of the manufacturer's tables.
#[track_caller]
pub(super) const fn check_lss_rates(
    tables: &[LssTable],
    codes: &[(u32, BitRate)],
    parameter: &Parameter,
) {
    each!(place, table in tables => {
        each!(index, rate in table.rates => {
            if let Some(rate) = rate
                && !is_permitted(*rate, codes, parameter)
            {
                table.mistake(place)
                    .text("the product does not permit the bit rate at index ")
                    .number(index as u32)
                    .text(", ")
                    .text(rate.name())
                    .text(": see BIT_RATES")
                    .fail();
            }
        });
    });
}

/// Whether the parameter permits the number of a bit rate.
const fn is_permitted(rate: BitRate, codes: &[(u32, BitRate)], parameter: &Parameter) -> bool {
    each!((code, own) in codes => {
        if *own as u8 == rate as u8 {
            return permits(parameter, *code);
        }
    });
    false
}

/// Checks that each permitted number of the bit rate has a bit rate.
#[track_caller]
pub(super) const fn check_bit_rate(
    parameters: &[Parameter],
    id: ParameterId,
    codes: &[(u32, BitRate)],
) {
    let parameter = parameter(parameters, id, "BIT_RATE");
    check_code(parameter, parameter.factory, codes);
    match parameter.permitted {
        Permitted::OneOf(numbers) => {
            each!(number in numbers => { check_code(parameter, *number, codes) });
        }
        Permitted::Named => {
            each!((number, _) in parameter.meanings => {
                check_code(parameter, *number, codes);
            });
        }
        Permitted::Range(low, high) => {
            let mut number = low;
            while number <= high {
                check_code(parameter, number as u32, codes);
                number += 1;
            }
        }
        Permitted::Any | Permitted::Ranges(_) => parameter
            .mistake()
            .text("the bit rate permits numbers without a bit rate")
            .fail(),
    }
}

/// Checks that a number of the bit rate parameter has a bit rate.
#[track_caller]
const fn check_code(parameter: &Parameter, number: u32, codes: &[(u32, BitRate)]) {
    each!((code, _) in codes => {
        if *code == number {
            return;
        }
    });
    parameter
        .mistake()
        .text("BIT_RATES has no bit rate for the permitted number ")
        .number(number)
        .fail();
}
