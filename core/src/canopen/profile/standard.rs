//! The objects of CiA 301 that most sensors have, as one table.

use super::{
    cob_id, device_type, emcy_cob_id, emcy_inhibit_time, error_history, error_register, guard_time,
    heartbeat_time, highest, identity, life_time_factor, server_sdo, service, sync_cob_id, text,
};
use crate::canopen::dictionary::{Access, Object, Service};
use crate::mistake::Mistake;
use crate::param::join::join;
use crate::param::{DataType, Parameter, ParameterId};
use crate::walk::{at, put};

/// What differs between the products in [`standard`].
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Standard {
    /// The number in 1000h: device profile and additional information.
    pub device_type: u32,
    /// The number of errors in the history (1003h).
    pub errors: u8,
    /// Manufacturer device name (1008h), hardware version (1009h) and software version (100Ah).
    pub names: [&'static str; 3],
    /// Vendor-ID, product code and revision number (1018h).
    pub identity: [u32; 3],
    /// The highest sub-index of 1010h and 1011h. The table has 1 to 4, [`merge`] adds the others.
    pub groups: u8,
    /// The first id of the [`standard_parameters`].
    pub first: ParameterId,
}

/// The number of rows of [`standard`].
pub const STANDARD: usize = 31;

/// The objects 1000h, 1001h, 1003h, 1005h, 1008h to 100Ah, 100Ch, 100Dh, 1010h, 1011h, 1014h, 1015h, 1017h, 1018h and 1200h. 1010h and
/// 1011h have four groups: all parameters, those of the communication profile, those of the device profile and the manufacturer-specific
/// ones.
///
/// `plumbline::objects![profile::standard(&STANDARD), profile::tpdo(0, "TPDO 1", TPDO), ...]` is a whole dictionary. [`merge`] adds
/// objects between these.
#[track_caller]
pub const fn standard(product: &Standard) -> [Object; STANDARD] {
    let [name, hardware, software] = product.names;
    let [vendor, code, revision] = product.identity;
    let ParameterId(first) = product.first;
    join(
        &[
            &[device_type(product.device_type), error_register()],
            &error_history(product.errors),
            &[
                Object::parameter(0x1005, 0, ParameterId(first)),
                text(0x1008, "Manufacturer device name", name),
                text(0x1009, "Manufacturer hardware version", hardware),
                text(0x100A, "Manufacturer software version", software),
                Object::parameter(0x100C, 0, ParameterId(first + 1)),
                Object::parameter(0x100D, 0, ParameterId(first + 2)),
            ],
            &store(product.groups),
            &restore(product.groups),
            &[
                cob_id(0x1014, 0, ParameterId(first + 3)),
                Object::parameter(0x1015, 0, ParameterId(first + 4)),
                Object::parameter(0x1017, 0, ParameterId(first + 5)),
            ],
            &identity(vendor, code, revision),
            &server_sdo(),
        ],
        Object::plain(),
    )
}

/// The parameters of [`standard`], with ids from `first` on: 1005h, 100Ch, 100Dh, 1014h, 1015h and 1017h.
#[track_caller]
pub const fn standard_parameters(first: ParameterId) -> [Parameter; 6] {
    let ParameterId(first) = first;
    [
        sync_cob_id(ParameterId(first)),
        guard_time(ParameterId(first + 1)),
        life_time_factor(ParameterId(first + 2)),
        emcy_cob_id(ParameterId(first + 3)),
        emcy_inhibit_time(ParameterId(first + 4)),
        heartbeat_time(ParameterId(first + 5)),
    ]
}

/// Store parameters (1010h) in four groups; `last` is the highest sub-index.
#[track_caller]
pub const fn store(last: u8) -> [Object; 5] {
    groups(
        last,
        0x1010,
        "Store parameters",
        Service::StoreGroup,
        [
            "Save all parameters",
            "Save communication parameters",
            "Save application parameters",
            "Save manufacturer defined parameters",
        ],
    )
}

/// Restore default parameters (1011h) in four groups; `last` is the highest sub-index.
#[track_caller]
pub const fn restore(last: u8) -> [Object; 5] {
    groups(
        last,
        0x1011,
        "Restore default parameters",
        Service::RestoreGroup,
        [
            "Restore all default parameters",
            "Restore communication default parameters",
            "Restore application default parameters",
            "Restore manufacturer defined default parameters",
        ],
    )
}

#[track_caller]
const fn groups(
    last: u8,
    index: u16,
    group: &'static str,
    own: Service,
    [all, communication, application, maker]: [&'static str; 4],
) -> [Object; 5] {
    [
        highest(index, group, DataType::U8, last),
        service(index, 1, all, DataType::U32, Access::Rw, own),
        service(index, 2, communication, DataType::U32, Access::Rw, own),
        service(index, 3, application, DataType::U32, Access::Rw, own),
        service(index, 4, maker, DataType::U32, Access::Rw, own),
    ]
}

/// Merges two sorted tables of objects. `N` is the number of all rows.
#[track_caller]
pub const fn merge<const N: usize>(one: &[Object], other: &[Object]) -> [Object; N] {
    if one.len() + other.len() != N {
        Mistake::item("merge")
            .text("the two tables have ")
            .number((one.len() + other.len()) as u32)
            .text(" rows together, `N` is ")
            .number(N as u32)
            .fail();
    }
    let mut merged = [Object::plain(); N];
    let (mut a, mut b) = (0, 0);
    while a + b < N {
        let takes_one = b == other.len() || (a < one.len() && is_before(at(one, a), at(other, b)));
        if takes_one {
            put(&mut merged, a + b, *at(one, a));
            a += 1;
        } else {
            put(&mut merged, a + b, *at(other, b));
            b += 1;
        }
    }
    merged
}

const fn is_before(one: &Object, other: &Object) -> bool {
    one.index < other.index || (one.index == other.index && one.sub < other.sub)
}
