//! Node-ID, bit rate and the sensor reset 2002h of the JN2101 (manual 7.7.1 and 9.1).

use crate::tester::canopen::*;
use plumbline::can::BitRate;
use plumbline::node::{Action, BusMode, Node};

const LOAD: u32 = 0x6461_6F6C;
const RESET: &str = "60A#2F02200001000000";
const ACCEPTED: &str = "58A#6002200000000000";

/// The time from the reply to 2002h until the boot-up message, in ms.
const DELAY: u64 = 100;

fn boot_up(id: &str) -> Vec<(u64, String)> {
    vec![(DELAY, format!("{id}#00"))]
}

/// The changes of mode and bit rate.
fn bus(t: &Jn2101Tester) -> Vec<Action> {
    let is_bus = |action: &&Action| matches!(action, Action::Bus(..));
    t.actions.iter().filter(is_bus).copied().collect()
}

#[test]
fn written_node_id_acts_after_reset_and_changes_cob_ids() {
    for node_id in [1, 0x20, 127_u8] {
        for reset in ["000#8200", "000#8100", "power"] {
            let mut t = booted();
            let id = |base: u32| base + u32::from(node_id);
            t.write(0x2000, 0, 1, node_id.into()).unwrap();
            assert_eq!(t.read(0x2000, 0), Ok(node_id.into()));
            assert_eq!(t.read(0x1200, 1), Ok(0x60A), "unchanged before the reset");
            if reset == "power" {
                t.store();
                t.power_cycle();
            } else {
                t.send(reset);
            }
            assert_eq!(t.sent_text(), [format!("{:03X}#00", id(0x700))], "{reset}");
            assert_eq!(t.exchange("60A#4000100000000000"), [""; 0]);
            t.node_id = node_id;
            for (index, sub, base) in [
                (0x1014, 0, 0x080),
                (0x1200, 1, 0x600),
                (0x1200, 2, 0x580),
                (0x1800, 1, 0x180),
                (0x1801, 1, 0x280),
            ] {
                assert_eq!(t.read(index, sub), Ok(id(base)), "{index:04X}");
            }
            assert_eq!(t.exchange("000#010A"), [""; 0]);
            t.send(&format!("000#01{node_id:02X}"));
            let tpdos = [
                format!("{:03X}#00000000", id(0x180)),
                format!("{:03X}#0000000000000000", id(0x280)),
            ];
            assert_eq!(t.exchange("080#"), tpdos);
            let guarding = t.exchange(&format!("{:03X}#R1", id(0x700)));
            assert_eq!(guarding, [format!("{:03X}#05", id(0x700))]);
        }
    }
}

#[test]
fn cob_ids_saved_before_follow_new_node_id() {
    // Manual 10: save with node-ID 10, change the node-ID, load, save.
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
fn sensor_reset_answers_then_starts_with_the_saved_parameters() {
    let mut t = operational();
    t.write(0x1017, 0, 2, 500).unwrap();
    t.write(0x2044, 0, 1, 3).unwrap();
    t.actions.clear();
    assert_eq!(t.write(0x2002, 0, 1, 0), Ok(()));
    assert_eq!(t.wait_text(400), [], "0 does nothing");
    assert_eq!(t.exchange(RESET), [ACCEPTED]);
    assert_eq!(t.wait_text(1000), boot_up("70A"));
    assert_eq!(t.read(0x1017, 0), Ok(0));
    assert_eq!(t.read(0x2044, 0), Ok(0));
    assert_eq!(t.exchange("70A#R1"), ["70A#7F"]);
    // Node-ID and bit rate have not changed: the controller stays on the bus.
    assert_eq!(bus(&t), []);
    assert!(!t.actions.contains(&Action::Restart));
}

#[test]
fn sensor_reset_keeps_unsaved_node_id_and_bit_rate() {
    let mut t = booted();
    t.write(0x2000, 0, 1, 0x20).unwrap();
    t.write(0x2001, 0, 2, 500).unwrap();
    t.write(0x6000, 0, 2, 100).unwrap();
    t.actions.clear();
    assert_eq!(t.exchange(RESET), [ACCEPTED]);
    assert_eq!(t.wait_text(DELAY - 1), []);
    // A change of the bit rate discards the frames in the mailboxes.
    assert_eq!(bus(&t), [], "the reply must be sent first");
    assert_eq!(t.wait_text(1), [(1, "720#00".to_string())]);
    assert_eq!(bus(&t), [Action::Bus(BusMode::Normal, BitRate::K500)]);
    t.node_id = 0x20;
    assert_eq!(t.read(0x2000, 0), Ok(0x20));
    assert_eq!(t.read(0x2001, 0), Ok(500));
    assert_eq!(t.read(0x1801, 1), Ok(0x2A0));
    assert_eq!(t.read(0x6000, 0), Ok(10));
    // Only a power cycle discards them.
    t.power_cycle();
    assert_eq!(t.sent_text(), ["70A#00"]);
    assert!(bus(&t).contains(&Action::Bus(BusMode::Normal, BitRate::K125)));
}

#[test]
fn sensor_is_silent_between_reply_and_reset() {
    let mut t = booted();
    t.write(0x1800, 2, 1, 254).unwrap();
    t.write(0x1017, 0, 2, 20).unwrap();
    t.write(0x100C, 0, 2, 10).unwrap();
    t.write(0x100D, 0, 1, 2).unwrap();
    t.send("000#010A");
    t.wait_text(50);
    assert_eq!(t.exchange(RESET), [ACCEPTED]);
    for frame in [
        "080#",
        "60A#4000100000000000",
        "60A#2310100173617665",
        "70A#R1",
        "18A#R4",
        "000#010A",
        "000#020A",
        "000#800A",
    ] {
        assert_eq!(t.exchange(frame), [""; 0], "{frame}");
    }
    assert_eq!(t.wait_text(1000), boot_up("70A"));
    assert_eq!(t.exchange("70A#R1"), ["70A#7F"]);
}

#[test]
fn reset_communication_before_the_end_of_the_delay_resets_the_node() {
    let mut t = booted();
    t.write(0x6000, 0, 2, 100).unwrap();
    assert_eq!(t.exchange(RESET), [ACCEPTED]);
    assert_eq!(t.exchange("000#8200"), ["70A#00"]);
    assert_eq!(t.read(0x6000, 0), Ok(10), "the stored value");
}

#[test]
fn nmt_reset_before_the_end_of_the_delay_acts_at_once() {
    for reset in ["000#810A", "000#8200"] {
        let mut t = booted();
        assert_eq!(t.exchange(RESET), [ACCEPTED]);
        t.wait_text(50);
        assert_eq!(t.exchange(reset), ["70A#00"]);
        assert_eq!(t.wait_text(1000), [], "{reset}: one boot-up message");
        assert_eq!(t.exchange("70A#R1"), ["70A#7F"]);
    }
}

#[test]
fn sensor_reset_enters_operational_by_itself_and_announces_active_faults() {
    let mut t = booted();
    t.write(0x1F80, 0, 4, 8).unwrap();
    t.store();
    t.tilt(60.0, 0.0);
    t.wait_text(10);
    assert_eq!(t.exchange(RESET), [ACCEPTED]);
    let expected = ["70A#00", "08A#0090010200000000"].map(|text| (DELAY, text.to_string()));
    assert_eq!(t.wait_text(1000), expected);
    assert_eq!(t.exchange("70A#R1"), ["70A#05"]);
}

#[test]
fn sensor_reset_during_a_save_uses_the_saved_parameters() {
    let mut t = booted();
    t.memory_works = None;
    t.write(0x6000, 0, 2, 100).unwrap();
    assert_eq!(t.exchange("60A#2310100173617665"), [""; 0]);
    assert_eq!(t.exchange(RESET), [ACCEPTED]);
    assert_eq!(t.wait_text(1000), boot_up("70A"));
    t.finish_save(Ok(()));
    assert_eq!(t.sent_text(), [""; 0]);
    assert_eq!(t.read(0x6000, 0), Ok(100));
}

#[test]
fn node_receives_frames_during_the_delay() {
    let mut t = booted();
    assert_eq!(t.exchange(RESET), [ACCEPTED]);
    assert!(t.node.ready());
}
