//! Long messages of the IMS360: the identification by BAM and by RTS/CTS.

use crate::tester::ims360::Ims360Tester;
use crate::tester::j1939::{NAME, NO_CODES, claimed};
use plumbline::node::Node;

/// "Plumbline*IMS360*67305985**": 27 bytes.
const RTS: &str = "1CEC2180#101B0004FFEBFE00";
const PACKETS: [&str; 4] = [
    "1CEB2180#01506C756D626C69",
    "1CEB2180#026E652A494D5333",
    "1CEB2180#0336302A36373330",
    "1CEB2180#04353938352A2AFF",
];
const ABORT: &str = "1CEC2180#FF03FFFFFFEBFE00";

/// A sensor that has sent its RTS to 21h.
fn requested() -> Ims360Tester {
    let mut tester = claimed();
    assert_eq!(tester.request_group("80", "EBFE00"), [RTS]);
    tester
}

#[test]
fn message_to_all_is_sent_every_60_ms() {
    let mut tester = claimed();
    let mut sent = tester.request_group("FF", "EBFE00");
    sent.extend(tester.wait_text(240).into_iter().map(|(at, text)| {
        assert_eq!(at % 60, 0, "{text}");
        text
    }));
    let mut expected = vec!["1CECFF80#201B0004FFEBFE00".to_string()];
    expected.extend(PACKETS.map(|text| text.replace("EB21", "EBFF")));
    assert_eq!(sent, expected);
}

#[test]
fn messages_to_all_follow_each_other() {
    let mut tester = claimed();
    tester.request_group("FF", "EBFE00");
    assert_eq!(tester.request_group("FF", "C5FD00"), [""; 0]);
    assert_eq!(tester.request_group("FF", "C5FD00"), [""; 0]);
    let sent: Vec<_> = tester.wait_text(900);
    // 40 bytes: "IMS360*67305985**Inclinometer*Plumbline*".
    let controls: Vec<_> = sent
        .iter()
        .filter(|(_, text)| text.contains("EC"))
        .collect();
    assert_eq!(controls.len(), 1);
    assert_eq!(controls[0].1, "1CECFF80#20280006FFC5FD00");
    let data = sent.iter().filter(|(_, text)| text.contains("EBFF"));
    assert_eq!(data.count(), 4 + 6);
}

#[test]
fn message_to_one_node_is_sent_on_request_of_the_receiver() {
    let mut tester = requested();
    assert_eq!(tester.exchange("1CEC8021#110401FFFFEBFE00"), PACKETS);
    assert_eq!(tester.exchange("1CEC8021#131B0004FFEBFE00"), [""; 0]);
    // The connection has ended.
    assert_eq!(tester.exchange("1CEC8021#110401FFFFEBFE00"), [""; 0]);
    assert_eq!(tester.request_group("80", "EBFE00"), [RTS]);
}

#[test]
fn receiver_requests_packets_again() {
    let mut tester = requested();
    assert_eq!(tester.exchange("1CEC8021#110101FFFFEBFE00"), PACKETS[..1]);
    assert_eq!(tester.exchange("1CEC8021#110302FFFFEBFE00"), PACKETS[1..]);
    assert_eq!(tester.exchange("1CEC8021#110202FFFFEBFE00"), PACKETS[1..3]);
    // More than remain.
    assert_eq!(tester.exchange("1CEC8021#110501FFFFEBFE00"), PACKETS);
    for ignored in [
        "1CEC8022#110401FFFFEBFE00",
        "1CEC8021#110401FFFFC5FD00",
        "1CEC8021#110105FFFFEBFE00",
        "1CEC8021#110100FFFFEBFE00",
        "1CECFF21#110401FFFFEBFE00",
    ] {
        assert_eq!(tester.exchange(ignored), [""; 0], "{ignored}");
    }
}

#[test]
fn silent_receiver_is_aborted() {
    let mut tester = requested();
    assert_eq!(tester.wait_text(1249).len(), 1, "one DM1");
    assert_eq!(tester.wait_text(1), [(1, ABORT.to_string())]);
    let mut tester = requested();
    tester.wait(1000);
    assert_eq!(tester.exchange("1CEC8021#1100FFFFFFEBFE00"), [""; 0]);
    tester.wait(1049);
    assert_eq!(tester.wait_text(1), [(1, ABORT.to_string())]);
}

#[test]
fn two_connections_are_served_at_a_time() {
    let mut tester = requested();
    let sent = tester.exchange("18EA8022#EBFE00");
    assert_eq!(sent, [RTS.replace("EC21", "EC22")]);
    let sent = tester.exchange("18EA8023#EBFE00");
    assert_eq!(sent, ["18E8FF80#03FFFFFF23EBFE00"]);
    let sent = tester.exchange("1CEC8022#110101FFFFEBFE00");
    assert_eq!(sent, [PACKETS[0].replace("EB21", "EB22")]);
    assert_eq!(tester.exchange("1CEC8021#110101FFFFEBFE00"), PACKETS[..1]);
    assert_eq!(tester.exchange("1CEC8021#FF01FFFFFFEBFE00"), [""; 0]);
    let sent = tester.exchange("18EA8023#EBFE00");
    assert_eq!(sent, [RTS.replace("EC21", "EC23")]);
}

#[test]
fn unsupported_messages_are_aborted() {
    let mut tester = claimed();
    let sent = tester.exchange("1CEC8021#10140003FFEBFE00");
    assert_eq!(sent, ["1CEC2180#FF02FFFFFFEBFE00"]);
    let sent = tester.exchange("1CEC8021#100A0002FFD8FE00");
    assert_eq!(sent, ["1CEC2180#FF02FFFFFFD8FE00"]);
    assert_eq!(tester.exchange("1CECFF21#20140003FFEBFE00"), [""; 0]);
    assert_eq!(tester.exchange("1CEB8021#01FFFFFFFFFFFFFF"), [""; 0]);
}

#[test]
fn received_transfer_times_out() {
    let mut tester = claimed();
    let sent = tester.exchange("1CEC8021#10090002FFD8FE00");
    assert_eq!(sent, ["1CEC2180#110201FFFFD8FE00"]);
    tester.wait(1249);
    let abort = "1CEC2180#FF03FFFFFFD8FE00".to_string();
    assert_eq!(tester.wait_text(1), [(1, abort)]);
    tester.exchange("1CEC8021#10090002FFD8FE00");
    let sent = tester.exchange("1CEB8021#0280A0FFFFFFFFFF");
    assert_eq!(sent, ["1CEC2180#FF07FFFFFFD8FE00"]);
}

/// A sensor that nothing wakes up for 850 ms: its accelerometer is silent, and the message with its trouble codes is sent.
fn silent() -> Ims360Tester {
    let mut tester = claimed();
    tester.sampled = false;
    tester.wait(250);
    tester
}

#[test]
fn received_transfer_times_out_750_ms_after_a_packet() {
    let mut tester = silent();
    let sent = tester.exchange("1CEC8021#10090002FFD8FE00");
    assert_eq!(sent, ["1CEC2180#110201FFFFD8FE00"]);
    tester.wait(10);
    assert_eq!(tester.exchange("1CEB8021#010102E3FF009100"), [""; 0]);
    assert_eq!(tester.wait_text(749), []);
    let abort = "1CEC2180#FF03FFFFFFD8FE00".to_string();
    assert_eq!(tester.wait_text(1), [(1, abort)]);
}

#[test]
fn transfer_ends_with_the_address() {
    let mut tester = requested();
    let sent = tester.exchange("18EEFF80#0000000000000000");
    assert_eq!(sent, [format!("18EEFF81#{NAME}")]);
    tester.wait(250);
    assert_eq!(tester.exchange("1CEC8121#110401FFFFEBFE00"), [""; 0]);
    let codes = NO_CODES.replace("CA80", "CA81");
    let expected = [1000, 2000, 3000].map(|at| (at, codes.clone()));
    assert_eq!(tester.wait_text(3000), expected);
}

#[test]
fn packets_to_all_are_sent_60_ms_after_the_previous_transmission() {
    let mut tester = claimed();
    tester.acknowledged = false;
    assert_eq!(
        tester.request_group("FF", "EBFE00"),
        ["1CECFF80#201B0004FFEBFE00"]
    );
    for packet in PACKETS {
        // The bus is busy for 12 ms before the frame is sent.
        assert_eq!(tester.wait_text(12), []);
        tester.node.sent(tester.now);
        assert_eq!(tester.wait_text(59), []);
        let expected = packet.replace("EB21", "EBFF");
        assert_eq!(tester.wait_text(1), [(1, expected)]);
    }
    tester.node.sent(tester.now);
    tester.acknowledged = true;
    assert_eq!(tester.wait_text(300), []);
}

#[test]
fn unsent_packet_delays_the_next_packet() {
    let mut tester = claimed();
    tester.acknowledged = false;
    tester.request_group("FF", "EBFE00");
    assert_eq!(tester.wait_text(700), []);
}

/// Commanded Address A0h for our NAME to all, from this node.
fn command(tester: &mut Ims360Tester, source: &str, part: usize) -> Vec<String> {
    let frames = [
        format!("1CECFF{source}#20090002FFD8FE00"),
        format!("1CEBFF{source}#01{}", &NAME[..14]),
        format!("1CEBFF{source}#02{}A0FFFFFFFFFF", &NAME[14..]),
    ];
    tester.exchange(&frames[part])
}

#[test]
fn transfers_that_time_out_together_all_end() {
    let mut tester = claimed();
    tester.wait(10);
    for part in 0..2 {
        for source in ["21", "22", "23"] {
            assert_eq!(command(&mut tester, source, part), [""; 0]);
        }
    }
    assert_eq!(tester.wait_text(750), []);
    for source in ["23", "22", "21"] {
        assert_eq!(command(&mut tester, source, 2), [""; 0]);
    }
    // There is room for another one.
    command(&mut tester, "24", 0);
    command(&mut tester, "24", 1);
    let claim = format!("18EEFFA0#{NAME}");
    assert_eq!(command(&mut tester, "24", 2), [claim]);
}

/// "IMS360*67305985**Inclinometer*Plumbline*" to 21h: 40 bytes.
const ECU_RTS: &str = "1CEC2180#10280006FFC5FD00";
const ECU_PACKETS: [&str; 6] = [
    "1CEB2180#01494D533336302A",
    "1CEB2180#0236373330353938",
    "1CEB2180#03352A2A496E636C",
    "1CEB2180#04696E6F6D657465",
    "1CEB2180#05722A506C756D62",
    "1CEB2180#066C696E652AFFFF",
];

/// A sensor that has sent its RTS for the ECU identification to 21h.
fn opened() -> Ims360Tester {
    let mut tester = claimed();
    assert_eq!(tester.request_group("80", "C5FD00"), [ECU_RTS]);
    tester
}

/// CTS of 21h for packets of the ECU identification.
fn clear(tester: &mut Ims360Tester, count: u8, first: u8) -> Vec<String> {
    tester.exchange(&format!("1CEC8021#11{count:02X}{first:02X}FFFFC5FD00"))
}

#[test]
fn each_clear_to_send_is_answered_with_its_packets_up_to_the_last_one() {
    // Every number of packets from every packet on, in any order.
    let mut tester = opened();
    for count in (1..=255).rev() {
        for first in 0..=255 {
            let sent = clear(&mut tester, count, first);
            if (1..=6).contains(&first) {
                let before = usize::from(first) - 1;
                let last = (before + usize::from(count)).min(6);
                assert_eq!(sent, ECU_PACKETS[before..last], "{count} from {first}");
            } else {
                assert_eq!(sent, [""; 0], "{count} from {first}");
            }
        }
    }
    assert_eq!(tester.exchange("1CEC8021#13280006FFC5FD00"), [""; 0]);
    assert_eq!(clear(&mut tester, 1, 1), [""; 0], "the end");
}

#[test]
fn ecu_identification_is_sent_to_all() {
    let mut tester = claimed();
    let mut sent = tester.request_group("FF", "C5FD00");
    let timed = tester.wait_text(900).into_iter();
    sent.extend(timed.map(|(at, text)| {
        assert_eq!(at % 60, 0, "{text}");
        text
    }));
    let mut expected = vec!["1CECFF80#20280006FFC5FD00".to_string()];
    expected.extend(ECU_PACKETS.map(|text| text.replace("EB21", "EBFF")));
    assert_eq!(sent, expected);
}

#[test]
fn frames_of_others_do_not_change_a_connection() {
    let mut tester = opened();
    tester.wait(1000);
    for text in [
        "1CEC8035#110101FFFFC5FD00",
        "1CEC8035#1100FFFFFFC5FD00",
        "1CEC8021#110101FFFFEBFE00",
        "1CEC9021#110101FFFFC5FD00",
        "1CECFF21#110101FFFFC5FD00",
        "1CEC8021#110101FFFFC5FD",
        "1CEC8021#110107FFFFC5FD00",
        "1CEC8021#110201FFFFC5FD01",
        "1EEC8021#110101FFFFC5FD00",
        "1CEC8035#13280006FFC5FD00",
        "1CEC8021#13280006FFEBFE00",
        "1CEC8035#FF03FFFFFFC5FD00",
        "1CEC8021#FF03FFFFFFEBFE00",
    ] {
        assert_eq!(tester.exchange(text), [""; 0], "{text}");
    }
    // Nor do they extend T3.
    assert_eq!(tester.wait_text(249).len(), 0);
    let abort = "1CEC2180#FF03FFFFFFC5FD00".to_string();
    assert_eq!(tester.wait_text(1), [(1, abort)]);
}

#[test]
fn connection_ends_with_an_abort_of_the_receiver() {
    for reason in 0..=255 {
        let mut tester = opened();
        assert_eq!(clear(&mut tester, 1, 1), ECU_PACKETS[..1]);
        let abort = format!("1CEC8021#FF{reason:02X}FFFFFFC5FD00");
        assert_eq!(tester.exchange(&abort), [""; 0]);
        assert_eq!(clear(&mut tester, 1, 2), [""; 0]);
        assert_eq!(tester.request_group("80", "C5FD00"), [ECU_RTS]);
    }
    // The abort and the end come before the packets.
    for end in ["1CEC8021#FF03FFFFFFC5FD00", "1CEC8021#13280006FFC5FD00"] {
        let mut tester = opened();
        assert_eq!(tester.exchange(end), [""; 0]);
        assert_eq!(clear(&mut tester, 6, 1), [""; 0]);
        assert!(
            tester
                .wait_text(2000)
                .iter()
                .all(|(_, text)| text == NO_CODES)
        );
    }
}

#[test]
fn silent_receiver_is_aborted_after_each_step() {
    let abort = "1CEC2180#FF03FFFFFFC5FD00";
    // The CTS (number of packets, first packet), and the time to the abort: T3 after packets, T4 after a hold.
    for (steps, time) in [
        (&[(2, 1)][..], 1250),
        (&[(6, 1)], 1250),
        (&[(0, 1)], 1050),
        (&[(0, 255), (0, 255), (0, 255), (0, 255)], 1050),
        (&[(6, 1), (0, 1)], 1050),
        (&[(0, 1), (1, 6)], 1250),
    ] {
        let mut tester = opened();
        for &(count, first) in steps {
            tester.wait(1000);
            let sent = clear(&mut tester, count, first);
            assert_eq!(sent.len(), usize::from(count), "{sent:?}");
        }
        let sent = tester.wait_text(time);
        let own: Vec<_> = sent.iter().filter(|(_, text)| text != NO_CODES).collect();
        assert_eq!(own, [&(time, abort.to_string())], "{steps:?}");
        assert_eq!(clear(&mut tester, 1, 1), [""; 0]);
    }
}

#[test]
fn requester_with_a_connection_is_told_busy() {
    let mut tester = opened();
    for pgn in ["C5FD00", "EBFE00"] {
        let sent = tester.request_group("80", pgn);
        assert_eq!(sent, [format!("18E8FF80#03FFFFFF21{pgn}")]);
    }
    assert_eq!(clear(&mut tester, 6, 1), ECU_PACKETS, "it goes on");
    tester.exchange("1CEC8021#13280006FFC5FD00");
    assert_eq!(tester.request_group("80", "EBFE00"), [RTS]);
    // A connection that nobody continues is free after T3.
    tester.wait(1250);
    assert_eq!(tester.request_group("80", "C5FD00"), [ECU_RTS]);
}

#[test]
fn message_to_all_is_sent_beside_two_connections() {
    let mut tester = opened();
    let sent = tester.exchange("18EA8022#EBFE00");
    assert_eq!(sent, [RTS.replace("EC21", "EC22")]);
    let sent = tester.exchange("18EAFF24#EBFE00");
    assert_eq!(sent, ["1CECFF80#201B0004FFEBFE00"]);
    for (place, packet) in PACKETS.iter().enumerate() {
        assert_eq!(clear(&mut tester, 1, 1), ECU_PACKETS[..1]);
        let sent = tester.exchange("1CEC8022#110104FFFFEBFE00");
        assert_eq!(sent, [PACKETS[3].replace("EB21", "EB22")]);
        let to_all = packet.replace("EB21", "EBFF");
        assert_eq!(tester.wait_text(60), [(60, to_all)], "{place}");
    }
    let sent = tester.exchange("18EA8023#EBFE00");
    assert_eq!(sent, ["18E8FF80#03FFFFFF23EBFE00"]);
    assert_eq!(clear(&mut tester, 6, 1), ECU_PACKETS);
}
