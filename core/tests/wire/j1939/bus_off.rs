//! Bus-off of the IMS360 in J1939: what follows its recovery, and a restart without recovery.

use crate::tester::ims360::{Ims360Tester, booted};
use crate::tester::j1939::{CLAIM, LOWER, NAME, NO_CODES, claimed, claimed_with, with};
use crate::tester::leds;
use plumbline::can::BitRate;
use plumbline::node::{Action, BusEvent, BusMode, BusState, Node};

const BUS_OFF: BusEvent = BusEvent::State(BusState::BusOff);
const ACTIVE: BusEvent = BusEvent::State(BusState::Active);

/// 2010h:01 = 1.
const RESTART: &str = "2F10200101000000";

/// The number of requests to take part in the bus.
fn joined(tester: &Ims360Tester) -> usize {
    let online = Action::Bus(BusMode::Normal, BitRate::K125);
    let actions = tester.actions.iter();
    actions.filter(|action| **action == online).count()
}

#[test]
fn address_is_claimed_again() {
    let mut tester = claimed();
    tester.bus(BUS_OFF);
    assert_eq!(tester.wait_text(2000), []);
    tester.bus(ACTIVE);
    assert_eq!(tester.sent_text(), [CLAIM]);
    assert_eq!(tester.wait_text(249), []);
    assert_eq!(tester.wait_text(1), [(1, NO_CODES.to_string())]);
}

#[test]
fn commanded_address_is_claimed_if_its_claim_was_not_sent() {
    let mut tester = claimed();
    let claim = format!("18EEFFA0#{NAME}");
    tester.acknowledged = false;
    assert_eq!(tester.command_address(NAME), [claim.as_str()]);
    tester.bus(BUS_OFF);
    assert_eq!(tester.wait_text(2000), []);
    tester.bus(ACTIVE);
    tester.acknowledged = true;
    assert_eq!(tester.sent_text(), [claim.as_str()]);
    assert_eq!(tester.wait_text(249), []);
    let codes = NO_CODES.replace("CA80", "CAA0");
    assert_eq!(tester.wait_text(1), [(1, codes)]);
}

#[test]
fn cannot_claim_message_is_sent_once_after_bus_off_recovery() {
    let lost = "18EEFFFE#0102E3FF00910000";
    for is_built in [false, true] {
        let mut tester = with(&[(0x2106, 1, 1, 0)]);
        tester.sent();
        tester.acknowledged = false;
        assert_eq!(tester.exchange(&format!("18EEFF80#{LOWER}")), [""; 0]);
        if is_built {
            // It waits in the mailbox.
            let sent = tester.wait_text(153);
            assert_eq!(sent.len(), 1, "{sent:?}");
            assert_eq!(sent[0].1, lost);
        }
        tester.bus(BUS_OFF);
        tester.node.sent(tester.now);
        assert_eq!(tester.wait_text(2000), []);
        tester.bus(ACTIVE);
        tester.acknowledged = true;
        let sent = tester.wait_text(5000);
        assert_eq!(sent.len(), 1, "{sent:?}");
        assert!(sent[0].0 <= 153 && sent[0].1 == lost, "{sent:?}");
        // It was sent: nothing follows the next one.
        tester.bus(BUS_OFF);
        tester.bus(ACTIVE);
        assert_eq!(tester.wait_text(5000), []);
    }
}

#[test]
fn error_led_shows_warning_limit() {
    let mut tester = claimed();
    let lit = |tester: &mut Ims360Tester| {
        let steps = (0..30).filter(|_| {
            tester.wait(40);
            assert!(tester.leds.run);
            tester.leds.error
        });
        steps.count()
    };
    assert_eq!(lit(&mut tester), 0);
    for state in [BusState::Warning, BusState::Passive] {
        tester.bus(BusEvent::State(state));
        assert_eq!(lit(&mut tester), 5, "single flash: 200 of 1200 ms");
    }
    tester.bus(ACTIVE);
    assert_eq!(lit(&mut tester), 0);
}

#[test]
fn node_without_recovery_is_silent_until_a_restart() {
    let mut tester = claimed_with(&[(0x3100, 2, 1, 0)]);
    tester.actions.clear();
    tester.bus(BUS_OFF);
    assert_eq!(tester.wait_text(10_000), []);
    tester.bus(ACTIVE);
    assert_eq!(tester.wait_text(10_000), []);
    assert_eq!(joined(&tester), 0);
    tester.power_cycle();
    assert_eq!(tester.sent_text(), [CLAIM]);
}

/// Bus-off between the answer to 2010h:01 and its restart. Returns the frames of the next 100 ms.
fn restarted_in_bus_off(tester: &mut Ims360Tester) -> Vec<(u64, String)> {
    tester.actions.clear();
    tester.bus(BUS_OFF);
    tester.wait(1);
    assert_eq!(tester.leds, leds(tester.leds.run, true));
    let sent = tester.wait_text(99);
    assert_eq!(joined(tester), 1);
    assert!(tester.actions.contains(&Action::Recover));
    tester.wait(1);
    assert!(!tester.leds.error);
    sent
}

#[test]
fn restart_leaves_bus_off_without_recovery() {
    let mut tester = claimed_with(&[(0x3100, 2, 1, 0)]);
    assert_eq!(tester.parameter(RESTART), "6010200100000000");
    let sent = restarted_in_bus_off(&mut tester);
    assert_eq!(sent, [(99, CLAIM.to_string())]);
    tester.bus(ACTIVE);
    assert_eq!(tester.wait_text(248), []);
    assert_eq!(tester.wait_text(1), [(1, NO_CODES.to_string())]);
    // The next bus-off is final again.
    tester.bus(BUS_OFF);
    assert_eq!(tester.wait_text(10_000), []);
}

#[test]
fn restart_in_canopen_leaves_bus_off_without_recovery() {
    let boot_up = [(99, "732#00".to_string())];
    let mut changed = claimed_with(&[(0x3100, 2, 1, 0)]);
    assert_eq!(changed.parameter("2F00310102000000"), "6000310100000000");
    assert_eq!(changed.parameter("2310100173617665"), "6010100100000000");
    assert_eq!(changed.parameter(RESTART), "6010200100000000");
    assert_eq!(restarted_in_bus_off(&mut changed), boot_up);
    let mut tester = booted();
    tester.write(0x3100, 2, 1, 0).unwrap();
    tester.write(0x1010, 1, 4, 0x6576_6173).unwrap();
    // Error passive comes before bus-off, and ends with it.
    tester.bus(BusEvent::State(BusState::Passive));
    tester.sent();
    assert_eq!(
        tester.exchange(&format!("632#{RESTART}")),
        ["5B2#6010200100000000"]
    );
    assert_eq!(restarted_in_bus_off(&mut tester), boot_up);
    tester.bus(ACTIVE);
    assert_eq!(tester.read(0x3100, 2), Ok(0));
    tester.bus(BUS_OFF);
    assert_eq!(tester.wait_text(10_000), []);
}
