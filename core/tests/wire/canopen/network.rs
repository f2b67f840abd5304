//! NMT, boot-up, error control and LEDs of the JN2101 (CiA 301, 7.2.8, 7.3.2; manual 7.2, 7.3, 11).

use crate::tester::canopen::*;
use crate::tester::leds as lit;
use plumbline::can::BitRate;
use plumbline::node::{Action, BusEvent, BusMode, BusState, Leds};

const RUN: Leds = lit(true, false);

fn state(state: BusState) -> BusEvent {
    BusEvent::State(state)
}

#[test]
fn node_after_boot_up_is_pre_operational() {
    let mut t = power_up();
    assert!(
        t.actions
            .contains(&Action::Bus(BusMode::Normal, BitRate::K125))
    );
    assert!(t.actions.contains(&Action::Termination(true)));
    assert_eq!(t.sent_text(), ["70A#00"]);
    assert_eq!(t.exchange("70A#R1"), ["70A#7F"]);
    assert_eq!(t.wait_text(5000), []);
}

#[test]
fn reset_commands_in_any_state_send_boot_up() {
    for state in ["000#800A", "000#010A", "000#020A"] {
        for reset in ["000#810A", "000#8100", "000#820A", "000#8200"] {
            let mut t = booted();
            t.send(state);
            assert_eq!(t.exchange(reset), ["70A#00"], "{state} {reset}");
            assert_eq!(t.wait_text(500), []);
            assert_eq!(t.exchange("70A#R1"), ["70A#7F"]);
        }
        let mut t = booted();
        t.send(state);
        assert_eq!(t.exchange("000#810B"), [""; 0]);
        assert_eq!(t.exchange("000#820B"), [""; 0]);
    }
}

#[test]
fn reset_communication_and_reset_node_restore_stored_parameters() {
    let mut t = booted();
    t.write(0x1017, 0, 2, 500).unwrap();
    t.write(0x2044, 0, 1, 2).unwrap();
    t.store();
    t.write(0x1017, 0, 2, 100).unwrap();
    t.write(0x1029, 1, 1, 2).unwrap();
    t.write(0x2044, 0, 1, 3).unwrap();
    t.send("000#8200");
    assert_eq!(t.sent_text(), ["70A#00"]);
    assert_eq!(t.read(0x1017, 0), Ok(500));
    assert_eq!(t.read(0x1029, 1), Ok(0), "1029h is not stored");
    assert_eq!(t.read(0x2044, 0), Ok(3), "not a communication parameter");
    t.send("000#8100");
    assert_eq!(t.sent_text(), ["70A#00"]);
    assert_eq!(t.read(0x2044, 0), Ok(2));
}

#[test]
fn start_up_8_starts_node_and_2_starts_all_nodes() {
    for (value, frames) in [(8, &["70A#00"][..]), (2, &["70A#00", "000#0100"])] {
        let mut t = booted();
        t.write(0x1F80, 0, 4, value).unwrap();
        t.store();
        assert_eq!(t.exchange("70A#R1"), ["70A#7F"], "acts only after a reset");
        for _ in 0..2 {
            t.power_cycle();
            assert_eq!(t.sent_text(), frames);
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
fn heartbeat_is_sent_in_all_states() {
    let mut t = booted();
    assert_eq!(t.wait_text(1000), []);
    t.write(0x1017, 0, 2, 250).unwrap();
    let beat = |ms, state: &str| (ms, format!("70A#{state}"));
    assert_eq!(t.wait_text(500), [beat(250, "7F"), beat(500, "7F")]);
    t.send("000#0100");
    assert_eq!(t.wait_text(250), [beat(250, "05")]);
    t.send("000#0200");
    assert_eq!(t.wait_text(250), [beat(250, "04")]);
    t.send("000#8000");
    t.write(0x1017, 0, 2, 0).unwrap();
    assert_eq!(t.wait_text(1000), []);
    // After a reset, the period begins with the boot-up message.
    t.write(0x1017, 0, 2, 250).unwrap();
    t.store();
    assert_eq!(t.exchange("000#8200"), ["70A#00"]);
    assert_eq!(t.wait_text(250), [beat(250, "7F")]);
}

#[test]
fn guarding_replies_have_toggle_bit_starting_at_0() {
    let mut t = booted();
    assert_eq!(t.exchange("70A#R1"), ["70A#7F"]);
    assert_eq!(t.exchange("70A#R1"), ["70A#FF"]);
    t.send("000#0100");
    assert_eq!(t.exchange("70A#R1"), ["70A#05"]);
    t.send("000#0200");
    assert_eq!(t.exchange("70A#R1"), ["70A#84"]);
    assert_eq!(t.exchange("70A#R1"), ["70A#04"]);
    for ignored in ["70B#R1", "700#R1", "0000070A#R1", "70A#00"] {
        assert_eq!(t.exchange(ignored), [""; 0], "{ignored}");
    }
    for length in ["70A#R0", "70A#R8"] {
        assert_eq!(t.exchange(length).len(), 1, "{length}");
    }
    for reset in ["000#8200", "000#8100"] {
        assert_eq!(t.exchange(reset), ["70A#00"]);
        assert_eq!(t.exchange("70A#R1"), ["70A#7F"]);
    }
}

#[test]
fn heartbeat_overrides_guarding() {
    let mut t = booted();
    t.write(0x100C, 0, 2, 100).unwrap();
    t.write(0x100D, 0, 1, 2).unwrap();
    t.exchange("70A#R1");
    t.write(0x1017, 0, 2, 1000).unwrap();
    assert_eq!(
        t.wait_text(1000),
        [(1000, "70A#7F".to_string())],
        "no emergency"
    );
    assert_eq!(t.exchange("70A#R1"), [""; 0]);
    t.write(0x1017, 0, 2, 0).unwrap();
    assert_eq!(t.exchange("70A#R1").len(), 1);
    assert_eq!(
        t.wait_text(200),
        [(200, "08A#3081114000000000".to_string())]
    );
}

/// Guard time 100 ms, life time factor 3.
fn guarded() -> Jn2101Tester {
    let mut t = booted();
    t.write(0x100C, 0, 2, 100).unwrap();
    t.write(0x100D, 0, 1, 3).unwrap();
    t
}

#[test]
fn life_guarding_time_out_sends_emergency() {
    let mut t = guarded();
    t.send("000#0100");
    assert_eq!(
        t.wait_text(1000),
        [],
        "life guarding begins with the first request"
    );
    assert_eq!(t.exchange("70A#R1"), ["70A#05"]);
    t.wait_text(299);
    assert_eq!(t.exchange("70A#R1"), ["70A#85"]);
    // 8130h, communication and generic bit, status bit 6; back to pre-operational.
    assert_eq!(
        t.wait_text(1000),
        [(300, "08A#3081114000000000".to_string())]
    );
    assert_eq!(t.read(0x1001, 0), Ok(0x11));
    assert_eq!(t.read(0x1003, 0), Ok(1));
    assert_eq!(t.read(0x1003, 1), Ok(0x4011_8130));
    // The master sends requests again.
    assert_eq!(t.exchange("70A#R1"), ["70A#7F", "08A#0000000000000000"]);
    assert_eq!(t.read(0x1001, 0), Ok(0));
    assert_eq!(t.read(0x1003, 0), Ok(1));
    // The next time-out is reported again.
    assert_eq!(
        t.wait_text(1000),
        [(300, "08A#3081114000000000".to_string())]
    );
    assert_eq!(t.read(0x1003, 0), Ok(2));
}

#[test]
fn life_time_of_more_than_32_bits_in_us_does_not_overflow() {
    // 16,843,009 ms * 1000 is 2^32 * 3.92; 4,294,968 ms * 1000 is just above 2^32.
    for (guard_time, factor) in [(65_535, 255), (64_103, 67), (65_535, 66)] {
        let mut t = guarded();
        t.write(0x100C, 0, 2, guard_time).unwrap();
        t.write(0x100D, 0, 1, factor).unwrap();
        t.exchange("70A#R1");
        let life = u64::from(guard_time) * u64::from(factor);
        t.sampled = false;
        // Without samples the node reports its accelerometer.
        assert_eq!(t.wait_text(life - 1).len(), 1, "{guard_time} {factor}");
        let time_out = (1, "08A#3081114100000000".to_string());
        assert_eq!(t.wait_text(1), [time_out]);
    }
}

#[test]
fn reset_ends_life_guarding_until_the_next_request() {
    for command in ["000#810A", "000#820A"] {
        let mut t = guarded();
        t.store();
        t.exchange("70A#R1");
        assert_eq!(t.exchange(command), ["70A#00"]);
        assert_eq!(t.wait_text(2000), [], "{command}");
        t.exchange("70A#R1");
        assert_eq!(t.wait_text(300).len(), 1);
    }
}

#[test]
fn reset_clears_life_guarding_time_out() {
    for command in ["000#810A", "000#820A"] {
        let mut t = guarded();
        t.exchange("70A#R1");
        t.wait_text(400);
        assert_eq!(t.read(0x1001, 0), Ok(0x11));
        let sent = t.exchange(command);
        assert_eq!(sent[0], "70A#00");
        assert!(!sent.iter().any(|frame| frame.starts_with("08A#3081")));
        assert_eq!(t.read(0x1001, 0), Ok(0), "{command}");
        assert_eq!(t.wait_text(2000), []);
    }
}

#[test]
fn error_behaviour_selects_state_after_time_out() {
    for (start, behaviour, end) in [
        ("000#0100", 0, "FF"),
        ("000#0100", 1, "85"),
        ("000#0100", 2, "84"),
        ("000#8000", 0, "FF"),
        ("000#8000", 1, "FF"),
        ("000#8000", 2, "84"),
        ("000#0200", 0, "84"),
        ("000#0200", 1, "84"),
        ("000#0200", 2, "84"),
    ] {
        let mut t = guarded();
        t.write(0x1029, 1, 1, behaviour).unwrap();
        t.send(start);
        t.exchange("70A#R1");
        t.wait_text(400);
        let answer = &t.exchange("70A#R1")[0];
        assert_eq!(answer, &format!("70A#{end}"), "{start} {behaviour}");
    }
}

#[test]
fn life_guarding_without_guard_time_or_factor_is_off() {
    for (guard_time, factor) in [(0, 3), (100, 0)] {
        let mut t = booted();
        t.write(0x100C, 0, 2, guard_time).unwrap();
        t.write(0x100D, 0, 1, factor).unwrap();
        assert_eq!(t.exchange("70A#R1"), ["70A#7F"]);
        assert_eq!(t.wait_text(10_000), []);
    }
    // Switching life guarding off after a time-out ends the error.
    let mut t = guarded();
    t.exchange("70A#R1");
    t.wait_text(300);
    let off = format!("60A#{}", write_request(0x100C, 0, 2, 0));
    assert_eq!(
        t.exchange(&off),
        ["58A#600C100000000000", "08A#0000000000000000"]
    );
    assert_eq!(t.read(0x1001, 0), Ok(0));
}

/// The times in ms at which the LEDs change within 3 s, and their new state.
fn leds(t: &mut Jn2101Tester) -> Vec<(u64, Leds)> {
    let mut changes = vec![(0, t.leds)];
    for ms in 1..=3000 {
        t.wait_text(1);
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
fn run_led_shows_state_as_in_manual() {
    // On in pre-operational, flashing in operational, one short flash in stopped (11.3).
    let mut t = booted();
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
fn error_led_shows_error_with_highest_priority() {
    let mut t = guarded();
    assert_eq!(pattern(&leds(&mut t), false), [(0, false)]);
    t.bus(state(BusState::Warning));
    let times = pattern(&leds(&mut t), false);
    assert_eq!(
        times[..4],
        [(0, true), (200, false), (1200, true), (1400, false)]
    );
    t.exchange("70A#R1");
    t.wait_text(300);
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
