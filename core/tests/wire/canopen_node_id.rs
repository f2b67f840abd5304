//! Node-ID, bit rate and the sensor reset 2002h of the JN2101 (manual 7.7.1 and 9.1).

use crate::tester::canopen::*;
use plumbline::can::BitRate;
use plumbline::node::{Action, BusMode, Node};

const LOAD: u32 = 0x6461_6F6C;

#[test]
fn written_node_id_acts_after_reset_and_changes_cob_ids() {
    for reset in ["000#8200", "000#8100", "power"] {
        let mut t = booted();
        t.write(0x2000, 0, 1, 0x20).unwrap();
        assert_eq!(t.read(0x2000, 0), Ok(0x20));
        assert_eq!(t.read(0x1200, 1), Ok(0x60A), "unchanged before the reset");
        if reset == "power" {
            t.store();
            t.power_cycle();
        } else {
            t.send(reset);
        }
        assert_eq!(t.sent_text(), ["720#00"], "{reset}");
        assert_eq!(t.exchange("60A#4000100000000000"), [""; 0]);
        t.node_id = 0x20;
        for (index, sub, value) in [
            (0x1014, 0, 0xA0),
            (0x1200, 1, 0x620),
            (0x1200, 2, 0x5A0),
            (0x1800, 1, 0x1A0),
            (0x1801, 1, 0x2A0),
        ] {
            assert_eq!(t.read(index, sub), Ok(value), "{index:04X}");
        }
        assert_eq!(t.exchange("000#010A"), [""; 0]);
        t.send("000#0120");
        assert_eq!(t.exchange("080#"), ["1A0#00000000", "2A0#0000000000000000"]);
        assert_eq!(t.exchange("720#R1"), ["720#05"]);
    }
}

#[test]
fn cob_ids_saved_before_follow_new_node_id() {
    // 10: saved with node-ID 10, then changed, then load and save again.
    let mut t = booted();
    t.store();
    t.write(0x2000, 0, 1, 0x7F).unwrap();
    t.write(0x1011, 1, 4, LOAD).unwrap();
    t.store();
    t.power_cycle();
    assert_eq!(t.sent_text(), ["77F#00"]);
    t.node_id = 0x7F;
    assert_eq!(t.read(0x1800, 1), Ok(0x1FF));
}

#[test]
fn unsaved_node_id_is_lost_after_power_cycle() {
    let mut t = booted();
    t.write(0x2000, 0, 1, 0x20).unwrap();
    t.power_cycle();
    assert_eq!(t.sent_text(), ["70A#00"]);
}

#[test]
fn written_bit_rate_acts_after_reset() {
    for (kbits, rate) in [
        (10, BitRate::K10),
        (20, BitRate::K20),
        (50, BitRate::K50),
        (125, BitRate::K125),
        (250, BitRate::K250),
        (500, BitRate::K500),
        (800, BitRate::K800),
        (1000, BitRate::M1),
    ] {
        let mut t = booted();
        t.actions.clear();
        t.write(0x2001, 0, 2, kbits).unwrap();
        assert_eq!(t.actions, [], "not before a reset");
        t.store();
        t.power_cycle();
        assert!(t.actions.contains(&Action::Bus(BusMode::Normal, rate)));
        let mut t = booted();
        t.actions.clear();
        t.write(0x2001, 0, 2, kbits).unwrap();
        t.send("000#820A");
        let bus: Vec<_> = t
            .actions
            .iter()
            .filter(|action| matches!(action, Action::Bus(..)))
            .collect();
        let expected = [&Action::Bus(BusMode::Normal, rate)];
        assert_eq!(bus, if kbits == 125 { &[][..] } else { &expected });
    }
}

#[test]
fn device_reset_restarts_after_its_reply() {
    let mut t = booted();
    assert_eq!(t.write(0x2002, 0, 1, 0), Ok(()));
    assert!(!t.actions.contains(&Action::Restart));
    t.send(&format!("60A#{}", write_request(0x2002, 0, 1, 1)));
    assert!(!t.actions.contains(&Action::Restart));
    assert_eq!(t.sent_text(), ["58A#6002200000000000"]);
    assert_eq!(t.actions.last(), Some(&Action::Restart));
    assert!(!t.node.ready());
    // If the reply is not sent, the wait is limited.
    let mut t = booted();
    t.send(&format!("60A#{}", write_request(0x2002, 0, 1, 1)));
    while t.actions.last() != Some(&Action::Restart) {
        t.now = t.node.deadline().unwrap();
        while let Some(action) = t.node.poll(t.now) {
            t.actions.push(action);
        }
        assert!(t.now.ticks() < 1_000_000);
    }
}
