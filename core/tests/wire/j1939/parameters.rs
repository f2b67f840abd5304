//! Parameters of the IMS360 in J1939, and the change between CANopen and J1939.

use crate::tester::ims360::booted;
use crate::tester::j1939::{CLAIM, LOWER, NAME, NO_CODES, claimed, select, with};
use plumbline::can::BitRate;
use plumbline::node::{Action, BusMode};

#[test]
fn objects_are_read_and_written() {
    let mut tester = claimed();
    let rows = [
        ("4000100000000000", "430010009A010407"),
        ("4011310000000000", "4B113100D0070000"),
        ("2B113100401F0000", "6011310000000000"),
        ("4011310000000000", "4B113100401F0000"),
        ("40FE5F0000000000", "80FE5F0000000206"),
        ("4006210900000000", "4306210901020300"),
        ("2B113100A8610000", "8011310030000906"),
        ("2F02210000FE0000", "6002210000000000"),
        ("2F022100FE000000", "8002210031000906"),
    ];
    for (request, reply) in rows {
        assert_eq!(tester.parameter(request), reply, "{request}");
    }
}

#[test]
fn communication_objects_can_be_prepared() {
    let mut tester = claimed();
    // COB-ID, mapping and heartbeat of CANopen, as in pre-operational.
    assert_eq!(tester.parameter("23001801B2018080"), "8000180130000906");
    assert_eq!(tester.parameter("23001801B2010080"), "6000180100000000");
    assert_eq!(tester.parameter("2F001A0000000000"), "60001A0000000000");
    assert_eq!(tester.parameter("2B171000E8030000"), "6017100000000000");
    let sent = tester.wait_text(2000);
    assert_eq!(sent, [1000, 2000].map(|at| (at, NO_CODES.to_string())));
    let buses = tester
        .actions
        .iter()
        .filter(|one| matches!(one, Action::Bus(..)));
    assert_eq!(buses.count(), 1, "at the start");
}

#[test]
fn texts_are_read_in_segments() {
    let mut tester = claimed();
    assert_eq!(tester.parameter("4008100000000000"), "4108100006000000");
    assert_eq!(tester.parameter("6000000000000000"), "03494D5333363000");
    // A segment of another client has no effect.
    assert_eq!(tester.parameter("4008100000000000"), "4108100006000000");
    let other = tester.exchange("18EF8022#6000000000000000");
    assert_eq!(other, ["18EF2280#8000000001000405"]);
    assert_eq!(tester.parameter("6000000000000000"), "03494D5333363000");
    // A new request of another client ends the transfer.
    assert_eq!(tester.parameter("4008100000000000"), "4108100006000000");
    let other = tester.exchange("18EF8022#4000100000000000");
    assert_eq!(other, ["18EF2280#430010009A010407"]);
    assert_eq!(tester.parameter("6000000000000000"), "8000000001000405");
    // A transfer times out.
    assert_eq!(tester.parameter("4008100000000000"), "4108100006000000");
    let sent = tester.wait_text(1000);
    let abort = "18EF2180#8008100000000405".to_string();
    assert!(sent.contains(&(1000, abort)), "{sent:?}");
}

/// Requests of a client without a transfer, and the replies.
const REFUSED: [(&str, &[&str]); 10] = [
    ("0000100000000000", &["8000000001000405"]), // segment of a download
    ("6000100000000000", &["8000000001000405"]), // segment of an upload
    ("A100100000000000", &["8000000001000405"]), // block upload: end
    ("A208100000000000", &["8000000001000405"]), // block upload: acknowledgement
    ("A800100000000000", &["8000000001000405"]), // no command of a block upload
    ("C108100000000000", &["8000000001000405"]), // block download: end
    ("E000100000000000", &["8000100001000405"]), // unknown command
    ("FF08100300000000", &["8008100301000405"]),
    ("8008100000000405", &[]), // abort
    ("9F08100000000405", &[]),
];

#[test]
fn request_without_a_transfer_is_refused_as_in_canopen() {
    let replies = |id: &str, replies: &[&str]| -> Vec<String> {
        replies.iter().map(|data| format!("{id}#{data}")).collect()
    };
    let mut canopen = booted();
    for (request, refusal) in REFUSED {
        let sent = canopen.exchange(&format!("632#{request}"));
        assert_eq!(sent, replies("5B2", refusal), "{request}");
        // The first frame of a client, and one after its transfer.
        let mut tester = claimed();
        for read in [false, true] {
            if read {
                assert_eq!(tester.parameter("4000100000000000"), "430010009A010407");
            }
            let sent = tester.exchange(&format!("18EF8021#{request}"));
            assert_eq!(sent, replies("18EF2180", refusal), "{request}");
        }
        // The transfer of another client goes on.
        assert_eq!(tester.parameter("4008100000000000"), "4108100006000000");
        let sent = tester.exchange(&format!("18EF8022#{request}"));
        assert_eq!(sent, replies("18EF2280", refusal), "{request}");
        assert_eq!(tester.parameter("6000000000000000"), "03494D5333363000");
    }
}

#[test]
fn block_upload_is_served() {
    let mut tester = claimed();
    assert_eq!(tester.parameter("A40810007F000000"), "C608100006000000");
    let segment = tester.exchange("18EF8021#A300000000000000");
    assert_eq!(segment, ["18EF2180#81494D5333363000"]);
    let end = tester.exchange("18EF8021#A2017F0000000000");
    assert_eq!(end.len(), 1);
    assert!(end[0].starts_with("18EF2180#C5"), "{end:?}");
}

#[test]
fn frames_that_are_no_requests_are_ignored() {
    let mut tester = claimed();
    for text in [
        "18EF8021#40001000000000",
        "18EFFF21#4000100000000000",
        "18EF8121#4000100000000000",
        "18EF80FE#4000100000000000",
    ] {
        assert_eq!(tester.exchange(text), [""; 0], "{text}");
    }
}

#[test]
fn save_is_answered_to_its_client_at_its_end() {
    let mut tester = claimed();
    tester.memory_works = None;
    assert_eq!(tester.exchange("18EF8021#2310100173617665"), [""; 0]);
    let other = tester.exchange("18EF8022#4000100000000000");
    assert_eq!(other, ["18EF2280#430010009A010407"]);
    // The other client aborts its transfer, with the object address 0 or the object address of the save.
    for abort in ["8000000000000008", "8010100100000008"] {
        let sent = tester.exchange(&format!("18EF8022#{abort}"));
        assert_eq!(sent, [""; 0]);
    }
    tester.finish_save(Ok(()));
    assert_eq!(tester.sent_text(), ["18EF2180#6010100100000000"]);
}

#[test]
fn save_is_not_answered_from_another_address() {
    let claim = format!("18EEFF81#{NAME}");
    for is_late in [false, true] {
        let mut tester = claimed();
        tester.memory_works = None;
        assert_eq!(tester.exchange("18EF8021#2310100173617665"), [""; 0]);
        let sent = tester.exchange(&format!("18EEFF80#{LOWER}"));
        assert_eq!(sent, [claim.as_str()]);
        // The save ends while the next address is claimed, or later.
        if !is_late {
            tester.finish_save(Ok(()));
        }
        let codes = NO_CODES.replace("CA80", "CA81");
        assert_eq!(tester.wait_text(250), [(250, codes)]);
        if is_late {
            tester.finish_save(Ok(()));
        }
        assert_eq!(tester.sent_text(), [""; 0]);
        tester.memory_works = Some(true);
        let sent = tester.exchange("18EF8121#2310100173617665");
        assert_eq!(sent, ["18EF2181#6010100100000000"]);
    }
}

#[test]
fn protocol_changes_after_store_and_restart() {
    let mut tester = booted();
    // 250 kbit/s for the vehicle.
    assert_eq!(tester.write(0x2001, 0, 4, 250_000), Ok(()));
    select(&mut tester);
    assert_eq!(tester.read(0x3100, 1), Ok(1));
    // Not after reset communication.
    assert_eq!(tester.exchange("000#8232"), ["732#00"]);
    assert_eq!(tester.read(0x3100, 1), Ok(1));
    tester.actions.clear();
    assert_eq!(tester.exchange("000#8132"), [CLAIM]);
    let online = Action::Bus(BusMode::Normal, BitRate::K250);
    assert!(tester.actions.contains(&online), "{:?}", tester.actions);
    tester.wait(300);
    assert_eq!(tester.parameter("4000310100000000"), "4F00310101000000");
    assert_eq!(tester.parameter("4001200000000000"), "4301200090D00300");
    // And back.
    assert_eq!(tester.parameter("2F00310102000000"), "6000310100000000");
    assert_eq!(tester.parameter("2310100173617665"), "6010100100000000");
    assert_eq!(tester.parameter("2F10200101000000"), "6010200100000000");
    let sent = tester.wait_text(1000);
    let last = sent.last().unwrap();
    assert_eq!(*last, (100, "732#00".to_string()));
    assert_eq!(tester.read(0x2001, 0), Ok(250_000));
    assert_eq!(tester.exchange("18EA8021#00EE00"), [""; 0]);
}

#[test]
fn protocol_that_is_not_stored_does_not_change() {
    let mut tester = booted();
    assert_eq!(tester.write(0x3100, 1, 1, 1), Ok(()));
    assert_eq!(tester.exchange("000#8132"), ["732#00"]);
    assert_eq!(tester.read(0x3100, 1), Ok(2));
}

#[test]
fn restart_in_j1939_claims_again() {
    let mut tester = with(&[]);
    tester.wait(300);
    assert!(
        tester
            .exchange("18EF8021#2F10200101000000")
            .contains(&"18EF2180#6010200100000000".to_string())
    );
    assert_eq!(tester.wait_text(300), [(100, CLAIM.to_string())]);
}

#[test]
fn node_is_silent_between_the_reply_to_a_restart_and_the_claim() {
    let mut tester = with(&[]);
    tester.wait(300);
    // A message to all nodes is in progress.
    tester.send("18EAFF21#EBFE00");
    tester.wait(70);
    let sent = tester.exchange("18EF8021#2F10200101000000");
    assert_eq!(
        sent.last().map(String::as_str),
        Some("18EF2180#6010200100000000")
    );
    for frame in [
        "18EA8021#EEFE00",
        "18EAFF21#00EE00",
        "18EF8021#4000100000000000",
        "18EEFF80#0000000000000000",
        "1CEC8021#10140003FFEBFE00",
    ] {
        assert_eq!(tester.exchange(frame), [""; 0], "{frame}");
    }
    assert_eq!(tester.wait_text(99), [] as [(u64, String); 0]);
    // The restart tries the preferred address, although a lower NAME has claimed it before.
    assert_eq!(tester.wait_text(2), [(1, CLAIM.to_string())]);
}

#[test]
fn restore_of_factory_values_selects_canopen() {
    for sub in [1, 4, 5] {
        let mut tester = claimed();
        let reply = tester.parameter(&format!("231110{sub:02X}6C6F6164"));
        assert_eq!(reply, format!("601110{sub:02X}00000000"));
        tester.power_cycle();
        assert_eq!(tester.sent_text(), ["732#00"]);
    }
    let mut tester = claimed();
    tester.parameter("231110026C6F6164");
    tester.power_cycle();
    assert_eq!(tester.sent_text(), [CLAIM]);
}
