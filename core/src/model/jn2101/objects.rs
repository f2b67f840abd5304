//! The object dictionary of the JN2101 (manual 7.6, 7.7 and 14).

use super::application::value;
use super::parameters::id;
use crate::canopen::dictionary::{Access, Command, Object, Service, Starts, Target};
use crate::canopen::profile::{self, constant, highest, service};
use crate::param::{DataType, ParameterId};

#[track_caller]
const fn parameter(index: u16, id: ParameterId) -> Object {
    Object::parameter(index, 0, id)
}

const TPDO0: [Object; 5] = profile::tpdo(0, "Transmit PDO0 communication parameter", id::TPDO0);
const TPDO1: [Object; 5] = profile::tpdo(1, "Transmit PDO1 communication parameter", id::TPDO1);
const MAPPING0: [Object; 3] = profile::mapping(
    0,
    "Transmit PDO0 mapping parameter",
    &[
        (
            "Inclination value longitudinal (X axis)",
            profile::entry(0x6010, 0, 16),
        ),
        (
            "Inclination value lateral (Y axis)",
            profile::entry(0x6020, 0, 16),
        ),
    ],
);
const MAPPING1: [Object; 3] = profile::mapping(
    1,
    "Transmit PDO1 mapping parameter",
    &[
        (
            "Inclination value longitudinal (X axis)",
            profile::entry(0x6110, 0, 32),
        ),
        (
            "Inclination value lateral (Y axis)",
            profile::entry(0x6120, 0, 32),
        ),
    ],
);

#[track_caller]
const fn operating_parameter(index: u16, name: &'static str) -> Object {
    constant(index, 0, name, DataType::U8, 0)
}

/// The objects of the manufacturer and of the device profile (manual 7.7 and 14).
const APPLICATION: [Object; 26] = [
    parameter(0x2000, id::NODE_ID),
    parameter(0x2001, id::BAUD_RATE),
    Object::own(0x2002, 0, "Sensor reset", DataType::U8, Access::Rw).starting(Command {
        starts: Starts::Reset,
        numbers: "0..1; 1 = reset",
        limits: (0, 1),
    }),
    parameter(0x2040, id::QUADRANT),
    parameter(0x2041, id::HEATING),
    parameter(0x2042, id::TEACH),
    parameter(0x2043, id::FILTER),
    parameter(0x2044, id::DEFINITION),
    parameter(0x2045, id::TERMINATION),
    parameter(0x2046, id::ZERO),
    Object::own(0x207F, 0, "Factory reset", DataType::U8, Access::Rw).starting(Command {
        starts: Starts::Restore,
        numbers: "1 = restore; reads 1 = done, 0 = failed",
        limits: (0, 1),
    }),
    Object::own(0x3000, 0, "Programming key", DataType::Text, Access::Rw),
    highest(0x4004, "MEMS self-test", DataType::U8, 2),
    Object {
        target: Target::Command(id::SELF_TEST, value::SELF_TEST_ACTIVE),
        ..Object::parameter(0x4004, 1, id::SELF_TEST)
    },
    profile::read_only(0x4004, 2, value::SELF_TEST_RESULT),
    profile::read_only(0x4080, 0, value::TEMPERATURE),
    profile::read_only(0x4081, 0, value::HEATING_POWER),
    parameter(0x6000, id::RESOLUTION),
    Object::value(0x6010, 0, value::X16),
    operating_parameter(0x6011, "Slope long16 operating parameter"),
    Object::value(0x6020, 0, value::Y16),
    operating_parameter(0x6021, "Slope lateral16 operating parameter"),
    Object::value(0x6110, 0, value::X32),
    operating_parameter(0x6111, "Slope long32 operating parameter"),
    Object::value(0x6120, 0, value::Y32),
    operating_parameter(0x6121, "Slope lateral32 operating parameter"),
];

/// All objects, sorted: the communication profile (manual 7.6), then the others.
pub(super) const OBJECTS: &[Object] = crate::objects![
    [profile::device_type(0x0004_019A), profile::error_register()],
    profile::error_history_or_zero(super::HISTORY as u8),
    [
        parameter(0x1005, id::SYNC_COB_ID),
        profile::text(0x1008, "Product designation", "JN2101"),
        profile::text(0x1009, "Hardware version", "1.0.0"),
        // The oldest firmware that the manual describes.
        profile::text(0x100A, "Software version", "2.2.0"),
        parameter(0x100C, id::GUARD_TIME),
        parameter(0x100D, id::LIFE_TIME_FACTOR),
        highest(0x1010, "Save parameters", DataType::U8, 1),
        service(
            0x1010,
            1,
            "Save all parameters",
            DataType::U32,
            Access::Rw,
            Service::Store,
        ),
        highest(0x1011, "Restore factory parameters", DataType::U8, 1),
        service(
            0x1011,
            1,
            "Restore all factory parameters",
            DataType::U32,
            Access::Rw,
            Service::RestoreCommunication,
        ),
        profile::cob_id(0x1014, 0, id::EMCY_COB_ID),
        parameter(0x1015, id::EMCY_INHIBIT_TIME),
        parameter(0x1017, id::HEARTBEAT_TIME),
    ],
    profile::identity(0x6D66_6900, 0x01, 0xAA),
    [
        Object {
            group: "Error behaviour object",
            ..constant(0x1029, 0, "Number of error classes", DataType::U8, 1)
        },
        Object::parameter(0x1029, 1, id::ERROR_BEHAVIOUR),
    ],
    profile::server_sdo(),
    TPDO0,
    TPDO1,
    MAPPING0,
    MAPPING1,
    [parameter(0x1F80, id::START_UP)],
    APPLICATION,
];
