//! A product with FSC without mistakes. The tests replace one text of this file and compile it.

use plumbline::can::BitRate;
use plumbline::fsc::table::{Access, Field, Function, LedTable, Operation, Roles, Source};
use plumbline::fsc::{Article, Condition, Own, Product, StatusBit};
use plumbline::node::{ErrorPatterns, Pattern};
use plumbline::param::{Constraint, Relation};
use plumbline::prelude::*;

include!(concat!(
    env!("CARGO_MANIFEST_DIR"),
    "/tests/wire/stranger/idle.rs"
));

plumbline::ids! { pub ParameterId:
    SET_ID, REPLY_ID, SYNC_ID, BIT_RATE, RECOVERY, CYCLIC_TIME, CYCLIC_MODE, ZERO, LIMIT, TOTAL(2),
}
plumbline::ids! { pub ValueId: SLOPE, FINE }

pub struct Mast;

#[track_caller]
const fn identifier(id: ParameterId, name: &'static str, factory: i32) -> Parameter {
    Parameter::new(id, name, DataType::U32).within(1, 0x7FF, factory)
}

impl Table for Mast {
    const PARAMETERS: &'static [Parameter] = plumbline::parameters![
        [
            identifier(SET_ID, "Set-ID", 0x300),
            identifier(REPLY_ID, "Reply-ID", 0x301),
            identifier(SYNC_ID, "Sync-ID", 0x100),
            Parameter::new(BIT_RATE, "Bit rate", DataType::U8).within(0, 1, 0),
            Parameter::new(RECOVERY, "Recovery", DataType::U8).within(0, 1, 0),
            Parameter::new(CYCLIC_TIME, "Cyclic time", DataType::U16).within(1, 1000, 100),
            Parameter::new(CYCLIC_MODE, "Cyclic mode", DataType::U8).within(0, 1, 0),
            Parameter::new(ZERO, "Zero", DataType::I16).within(-100, 100, 0),
            Parameter {
                permitted: plumbline::param::Permitted::Named,
                meanings: &[(1, "low"), (5, "high")],
                factory: 5,
                ..Parameter::new(LIMIT, "Limit", DataType::U8)
            },
        ],
        Parameter::new(TOTAL, "Total", DataType::U64).wide_within(0, 1_000_000_000_000, 7),
    ];
    const CONSTRAINTS: &'static [Constraint] = &[
        Constraint::different(LIMIT, RECOVERY),
        Constraint::new(Relation::AtMost { parameter: CYCLIC_TIME, high: 500, other: CYCLIC_MODE, number: 1 }),
    ];
    plumbline::project!(parameters);
}

const SPARE: &[Field] = &[Field::described(Source::Value(FINE))];

/// A function that reads, for tables with many codes.
pub const fn spare(code: u8) -> Function {
    Function::new(code, "Spare", Operation::Read).replying(SPARE)
}

pub struct Slope;

impl Application for Slope {
    type Table = Mast;
    type Values = Published<2>;
    const QUANTITIES: &'static [Quantity] = &[
        Quantity::new(SLOPE, "Slope", DataType::I16),
        Quantity::new(FINE, "Fine", DataType::I32),
    ];
    const INITIAL: Self = Self;

    idle!();
}

impl Product for Mast {
    type Application = Slope;

    const ROLES: Roles = Roles {
        set_id: SET_ID,
        reply_id: REPLY_ID,
        sync_id: SYNC_ID,
        bit_rate: BIT_RATE,
        bit_rates: &[None, Some(BitRate::K250)],
        bus_off_recovery: RECOVERY,
        cyclic_time: CYCLIC_TIME,
        cyclic_mode: CYCLIC_MODE,
    };
    const ACCESS: &'static [Access] = &[
        Access::new(0x10, 0x20, "Set-ID", &[SET_ID]),
        Access::new(0x18, 0x28, "Zero and limit", &[ZERO, LIMIT]),
    ];
    const FUNCTIONS: &'static [Function] = &[
        Function::new(0x00, "Inclination", Operation::Inclination).replying(&[
            Field::described(Source::Value(SLOPE)),
            Field::described(Source::Counter),
        ]),
        Function::new(0x04, "Serial number", Operation::Read)
            .replying(&[Field::described(Source::SerialNumber)]),
        Function::new(0x40, "Load", Operation::Load).signed(b"LOAD"),
        Function::new(0x50, "Save", Operation::Save).signed(b"SAVE"),
        Function::new(0x60, "Own", Operation::Own),
        Function::new(0xFF, "Alive", Operation::Alive).signed(b"RESET"),
    ];
    const OWN: &'static [Own<Slope>] = &[Own {
        code: 0x60,
        serve: |_, _| None,
    }];
    const STATUS: [StatusBit; 8] = [
        StatusBit::new("", Condition::DefaultParam),
        StatusBit::new("", Condition::AutobaudDetection),
        StatusBit::new("", Condition::EepromError),
        StatusBit::new("", Condition::CmdParamError),
        StatusBit::new("", Condition::Fault(Faults::X)),
        StatusBit::new("", Condition::Fault(Faults::Y)),
        StatusBit::new("", Condition::Never),
        StatusBit::new("", Condition::Never),
    ];
    const LEDS: LedTable = LedTable {
        detecting: Pattern::Flickering,
        normal: Pattern::On,
        error: ErrorPatterns {
            working: Pattern::Off,
            warning: Pattern::SingleFlash,
            bus_off: Pattern::On,
        },
    };
    plumbline::project!(functions);

    fn set_article(_: &mut Slope, _: &Article) {}
}
