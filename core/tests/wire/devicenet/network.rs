//! DeviceNet: duplicate MAC ID check, MAC ID and bit rate, reset, bus-off.

use crate::tester::devicenet::{LevelTester, MAC_3, allocated, online, online_with, power_up};
use plumbline::can::{BitRate, extended, standard};
use plumbline::node::Node;
use plumbline::node::{Action, BusEvent, BusMode, BusState};

const REQUEST: &str = "41F#00620101020304";

/// The first byte of the stored parameters is the MAC ID, the second one is the code of the bit rate, the third one is BOI.
fn with_boi() -> LevelTester {
    online_with(&[3, 0, 1])
}

#[test]
fn factory_mac_id_is_63_and_bit_rate_125_kbit() {
    let mut tester = power_up(None);
    assert_eq!(tester.sent_text(), ["5FF#00620101020304"]);
    let bus = Action::Bus(BusMode::Normal, BitRate::K125);
    assert!(tester.actions.contains(&bus));
    assert_eq!(tester.wait_text(2000).len(), 1);
    assert_eq!(tester.exchange("5FE#0A4B0301030A"), ["5FB#0ACB00"]);
    assert_eq!(tester.exchange("5FC#0A0E030101"), ["5FB#0A8E3F"]);
    assert_eq!(tester.exchange("5FC#0A0E030102"), ["5FB#0A8E00"]);
    assert_eq!(tester.exchange("5FC#0A0E030103"), ["5FB#0A8E00"]);
    assert_eq!(tester.exchange("5FC#0A100502090000"), ["5FB#0A900000"]);
    assert_eq!(tester.exchange("5FD#"), ["3FF#00000000"]);
}

#[test]
fn filters_pass_exactly_the_messages_to_the_own_mac_id() {
    let tester = online();
    for id in 0..0x800 {
        let own = matches!(id, 0x41A | 0x41C..=0x41F);
        assert_eq!(tester.accepts(standard(id)), own, "{id:03X}");
        assert!(!tester.accepts(extended(id.into())));
    }
}

#[test]
fn lone_node_stays_pending_and_counts_from_the_acknowledge() {
    let mut tester = power_up(Some(MAC_3));
    tester.acknowledged = false;
    assert_eq!(tester.wait_text(10_000), [(0, REQUEST.into())]);
    assert!(
        !tester.node.sends_once(),
        "the controller repeats the request"
    );
    // Another node appears and acknowledges the request.
    tester.acknowledged = true;
    tester.acknowledge();
    assert_eq!(tester.wait_text(999), []);
    tester.acknowledged = false;
    assert_eq!(tester.wait_text(5000), [(1, REQUEST.into())]);
    tester.acknowledged = true;
    tester.acknowledge();
    assert_eq!(tester.wait_text(999), []);
    tester.ignores("41E#0A4C030101");
    assert_eq!(tester.wait_text(1), []);
    assert!(!tester.owner());
}

#[test]
fn message_for_own_mac_id_during_the_check_silences_the_node() {
    for message in ["41F#00620102020304", "41F#80990001000000"] {
        for wait in [0, 500, 1500, 1999] {
            let mut tester = power_up(Some(MAC_3));
            tester.wait(wait);
            tester.ignores(message);
            assert!(tester.leds.error && !tester.leds.run || wait < 1000);
            assert_eq!(tester.wait_text(5000), []);
            for text in [message, "41E#0A4B0301010A", "41F#00620102020304"] {
                tester.ignores(text);
            }
            assert!(tester.leds.error && !tester.leds.run);
            tester.power_cycle();
            assert_eq!(tester.sent_text(), [REQUEST]);
        }
    }
}

#[test]
fn other_mac_ids_and_malformed_messages_do_not_disturb_the_check() {
    let mut tester = power_up(Some(MAC_3));
    tester.sent();
    for text in [
        "417#00620102020304",
        "427#80620102020304",
        "41F#",
        "41F#80",
        "41F#R7",
        "0000041F#80620102020304",
        "603#80620102020304",
    ] {
        tester.ignores(text);
    }
    assert_eq!(tester.wait_text(2000), [(1000, REQUEST.into())]);
    assert!(!tester.owner());
}

#[test]
fn online_node_answers_a_request_and_goes_on() {
    let mut tester = allocated(2);
    tester.set_rate(2, 0);
    let response = "41F#80620101020304";
    assert_eq!(tester.exchange("41F#00620102020304"), [response]);
    assert_eq!(tester.exchange("41F#05990000000000"), [response]);
    assert_eq!(tester.exchange("41D#"), ["3C3#D204C9FD"]);
}

#[test]
fn response_silences_the_online_node() {
    let mut tester = allocated(0x52);
    tester.set_rate(2, 0);
    tester.ignores("41F#80620102020304");
    tester.force_milli(0, 0);
    assert_eq!(tester.wait_text(20_000), []);
    for text in [
        "41D#",
        "41C#0A0E030101",
        "41E#0A4B0301010A",
        "41F#00620102020304",
    ] {
        tester.ignores(text);
    }
    assert!(tester.leds.error && !tester.leds.run);
}

#[test]
fn changed_mac_id_is_answered_on_the_old_one_stored_and_checked() {
    let mut tester = allocated(0x52);
    tester.set_rate(2, 0);
    let request = "42F#00620101020304";
    let sent = tester.exchange("41C#0A1003010105");
    assert_eq!(sent, ["41B#0A90", request]);
    assert!(tester.accepts(standard(0x42F)) && !tester.accepts(standard(0x41F)));
    assert_eq!(tester.wait_text(1999), [(1000, request.into())]);
    for text in ["41D#", "42D#", "41C#0A0E030101", "42E#0A4C030101"] {
        tester.ignores(text);
    }
    tester.wait(1);
    assert_eq!(tester.exchange("42E#0A4C030101"), ["42B#0A940B02"]);
    tester.ignores("41E#0A4C030101");
    assert_eq!(tester.memory.as_ref().unwrap()[0], 5);
    tester.power_cycle();
    assert_eq!(tester.sent_text(), [request]);
}

#[test]
fn changed_mac_id_is_checked_250_ms_later_if_nobody_acknowledges_the_answer() {
    let mut tester = allocated(2);
    tester.set_rate(2, 0);
    tester.acknowledged = false;
    assert_eq!(tester.explicit("1003010105"), "90");
    for text in [
        "41D#",
        "41E#0A4C030101",
        "41C#0A0E030101",
        "41F#00620102020304",
    ] {
        tester.ignores(text);
    }
    assert_eq!(tester.wait_text(249), []);
    let request = "42F#00620101020304";
    assert_eq!(tester.wait_text(1), [(1, request.into())]);
}

#[test]
fn same_mac_id_keeps_the_connections() {
    let mut tester = allocated(0);
    assert_eq!(tester.explicit("1003010103"), "90");
    assert_eq!(tester.wait_text(2000), []);
    assert_eq!(tester.explicit("0E030101"), "8E03");
}

#[test]
fn reset_type_0_answers_stores_and_restarts() {
    for body in ["050101", "05010100"] {
        let mut tester = allocated(2);
        tester.set_rate(2, 0);
        assert_eq!(tester.explicit("106501712C01"), "90");
        tester.actions.clear();
        tester.receive(crate::tester::canopen::frame(&format!("41C#0A{body}")));
        assert!(
            !tester.actions.contains(&Action::Restart),
            "before the answer"
        );
        assert_eq!(tester.sent_text(), ["41B#0A85"]);
        assert!(matches!(
            &tester.actions[..],
            [Action::Save, .., Action::Restart]
        ));
        assert_eq!(tester.wait_text(1000), []);
        tester.power_cycle();
        assert_eq!(tester.wait_text(2001).len(), 2);
        tester.allocate(1);
        assert_eq!(tester.explicit("0E650171"), "8E2C01");
    }
}

#[test]
fn reset_type_1_stores_factory_values() {
    let mut tester = online_with(&[3, 2, 1, 101]);
    tester.allocate(1);
    assert_eq!(tester.explicit("05010101"), "85");
    tester.wait(500);
    assert_eq!(tester.actions.last(), Some(&Action::Restart));
    tester.power_cycle();
    assert_eq!(tester.sent_text(), ["5FF#00620101020304"]);
    let bus = Action::Bus(BusMode::Normal, BitRate::K125);
    assert!(tester.actions.contains(&bus));
    tester.wait(2001);
    assert_eq!(tester.exchange("5FE#0A4B0301010A"), ["5FB#0ACB00"]);
    assert_eq!(tester.exchange("5FC#0A0E030103"), ["5FB#0A8E00"]);
    assert_eq!(tester.exchange("5FC#0A0E650181"), ["5FB#0A8E67"]);
}

#[test]
fn reset_waits_for_the_running_save_and_stores_the_rest() {
    let mut tester = allocated(0);
    tester.memory_works = None;
    assert_eq!(tester.explicit("106501712C01"), "90");
    tester.wait(400);
    assert_eq!(tester.explicit("106501732C00"), "90");
    assert_eq!(tester.explicit("050101"), "85");
    for text in ["41E#0A4C030101", "41C#0A0E030101", "41F#00620102020304"] {
        tester.ignores(text);
    }
    assert_eq!(tester.wait_text(100), []);
    assert!(!tester.actions.contains(&Action::Restart));
    tester.memory_works = Some(true);
    tester.finish_save(Ok(()));
    assert!(tester.actions.contains(&Action::Restart));
    tester.power_cycle();
    tester.wait(2001);
    tester.allocate(1);
    assert_eq!(tester.explicit("0E650173"), "8E2C00");
}

/// Whether the node requests a new mode of the CAN controller or its recovery. Both end bus-off.
fn ends_bus_off(tester: &LevelTester) -> bool {
    let ends = |action: &Action| matches!(action, Action::Bus(..) | Action::Recover);
    tester.actions.iter().any(ends)
}

#[test]
fn bus_off_without_boi_silences_the_node() {
    let mut tester = allocated(2);
    tester.set_rate(2, 0);
    tester.actions.clear();
    tester.bus(BusEvent::State(BusState::BusOff));
    assert!(tester.leds.error && !tester.leds.run);
    assert_eq!(tester.wait_text(1000), []);
    assert!(!ends_bus_off(&tester), "{:?}", tester.actions);
    tester.bus(BusEvent::State(BusState::Active));
    assert_eq!(tester.wait_text(5000), []);
    tester.ignores("41D#");
    tester.ignores("41E#0A4C030101");
    assert!(!ends_bus_off(&tester), "{:?}", tester.actions);
}

#[test]
fn bus_off_without_boi_ends_the_change_of_the_mac_id() {
    let mut tester = allocated(0);
    tester.acknowledged = false;
    assert_eq!(tester.explicit("1003010105"), "90");
    tester.actions.clear();
    tester.bus(BusEvent::State(BusState::BusOff));
    assert_eq!(tester.wait_text(1000), []);
    assert!(!ends_bus_off(&tester), "{:?}", tester.actions);
    assert!(tester.leds.error && !tester.leds.run);
    assert_eq!(tester.memory.as_ref().unwrap()[0], 5);
}

#[test]
fn bus_off_with_boi_checks_the_mac_id_again_and_is_counted() {
    let mut tester = with_boi();
    for count in ["01", "02"] {
        tester.allocate(3);
        tester.set_rate(2, 0);
        tester.bus(BusEvent::State(BusState::BusOff));
        assert_eq!(tester.actions.last(), Some(&Action::Recover));
        assert_eq!(tester.wait_text(10), []);
        tester.bus(BusEvent::State(BusState::Active));
        let sent = tester.wait_text(2001);
        assert_eq!(sent, [(0, REQUEST.into()), (1000, REQUEST.into())]);
        assert!(!tester.owner());
        tester.allocate(1);
        assert_eq!(tester.explicit("0E030104"), format!("8E{count}"));
        tester.exchange("41E#0A4C030101");
    }
    tester.allocate(1);
    assert_eq!(tester.explicit("10030104AA"), "90");
    assert_eq!(tester.explicit("0E030104"), "8E00");
}

#[test]
fn warning_and_passive_are_no_faults() {
    let mut tester = allocated(2);
    tester.set_rate(2, 0);
    for state in [BusState::Warning, BusState::Passive, BusState::Active] {
        tester.bus(BusEvent::State(state));
        assert_eq!(tester.exchange("41D#"), ["3C3#D204C9FD"]);
    }
    assert_eq!(tester.explicit("0E030104"), "8E00");
}
