//! A CANopen sensor with one slope: its parameters, its measurement, its object dictionary.
#![cfg_attr(target_os = "none", no_std)]

use plumbline::canopen::{Absent, ErrorHistory, Object, Product, Text, TpdoArray, profile};
use plumbline::model::listing::{self, Article, Guide};
use plumbline::prelude::*;

/// The mounting angle in 0.01 deg (2100h).
pub const MOUNTING: ParameterId = ParameterId(2);
const TPDO: ParameterId = ParameterId(3); // and the three that follow
const SLOPE: ValueId = ValueId(0);

/// The product: a sensor with one slope.
pub struct Mast;

impl Table for Mast {
    const PARAMETERS: &'static [Parameter] = plumbline::parameters![
        [profile::node_id(Self::NODE_ID, 20)],
        [profile::bit_rate(Self::BIT_RATE, 250)],
        [Parameter::new(MOUNTING, "Mounting angle", DataType::I16).in_unit("deg", 2)],
        profile::tpdo_communication(TPDO, 0x180),
    ];
    plumbline::project!(parameters);
}

/// The measurement: the slope from the acceleration, and the mounting angle.
pub struct Slope {
    inclinometer: Inclinometer,
    /// The mounting angle in 0.01 deg.
    mounting: i32,
    values: Published<1>,
}

impl Application for Slope {
    type Table = Mast;
    type Values = Published<1>;
    const QUANTITIES: &'static [Quantity] =
        &[Quantity::new(SLOPE, "Slope", DataType::I16).in_unit("deg", 2)];
    const INITIAL: Self = Self {
        inclinometer: Inclinometer::INITIAL,
        mounting: 0,
        values: Published::INITIAL,
    };

    fn start(&mut self, calibration: Calibration) {
        self.inclinometer.calibration = calibration;
    }

    fn apply(&mut self, _: Instant, parameters: &Parameters<Mast>) -> Published<1> {
        self.mounting = i32::from(parameters.get(MOUNTING) as i16);
        self.values
    }

    fn sample(&mut self, _: Instant, reading: &Reading) -> Published<1> {
        let angles = definition::perpendicular(self.inclinometer.sample(reading));
        let slope = angles.x.centidegrees() - self.mounting;
        self.values = Published::new([slope], Faults::NONE);
        self.values
    }

    fn stale(&mut self) -> Published<1> {
        self.values = Published::new(self.values.numbers, Faults::SENSOR);
        self.values
    }
}

impl Product for Mast {
    type Application = Slope;
    type Tpdos = TpdoArray<1, 1>;
    type History = ErrorHistory<4>;
    type Text = Text<32>;
    type Lss = Absent;
    type Block = Absent;
    type State = ();
    type Consumers = Absent;
    const OBJECTS: &'static [Object] = plumbline::objects![
        [profile::device_type(0x0001_019A), profile::error_register()],
        profile::error_history(4),
        [profile::text(0x1008, "Device name", "MAST")],
        profile::identity(0, 0, 0),
        profile::tpdo(0, "Slope", TPDO),
        profile::mapping::<2>(0, "Mapping", &[("Slope", 0x6010_0010)]),
        [Object::parameter(0x2000, 0, Self::NODE_ID)],
        [Object::parameter(0x2001, 0, Self::BIT_RATE)],
        [Object::parameter(0x2100, 0, MOUNTING)],
        [Object::value(0x6010, 0, SLOPE)],
    ];
    const NODE_ID: ParameterId = ParameterId(0);
    const BIT_RATE: ParameterId = ParameterId(1);
    const IMAGE: ImageId = ImageId::new(0x7001);
    plumbline::project!(objects);
}

/// The product as data, for programs on a PC.
pub const LISTING: listing::Product = listing::Product::canopen::<Mast>(
    "mast",
    "Example Works",
    Article {
        name: "MAST",
        number: "0001",
    },
)
.sold_by("Example Works")
.guided(&Guide {
    angles: &[SLOPE],
    ..Guide::NONE
});
