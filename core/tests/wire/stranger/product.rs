//! A sensor that is not in the catalogue: an inclinometer with the device profile CiA 410 and node-ID 30. It uses public items only, as a
//! product of another crate.
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
//! | 1016h:n | three monitored nodes                       | U32  | 1, 2      |
//! | 1029h:1 | error behaviour                             | U8   | 1, 2      |
//! | 2200h   | a count                                     | U64  | 1, 4      |
//! | 2201h   | a balance                                   | I64  | 1, 4      |
//! | 2202h   | a factor, -90 to 90                         | R32  | 1, 4      |
//! | 2203h   | a scale                                     | R64  | 1, 4      |
//! | 5000h   | slope in deg                                | R32  |           |
//! | 5001h   | number of samples, negative                 | I64  |           |
//! | 5002h   | half of the slope in deg                    | R64  |           |

use plumbline::application::Effect;
use plumbline::can::BitRate;
use plumbline::canopen::dictionary::{Access, Service};
use plumbline::canopen::profile::{self, Standard, entry};
use plumbline::canopen::{
    Absent, ErrorHistory, Group, Heartbeats, Lss, LssTable, Object, Present, Product, Text,
    TpdoArray,
};
use plumbline::param::{Permitted, Refused};
use plumbline::prelude::*;
use plumbline::store::unit::NAME;

plumbline::ids! { ParameterId:
    STANDARD(6),
    TPDO[2](4),
    NODE_ID,
    BIT_RATE,
    FILTER,
    MOUNTING,
    RESOLUTION,
    OFFSET,
    /// A parameter without an object: sub-index 4 of 1010h stores it.
    HIDDEN,
    CONSUMERS(3),
    /// Numbers of 64 bits have two rows each.
    COUNT(2),
    BALANCE(2),
    FACTOR,
    SCALE(2),
    ERROR_BEHAVIOUR,
}

plumbline::ids! { ValueId: SLOPE, REAL_SLOPE, SAMPLES, MEAN }

/// The tables of the product.
pub struct StrangerProduct;

impl Table for StrangerProduct {
    const PARAMETERS: &'static [Parameter] = plumbline::parameters![
        profile::standard_parameters(STANDARD),
        profile::tpdo_communication(TPDO[0], 0x180),
        profile::tpdo_communication(TPDO[1], 0x280),
        [
            profile::lss_node_id_to_127(NODE_ID, 30),
            Parameter {
                permitted: Permitted::OneOf(&[125, 250, 500]),
                ..profile::bit_rate(BIT_RATE, 125)
            },
            Parameter::new(FILTER, "Filter", DataType::U8).within(0, 9, 4),
            Parameter::new(MOUNTING, "Mounting angle", DataType::I16).in_unit("deg", 2),
            Parameter::new(RESOLUTION, "Resolution", DataType::U16).within(10, 1000, 10),
            Parameter::new(OFFSET, "Slope long16 offset", DataType::I16),
            Parameter::new(HIDDEN, "Counter of the filter", DataType::U8),
        ],
        profile::consumer_parameters::<3>(CONSUMERS),
        Parameter::new(COUNT, "Count", DataType::U64).wide(1 << 40),
        Parameter::new(BALANCE, "Balance", DataType::I64).wide(-5_i64 as u64),
        [Parameter::new(FACTOR, "Factor", DataType::Real32).within(-90, 90, 2)],
        Parameter::new(SCALE, "Scale", DataType::Real64).wide(0.25_f64.to_bits()),
        [profile::error_behaviour(ERROR_BEHAVIOUR)],
    ];
    plumbline::project!(parameters);
}

/// The published values: the slope in 0.01 deg, and the number of samples.
#[derive(Clone, Copy)]
pub struct Measured {
    slope: i32,
    samples: i32,
    faults: Faults,
}

impl Values for Measured {
    const INITIAL: Self = Self {
        slope: 0,
        samples: 0,
        faults: Faults::NONE,
    };
    const CAPACITY: usize = 4;

    fn number(&self, id: ValueId) -> u32 {
        match id {
            REAL_SLOPE => plumbline::param::real32(self.slope, 2),
            SAMPLES => -self.samples as u32,
            _ => self.slope as u32,
        }
    }

    fn wide(&self, id: ValueId) -> u64 {
        match id {
            MEAN => (f64::from(self.slope) / 200.0).to_bits(),
            _ => i64::from(-self.samples) as u64,
        }
    }

    fn faults(&self) -> Faults {
        self.faults
    }
}

/// The slope plus the offset.
pub struct Slope(Inclinometer, i32, Measured);

impl Application for Slope {
    type Table = StrangerProduct;
    type Values = Measured;
    const QUANTITIES: &'static [Quantity] = &[
        Quantity::new(SLOPE, "Slope long16", DataType::I16).in_unit("deg", 2),
        Quantity::new(REAL_SLOPE, "Slope", DataType::Real32).in_unit("deg", 0),
        Quantity::new(SAMPLES, "Samples", DataType::I64),
        Quantity::new(MEAN, "Half of the slope", DataType::Real64).in_unit("deg", 0),
    ];
    const INITIAL: Self = Self(Inclinometer::INITIAL, 0, Measured::INITIAL);

    fn start(&mut self, calibration: Calibration) {
        self.0.calibration = calibration;
    }

    fn apply(&mut self, _: Instant, parameters: &Parameters<StrangerProduct>) -> Measured {
        self.1 = i32::from(parameters.get(OFFSET) as i16);
        self.2
    }

    fn sample(&mut self, _: Instant, reading: &Reading) -> Measured {
        let angles = definition::perpendicular(self.0.sample(reading));
        self.2 = Measured {
            slope: angles.x.centidegrees() + self.1,
            samples: self.2.samples.wrapping_add(1),
            faults: Faults::NONE,
        };
        self.2
    }

    fn stale(&mut self) -> Measured {
        Measured {
            faults: Faults::SENSOR,
            ..self.2
        }
    }

    /// The counter of the filter counts its changes.
    fn write(
        id: ParameterId,
        value: u32,
        _: &Measured,
        parameters: &mut Parameters<StrangerProduct>,
    ) -> Result<Effect, Refused> {
        if id == FILTER {
            parameters.set(HIDDEN, (parameters.get(HIDDEN) + 1) & 0xFF);
        }
        parameters.set(id, value);
        Ok(Effect::None)
    }
}

/// The objects between the standard objects: 1010h and 1011h with one more manufacturer-specific group, the heartbeat consumer, and the
/// error behaviour.
const MORE: &[Object] = plumbline::objects![
    [group(0x1010, "Save mounting", Service::StoreGroup)],
    [group(0x1011, "Restore mounting", Service::RestoreGroup)],
    profile::consumers::<4>(CONSUMERS),
    [profile::highest(0x1029, "Error behaviour", DataType::U8, 1)],
    [Object::parameter(0x1029, 1, ERROR_BEHAVIOUR)],
];

const fn group(index: u16, name: &'static str, service: Service) -> Object {
    profile::service(index, 5, name, DataType::U32, Access::Rw, service)
}

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
    type Tpdos = TpdoArray<2, 2>;
    type History = ErrorHistory<4>;
    type Text = Text<NAME>;
    type Lss = Present<Lss>;
    type State = ();
    type Consumers = Heartbeats<3>;
    type Block = Absent;
    const OBJECTS: &'static [Object] = plumbline::objects![
        profile::merge::<{ profile::STANDARD + MORE.len() }>(&profile::standard(&PROFILE), MORE),
        profile::tpdo(0, "TPDO 1", TPDO[0]),
        profile::tpdo(1, "TPDO 2", TPDO[1]),
        profile::mapping::<3>(
            0,
            "Mapping 1",
            &[
                ("Slope", entry(0x6010, 0, 16)),
                ("Real", entry(0x5000, 0, 32))
            ],
        ),
        profile::mapping::<2>(1, "Mapping 2", &[("Samples", entry(0x5001, 0, 64))]),
        [
            Object::parameter(0x2000, 0, NODE_ID),
            Object::parameter(0x2001, 0, BIT_RATE),
            Object::parameter(0x2100, 0, FILTER),
            Object::parameter(0x2200, 0, COUNT),
            Object::parameter(0x2201, 0, BALANCE),
            Object::parameter(0x2202, 0, FACTOR),
            Object::parameter(0x2203, 0, SCALE),
            Object::parameter(0x3000, 0, MOUNTING),
            Object::value(0x5000, 0, REAL_SLOPE),
            Object::value(0x5001, 0, SAMPLES),
            Object::value(0x5002, 0, MEAN),
            Object::parameter(0x6000, 0, RESOLUTION),
            Object::value(0x6010, 0, SLOPE),
            Object::parameter(0x6013, 0, OFFSET),
        ],
    ];
    const GROUPS: &'static [Group] = &[Group::new(0x2000, 0x2FFF), Group::new(0x3000, 0x5FFF)];
    const LSS_TABLES: &'static [LssTable] = &[LssTable::new(
        128,
        &[None, Some(BitRate::K125), None, Some(BitRate::K500)],
    )];
    const NODE_ID: ParameterId = NODE_ID;
    const BIT_RATE: ParameterId = BIT_RATE;
    const IMAGE: ImageId = ImageId::new(0x7006);
    plumbline::project!(objects);
}
