//! A product with CANopen without mistakes. The tests replace one text of this file and compile it.

use plumbline::canopen::dictionary::{Access, Service};
use plumbline::canopen::emcy::{CIA_301, Cause, FaultBit, fault};
use plumbline::canopen::{Absent, ErrorHistory, Group, LssTable, Object, Product, Text, TpdoArray, profile};
use plumbline::model::listing::{self, Adjustment, Article, Guide, Resolution, Written};
use plumbline::prelude::*;

include!(concat!(env!("CARGO_MANIFEST_DIR"), "/tests/wire/stranger/idle.rs"));

plumbline::ids! { pub ParameterId: NODE_ID, BIT_RATE, LIMIT, TPDO(4) }
plumbline::ids! { pub ValueId: SLOPE, RATE }

pub struct Mast;

impl Table for Mast {
    const PARAMETERS: &'static [Parameter] = plumbline::parameters![
        [
            profile::node_id(NODE_ID, 20),
            profile::bit_rate(BIT_RATE, 250),
            Parameter::new(LIMIT, "Limit", DataType::U8).within(1, 100, 50),
        ],
        profile::tpdo_communication(TPDO, 0x180),
    ];
    plumbline::project!(parameters);
}

pub struct Slope;

impl Application for Slope {
    type Table = Mast;
    type Values = Published<2>;
    const QUANTITIES: &'static [Quantity] = &[
        Quantity::new(SLOPE, "Slope", DataType::I16),
        Quantity::new(RATE, "Rate", DataType::I32),
    ];
    const INITIAL: Self = Self;

    idle!();
}

impl Product for Mast {
    type Application = Slope;
    type Tpdos = TpdoArray<1, 1>;
    type History = ErrorHistory<2>;
    type Text = Text<8>;
    type Lss = Absent;
    type State = ();
    type Consumers = Absent;
    type Block = Absent;
    const OBJECTS: &'static [Object] = plumbline::objects![
        [profile::device_type(0x0001_019A), profile::error_register()],
        profile::error_history(2),
        profile::store(5),
        [profile::service(
            0x1010,
            5,
            "Save others",
            DataType::U32,
            Access::Rw,
            Service::StoreGroup,
        )],
        profile::restore(4),
        profile::identity(1, 2, 3),
        profile::tpdo(0, "TPDO 1", TPDO),
        profile::mapping::<2>(0, "Mapping 1", &[("Slope", 0x6010_0010)]),
        [
            Object::parameter(0x2000, 0, NODE_ID),
            Object::parameter(0x2001, 0, BIT_RATE),
            Object::parameter(0x2100, 0, LIMIT),
            Object::value(0x6010, 0, SLOPE),
            Object::value(0x6011, 0, RATE),
        ],
    ];
    const FAULTS: [FaultBit; 8] = {
        let mut faults = CIA_301;
        faults[3] = CIA_301[3];
        faults
    };
    const GROUPS: &'static [Group] = &[
        Group::new(0x2000, 0x2000),
        Group::new(0x2001, 0x5FFF),
    ];
    const NODE_ID: ParameterId = NODE_ID;
    const BIT_RATE: ParameterId = BIT_RATE;
    const IMAGE: ImageId = ImageId::new(0x7001);
    plumbline::project!(objects);
}

pub const LISTING: listing::Product = listing::Product::canopen::<Mast>(NAME, MAKER, ARTICLE)
    .guided(&Guide {
        short_names: &[(LIMIT, "limit")],
        groups: &[("limits", &[LIMIT])],
        angles: &[SLOPE],
        resolution: Some(Resolution {
            parameter: LIMIT,
            parameters: &[LIMIT],
            values: &[SLOPE],
        }),
        zero: &[Adjustment::new("x", &[(LIMIT, Written::Nothing)])],
        teach: &[],
    });

const NAME: &str = "mast";
const MAKER: &str = "Own";
const ARTICLE: Article = Article {
    name: "MAST",
    number: "1",
};

/// For the changes of the tests.
pub const SERVICE: Service = Service::StoreGroup;
