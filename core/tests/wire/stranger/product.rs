//! A stranger's sensor outside of the catalogue: an inclinometer with the device profile CiA 410, node-ID 30, as its own maker would
//! write it with public items only.
//!
//! | object  | contents                                    | type | stored by |
//! |---------|---------------------------------------------|------|-----------|
//! | 2000h   | node-ID                                     | U8   | 1, 4      |
//! | 2001h   | bit rate in kbit/s                          | U16  | 1, 4      |
//! | 2100h   | filter                                      | U8   | 1, 4      |
//! | 3000h   | mounting angle                              | I16  | 1, 5      |
//! | 6000h   | resolution                                  | U16  | 1, 3      |
//! | 6010h   | slope                                       | I16  |           |
//! | 6013h   | offset of the slope                         | I16  | 1, 3      |

use plumbline::can::BitRate;
use plumbline::canopen::dictionary::{Access, Service};
use plumbline::canopen::profile::{self, Standard};
use plumbline::canopen::{
    Absent, CanopenNode, ErrorHistory, Lss, LssTable, Object, Present, Product, Text, TpdoArray,
};
use plumbline::prelude::*;
use plumbline::store::unit::NAME;

plumbline::ids! { ParameterId:
    STANDARD(6),
    TPDO(4),
    NODE_ID,
    BIT_RATE,
    FILTER,
    MOUNTING,
    RESOLUTION,
    OFFSET,
    /// Not an object: it belongs to sub-index 4.
    HIDDEN,
}

plumbline::ids! { ValueId: SLOPE }

/// The tables of the product.
pub struct StrangerProduct;

/// The sensor.
pub type Stranger = CanopenNode<StrangerProduct>;

impl Table for StrangerProduct {
    const PARAMETERS: &'static [Parameter] = plumbline::parameters![
        profile::standard_parameters(STANDARD),
        profile::tpdo_communication(TPDO, 0x180),
        [
            profile::lss_node_id_to_127(NODE_ID, 30),
            profile::bit_rate(BIT_RATE, 125),
            Parameter::new(FILTER, "Filter", DataType::U8).within(0, 9, 4),
            Parameter::new(MOUNTING, "Mounting angle", DataType::I16).in_unit("deg", 2),
            Parameter::new(RESOLUTION, "Resolution", DataType::U16).within(10, 1000, 10),
            Parameter::new(OFFSET, "Slope long16 offset", DataType::I16),
            Parameter::new(HIDDEN, "Counter of the filter", DataType::U8),
        ],
    ];
    plumbline::project!(parameters);
}

/// The slope, which is the offset while the sensor is level.
pub struct Slope(Inclinometer, i32, Published<1>);

impl Application for Slope {
    type Table = StrangerProduct;
    type Values = Published<1>;
    const QUANTITIES: &'static [Quantity] =
        &[Quantity::new(SLOPE, "Slope long16", DataType::I16).in_unit("deg", 2)];
    const INITIAL: Self = Self(Inclinometer::INITIAL, 0, Published::INITIAL);

    fn start(&mut self, calibration: Calibration) {
        self.0.calibration = calibration;
    }

    fn apply(&mut self, _: Instant, parameters: &Parameters<StrangerProduct>) -> Published<1> {
        self.1 = i32::from(parameters.get(OFFSET) as i16);
        self.2
    }

    fn sample(&mut self, _: Instant, reading: &Reading) -> Published<1> {
        let angles = definition::perpendicular(self.0.sample(reading));
        self.2 = Published::new([angles.x.centidegrees() + self.1], Faults::NONE);
        self.2
    }

    fn stale(&mut self) -> Published<1> {
        Published::new(self.2.numbers, Faults::SENSOR)
    }

    /// The counter of the filter counts its changes.
    fn write(
        id: ParameterId,
        value: u32,
        _: &Published<1>,
        parameters: &mut Parameters<StrangerProduct>,
    ) -> Result<plumbline::application::Effect, plumbline::param::Refused> {
        if id == FILTER {
            parameters.set(HIDDEN, (parameters.get(HIDDEN) + 1) & 0xFF);
        }
        parameters.set(id, value);
        Ok(plumbline::application::Effect::None)
    }
}

/// 1010h and 1011h with one more group of the maker.
const MAKERS_GROUP: [Object; 2] = [
    profile::service(
        0x1010,
        5,
        "Save mounting",
        DataType::U32,
        Access::Rw,
        Service::StoreGroup,
    ),
    profile::service(
        0x1011,
        5,
        "Restore mounting",
        DataType::U32,
        Access::Rw,
        Service::RestoreGroup,
    ),
];

const PROFILE: Standard = Standard {
    device_type: 0x0001_019A,
    errors: 4,
    names: ["TILT-1", "A", "1.00"],
    identity: [0x0000_04D2, 0x11, 0x0001_0000],
    groups: 5,
    first: STANDARD,
};

impl Product for StrangerProduct {
    type Application = Slope;
    type Tpdos = TpdoArray<1, 1>;
    type History = ErrorHistory<4>;
    type Text = Text<NAME>;
    type Lss = Present<Lss>;
    type State = ();
    type Block = Absent;
    const OBJECTS: &'static [Object] = plumbline::objects![
        profile::merge::<{ profile::STANDARD + 2 }>(&profile::standard(&PROFILE), &MAKERS_GROUP),
        profile::tpdo(0, "TPDO 1", TPDO),
        profile::mapping::<2>(0, "Mapping 1", &[("Slope", profile::entry(0x6010, 0, 16))]),
        [
            Object::parameter(0x2000, 0, NODE_ID),
            Object::parameter(0x2001, 0, BIT_RATE),
            Object::parameter(0x2100, 0, FILTER),
            Object::parameter(0x3000, 0, MOUNTING),
            Object::parameter(0x6000, 0, RESOLUTION),
            Object::value(0x6010, 0, SLOPE),
            Object::parameter(0x6013, 0, OFFSET),
        ],
    ];
    const GROUPS: &'static [(u16, u16)] = &[(0x2000, 0x2FFF), (0x3000, 0x5FFF)];
    const LSS_TABLES: &'static [LssTable] = &[(
        128,
        &[
            None,
            Some(BitRate::K125),
            Some(BitRate::K100),
            Some(BitRate::K500),
        ],
    )];
    const NODE_ID: ParameterId = NODE_ID;
    const BIT_RATE: ParameterId = BIT_RATE;
    const IMAGE: ImageId = ImageId::new(0x7006);
    plumbline::project!(objects);
}
