//! A product of another crate with CANopen and J1939: 2002h selects one of them, and 2003h restarts.

use crate::tester::Tester;
use crate::tester::canopen::frame;
use plumbline::canopen::dictionary::{Access, Service};
use plumbline::canopen::{
    self, Abort, Absent, ErrorHistory, Object, Own, Scope, Text, Then, TpdoArray, profile,
};
use plumbline::j1939::signal::Group;
use plumbline::j1939::{self, Sent, Timer};
use plumbline::model::dual::DualNode;
use plumbline::node::Boot;
use plumbline::param::Setting;
use plumbline::prelude::*;

plumbline::ids! { ParameterId: NODE_ID, BIT_RATE, SELECTOR, ADDRESS, RATE, TPDO(4) }

const SLOPE: ValueId = ValueId(0);

struct Mast;

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
struct Slope;

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

impl canopen::Product for Mast {
    type Application = Slope;
    type Tpdos = TpdoArray<1, 1>;
    type History = ErrorHistory<2>;
    type Text = Text<0>;
    type Lss = Absent;
    type State = ();
    type Consumers = Absent;
    type Block = Absent;
    const OBJECTS: &'static [Object] = plumbline::objects![
        [profile::device_type(0), profile::ERROR_REGISTER],
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

impl j1939::Product for Mast {
    type Application = Slope;
    type Timers = [Timer; 1];
    const SENT: &'static [Sent<Slope>] = &[Sent {
        pgn: 0xFF20,
        rate: Setting::Parameter(RATE),
        priority: Setting::Constant(6),
        data: |_| [0xD2, 0x04, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF],
    }];
    const GROUPS: &'static [Group] = &[Group {
        name: "SLOPE",
        pgn: 0xFF20,
        signals: &[],
    }];
    const ADDRESS: ParameterId = ADDRESS;
    const NAME: [Setting; 8] = [Setting::Constant(0); 8];
    const MAKE: &'static str = "Own";
    const MODEL: &'static str = "Mast";
    const VERSION: &'static str = "1.0";
    const TYPE: &'static str = "Slope";
    const IMAGE: ImageId = ImageId::new(0x7012);
    plumbline::project!(groups);
}

#[test]
fn groups_are_sent_after_the_restart_that_selects_j1939_the_claim_and_a_period() {
    let mut t = Tester::power_up(Boot::default(), DualNode::<Mast>::new);
    assert_eq!(t.sent_text(), ["714#00"]);
    for text in ["614#2F02200001000000", "614#2310100173617665"] {
        t.receive(frame(text));
        t.wait(50);
    }
    t.receive(frame("614#2F03200001000000"));
    let frames = t.wait(600);
    let start = frames[0].0;
    let timed = frames
        .iter()
        .map(|(time, frame)| (time - start, format!("{frame:?}")));
    let expected = [
        (0, "594#6003200000000000"),
        (100, "18EEFF90#0102030000000000"),
        (350, "18FECA90#00FF00000000FFFF"),
        (450, "18FF2090#D204FFFFFFFFFFFF"),
        (550, "18FF2090#D204FFFFFFFFFFFF"),
    ];
    assert_eq!(
        timed.collect::<Vec<_>>(),
        expected.map(|(time, text)| (time, text.to_string()))
    );
}
