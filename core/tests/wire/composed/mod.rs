//! A product of another crate with CANopen and a second protocol: 2002h selects one of them, and 2003h restarts.
//!
//! - [`tunnel`]: a protocol of the maker, composed outside of the crate
//! - [`j1939`]: SAE J1939, by the node of the crate

mod j1939;
mod tunnel;

use plumbline::canopen::dictionary::{Access, Service};
use plumbline::canopen::{
    Abort, Absent, ErrorHistory, Object, Own, Product, Scope, Text, Then, TpdoArray, profile,
};
use plumbline::prelude::*;

plumbline::ids! { pub ParameterId: NODE_ID, BIT_RATE, SELECTOR, ADDRESS, RATE, TPDO(4) }

pub const SLOPE: ValueId = ValueId(0);

/// The tables of the product.
pub struct Mast;

impl Table for Mast {
    const PARAMETERS: &'static [Parameter] = plumbline::parameters![
        [
            profile::node_id(NODE_ID, 20),
            profile::bit_rate(BIT_RATE, 250),
            Parameter::new(SELECTOR, "Protocol", DataType::U8).within(0, 1, 0),
            Parameter::new(ADDRESS, "Address", DataType::U8).within(0, 253, 0x90),
            Parameter::new(RATE, "Rate", DataType::U16).within(0, 1000, 100),
        ],
        profile::tpdo_communication(TPDO, 0x180),
    ];
    plumbline::project!(parameters);
}

/// Always 12.34 deg.
pub struct Slope;

const VALUES: Published<1> = Published::new([12_34], Faults::NONE);

impl Application for Slope {
    type Table = Mast;
    type Values = Published<1>;
    const QUANTITIES: &'static [Quantity] =
        &[Quantity::new(SLOPE, "Slope", DataType::I16).in_unit("deg", 2)];
    const INITIAL: Self = Self;
    fn start(&mut self, _: Calibration) {}
    fn apply(&mut self, _: Instant, _: &Parameters<Mast>) -> Published<1> {
        VALUES
    }
    fn sample(&mut self, _: Instant, _: &Reading) -> Published<1> {
        VALUES
    }
    fn stale(&mut self) -> Published<1> {
        VALUES
    }
}

fn restart(_: &mut Scope<Mast>, data: &[u8]) -> Result<Then, Abort> {
    if data == [1] {
        Ok(Then::Restart)
    } else {
        Err(Abort::Value)
    }
}

impl Product for Mast {
    type Application = Slope;
    type Tpdos = TpdoArray<1, 1>;
    type History = ErrorHistory<2>;
    type Text = Text<0>;
    type Lss = Absent;
    type State = ();
    type Consumers = Absent;
    type Block = Absent;
    const OBJECTS: &'static [Object] = plumbline::objects![
        [profile::device_type(0), profile::error_register()],
        profile::error_history(2),
        [profile::highest(0x1010, "Store", DataType::U8, 1)],
        [profile::service(
            0x1010,
            1,
            "All",
            DataType::U32,
            Access::Rw,
            Service::StoreGroup
        )],
        profile::identity(1, 2, 3),
        profile::tpdo(0, "TPDO", TPDO),
        profile::mapping::<2>(0, "Mapping", &[("Slope", 0x6010_0010)]),
        [
            Object::parameter(0x2000, 0, NODE_ID),
            Object::parameter(0x2001, 0, BIT_RATE),
            Object::parameter(0x2002, 0, SELECTOR),
            Object::own(0x2003, 0, "Restart", DataType::U8, Access::Wo),
            Object::value(0x6010, 0, SLOPE),
        ],
    ];
    const OWN: &'static [Own<Self>] = &[Own::command(0x2003, 0, restart)];
    const HOSTED: Option<fn(&Parameters<Self>) -> bool> =
        Some(|parameters| parameters.get(SELECTOR) == 1);
    const NODE_ID: ParameterId = NODE_ID;
    const BIT_RATE: ParameterId = BIT_RATE;
    const IMAGE: ImageId = ImageId::new(0x7012);
    plumbline::project!(objects);
}
