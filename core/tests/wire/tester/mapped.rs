//! A product with four TPDOs, a dynamic mapping and free COB-IDs, which all follow CiA 301. Node-ID 50.
//!
//! | object  | contents                                   | type | mappable |
//! |---------|--------------------------------------------|------|----------|
//! | 3000h   | status: 04h + 80h while 3100h is not 0     | U8   | yes      |
//! | 3010h:n | X, Y, Z of the specific force in 0.001 g   | I16  | 1 and 2  |
//! | 3100h   | a parameter                                | U8   | yes      |
//! | 3101h   | a parameter                                | U8   | no       |
//! | 6110h   | X in 0.000001 g                            | I32  | yes      |

use super::Tester;
use plumbline::canopen::dictionary::{Access, Service};
use plumbline::canopen::nmt::State;
use plumbline::canopen::{
    Absent, CanopenNode, DynamicTpdos, ErrorHistory, Object, Own, Product, Text, Triggers, profile,
};
use plumbline::measure::ONE_G;
use plumbline::node::{Boot, Context};
use plumbline::prelude::*;

const MILLI: [ValueId; 3] = [ValueId(0), ValueId(1), ValueId(2)];
const MICRO: ValueId = ValueId(3);

mod id {
    use plumbline::param::ParameterId;

    pub const NODE_ID: ParameterId = ParameterId(0);
    pub const BIT_RATE: ParameterId = ParameterId(1);
    pub const SYNC: ParameterId = ParameterId(2);
    pub const EMCY: ParameterId = ParameterId(3);
    pub const TPDO: [ParameterId; 4] = ids([4, 8, 12, 16]);
    pub const MAPPING: [ParameterId; 4] = ids([20, 29, 38, 47]);
    pub const NUMBER: ParameterId = ParameterId(56);
    pub const HIDDEN: ParameterId = ParameterId(57);

    const fn ids([a, b, c, d]: [u8; 4]) -> [ParameterId; 4] {
        [
            ParameterId(a),
            ParameterId(b),
            ParameterId(c),
            ParameterId(d),
        ]
    }
}

pub struct Mapped;

impl Table for Mapped {
    const PARAMETERS: &'static [Parameter] = plumbline::parameters![
        [
            profile::node_id(id::NODE_ID, 50),
            profile::bit_rate(id::BIT_RATE, 125),
            profile::sync_cob_id(id::SYNC),
            Parameter {
                persistence: plumbline::param::Persistence::OnSave,
                ..profile::emcy_cob_id(id::EMCY)
            },
        ],
        profile::stored_tpdo_communication(id::TPDO[0], 0x180),
        profile::stored_tpdo_communication(id::TPDO[1], 0x8000_0280),
        profile::stored_tpdo_communication(id::TPDO[2], 0x8000_0380),
        profile::stored_tpdo_communication(id::TPDO[3], 0x8000_0480),
        profile::mapping_parameters(id::MAPPING[0], &[0x3010_0110, 0x3010_0210]),
        profile::mapping_parameters(id::MAPPING[1], &[]),
        profile::mapping_parameters(id::MAPPING[2], &[]),
        profile::mapping_parameters(id::MAPPING[3], &[]),
        [
            Parameter::new(id::NUMBER, "Number", DataType::U8),
            Parameter::new(id::HIDDEN, "Hidden", DataType::U8),
        ],
    ];
    plumbline::project!(parameters);
}

pub struct Force(Published<4>);

impl Application for Force {
    type Table = Mapped;
    type Values = Published<4>;
    const QUANTITIES: &'static [Quantity] = &[
        Quantity::new(MILLI[0], "X", DataType::I16),
        Quantity::new(MILLI[1], "Y", DataType::I16),
        Quantity::new(MILLI[2], "Z", DataType::I16),
        Quantity::new(MICRO, "Fine X", DataType::I32),
    ];
    const INITIAL: Self = Self(Published::INITIAL);
    fn start(&mut self, _: Calibration) {}
    fn apply(&mut self, _: Instant, _: &Parameters<Mapped>) -> Published<4> {
        self.0
    }
    fn sample(&mut self, _: Instant, reading: &Reading) -> Published<4> {
        let scaled =
            |force: i32, unit: i64| (i64::from(force) * unit).div_euclid(i64::from(ONE_G)) as i32;
        let force = reading.acceleration;
        let [x, y, z] = [force.x, force.y, force.z].map(|force| scaled(force, 1000));
        self.0 = Published::new([x, y, z, scaled(force.x, 1_000_000)], Faults::NONE);
        self.0
    }
    fn stale(&mut self) -> Published<4> {
        Published::new(self.0.numbers, Faults::SENSOR)
    }
}

impl Product for Mapped {
    type Application = Force;
    type Tpdos = DynamicTpdos<4, 8>;
    type History = ErrorHistory<4>;
    type Text = Text<0>;
    type Lss = Absent;
    type Consumers = Absent;
    type Block = Absent;
    type State = ();
    const TRIGGERS: Triggers = Triggers {
        changes: true,
        restarts_timer: true,
    };
    const OBJECTS: &'static [Object] = plumbline::objects![
        [profile::device_type(0x0001_019A), profile::error_register()],
        profile::error_history(4),
        [
            Object::parameter(0x1005, 0, id::SYNC),
            profile::highest(0x1010, "Store", DataType::U8, 1),
            profile::service(
                0x1010,
                1,
                "Store all",
                DataType::U32,
                Access::Rw,
                Service::Store
            ),
            profile::free_cob_id(0x1014, 0, id::EMCY),
        ],
        profile::identity(0, 0, 0),
        profile::free_tpdo(0, "TPDO 1", id::TPDO[0]),
        profile::free_tpdo(1, "TPDO 2", id::TPDO[1]),
        profile::free_tpdo(2, "TPDO 3", id::TPDO[2]),
        profile::free_tpdo(3, "TPDO 4", id::TPDO[3]),
        profile::dynamic_mapping(0, "Mapping 1", id::MAPPING[0]),
        profile::dynamic_mapping(1, "Mapping 2", id::MAPPING[1]),
        profile::dynamic_mapping(2, "Mapping 3", id::MAPPING[2]),
        profile::dynamic_mapping(3, "Mapping 4", id::MAPPING[3]),
        [
            Object::parameter(0x2000, 0, id::NODE_ID),
            Object::parameter(0x2001, 0, id::BIT_RATE),
            Object {
                mappable: true,
                ..Object::own(0x3000, 0, "Status", DataType::U8, Access::Ro)
            },
            profile::highest(0x3010, "Acceleration", DataType::U8, 3),
            Object::value(0x3010, 1, MILLI[0]),
            Object::value(0x3010, 2, MILLI[1]),
            profile::read_only(0x3010, 3, MILLI[2]),
            Object {
                mappable: true,
                ..Object::parameter(0x3100, 0, id::NUMBER)
            },
            Object::parameter(0x3101, 0, id::HIDDEN),
            Object::value(0x6110, 0, MICRO),
        ],
    ];
    const NODE_ID: ParameterId = id::NODE_ID;
    const BIT_RATE: ParameterId = id::BIT_RATE;
    const OWN: &'static [Own<Self>] = &[Own::number(0x3000, 0, status)];
    const IMAGE: ImageId = ImageId::new(0x7002);
    plumbline::project!(objects);

    fn is_writable(index: u16, state: State) -> bool {
        !matches!(index, 0x1005 | 0x1014) || state == State::PreOperational
    }
}

/// The status (3000h).
fn status(_: &(), node: &Context<Force>) -> u32 {
    if node.parameters.get(id::NUMBER) == 0 {
        0x04
    } else {
        0x84
    }
}

/// A node of this product under test.
pub type MappedTester = Tester<CanopenNode<Mapped>>;

/// A node with these contents of the memory that has sent its boot-up message.
pub fn booted_with(memory: Option<&[u8]>) -> MappedTester {
    let loaded = Boot {
        parameters: memory,
        ..Boot::default()
    };
    let mut tester = Tester::power_up(loaded, CanopenNode::<Mapped>::new);
    tester.node_id = 50;
    tester
}

/// A node with factory values that has sent its boot-up message.
pub fn mapped() -> MappedTester {
    let mut tester = booted_with(None);
    assert_eq!(tester.sent_text(), ["732#00"]);
    tester
}

impl MappedTester {
    /// Hands in samples of this specific force in 0.001 g.
    pub fn push(&mut self, [x, y, z]: [i32; 3]) {
        let in_units = |milli: i32| {
            let units = i64::from(milli) * i64::from(ONE_G);
            units.div_euclid(1000) as i32 + 1
        };
        self.hold([in_units(x), in_units(y), in_units(z)], 1);
    }
}
