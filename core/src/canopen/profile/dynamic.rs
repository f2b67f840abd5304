//! The parameters and objects of TPDOs with a free COB-ID and a dynamic mapping.

use super::{highest, tpdo};
use crate::canopen::dictionary::{Access, Object, Target};
use crate::canopen::pdo::TRANSMISSION_TYPES_FROM_1;
use crate::param::{DataType, Parameter, ParameterId, Permitted};
use crate::walk::{at, each, put};

/// The names of the mapping entries.
const ENTRIES: [&str; 8] = [
    "Mapping entry 1",
    "Mapping entry 2",
    "Mapping entry 3",
    "Mapping entry 4",
    "Mapping entry 5",
    "Mapping entry 6",
    "Mapping entry 7",
    "Mapping entry 8",
];

/// The stored communication parameter of a TPDO (180xh) as four parameters with ids from `first` on: COB-ID, transmission type
/// without 0, inhibit time in 100 us, event timer in ms. The node-ID is added to the default COB-ID. Factory values: `cob_id`,
/// 254, 0, 0 ms.
#[track_caller]
pub const fn stored_tpdo_communication(first: ParameterId, cob_id: u32) -> [Parameter; 4] {
    let ParameterId(first) = first;
    [
        Parameter {
            factory: cob_id,
            ..Parameter::new(ParameterId(first), "COB-ID", DataType::U32)
        },
        Parameter {
            permitted: Permitted::Ranges(&TRANSMISSION_TYPES_FROM_1),
            factory: 254,
            ..Parameter::new(ParameterId(first + 1), "Transmission type", DataType::U8)
        },
        Parameter {
            unit: "100 us",
            ..Parameter::new(ParameterId(first + 2), "Inhibit time", DataType::U16)
        },
        Parameter {
            unit: "ms",
            ..Parameter::new(ParameterId(first + 3), "Event timer", DataType::U16)
        },
    ]
}

/// The mapping of a TPDO (1A00h and following) as nine parameters with ids from `first` on: the number of mapped objects and eight
/// entries. `factory` has the factory values of the entries.
#[track_caller]
pub const fn mapping_parameters(first: ParameterId, factory: &[u32]) -> [Parameter; 9] {
    let number = Parameter {
        factory: factory.len() as u32,
        ..Parameter::new(first, "Number of mapped objects", DataType::U8)
    };
    let mut parameters = [number; 9];
    each!(place, name in &ENTRIES => {
        let id = ParameterId(first.0 + 1 + place as u8);
        let entry = Parameter {
            factory: if place < factory.len() {
                *at(factory, place)
            } else {
                0
            },
            ..Parameter::new(id, name, DataType::U32)
        };
        put(&mut parameters, place + 1, entry);
    });
    parameters
}

/// A COB-ID that a master can change.
#[track_caller]
pub const fn free_cob_id(index: u16, sub: u8, id: ParameterId) -> Object {
    Object {
        access: Access::Rw,
        target: Target::FreeCobId(id),
        ..Object::parameter(index, sub, id)
    }
}

/// The communication parameter of TPDO `number` (from 0; 1800h and following) with a COB-ID that a master can change. `first` is the
/// id of its first parameter.
#[track_caller]
pub const fn free_tpdo(number: u8, group: &'static str, first: ParameterId) -> [Object; 5] {
    let [highest, _, transmission_type, inhibit, event] = tpdo(number, group, first);
    let cob_id = free_cob_id(highest.index, 1, first);
    [highest, cob_id, transmission_type, inhibit, event]
}

/// The dynamic mapping of TPDO `number` (from 0; 1A00h and following). `first` is the id of the parameter with the number of mapped
/// objects; the entries follow.
#[track_caller]
pub const fn dynamic_mapping(number: u8, group: &'static str, first: ParameterId) -> [Object; 9] {
    let index = 0x1A00 + number as u16;
    let mut rows = [highest(index, group, DataType::U8, 0); 9];
    let mut row = 0;
    while row < 9 {
        let object = Object {
            group: if row == 0 { group } else { "" },
            ..Object::parameter(index, row as u8, ParameterId(first.0 + row as u8))
        };
        put(&mut rows, row, object);
        row += 1;
    }
    rows
}
