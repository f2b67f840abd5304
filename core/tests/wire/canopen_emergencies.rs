//! Emergencies, error register and history of the JN2101 on the wire (CiA 301, 7.2.7; manual 7.6.1 and 11).

use crate::tester::canopen::*;
use plumbline::node::{Action, BusEvent, BusState};

fn state(state: BusState) -> BusEvent {
    BusEvent::State(state)
}

#[test]
fn no_samples_are_a_sensor_error() {
    let mut t = booted();
    t.sampled = false;
    assert_eq!(
        t.wait_text(1000),
        [(100, "08A#0010010100000000".to_string())]
    );
    assert_eq!(t.read(0x1001, 0), Ok(1));
    t.sampled = true;
    assert_eq!(t.wait_text(1), [(0, "08A#0000000000000000".to_string())]);
}

#[test]
fn a_clipping_accelerometer_is_a_sensor_error() {
    let mut t = booted();
    t.clipped = true;
    t.wait_text(0);
    assert_eq!(t.wait_text(6), [(5, "08A#0010010100000000".to_string())]);
    t.clipped = false;
    let frames = t.wait_text(200);
    assert_eq!(frames.len(), 1);
    assert_eq!(frames[0].1, "08A#0000000000000000");
}

#[test]
fn beyond_45_degrees_the_limit_is_exceeded() {
    let mut t = booted();
    t.tilt(44.9, 0.0);
    assert_eq!(t.sent_text(), [""; 0]);
    t.tilt(45.1, 0.0);
    assert_eq!(t.sent_text(), ["08A#0090010200000000"]);
    t.tilt(44.7, 0.0);
    assert_eq!(t.sent_text(), [""; 0]);
    t.tilt(43.5, 0.0);
    assert_eq!(t.sent_text(), ["08A#0000000000000000"]);
    t.tilt(0.0, -46.0);
    assert_eq!(t.sent_text(), ["08A#0090010200000000"]);
}

#[test]
fn the_temperature_is_watched() {
    let mut t = booted();
    t.temperature = 85_10;
    let hot = t.wait_text(200);
    assert_eq!(hot.len(), 1);
    // 4200h; temperature and generic bit; status bit 2.
    assert_eq!(hot[0].1, "08A#0042090400000000");
    assert_eq!(t.read(0x4080, 0), Ok(851));
    t.temperature = 84_00;
    assert_eq!(t.wait_text(400), []);
    t.temperature = 82_00;
    assert_eq!(t.wait_text(200)[0].1, "08A#0000000000000000");
    t.temperature = -40_10;
    assert_eq!(t.wait_text(200)[0].1, "08A#0042090400000000");
    assert_eq!(t.read_i32(0x4080), -401);
}

#[test]
fn faults_end_one_by_one() {
    let mut t = booted();
    t.temperature = 90_00;
    t.wait_text(200);
    t.tilt(50.0, 0.0);
    assert_eq!(t.sent_text(), ["08A#0090090600000000"]);
    t.tilt(0.0, 0.0);
    assert_eq!(t.sent_text(), ["08A#0000090400000000"]);
    t.temperature = 20_00;
    assert_eq!(t.wait_text(200)[0].1, "08A#0000000000000000");
    assert_eq!(t.read(0x1003, 0), Ok(2));
    assert_eq!(t.read(0x1003, 1), Ok(0x0006_9000));
    assert_eq!(t.read(0x1003, 2), Ok(0x0004_4200));
    assert_eq!(t.read(0x1003, 3), Ok(0));
    assert_eq!(t.write(0x1003, 0, 4, 0), Ok(()));
    assert_eq!(t.read(0x1003, 0), Ok(0));
    assert_eq!(t.read(0x1003, 1), Ok(0));
}

#[test]
fn the_history_keeps_the_newest_fifty() {
    let mut t = booted();
    t.bus(state(BusState::Passive));
    t.bus(state(BusState::Active));
    for _ in 0..49 {
        t.bus(BusEvent::Overrun);
        t.sent_text();
    }
    assert_eq!(t.read(0x1003, 0), Ok(50));
    assert_eq!(t.read(0x1003, 1), Ok(0x0010_8110));
    assert_eq!(t.read(0x1003, 50), Ok(0x0020_8120));
    t.bus(BusEvent::Overrun);
    t.sent_text();
    assert_eq!(t.read(0x1003, 0), Ok(50));
    assert_eq!(t.read(0x1003, 50), Ok(0x0010_8110));
}

#[test]
fn bus_faults_are_emergencies() {
    let mut t = booted();
    t.bus(BusEvent::Overrun);
    assert_eq!(
        t.sent_text(),
        ["08A#1081111000000000", "08A#0000000000000000"]
    );
    t.bus(state(BusState::Warning));
    assert_eq!(t.sent_text(), [""; 0]);
    t.bus(state(BusState::Passive));
    assert_eq!(t.sent_text(), ["08A#2081112000000000"]);
    t.bus(state(BusState::Active));
    assert_eq!(t.sent_text(), ["08A#0000000000000000"]);
    t.actions.clear();
    t.bus(state(BusState::BusOff));
    assert!(t.actions.contains(&Action::Recover));
    assert_eq!(t.sent_text(), [""; 0]);
    t.bus(state(BusState::Active));
    assert_eq!(
        t.sent_text(),
        ["08A#4081118000000000", "08A#0000000000000000"]
    );
    assert_eq!(t.read(0x1003, 1), Ok(0x0080_8140));
}

#[test]
fn in_bus_off_nothing_is_taken_in_or_sent() {
    let mut t = operational();
    t.bus(state(BusState::BusOff));
    assert_eq!(t.exchange("080#"), [""; 0]);
    assert_eq!(t.exchange("000#8100"), [""; 0]);
    t.bus(state(BusState::Active));
    t.sent_text();
    assert_eq!(t.exchange("70A#R1"), ["70A#05"]);
}

#[test]
fn the_inhibit_time_keeps_emergencies_apart() {
    let mut t = booted();
    t.write(0x1015, 0, 2, 500).unwrap();
    t.bus(BusEvent::Overrun);
    t.bus(BusEvent::Overrun);
    let frames = t.wait_text(1000);
    let expected = [
        (0, "08A#1081111000000000"),
        (50, "08A#0000000000000000"),
        (100, "08A#1081111000000000"),
        (150, "08A#0000000000000000"),
    ];
    assert_eq!(
        frames,
        expected.map(|(time, frame)| (time, frame.to_string()))
    );
}

#[test]
fn in_stopped_emergencies_wait() {
    let mut t = booted();
    t.write(0x1015, 0, 2, 100).unwrap();
    t.send("000#0200");
    t.bus(BusEvent::Overrun);
    assert_eq!(t.wait_text(1000), []);
    t.send("000#8000");
    let frames = t.wait_text(100);
    assert_eq!(frames.len(), 2);
    assert_eq!(frames[0], (0, "08A#1081111000000000".to_string()));
}

#[test]
fn emergencies_go_out_in_operational_and_do_not_change_the_state() {
    let mut t = operational();
    t.tilt(50.0, 0.0);
    assert_eq!(t.sent_text(), ["08A#0090010200000000"]);
    assert_eq!(t.exchange("70A#R1"), ["70A#05"]);
}

#[test]
fn a_fault_that_lasts_is_told_again_after_a_reset() {
    let mut t = booted();
    t.tilt(50.0, 0.0);
    t.sent_text();
    assert_eq!(t.exchange("000#8100"), ["70A#00", "08A#0090010200000000"]);
    assert_eq!(t.read(0x1003, 0), Ok(1));
}
