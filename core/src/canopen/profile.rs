//! The common objects and parameters of CiA 301 for the tables of a product.
//!
//! A function for a parameter takes its id and returns its description. A function for an object takes the properties that differ
//! between products. A product can replace the name of CiA 301 with the name of its manual by struct update: `Parameter { name:
//! "...", ..guard_time(ID) }`. [`objects!`](crate::objects) and [`parameters!`](crate::parameters) join the rows to one table.

use super::cob_id;
use super::dictionary::{Access, Object, Service, Target};
use super::lss::UNCONFIGURED;
use super::pdo::TRANSMISSION_TYPES;
use crate::can::BitRate;
use crate::mistake::Mistake;
use crate::param::{
    Coding, DataType, Parameter, ParameterId, Permitted, Persistence, Ranges, ValueId,
};
use crate::walk::{each, put};

/// Joins several arrays of objects to one table: `plumbline::objects![[profile::error_register()], profile::server_sdo()]`.
#[macro_export]
macro_rules! objects {
    ($($part:expr),* $(,)?) => {
        &$crate::param::join::join::<
            $crate::canopen::dictionary::Object,
            { 0 $(+ $part.len())* },
        >(&[$(&$part),*], $crate::canopen::dictionary::Object::plain())
    };
}

mod dynamic;
mod standard;
pub use dynamic::{
    dynamic_mapping, free_cob_id, free_tpdo, mapping_parameters, stored_tpdo_communication,
};
pub use standard::{STANDARD, Standard, merge, restore, standard, standard_parameters, store};

// Parameters.

/// Node-ID, an object of the maker. A written number acts at the next reset of the communication or of the node, also if it is not saved;
/// at power-up the saved one does.
#[track_caller]
pub const fn node_id(id: ParameterId, factory: u8) -> Parameter {
    Parameter {
        permitted: Permitted::Range(1, 127),
        factory: factory as u32,
        ..Parameter::new(id, "Node-ID", DataType::U8)
    }
}

/// Node-ID of a product with LSS, an object of the maker: 1 to 126, or 255 for none. SDO cannot write 255.
#[track_caller]
pub const fn lss_node_id(id: ParameterId, factory: u8) -> Parameter {
    Parameter {
        permitted: Permitted::Ranges(&LSS_NODE_IDS),
        ..node_id(id, factory)
    }
}

/// The same with all node-IDs of CiA 301: 1 to 127, or 255 for none.
#[track_caller]
pub const fn lss_node_id_to_127(id: ParameterId, factory: u8) -> Parameter {
    Parameter {
        permitted: Permitted::Ranges(&LSS_NODE_IDS_TO_127),
        ..node_id(id, factory)
    }
}

const LSS_NODE_IDS_TO_127: Ranges = Ranges {
    text: "1..127; 255 by LSS only",
    ignored_bits: 0,
    ranges: &[(1, 127), (UNCONFIGURED as u32, UNCONFIGURED as u32)],
};

const LSS_NODE_IDS: Ranges = Ranges {
    text: "1..126; 255 by LSS only",
    ignored_bits: 0,
    ranges: &[(1, 126), (UNCONFIGURED as u32, UNCONFIGURED as u32)],
};

/// Bit rate in kbit/s, an object of the maker; [`BIT_RATES`] are permitted.
#[track_caller]
pub const fn bit_rate(id: ParameterId, factory: u16) -> Parameter {
    Parameter {
        unit: "kbit/s",
        permitted: Permitted::OneOf(&BIT_RATE_NUMBERS),
        factory: factory as u32,
        ..Parameter::new(id, "Bit rate", DataType::U16)
    }
}

/// The bit rates of CiA 301, table 1, by their numbers in kbit/s.
pub const BIT_RATES: [(u32, BitRate); 8] = {
    let mut rates = [(0, BitRate::K10); 8];
    each!(place, (number, rate) in &BIT_RATE_CODING.codes() => {
        put(&mut rates, place, (*number as u32, *rate));
    });
    rates
};

const BIT_RATE_NUMBERS: [u32; 8] = BIT_RATE_CODING.numbers();

const BIT_RATE_CODING: Coding<BitRate, 8> = Coding([
    (10, "", BitRate::K10),
    (20, "", BitRate::K20),
    (50, "", BitRate::K50),
    (125, "", BitRate::K125),
    (250, "", BitRate::K250),
    (500, "", BitRate::K500),
    (800, "", BitRate::K800),
    (1000, "", BitRate::M1),
]);

/// COB-ID of the SYNC (1005h). Factory value 80h.
#[track_caller]
pub const fn sync_cob_id(id: ParameterId) -> Parameter {
    Parameter {
        permitted: Permitted::Ranges(&cob_id::SYNC),
        factory: cob_id::EMCY as u32,
        ..Parameter::new(id, "COB-ID SYNC message", DataType::U32)
    }
}

/// Guard time (100Ch) in ms. Factory value 0.
#[track_caller]
pub const fn guard_time(id: ParameterId) -> Parameter {
    Parameter {
        unit: "ms",
        ..Parameter::new(id, "Guard time", DataType::U16)
    }
}

/// Life time factor (100Dh). Factory value 0.
#[track_caller]
pub const fn life_time_factor(id: ParameterId) -> Parameter {
    Parameter::new(id, "Life time factor", DataType::U8)
}

/// COB-ID of the EMCY (1014h). Factory value 80h; the node-ID is added at each start.
#[track_caller]
pub const fn emcy_cob_id(id: ParameterId) -> Parameter {
    Parameter {
        factory: cob_id::EMCY as u32,
        persistence: Persistence::Volatile,
        ..Parameter::new(id, "COB-ID EMCY", DataType::U32)
    }
}

/// Inhibit time of the EMCY (1015h) in 100 us. Factory value 0.
#[track_caller]
pub const fn emcy_inhibit_time(id: ParameterId) -> Parameter {
    Parameter {
        unit: "100 us",
        ..Parameter::new(id, "Inhibit time EMCY", DataType::U16)
    }
}

/// Producer heartbeat time (1017h) in ms. Factory value 0.
#[track_caller]
pub const fn heartbeat_time(id: ParameterId) -> Parameter {
    Parameter {
        unit: "ms",
        ..Parameter::new(id, "Producer heartbeat time", DataType::U16)
    }
}

/// Error behaviour (1029h:01): the NMT state after a communication error. Factory value 0 (pre-operational).
#[track_caller]
pub const fn error_behaviour(id: ParameterId) -> Parameter {
    Parameter {
        permitted: Permitted::Named,
        meanings: &[
            (0, "pre-operational"),
            (1, "no change of state"),
            (2, "stopped"),
        ],
        ..Parameter::new(id, "Error behaviour", DataType::U8)
    }
}

/// NMT start-up (1F80h): 0 waits for the master, 2 starts all nodes, 8 starts only this node. Factory value 0.
#[track_caller]
pub const fn nmt_start_up(id: ParameterId) -> Parameter {
    Parameter {
        permitted: Permitted::Named,
        meanings: &[
            (0, "slave only"),
            (2, "NMT start command"),
            (8, "autostart"),
        ],
        ..Parameter::new(id, "NMT start-up", DataType::U32)
    }
}

/// The communication parameter of a TPDO (180xh) as four parameters with ids from `first` on: COB-ID (the node-ID is added at
/// each start), transmission type, inhibit time in 100 us, event timer in ms. Factory values: `cob_id`, 1, 0, 10 ms.
#[track_caller]
pub const fn tpdo_communication(first: ParameterId, cob_id: u32) -> [Parameter; 4] {
    let ParameterId(first) = first;
    [
        Parameter {
            factory: cob_id,
            persistence: Persistence::Volatile,
            ..Parameter::new(ParameterId(first), "COB-ID", DataType::U32)
        },
        Parameter {
            permitted: Permitted::Ranges(&TRANSMISSION_TYPES),
            factory: 1,
            ..Parameter::new(ParameterId(first + 1), "Transmission type", DataType::U8)
        },
        Parameter {
            unit: "100 us",
            ..Parameter::new(ParameterId(first + 2), "Inhibit time", DataType::U16)
        },
        Parameter {
            unit: "ms",
            factory: 10,
            ..Parameter::new(ParameterId(first + 3), "Event timer", DataType::U16)
        },
    ]
}

// Objects.

/// An object that is a constant number of this type.
#[track_caller]
pub const fn constant(
    index: u16,
    sub: u8,
    name: &'static str,
    data_type: DataType,
    value: u32,
) -> Object {
    Object {
        index,
        sub,
        name,
        data_type,
        target: Target::Constant(value),
        ..Object::plain()
    }
}

/// An object that is a constant text.
#[track_caller]
pub const fn text(index: u16, name: &'static str, value: &'static str) -> Object {
    Object {
        index,
        name,
        access: Access::Const,
        target: Target::Text(value),
        ..Object::plain()
    }
}

/// Sub-index 0 with the highest supported sub-index.
#[track_caller]
pub const fn highest(index: u16, group: &'static str, data_type: DataType, sub: u8) -> Object {
    Object {
        group,
        ..constant(
            index,
            0,
            "Highest supported sub-index",
            data_type,
            sub as u32,
        )
    }
}

/// A service of the node.
#[track_caller]
pub const fn service(
    index: u16,
    sub: u8,
    name: &'static str,
    data_type: DataType,
    access: Access,
    service: Service,
) -> Object {
    Object {
        index,
        sub,
        name,
        data_type,
        access,
        target: Target::Service(service),
        ..Object::plain()
    }
}

/// A COB-ID to which the node-ID is added at each start; read-only, but its own value is accepted. If it is writable, only bits 31 and 30
/// can change.
#[track_caller]
pub const fn cob_id(index: u16, sub: u8, id: ParameterId) -> Object {
    Object {
        index,
        sub,
        target: Target::CobId(id),
        ..Object::plain()
    }
}

/// The device type (1000h): the number of the profile in the low word, additional information in the high word.
#[track_caller]
pub const fn device_type(value: u32) -> Object {
    Object {
        access: Access::Const,
        ..constant(0x1000, 0, "Device type", DataType::U32, value)
    }
}

/// The error register (1001h): the bits of the active faults.
#[track_caller]
pub const fn error_register() -> Object {
    service(
        0x1001,
        0,
        "Error register",
        DataType::U8,
        Access::Ro,
        Service::ErrorRegister,
    )
}

/// Pre-defined error field (1003h) with a history of `count` errors.
#[track_caller]
pub const fn error_history(count: u8) -> [Object; 2] {
    errors(count, Service::ErrorHistory)
}

/// The same. An error that did not occur reads 0 in place of an abort.
#[track_caller]
pub const fn error_history_or_zero(count: u8) -> [Object; 2] {
    errors(count, Service::ErrorHistoryOrZero)
}

#[track_caller]
const fn errors(count: u8, history: Service) -> [Object; 2] {
    [
        Object {
            group: "Pre-defined error field",
            ..service(
                0x1003,
                0,
                "Number of error entries",
                DataType::U8,
                Access::Rw,
                Service::ErrorCount,
            )
        },
        Object {
            count,
            ..service(0x1003, 1, "Error code", DataType::U32, Access::Ro, history)
        },
    ]
}

/// Identity object (1018h). The serial number is that of the device.
#[track_caller]
pub const fn identity(vendor: u32, product: u32, revision: u32) -> [Object; 5] {
    [
        highest(0x1018, "Identity object", DataType::U8, 4),
        constant(0x1018, 1, "Vendor ID", DataType::U32, vendor),
        constant(0x1018, 2, "Product code", DataType::U32, product),
        constant(0x1018, 3, "Revision number", DataType::U32, revision),
        service(
            0x1018,
            4,
            "Serial number",
            DataType::U32,
            Access::Ro,
            Service::SerialNumber,
        ),
    ]
}

/// The entries of the heartbeat consumer (1016h), with ids from `first` on. No node is monitored as delivered.
#[track_caller]
pub const fn consumer_parameters<const N: usize>(first: ParameterId) -> [Parameter; N] {
    let mut rows = [Parameter::plain(); N];
    let mut place = 0;
    while place < N {
        let id = ParameterId(first.0 + place as u8);
        let parameter = Parameter::new(id, "Consumer heartbeat time", DataType::U32);
        put(&mut rows, place, parameter.within(0, 0x00FF_FFFF, 0));
        place += 1;
    }
    rows
}

/// Consumer heartbeat time (1016h). `first` is the id of its first parameter, `N` the number of entries plus 1.
#[track_caller]
pub const fn consumers<const N: usize>(first: ParameterId) -> [Object; N] {
    let last = N as u8 - 1;
    let mut rows = [highest(0x1016, "Consumer heartbeat time", DataType::U8, last); N];
    let mut sub = 1;
    while sub < N {
        let id = ParameterId(first.0 + sub as u8 - 1);
        put(&mut rows, sub, Object::parameter(0x1016, sub as u8, id));
        sub += 1;
    }
    rows
}

/// The server SDO parameter (1200h): the identifiers of requests and replies.
#[track_caller]
pub const fn server_sdo() -> [Object; 3] {
    [
        highest(0x1200, "Server SDO parameter", DataType::U8, 2),
        Object {
            target: Target::NodeRelative(cob_id::SDO_REQUEST as u32),
            ..constant(0x1200, 1, "COB-ID client to server", DataType::U32, 0)
        },
        Object {
            target: Target::NodeRelative(cob_id::SDO_REPLY as u32),
            ..constant(0x1200, 2, "COB-ID server to client", DataType::U32, 0)
        },
    ]
}

/// The communication parameter of TPDO `number` (from 0; 1800h and following). `first` is the id of its first parameter.
#[track_caller]
pub const fn tpdo(number: u8, group: &'static str, first: ParameterId) -> [Object; 5] {
    let index = 0x1800 + number as u16;
    let ParameterId(first) = first;
    [
        highest(index, group, DataType::U8, 5),
        Object {
            access: Access::Rw,
            ..cob_id(index, 1, ParameterId(first))
        },
        Object::parameter(index, 2, ParameterId(first + 1)),
        Object::parameter(index, 3, ParameterId(first + 2)),
        Object::parameter(index, 5, ParameterId(first + 3)),
    ]
}

/// A PDO mapping entry: index, sub-index and length in bits.
pub const fn entry(index: u16, sub: u8, bits: u8) -> u32 {
    (index as u32) << 16 | (sub as u32) << 8 | bits as u32
}

/// The fixed mapping of TPDO `number` (from 0; 1A00h and following): a name and an [`entry`] for each object. `N` is the number
/// of entries plus 1.
#[track_caller]
pub const fn mapping<const N: usize>(
    number: u8,
    group: &'static str,
    entries: &[(&'static str, u32)],
) -> [Object; N] {
    let index = 0x1A00 + number as u16;
    Mistake::object(index, 0).unless(
        entries.len() + 1 == N,
        "`mapping::<N>` needs one row more than its entries",
    );
    let mut rows = [highest(index, group, DataType::U8, entries.len() as u8); N];
    each!(place, (name, entry) in entries => {
        let row = constant(index, place as u8 + 1, name, DataType::U32, *entry);
        put(&mut rows, place + 1, row);
    });
    rows
}

/// A published value that is read-only and not mappable.
#[track_caller]
pub const fn read_only(index: u16, sub: u8, id: ValueId) -> Object {
    Object {
        mappable: false,
        ..Object::value(index, sub, id)
    }
}

#[cfg(test)]
mod tests;
