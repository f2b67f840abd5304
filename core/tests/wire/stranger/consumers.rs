//! The heartbeat consumer (1016h): the monitoring of nodes 5, 6 and 7.

use super::Stranger;
use super::booted;
use crate::tester::Tester;

/// Node 5 within 100 ms.
const NODE_5: u32 = 0x0005_0064;
/// Node 6 within 200 ms.
const NODE_6: u32 = 0x0006_00C8;
const LOST: &str = "09E#3081112000000000";
const FOUND: &str = "09E#0000000000000000";

/// A sensor in operational that monitors node 5. Its TPDOs are sent with a SYNC only.
fn monitoring() -> Tester<Stranger> {
    let mut t = booted();
    t.write(0x1016, 1, 4, NODE_5).unwrap();
    t.send("000#011E");
    assert_eq!(t.sent_text(), [""; 0]);
    t
}

/// The NMT state, from the reply to a guarding request without the toggle bit.
fn state(t: &mut Tester<Stranger>) -> u8 {
    let reply = t.exchange("71E#R1");
    u8::from_str_radix(&reply[0][4..], 16).unwrap() & 0x7F
}

#[test]
fn first_heartbeat_starts_monitoring() {
    let mut t = monitoring();
    assert_eq!(t.wait_text(1000), []);
    assert_eq!(t.exchange("705#05"), [""; 0]);
    assert_eq!(t.wait_text(99), []);
    assert_eq!(t.wait_text(1), [(1, LOST.to_owned())]);
}

#[test]
fn heartbeat_restarts_consumer_time() {
    let mut t = monitoring();
    for state in ["05", "7F", "04", "05"] {
        t.send(&format!("705#{state}"));
        assert_eq!(t.wait_text(99), [], "{state}");
    }
}

#[test]
fn boot_up_message_neither_starts_nor_continues_monitoring() {
    let mut t = monitoring();
    t.send("705#00");
    assert_eq!(t.wait_text(500), []);
    t.send("705#05");
    assert_eq!(t.wait_text(60), []);
    t.send("705#00");
    assert_eq!(t.wait_text(60), [(40, LOST.to_owned())]);
}

#[test]
fn lost_heartbeat_is_an_error_until_the_next_heartbeat() {
    let mut t = monitoring();
    t.send("705#05");
    t.wait_text(100);
    assert_eq!(t.read(0x1001, 0), Ok(0x11));
    assert_eq!(t.read(0x1003, 1), Ok(0x2011_8130));
    assert_eq!(t.exchange("705#05"), [FOUND]);
    assert_eq!(t.read(0x1001, 0), Ok(0));
    assert_eq!(t.wait_text(99), []);
    assert_eq!(t.wait_text(1), [(1, LOST.to_owned())]);
}

#[test]
fn lost_heartbeat_causes_error_behaviour_of_1029h() {
    for (behaviour, after) in [(0, 0x7F), (1, 0x05), (2, 0x04)] {
        let mut t = booted();
        t.write(0x1029, 1, 1, behaviour).unwrap();
        t.write(0x1016, 1, 4, NODE_5).unwrap();
        t.send("000#011E");
        t.send("705#05");
        let sent = t.wait_text(100);
        assert_eq!(sent, [(100, LOST.to_owned())], "1029h:01 = {behaviour}");
        assert_eq!(state(&mut t), after, "1029h:01 = {behaviour}");
    }
}

#[test]
fn nodes_are_monitored_independently() {
    let mut t = monitoring();
    t.write(0x1016, 3, 4, NODE_6).unwrap();
    t.send("705#05");
    t.send("706#05");
    assert_eq!(t.wait_text(90), []);
    t.send("706#05");
    assert_eq!(t.wait_text(20), [(10, LOST.to_owned())]);
    // The heartbeat of node 6 is lost too. The error ends when both nodes send heartbeats again.
    t.wait_text(300);
    assert_eq!(t.exchange("705#05"), [""; 0]);
    assert_eq!(t.exchange("706#05"), [FOUND]);
}

#[test]
fn entry_with_time_0_or_another_node_id_monitors_nothing() {
    for entry in [0x0005_0000, 0x0000_0064, 0x0080_0064] {
        let mut t = booted();
        assert_eq!(t.write(0x1016, 1, 4, entry), Ok(()), "{entry:08X}");
        t.send("705#05");
        assert_eq!(t.wait_text(500), [], "{entry:08X}");
    }
}

#[test]
fn second_entry_for_a_node_is_incompatible() {
    let mut t = monitoring();
    assert_eq!(t.write(0x1016, 2, 4, 0x0005_0001), Err(0x0604_0043));
    // An unused entry, then the present value.
    assert_eq!(t.write(0x1016, 2, 4, 0x0005_0000), Ok(()));
    assert_eq!(t.write(0x1016, 1, 4, NODE_5), Ok(()));
    assert_eq!(t.write(0x1016, 1, 4, 0x0005_0065), Ok(()));
    assert_eq!(t.write(0x1016, 2, 4, 0x0100_0000), Err(0x0609_0031));
    // A real number with the same bits is no entry.
    assert_eq!(t.write(0x2202, 0, 4, 0x3F05_0001), Ok(()));
}

#[test]
fn remote_frame_and_empty_frame_are_not_a_heartbeat() {
    let mut t = monitoring();
    for frame in ["705#R1", "705#"] {
        t.send(frame);
        assert_eq!(t.wait_text(500), [], "{frame}");
    }
}

#[test]
fn filters_pass_the_heartbeats_of_monitored_nodes_only() {
    let mut t = booted();
    let id = |number| plumbline::can::standard(number);
    assert!(!t.accepts(id(0x705)));
    t.write(0x1016, 2, 4, NODE_5).unwrap();
    assert!(t.accepts(id(0x705)) && !t.accepts(id(0x706)));
    t.write(0x1016, 2, 4, 0).unwrap();
    assert!(!t.accepts(id(0x705)));
}

#[test]
fn first_heartbeat_starts_monitoring_again_after_reset() {
    let mut t = booted();
    t.write(0x1016, 1, 4, NODE_5).unwrap();
    t.store();
    t.send("705#05");
    for reset in ["000#821E", "000#811E"] {
        t.send(reset);
        assert_eq!(t.wait_text(500), [(0, "71E#00".to_owned())], "{reset}");
        t.send("705#05");
        assert_eq!(t.wait_text(100), [(100, LOST.to_owned())], "{reset}");
    }
}
