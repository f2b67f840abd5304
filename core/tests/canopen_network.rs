//! NMT, boot-up, error control, emergencies and LEDs of the JN2101 on the wire (CiA 301, 7.2.7, 7.2.8, 7.3.2; manual 7.2, 7.3, 11).

mod canopen_tester;

use canopen_tester::*;
use plumbline::can::BitRate;
use plumbline::node::{Action, BusEvent, BusMode, BusState, Leds};

const RUN: Leds = Leds {
    run: true,
    error: false,
};

fn state(state: BusState) -> BusEvent {
    BusEvent::State(state)
}

#[test]
fn it_boots_into_pre_operational() {
    let mut t = Tester::power_up();
    assert!(
        t.actions
            .contains(&Action::Bus(BusMode::Normal, BitRate::K125))
    );
    assert!(t.actions.contains(&Action::Termination(true)));
    assert_eq!(t.sent(), ["70A#00"]);
    assert_eq!(t.exchange("70A#R1"), ["70A#7F"]);
    assert_eq!(t.wait(5000), []);
}

#[test]
fn nmt_commands_change_the_state() {
    let mut t = Tester::booted();
    t.write(0x1017, 0, 2, 100).unwrap();
    for (command, state) in [
        ("000#010A", "70A#05"),
        ("000#020A", "70A#04"),
        ("000#800A", "70A#7F"),
        ("000#0100", "70A#05"),
        ("000#0100", "70A#05"),
        ("000#0200", "70A#04"),
        ("000#0100", "70A#05"),
        ("000#8000", "70A#7F"),
        // Unknown commands, other nodes, wrong lengths, remote frames.
        ("000#0300", "70A#7F"),
        ("000#FF0A", "70A#7F"),
        ("000#0000", "70A#7F"),
        ("000#010B", "70A#7F"),
        ("000#01", "70A#7F"),
        ("000#", "70A#7F"),
        ("000#010A00", "70A#7F"),
        ("000#R2", "70A#7F"),
        ("00000000#010A", "70A#7F"),
    ] {
        assert_eq!(t.exchange(command), [""; 0], "{command}");
        assert_eq!(t.wait(100), [(100, state.to_string())], "{command}");
    }
}

#[test]
fn reset_commands_boot_anew_in_every_state() {
    for state in ["000#800A", "000#010A", "000#020A"] {
        for reset in ["000#810A", "000#8100", "000#820A", "000#8200"] {
            let mut t = Tester::booted();
            t.send(state);
            assert_eq!(t.exchange(reset), ["70A#00"], "{state} {reset}");
            assert_eq!(t.exchange("70A#R1"), ["70A#7F"]);
        }
        let mut t = Tester::booted();
        t.send(state);
        assert_eq!(t.exchange("000#810B"), [""; 0]);
        assert_eq!(t.exchange("000#820B"), [""; 0]);
    }
}

#[test]
fn reset_communication_and_reset_node_bring_the_stored_parameters_back() {
    let mut t = Tester::booted();
    t.write(0x1017, 0, 2, 500).unwrap();
    t.write(0x2044, 0, 1, 2).unwrap();
    t.store();
    t.write(0x1017, 0, 2, 100).unwrap();
    t.write(0x1029, 1, 1, 2).unwrap();
    t.write(0x2044, 0, 1, 3).unwrap();
    t.send("000#8200");
    assert_eq!(t.sent(), ["70A#00"]);
    assert_eq!(t.read(0x1017, 0), Ok(500));
    assert_eq!(t.read(0x1029, 1), Ok(0), "1029h is not stored");
    assert_eq!(t.read(0x2044, 0), Ok(3), "not a communication parameter");
    t.send("000#8100");
    assert_eq!(t.sent(), ["70A#00"]);
    assert_eq!(t.read(0x2044, 0), Ok(2));
}

#[test]
fn start_up_8_starts_the_sensor_and_2_the_network() {
    for (value, frames) in [(8, &["70A#00"][..]), (2, &["70A#00", "000#0100"])] {
        let mut t = Tester::booted();
        t.write(0x1F80, 0, 4, value).unwrap();
        t.store();
        assert_eq!(t.exchange("70A#R1"), ["70A#7F"], "only after a new start");
        for _ in 0..2 {
            t.power_cycle();
            assert_eq!(t.sent(), frames);
            assert_eq!(t.exchange("70A#R1"), ["70A#05"]);
            assert_eq!(t.exchange("080#").len(), 2);
        }
        for reset in ["000#8100", "000#8200"] {
            assert_eq!(t.exchange(reset), frames);
            assert_eq!(t.exchange("70A#R1"), ["70A#05"]);
        }
    }
}

#[test]
fn the_heartbeat_comes_in_every_state() {
    let mut t = Tester::booted();
    assert_eq!(t.wait(1000), []);
    t.write(0x1017, 0, 2, 250).unwrap();
    let beat = |ms, state: &str| (ms, format!("70A#{state}"));
    assert_eq!(t.wait(500), [beat(250, "7F"), beat(500, "7F")]);
    t.send("000#0100");
    assert_eq!(t.wait(250), [beat(250, "05")]);
    t.send("000#0200");
    assert_eq!(t.wait(250), [beat(250, "04")]);
    t.send("000#8000");
    t.write(0x1017, 0, 2, 0).unwrap();
    assert_eq!(t.wait(1000), []);
    // After boot-up it goes on from the boot-up message.
    t.write(0x1017, 0, 2, 250).unwrap();
    t.store();
    assert_eq!(t.exchange("000#8200"), ["70A#00"]);
    assert_eq!(t.wait(250), [beat(250, "7F")]);
}

#[test]
fn guarding_answers_with_a_toggle_bit_that_starts_at_0() {
    let mut t = Tester::booted();
    assert_eq!(t.exchange("70A#R1"), ["70A#7F"]);
    assert_eq!(t.exchange("70A#R1"), ["70A#FF"]);
    t.send("000#0100");
    assert_eq!(t.exchange("70A#R1"), ["70A#05"]);
    t.send("000#0200");
    assert_eq!(t.exchange("70A#R1"), ["70A#84"]);
    assert_eq!(t.exchange("70A#R1"), ["70A#04"]);
    assert_eq!(t.exchange("70B#R1"), [""; 0]);
    assert_eq!(t.exchange("70A#00"), [""; 0]);
    for reset in ["000#8200", "000#8100"] {
        assert_eq!(t.exchange(reset), ["70A#00"]);
        assert_eq!(t.exchange("70A#R1"), ["70A#7F"]);
    }
}

#[test]
fn only_one_of_heartbeat_and_guarding_works() {
    let mut t = Tester::booted();
    t.write(0x100C, 0, 2, 100).unwrap();
    t.write(0x100D, 0, 1, 2).unwrap();
    t.exchange("70A#R1");
    t.write(0x1017, 0, 2, 1000).unwrap();
    assert_eq!(t.wait(1000), [(1000, "70A#7F".to_string())], "no emergency");
    assert_eq!(t.exchange("70A#R1"), [""; 0]);
    t.write(0x1017, 0, 2, 0).unwrap();
    assert_eq!(t.exchange("70A#R1").len(), 1);
    assert_eq!(t.wait(200), [(200, "08A#3081114000000000".to_string())]);
}

/// Guard time 100 ms, life time factor 3.
fn guarded() -> Tester {
    let mut t = Tester::booted();
    t.write(0x100C, 0, 2, 100).unwrap();
    t.write(0x100D, 0, 1, 3).unwrap();
    t
}

#[test]
fn a_silent_guarding_master_is_an_emergency() {
    let mut t = guarded();
    t.send("000#0100");
    assert_eq!(t.wait(1000), [], "it counts from the first request");
    assert_eq!(t.exchange("70A#R1"), ["70A#05"]);
    t.wait(299);
    assert_eq!(t.exchange("70A#R1"), ["70A#85"]);
    // 8130h, communication and generic bit, status bit 6; back to pre-operational.
    assert_eq!(t.wait(1000), [(300, "08A#3081114000000000".to_string())]);
    assert_eq!(t.read(0x1001, 0), Ok(0x11));
    assert_eq!(t.read(0x1003, 0), Ok(1));
    assert_eq!(t.read(0x1003, 1), Ok(0x0040_8130));
    // The master is back.
    assert_eq!(t.exchange("70A#R1"), ["70A#7F", "08A#0000000000000000"]);
    assert_eq!(t.read(0x1001, 0), Ok(0));
    assert_eq!(t.read(0x1003, 0), Ok(1));
}

#[test]
fn the_error_behaviour_says_what_becomes_of_the_state() {
    for (start, behaviour, end) in [
        ("000#0100", 0, "FF"),
        ("000#0100", 1, "85"),
        ("000#0100", 2, "84"),
        ("000#8000", 0, "FF"),
        ("000#8000", 1, "FF"),
        ("000#8000", 2, "84"),
        ("000#0200", 0, "84"),
    ] {
        let mut t = guarded();
        t.write(0x1029, 1, 1, behaviour).unwrap();
        t.send(start);
        t.exchange("70A#R1");
        t.wait(400);
        let answer = &t.exchange("70A#R1")[0];
        assert_eq!(answer, &format!("70A#{end}"), "{start} {behaviour}");
    }
}

#[test]
fn without_guard_time_or_factor_the_master_is_not_guarded() {
    for (guard_time, factor) in [(0, 3), (100, 0)] {
        let mut t = Tester::booted();
        t.write(0x100C, 0, 2, guard_time).unwrap();
        t.write(0x100D, 0, 1, factor).unwrap();
        assert_eq!(t.exchange("70A#R1"), ["70A#7F"]);
        assert_eq!(t.wait(10_000), []);
    }
    // Switched off while the master is silent, the error is over.
    let mut t = guarded();
    t.exchange("70A#R1");
    t.wait(300);
    let off = format!("60A#{}", write_request(0x100C, 0, 2, 0));
    assert_eq!(
        t.exchange(&off),
        ["58A#600C100000000000", "08A#0000000000000000"]
    );
    assert_eq!(t.read(0x1001, 0), Ok(0));
}

#[test]
fn no_samples_are_a_sensor_error() {
    let mut t = Tester::booted();
    t.sampled = false;
    assert_eq!(t.wait(1000), [(100, "08A#0010010100000000".to_string())]);
    assert_eq!(t.read(0x1001, 0), Ok(1));
    t.sampled = true;
    assert_eq!(t.wait(1), [(0, "08A#0000000000000000".to_string())]);
}

#[test]
fn a_clipping_accelerometer_is_a_sensor_error() {
    let mut t = Tester::booted();
    t.clipped = true;
    t.wait(0);
    assert_eq!(t.wait(6), [(5, "08A#0010010100000000".to_string())]);
    t.clipped = false;
    let frames = t.wait(200);
    assert_eq!(frames.len(), 1);
    assert_eq!(frames[0].1, "08A#0000000000000000");
}

#[test]
fn beyond_45_degrees_the_limit_is_exceeded() {
    let mut t = Tester::booted();
    t.tilt(44.9, 0.0);
    assert_eq!(t.sent(), [""; 0]);
    t.tilt(45.1, 0.0);
    assert_eq!(t.sent(), ["08A#0090010200000000"]);
    t.tilt(44.7, 0.0);
    assert_eq!(t.sent(), [""; 0]);
    t.tilt(43.5, 0.0);
    assert_eq!(t.sent(), ["08A#0000000000000000"]);
    t.tilt(0.0, -46.0);
    assert_eq!(t.sent(), ["08A#0090010200000000"]);
}

#[test]
fn the_temperature_is_watched() {
    let mut t = Tester::booted();
    t.temperature = 85_10;
    let hot = t.wait(200);
    assert_eq!(hot.len(), 1);
    // 4200h; temperature and generic bit; status bit 2.
    assert_eq!(hot[0].1, "08A#0042090400000000");
    assert_eq!(t.read(0x4080, 0), Ok(851));
    t.temperature = 84_00;
    assert_eq!(t.wait(400), []);
    t.temperature = 82_00;
    assert_eq!(t.wait(200)[0].1, "08A#0000000000000000");
    t.temperature = -40_10;
    assert_eq!(t.wait(200)[0].1, "08A#0042090400000000");
    assert_eq!(t.read_i32(0x4080), -401);
}

#[test]
fn faults_end_one_by_one() {
    let mut t = Tester::booted();
    t.temperature = 90_00;
    t.wait(200);
    t.tilt(50.0, 0.0);
    assert_eq!(t.sent(), ["08A#0090090600000000"]);
    t.tilt(0.0, 0.0);
    assert_eq!(t.sent(), ["08A#0000090400000000"]);
    t.temperature = 20_00;
    assert_eq!(t.wait(200)[0].1, "08A#0000000000000000");
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
    let mut t = Tester::booted();
    t.bus(state(BusState::Passive));
    t.bus(state(BusState::Active));
    for _ in 0..49 {
        t.bus(BusEvent::Overrun);
        t.sent();
    }
    assert_eq!(t.read(0x1003, 0), Ok(50));
    assert_eq!(t.read(0x1003, 1), Ok(0x0010_8110));
    assert_eq!(t.read(0x1003, 50), Ok(0x0020_8120));
    t.bus(BusEvent::Overrun);
    t.sent();
    assert_eq!(t.read(0x1003, 0), Ok(50));
    assert_eq!(t.read(0x1003, 50), Ok(0x0010_8110));
}

#[test]
fn bus_faults_are_emergencies() {
    let mut t = Tester::booted();
    t.bus(BusEvent::Overrun);
    assert_eq!(t.sent(), ["08A#1081111000000000", "08A#0000000000000000"]);
    t.bus(state(BusState::Warning));
    assert_eq!(t.sent(), [""; 0]);
    t.bus(state(BusState::Passive));
    assert_eq!(t.sent(), ["08A#2081112000000000"]);
    t.bus(state(BusState::Active));
    assert_eq!(t.sent(), ["08A#0000000000000000"]);
    t.actions.clear();
    t.bus(state(BusState::BusOff));
    assert!(t.actions.contains(&Action::Recover));
    assert_eq!(t.sent(), [""; 0]);
    t.bus(state(BusState::Active));
    assert_eq!(t.sent(), ["08A#4081118000000000", "08A#0000000000000000"]);
    assert_eq!(t.read(0x1003, 1), Ok(0x0080_8140));
}

#[test]
fn in_bus_off_nothing_is_taken_in_or_sent() {
    let mut t = Tester::operational();
    t.bus(state(BusState::BusOff));
    assert_eq!(t.exchange("080#"), [""; 0]);
    assert_eq!(t.exchange("000#8100"), [""; 0]);
    t.bus(state(BusState::Active));
    t.sent();
    assert_eq!(t.exchange("70A#R1"), ["70A#05"]);
}

#[test]
fn the_inhibit_time_keeps_emergencies_apart() {
    let mut t = Tester::booted();
    t.write(0x1015, 0, 2, 500).unwrap();
    t.bus(BusEvent::Overrun);
    t.bus(BusEvent::Overrun);
    let frames = t.wait(1000);
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
    let mut t = Tester::booted();
    t.write(0x1015, 0, 2, 100).unwrap();
    t.send("000#0200");
    t.bus(BusEvent::Overrun);
    assert_eq!(t.wait(1000), []);
    t.send("000#8000");
    let frames = t.wait(100);
    assert_eq!(frames.len(), 2);
    assert_eq!(frames[0], (0, "08A#1081111000000000".to_string()));
}

#[test]
fn emergencies_go_out_in_operational_and_do_not_change_the_state() {
    let mut t = Tester::operational();
    t.tilt(50.0, 0.0);
    assert_eq!(t.sent(), ["08A#0090010200000000"]);
    assert_eq!(t.exchange("70A#R1"), ["70A#05"]);
}

#[test]
fn a_fault_that_lasts_is_told_again_after_a_reset() {
    let mut t = Tester::booted();
    t.tilt(50.0, 0.0);
    t.sent();
    assert_eq!(t.exchange("000#8100"), ["70A#00", "08A#0090010200000000"]);
    assert_eq!(t.read(0x1003, 0), Ok(1));
}

/// The times at which the LEDs change within 3 s, in ms, and what they show then.
fn leds(t: &mut Tester) -> Vec<(u64, Leds)> {
    let mut changes = vec![(0, t.leds)];
    for ms in 1..=3000 {
        t.wait(1);
        let (_, last) = changes[changes.len() - 1];
        if t.leds != last {
            changes.push((ms, t.leds));
        }
    }
    changes
}

fn pattern(changes: &[(u64, Leds)], run: bool) -> Vec<(u64, bool)> {
    let mut list: Vec<_> = changes
        .iter()
        .map(|&(time, leds)| (time, if run { leds.run } else { leds.error }))
        .collect();
    list.dedup_by_key(|&mut (_, lit)| lit);
    list
}

#[test]
fn the_run_led_shows_the_state_as_the_manual_prints_it() {
    // On in pre-operational, flashing in operational, one short flash in stopped (11.3).
    let mut t = Tester::booted();
    assert_eq!(leds(&mut t), [(0, RUN)]);
    t.send("000#0100");
    let changes = leds(&mut t);
    let times: Vec<_> = pattern(&changes, true);
    assert_eq!(
        times[..4],
        [(0, true), (200, false), (400, true), (600, false)]
    );
    t.send("000#0200");
    let times = pattern(&leds(&mut t), true);
    assert_eq!(
        times[..4],
        [(0, true), (200, false), (1200, true), (1400, false)]
    );
}

#[test]
fn the_error_led_shows_the_worst_first() {
    let mut t = guarded();
    assert_eq!(pattern(&leds(&mut t), false), [(0, false)]);
    t.bus(state(BusState::Warning));
    let times = pattern(&leds(&mut t), false);
    assert_eq!(
        times[..4],
        [(0, true), (200, false), (1200, true), (1400, false)]
    );
    t.exchange("70A#R1");
    t.wait(300);
    let times = pattern(&leds(&mut t), false);
    assert_eq!(
        times[..5],
        [
            (0, true),
            (200, false),
            (400, true),
            (600, false),
            (1600, true)
        ]
    );
    t.bus(state(BusState::BusOff));
    assert_eq!(pattern(&leds(&mut t), false), [(0, true)]);
    t.bus(state(BusState::Active));
    t.send(&format!("60A#{}", write_request(0x100C, 0, 2, 0)));
    assert_eq!(pattern(&leds(&mut t), false), [(0, false)]);
}
