//! DeviceNet: frames that have no meaning for the node are neither answered nor change anything.

use crate::tester::canopen::frame;
use crate::tester::devicenet::{LevelTester, MAC_3, allocated, online, power_up};
use plumbline::can::{Frame, extended, standard};

/// Frames that have a meaning on an identifier of group 2.
const REQUESTS: [&str; 7] = [
    "",
    "0B4B0301030B",
    "0A4B0301030A",
    "0A4C030103",
    "0A106501712C01",
    "00620102020304",
    "80620102020304",
];

/// The node on-line, allocated, and with all connections established.
fn states() -> [LevelTester; 3] {
    let mut established = allocated(0x52);
    established.set_rate(2, 0);
    let sent = established.exchange("41C#0A100504090000");
    assert_eq!(sent.len(), 2);
    [online(), allocated(0x52), established]
}

fn ignores(tester: &mut LevelTester, frame: Frame) {
    tester.receive(frame);
    assert_eq!(tester.sent_text(), [""; 0], "{frame:?}");
}

/// Everything that a master can read.
fn snapshot(tester: &mut LevelTester) -> Vec<String> {
    if !tester.owner() {
        tester.allocate(1);
        let values = snapshot(tester);
        assert_eq!(tester.exchange("41E#0A4C030101"), ["41B#0ACC"]);
        return values;
    }
    let angle = [0x71, 0x72, 0x73, 0x75, 0x76, 0x78, 0x7A, 0x81, 0x82, 0x88];
    let mut requests: Vec<String> = angle.iter().map(|it| format!("0E6501{it:02X}")).collect();
    for attribute in 1..=6 {
        requests.push(format!("0E0101{attribute:02X}"));
    }
    for attribute in 1..=5 {
        requests.push(format!("0E0301{attribute:02X}"));
    }
    for instance in [1, 2, 4] {
        for attribute in [1, 4, 5, 9, 12, 17] {
            requests.push(format!("0E05{instance:02X}{attribute:02X}"));
        }
    }
    for attribute in 1..=3 {
        requests.push(format!("0E2B01{attribute:02X}"));
    }
    requests.iter().map(|it| tester.explicit(it)).collect()
}

#[test]
fn other_identifiers_are_ignored() {
    for mut tester in states() {
        let before = snapshot(&mut tester);
        for id in (0..0x800).filter(|id| !matches!(id, 0x41A | 0x41C..=0x41F)) {
            for request in REQUESTS {
                ignores(&mut tester, frame(&format!("{id:03X}#{request}")));
            }
        }
        assert_eq!(snapshot(&mut tester), before);
    }
}

#[test]
fn extended_and_remote_frames_are_ignored() {
    for mut tester in states() {
        let before = snapshot(&mut tester);
        for message in 0..8 {
            let id = 0x418 | message;
            for request in REQUESTS {
                let data = frame(&format!("000#{request}"));
                for number in [u32::from(id), u32::from(id) << 18] {
                    let extended = Frame::data(extended(number), data.bytes());
                    ignores(&mut tester, extended.unwrap());
                }
            }
            for length in 0..=8 {
                let remote = Frame::remote(standard(id), length);
                ignores(&mut tester, remote.unwrap());
            }
        }
        assert_eq!(snapshot(&mut tester), before);
    }
}

#[test]
fn responses_are_no_requests() {
    let mut tester = allocated(0);
    for service in 0x80..=0xFF_u8 {
        for body in ["", "650187", "65017100", "0101"] {
            for id in ["41C", "41E"] {
                tester.ignores(&format!("{id}#0A{service:02X}{body}"));
                tester.ignores(&format!("{id}#4A{service:02X}{body}"));
            }
        }
    }
    assert_eq!(tester.explicit("0E650171"), "8E0A00");
}

#[test]
fn request_without_class_or_instance_has_not_enough_data() {
    let mut tester = allocated(0);
    for service in 0..0x80 {
        for rest in ["", "65"] {
            let response = tester.explicit(&format!("{service:02X}{rest}"));
            assert_eq!(response, "9413FF", "{service:02X}{rest}");
        }
    }
    for service in ["4B", "4C"] {
        for rest in ["", "03"] {
            let sent = tester.exchange(&format!("41E#0A{service}{rest}"));
            assert_eq!(sent, ["41B#0A9413FF"], "{service}{rest}");
        }
    }
}

#[test]
fn node_is_silent_before_it_is_online() {
    for wait in [0, 500, 999, 1000, 1500, 1999] {
        let mut tester = power_up(Some(MAC_3));
        tester.wait(wait);
        for text in [
            "41E#0A4B0301030A",
            "41E#0A4C030101",
            "41E#0A0E030101",
            "41C#0A0E030101",
            "41C#8A00106501",
            "41D#",
            "41A#",
            "417#00620102020304",
            "427#80620102020304",
        ] {
            tester.ignores(text);
        }
        let left = tester.wait_text(2000 - wait).len();
        assert_eq!(left, usize::from(wait < 1000), "{wait}");
        assert!(!tester.owner(), "on-line, and nothing is allocated");
    }
}

/// Byte 0 of the check: bit 7 is the response, the others are the port.
#[test]
fn duplicate_check_distinguishes_requests_and_responses_on_every_port() {
    for first in 0..=255_u8 {
        let mut tester = online();
        let message = format!("41F#{first:02X}620102020304");
        if first < 0x80 {
            assert_eq!(tester.exchange(&message), ["41F#80620101020304"]);
            assert!(!tester.owner());
        } else {
            tester.ignores(&message);
            tester.ignores("41F#00620102020304");
            tester.ignores("41E#0A4B0301010A");
        }
    }
}
