//! Saves of the JN2101: replies while a save is running, aborts of the client, interrupted and unnecessary saves.

use crate::tester::canopen::*;
use plumbline::node::{Action, Boot, Node};
use plumbline::store::StoreError;

const LOAD: u32 = 0x6461_6F6C;
const SAVE: &str = "60A#2310100173617665";
const SAVED: &str = "58A#6010100100000000";

/// The number of saves since the start, or since the actions were cleared.
fn saves(t: &Jn2101Tester) -> usize {
    let is_save = |action: &&Action| **action == Action::Save;
    t.actions.iter().filter(is_save).count()
}

#[test]
fn save_is_answered_at_its_end_and_other_requests_at_once() {
    let mut t = operational();
    t.memory_works = None;
    assert_eq!(t.exchange("60A#2310100173617665"), [""; 0]);
    assert_eq!(t.exchange("080#").len(), 2);
    assert_eq!(t.exchange("70A#R1"), ["70A#05"]);
    assert_eq!(t.exchange("60A#4000100000000000"), ["58A#430010009A010400"]);
    assert_eq!(t.exchange("60A#4008100000000000").len(), 1);
    assert_eq!(t.exchange("000#800A"), [""; 0]);
    assert_eq!(t.exchange("70A#R1"), ["70A#FF"]);
    // A value that is not in force.
    assert_eq!(t.write(0x1017, 0, 2, 60_000), Ok(()));
    assert_eq!(t.read(0x1017, 0), Ok(60_000));
    assert!(t.node.ready());
    t.finish_save(Ok(()));
    assert_eq!(t.sent_text(), ["58A#6010100100000000"]);
}

#[test]
fn heartbeat_and_event_timer_continue_during_a_save() {
    let mut t = booted();
    t.memory_works = None;
    t.write(0x1017, 0, 2, 20).unwrap();
    t.write(0x1800, 5, 2, 30).unwrap();
    t.write(0x1800, 2, 1, 254).unwrap();
    t.send("000#010A");
    assert_eq!(t.exchange(SAVE), [""; 0]);
    let mut expected: Vec<_> = (1..=5).map(|n| (20 * n, "70A#05".to_string())).collect();
    expected.extend((1..=3).map(|n| (30 * n, "18A#00000000".to_string())));
    expected.sort();
    let mut sent = t.wait_text(100);
    sent.sort();
    assert_eq!(sent, expected);
    t.finish_save(Ok(()));
    assert_eq!(t.sent_text(), [SAVED]);
}

#[test]
fn write_that_needs_a_save_is_refused_during_a_save() {
    let mut t = booted();
    t.memory_works = None;
    assert_eq!(t.exchange("60A#2310100173617665"), [""; 0]);
    let refused = Err(0x0800_0022);
    assert_eq!(t.write(0x1010, 1, 4, 0x6576_6173), refused);
    assert_eq!(t.write(0x1011, 1, 4, LOAD), refused);
    assert_eq!(t.write(0x207F, 0, 1, 1), refused);
    t.tilt(10.0, 0.0);
    // Zero point: the angle does not change.
    assert_eq!(t.write(0x2046, 0, 1, 1), refused);
    assert_eq!(t.read(0x2046, 0), Ok(2));
    assert_eq!(t.read_i32(0x6110), 1000);
    t.finish_save(Ok(()));
    assert_eq!(t.sent_text(), ["58A#6010100100000000"]);
}

#[test]
fn reset_during_a_save_is_performed_at_once_with_the_saved_parameters() {
    for reset in ["000#810A", "000#820A"] {
        let mut t = booted();
        t.memory_works = None;
        t.write(0x1F80, 0, 4, 8).unwrap();
        assert_eq!(t.exchange("60A#2310100173617665"), [""; 0]);
        assert_eq!(t.exchange(reset), ["70A#00"]);
        assert_eq!(t.read(0x1F80, 0), Ok(8), "{reset}");
        assert_eq!(t.exchange("70A#R1"), ["70A#05"], "{reset}");
        t.finish_save(Ok(()));
        assert_eq!(t.sent_text(), [""; 0], "the reset has ended the transfer");
        assert_eq!(t.exchange(reset), ["70A#00"]);
        assert_eq!(t.exchange("70A#R1"), ["70A#05"], "{reset}");
    }
}

#[test]
fn failed_save_is_undone_by_the_next_reset_also_after_a_reset_during_the_save() {
    let mut t = booted();
    t.memory_works = None;
    t.write(0x1F80, 0, 4, 8).unwrap();
    assert_eq!(t.exchange("60A#2310100173617665"), [""; 0]);
    assert_eq!(t.exchange("000#810A"), ["70A#00"]);
    t.finish_save(Err(StoreError));
    t.sent_text();
    assert_eq!(t.read(0x1F80, 0), Ok(8));
    t.exchange("000#810A");
    assert_eq!(t.read(0x1F80, 0), Ok(0), "the stored value");
}

#[test]
fn write_during_factory_reset_is_refused() {
    let mut t = booted();
    t.memory_works = None;
    assert_eq!(t.exchange("60A#2F7F200001000000"), [""; 0]);
    assert_eq!(t.write(0x6000, 0, 2, 100), Err(0x0800_0022));
    t.finish_save(Ok(()));
    assert_eq!(t.sent_text(), ["58A#607F200000000000"]);
    assert_eq!(t.write(0x6000, 0, 2, 100), Ok(()));
}

#[test]
fn client_that_aborts_during_a_save_gets_no_answer() {
    let mut t = booted();
    t.memory_works = None;
    assert_eq!(t.exchange("60A#2310100173617665"), [""; 0]);
    assert_eq!(t.exchange("60A#8010100100000405"), [""; 0]);
    t.finish_save(Ok(()));
    assert_eq!(t.sent_text(), [""; 0]);
}

#[test]
fn unrequested_save_result_changes_nothing() {
    let mut t = booted();
    t.finish_save(Ok(()));
    t.finish_save(Err(StoreError));
    assert_eq!(t.sent_text(), [""; 0]);
    assert_eq!(t.read(0x1001, 0), Ok(0));
}

#[test]
fn abort_of_another_object_during_a_save_changes_nothing() {
    for request in [SAVE, "60A#2F46200001000000"] {
        let mut t = booted();
        t.memory_works = None;
        assert_eq!(t.exchange(request), [""; 0]);
        // An object without a transfer, another sub-index, and the object of a transfer that has ended.
        assert_eq!(t.exchange("60A#8017100000000405"), [""; 0]);
        assert_eq!(t.exchange("60A#8010100000000405"), [""; 0]);
        t.read(0x1000, 0).unwrap();
        assert_eq!(t.exchange("60A#8000100000000405"), [""; 0]);
        t.finish_save(Ok(()));
        let reply = format!("58A#60{}00000000", &request[6..12]);
        assert_eq!(t.sent_text(), [reply], "{request}");
    }
}

#[test]
fn abort_during_a_save_ends_either_the_save_or_another_transfer() {
    let mut t = booted();
    t.memory_works = None;
    assert_eq!(t.exchange(SAVE), [""; 0]);
    assert_eq!(t.sdo("4008100000000000"), "4108100006000000");
    // The abort of the save does not end the read.
    assert_eq!(t.exchange("60A#8010100100000405"), [""; 0]);
    assert_eq!(t.sdo("6000000000000000"), "034A4E3231303100");
    t.finish_save(Ok(()));
    assert_eq!(t.sent_text(), [""; 0]);
    // The abort of a read does not end the save.
    assert_eq!(t.exchange(SAVE), [""; 0]);
    assert_eq!(t.sdo("4008100000000000"), "4108100006000000");
    assert_eq!(t.exchange("60A#8008100000000405"), [""; 0]);
    assert_eq!(t.sdo("6000000000000000"), "8000000001000405");
    t.finish_save(Ok(()));
    assert_eq!(t.sent_text(), [SAVED]);
}

/// python-canopen sends index 0 and sub-index 0.
#[test]
fn abort_without_address_ends_all_transfers() {
    let mut t = booted();
    t.memory_works = None;
    assert_eq!(t.exchange(SAVE), [""; 0]);
    assert_eq!(t.sdo("4008100000000000"), "4108100006000000");
    assert_eq!(t.exchange("60A#8000000000000405"), [""; 0]);
    assert_eq!(t.sdo("6000000000000000"), "8000000001000405");
    t.finish_save(Ok(()));
    assert_eq!(t.sent_text(), [""; 0]);
}

#[test]
fn failed_save_of_aborted_transfer_is_reported_by_emergency_only() {
    let mut t = booted();
    t.memory_works = None;
    assert_eq!(t.exchange(SAVE), [""; 0]);
    assert_eq!(t.exchange("60A#8010100100000405"), [""; 0]);
    t.finish_save(Err(StoreError));
    assert_eq!(t.sent_text(), ["08A#0010010800000000"]);
}

#[test]
fn teach_and_zero_point_without_change_are_not_saved() {
    let mut t = booted();
    // Also with blank memory: the factory values are in force.
    for (index, value) in [(0x2042, 2), (0x2042, 0), (0x2046, 2), (0x2046, 0)] {
        assert_eq!(t.write(index, 0, 1, value), Ok(()));
    }
    assert_eq!(t.write_text(0x3000, "D0UfZEgRKHAI5Ag="), "2000000000000000");
    assert_eq!((saves(&t), &t.memory), (0, &None));
    t.tilt(10.0, 5.0);
    for (index, count) in [(0x2042, 1), (0x2046, 3)] {
        assert_eq!(t.write(index, 0, 1, 1), Ok(()));
        assert_eq!(saves(&t), count, "{index:04X}");
        // The same position, and the value for "no change".
        assert_eq!(t.write(index, 0, 1, 1), Ok(()));
        assert_eq!(t.write(index, 0, 1, 0), Ok(()));
        assert_eq!(saves(&t), count, "{index:04X}");
        assert_eq!(t.write(index, 0, 1, 2), Ok(()));
        assert_eq!(saves(&t), count + 1, "{index:04X}");
        assert_eq!(t.write(index, 0, 1, 2), Ok(()));
        assert_eq!(saves(&t), count + 1, "{index:04X}");
    }
    // Also after a power cycle, and after a failed save.
    t.power_cycle();
    t.sent_text();
    assert_eq!(t.write(0x2042, 0, 1, 2), Ok(()));
    assert_eq!(saves(&t), 0);
    t.memory_works = Some(false);
    assert_eq!(t.exchange("60A#2F42200001000000").len(), 2, "abort, EMCY");
    assert_eq!(t.write(0x2042, 0, 1, 2), Ok(()));
    assert_eq!(saves(&t), 1);
}

/// The store has the older image and detects the incomplete newer one. Tests in `host-tests/tests` interrupt a save at each point and
/// check the older image.
#[test]
fn interrupted_save_is_a_hardware_fault_until_the_next_successful_save() {
    const ERROR: &str = "08A#0010010800000000";
    let mut t = booted();
    t.write(0x1017, 0, 2, 60_000).unwrap();
    t.write(0x2000, 0, 1, 0x0A).unwrap();
    t.store();
    let image = t.memory.clone();
    let loaded = Boot {
        parameters: image.as_deref(),
        damaged: true,
        ..Boot::default()
    };
    let mut t = with_memory(loaded);
    assert_eq!(t.sent_text(), ["70A#00", ERROR]);
    assert_eq!(t.read(0x1017, 0), Ok(60_000), "the older image is in force");
    assert_eq!(t.read(0x1001, 0), Ok(1));
    assert_eq!(t.read(0x1003, 1), Ok(0x0801_1000));
    for reset in ["000#810A", "000#820A"] {
        assert_eq!(t.exchange(reset), ["70A#00", ERROR], "{reset}");
    }
    // A write without a save, and a failed save, do not end the fault.
    assert_eq!(t.write(0x2042, 0, 1, 2), Ok(()));
    t.memory_works = Some(false);
    assert_eq!(t.exchange(SAVE), ["58A#8010100100000606"]);
    assert_eq!(t.read(0x1001, 0), Ok(1));
    t.memory_works = Some(true);
    assert_eq!(t.exchange(SAVE), [SAVED, "08A#0000000000000000"]);
    assert_eq!(t.read(0x1001, 0), Ok(0));
    assert_eq!(t.exchange("000#810A"), ["70A#00"]);
}
