//! CANopen and SAE J1939 in one node.

use super::{ADDRESS, Mast, RATE, Slope};
use crate::tester::Tester;
use crate::tester::canopen::frame;
use plumbline::j1939::signal::Group;
use plumbline::j1939::{Product, Sent, Timer};
use plumbline::model::dual::DualNode;
use plumbline::node::Boot;
use plumbline::param::Setting;
use plumbline::prelude::*;

impl Product for Mast {
    type Application = Slope;
    type Timers = [Timer; 1];
    const SENT: &'static [Sent<Slope>] = &[Sent {
        pgn: 0xFF20,
        rate: Setting::Parameter(RATE),
        priority: Setting::Constant(6),
        data: |_| [0xD2, 0x04, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF],
    }];
    const GROUPS: &'static [Group] = &[Group::new("SLOPE", 0xFF20, &[])];
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
fn first_group_is_sent_one_period_after_the_address_claim() {
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
