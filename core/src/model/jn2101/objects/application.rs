//! The manufacturer's and the device profile's objects (manual 7.7 and 14).

use super::super::measuring::Output;
use super::super::slots;
use super::{PLAIN, highest, number, parameter, volatile};
use crate::canopen::dictionary::{Access, DataType, Home, Object};

const fn measured(
    index: u16,
    name: &'static str,
    data_type: DataType,
    unit: &'static str,
    output: Output,
) -> Object {
    Object {
        index,
        name,
        data_type,
        mappable: true,
        unit,
        home: Home::Measured(output as u8),
        ..PLAIN
    }
}

const OFF_ON: &[(u32, &str)] = &[(0, "off"), (1, "on")];

/// The bit rates in kbit/s (9.1).
static BIT_RATES: &[u16] = &[10, 20, 50, 125, 250, 500, 800, 1000];

/// The resolutions in 0.001 deg.
static RESOLUTIONS: &[u16] = &[1, 10, 100, 1000];

/// What makes a factory reset.
static MAKE: &[u16] = &[1];

/// Its objects, sorted.
pub const OBJECTS: [Object; 26] = [
    parameter(
        0x2000,
        0,
        "Node ID",
        DataType::U8,
        Home::Range(slots::NODE_ID, 1, 127),
        10,
    ),
    Object {
        unit: "kbit/s",
        ..parameter(
            0x2001,
            0,
            "Baud rate",
            DataType::U16,
            Home::OneOf(slots::BIT_RATE, &BIT_RATES),
            125,
        )
    },
    Object {
        meanings: &[(1, "reset")],
        ..volatile(parameter(
            0x2002,
            0,
            "Sensor reset",
            DataType::U8,
            Home::Range(slots::RESET, 0, 1),
            0,
        ))
    },
    Object {
        meanings: &[(0, "off"), (1, "+-180 deg"), (2, "0 to 360 deg")],
        ..parameter(
            0x2040,
            0,
            "Quadrant correction",
            DataType::U8,
            Home::Range(slots::QUADRANT, 0, 2),
            1,
        )
    },
    Object {
        meanings: OFF_ON,
        ..parameter(
            0x2041,
            0,
            "Heating",
            DataType::U8,
            Home::Range(slots::HEATING, 0, 1),
            1,
        )
    },
    Object {
        meanings: &[
            (0, "no change"),
            (1, "relative measurement"),
            (2, "absolute measurement"),
        ],
        ..parameter(
            0x2042,
            0,
            "Teach index",
            DataType::U8,
            Home::Range(slots::TEACH, 0, 2),
            2,
        )
    },
    Object {
        meanings: &[
            (0, "off"),
            (1, "10 Hz"),
            (2, "5 Hz"),
            (3, "1 Hz"),
            (4, "0.5 Hz"),
        ],
        ..parameter(
            0x2043,
            0,
            "FIR filter",
            DataType::U8,
            Home::Range(slots::FILTER, 0, 4),
            2,
        )
    },
    Object {
        meanings: &[
            (0, "perpendicular"),
            (1, "Euler"),
            (2, "gimbal X"),
            (3, "gimbal Y"),
        ],
        ..parameter(
            0x2044,
            0,
            "Angle calculation",
            DataType::U8,
            Home::Range(slots::DEFINITION, 0, 3),
            0,
        )
    },
    Object {
        meanings: OFF_ON,
        ..parameter(
            0x2045,
            0,
            "Terminating resistor",
            DataType::U8,
            Home::Range(slots::TERMINATION, 0, 1),
            1,
        )
    },
    Object {
        meanings: &[
            (0, "unchanged"),
            (1, "relative measurement"),
            (2, "absolute measurement"),
        ],
        ..parameter(
            0x2046,
            0,
            "Zero point",
            DataType::U8,
            Home::Range(slots::ZERO, 0, 2),
            2,
        )
    },
    Object {
        meanings: &[(0, "failed"), (1, "make, or made")],
        ..volatile(parameter(
            0x207F,
            0,
            "Factory reset",
            DataType::U8,
            Home::OneOf(slots::FACTORY_RESET, &MAKE),
            0,
        ))
    },
    Object {
        index: 0x3000,
        name: "Programming key",
        data_type: DataType::Text,
        access: Access::Rw,
        home: Home::Key,
        ..PLAIN
    },
    highest(0x4004, "MEMS self-test", DataType::U8, 2),
    volatile(parameter(
        0x4004,
        1,
        "Activate self-test",
        DataType::U8,
        Home::Range(slots::SELF_TEST, 0, 1),
        0,
    )),
    Object {
        access: Access::Ro,
        ..volatile(parameter(
            0x4004,
            2,
            "Self-test register",
            DataType::U8,
            Home::Any(slots::SELF_TEST_RESULT),
            0,
        ))
    },
    measured(
        0x4080,
        "MEMS temperature",
        DataType::I32,
        "0.1 degC",
        Output::Temperature,
    ),
    Object {
        mappable: false,
        ..measured(
            0x4081,
            "Heating power",
            DataType::U16,
            "mW",
            Output::HeatingPower,
        )
    },
    Object {
        unit: "0.001 deg",
        ..parameter(
            0x6000,
            0,
            "Resolution",
            DataType::U16,
            Home::OneOf(slots::RESOLUTION, &RESOLUTIONS),
            10,
        )
    },
    measured(0x6010, "Slope long16", DataType::I16, "6000h", Output::X16),
    number(
        0x6011,
        0,
        "Slope long16 operating parameter",
        DataType::U8,
        0,
    ),
    measured(
        0x6020,
        "Slope lateral16",
        DataType::I16,
        "6000h",
        Output::Y16,
    ),
    number(
        0x6021,
        0,
        "Slope lateral16 operating parameter",
        DataType::U8,
        0,
    ),
    measured(0x6110, "Slope long32", DataType::I32, "6000h", Output::X32),
    number(
        0x6111,
        0,
        "Slope long32 operating parameter",
        DataType::U8,
        0,
    ),
    measured(
        0x6120,
        "Slope lateral32",
        DataType::I32,
        "6000h",
        Output::Y32,
    ),
    number(
        0x6121,
        0,
        "Slope lateral32 operating parameter",
        DataType::U8,
        0,
    ),
];
