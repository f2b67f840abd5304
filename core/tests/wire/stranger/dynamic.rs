//! A product with CANopen whose TPDOs have a free COB-ID and a dynamic mapping, with LSS, own objects and numbers of 64 bits, without
//! mistakes. The wire tests run it; `host-tests/tests/mistakes` replaces one text of this file and compiles it.

use plumbline::can::BitRate;
use plumbline::canopen::dictionary::Access;
use plumbline::canopen::profile::{self, Standard, entry};
use plumbline::canopen::{
    Absent, DynamicTpdos, ErrorHistory, Lss, LssTable, Object, Own, Present, Product, Text,
};
use plumbline::prelude::*;
use plumbline::store::unit::NAME;

include!(concat!(
    env!("CARGO_MANIFEST_DIR"),
    "/tests/wire/stranger/idle.rs"
));

plumbline::ids! { pub ParameterId:
    STANDARD(6), NODE_ID, BIT_RATE, TPDO[2](4), MAPPING[2](9), TOTAL(2), SCALE(2),
}
plumbline::ids! { pub ValueId: SLOPE, FINE, SAMPLES }

pub struct Mast;

impl Table for Mast {
    const PARAMETERS: &'static [Parameter] = plumbline::parameters![
        profile::standard_parameters(STANDARD),
        [
            profile::lss_node_id(NODE_ID, 50),
            profile::bit_rate(BIT_RATE, 250),
        ],
        profile::stored_tpdo_communication(TPDO[0], 0x180),
        profile::stored_tpdo_communication(TPDO[1], 0x280),
        profile::mapping_parameters(MAPPING[0], &[entry(0x6010, 0, 16), entry(0x6110, 0, 32)]),
        profile::mapping_parameters(MAPPING[1], &[entry(0x2200, 0, 64)]),
        Parameter::new(TOTAL, "Total", DataType::I64).wide_within(-5, 1 << 40, -5),
        Parameter::new(SCALE, "Scale", DataType::Real64).wide_within(-90, 90, 2),
    ];
    plumbline::project!(parameters);
}

/// The number of samples, negative.
pub struct Slope(i32);

impl Application for Slope {
    type Table = Mast;
    type Values = Published<3>;
    const QUANTITIES: &'static [Quantity] = &[
        Quantity::new(SLOPE, "Slope", DataType::I16),
        Quantity::new(FINE, "Fine", DataType::I32),
        Quantity::new(SAMPLES, "Samples", DataType::I64),
    ];
    const INITIAL: Self = Self(0);

    fn sample(&mut self, _: Instant, _: &Reading) -> Self::Values {
        self.0 = self.0.wrapping_sub(1);
        Self::Values::new([0, 0, self.0], Faults::NONE)
    }

    idle!(except sample);
}

const PROFILE: Standard = Standard {
    device_type: 0x0001_019A,
    errors: 4,
    names: ["MAST", "A", "1.00"],
    identity: [1, 2, 3],
    groups: 4,
    first: STANDARD,
};

impl Product for Mast {
    type Application = Slope;
    type Tpdos = DynamicTpdos<2, 8>;
    type History = ErrorHistory<4>;
    type Text = Text<NAME>;
    type Lss = Present<Lss>;
    type State = ();
    type Consumers = Absent;
    type Block = Absent;
    const OBJECTS: &'static [Object] = plumbline::objects![
        profile::standard(&PROFILE),
        profile::free_tpdo(0, "TPDO 1", TPDO[0]),
        profile::free_tpdo(1, "TPDO 2", TPDO[1]),
        profile::dynamic_mapping(0, "Mapping 1", MAPPING[0]),
        profile::dynamic_mapping(1, "Mapping 2", MAPPING[1]),
        [
            Object::parameter(0x2000, 0, NODE_ID),
            Object::parameter(0x2001, 0, BIT_RATE),
            Object {
                mappable: true,
                ..Object::parameter(0x2200, 0, TOTAL)
            },
            Object {
                mappable: true,
                ..Object::parameter(0x2201, 0, SCALE)
            },
            Object::own(0x2300, 0, "Hours", DataType::U16, Access::Ro),
            Object::own(0x2301, 0, "Reset", DataType::U8, Access::Wo),
            Object::value(0x6010, 0, SLOPE),
            Object::value(0x6110, 0, FINE),
            Object::value(0x6210, 0, SAMPLES),
        ],
    ];
    const OWN: &'static [Own<Self>] = &[
        Own::number(0x2300, 0, |_, _| 1),
        Own::command(0x2301, 0, |_, _| Ok(plumbline::canopen::Then::Reply)),
    ];
    const LSS_TABLES: &'static [LssTable] = &[
        LssTable::new(128, &[None, Some(BitRate::K125)]),
        LssTable::new(129, &[]),
    ];
    const NODE_ID: ParameterId = NODE_ID;
    const BIT_RATE: ParameterId = BIT_RATE;
    const IMAGE: ImageId = ImageId::new(0x7002);
    plumbline::project!(objects);
}
