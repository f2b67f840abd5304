//! A product with DeviceNet without mistakes. The tests replace one text of this file and compile it.

use plumbline::can::BitRate;
use plumbline::devicenet::{Assembly, Attribute, Identity, Object, Own, Product, Roles, Source};
use plumbline::param::{Permitted, Persistence};
use plumbline::prelude::*;

include!(concat!(
    env!("CARGO_MANIFEST_DIR"),
    "/tests/wire/stranger/idle.rs"
));

plumbline::ids! { pub ParameterId: MAC_ID, BAUD_RATE, BUS_OFF, POLLED, CYCLIC, DELTA, LIMIT }
plumbline::ids! { pub ValueId: SLOPE, FINE }

pub struct Mast;

#[track_caller]
const fn byte(id: ParameterId, name: &'static str, low: i64, high: i64) -> Parameter {
    Parameter {
        persistence: Persistence::AtOnce,
        ..Parameter::new(id, name, DataType::U8).within(low, high, low as i32)
    }
}

impl Table for Mast {
    const PARAMETERS: &'static [Parameter] = &[
        byte(MAC_ID, "MAC ID", 0, 63),
        byte(BAUD_RATE, "Baud rate", 0, 2),
        byte(BUS_OFF, "Bus-off interrupt", 0, 1),
        byte(POLLED, "Polled assembly", 1, 2),
        byte(CYCLIC, "Cyclic assembly", 1, 2),
        byte(DELTA, "COS delta", 0, 200),
        byte(LIMIT, "Limit", 0, 90),
    ];
    plumbline::project!(parameters);
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

const COARSE: &[Attribute] = &[
    Attribute::new(0x01, "Number", Source::Constant(DataType::U8, 4)),
    Attribute::new(0x71, "Limit", Source::Parameter(LIMIT)).settable(),
    Attribute::new(0x72, "Slope", Source::Value(SLOPE)),
    Attribute::new(0x73, "Own", Source::Own(DataType::U8)),
];

const EXACT: Attribute = Attribute::new(0x01, "Fine", Source::Value(FINE));

impl Product for Mast {
    type Application = Slope;
    const IDENTITY: Identity = Identity {
        vendor: 1,
        vendor_name: "Own",
        device_type: 0,
        device_type_name: "Generic",
        product_code: 7,
        revision: (1, 2),
        name: "MAST 1",
        catalog: "MAST",
    };
    const ROLES: Roles = Roles {
        mac_id: MAC_ID,
        baud_rate: BAUD_RATE,
        bit_rates: &[BitRate::K125, BitRate::K250, BitRate::K500],
        bus_off_interrupt: BUS_OFF,
        polled_assembly: POLLED,
        cyclic_assembly: CYCLIC,
        cos_delta: DELTA,
    };
    const OBJECTS: &'static [Object] = &[
        Object::new(0x65, "Slope", COARSE),
        Object::new(0x66, "Fine", &[EXACT]),
    ];
    const OWN: &'static [Own<Slope>] = &[Own::read_only(0x65, 0x73, |_| 1)];
    const ASSEMBLIES: &'static [Assembly] = &[
        Assembly::new(1, "Slope", &[SLOPE]),
        Assembly::new(2, "Twice", &[SLOPE, SLOPE]),
    ];
    const IMAGE: ImageId = ImageId::new(0x7003);
    plumbline::project!(attributes);

    fn distance(_: &Parameters<Mast>, one: u16, other: u16) -> u16 {
        one.abs_diff(other)
    }
}

/// For the changes of the tests.
pub const ANY: Permitted = Permitted::Any;
