//! Random frames that are no valid request change nothing: no setting, no NMT state, no error.

use super::{dictionary, ims360_dictionary};
use crate::tester::Tester;
use crate::tester::dictionary::{Access, Row};
use crate::tester::{canopen, ims360};
use plumbline::can::{Frame, extended, standard};
use plumbline::node::Node;

const FRAMES: usize = 2000;

/// A generator of random numbers (xorshift64*).
struct Random(u64);

impl Random {
    fn next(&mut self) -> u32 {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        (self.0.wrapping_mul(0x2545_F491_4F6C_DD1D) >> 32) as u32
    }

    fn below(&mut self, limit: u32) -> u32 {
        self.next() % limit
    }

    fn bytes(&mut self) -> [u8; 8] {
        let [a, b] = [self.next(), self.next()].map(u32::to_le_bytes);
        [a, b].concat().try_into().unwrap()
    }
}

/// A frame that must change nothing; None if the random one could.
fn invalid(random: &mut Random, node_id: u8, rows: &[Row]) -> Option<Frame> {
    let request = 0x600 + u16::from(node_id);
    let guarding = 0x700 + u16::from(node_id);
    let id = random.below(0x800) as u16;
    let length = random.below(9) as usize;
    let mut data = random.bytes();
    let frame = match random.below(8) {
        // NMT, SYNC, LSS and SDO have kinds of their own.
        0 if ![0, 0x080, 0x7E5, request].contains(&id) => {
            Frame::data(standard(id), &data[..length])
        }
        1 => {
            let ids = [random.below(1 << 29), 0, 0x080, request.into()];
            Frame::data(extended(ids[random.below(4) as usize]), &data[..length])
        }
        2 if id != guarding => Frame::remote(standard(id), length),
        3 if ![0, node_id].contains(&data[1]) => Frame::data(standard(0), &data[..2]),
        4 if ![1, 2, 0x80, 0x81, 0x82].contains(&data[0]) => Frame::data(
            standard(0),
            &[data[0], [0, node_id][random.below(2) as usize]],
        ),
        5 => Frame::data(standard(request), &data[..length.min(7)]),
        // Reads, segments and aborts without a transfer; not the begin of a write, nor that of a block.
        6 if ![1, 6].contains(&(data[0] >> 5)) => Frame::data(standard(request), &data),
        7 => {
            let index = u16::from_le_bytes([data[1], data[2]]);
            if rows.iter().any(|row| row.0 == index) {
                return None;
            }
            data[0] = 0x23;
            Frame::data(standard(request), &data)
        }
        _ => return None,
    };
    Some(frame.unwrap())
}

fn assert_unchanged<N: Node>(mut t: Tester<N>, rows: &[Row]) {
    let settings = |t: &mut Tester<N>| -> Vec<u32> {
        let numbers = rows.iter().filter(|row| row.2 > 0 && row.3 == Access::Rw);
        numbers.map(|row| t.read(row.0, row.1).unwrap()).collect()
    };
    let before = settings(&mut t);
    let node_id = t.node_id;
    let mut random = Random(2101);
    // The answer to a remote frame shows the state.
    let tpdo = format!("{:03X}#R8", 0x180 + u16::from(node_id));
    for (command, answers) in [(0x80, 0), (0x01, 1)] {
        t.send(&format!("000#{command:02X}{node_id:02X}"));
        for _ in 0..FRAMES {
            if let Some(frame) = invalid(&mut random, node_id, rows) {
                t.receive(frame);
                t.sent();
            }
        }
        t.wait(1100);
        assert_eq!(t.exchange(&tpdo).len(), answers, "the state");
        assert_eq!(settings(&mut t), before);
        assert_eq!((t.read(0x1001, 0), t.read(0x1003, 0)), (Ok(0), Ok(0)));
        assert_eq!(t.memory, None);
    }
}

#[test]
fn random_invalid_frames_change_nothing_in_jn2101() {
    assert_unchanged(canopen::booted(), &dictionary::objects());
}

#[test]
fn random_invalid_frames_change_nothing_in_ims360() {
    assert_unchanged(ims360::booted(), ims360_dictionary::OBJECTS);
}
