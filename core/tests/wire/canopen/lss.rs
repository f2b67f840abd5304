//! Layer setting services (CiA 305) of a node with a node-ID: each service with its bytes, its states and its effect.

use crate::tester::canopen::{abort, write_request};
use crate::tester::gauge::{self, Gauge, booted};
use crate::tester::{SERIAL, Tester, leds};
use plumbline::can::BitRate;
use plumbline::node::{Action, BusEvent, BusMode, BusState, Node, ProductNode};
use plumbline::store::StoreError;

pub const CONFIGURATION: &str = "7E5#0401000000000000";
pub const WAITING: &str = "7E5#0400000000000000";
const NOTHING: [&str; 0] = [];
const STORE: &str = "7E5#1700000000000000";
const STORED: [&str; 1] = ["7E4#1700000000000000"];
const INQUIRE_NODE_ID: &str = "7E5#5E00000000000000";

/// A request with a number in bytes 1 to 4.
pub fn with_number(command: u8, number: u32) -> String {
    let [a, b, c, d] = number.to_le_bytes();
    format!("7E5#{command:02X}{a:02X}{b:02X}{c:02X}{d:02X}000000")
}

/// The identity of the node under test.
fn identity() -> [u32; 4] {
    let [vendor, product, revision] = gauge::IDENTITY;
    [vendor, product, revision, SERIAL]
}

/// A gauge in the configuration state.
fn configuring() -> Tester<Gauge> {
    let mut t = booted();
    assert_eq!(t.exchange(CONFIGURATION), NOTHING);
    t
}

fn configure_node_id(t: &mut Tester<Gauge>, node_id: u8) -> Vec<String> {
    t.exchange(&format!("7E5#11{node_id:02X}000000000000"))
}

#[test]
fn configuration_state_answers_inquiries_and_waiting_state_does_not() {
    let mut t = booted();
    let requests = [
        ("5A", "7E4#5A95010000000000"),
        ("5B", "7E4#5B9F860100000000"),
        ("5C", "7E4#5C01000200000000"),
        ("5D", "7E4#5D01020304000000"),
        ("5E", "7E4#5E32000000000000"),
    ];
    for (command, answer) in requests {
        let request = format!("7E5#{command}00000000000000");
        assert_eq!(t.exchange(&request), NOTHING, "waiting");
        t.send(CONFIGURATION);
        assert_eq!(t.exchange(&request), [answer]);
        t.send(WAITING);
        assert_eq!(t.exchange(&request), NOTHING, "waiting again");
    }
    // The identity is that of 1018h.
    for (sub, number) in (1..).zip(identity()) {
        assert_eq!(t.read(0x1018, sub), Ok(number));
    }
}

#[test]
fn selective_switch_with_own_identity_answers_and_enters_configuration() {
    let mut t = booted();
    let requests: Vec<_> = (0x40..).zip(identity()).collect();
    for &(command, number) in &requests[..3] {
        assert_eq!(t.exchange(&with_number(command, number)), NOTHING);
    }
    let last = with_number(0x43, SERIAL);
    assert_eq!(t.exchange(&last), ["7E4#4400000000000000"]);
    assert_eq!(t.exchange(INQUIRE_NODE_ID), ["7E4#5E32000000000000"]);
    // Not a service of the configuration state.
    for (command, number) in requests {
        assert_eq!(t.exchange(&with_number(command, number)), NOTHING);
    }
    assert_eq!(t.exchange(INQUIRE_NODE_ID).len(), 1);
}

#[test]
fn selective_switch_with_another_number_or_a_missing_frame_selects_nothing() {
    let requests = |numbers: [u32; 4]| (0x40..).zip(numbers).map(|(c, n)| with_number(c, n));
    for place in 0..4 {
        let mut t = booted();
        let mut numbers = identity();
        numbers[place] ^= 1 << 31;
        for request in requests(numbers) {
            assert_eq!(t.exchange(&request), NOTHING, "{request}");
        }
        for (_, request) in requests(identity())
            .enumerate()
            .filter(|&(at, _)| at != place)
        {
            assert_eq!(t.exchange(&request), NOTHING, "without {place}: {request}");
        }
        assert_eq!(t.exchange(INQUIRE_NODE_ID), NOTHING);
    }
}

#[test]
fn selective_switch_with_repeated_frames_answers_once() {
    let mut t = booted();
    let requests = (0x40..).zip(identity());
    let sent: Vec<_> = requests
        .flat_map(|(command, number)| [with_number(command, number), with_number(command, number)])
        .flat_map(|request| t.exchange(&request))
        .collect();
    assert_eq!(sent, ["7E4#4400000000000000"]);
}

#[test]
fn node_id_1_to_126_and_255_is_accepted_and_others_answer_error_1() {
    let mut t = configuring();
    for node_id in 0..=255_u8 {
        let error = u8::from(!matches!(node_id, 1..=126 | 255));
        let answer = format!("7E4#11{error:02X}000000000000");
        let before = t.read(0x2002, 0);
        assert_eq!(configure_node_id(&mut t, node_id), [answer], "{node_id}");
        let expected = if error == 0 {
            Ok(node_id.into())
        } else {
            before
        };
        assert_eq!(t.read(0x2002, 0), expected, "2002h is the pending node-ID");
    }
    assert_eq!(t.exchange(INQUIRE_NODE_ID), ["7E4#5E32000000000000"]);
    t.send(WAITING);
    assert_eq!(t.sent_text(), NOTHING, "the node has a valid node-ID");
    assert_eq!(configure_node_id(&mut t, 1), NOTHING, "waiting");
    assert_eq!(t.read(0x2002, 0), Ok(255));
}

#[test]
fn configured_node_id_acts_after_reset_communication_or_reset_node() {
    for reset in ["000#8232", "000#8132"] {
        let mut t = configuring();
        configure_node_id(&mut t, 0x21);
        t.send(WAITING);
        assert_eq!(t.sent_text(), NOTHING);
        assert_eq!(t.read(0x1000, 0), Ok(0x0001_019A), "present node-ID");
        assert_eq!(t.exchange(reset), ["721#00"]);
        t.node_id = 0x21;
        assert_eq!(t.read(0x2002, 0), Ok(0x21));
        t.power_cycle();
        assert_eq!(t.sent_text(), ["732#00"], "not stored");
    }
}

#[test]
fn sdo_cannot_write_node_id_255_and_other_node_ids_that_lss_refuses() {
    let mut t = booted();
    for node_id in [0, 127, 128, 254, 255] {
        assert_eq!(t.write(0x2002, 0, 1, node_id), Err(0x0609_0030));
        assert_eq!(t.read(0x2002, 0), Ok(50));
    }
    for node_id in [1, 126] {
        assert_eq!(t.write(0x2002, 0, 1, node_id), Ok(()));
    }
}

#[test]
fn bit_timing_takes_rates_of_product_in_table_0_and_refuses_others() {
    let mut t = configuring();
    let rates = [Some(1000), Some(800), Some(500), Some(250), Some(125)];
    for index in 0..=255_u8 {
        let before = t.read(0x2001, 0);
        let rate = rates.get(usize::from(index)).copied().flatten();
        let answer = format!("7E4#13{:02X}000000000000", u8::from(rate.is_none()));
        let request = format!("7E5#1300{index:02X}0000000000");
        assert_eq!(t.exchange(&request), [answer], "{index}");
        assert_eq!(t.read(0x2001, 0), rate.map_or(before, Ok), "{index}");
    }
    for table in [1, 0x80, 0xFF] {
        let request = format!("7E5#13{table:02X}020000000000");
        assert_eq!(t.exchange(&request), ["7E4#1301000000000000"]);
    }
    assert_eq!(t.read(0x2001, 0), Ok(125));
    t.send(WAITING);
    assert_eq!(t.exchange("7E5#1300020000000000"), NOTHING);
    assert_eq!(t.read(0x2001, 0), Ok(125));
}

/// The changes of mode and bit rate since the last call.
fn bus(t: &mut Tester<Gauge>) -> Vec<Action> {
    let actions = std::mem::take(&mut t.actions);
    let is_bus = |action: &Action| matches!(action, Action::Bus(..));
    actions.into_iter().filter(is_bus).collect()
}

#[test]
fn activated_bit_rate_acts_between_two_silent_delays() {
    let mut t = configuring();
    t.write(0x1017, 0, 2, 10).unwrap();
    t.write(0x1800, 2, 1, 254).unwrap();
    t.send("000#0100");
    t.exchange("7E5#1300020000000000");
    t.wait(20);
    bus(&mut t);
    assert_eq!(t.exchange("7E5#15C8000000000000"), NOTHING);
    let rate = [Action::Bus(BusMode::Normal, BitRate::K500)];
    for expected in [&[][..], &rate] {
        assert_eq!(t.wait(100), []);
        let read = "632#4000100000000000";
        for ignored in ["080#", read, "000#8232", "732#R1", WAITING, INQUIRE_NODE_ID] {
            assert_eq!(t.exchange(ignored), NOTHING);
        }
        assert_eq!(t.wait(99), []);
        assert_eq!(bus(&mut t), []);
        let sent = t.wait_text(1);
        assert_eq!(sent.is_empty(), expected.is_empty());
        if !expected.is_empty() {
            assert_eq!(sent, [(1, "732#00".to_string())]);
        }
        let now = bus(&mut t);
        assert_eq!(now, if expected.is_empty() { &rate[..] } else { &[] });
    }
    // A pre-operational node that is still in the configuration state.
    assert_eq!(t.exchange("732#R1"), ["732#7F"]);
    assert_eq!(t.exchange(INQUIRE_NODE_ID), ["7E4#5E32000000000000"]);
    assert_eq!(t.read(0x2001, 0), Ok(500));
}

#[test]
fn activated_bit_rate_without_delay_acts_at_once_and_node_id_follows() {
    let mut t = configuring();
    t.wait(1);
    configure_node_id(&mut t, 7);
    t.exchange("7E5#1300030000000000");
    bus(&mut t);
    assert_eq!(t.exchange("7E5#1500000000000000"), ["707#00"]);
    assert!(bus(&mut t).contains(&Action::Bus(BusMode::Normal, BitRate::K250)));
    // In the waiting state the service is not possible.
    t.send(WAITING);
    assert_eq!(t.exchange("7E5#1500000000000000"), NOTHING);
    assert_eq!(bus(&mut t), []);
}

#[test]
fn store_keeps_node_id_and_bit_rate_and_nothing_else() {
    let mut t = configuring();
    t.write(0x2101, 0, 1, 99).unwrap();
    configure_node_id(&mut t, 7);
    t.exchange("7E5#1300030000000000");
    assert_eq!(t.exchange(STORE), STORED);
    t.actions.clear();
    t.power_cycle();
    assert_eq!(t.sent_text(), ["707#00"]);
    assert_eq!(bus(&mut t), [Action::Bus(BusMode::Normal, BitRate::K250)]);
    t.node_id = 7;
    assert_eq!(t.read(0x2101, 0), Ok(24));
    assert_eq!(t.exchange(STORE), NOTHING, "waiting state after power-up");
}

#[test]
fn failed_store_answers_error_2() {
    let mut t = configuring();
    t.memory_works = Some(false);
    configure_node_id(&mut t, 7);
    let sent = t.exchange(STORE);
    assert_eq!(sent[0], "7E4#1702000000000000");
    t.memory_works = Some(true);
    assert_eq!(t.exchange(STORE)[0], STORED[0]);
}

#[test]
fn store_answers_after_its_save() {
    let mut t = configuring();
    t.memory_works = None;
    assert_eq!(t.exchange(STORE), NOTHING);
    assert_eq!(t.read(0x1000, 0), Ok(0x0001_019A), "SDO continues");
    let save = write_request(0x1010, 1, 4, 0x6576_6173);
    assert_eq!(t.sdo(&save), abort("101001", 0x0800_0022));
    t.finish_save(Ok(()));
    assert_eq!(t.sent_text(), STORED);
}

#[test]
fn store_during_save_of_sdo_waits_for_it() {
    let mut t = configuring();
    t.memory_works = None;
    let save = write_request(0x1010, 1, 4, 0x6576_6173);
    assert_eq!(t.exchange(&format!("632#{save}")), NOTHING);
    configure_node_id(&mut t, 7);
    assert_eq!(t.exchange(STORE), NOTHING);
    t.memory_works = Some(true);
    t.finish_save(Err(StoreError));
    let sent = t.sent_text();
    let failed = format!("5B2#{}", abort("101001", 0x0606_0000));
    assert_eq!(sent[..2], [failed, STORED[0].to_string()]);
    t.power_cycle();
    assert_eq!(t.sent_text(), ["707#00"]);
}

#[test]
fn reset_communication_cancels_answer_and_enters_waiting() {
    let mut t = configuring();
    t.memory_works = None;
    assert_eq!(t.exchange(STORE), NOTHING);
    assert_eq!(t.exchange("000#8232"), ["732#00"]);
    t.finish_save(Ok(()));
    assert_eq!(t.sent_text(), NOTHING);
    assert_eq!(t.exchange(INQUIRE_NODE_ID), NOTHING);
}

#[test]
fn identify_remote_slave_answers_within_limits_in_both_states() {
    let [vendor, product, revision, serial] = identity();
    let exact = [vendor, product, revision, revision, serial, serial];
    let wide = [vendor, product, 0, u32::MAX, 0, u32::MAX];
    let identify = |t: &mut Tester<Gauge>, numbers: [u32; 6]| -> Vec<String> {
        let requests = (0x46..).zip(numbers).map(|(c, n)| with_number(c, n));
        requests.flat_map(|request| t.exchange(&request)).collect()
    };
    let mut t = booted();
    for state in [WAITING, CONFIGURATION] {
        t.send(state);
        for numbers in [exact, wide] {
            assert_eq!(identify(&mut t, numbers), ["7E4#4F00000000000000"]);
        }
        for (place, number) in [
            (0, vendor + 1),
            (1, product - 1),
            (2, revision + 1),
            (3, revision - 1),
            (4, serial + 1),
            (5, serial - 1),
        ] {
            let mut numbers = exact;
            numbers[place] = number;
            assert_eq!(identify(&mut t, numbers), NOTHING, "{place}");
        }
        assert_eq!(
            t.exchange(INQUIRE_NODE_ID).len(),
            usize::from(state == CONFIGURATION)
        );
    }
    let last = with_number(0x4B, serial);
    assert_eq!(t.exchange(&last), NOTHING, "without the others");
}

#[test]
fn services_for_unconfigured_nodes_have_no_answer_while_a_node_id_is_valid() {
    let mut t = booted();
    let requests = ["7E5#4C00000000000000", "7E5#5100000000800000"];
    for request in requests {
        assert_eq!(t.exchange(request), NOTHING, "node-ID 50");
    }
    t.send(CONFIGURATION);
    configure_node_id(&mut t, 255);
    t.send(WAITING);
    for request in requests {
        assert_eq!(t.exchange(request), NOTHING, "255 is pending only");
    }
}

#[test]
fn unknown_command_other_length_or_remote_frame_has_no_effect() {
    let mut t = booted();
    for state in [WAITING, CONFIGURATION] {
        t.send(state);
        for command in 0..=255_u8 {
            let known = [0x04, 0x11, 0x13, 0x15, 0x17, 0x4C, 0x51];
            let ranges = matches!(command, 0x40..=0x43 | 0x46..=0x4B | 0x5A..=0x5E);
            if !known.contains(&command) && !ranges {
                let request = with_number(command, 1);
                assert_eq!(t.exchange(&request), NOTHING, "{request}");
            }
        }
        let answers = usize::from(state == CONFIGURATION);
        assert_eq!(t.exchange(INQUIRE_NODE_ID).len(), answers);
        for malformed in [
            "7E5#0400",
            "7E5#04010000000000",
            "7E5#R8",
            "7E5#5E",
            "7E5#0402000000000000",
            "000007E5#5E00000000000000",
            "7E4#5E00000000000000",
        ] {
            assert_eq!(t.exchange(malformed), NOTHING, "{malformed}");
        }
        assert_eq!(t.exchange(INQUIRE_NODE_ID).len(), answers);
    }
}

#[test]
fn lss_works_in_all_nmt_states() {
    for command in ["000#0132", "000#0232", "000#8032"] {
        let mut t = booted();
        t.send(command);
        t.send(CONFIGURATION);
        assert_eq!(t.exchange(INQUIRE_NODE_ID), ["7E4#5E32000000000000"]);
        assert_eq!(configure_node_id(&mut t, 7), ["7E4#1100000000000000"]);
        t.send(WAITING);
        let state = match command {
            "000#0132" => "732#05",
            "000#0232" => "732#04",
            _ => "732#7F",
        };
        assert_eq!(t.exchange("732#R1"), [state], "unchanged");
    }
}

#[test]
fn lss_between_segments_disturbs_neither_sdo_nor_pdo() {
    let mut t = booted();
    t.send("000#0132");
    assert_eq!(t.sdo("4008100000000000"), "410810000E000000");
    t.send(CONFIGURATION);
    assert_eq!(t.sdo("6000000000000000"), "0047617567652077");
    assert_eq!(t.exchange(INQUIRE_NODE_ID), ["7E4#5E32000000000000"]);
    assert_eq!(t.exchange("080#"), ["1B2#FEFF"]);
    assert_eq!(t.exchange(STORE), STORED);
    assert_eq!(
        t.sdo("7000000000000000"),
        "116974682050535300".replace("50535300", "4C5353")
    );
}

#[test]
fn leds_flicker_in_turn_in_configuration_state_and_bus_off_is_red() {
    let mut t = booted();
    t.send("000#0132");
    assert_eq!(t.leds, leds(true, false), "operational");
    t.send(CONFIGURATION);
    t.wait(60);
    for _ in 0..5 {
        assert_eq!(t.leds, leds(true, false));
        t.wait(50);
        assert_eq!(t.leds, leds(false, true));
        t.wait(50);
    }
    t.bus(BusEvent::State(BusState::Warning));
    t.wait(50);
    assert_eq!(t.leds, leds(false, true), "flickering comes before warning");
    t.bus(BusEvent::State(BusState::BusOff));
    for _ in 0..5 {
        assert!(t.leds.error, "bus-off comes before flickering");
        t.wait(50);
    }
    t.wait(17);
    t.bus(BusEvent::State(BusState::Active));
    t.sent();
    t.wait(55);
    for _ in 0..5 {
        assert_eq!(t.leds, leds(true, false));
        t.wait(50);
        assert_eq!(t.leds, leds(false, true));
        t.wait(50);
    }
    t.send(WAITING);
    assert_eq!(t.leds, leds(true, false), "operational");
}

#[test]
fn filters_accept_lss_requests() {
    let t = booted();
    let mut count = 0;
    t.node.filters(&mut |_| count += 1);
    assert_eq!((count, Gauge::FILTERS), (6, 6));
    assert!(t.accepts(plumbline::can::standard(0x7E5)));
}
