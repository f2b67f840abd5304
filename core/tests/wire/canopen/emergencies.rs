//! Emergency messages, error register and history of the JN2101 (CiA 301, 7.2.7; manual 7.6.1 and 11).

use crate::tester::canopen::*;
use plumbline::node::{Action, BusEvent, BusState};

fn state(state: BusState) -> BusEvent {
    BusEvent::State(state)
}

#[test]
fn missing_samples_are_sensor_error() {
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
fn clipping_accelerometer_is_sensor_error() {
    let mut t = booted();
    t.clip(20);
    assert_eq!(t.sent_text(), [""; 0], "100 ms");
    t.clip(1);
    assert_eq!(t.sent_text(), ["08A#0010010100000000"]);
    let frames = t.wait_text(200);
    assert_eq!(frames.len(), 1);
    assert_eq!(frames[0].1, "08A#0000000000000000");
}

#[test]
fn implausible_acceleration_is_sensor_error() {
    for force in [[0.0; 3], [0.3, 0.0, 0.3], [0.0, 0.0, 1.6], [0.0, -3.0, 1.0]] {
        let mut t = booted();
        t.hold(in_g(force), 99);
        // 1000h, also while another error is active
        let has_error = |sent: Vec<String>| sent.iter().any(|text| text.starts_with("08A#0010"));
        assert!(!has_error(t.sent_text()), "{force:?}");
        t.hold(in_g(force), 40);
        assert!(has_error(t.sent_text()), "{force:?}");
        t.settle_at([0.0, 0.0, 1.0]);
        t.sent_text();
        assert_eq!(t.read(0x1001, 0), Ok(0), "{force:?}");
    }
}

/// The fault is active from the first reading on. Otherwise the sensor would be reported as level.
#[test]
fn dead_accelerometer_is_announced_behind_the_boot_up_message() {
    let mut t = booted();
    t.force = [0; 3];
    t.power_cycle();
    assert_eq!(t.sent_text(), ["70A#00", "08A#0010010100000000"]);
}

/// 3 g for 20 ms, twice a second, for 10 s.
#[test]
fn repeated_shocks_are_no_error() {
    let mut t = booted();
    for n in 0..2000 {
        let z = if n % 100 < 4 { 4.0 } else { 1.0 };
        t.force = in_g([0.0, 0.0, z]);
        assert_eq!(t.wait_text(5), [], "sample {n}");
    }
}

#[test]
fn sensor_on_its_back_exceeds_limit_unless_the_lateral_range_is_extended() {
    let exceeded = ["08A#0090010200000000"];
    for (definition, quadrants, measures) in [
        (0, 1, false),
        (1, 0, false),
        (1, 1, true),
        (1, 2, true),
        (2, 1, false),
        (3, 2, false),
    ] {
        let mut t = booted();
        t.write(0x2044, 0, 1, definition).unwrap();
        t.write(0x2040, 0, 1, quadrants).unwrap();
        t.settle_at([0.1, 0.0, -1.0]);
        let sent = t.sent_text();
        if measures {
            assert_eq!(sent, [""; 0], "{definition} {quadrants}");
        } else {
            assert_eq!(sent, exceeded, "{definition} {quadrants}");
        }
    }
}

#[test]
fn inclination_above_45_degrees_exceeds_limit() {
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
fn range_of_45_degrees_is_that_of_both_axes_in_both_directions() {
    for (x, y) in [(1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0)] {
        let mut t = booted();
        t.tilt(44.9 * x, 44.9 * y);
        assert_eq!(t.sent_text(), [""; 0], "{x} {y}");
        t.tilt(45.1 * x, 45.1 * y);
        assert_eq!(t.sent_text(), ["08A#0090010200000000"], "{x} {y}");
        assert_eq!(t.read(0x1001, 0), Ok(1));
        assert_eq!(t.read(0x1003, 0), Ok(1));
        assert_eq!(t.read(0x1003, 1), Ok(0x0201_9000));
    }
}

/// The inclination is the direction of the acceleration, whatever its length.
#[test]
fn range_of_45_degrees_does_not_depend_on_the_length_of_the_acceleration() {
    for g in [0.7, 1.0, 1.4] {
        let mut t = booted();
        let at = |degrees: f64| {
            let angle = degrees.to_radians();
            [g * angle.sin(), 0.0, g * angle.cos()]
        };
        t.settle_at(at(44.9));
        assert_eq!(t.sent_text(), [""; 0], "{g} g");
        t.settle_at(at(45.1));
        assert_eq!(t.sent_text(), ["08A#0090010200000000"], "{g} g");
        t.settle_at(at(70.0));
        assert_eq!(t.sent_text(), [""; 0], "{g} g");
    }
    // Up to the range of the accelerometer. Without a filter, a push of 50 ms changes the angle.
    for (degrees, exceeds) in [(44.0, false), (60.0, true)] {
        let mut t = booted();
        t.write(0x2043, 0, 1, 0).unwrap();
        let (x, z) = f64::to_radians(degrees).sin_cos();
        t.hold(in_g([7.5 * x, 0.0, 7.5 * z]), 10);
        let sent = t.sent_text();
        assert_eq!(sent.len(), usize::from(exceeds), "{degrees} {sent:?}");
    }
    // Exactly 45 deg are within the range.
    let mut t = booted();
    t.settle_at([0.7, 0.0, 0.7]);
    assert_eq!(t.sent_text(), [""; 0]);
}

/// Nobody acknowledges the boot-up message until another node is there.
#[test]
fn error_passive_before_the_boot_up_message_is_sent_after_it() {
    let mut t = power_up();
    t.bus(state(BusState::Passive));
    assert_eq!(t.sent_text(), ["70A#00", "08A#2081112000000000"]);
    t.bus(state(BusState::Active));
    assert_eq!(t.sent_text(), ["08A#0000000000000000"]);
    assert_eq!(t.read(0x1003, 1), Ok(0x2011_8120));
}

#[test]
fn supply_outside_its_limits_is_reported_with_hysteresis() {
    let mut t = booted();
    for (millivolts, message) in [
        (24_000, None),
        (8_000, None),
        (7_990, Some("08A#0031051000000000")),
        (8_490, None),
        (8_510, Some("08A#0000000000000000")),
        (36_000, None),
        (36_010, Some("08A#0031051000000000")),
        (35_510, None),
        (35_490, Some("08A#0000000000000000")),
    ] {
        t.supply(millivolts);
        let expected: Vec<_> = message.into_iter().collect();
        assert_eq!(t.sent_text(), expected, "{millivolts} mV");
    }
    assert_eq!(t.read(0x1003, 1), Ok(0x1005_3100));
    // Generic and voltage; an event in between has the bits of the lasting fault.
    t.supply(5_000);
    t.sent_text();
    assert_eq!(t.read(0x1001, 0), Ok(0x05));
    t.bus(BusEvent::Overrun);
    assert_eq!(
        t.sent_text(),
        ["08A#1081151000000000", "08A#0000051000000000"]
    );
    assert_eq!(t.read(0x1003, 1), Ok(0x1015_8110));
}

#[test]
fn temperature_outside_limits_sends_emergency() {
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

/// 7.6.1: an entry of 1003h has the first bytes of the message: code, error register (1001h), manufacturer-specific field.
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
    assert_eq!(t.read(0x1003, 1), Ok(0x0609_9000));
    assert_eq!(t.read(0x1003, 2), Ok(0x0409_4200));
    assert_eq!(t.read(0x1003, 3), Ok(0));
    assert_eq!(t.write(0x1003, 0, 4, 0), Ok(()));
    assert_eq!(t.read(0x1003, 0), Ok(0));
    assert_eq!(t.read(0x1003, 1), Ok(0));
}

#[test]
fn history_keeps_newest_fifty_errors() {
    let mut t = booted();
    t.bus(state(BusState::Passive));
    t.bus(state(BusState::Active));
    for _ in 0..49 {
        t.bus(BusEvent::Overrun);
        t.sent_text();
    }
    assert_eq!(t.read(0x1003, 0), Ok(50));
    assert_eq!(t.read(0x1003, 1), Ok(0x0011_8110));
    assert_eq!(t.read(0x1003, 50), Ok(0x2011_8120));
    t.bus(BusEvent::Overrun);
    t.sent_text();
    assert_eq!(t.read(0x1003, 0), Ok(50));
    assert_eq!(t.read(0x1003, 50), Ok(0x0011_8110));
}

#[test]
fn bus_faults_send_emergencies() {
    let mut t = booted();
    t.bus(BusEvent::Overrun);
    assert_eq!(
        t.sent_text(),
        ["08A#1081110000000000", "08A#0000000000000000"]
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
    assert_eq!(t.read(0x1003, 1), Ok(0x8011_8140));
}

#[test]
fn node_in_bus_off_ignores_requests_and_sends_nothing() {
    let mut t = operational();
    t.bus(state(BusState::BusOff));
    assert_eq!(t.exchange("080#"), [""; 0]);
    assert_eq!(t.exchange("000#8100"), [""; 0]);
    t.bus(state(BusState::Active));
    t.sent_text();
    assert_eq!(t.exchange("70A#R1"), ["70A#05"]);
}

#[test]
fn inhibit_time_delays_emergencies() {
    let mut t = booted();
    t.write(0x1015, 0, 2, 500).unwrap();
    t.bus(BusEvent::Overrun);
    t.bus(BusEvent::Overrun);
    let frames = t.wait_text(1000);
    let expected = [
        (0, "08A#1081110000000000"),
        (50, "08A#0000000000000000"),
        (100, "08A#1081110000000000"),
        (150, "08A#0000000000000000"),
    ];
    assert_eq!(
        frames,
        expected.map(|(time, frame)| (time, frame.to_string()))
    );
}

#[test]
fn new_inhibit_time_counts_from_the_last_emergency() {
    for (inhibit, times) in [(500, [50, 100]), (900, [90, 180]), (300, [30, 60])] {
        let mut t = booted();
        t.write(0x1015, 0, 2, 500).unwrap();
        t.bus(BusEvent::Overrun);
        t.bus(BusEvent::Overrun);
        assert_eq!(t.sent_text(), ["08A#1081110000000000"]);
        t.wait_text(20);
        t.write(0x1015, 0, 2, inhibit).unwrap();
        let sent = t.wait_text(1000).into_iter().map(|(time, _)| time + 20);
        assert_eq!(sent.take(2).collect::<Vec<_>>(), times, "{inhibit}");
    }
}

/// Byte 3 of the message has a bit for each lasting fault. An overrun has no bit.
#[test]
fn overrun_has_no_bit_in_the_status_byte() {
    let mut t = operational();
    t.temperature = 90_00;
    t.wait_text(200);
    t.write(0x100C, 0, 2, 100).unwrap();
    t.write(0x100D, 0, 1, 1).unwrap();
    t.exchange("70A#R1");
    t.supply(6_000);
    t.tilt(50.0, 0.0);
    t.memory_works = Some(false);
    t.exchange("60A#2310100173617665");
    t.bus(state(BusState::Passive));
    t.wait_without_samples(200);
    t.bus(BusEvent::Overrun);
    // All bits except that of 8140h, which is a momentary fault.
    let expected = ["08A#1081 1D 7F00000000", "08A#0000 1D 7F00000000"];
    assert_eq!(t.sent_text(), expected.map(|text| text.replace(' ', "")));
    assert_eq!(t.read(0x1003, 1), Ok(0x7F1D_8110));
}

/// The first message is sent, the others wait for the inhibit time.
#[test]
fn overruns_do_not_displace_the_waiting_message_of_a_lasting_fault() {
    let mut t = booted();
    t.write(0x1015, 0, 2, 500).unwrap();
    t.bus(BusEvent::Overrun);
    t.sent_text();
    t.tilt(50.0, 0.0);
    for _ in 0..20 {
        t.bus(BusEvent::Overrun);
    }
    let sent = t.wait_text(2000);
    let lasting = |(_, frame): &&(u64, String)| frame == "08A#0090010200000000";
    assert_eq!(sent.iter().filter(lasting).count(), 1, "{sent:?}");
    assert_eq!(t.read(0x1003, 0), Ok(22));
}

#[test]
fn emergency_in_operational_is_sent_and_keeps_state() {
    let mut t = operational();
    t.tilt(50.0, 0.0);
    assert_eq!(t.sent_text(), ["08A#0090010200000000"]);
    assert_eq!(t.exchange("70A#R1"), ["70A#05"]);
}

#[test]
fn active_fault_is_sent_again_after_reset() {
    let mut t = booted();
    t.tilt(50.0, 0.0);
    t.sent_text();
    assert_eq!(t.exchange("000#8100"), ["70A#00", "08A#0090010200000000"]);
    assert_eq!(t.read(0x1003, 0), Ok(1));
}

#[test]
fn guarding_time_out_sends_emergency_before_node_stops() {
    let mut t = operational();
    t.write(0x100C, 0, 2, 100).unwrap();
    t.write(0x100D, 0, 1, 3).unwrap();
    t.write(0x1029, 1, 1, 2).unwrap();
    t.exchange("70A#R1");
    assert_eq!(
        t.wait_text(400),
        [(300, "08A#3081114000000000".to_string())]
    );
    // Stopped; the end of the fault is sent later.
    assert_eq!(t.exchange("70A#R1"), ["70A#84"]);
    assert_eq!(t.exchange("000#800A"), ["08A#0000000000000000"]);
}

#[test]
fn fault_that_was_told_and_ends_in_stopped_is_reset_when_the_node_leaves() {
    let mut t = booted();
    t.tilt(50.0, 0.0);
    t.temperature = 90_00;
    let told = t.wait_text(200);
    assert_eq!(told.len(), 2, "{told:?}");
    for leave in ["000#010A", "000#800A"] {
        t.send("000#020A");
        t.tilt(if leave == "000#010A" { 0.0 } else { 50.0 }, 0.0);
        let sent = t.exchange(leave);
        if leave == "000#010A" {
            let expected = ["08A#0042090400000000", "08A#0000090400000000"];
            assert_eq!(sent, expected, "one has ended");
        } else {
            let expected = ["08A#0090010200000000", "08A#0042090600000000"];
            assert_eq!(sent, expected, "none has ended");
        }
    }
    // Told twice, once ended: one error reset. A fault that was not told has none.
    t.send("000#020A");
    t.tilt(0.0, 0.0);
    t.temperature = 20_00;
    assert_eq!(t.wait_text(500), []);
    assert_eq!(t.exchange("000#800A"), ["08A#0000000000000000"]);
    t.send("000#020A");
    t.tilt(50.0, 0.0);
    t.tilt(0.0, 0.0);
    assert_eq!(t.exchange("000#010A"), [""; 0]);
    // The boot-up message ends all.
    t.tilt(50.0, 0.0);
    t.sent_text();
    t.send("000#020A");
    t.tilt(0.0, 0.0);
    assert_eq!(t.exchange("000#820A"), ["70A#00"]);
    t.send("000#020A");
    assert_eq!(t.exchange("000#800A"), [""; 0]);
}

#[test]
fn error_whose_message_waits_when_the_node_stops_has_no_error_reset() {
    let mut t = booted();
    t.write(0x1015, 0, 2, 10_000).unwrap();
    t.bus(BusEvent::Overrun);
    t.sent_text();
    t.tilt(50.0, 0.0);
    assert_eq!(t.wait_text(10), []);
    t.send("000#020A");
    t.tilt(0.0, 0.0);
    t.send("000#800A");
    // Only that of the overrun, which was told.
    let sent = t.wait_text(3000);
    assert!(
        sent.iter()
            .all(|(_, frame)| frame == "08A#0000000000000000"),
        "{sent:?}"
    );
    assert!(sent.len() <= 1, "{sent:?}");
}

#[test]
fn node_in_stopped_queues_no_emergencies_and_announces_active_faults_when_it_leaves() {
    let mut t = booted();
    t.send("000#020A");
    t.tilt(50.0, 0.0);
    t.tilt(0.0, 0.0);
    t.bus(BusEvent::Overrun);
    assert_eq!(t.exchange("000#800A"), [""; 0], "no active fault");
    assert_eq!(t.read(0x1003, 0), Ok(2), "the history continues");
    t.send("000#020A");
    t.tilt(50.0, 0.0);
    t.bus(state(BusState::Passive));
    assert_eq!(t.sent_text(), [""; 0]);
    let active = ["08A#0090010200000000", "08A#2081112200000000"];
    assert_eq!(t.exchange("000#010A"), active);
    assert_eq!(t.read(0x1003, 0), Ok(4));
}

#[test]
fn reset_communication_announces_persisting_faults_after_boot_up() {
    let mut t = booted();
    t.tilt(50.0, 0.0);
    assert_eq!(t.sent_text(), ["08A#0090010200000000"]);
    let expected = ["70A#00", "08A#0090010200000000"];
    assert_eq!(t.exchange("000#820A"), expected);
    assert_eq!(t.read(0x1003, 0), Ok(1));
    assert_eq!(t.exchange("000#810A"), expected);
}

#[test]
fn filter_begins_again_after_missing_samples() {
    let mut t = booted();
    t.write(0x2043, 0, 1, 4).unwrap();
    t.hold(in_g([0.7, 0.0, 0.7]), 100);
    assert_ne!(t.read_i16(0x6010), 0);
    t.wait_without_samples(200);
    t.hold(in_g([0.0, 0.0, 1.0]), 2);
    t.sent_text();
    assert_eq!(t.read_i16(0x6010), 0);
}
