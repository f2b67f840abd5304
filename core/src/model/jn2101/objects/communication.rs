//! The communication profile (manual 7.6).

use super::{PLAIN, highest, number, parameter, volatile};
use crate::canopen::Key;
use crate::canopen::dictionary::{Access, DataType, Home, Live, Object};
use crate::canopen::emcy::HISTORY;
use crate::canopen::key::{TpdoKey, tpdo};

const fn constant(index: u16, name: &'static str, home: Home, data_type: DataType) -> Object {
    Object {
        index,
        name,
        data_type,
        access: Access::Const,
        home,
        ..PLAIN
    }
}

const fn live(
    index: u16,
    sub: u8,
    name: &'static str,
    data_type: DataType,
    access: Access,
    live: Live,
) -> Object {
    Object {
        index,
        sub,
        name,
        data_type,
        access,
        home: Home::Live(live),
        ..PLAIN
    }
}

/// A COB-ID that follows the node id.
const fn cob_id(index: u16, sub: u8, name: &'static str, home: Home, base: u32) -> Object {
    Object {
        index,
        sub,
        name,
        data_type: DataType::U32,
        home,
        factory: base,
        node_relative: true,
        ..PLAIN
    }
}

/// The communication parameter of a TPDO, `number` from 0 (1800h, 1801h).
const fn communication(number: u8, group: &'static str, base: u32) -> [Object; 5] {
    let index = 0x1800 + number as u16;
    [
        highest(index, group, DataType::U8, 5),
        cob_id(
            index,
            1,
            "COB-ID",
            Home::Any(tpdo(number, TpdoKey::Id)),
            base,
        ),
        parameter(
            index,
            2,
            "Transmission type",
            DataType::U8,
            Home::Transmission(tpdo(number, TpdoKey::Type)),
            1,
        ),
        Object {
            unit: "100 us",
            ..parameter(
                index,
                3,
                "Inhibit time",
                DataType::U16,
                Home::Any(tpdo(number, TpdoKey::Inhibit)),
                0,
            )
        },
        Object {
            unit: "ms",
            ..parameter(
                index,
                5,
                "Event timer",
                DataType::U16,
                Home::Any(tpdo(number, TpdoKey::Event)),
                10,
            )
        },
    ]
}

const TPDO0: [Object; 5] = communication(0, "Transmit PDO0 communication parameter", 0x180);
const TPDO1: [Object; 5] = communication(1, "Transmit PDO1 communication parameter", 0x280);

/// NMT start-up (7.3).
static START_UPS: &[u16] = &[0, 2, 8];

static PRODUCT: &str = "JN2101";
static HARDWARE_VERSION: &str = "1.0.0";
/// The oldest firmware that the manual describes.
static SOFTWARE_VERSION: &str = "2.2.0";

/// Its objects, sorted.
pub const OBJECTS: [Object; 44] = [
    constant(
        0x1000,
        "Device type",
        Home::Constant(0x0004_019A),
        DataType::U32,
    ),
    live(
        0x1001,
        0,
        "Error register",
        DataType::U8,
        Access::Ro,
        Live::ErrorRegister,
    ),
    Object {
        group: "Pre-defined error field",
        ..live(
            0x1003,
            0,
            "Number of error entries",
            DataType::U32,
            Access::Rw,
            Live::ErrorCount,
        )
    },
    Object {
        count: HISTORY as u8,
        ..live(
            0x1003,
            1,
            "Error code",
            DataType::U32,
            Access::Ro,
            Live::ErrorHistory,
        )
    },
    parameter(
        0x1005,
        0,
        "COB-ID SYNC message",
        DataType::U32,
        Home::SyncId(Key::SyncId as u8),
        0x80,
    ),
    constant(
        0x1008,
        "Product designation",
        Home::Text(&PRODUCT),
        DataType::Text,
    ),
    constant(
        0x1009,
        "Hardware version",
        Home::Text(&HARDWARE_VERSION),
        DataType::Text,
    ),
    constant(
        0x100A,
        "Software version",
        Home::Text(&SOFTWARE_VERSION),
        DataType::Text,
    ),
    Object {
        unit: "ms",
        ..parameter(
            0x100C,
            0,
            "Guard time",
            DataType::U16,
            Home::Any(Key::GuardTime as u8),
            0,
        )
    },
    parameter(
        0x100D,
        0,
        "Life time factor",
        DataType::U8,
        Home::Any(Key::LifeTimeFactor as u8),
        0,
    ),
    highest(0x1010, "Save parameters", DataType::U32, 1),
    live(
        0x1010,
        1,
        "Save all parameters",
        DataType::U32,
        Access::Rw,
        Live::Store,
    ),
    highest(0x1011, "Restore factory parameters", DataType::U32, 1),
    live(
        0x1011,
        1,
        "Restore all factory parameters",
        DataType::U32,
        Access::Rw,
        Live::Restore,
    ),
    cob_id(0x1014, 0, "COB-ID EMCY", Home::Any(Key::EmcyId as u8), 0x80),
    Object {
        unit: "100 us",
        ..parameter(
            0x1015,
            0,
            "Inhibit time EMCY",
            DataType::U16,
            Home::Any(Key::EmcyInhibit as u8),
            0,
        )
    },
    Object {
        unit: "ms",
        ..parameter(
            0x1017,
            0,
            "Heartbeat interval time",
            DataType::U16,
            Home::Any(Key::Heartbeat as u8),
            0,
        )
    },
    highest(0x1018, "Identity object", DataType::U8, 4),
    number(0x1018, 1, "Vendor ID", DataType::U32, 0x6D66_6900),
    number(0x1018, 2, "Product code", DataType::U32, 0x01),
    number(0x1018, 3, "Revision number", DataType::U32, 0xAA),
    live(
        0x1018,
        4,
        "Serial number",
        DataType::U32,
        Access::Ro,
        Live::Serial,
    ),
    Object {
        group: "Error behaviour object",
        ..number(0x1029, 0, "Number of error classes", DataType::U8, 1)
    },
    Object {
        meanings: &[
            (0, "pre-operational"),
            (1, "no change of state"),
            (2, "stopped"),
        ],
        ..volatile(parameter(
            0x1029,
            1,
            "Error behaviour",
            DataType::U8,
            Home::Range(Key::ErrorBehaviour as u8, 0, 2),
            0,
        ))
    },
    highest(0x1200, "Server SDO parameter", DataType::U8, 2),
    cob_id(
        0x1200,
        1,
        "COB-ID client to server",
        Home::Constant(0x600),
        0,
    ),
    cob_id(
        0x1200,
        2,
        "COB-ID server to client",
        Home::Constant(0x580),
        0,
    ),
    TPDO0[0],
    TPDO0[1],
    TPDO0[2],
    TPDO0[3],
    TPDO0[4],
    TPDO1[0],
    TPDO1[1],
    TPDO1[2],
    TPDO1[3],
    TPDO1[4],
    highest(0x1A00, "Transmit PDO0 mapping parameter", DataType::U8, 2),
    number(
        0x1A00,
        1,
        "Inclination value longitudinal (X axis)",
        DataType::U32,
        0x6010_0010,
    ),
    number(
        0x1A00,
        2,
        "Inclination value lateral (Y axis)",
        DataType::U32,
        0x6020_0010,
    ),
    highest(0x1A01, "Transmit PDO1 mapping parameter", DataType::U8, 2),
    number(
        0x1A01,
        1,
        "Inclination value longitudinal (X axis)",
        DataType::U32,
        0x6110_0020,
    ),
    number(
        0x1A01,
        2,
        "Inclination value lateral (Y axis)",
        DataType::U32,
        0x6120_0020,
    ),
    Object {
        meanings: &[
            (0, "slave only"),
            (2, "NMT start command"),
            (8, "autostart"),
        ],
        ..parameter(
            0x1F80,
            0,
            "NMT start-up",
            DataType::U32,
            Home::OneOf(Key::StartUp as u8, &START_UPS),
            0,
        )
    },
];
