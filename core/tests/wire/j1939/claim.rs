//! Address claim of the IMS360 (SAE J1939-81): start, contention, cannot claim, Commanded Address.

use crate::tester::ims360::booted;
use crate::tester::j1939::{CLAIM, LOWER, NAME, NO_CODES, claimed, claimed_with, select, with};
use crate::tester::leds;
use plumbline::can::extended;
use plumbline::node::{BusEvent, Leds, Node};

/// A NAME that is higher than ours.
const HIGHER: &str = "FFFFFFFFFFFFFFFF";

const SSI2: &str = "0CF02980#00007D00007D33FF";

#[test]
fn traffic_begins_250_ms_after_the_claim() {
    let mut tester = with(&[]);
    let expected = [(0, CLAIM), (250, NO_CODES), (260, SSI2), (270, SSI2)];
    let expected = expected.map(|(at, text)| (at, text.to_string()));
    assert_eq!(tester.wait_text(270), expected);
}

#[test]
fn silence_begins_when_the_claim_is_sent() {
    let mut tester = with(&[]);
    tester.acknowledged = false;
    assert_eq!(tester.sent_text(), [CLAIM]);
    assert_eq!(tester.wait_text(5000), [], "nobody acknowledges");
    tester.acknowledged = true;
    tester.node.sent(tester.now);
    tester.sample();
    assert_eq!(tester.wait_text(249), []);
    assert_eq!(tester.wait_text(1), [(1, NO_CODES.to_string())]);
}

#[test]
fn only_requests_for_the_claim_are_answered_before() {
    let mut tester = with(&[]);
    assert_eq!(tester.sent_text(), [CLAIM]);
    assert_eq!(tester.request_group("FF", "00EE00"), [CLAIM]);
    assert_eq!(tester.request_group("80", "00EE00"), [CLAIM]);
    for (destination, pgn) in [("FF", "29F000"), ("80", "EBFE00"), ("80", "EEFE00")] {
        assert_eq!(tester.request_group(destination, pgn), [""; 0]);
    }
    assert_eq!(tester.exchange("18EF8021#4000100000000000"), [""; 0]);
    assert_eq!(tester.exchange("1CEC8021#10090002FFD8FE00"), [""; 0]);
}

#[test]
fn request_is_answered_by_the_claim_that_waits() {
    let mut tester = with(&[]);
    tester.acknowledged = false;
    assert_eq!(tester.sent_text(), [CLAIM]);
    // The claim is still in the mailbox.
    for request in ["18EAFFFE#00EE00", "18EA8021#00EE00"] {
        assert_eq!(tester.exchange(request), [""; 0], "{request}");
    }
    tester.acknowledged = true;
    tester.node.sent(tester.now);
    tester.sample();
    assert_eq!(tester.wait_text(249), []);
    assert_eq!(tester.wait_text(1), [(1, NO_CODES.to_string())]);
}

#[test]
fn address_is_kept_against_a_higher_name() {
    let mut tester = claimed();
    assert_eq!(tester.exchange(&format!("18EEFF80#{HIGHER}")), [CLAIM]);
    assert_eq!(tester.request_group("80", "29F000"), [SSI2]);
    // While claiming, the silence begins again.
    let mut tester = with(&[]);
    tester.wait(200);
    assert_eq!(tester.exchange(&format!("18EEFF80#{HIGHER}")), [CLAIM]);
    assert_eq!(tester.wait_text(249), []);
    assert_eq!(tester.wait_text(1), [(1, NO_CODES.to_string())]);
}

#[test]
fn lower_name_takes_the_address() {
    let mut tester = with(&[]);
    tester.wait(1000);
    tester.exchange(&format!("18EEFF81#{HIGHER}"));
    // Answers that are queued are not sent from the old address.
    tester.send("18EA8021#29F000");
    tester.send("18EA8021#CAFE00");
    tester.send("18EF8021#4000100000000000");
    let sent = tester.exchange(&format!("18EEFF80#{LOWER}"));
    assert_eq!(sent, [format!("18EEFF82#{NAME}")]);
    assert_eq!(tester.wait_text(249), []);
    let sent = tester.wait_text(11);
    assert_eq!(sent[0].1, "18FECA82#00FF00000000FFFF");
    assert_eq!(sent[1].1, SSI2.replace("2980", "2982"));
    // The next start begins with the preferred address.
    tester.power_cycle();
    assert_eq!(tester.sent_text(), [CLAIM]);
}

#[test]
fn own_name_at_the_own_address_is_ignored() {
    let mut tester = claimed();
    assert_eq!(tester.exchange(CLAIM), [""; 0]);
}

#[test]
fn fixed_address_is_lost_with_one_message() {
    let lost = "18EEFFFE#0102E3FF00910000";
    let mut tester = with(&[(0x2106, 1, 1, 0), (0x2102, 0, 1, 0x21)]);
    assert_eq!(tester.sent_text(), ["18EEFF21#0102E3FF00910000"]);
    assert_eq!(tester.exchange(&format!("18EEFF21#{LOWER}")), [""; 0]);
    let sent = tester.wait_text(5000);
    assert_eq!(sent.len(), 1, "{sent:?}");
    assert!(sent[0].0 <= 153 && sent[0].1 == lost, "{sent:?}");
    for destination in ["FF", "FE"] {
        assert_eq!(tester.request_group(destination, "00EE00"), [""; 0]);
        assert_eq!(tester.request_group(destination, "00EE00"), [""; 0]);
        let sent = tester.wait_text(200);
        assert_eq!(sent.len(), 1, "{sent:?}");
        assert_eq!(sent[0].1, lost);
    }
    assert_eq!(tester.request_group("FE", "EEFE00"), [""; 0]);
    assert_eq!(tester.exchange("18EFFE21#4000100000000000"), [""; 0]);
}

#[test]
fn commanded_address_is_claimed() {
    let mut tester = claimed();
    let claim = format!("18EEFFA0#{NAME}");
    assert_eq!(tester.command_address(HIGHER), [""; 0]);
    assert_eq!(tester.command_address(NAME), [claim.as_str()]);
    assert_eq!(tester.wait_text(249), []);
    tester.wait(1);
    let reply = tester.exchange("18EFA021#4002210000000000");
    assert_eq!(reply, ["18EF21A0#4F022100A0000000"]);
    // It is not stored.
    tester.power_cycle();
    assert_eq!(tester.sent_text(), [CLAIM]);
    // Also without an address.
    let mut tester = with(&[(0x2106, 1, 1, 0)]);
    tester.send(&format!("18EEFF80#{LOWER}"));
    tester.wait(200);
    let name = "0102E3FF00910000";
    assert_eq!(tester.command_address(name), [format!("18EEFFA0#{name}")]);
}

#[test]
fn commanded_address_to_us_is_acknowledged() {
    let mut tester = claimed();
    let sent = tester.exchange("1CEC8021#1009000201D8FE00");
    assert_eq!(sent, ["1CEC2180#110101FFFFD8FE00"]);
    let sent = tester.exchange("1CEB8021#010102E3FF009100");
    assert_eq!(sent, ["1CEC2180#110102FFFFD8FE00"]);
    let sent = tester.exchange("1CEB8021#0280A0FFFFFFFFFF");
    assert_eq!(
        sent,
        ["1CEC2180#13090002FFD8FE00", "18EEFFA0#0102E3FF00910080"]
    );
}

#[test]
fn run_led_shows_the_address() {
    let run = |leds: Leds| leds.run;
    let mut tester = with(&[]);
    tester.wait(1);
    assert!(run(tester.leds));
    tester.wait(210);
    assert!(!run(tester.leds), "blinking while claiming");
    tester.wait(40);
    for _ in 0..30 {
        assert!(run(tester.leds));
        tester.wait(100);
    }
    let mut tester = claimed_with(&[(0x2106, 1, 1, 0)]);
    tester.send(&format!("18EEFF80#{LOWER}"));
    tester.wait(100);
    assert!(run(tester.leds));
    tester.wait(200);
    assert!(!run(tester.leds), "single flash");
    tester.wait(500);
    assert!(!run(tester.leds));
}

#[test]
fn leds_do_not_show_the_state_of_canopen() {
    let mut prepared = claimed();
    // The LEDs flicker in the configuration state of LSS.
    let mut configured = booted();
    configured.write(0x2104, 1, 2, 0).unwrap();
    select(&mut configured);
    configured.exchange("7E5#0401000000000000");
    configured.wait(200);
    assert_eq!(configured.exchange("000#8132"), [CLAIM]);
    configured.wait(250);
    for tester in [&mut prepared, &mut configured] {
        // The heartbeat changes what CANopen guards.
        let reply = tester.parameter("2B171000E8030000");
        assert_eq!(reply, "6017100000000000");
        for _ in 0..50 {
            tester.wait(30);
            assert_eq!(tester.leds, leds(true, false));
        }
    }
}

#[test]
fn filters_accept_the_frames_that_the_node_uses() {
    let tester = claimed();
    let accepts = |id: u32| tester.accepts(extended(id));
    for id in [
        0x18EA_FF21,
        0x18EA_8021,
        0x00EA_8000,
        0x18EE_FF21,
        0x1CEC_FF21,
        0x1CEC_8021,
        0x1CEB_FF21,
        0x1CEB_8021,
        0x18EF_8021,
    ] {
        assert!(accepts(id), "{id:08X}");
    }
    for id in [
        0x18EA_8121,
        0x18EC_8121,
        0x18EF_8121,
        0x18EF_FF21,
        0x18FE_CA00,
        0x0CF0_0400,
        0x18E8_FF21,
        0x1AEF_8021,
        0x19EF_8021,
    ] {
        assert!(!accepts(id), "{id:08X}");
    }
    assert!(!tester.accepts(plumbline::can::standard(0x632)));
}

#[test]
fn filters_follow_the_address() {
    let mut tester = claimed();
    tester.exchange(&format!("18EEFF80#{LOWER}"));
    for (address, accepted) in [(0x80, false), (0x81, true), (0xFE, false)] {
        for format in [0x18EA, 0x18EF, 0x1CEC, 0x1CEB] {
            let id = format << 16 | address << 8 | 0x21;
            assert_eq!(tester.accepts(extended(id)), accepted, "{id:08X}");
        }
    }
}

/// Another node claims the same address at the same time.
#[test]
fn claim_that_ended_in_an_error_follows_after_a_random_delay() {
    let mut tester = with(&[]);
    tester.acknowledged = false;
    assert!(tester.node.sends_once());
    assert_eq!(tester.sent_text(), [CLAIM]);
    tester.bus(BusEvent::Unsent);
    assert!(!tester.node.sends_once());
    tester.acknowledged = true;
    let sent = tester.wait_text(450);
    assert!(sent[0].0 <= 153 && sent[0].1 == CLAIM, "{sent:?}");
    let silence = sent[0].0 + 250;
    assert_eq!(
        sent[1],
        (silence, NO_CODES.to_string()),
        "after the claim that was sent"
    );
    assert!(
        !tester.node.sends_once(),
        "the controller repeats all other frames"
    );
}
