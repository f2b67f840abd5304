//! NMT commands of the JN2101: each command in each state, for its node-ID and for all nodes (CiA 301, 7.2.8.3 and 7.3.2).

use crate::tester::canopen::*;

/// The states: the command that enters it, and its value in a heartbeat.
const STATES: [(u8, u8); 3] = [(0x01, 0x05), (0x02, 0x04), (0x80, 0x7F)];
const RESETS: [u8; 2] = [0x81, 0x82];

fn command(command: u8, node_id: u8) -> String {
    format!("000#{command:02X}{node_id:02X}")
}

/// The present state by node guarding, without the toggle bit.
fn state(t: &mut Jn2101Tester) -> u8 {
    let answer = t.exchange("70A#R1").remove(0);
    u8::from_str_radix(&answer[4..], 16).unwrap() & 0x7F
}

#[test]
fn each_command_in_each_state_enters_its_state() {
    for (enter, _) in STATES {
        for node_id in [0, 10] {
            for (next, expected) in STATES {
                let mut t = booted();
                t.send(&command(enter, 10));
                let name = format!("{next:02X}h to {node_id} after {enter:02X}h");
                assert_eq!(t.exchange(&command(next, node_id)), [""; 0], "{name}");
                assert_eq!(state(&mut t), expected, "{name}");
            }
            for reset in RESETS {
                let mut t = booted();
                t.send(&command(enter, 10));
                let name = format!("{reset:02X}h to {node_id} after {enter:02X}h");
                assert_eq!(t.exchange(&command(reset, node_id)), ["70A#00"], "{name}");
                assert_eq!(state(&mut t), 0x7F, "{name}");
            }
        }
    }
}

#[test]
fn unknown_command_in_each_state_is_ignored() {
    for (enter, present) in STATES {
        let mut t = booted();
        t.send(&command(enter, 10));
        for unknown in 0..=255 {
            if STATES.iter().all(|state| state.0 != unknown) && !RESETS.contains(&unknown) {
                for node_id in [0, 10] {
                    assert_eq!(t.exchange(&command(unknown, node_id)), [""; 0]);
                    assert_eq!(state(&mut t), present, "{unknown:02X}h");
                }
            }
        }
    }
}

#[test]
fn command_for_another_node_in_each_state_is_ignored() {
    let commands = STATES.map(|state| state.0).into_iter().chain(RESETS);
    for (enter, present) in STATES {
        let mut t = booted();
        t.send(&command(enter, 10));
        for other in commands.clone() {
            for node_id in (1..=255).filter(|node_id| *node_id != 10) {
                assert_eq!(t.exchange(&command(other, node_id)), [""; 0]);
            }
            assert_eq!(state(&mut t), present, "{other:02X}h");
        }
    }
}

#[test]
fn frame_that_is_no_command_in_each_state_is_ignored() {
    let commands = STATES.map(|state| state.0).into_iter().chain(RESETS);
    for (enter, present) in STATES {
        let mut t = booted();
        t.send(&command(enter, 10));
        for other in commands.clone() {
            for frame in [
                "000#".to_string(),
                format!("000#{other:02X}"),
                format!("000#{other:02X}0A00"),
                format!("00000000#{other:02X}0A"),
                "000#R2".to_string(),
                "00000000#R2".to_string(),
            ] {
                assert_eq!(t.exchange(&frame), [""; 0], "{frame}");
                assert_eq!(state(&mut t), present, "{frame}");
            }
        }
    }
}

#[test]
fn node_started_by_itself_obeys_commands() {
    let mut t = booted();
    t.write(0x1F80, 0, 4, 8).unwrap();
    t.store();
    t.power_cycle();
    assert_eq!(t.sent_text(), ["70A#00"]);
    assert_eq!(state(&mut t), 0x05);
    t.send("000#800A");
    assert_eq!(state(&mut t), 0x7F);
}
