//! The addresses of the IMS360 in J1939: every preferred address, the order of the next ones, the NAMEs that win, and frames to other
//! addresses (SAE J1939-81, 4.4; S20 to S24).

use crate::tester::ims360::Ims360Tester;
use crate::tester::j1939::{CLAIM, LOWER, NAME, NO_CODES, claimed, claimed_with, with};

/// A NAME that is higher than ours.
const HIGHER: &str = "FFFFFFFFFFFFFFFF";
const SSI2: &str = "0CF02980#00007D00007D33FF";
/// A NAME that is not arbitrary address capable, as a write to its object.
const FIXED: (u16, u8, u8, u32) = (0x2106, 1, 1, 0);
/// "Cannot claim" of a node with [`FIXED`].
const CANNOT_CLAIM: &str = "18EEFFFE#0102E3FF00910000";

fn claim(address: u8) -> String {
    format!("18EEFF{address:02X}#{NAME}")
}

/// A lower NAME claims the address. Returns the address of the next claim.
fn lose(tester: &mut Ims360Tester, address: u8) -> Option<u8> {
    let sent = tester.exchange(&format!("18EEFF{address:02X}#{LOWER}"));
    let [text] = &sent[..] else {
        assert_eq!(sent, [""; 0]);
        return None;
    };
    let next = u8::from_str_radix(&text[6..8], 16).unwrap();
    assert_eq!(*text, claim(next));
    Some(next)
}

#[test]
fn every_preferred_address_is_used_250_ms_after_its_claim() {
    for address in 0..=253 {
        let mut tester = with(&[(0x2102, 0, 1, address.into())]);
        assert_eq!(tester.sent_text(), [claim(address)]);
        assert_eq!(tester.wait_text(249), []);
        let from = |text: &str| text.replace("80#", &format!("{address:02X}#"));
        let expected = [(1, from(NO_CODES)), (11, from(SSI2))];
        assert_eq!(tester.wait_text(11), expected);
    }
}

#[test]
fn next_address_is_the_next_one_of_128_to_247() {
    for preferred in 0..=253 {
        let mut tester = with(&[(0x2102, 0, 1, preferred.into())]);
        let mut address = preferred;
        for step in 0..4_u64 {
            // While claiming, and with an address.
            tester.wait(250 * (step % 2));
            let above = (128..247).contains(&address);
            let next = if above { address + 1 } else { 128 };
            assert_eq!(lose(&mut tester, address), Some(next), "{address}");
            address = next;
        }
    }
}

#[test]
fn node_that_has_lost_every_address_cannot_claim() {
    let mut tester = claimed_with(&[(0x2102, 0, 1, 130)]);
    let mut address = 130;
    for next in (131..=247).chain([128, 129]) {
        assert_eq!(lose(&mut tester, address), Some(next));
        address = next;
    }
    assert_eq!(lose(&mut tester, address), None);
    let sent = tester.wait_text(153);
    let [(_, text)] = &sent[..] else {
        panic!("{sent:?}");
    };
    assert_eq!(*text, claim(254));
}

#[test]
fn next_address_is_one_that_nobody_has_claimed_since_the_start() {
    let mut tester = claimed();
    for (address, name) in [
        ("81", HIGHER),
        ("82", LOWER),
        ("84", HIGHER),
        ("30", LOWER),
        ("F8", LOWER),
    ] {
        let sent = tester.exchange(&format!("18EEFF{address}#{name}"));
        assert_eq!(sent, [""; 0]);
    }
    for (address, next) in [(0x80, 0x83), (0x83, 0x85), (0x85, 0x86)] {
        assert_eq!(lose(&mut tester, address), Some(next));
    }
    tester.power_cycle();
    assert_eq!(tester.sent_text(), [CLAIM]);
    assert_eq!(lose(&mut tester, 0x80), Some(0x81), "forgotten");
}

#[test]
fn address_claimed_by_another_node_before_the_claim_left_is_not_claimed() {
    for count in 1..=5 {
        let mut tester = claimed();
        for address in 0x80..0x80 + count {
            tester.send(&format!("18EEFF{address:02X}#{LOWER}"));
        }
        assert_eq!(tester.sent_text(), [claim(0x80 + count)]);
        assert_eq!(tester.wait_text(249), []);
        let codes = NO_CODES.replace("80#", &format!("{:02X}#", 0x80 + count));
        assert_eq!(tester.wait_text(1), [(1, codes)]);
    }
}

#[test]
fn each_bit_of_the_name_decides_who_keeps_the_address() {
    let own = u64::from_str_radix(NAME, 16).unwrap().swap_bytes();
    for bit in 0..64 {
        let mut tester = claimed();
        let other = own ^ 1 << bit;
        let sent = tester.exchange(&format!("18EEFF80#{:016X}", other.swap_bytes()));
        let expected = if other < own { 0x81 } else { 0x80 };
        assert_eq!(sent, [claim(expected)], "bit {bit}");
    }
}

#[test]
fn process_data_continues_while_the_address_is_defended() {
    let mut tester = with(&[]);
    tester.wait(250);
    for number in 1..=40 {
        let name = format!("{number:02X}02E3FF00FF0080");
        assert_eq!(tester.exchange(&format!("18EEFF80#{name}")), [CLAIM]);
        assert_eq!(tester.wait_text(10), [(10, SSI2.to_string())]);
    }
}

#[test]
fn frames_that_do_not_contend_for_the_address_are_not_answered() {
    let mut tester = claimed();
    for text in [
        format!("18EEFF90#{LOWER}"),
        format!("18EEFF91#{NAME}"),
        format!("18EEFFFE#{LOWER}"),
        // Short, empty, to one node, with the page bits of other protocols.
        format!("18EEFF80#{}", &LOWER[2..]),
        "18EEFF80#".to_string(),
        format!("18EE2180#{LOWER}"),
        format!("1AEEFF80#{LOWER}"),
        format!("19EEFF80#{LOWER}"),
    ] {
        assert_eq!(tester.exchange(&text), [""; 0], "{text}");
    }
    assert_eq!(tester.request_group("80", "00EE00"), [CLAIM]);
}

/// Asks for the claim, for trouble codes, for an unknown group, for a parameter and for a connection.
fn questions(destination: u8) -> [String; 5] {
    let to = |format: &str, data: &str| format!("{format}{destination:02X}21#{data}");
    [
        to("18EA", "00EE00"),
        to("18EA", "CAFE00"),
        to("18EA", "EEFE00"),
        to("18EF", "4000100000000000"),
        to("1CEC", "10090002FFD8FE00"),
    ]
}

#[test]
fn questions_to_other_addresses_are_not_answered() {
    let mut tester = claimed();
    for own in [0x80, 0x81] {
        for address in (0..=254).filter(|address| *address != own) {
            for text in questions(address) {
                assert_eq!(tester.exchange(&text), [""; 0], "{text}");
            }
        }
        for text in questions(own) {
            assert_eq!(tester.exchange(&text).len(), 1, "{text}");
        }
        lose(&mut tester, own);
        tester.wait(250);
    }
    // 2102h does not follow a contention.
    let reply = tester.exchange("18EF8221#4002210000000000");
    assert_eq!(reply, ["18EF2182#4F02210080000000"]);
}

#[test]
fn questions_during_the_silence_do_not_extend_it() {
    for text in questions(0x80)
        .into_iter()
        .chain(["18EAFFFE#00EE00", "18EA80FE#00EE00"].map(String::from))
    {
        let answers: &[&str] = if text.contains("#00EE") {
            &[CLAIM]
        } else {
            &[]
        };
        for before in [0, 100, 249] {
            let mut tester = with(&[]);
            tester.wait(before);
            tester.sent();
            assert_eq!(tester.exchange(&text), answers, "{text}");
            assert_eq!(tester.wait_text(249 - before), []);
            assert_eq!(tester.wait_text(1), [(1, NO_CODES.to_string())]);
        }
    }
}

#[test]
fn node_without_an_address_answers_only_requests_for_the_claim() {
    // The address is lost after the silence, and within it.
    for before in [250, 100] {
        let mut tester = with(&[FIXED]);
        tester.wait(before);
        assert_eq!(lose(&mut tester, 0x80), None);
        assert_eq!(tester.wait_text(5000).len(), 1);
        for text in ["18EAFF21#00EE00", "18EAFEFE#00EE00", "18EAFFFE#00EE00"] {
            assert_eq!(tester.exchange(text), [""; 0]);
            let sent = tester.wait_text(2000);
            assert!(sent.len() == 1 && sent[0].1 == CANNOT_CLAIM, "{sent:?}");
        }
        let own = [0x80, 0xFE].into_iter().flat_map(questions);
        // 254 asked for the claim is above; 80h is the address of another node.
        let others = own.filter(|text| text != "18EAFE21#00EE00");
        let to_all = ["29F000", "CAFE00", "EBFE00", "EEFE00"].map(|pgn| format!("18EAFF21#{pgn}"));
        let claims = [LOWER, HIGHER].map(|name| format!("18EEFF80#{name}"));
        for text in others.chain(to_all).chain(claims) {
            assert_eq!(tester.exchange(&text), [""; 0], "{text}");
            assert_eq!(tester.wait_text(200), [], "{text}");
        }
        tester.power_cycle();
        assert_eq!(tester.sent_text(), [CLAIM.replace("0080", "0000")]);
    }
}
