//! A sensor that is not in the catalogue and uses public items only: the requirements of CiA 301 for each CANopen device.

mod consumers;
mod dynamic;
mod groups;
mod product;
mod services;
mod types;
mod wide;

use crate::tester::Tester;
use plumbline::canopen::CanopenNode;
use plumbline::node::Boot;

type Stranger = CanopenNode<product::StrangerProduct>;

/// A sensor after power-up that has sent its boot-up message.
fn booted() -> Tester<Stranger> {
    let mut tester = Tester::power_up(Boot::default(), Stranger::new);
    tester.node_id = 30;
    assert_eq!(tester.sent_text(), ["71E#00"]);
    tester
}
