//! Saves of the JN2101: what is answered while one is running.

use crate::tester::canopen::*;
use plumbline::node::Node;
use plumbline::store::StoreError;

const LOAD: u32 = 0x6461_6F6C;

#[test]
fn save_is_answered_at_its_end_and_other_requests_at_once() {
    let mut t = operational();
    t.memory_works = None;
    assert_eq!(t.exchange("60A#2310100173617665"), [""; 0]);
    assert_eq!(t.exchange("080#").len(), 2);
    assert_eq!(t.exchange("70A#R1"), ["70A#05"]);
    assert_eq!(t.exchange("60A#4000100000000000"), ["58A#430010009A010400"]);
    assert_eq!(t.exchange("60A#4008100000000000").len(), 1);
    assert_eq!(t.write(0x1017, 0, 2, 0), Ok(()));
    assert_eq!(t.exchange("000#800A"), [""; 0]);
    assert_eq!(t.exchange("70A#R1"), ["70A#FF"]);
    assert!(t.node.ready());
    t.finish_save(Ok(()));
    assert_eq!(t.sent_text(), ["58A#6010100100000000"]);
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
