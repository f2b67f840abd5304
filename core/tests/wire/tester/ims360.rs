//! Helpers for tests of the IMS360.

use super::Tester;
use plumbline::model::ims360::Ims360;
use plumbline::node::Boot;

/// An IMS360 with its bus and its memory.
pub type Ims360Tester = Tester<Ims360>;

/// A sensor after power-up with these stored parameters.
pub fn with_memory(parameters: Option<&[u8]>) -> Ims360Tester {
    let loaded = Boot {
        parameters,
        ..Boot::default()
    };
    let mut tester = Tester::power_up(loaded, Ims360::new);
    tester.node_id = 50;
    tester
}

/// A sensor with factory values that has sent its boot-up message.
pub fn booted() -> Ims360Tester {
    let mut tester = with_memory(None);
    assert_eq!(tester.sent_text(), ["732#00"]);
    tester
}
