//! The address is lost in the middle of a transfer: nothing more is sent from it, and the transfer does not continue at the next
//! address.

use crate::j1939::network::{Network, Objects, answers, frame, memory};
use bench::Logged;

/// No process data.
const QUIET: Objects = &[(0x2104, 1, &[0, 0])];

/// A claim of 80h with the lowest NAME, and the answer of the sensor with the serial number 7.
const LOWER: &str = "18EEFF80#0000000000000000";
const MOVED: &str = "18EEFF81#0700E0FF00910080";

/// "Plumbline*IMS360*7**" to 21h.
const RTS: &str = "1CEC2180#10140003FFEBFE00";
const PACKETS: [&str; 3] = [
    "1CEB2180#01506C756D626C69",
    "1CEB2180#026E652A494D5333",
    "1CEB2180#0336302A372A2AFF",
];

/// A sensor with the address 80h.
fn claimed() -> Network {
    let mut network = Network::new(&[7], QUIET);
    network.wait(300);
    assert_eq!(network.addresses(), [Some(0x80)]);
    network
}

/// The answers within 20 ms after a frame.
fn ask(network: &mut Network, text: &str) -> Vec<String> {
    answers(&network.send(text, 20))
}

/// Checks that nothing more is sent for this time, from either address.
fn is_over(network: &mut Network) {
    assert_eq!(answers(&network.wait(3000)), [""; 0]);
    network.check();
}

#[test]
fn message_to_a_node_ends_with_the_address() {
    // Before the first packet, between packets, while the receiver holds the connection, before the end.
    for requests in [
        &[][..],
        &["110101"],
        &["110201", "1100FF"],
        &["110101", "110102", "110103"],
    ] {
        let mut network = claimed();
        assert_eq!(ask(&mut network, "18EA8021#EBFE00"), [RTS]);
        for request in requests {
            ask(&mut network, &format!("1CEC8021#{request}FFFFEBFE00"));
        }
        assert_eq!(ask(&mut network, LOWER), [MOVED]);
        for address in ["80", "81"] {
            let clear = format!("1CEC{address}21#110301FFFFEBFE00");
            assert_eq!(ask(&mut network, &clear), [""; 0]);
        }
        is_over(&mut network);
        // The connection is free again.
        for requester in ["21", "22"] {
            let sent = ask(&mut network, &format!("18EA81{requester}#EBFE00"));
            assert_eq!(sent, [format!("1CEC{requester}81#10140003FFEBFE00")]);
        }
    }
}

#[test]
fn packets_that_are_queued_are_not_sent_after_the_address_is_lost() {
    let mut network = claimed();
    assert_eq!(ask(&mut network, "18EA8021#C5FD00").len(), 1);
    // The receiver requests all packets, and the next frame on the bus is the claim.
    network.bus.give_way(false);
    network.send("1CEC8021#110501FFFFC5FD00", 0);
    let sent = answers(&network.send(LOWER, 20));
    assert_eq!(sent.last().map(String::as_str), Some(MOVED));
    is_over(&mut network);
}

#[test]
fn message_to_all_ends_with_the_address() {
    for packets in 0..3_u32 {
        let mut network = claimed();
        let mut sent = answers(&network.send("18EAFF21#EBFE00", 30));
        sent.extend(answers(&network.wait(60 * packets)));
        assert_eq!(sent.len(), 1 + packets as usize, "{sent:?}");
        assert_eq!(ask(&mut network, LOWER), [MOVED]);
        is_over(&mut network);
        // The next message to all begins with its announcement.
        let sent = ask(&mut network, "18EAFF21#EBFE00");
        assert_eq!(sent, ["1CECFF81#20140003FFEBFE00"]);
        assert_eq!(answers(&network.wait(200)).len(), 3);
    }
}

#[test]
fn packets_to_all_on_a_busy_bus_are_at_least_50_ms_apart() {
    let mut network = claimed();
    network.bus.give_way(false);
    network.bus.send(network.tester, frame("18EAFF21#C5FD00"));
    // Other nodes send up to 30 frames without a gap, about 1 ms each, at different times of the 60 ms.
    for step in 0..20 {
        for number in 0..step * 7 % 31 {
            let text = format!("0CF00421#{number:02X}FFFFFFFFFFFFFF");
            network.bus.send(network.tester, frame(&text));
        }
        network.wait(43);
    }
    let is_packet = |one: &&Logged| {
        let text = format!("{:?}", one.frame);
        text.starts_with("1CECFF80") || text.starts_with("1CEBFF80")
    };
    let packets: Vec<_> = network.log.iter().filter(is_packet).collect();
    assert_eq!(packets.len(), 1 + 5);
    for pair in packets.windows(2) {
        let gap = (pair[1].start - pair[0].start) / 1_000_000;
        assert!((50_000..=200_000).contains(&gap), "{gap} us");
    }
}

#[test]
fn messages_to_all_that_wait_end_with_the_address() {
    let mut network = claimed();
    ask(&mut network, "18EAFF21#EBFE00");
    ask(&mut network, "18EAFF21#C5FD00");
    assert_eq!(ask(&mut network, LOWER), [MOVED]);
    is_over(&mut network);
}

#[test]
fn commanded_address_to_us_ends_with_the_address() {
    for packets in 0..2 {
        let mut network = claimed();
        let sent = ask(&mut network, "1CEC8021#10090002FFD8FE00");
        assert_eq!(sent, ["1CEC2180#110201FFFFD8FE00"]);
        if packets > 0 {
            ask(&mut network, "1CEB8021#010700E0FF009100");
        }
        assert_eq!(ask(&mut network, LOWER), [MOVED]);
        for address in ["80", "81"] {
            for packet in ["010700E0FF009100", "0280A0FFFFFFFFFF"] {
                let sent = ask(&mut network, &format!("1CEB{address}21#{packet}"));
                assert_eq!(sent, [""; 0], "no end of message, no claim of A0h");
            }
        }
        is_over(&mut network);
        // 2102h has not changed.
        let sent = ask(&mut network, "18EF8121#4002210000000000");
        assert_eq!(sent, ["18EF2181#4F02210080000000"]);
    }
}

#[test]
fn commanded_address_to_all_does_not_end_with_the_address() {
    // It is heard in every state.
    let mut network = claimed();
    ask(&mut network, "1CECFF21#20090002FFD8FE00");
    ask(&mut network, "1CEBFF21#010700E0FF009100");
    assert_eq!(ask(&mut network, LOWER), [MOVED]);
    let sent = ask(&mut network, "1CEBFF21#0280A0FFFFFFFFFF");
    assert_eq!(sent, ["18EEFFA0#0700E0FF00910080"]);
    is_over(&mut network);
    assert_eq!(network.addresses(), [Some(0xA0)]);
}

#[test]
fn segmented_upload_ends_with_the_address() {
    let mut network = claimed();
    let sent = ask(&mut network, "18EF8021#4008100000000000");
    assert_eq!(sent, ["18EF2180#4108100006000000"]);
    assert_eq!(ask(&mut network, LOWER), [MOVED]);
    assert_eq!(
        ask(&mut network, "18EF8121#6000000000000000"),
        [""; 0],
        "silence"
    );
    network.wait(300);
    let sent = ask(&mut network, "18EF8121#6000000000000000");
    assert_eq!(sent, ["18EF2181#8000000001000405"]);
    is_over(&mut network);
}

#[test]
fn address_that_is_kept_keeps_its_transfers() {
    let mut network = claimed();
    assert_eq!(ask(&mut network, "18EA8021#EBFE00"), [RTS]);
    assert_eq!(ask(&mut network, "1CEC8021#110101FFFFEBFE00"), PACKETS[..1]);
    let defence = "18EEFF80#0700E0FF00910080";
    assert_eq!(ask(&mut network, "18EEFF80#FFFFFFFFFFFFFFFF"), [defence]);
    assert_eq!(ask(&mut network, "1CEC8021#110202FFFFEBFE00"), PACKETS[1..]);
    assert_eq!(ask(&mut network, "1CEC8021#13140003FFEBFE00"), [""; 0]);
    is_over(&mut network);
}

#[test]
fn transfers_of_two_sensors_and_a_late_sensor_do_not_mix() {
    let mut network = Network::new(&[7, 9], QUIET);
    network.wait(400);
    assert_eq!(network.addresses(), [Some(0x80), Some(0x81)]);
    // Both send to the tester, and the second also to all.
    let second = RTS.replace("2180", "2181");
    assert_eq!(ask(&mut network, "18EA8021#EBFE00"), [RTS]);
    assert_eq!(ask(&mut network, "18EA8121#EBFE00"), [second.as_str()]);
    // The late one takes 80h from the first, which takes 82h.
    let late = memory(1, QUIET);
    network.attach(1, late);
    let frames = network.wait(300);
    network.check();
    let addresses = network.addresses();
    assert_eq!(
        addresses,
        [Some(0x82), Some(0x81), Some(0x80)],
        "{frames:?}"
    );
    assert_eq!(ask(&mut network, "1CEC8021#110301FFFFEBFE00"), [""; 0]);
    assert_eq!(ask(&mut network, "1CEC8221#110301FFFFEBFE00"), [""; 0]);
    let sent = ask(&mut network, "1CEC8121#110101FFFFEBFE00");
    assert_eq!(sent, [PACKETS[0].replace("2180", "2181")]);
}
