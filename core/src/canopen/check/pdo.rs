//! Checks of the TPDOs and their mapping.

use super::{DataType, Mistake, Object, Parameter, Quantity, Target, Tpdos, mistake_at, object_at};
use crate::walk::{at, each};

/// The maximum number of bytes in a TPDO. Each byte can be an object.
const BYTES: usize = 8;

/// The sub-indices of the communication parameter that the protocol uses, and their types.
const SETTINGS: [(u8, DataType); 4] = [
    (1, DataType::U32),
    (2, DataType::U8),
    (3, DataType::U16),
    (5, DataType::U16),
];

const OTHER_NUMBER: &str = "the number of TPDOs is not that of the dictionary";

#[track_caller]
pub(super) const fn check_tpdos<T: Tpdos>(
    objects: &[Object],
    parameters: &[Parameter],
    quantities: &[Quantity],
) {
    let mut number = 0;
    while (number as usize) < T::COUNT {
        check_present(objects, 0x1800 + number, 1);
        check_present(objects, 0x1A00 + number, 0);
        check_settings(objects, 0x1800 + number, parameters, quantities);
        if T::DYNAMIC {
            check_dynamic(objects, number, T::ENTRIES, parameters, quantities);
        } else {
            check_mapping::<T>(objects, number, parameters, quantities);
        }
        number += 1;
    }
    each!(object in objects => {
        let number = match (object.index, object.sub) {
            (index @ 0x1800..0x1A00, 1) => index - 0x1800,
            (index @ 0x1A00..0x1C00, 0) => index - 0x1A00,
            _ => continue,
        };
        object.mistake().unless((number as usize) < T::COUNT, OTHER_NUMBER);
    });
}

/// Checks that an object of a TPDO is there.
#[track_caller]
const fn check_present(objects: &[Object], index: u16, sub: u8) {
    mistake_at(objects, index, sub).unless(object_at(objects, index, sub).is_some(), OTHER_NUMBER);
}

/// Checks that the communication parameter consists of parameters with the types of CiA 301.
#[track_caller]
const fn check_settings(
    objects: &[Object],
    index: u16,
    parameters: &[Parameter],
    quantities: &[Quantity],
) {
    each!((sub, data_type) in &SETTINGS => {
        if let Some(object) = object_at(objects, index, *sub) {
            let mistake = mistake_at(objects, index, *sub);
            mistake.unless(
                matches!(
                    object.target,
                    Target::Parameter(_) | Target::CobId(_) | Target::FreeCobId(_)
                ),
                "the communication parameter of a TPDO must be parameters",
            );
            mistake.unless(
                *sub != 1 || !matches!(object.target, Target::Parameter(_)),
                "the COB-ID of a TPDO is `profile::cob_id` or `profile::free_cob_id`",
            );
            mistake.unless(
                object.data_type(parameters, quantities) as u8 == *data_type as u8,
                "CiA 301 defines another data type for this object",
            );
        }
    });
}

#[track_caller]
const fn check_mapping<T: Tpdos>(
    objects: &[Object],
    number: u16,
    parameters: &[Parameter],
    quantities: &[Quantity],
) {
    let index = 0x1A00 + number;
    let (mut bits, mut sub) = (0, 1);
    while let Some(entry) = object_at(objects, index, sub) {
        let Target::Constant(entry) = entry.target else {
            mistake_at(objects, index, sub)
                .text("a mapping entry must be a constant, unless `Tpdos` is `DynamicTpdos`")
                .fail();
        };
        check_entry(objects, (index, sub), entry, parameters, quantities);
        mistake_at(objects, index, sub).unless(
            is_value(objects, entry),
            "a fixed mapping must consist of published values",
        );
        bits += entry & 0xFF;
        sub += 1;
    }
    mistake_at(objects, index, 0).unless(bits <= 64, "the mapped objects do not fit into a frame");
    mistake_at(objects, index, 0).unless(
        sub as usize <= T::ENTRIES + 1,
        "more objects are mapped than the TPDO takes",
    );
}

/// Whether a mapping entry maps a published value.
const fn is_value(objects: &[Object], entry: u32) -> bool {
    let mapped = object_at(objects, (entry >> 16) as u16, (entry >> 8) as u8);
    matches!(
        mapped,
        Some(Object {
            target: Target::Value(_),
            ..
        })
    )
}

/// Checks the mapping entry at an address: the object exists, can be mapped, and has the mapped length.
#[track_caller]
const fn check_entry(
    objects: &[Object],
    (index, sub): (u16, u8),
    entry: u32,
    parameters: &[Parameter],
    quantities: &[Quantity],
) {
    let what = match object_at(objects, (entry >> 16) as u16, (entry >> 8) as u8) {
        None => "does not exist",
        Some(mapped) if !mapped.mappable => "cannot be mapped",
        Some(mapped)
            if 8 * mapped.data_type(parameters, quantities).size() as u32 != entry & 0xFF =>
        {
            "has another length"
        }
        Some(_) => return,
    };
    mistake_at(objects, index, sub)
        .text("the mapped object ")
        .hexadecimal(entry >> 16, 4)
        .text("h:")
        .hexadecimal(entry >> 8 & 0xFF, 2)
        .text(" ")
        .text(what)
        .fail()
}

/// Checks the dynamic mapping of TPDO `number` (from 0): its number and its entries are parameters with consecutive ids, and the
/// factory values are a permitted mapping.
#[track_caller]
const fn check_dynamic(
    objects: &[Object],
    number: u16,
    most: usize,
    parameters: &[Parameter],
    quantities: &[Quantity],
) {
    let index = 0x1A00 + number;
    Mistake::item("Tpdos").unless(most <= BYTES, "a TPDO has at most 8 objects");
    let first = parameter_at(objects, index, 0);
    let mapped = at(parameters, first as usize).factory;
    mistake_at(objects, index, 0).unless(
        mapped as usize <= most,
        "more objects are mapped than the TPDO takes",
    );
    mistake_at(objects, index, most as u8 + 1).unless(
        object_at(objects, index, most as u8 + 1).is_none(),
        "the mapping has more entries than the TPDO takes",
    );
    let (mut bits, mut sub) = (0, 1);
    while sub as usize <= most {
        let id = parameter_at(objects, index, sub);
        mistake_at(objects, index, sub).unless(
            id == first + sub,
            "the parameters of a mapping must be consecutive",
        );
        let entry = at(parameters, id as usize).factory;
        if sub as u32 <= mapped {
            check_entry(objects, (index, sub), entry, parameters, quantities);
            bits += entry & 0xFF;
        }
        sub += 1;
    }
    mistake_at(objects, index, 0).unless(bits <= 64, "the mapped objects do not fit into a frame");
}

#[track_caller]
const fn parameter_at(objects: &[Object], index: u16, sub: u8) -> u8 {
    match object_at(objects, index, sub) {
        Some(Object {
            target: Target::Parameter(id),
            ..
        }) => id.0,
        _ => mistake_at(objects, index, sub)
            .text("a dynamic mapping must consist of parameters")
            .fail(),
    }
}
