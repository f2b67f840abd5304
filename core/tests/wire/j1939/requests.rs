//! Requests for groups, acknowledgements and identification of the IMS360.

use crate::tester::j1939::{CLAIM, NO_CODES, claimed, claimed_with};
use crate::tester::sweep::every;

#[test]
fn supported_group_is_sent_if_requested_from_this_node_or_from_all() {
    let mut tester = claimed();
    for destination in ["FF", "80"] {
        let rows = [
            ("00EE00", CLAIM),
            ("29F000", "0CF02980#00007D00007D33FF"),
            ("13F000", "0CF01380#007D007D007DC0FF"),
            ("2AF000", "0CF02A80#007D007D007DC0FF"),
            ("2DF000", "0CF02D80#007D007DD580C0FF"),
            ("CAFE00", NO_CODES),
            ("DAFE00", "18FEDA80#013031303030302A"),
        ];
        for (pgn, answer) in rows {
            assert_eq!(tester.request_group(destination, pgn), [answer]);
        }
    }
}

#[test]
fn unsupported_group_is_refused_only_if_requested_from_this_node() {
    let mut tester = claimed();
    let answer = tester.request_group("80", "EEFE00");
    assert_eq!(answer, ["18E8FF80#01FFFFFF21EEFE00"]);
    assert_eq!(tester.request_group("FF", "EEFE00"), [""; 0]);
    for pgn in ["00EF00", "00EA00", "00EC00", "D8FE00", "CBFE00"] {
        let answer = tester.request_group("80", pgn);
        assert_eq!(answer, [format!("18E8FF80#01FFFFFF21{pgn}")]);
    }
}

#[test]
fn request_for_trouble_codes_is_answered_with_the_active_one() {
    let mut tester = claimed();
    tester.wait(100);
    // 3210h = 100 deg: above the range.
    let active = "18FECA80#04FF70130001FFFF";
    let sent = tester.exchange("18EF8021#2310320010270000");
    assert_eq!(sent, ["18EF2180#6010320000000000", active]);
    assert_eq!(tester.request_group("80", "CAFE00"), [active]);
}

#[test]
fn request_has_three_bytes_or_more() {
    let mut tester = claimed();
    assert_eq!(tester.exchange("18EA8021#CAFE"), [""; 0]);
    assert_eq!(tester.exchange("18EA8021#CAFE00FFFFFFFFFF"), [NO_CODES]);
    assert_eq!(tester.exchange("0CEA8021#CAFE00"), [NO_CODES]);
}

#[test]
fn request_from_address_254_is_answered_only_with_the_claim() {
    let mut tester = claimed();
    assert_eq!(tester.exchange("18EA80FE#CAFE00"), [""; 0]);
    assert_eq!(tester.exchange("18EA80FE#00EE00"), [CLAIM]);
    assert_eq!(tester.exchange("18EAFFFE#00EE00"), [CLAIM]);
}

#[test]
fn frames_to_others_and_of_other_protocols_are_ignored() {
    let mut tester = claimed();
    for text in [
        "18EA8121#CAFE00",
        "1AEA8021#CAFE00",
        "19EA8021#CAFE00",
        "18EA8021#R3",
        "632#4000100000000000",
        "000#8132",
        "080#",
        "7E5#0401000000000000",
    ] {
        assert_eq!(tester.exchange(text), [""; 0], "{text}");
    }
    assert_eq!(tester.wait(300), []);
}

#[test]
fn priority_of_a_group_is_a_parameter() {
    let mut tester = claimed_with(&[(0x2105, 1, 1, 7), (0x2105, 4, 1, 0)]);
    let answer = tester.request_group("80", "29F000");
    assert_eq!(answer, ["1CF02980#00007D00007D33FF"]);
    let answer = tester.request_group("80", "2DF000");
    assert_eq!(answer, ["00F02D80#007D007DD580C0FF"]);
}

#[test]
fn name_is_made_of_its_parameters() {
    let mut tester = claimed_with(&[
        (0x2106, 1, 1, 0),
        (0x2106, 2, 1, 2),
        (0x2106, 3, 1, 15),
        (0x2106, 4, 1, 0x55),
        (0x2106, 5, 1, 0x12),
        (0x2106, 6, 1, 0x11),
        (0x2106, 7, 1, 5),
        (0x2106, 8, 2, 0x123),
    ]);
    let answer = tester.request_group("80", "00EE00");
    assert_eq!(answer, ["18EEFF80#010263248D12AA2F"]);
}

/// The groups that the sensor sends on request.
const SUPPORTED: [u32; 9] = [
    0xEE00, 0xF029, 0xF013, 0xF02A, 0xF02D, 0xFECA, 0xFEEB, 0xFEDA, 0xFDC5,
];

/// A PGN in three bytes.
fn bytes(pgn: u32) -> String {
    let [low, middle, high, _] = pgn.to_le_bytes();
    format!("{low:02X}{middle:02X}{high:02X}")
}

#[test]
fn every_other_group_is_refused() {
    let mut tester = claimed();
    let near = SUPPORTED.into_iter().flat_map(|pgn| pgn - 1..=pgn + 1);
    let all = (0..1 << 18).step_by(every(251)).chain([0xFF_FFFF]);
    for pgn in near.chain(all) {
        if SUPPORTED.contains(&pgn) {
            continue;
        }
        let requester = pgn as u8 % 254;
        let pgn = bytes(pgn);
        let answer = tester.exchange(&format!("18EA80{requester:02X}#{pgn}"));
        assert_eq!(answer, [format!("18E8FF80#01FFFFFF{requester:02X}{pgn}")]);
        assert_eq!(tester.request_group("FF", &pgn), [""; 0], "{pgn}");
    }
}

#[test]
fn request_of_every_length_and_priority_is_handled() {
    for pgn in SUPPORTED.into_iter().chain([0xFEEE]) {
        let pgn = bytes(pgn);
        for destination in ["80", "FF"] {
            let mut tester = claimed();
            let expected = tester.request_group(destination, &pgn);
            let refused = pgn == "EEFE00" && destination == "FF";
            assert_eq!(expected.len(), usize::from(!refused));
            for (priority, length) in
                (0..8).flat_map(|priority| (0..=8).map(move |length| (priority, length)))
            {
                let data = format!("{pgn}0102030405");
                let id = priority << 26
                    | 0x00EA_0021
                    | u32::from_str_radix(destination, 16).unwrap() << 8;
                let mut tester = claimed();
                let sent = tester.exchange(&format!("{id:08X}#{}", &data[..2 * length]));
                let expected: &[String] = if length < 3 { &[] } else { &expected[..] };
                assert_eq!(sent, expected, "{id:08X}, {length} bytes");
            }
            // From a node without an address, only the claim.
            let mut tester = claimed();
            let sent = tester.exchange(&format!("18EA{destination}FE#{pgn}"));
            assert_eq!(sent.len(), usize::from(pgn == "00EE00"), "{sent:?}");
        }
    }
}

#[test]
fn acknowledgements_and_groups_of_other_nodes_are_ignored() {
    let mut tester = claimed();
    for destination in ["FF", "80"] {
        for control in 0..=3 {
            let text = format!("18E8{destination}21#{control:02X}FFFFFF8000EE00");
            assert_eq!(tester.exchange(&text), [""; 0], "{text}");
        }
    }
    // DM13 (57088) among them: it stops nothing.
    let formats = [
        "0CF029", "0CF013", "0CF02A", "0CF02D", "18FECA", "18FEEE", "18FEEB", "18DFFF", "18DF80",
    ];
    for format in formats {
        let text = format!("{format}40#0000000000000000");
        assert_eq!(tester.exchange(&text), [""; 0], "{text}");
    }
    let sent = tester.wait_text(1000);
    assert_eq!(sent, [(1000, NO_CODES.to_string())]);
    assert_eq!(tester.request_group("80", "00EE00"), [CLAIM]);
}

#[test]
fn each_field_of_the_name_is_a_parameter_of_its_own() {
    // Sub-index, highest value, and the NAME as a number with only this field; the identity number is 030201h.
    let rows: [(u8, u32, u64); 8] = [
        (1, 1, 1 << 63),
        (2, 7, 7 << 60),
        (3, 15, 15 << 56),
        (4, 127, 127 << 49),
        (5, 255, 255 << 40),
        (6, 31, 31 << 35),
        (7, 7, 7 << 32),
        (8, 2047, 2047 << 21),
    ];
    for (place, _, name) in rows {
        let fields = rows.map(|(sub, highest, _)| {
            let size = if sub == 8 { 2 } else { 1 };
            let value = if sub == place { highest } else { 0 };
            (0x2106, sub, size, value)
        });
        let mut tester = claimed_with(&fields);
        let name = (name | 0x0003_0201).swap_bytes();
        let answer = tester.request_group("80", "00EE00");
        assert_eq!(answer, [format!("18EEFF80#{name:016X}")]);
    }
}
