//! Sizes follow from the dictionary: one TPDO sends one frame on SYNC, mapped objects have their lengths, and the ninth acceptance
//! filter of a node is there.

use crate::tester::Tester;
use crate::tester::canopen::frame;
use plumbline::canopen::{
    Absent, CanopenNode, ErrorHistory, Object, Product, Text, TpdoArray, profile,
};
use plumbline::node::ProductNode;
use plumbline::prelude::*;

const SLOPE: ValueId = ValueId(0);
const STATE: ValueId = ValueId(1);
const FINE_SLOPE: ValueId = ValueId(2);
const NODE_ID: ParameterId = ParameterId(0);
const BIT_RATE: ParameterId = ParameterId(1);

/// The values of a level sensor, of different types.
const VALUES: Published<3> = Published::new([-2, 0xA5, -0x0102_0304], Faults::NONE);

/// An application that publishes constants.
struct Level<T>(core::marker::PhantomData<T>);

impl<T: Table> Application for Level<T> {
    type Table = T;
    type Values = Published<3>;

    const QUANTITIES: &'static [Quantity] = &[
        Quantity::new(SLOPE, "Slope", DataType::I16),
        Quantity::new(STATE, "State", DataType::U8),
        Quantity::new(FINE_SLOPE, "Fine slope", DataType::I32),
    ];
    const INITIAL: Self = Self(core::marker::PhantomData);

    fn start(&mut self, _calibration: Calibration) {}

    fn apply(&mut self, _now: Instant, _parameters: &Parameters<T>) -> Published<3> {
        VALUES
    }

    fn sample(&mut self, _now: Instant, _reading: &Reading) -> Published<3> {
        VALUES
    }

    fn stale(&mut self) -> Published<3> {
        VALUES
    }
}

/// A product whose TPDOs have these numbers, with the mapping of each.
macro_rules! product {
    ($name:ident, $count:literal, [$($number:literal),*], $mapped:literal, $mapping:expr) => {
        struct $name;

        impl Table for $name {
            const PARAMETERS: &'static [Parameter] = plumbline::parameters![
                [profile::node_id(NODE_ID, 1), profile::bit_rate(BIT_RATE, 125)],
                $(profile::tpdo_communication(ParameterId(2 + 4 * $number), 0x180 + 0x80 * $number)),*
            ];
            plumbline::project!(parameters);
        }

        impl Product for $name {
            type Application = Level<Self>;
            type Tpdos = TpdoArray<$count, $mapped>;
            type History = ErrorHistory<1>;
            type Text = Text<0>;
            type Lss = Absent;
            type Consumers = Absent;
            type Block = Absent;
            type State = ();

            const OBJECTS: &'static [Object] = plumbline::objects![
                [profile::device_type(0), profile::error_register()],
                profile::error_history(1),
                profile::identity(0, 0, 0),
                $(profile::tpdo($number, "TPDO", ParameterId(2 + 4 * $number)),)*
                $(profile::mapping::<{ 1 + $mapped }>($number, "Mapping", $mapping),)*
                [
                    Object::value(0x6010, 0, SLOPE),
                    Object::value(0x6020, 0, STATE),
                    Object::value(0x6110, 0, FINE_SLOPE),
                ],
            ];
            const NODE_ID: ParameterId = NODE_ID;
            const BIT_RATE: ParameterId = BIT_RATE;
            const IMAGE: ImageId = ImageId::new(0x7003);
            plumbline::project!(objects);
        }
    };
}

product!(OneTpdo, 1, [0], 1, &[("Slope", 0x6010_0010)]);
product!(FiveTpdos, 5, [0, 1, 2, 3, 4], 1, &[("Slope", 0x6010_0010)]);
product!(
    ThreeMapped,
    1,
    [0],
    3,
    &[
        ("State", 0x6020_0008),
        ("Fine slope", 0x6110_0020),
        ("Slope", 0x6010_0010),
    ]
);

/// What a node in operational sends on SYNC.
fn sent_on_sync<P: Product>() -> Vec<String> {
    let mut tester = Tester::power_up(Boot::default(), CanopenNode::<P>::new);
    assert_eq!(tester.sent_text(), ["701#00"]);
    tester.send("000#0101");
    assert_eq!(tester.sent_text(), [""; 0]);
    tester.exchange("080#")
}

#[test]
fn one_tpdo_sends_one_frame_on_sync() {
    assert_eq!(sent_on_sync::<OneTpdo>(), ["181#FEFF"]);
}

#[test]
fn mapped_objects_follow_each_other_with_their_lengths() {
    assert_eq!(sent_on_sync::<ThreeMapped>(), ["181#A5FCFCFDFEFEFF"]);
}

#[test]
fn five_tpdos_send_five_frames_on_sync_and_have_nine_filters() {
    let expected: Vec<String> = (0..5)
        .map(|number| format!("{:03X}#FEFF", 0x181 + 0x80 * number))
        .collect();
    assert_eq!(sent_on_sync::<FiveTpdos>(), expected);

    let tester = Tester::power_up(Boot::default(), CanopenNode::<FiveTpdos>::new);
    let mut count = 0;
    tester.node.filters(&mut |_| count += 1);
    assert_eq!((count, CanopenNode::<FiveTpdos>::FILTERS), (9, 9));
    let requests = ["000#0101", "080#", "601#40", "701#R"].map(str::to_string);
    let remote = expected.iter().map(|text| text.replace("#FEFF", "#R"));
    for text in requests.into_iter().chain(remote) {
        assert!(tester.accepts(frame(&text).id()), "{text}");
    }
}
