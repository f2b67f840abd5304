//! A program that checks the gyroscope and the measurement of the supply on a board. It is no product: node-ID 1, 250 kbit/s, and one
//! TPDO (181h), which a SYNC requests:
//!
//! ```text
//! byte 0             4                  6                 8
//!      +-------------+------------------+-----------------+
//!      | rotation    | angular rate     | supply          |
//!      | i32         | i16              | u16             |
//!      | 0.001 deg   | 0.1 deg/s        | 0.01 V          |
//!      +-------------+------------------+-----------------+
//! ```
//!
//! Rotation and angular rate are those about X. The rotation is the sum of the rates since the start.
#![cfg_attr(target_os = "none", no_std, no_main)]

use plumbline::canopen::{
    Absent, CanopenNode, ErrorHistory, Object, Product, Text, TpdoArray, profile,
};
use plumbline::prelude::*;

const TPDO: ParameterId = ParameterId(2); // and the three that follow
const ROTATION: ValueId = ValueId(0);
const RATE: ValueId = ValueId(1);
const SUPPLY: ValueId = ValueId(2);

/// A product that publishes what the accelerometer measures.
struct Sensing;

impl Table for Sensing {
    const PARAMETERS: &'static [Parameter] = plumbline::parameters![
        [profile::node_id(Self::NODE_ID, 1)],
        [profile::bit_rate(Self::BIT_RATE, 250)],
        profile::tpdo_communication(TPDO, 0x180),
    ];
    plumbline::project!(parameters);
}

/// The sum of the rates since the start, the present rate and the supply.
struct Motion {
    /// The sum of the rates in 2^-16 deg/s.
    sum: i64,
    values: Published<3>,
}

impl Application for Motion {
    type Table = Sensing;
    type Values = Published<3>;
    const QUANTITIES: &'static [Quantity] = &[
        Quantity::new(ROTATION, "Rotation", DataType::I32).in_unit("deg", 3),
        Quantity::new(RATE, "Rate", DataType::I16).in_unit("deg/s", 1),
        Quantity::new(SUPPLY, "Supply", DataType::U16).in_unit("V", 2),
    ];
    const MEASURES_SUPPLY: bool = true;
    const HAS_GYROSCOPE: bool = true;
    const INITIAL: Self = Self {
        sum: 0,
        values: Published::INITIAL,
    };

    fn start(&mut self, _: Calibration) {}

    fn apply(&mut self, _: Instant, _: &Parameters<Sensing>) -> Published<3> {
        self.values
    }

    fn sample(&mut self, _: Instant, reading: &Reading) -> Published<3> {
        let rate = i64::from(reading.angular_rate.x);
        self.sum = self.sum.wrapping_add(rate);
        // A sample is 5 ms.
        let rotation = (self.sum.wrapping_mul(5) >> 16) as i32;
        let [.., supply] = self.values.numbers;
        let rate = (rate.wrapping_mul(10) >> 16) as i32;
        self.values = Published::new([rotation, rate, supply], Faults::NONE);
        self.values
    }

    fn stale(&mut self) -> Published<3> {
        self.values = Published::new(self.values.numbers, Faults::SENSOR);
        self.values
    }

    fn supply(&mut self, millivolts: u16) -> Option<Published<3>> {
        let [rotation, rate, before] = self.values.numbers;
        let supply = i32::from(millivolts / 10);
        self.values = Published::new([rotation, rate, supply], self.values.faults);
        (supply != before).then_some(self.values)
    }
}

impl Product for Sensing {
    type Application = Motion;
    type Tpdos = TpdoArray<1, 3>;
    type History = ErrorHistory<4>;
    type Text = Text<0>;
    type Lss = Absent;
    type Consumers = Absent;
    type Block = Absent;
    type State = ();
    const OBJECTS: &'static [Object] = plumbline::objects![
        [profile::device_type(0), profile::error_register()],
        profile::error_history(4),
        profile::identity(0, 0, 0),
        profile::tpdo(0, "Measured", TPDO),
        profile::mapping::<4>(
            0,
            "Mapping",
            &[
                ("Rotation", 0x2100_0020),
                ("Rate", 0x2101_0010),
                ("Supply", 0x2102_0010)
            ]
        ),
        [Object::value(0x2100, 0, ROTATION)],
        [Object::value(0x2101, 0, RATE)],
        [Object::value(0x2102, 0, SUPPLY)],
    ];
    const NODE_ID: ParameterId = ParameterId(0);
    const BIT_RATE: ParameterId = ParameterId(1);
    const IMAGE: ImageId = ImageId::new(0x7F01);
    plumbline::project!(objects);
}

firmware_stm32::firmware!(CanopenNode<Sensing>, "sensing", Sensing::IMAGE);
