//! Sizes follow from the dictionary: one TPDO sends one frame on SYNC, and the ninth acceptance filter of a node is there.

use crate::tester::Tester;
use crate::tester::canopen::frame;
use plumbline::canopen::{CanopenNode, ErrorHistory, Object, Product, Text, TpdoArray, profile};
use plumbline::prelude::*;

const SLOPE: ValueId = ValueId(0);
const NODE_ID: ParameterId = ParameterId(0);
const BIT_RATE: ParameterId = ParameterId(1);

/// Publishes nothing but zeros.
struct Level<T>(core::marker::PhantomData<T>);

impl<T: Table> Application for Level<T> {
    type Table = T;
    type Values = Published<1>;

    const QUANTITIES: &'static [Quantity] = &[Quantity::new(SLOPE, "Slope", DataType::I16)];
    const INITIAL: Self = Self(core::marker::PhantomData);

    fn start(&mut self, _calibration: Calibration) {}

    fn apply(&mut self, _now: Instant, _parameters: &Parameters<T>) -> Published<1> {
        Published::INITIAL
    }

    fn sample(&mut self, _now: Instant, _reading: &Reading) -> Published<1> {
        Published::INITIAL
    }

    fn stale(&mut self) -> Published<1> {
        Published::INITIAL
    }
}

/// A product whose TPDOs have these numbers.
macro_rules! product {
    ($name:ident, $count:literal, [$($number:literal),*]) => {
        struct $name;

        impl Table for $name {
            const PARAMETERS: &'static [Parameter] = plumbline::parameters![
                [profile::node_id(NODE_ID, 1), profile::bit_rate(BIT_RATE, 125)],
                $(profile::tpdo_communication(ParameterId(2 + 4 * $number), 0x180 + 0x10 * $number)),*
            ];
            plumbline::project_parameters!();
        }

        impl Product for $name {
            type Application = Level<Self>;
            type Tpdos = TpdoArray<$count, 1>;
            type History = ErrorHistory<1>;
            type Text = Text<0>;

            const OBJECTS: &'static [Object] = plumbline::objects![
                profile::error_history(1),
                $(profile::tpdo($number, "TPDO", ParameterId(2 + 4 * $number)),)*
                $(profile::mapping::<2>($number, "Mapping", &[("Slope", 0x6010_0010)]),)*
                [Object::value(0x6010, 0, SLOPE)],
            ];
            const NODE_ID: ParameterId = NODE_ID;
            const BIT_RATE: ParameterId = BIT_RATE;
            const IMAGE: ImageId = ImageId::new(0x7003);
            plumbline::project_objects!();
        }
    };
}

product!(OneTpdo, 1, [0]);
product!(FiveTpdos, 5, [0, 1, 2, 3, 4]);

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
    assert_eq!(sent_on_sync::<OneTpdo>(), ["181#0000"]);
}

#[test]
fn five_tpdos_send_five_frames_on_sync_and_have_nine_filters() {
    let expected: Vec<String> = (0..5)
        .map(|number| format!("{:03X}#0000", 0x181 + 0x10 * number))
        .collect();
    assert_eq!(sent_on_sync::<FiveTpdos>(), expected);

    let tester = Tester::power_up(Boot::default(), CanopenNode::<FiveTpdos>::new);
    let mut count = 0;
    tester.node.filters(&mut |_| count += 1);
    assert_eq!((count, CanopenNode::<FiveTpdos>::FILTERS), (9, 9));
    let requests = ["000#0101", "080#", "601#40", "701#R"].map(str::to_string);
    let remote = expected.iter().map(|text| text.replace("#0000", "#R"));
    for text in requests.into_iter().chain(remote) {
        assert!(tester.accepts(frame(&text).id()), "{text}");
    }
}
