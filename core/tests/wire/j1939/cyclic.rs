//! The cyclic messages of the IMS360 in J1939: what is sent as delivered, the rate and the priority of each group (S20, S30).

use crate::tester::ims360::Ims360Tester;
use crate::tester::j1939::{claimed, with};
use std::collections::BTreeSet;

/// The PGN of each group in the order of 2104h and 2105h, as in an identifier and as in a request.
const GROUPS: [(&str, &str); 4] = [
    ("F029", "29F000"),
    ("F013", "13F000"),
    ("F02A", "2AF000"),
    ("F02D", "2DF000"),
];

/// Writes a rate in ms.
fn rate(tester: &mut Ims360Tester, sub: u8, ms: u16) {
    let [low, high] = ms.to_le_bytes();
    let reply = tester.parameter(&format!("2B0421{sub:02X}{low:02X}{high:02X}0000"));
    assert_eq!(reply, format!("600421{sub:02X}00000000"));
}

/// The times of the frames of a group with priority 3.
fn times(sent: &[(u64, String)], pgn: &str) -> Vec<u64> {
    let id = format!("0C{pgn}80#");
    let own = sent.iter().filter(|(_, text)| text.starts_with(&id));
    own.map(|(at, _)| *at).collect()
}

#[test]
fn sensor_as_delivered_sends_ssi2_and_dm1_only() {
    let mut tester = with(&[]);
    tester.wait(250);
    let sent = tester.wait_text(3000);
    let expected: Vec<u64> = (1..=300).map(|step| step * 10).collect();
    assert_eq!(times(&sent, "F029"), expected);
    let heads: BTreeSet<_> = sent.iter().map(|(_, text)| &text[..8]).collect();
    assert_eq!(
        heads.into_iter().collect::<Vec<_>>(),
        ["0CF02980", "18FECA80"]
    );
}

#[test]
fn each_group_has_its_rate_from_the_write_on() {
    for (sub, (pgn, request)) in (1..).zip(GROUPS) {
        let mut tester = claimed();
        for ms in (10..=60).chain([100, 333, 1000, 2000]) {
            tester.wait(7);
            rate(&mut tester, sub, ms);
            let sent = tester.wait_text(u64::from(ms) * 4);
            let expected: Vec<u64> = (1..=4).map(|step| step * u64::from(ms)).collect();
            assert_eq!(times(&sent, pgn), expected, "{pgn} every {ms} ms");
            let others = GROUPS.iter().filter(|(other, _)| *other != pgn);
            for (other, _) in others {
                assert_eq!(times(&sent, other), [0; 0]);
            }
        }
        // The longest period, then off: the group is still sent on request.
        rate(&mut tester, sub, 65_535);
        assert_eq!(times(&tester.wait_text(65_535), pgn), [65_535]);
        rate(&mut tester, sub, 0);
        assert_eq!(times(&tester.wait_text(2000), pgn), [0; 0]);
        let sent = tester.request_group("80", request);
        assert!(sent.len() == 1 && sent[0].starts_with(&format!("0C{pgn}80#")));
    }
}

#[test]
fn groups_keep_their_rates_beside_each_other() {
    let mut tester = claimed();
    let periods = [20, 30, 50, 70];
    for (sub, ms) in (1..).zip(periods) {
        rate(&mut tester, sub, ms);
    }
    let sent = tester.wait_text(3000);
    for ((pgn, _), ms) in GROUPS.into_iter().zip(periods.map(u64::from)) {
        let expected: Vec<u64> = (1..=3000 / ms).map(|step| step * ms).collect();
        assert_eq!(times(&sent, pgn), expected, "{pgn}");
    }
}

#[test]
fn each_group_has_its_priority_on_request_and_cyclically() {
    for (sub, (pgn, _)) in (1..).zip(GROUPS) {
        let mut tester = claimed();
        for priority in 0..8_u32 {
            let reply = tester.parameter(&format!("2F0521{sub:02X}{priority:02X}000000"));
            assert_eq!(reply, format!("600521{sub:02X}00000000"));
            let head = format!("{:02X}{pgn}80#", priority << 2);
            for (other, text) in GROUPS {
                let head = if other == pgn {
                    head.clone()
                } else {
                    format!("0C{other}80#")
                };
                for destination in ["80", "FF"] {
                    let sent = tester.request_group(destination, text);
                    assert!(sent.len() == 1 && sent[0].starts_with(&head), "{sent:?}");
                }
            }
            rate(&mut tester, sub, 20);
            let sent = tester.wait_text(20);
            assert!(sent.iter().any(|(_, text)| text.starts_with(&head)));
            rate(&mut tester, sub, 0);
        }
    }
}
