//! The addresses that the data sheet does not have. The node gets the requests without a wire, because there are some 150,000.

use super::sdo::{JN2101, NO_OBJECT, NO_SUB_INDEX};
use super::sheet::Sheet;
use bench::NodeType;
use bench::script::LEVEL;
use plumbline::can::{Frame, standard};
use plumbline::diagnosis::{LAST, OBJECT};
use plumbline::node::{Boot, Node};
use plumbline::time::Instant;
use std::collections::BTreeSet;

/// The time stands still.
const NOW: Instant = Instant::from_ticks(0);

/// The node of a JN2101 after its first reading.
struct Jn2101(Box<dyn Node>);

impl Jn2101 {
    fn new() -> Self {
        let node_type = NodeType::find(JN2101.product).expect("a product");
        let mut node = node_type.start(NOW, &Boot::default());
        node.sample(NOW, &LEVEL);
        let mut own = Self(node);
        let boot_up = own.sent();
        assert_eq!(boot_up.id(), standard(0x70A));
        own
    }

    /// The next frame that it sends.
    fn sent(&mut self) -> Frame {
        while self.0.poll(NOW).is_some() {}
        let frame = self.0.transmit(NOW).expect("a frame");
        self.0.sent(NOW);
        frame
    }

    /// The reply to an SDO request.
    fn reply(&mut self, command: u8, (index, sub): (u16, u8)) -> [u8; 8] {
        let [low, high] = index.to_le_bytes();
        let request = [command, low, high, sub, 0, 0, 0, 0];
        let request = Frame::data(standard(0x60A), &request).expect("eight bytes");
        self.0.receive(NOW, &request);
        let reply = self.sent();
        assert_eq!(reply.id(), standard(0x58A));
        reply.bytes().try_into().expect("eight bytes")
    }

    /// The abort code of an SDO request.
    fn abort(&mut self, command: u8, (index, sub): (u16, u8)) -> u32 {
        match self.reply(command, (index, sub)) {
            [0x80, _, _, _, a, b, c, d] => u32::from_le_bytes([a, b, c, d]),
            reply => panic!("{index:04X}h:{sub:02X}: {reply:02X?}"),
        }
    }
}

/// The object of the diagnostic data. The original does not have it, so no data sheet has it. Each higher sub-index is refused.
#[test]
fn object_of_the_diagnosis_is_in_the_sensor_and_not_in_the_data_sheet() {
    let sheet = Sheet::parse(&super::text());
    assert!(!sheet.indices().contains(&OBJECT));
    let mut node = Jn2101::new();
    for sub in 0..=LAST {
        let reply = node.reply(0x40, (OBJECT, sub));
        assert!(matches!(reply[0], 0x43 | 0x4F), "{sub}: {reply:02X?}");
    }
    for sub in LAST + 1..=u8::MAX {
        assert_eq!(node.abort(0x40, (OBJECT, sub)), NO_SUB_INDEX, "{sub:02X}h");
        assert_eq!(node.abort(0x2F, (OBJECT, sub)), NO_SUB_INDEX, "{sub:02X}h");
    }
}

#[test]
fn sensor_has_no_other_objects() {
    let sheet = Sheet::parse(&super::text());
    let variables = sheet.variables().into_iter();
    let described: BTreeSet<_> = variables.map(|variable| variable.address).collect();
    let indices: BTreeSet<_> = sheet.indices().into_iter().collect();
    let mut node = Jn2101::new();
    // Its own test is above.
    for index in (0..=u16::MAX).filter(|index| *index != OBJECT) {
        let (subs, expected) = if indices.contains(&index) {
            (0..=u8::MAX, NO_SUB_INDEX)
        } else {
            (0..=0, NO_OBJECT)
        };
        for sub in subs {
            if described.contains(&(index, sub)) {
                continue;
            }
            let (read, written) = (
                node.abort(0x40, (index, sub)),
                node.abort(0x2F, (index, sub)),
            );
            assert_eq!(
                (read, written),
                (expected, expected),
                "{index:04X}h:{sub:02X}"
            );
        }
    }
}
