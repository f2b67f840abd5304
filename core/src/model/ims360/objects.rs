//! The object dictionary of the IMS360 (manual 7).

use super::application::value;
use super::parameters::id;
use crate::canopen::dictionary::{Access, Command, Object, Service, Starts};
use crate::canopen::profile::{self, constant, highest};
use crate::param::{DataType, ParameterId, ValueId};

#[track_caller]
const fn parameter(index: u16, sub: u8, id: ParameterId) -> Object {
    Object::parameter(index, sub, id)
}

/// A parameter that can be mapped into a TPDO.
#[track_caller]
const fn mappable(index: u16, sub: u8, id: ParameterId) -> Object {
    Object {
        mappable: true,
        ..Object::parameter(index, sub, id)
    }
}

/// Three values, for X, Y and Z, at the sub-indices 1 to 3.
#[track_caller]
const fn vector(index: u16, group: &'static str, ids: [ValueId; 3]) -> [Object; 4] {
    let [x, y, z] = ids;
    [
        highest(index, group, DataType::U8, 3),
        Object::value(index, 1, x),
        Object::value(index, 2, y),
        Object::value(index, 3, z),
    ]
}

/// 1010h: one command for each group of parameters.
#[track_caller]
const fn store(sub: u8, name: &'static str) -> Object {
    Object::own(0x1010, sub, name, DataType::U32, Access::Rw).in_place_of(Service::StoreGroup)
}

/// 1011h: one command for each group of parameters.
#[track_caller]
const fn restore(sub: u8, name: &'static str) -> Object {
    Object::own(0x1011, sub, name, DataType::U32, Access::Rw).in_place_of(Service::RestoreGroup)
}

/// A status byte without a meaning (3000h:02 to :05).
#[track_caller]
const fn status(sub: u8, name: &'static str) -> Object {
    constant(0x3000, sub, name, DataType::U8, 0)
}

const IDENTIFICATION: [Object; 6] = [
    Object {
        group: "Logistic data",
        ..highest(0x2000, "Logistic data", DataType::U8, 3)
    },
    Object::own(0x2000, 1, "Serial number", DataType::Text, Access::Ro),
    constant(0x2000, 2, "Version number", DataType::U32, 1),
    Object {
        sub: 3,
        access: Access::Ro,
        ..profile::text(0x2000, "Device ID", "IMS360")
    },
    parameter(0x2001, 0, id::BIT_RATE),
    parameter(0x2002, 0, id::NODE_ID),
];

const CONTROL: [Object; 5] = [
    highest(0x2010, "Controller settings", DataType::U8, 2),
    Object::own(0x2010, 1, "Set controller", DataType::U8, Access::Wo).starting(Command {
        starts: Starts::Reset,
        numbers: "1 = reset",
        limits: (1, 1),
    }),
    highest(0x2020, "Internal values", DataType::U8, 1),
    profile::read_only(0x2020, 1, value::SUPPLY),
    constant(0x20FF, 0, "Version of layout", DataType::U16, 1),
];

const J1939: [Object; 21] = [
    parameter(0x2102, 0, id::J1939_ADDRESS),
    highest(0x2104, "J1939 transmission rates", DataType::U8, 4),
    parameter(0x2104, 1, id::J1939_RATES[0]),
    parameter(0x2104, 2, id::J1939_RATES[1]),
    parameter(0x2104, 3, id::J1939_RATES[2]),
    parameter(0x2104, 4, id::J1939_RATES[3]),
    highest(0x2105, "J1939 priorities", DataType::U8, 4),
    parameter(0x2105, 1, id::J1939_PRIORITIES[0]),
    parameter(0x2105, 2, id::J1939_PRIORITIES[1]),
    parameter(0x2105, 3, id::J1939_PRIORITIES[2]),
    parameter(0x2105, 4, id::J1939_PRIORITIES[3]),
    highest(0x2106, "J1939 NAME", DataType::U8, 9),
    parameter(0x2106, 1, id::J1939_NAME[0]),
    parameter(0x2106, 2, id::J1939_NAME[1]),
    parameter(0x2106, 3, id::J1939_NAME[2]),
    parameter(0x2106, 4, id::J1939_NAME[3]),
    parameter(0x2106, 5, id::J1939_NAME[4]),
    parameter(0x2106, 6, id::J1939_NAME[5]),
    parameter(0x2106, 7, id::J1939_NAME[6]),
    parameter(0x2106, 8, id::J1939_NAME[7]),
    Object::own(0x2106, 9, "Identity number", DataType::U32, Access::Ro),
];

const STATUS: [Object; 6] = [
    highest(0x3000, "Status", DataType::U8, 5),
    Object {
        mappable: true,
        ..Object::own(0x3000, 1, "Status byte ST0", DataType::U8, Access::Ro)
    },
    status(2, "Status byte ST1"),
    status(3, "Status byte ST2"),
    status(4, "Status byte ST3"),
    status(5, "Status byte ST4"),
];

const HIGH_RESOLUTION_FORCE: [Object; 3] = [
    Object::value(0x3011, 0, value::FORCE32[0]),
    Object::value(0x3012, 0, value::FORCE32[1]),
    Object::value(0x3013, 0, value::FORCE32[2]),
];

const HIGH_RESOLUTION_RATE: [Object; 3] = [
    Object::value(0x3021, 0, value::RATE32[0]),
    Object::value(0x3022, 0, value::RATE32[1]),
    Object::value(0x3023, 0, value::RATE32[2]),
];

const SETTINGS: [Object; 17] = [
    highest(0x3100, "CAN settings", DataType::U8, 2),
    mappable(0x3100, 1, id::PROTOCOL),
    parameter(0x3100, 2, id::BUS_OFF_RECOVERY),
    highest(0x3110, "Filter configuration", DataType::U8, 2),
    parameter(0x3110, 1, id::FILTER_TYPE),
    mappable(0x3110, 2, id::FUSION),
    parameter(0x3111, 0, id::CUT_OFF),
    highest(0x3112, "Kalman filter parameters", DataType::U8, 4),
    mappable(0x3112, 1, id::Q[0]),
    parameter(0x3112, 2, id::Q[1]),
    parameter(0x3112, 3, id::R[0]),
    mappable(0x3112, 4, id::R[1]),
    highest(0x3120, "Sensor configuration", DataType::U8, 1),
    parameter(0x3120, 1, id::VARIANT),
    Object {
        access: Access::Wo,
        ..parameter(0x3200, 0, id::AUTO_ZERO)
    },
    parameter(0x3210, 0, id::ZERO_X),
    parameter(0x3220, 0, id::ZERO_Y),
];

const SLOPES: [Object; 6] = [
    // In units of 0.001 deg.
    Object {
        access: Access::Const,
        ..constant(0x6000, 0, "Resolution", DataType::U16, 10)
    },
    Object::value(0x6110, 0, value::X),
    constant(
        0x6111,
        0,
        "Slope long32 operating parameter",
        DataType::U8,
        0,
    ),
    Object::value(0x6120, 0, value::Y),
    constant(
        0x6121,
        0,
        "Slope lateral32 operating parameter",
        DataType::U8,
        0,
    ),
    Object::value(0x6511, 0, value::TEMPERATURE),
];

/// All objects, sorted: the communication profile, those of the manufacturer, and the device profile.
pub(super) const OBJECTS: &[Object] = crate::objects![
    [
        Object {
            access: Access::Ro,
            ..parameter(0x1000, 0, id::DEVICE_TYPE)
        },
        profile::error_register()
    ],
    profile::error_history(super::HISTORY as u8),
    [
        parameter(0x1005, 0, id::SYNC_COB_ID),
        profile::text(0x1008, "Manufacturer device name", "IMS360"),
        profile::text(0x1009, "Manufacturer hardware version", "01"),
        profile::text(0x100A, "Manufacturer software version", "010000"),
        highest(0x1010, "Store parameters", DataType::U8, 4),
        store(1, "Store all parameters"),
        store(2, "Store communication parameters"),
        store(3, "Store application parameters"),
        store(4, "Store manufacturer-specific parameters"),
        highest(0x1011, "Restore parameters", DataType::U8, 5),
        restore(1, "Restore user parameters"),
        restore(2, "Restore communication parameters"),
        restore(3, "Restore application parameters"),
        restore(4, "Restore manufacturer-specific parameters"),
        restore(5, "Restore all parameters"),
        profile::free_cob_id(0x1014, 0, id::EMCY_COB_ID),
        parameter(0x1017, 0, id::HEARTBEAT_TIME),
    ],
    profile::identity(0x0000_0195, 0x0001_869F, 0x0000_0000),
    profile::free_tpdo(0, "1. Transmit PDO parameter", id::TPDO[0]),
    profile::free_tpdo(1, "2. Transmit PDO parameter", id::TPDO[1]),
    profile::free_tpdo(2, "3. Transmit PDO parameter", id::TPDO[2]),
    profile::free_tpdo(3, "4. Transmit PDO parameter", id::TPDO[3]),
    profile::dynamic_mapping(0, "1. Transmit PDO mapping parameter", id::MAPPING[0]),
    profile::dynamic_mapping(1, "2. Transmit PDO mapping parameter", id::MAPPING[1]),
    profile::dynamic_mapping(2, "3. Transmit PDO mapping parameter", id::MAPPING[2]),
    profile::dynamic_mapping(3, "4. Transmit PDO mapping parameter", id::MAPPING[3]),
    IDENTIFICATION,
    CONTROL,
    J1939,
    STATUS,
    vector(0x3010, "Acceleration values", value::FORCE16),
    HIGH_RESOLUTION_FORCE,
    vector(0x3020, "Gyro values", value::RATE16),
    HIGH_RESOLUTION_RATE,
    SETTINGS,
    SLOPES,
];
