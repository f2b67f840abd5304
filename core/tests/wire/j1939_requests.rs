//! Requests for groups, acknowledgements and identification of the IMS360.

use crate::tester::j1939::{CLAIM, NO_CODES, claimed, claimed_with};

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
