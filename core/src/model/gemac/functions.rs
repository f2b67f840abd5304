//! The function select codes of the GEMAC sensors (tables 17, 18, 21 and 22), the status byte (tables 14 and 15) and the LEDs
//! (table 12).

use super::parameters::{BAUD_RATES, id};
use crate::application::Faults;
use crate::fsc::table::{Access, Field, Function, LedTable, Operation, Roles, Source};
use crate::fsc::{Condition, StatusBit};
use crate::model::listing::{Adjustment, Guide, Offset, Written};
use crate::node::{ErrorPatterns, Pattern};
use crate::param::{DataType, ParameterId, Quantity, ValueId};

/// The first angle, or the only one.
pub const ANGLE_X: ValueId = ValueId(0);
/// The second angle, of 2-axis sensors only.
pub const ANGLE_Y: ValueId = ValueId(1);

/// An angle of -90 to +90 deg (2-axis sensors).
#[track_caller]
pub(super) const fn signed_angle(id: ValueId, name: &'static str) -> Quantity {
    Quantity::new(id, name, DataType::I16)
        .in_unit("deg", 2)
        .within(-90_00, 90_00)
}

/// An angle of 0 to 359.99 deg (1-axis sensors).
#[track_caller]
pub(super) const fn unsigned_angle(id: ValueId, name: &'static str) -> Quantity {
    Quantity::new(id, name, DataType::U16)
        .in_unit("deg", 2)
        .within(0, 35_999)
}

/// The parameters that the protocol uses.
pub(super) const ROLES: Roles = Roles {
    set_id: id::SET_ID,
    reply_id: id::REPLY_ID,
    sync_id: id::SYNC_ID,
    bit_rate: id::BAUD_RATE,
    bit_rates: &BAUD_RATES,
    bus_off_recovery: id::BUS_OFF_RECOVERY,
    cyclic_time: id::CYCLIC_TIME,
    cyclic_mode: id::CYCLIC_MODE,
};

/// The codes that read and write parameters. The second zero offset is the last row.
const ACCESS: [Access; 10] = [
    Access::new(0x10, 0x20, "Set-Parameter-ID", &[id::SET_ID]),
    Access::new(0x11, 0x21, "Reply-Parameter-ID", &[id::REPLY_ID]),
    Access::new(0x12, 0x22, "Sync-ID", &[id::SYNC_ID]),
    Access::new(0x13, 0x23, "Baud Rate", &[id::BAUD_RATE]),
    Access::new(
        0x14,
        0x24,
        "Automatic Bus-Off Recovery",
        &[id::BUS_OFF_RECOVERY],
    ),
    Access::new(0x15, 0x25, "Cyclic Time", &[id::CYCLIC_TIME]),
    Access::new(0x16, 0x26, "Cyclic Mode", &[id::CYCLIC_MODE]),
    Access::new(
        0x17,
        0x27,
        "Cut-off Frequency and Filter Type",
        &[id::CUT_OFF, id::FILTER_TYPE],
    ),
    Access::new(0x18, 0x28, "Zero Offset X", &[id::ZERO_X]),
    Access::new(0x19, 0x29, "Zero Offset Y", &[id::ZERO_Y]),
];

/// The codes of a 2-axis sensor.
pub(super) const ACCESS_TWO_AXES: &[Access] = &ACCESS;

/// The codes of a 1-axis sensor.
pub(super) const ACCESS_ONE_AXIS: &[Access] = {
    let [a, b, c, d, e, f, g, h, zero, _] = ACCESS;
    let zero = Access {
        name: "Zero Offset",
        ..zero
    };
    &[a, b, c, d, e, f, g, h, zero]
};

const fn named(source: Source, name: &'static str) -> Field {
    Field { source, name }
}

/// The functions that do not access parameters. `inclination` is the reply to 00h.
const fn functions(inclination: &'static [Field]) -> [Function; 7] {
    [
        Function::new(0x00, "Inclination", Operation::Inclination).replying(inclination),
        Function::new(0x02, "Status", Operation::ReadStatus),
        Function::new(0x03, "Product Number and Revision", Operation::Read).replying(
            const {
                &[
                    named(Source::ProductNumber, "Product Number"),
                    named(Source::Revision, "Revision"),
                ]
            },
        ),
        Function::new(0x04, "Serial Number and Software Version", Operation::Read).replying(
            const {
                &[
                    named(Source::SerialNumber, "Serial Number"),
                    named(Source::SoftwareVersion, "Software Version"),
                ]
            },
        ),
        Function::new(0x40, "Load Defaults", Operation::Load).signed(b"LOAD"),
        Function::new(0x50, "Save", Operation::Save).signed(b"SAVE"),
        Function::new(0xFF, "Alive or Reset", Operation::Alive)
            .signed(b"RESET")
            .replying(
                const {
                    &[
                        named(Source::ActiveSetId, "Active Set-Parameter-ID"),
                        named(Source::SoftwareVersion, "Alive Software Version"),
                    ]
                },
            ),
    ]
}

const COUNTER: Field = named(Source::Counter, "Cyclic Counter");

/// The functions of a 1-axis sensor (table 21).
pub(super) const FUNCTIONS_ONE_AXIS: &[Function] =
    &functions(&[Field::described(Source::Value(ANGLE_X)), COUNTER]);

/// The functions of a 2-axis sensor (table 22).
pub(super) const FUNCTIONS_TWO_AXES: &[Function] = &functions(&[
    Field::described(Source::Value(ANGLE_X)),
    Field::described(Source::Value(ANGLE_Y)),
    COUNTER,
]);

const fn status(x: StatusBit, y: StatusBit) -> [StatusBit; 8] {
    [
        StatusBit::new("DefaultParam", Condition::DefaultParam),
        StatusBit::new("AutobaudDetection", Condition::AutobaudDetection),
        StatusBit::new("EEPROMError", Condition::EepromError),
        StatusBit::new("CmdParamError", Condition::CmdParamError),
        x,
        y,
        StatusBit::new("AccuracyWarning", Condition::Fault(Faults::WARM_UP)),
        RESERVED,
    ]
}

const RESERVED: StatusBit = StatusBit::new("", Condition::Never);

/// The status byte of a 1-axis sensor (table 14).
pub(super) const STATUS_ONE_AXIS: [StatusBit; 8] = status(
    StatusBit::new("SensorError", Condition::Fault(Faults::X)),
    RESERVED,
);

/// The status byte of a 2-axis sensor (table 15).
pub(super) const STATUS_TWO_AXES: [StatusBit; 8] = status(
    StatusBit::new("SensorErrorX", Condition::Fault(Faults::X)),
    StatusBit::new("SensorErrorY", Condition::Fault(Faults::Y)),
);

/// The status LEDs (table 12): the error LED flashes from the CAN warning limit on.
pub(super) const LEDS: LedTable = LedTable {
    detecting: Pattern::Flickering,
    normal: Pattern::On,
    error: ErrorPatterns {
        working: Pattern::Off,
        warning: Pattern::SingleFlash,
        bus_off: Pattern::On,
    },
};

/// The guide for a sensor with these short names, angles and zero offsets.
const fn guide(
    short_names: &'static [(ParameterId, &'static str)],
    angles: &'static [ValueId],
    zero: &'static [Adjustment],
) -> Guide {
    Guide {
        short_names,
        groups: &[("filter", &[id::CUT_OFF, id::FILTER_TYPE])],
        angles,
        zero,
        ..Guide::NONE
    }
}

const ZERO_X: Adjustment =
    Adjustment::new("x", &[(id::ZERO_X, Written::Nothing)]).with_offset(Offset {
        angle: ANGLE_X,
        parameter: id::ZERO_X,
        switch: None,
    });
const ZERO_Y: Adjustment =
    Adjustment::new("y", &[(id::ZERO_Y, Written::Nothing)]).with_offset(Offset {
        angle: ANGLE_Y,
        parameter: id::ZERO_Y,
        switch: None,
    });

/// The guide for a 1-axis sensor.
pub(super) const GUIDE_ONE_AXIS: Guide = guide(
    &[
        (id::SET_ID, "set-id"),
        (id::REPLY_ID, "reply-id"),
        (id::BUS_OFF_RECOVERY, "bus-off-recovery"),
        (id::CUT_OFF, "cut-off"),
        (id::ZERO_X, "zero"),
    ],
    &[ANGLE_X],
    &[ZERO_X],
);

/// The guide for a 2-axis sensor.
pub(super) const GUIDE_TWO_AXES: Guide = guide(
    &[
        (id::SET_ID, "set-id"),
        (id::REPLY_ID, "reply-id"),
        (id::BUS_OFF_RECOVERY, "bus-off-recovery"),
        (id::CUT_OFF, "cut-off"),
        (id::ZERO_X, "zero-x"),
        (id::ZERO_Y, "zero-y"),
    ],
    &[ANGLE_X, ANGLE_Y],
    &[ZERO_X, ZERO_Y],
);
