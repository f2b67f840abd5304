//! What GEMAC's 1- and 2-axis sensors share: parameters (tables 17 to 19, section 9.10), functions and LEDs (table 12).

use crate::fsc::table::{Check, Field, Function, LedTable, Parameter};
use crate::fsc::{Key, code};
use crate::measure::low_pass::Kind;
use crate::node::Pattern;

/// A number without unit and names.
const PLAIN: Field = Field {
    symbol: "",
    name: "",
    size: 1,
    signed: false,
    decimals: 0,
    unit: "",
    min: 0,
    max: 0xFF,
    meanings: &[],
};

const fn identifier(key: Key, name: &'static str, fields: &'static [Field], id: u32) -> Parameter {
    Parameter {
        key,
        name,
        fields,
        check: Check::Identifier,
        factory: id,
    }
}

const fn id_field(name: &'static str) -> [Field; 1] {
    [Field {
        symbol: "ID",
        name,
        size: 4,
        max: 0x9FFF_FFFF,
        ..PLAIN
    }]
}

const fn range(key: Key, field: &'static [Field; 1], factory: u32) -> Parameter {
    let [Field { name, .. }] = field;
    Parameter {
        key,
        name,
        fields: field,
        check: Check::Range,
        factory,
    }
}

/// Set-Parameter-ID, 300h.
pub const SET_ID: Parameter = identifier(
    Key::SetId,
    "Set-Parameter-ID",
    &id_field("Set-Parameter-ID"),
    0x300,
);

/// Reply-Parameter-ID, 301h.
pub const REPLY_ID: Parameter = identifier(
    Key::ReplyId,
    "Reply-Parameter-ID",
    &id_field("Reply-Parameter-ID"),
    0x301,
);

/// Sync-ID, 100h.
pub const SYNC_ID: Parameter = identifier(Key::SyncId, "Sync-ID", &id_field("Sync-ID"), 0x100);

/// Baud rate, automatic detection.
pub const BAUD_RATE: Parameter = range(
    Key::BaudRate,
    &[Field {
        symbol: "BR",
        name: "Baud Rate",
        max: 10,
        meanings: &[
            (0, "automatic detection"),
            (1, "10 kbit/s"),
            (2, "20 kbit/s"),
            (3, "50 kbit/s"),
            (4, "100 kbit/s"),
            (5, "125 kbit/s"),
            (6, "250 kbit/s"),
            (7, "500 kbit/s"),
            (8, "800 kbit/s"),
            (9, "1 Mbit/s"),
            (10, "62.5 kbit/s"),
        ],
        ..PLAIN
    }],
    0,
);

/// Automatic bus-off recovery, off.
pub const BUS_OFF_RECOVERY: Parameter = range(
    Key::BusOffRecovery,
    &[Field {
        symbol: "ABOR",
        name: "Automatic Bus-Off Recovery",
        max: 1,
        meanings: &[(0, "stays in bus-off"), (1, "recovers")],
        ..PLAIN
    }],
    0,
);

/// Cyclic time, 250 ms.
pub const CYCLIC_TIME: Parameter = range(
    Key::CyclicTime,
    &[Field {
        symbol: "CYT",
        name: "Cyclic Time",
        size: 2,
        unit: "ms",
        min: 1,
        max: 65_535,
        ..PLAIN
    }],
    250,
);

/// Cyclic mode, off.
pub const CYCLIC_MODE: Parameter = range(
    Key::CyclicMode,
    &[Field {
        symbol: "CYM",
        name: "Cyclic Mode",
        max: 1,
        meanings: &[(0, "off"), (1, "on")],
        ..PLAIN
    }],
    0,
);

/// Cut-off frequency and filter type: 2 Hz, critically damped.
pub const FILTER: Parameter = Parameter {
    key: Key::Filter,
    name: "Cut-off Frequency and Filter Type",
    fields: &[
        Field {
            symbol: "CF",
            name: "Cut-off Frequency",
            size: 2,
            unit: "mHz",
            min: *Kind::Butterworth.cutoffs().start() as i64,
            max: *Kind::Butterworth.cutoffs().end() as i64,
            ..PLAIN
        },
        Field {
            symbol: "FT",
            name: "Filter Type",
            max: 2,
            meanings: &[(0, "off"), (1, "Butterworth"), (2, "critically damped")],
            ..PLAIN
        },
    ],
    check: Check::CutOff,
    factory: 2000 | 2 << 16,
};

/// A zero offset of -90 to +90 deg.
pub const fn zero_offset(key: Key, field: &'static [Field; 1]) -> Parameter {
    range(key, field, 0)
}

/// The field of a zero offset in two's complement.
pub const fn signed_offset(symbol: &'static str, name: &'static str) -> Field {
    Field {
        symbol,
        name,
        size: 2,
        signed: true,
        decimals: 2,
        unit: "deg",
        min: -9000,
        max: 9000,
        ..PLAIN
    }
}

/// The field of a zero offset of 0 to 359.99 deg.
pub const fn unsigned_offset(symbol: &'static str, name: &'static str) -> Field {
    Field {
        symbol,
        name,
        size: 2,
        decimals: 2,
        unit: "deg",
        max: 35_999,
        ..PLAIN
    }
}

/// An angle of -90 to +90 deg.
pub const fn signed_angle(symbol: &'static str, name: &'static str) -> Field {
    signed_offset(symbol, name)
}

/// An angle of 0 to 359.99 deg.
pub const fn unsigned_angle(symbol: &'static str, name: &'static str) -> Field {
    unsigned_offset(symbol, name)
}

/// The counter of cyclic mode, present while that is on.
pub const COUNTER: Field = Field {
    symbol: "CNT",
    name: "Cyclic Counter",
    size: 2,
    max: 0xFFFF,
    ..PLAIN
};

const VERSION: Field = Field {
    symbol: "SWV",
    name: "Software Version",
    size: 2,
    max: 0xFFFF,
    ..PLAIN
};

/// The functions besides the parameters; `inclination` is the reply to 00h.
pub const fn functions(inclination: &'static [Field]) -> [Function; 7] {
    const NONE: Function = Function {
        fsc: 0,
        name: "",
        signature: &[],
        reply: &[],
    };
    [
        Function {
            fsc: code::INCLINATION,
            name: "Inclination",
            reply: inclination,
            ..NONE
        },
        Function {
            fsc: code::STATUS,
            name: "Status",
            ..NONE
        },
        Function {
            fsc: code::PRODUCT,
            name: "Product Number and Revision",
            reply: &[
                Field {
                    symbol: "PR",
                    name: "Product Number",
                    size: 4,
                    max: 0xFFFF_FFFF,
                    ..PLAIN
                },
                Field {
                    symbol: "RV",
                    name: "Revision",
                    size: 2,
                    max: 0xFFFF,
                    ..PLAIN
                },
            ],
            ..NONE
        },
        Function {
            fsc: code::SERIAL,
            name: "Serial Number and Software Version",
            reply: &[
                Field {
                    symbol: "SN",
                    name: "Serial Number",
                    size: 4,
                    max: 0xFFFF_FFFF,
                    ..PLAIN
                },
                VERSION,
            ],
            ..NONE
        },
        Function {
            fsc: code::LOAD,
            name: "Load Defaults",
            signature: code::LOAD_SIGNATURE,
            ..NONE
        },
        Function {
            fsc: code::SAVE,
            name: "Save",
            signature: code::SAVE_SIGNATURE,
            ..NONE
        },
        Function {
            fsc: code::ALIVE,
            name: "Alive or Reset",
            signature: code::RESET_SIGNATURE,
            reply: &[
                Field {
                    symbol: "SID",
                    name: "Active Set-Parameter-ID",
                    size: 4,
                    max: 0x9FFF_FFFF,
                    ..PLAIN
                },
                Field {
                    name: "Alive Software Version",
                    ..VERSION
                },
            ],
        },
    ]
}

/// The status LEDs (table 12): the error LED flashes from the CAN warning limit on.
pub const LEDS: LedTable = LedTable {
    detecting: Pattern::Flickering,
    normal: Pattern::On,
    working: Pattern::Off,
    warning: Pattern::SingleFlash,
    bus_off: Pattern::On,
};
