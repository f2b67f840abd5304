//! A CANopen sensor of your own, outside of Plumbline: one slope, one TPDO, and an object of the maker, 2100h, the mounting angle.
//! Run it with `cargo run -p core --example new_canopen_model`.

use plumbline::canopen::{CanopenNode, ErrorHistory, Object, Product, Text, TpdoArray, profile};
use plumbline::prelude::*;

plumbline::ids! { ParameterId: NODE_ID, BIT_RATE, MOUNTING, TPDO(4) }
plumbline::ids! { ValueId: SLOPE }

struct Mast;
impl Table for Mast {
    const PARAMETERS: &'static [Parameter] = plumbline::parameters![
        [profile::node_id(NODE_ID, 20)],
        [profile::bit_rate(BIT_RATE, 250)],
        [Parameter::new(MOUNTING, "Mounting angle", DataType::I16).in_unit("deg", 2)],
        profile::tpdo_communication(TPDO, 0x180),
    ];
    plumbline::project!(parameters);
}

/// Calibration and low-pass, the mounting angle in 0.01 deg, the last values.
struct Slope(Inclinometer, i32, Published<1>);
impl Application for Slope {
    type Table = Mast;
    type Values = Published<1>;
    const QUANTITIES: &'static [Quantity] =
        &[Quantity::new(SLOPE, "Slope", DataType::I16).in_unit("deg", 2)];
    const INITIAL: Self = Self(Inclinometer::INITIAL, 0, Published::INITIAL);
    fn start(&mut self, calibration: Calibration) {
        self.0.calibration = calibration;
    }
    fn apply(&mut self, _: Instant, parameters: &Parameters<Mast>) -> Published<1> {
        self.1 = i32::from(parameters.get(MOUNTING) as i16);
        self.2
    }
    fn sample(&mut self, _: Instant, reading: &Reading) -> Published<1> {
        let angles = definition::perpendicular(self.0.sample(reading));
        self.2 = Published::new([angles.x.centidegrees() - self.1], Faults::NONE);
        self.2
    }
    fn stale(&mut self) -> Published<1> {
        Published::new(self.2.numbers, Faults::SENSOR)
    }
}

impl Product for Mast {
    type Application = Slope;
    type Tpdos = TpdoArray<1, 1>;
    type History = ErrorHistory<4>;
    type Text = Text<0>;
    type Lss = plumbline::canopen::Absent;
    type Consumers = plumbline::canopen::Absent;
    type Block = plumbline::canopen::Absent;
    type State = ();
    const OBJECTS: &'static [Object] = plumbline::objects![
        [profile::device_type(0x0001_019A), profile::error_register()],
        profile::error_history(4),
        profile::identity(0, 0, 0),
        profile::tpdo(0, "Slope", TPDO),
        profile::mapping::<2>(0, "Mapping", &[("Slope", 0x6010_0010)]),
        [Object::parameter(0x2000, 0, NODE_ID)],
        [Object::parameter(0x2100, 0, MOUNTING)],
        [Object::value(0x6010, 0, SLOPE)],
    ];
    const NODE_ID: ParameterId = NODE_ID;
    const BIT_RATE: ParameterId = BIT_RATE;
    const IMAGE: ImageId = ImageId::new(0x7001);
    plumbline::project!(objects);
}

fn main() {
    let now = Instant::from_ticks(0);
    let mut sensor = CanopenNode::<Mast>::new(now, &Boot::default());
    let write = &[0x2B, 0x00, 0x21, 0x00, 0x0C, 0xFE, 0, 0][..]; // -5.00 deg into 2100h by SDO
    for (id, data) in [(0x000, &[1, 20][..]), (0x614, write), (0x080, &[])] {
        sensor.sample(now, &Reading::default());
        sensor.receive(now, &Frame::data(standard(id), data).expect("a frame"));
        while sensor.poll(now).is_some() {}
        std::iter::from_fn(|| sensor.transmit(now)).for_each(|frame| println!("{frame:?}"));
    }
}
