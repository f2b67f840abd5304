//! J1939 without CANopen: a sensor with a group of its own, messages of its own and constants in its NAME.
//!
//! | Proprietary A      | answer             | meaning                                     |
//! |--------------------|--------------------|---------------------------------------------|
//! | 01 low high        | 01 00; 01 01       | sets the zero point; the value is refused    |
//! | 02                 | 02 00; 02 01; none | saves; the save has failed; a save is running |

use crate::tester::Tester;
use plumbline::can::BitRate;
use plumbline::j1939::diagnostics::Trouble;
use plumbline::j1939::signal::{Contents, Group, Signal};
use plumbline::j1939::{Conditions, J1939Node, Product, Sent, Timer, name};
use plumbline::measure::ONE_G;
use plumbline::node::{Action, Boot, BusEvent, BusMode, BusState, Context};
use plumbline::param::{Persistence, Setting};
use plumbline::prelude::*;

const ADDRESS: ParameterId = ParameterId(0);
const RATE: ParameterId = ParameterId(1);
const ZERO: ParameterId = ParameterId(2);
const SLOPE: ValueId = ValueId(0);

/// The group with the slope, Proprietary B.
const PGN: u32 = 0x0FF20;

struct Mast;

impl Table for Mast {
    const PARAMETERS: &'static [Parameter] = &[
        Parameter::new(ADDRESS, "Address", DataType::U8).within(0, 253, 0x90),
        Parameter::new(RATE, "Rate", DataType::U16).within(0, 1000, 100),
        Parameter {
            persistence: Persistence::OnSave,
            ..Parameter::new(ZERO, "Zero", DataType::I16).within(-500, 500, 0)
        },
    ];
    plumbline::project!(parameters);
}

/// The specific force along X in 0.001 g, and the zero point.
struct Slope(i32, i32);

impl Slope {
    fn values(&self, faults: Faults) -> Published<1> {
        Published::new([self.0 + self.1], faults)
    }
}

impl Application for Slope {
    type Table = Mast;
    type Values = Published<1>;
    const QUANTITIES: &'static [Quantity] = &[Quantity::new(SLOPE, "Slope", DataType::I16)];
    const INITIAL: Self = Self(0, 0);
    fn start(&mut self, _: Calibration) {}
    fn apply(&mut self, _: Instant, parameters: &Parameters<Mast>) -> Published<1> {
        self.1 = i32::from(parameters.get(ZERO) as i16);
        self.values(Faults::NONE)
    }
    fn sample(&mut self, _: Instant, reading: &Reading) -> Published<1> {
        let milli = i64::from(reading.acceleration.x) * 1000 / i64::from(ONE_G);
        self.0 = milli as i32;
        self.values(Faults::NONE)
    }
    fn stale(&mut self) -> Published<1> {
        self.values(Faults::SENSOR)
    }
}

impl Product for Mast {
    type Application = Slope;
    type Timers = [Timer; 1];
    const SENT: &'static [Sent<Slope>] = &[Sent {
        pgn: PGN,
        rate: Setting::Parameter(RATE),
        priority: Setting::Constant(5),
        data: slope,
    }];
    const GROUPS: &'static [Group] = &[Group::new(
        "SLOPE",
        PGN,
        &[Signal::new(
            "Slope",
            0,
            0,
            16,
            Contents::Own {
                resolution: (1, 1000),
                offset: 0,
                unit: "g",
            },
        )],
    )];
    const ADDRESS: ParameterId = ADDRESS;
    const NAME: [Setting; 8] = name::constants([0, 2, 0, 0, 145, 0, 0, 2047]);
    const MAKE: &'static str = "Own";
    const MODEL: &'static str = "Mast";
    const VERSION: &'static str = "1.0";
    const TYPE: &'static str = "Slope";
    const TROUBLES: &'static [Trouble] = &[
        Trouble::new(3318, 12),
        Trouble::new(630, 12),
        Trouble::new(639, 2),
    ];
    const IMAGE: ImageId = ImageId::new(0x7006);
    plumbline::project!(groups);

    fn active(node: &Context<Slope>, conditions: Conditions) -> u16 {
        u16::from(node.values.faults().intersects(Faults::SENSOR))
            | u16::from(conditions.memory) << 1
            | u16::from(conditions.network) << 2
    }

    fn proprietary(node: &mut Context<Slope>, message: [u8; 8]) -> Option<[u8; 8]> {
        let [command, low, high, ..] = message;
        match command {
            1 => {
                let written = node.write(ZERO, u16::from_le_bytes([low, high]).into());
                node.apply();
                Some([1, written.is_err().into(), 0, 0, 0, 0, 0, 0])
            }
            2 if !node.is_saving() => {
                node.save(node.parameters);
                None
            }
            _ => None,
        }
    }

    fn stored(_: &mut Context<Slope>, succeeded: bool) -> Option<[u8; 8]> {
        Some([2, (!succeeded).into(), 0, 0, 0, 0, 0, 0])
    }
}

/// The data of the group: the slope in the first two bytes.
fn slope(node: &Context<Slope>) -> [u8; 8] {
    let [low, high] = (node.values.number(SLOPE) as u16).to_le_bytes();
    [low, high, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF]
}

/// A sensor that has claimed its address, 100 ms before the first group.
fn claimed() -> Tester<J1939Node<Mast>> {
    let mut tester = Tester::power_up(Boot::default(), J1939Node::<Mast>::new);
    assert_eq!(tester.sent_text(), ["18EEFF90#0102E3FF00910020"]);
    let online = Action::Bus(BusMode::Normal, BitRate::K250);
    assert!(tester.actions.contains(&online));
    let sent = tester.wait_text(250);
    assert_eq!(sent, [(250, "18FECA90#00FF00000000FFFF".into())], "DM1");
    tester
}

#[test]
fn own_group_is_sent_at_its_rate_and_on_request() {
    let mut tester = claimed();
    tester.hold([ONE_G / 2, 0, 0], 1);
    let group = "14FF2090#F401FFFFFFFFFFFF";
    assert_eq!(tester.wait_text(100), [(100, group.into())]);
    assert_eq!(tester.exchange("18EA9021#20FF00"), [group]);
    // Another group is refused.
    let refused = "18E8FF90#01FFFFFF2109F000";
    assert_eq!(tester.exchange("18EA9021#09F000"), [refused]);
}

#[test]
fn own_message_writes_a_parameter_and_saves_it() {
    let mut tester = claimed();
    let answer = "18EF2190#0100000000000000";
    assert_eq!(tester.exchange("18EF9021#0114000000000000"), [answer]);
    assert_eq!(
        tester.exchange("18EA9021#20FF00"),
        ["14FF2090#1400FFFFFFFFFFFF"]
    );
    let refused = "18EF2190#0101000000000000";
    assert_eq!(tester.exchange("18EF9021#01F5010000000000"), [refused]);
    tester.memory_works = None;
    assert_eq!(tester.exchange("18EF9021#0200000000000000"), [""; 0]);
    // The save answers the node that has begun it.
    assert_eq!(tester.exchange("18EF9022#0200000000000000"), [""; 0]);
    tester.finish_save(Ok(()));
    assert_eq!(tester.sent_text(), ["18EF2190#0200000000000000"]);
    tester.memory_works = Some(true);
    assert_eq!(
        tester.exchange("18EF9022#0200000000000000"),
        ["18EF2290#0200000000000000"]
    );
    tester.power_cycle();
    tester.wait(250);
    assert_eq!(
        tester.exchange("18EA9021#20FF00"),
        ["14FF2090#1400FFFFFFFFFFFF"]
    );
}

#[test]
fn faults_of_the_node_are_active_codes() {
    let mut tester = claimed();
    // The shortest time between two messages with codes.
    tester.wait(50);
    tester.memory_works = Some(false);
    tester.receive(crate::tester::canopen::frame("18EF9021#0200000000000000"));
    let answer = "18EF2190#0201000000000000";
    let memory = "18FECA90#04FF76020C01FFFF";
    assert_eq!(tester.sent_text(), [answer, memory]);
    tester.bus(BusEvent::State(BusState::Passive));
    let sent = tester.wait_text(60);
    // A message with two codes has ten bytes.
    let announced = "1CECFF90#200A0002FFCAFE00".to_string();
    assert!(
        sent.iter().any(|(_, frame)| *frame == announced),
        "{sent:?}"
    );
}

#[test]
fn identification_has_the_texts_of_the_product() {
    let mut tester = claimed();
    // 01h, "1.0*", filled.
    assert_eq!(
        tester.exchange("18EA9021#DAFE00"),
        ["18FEDA90#01312E302AFFFFFF"]
    );
}
