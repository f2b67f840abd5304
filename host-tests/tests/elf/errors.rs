//! Fault confinement (ISO 11898-1) as the manual wants it: no acknowledge, bus-off, and what the LEDs say (table 12).

use crate::rig::*;
use bench::{BusRate, Source};
use plumbline::can::BitRate;
use plumbline::node::{BusState, Leds};

const RATE: BitRate = BitRate::K125;

/// The recovery from bus-off: 128 times 11 recessive bits, in microseconds.
const RECOVERY: u64 = 128 * 11 * 8;

/// How precisely LEDs keep their times, in microseconds.
const PRECISION: u64 = 2_000;

/// Times in microseconds between the changes of an LED from `from` (in microseconds) on.
fn intervals(rig: &Rig, from: u64, led: fn(&Leds) -> bool) -> Vec<(bool, u64)> {
    let mut changes: Vec<(u64, bool)> = Vec::new();
    for (at, leds) in rig.device().led_history() {
        if changes.last().is_none_or(|(_, lit)| *lit != led(leds)) {
            changes.push((at.ticks(), led(leds)));
        }
    }
    changes.retain(|(at, _)| *at >= from);
    let pairs = changes.windows(2);
    pairs
        .map(|pair| (pair[0].1, pair[1].0 - pair[0].0))
        .collect()
}

/// An LED has blinked `count` times at least, lit for `on` and dark for `off` milliseconds.
#[track_caller]
fn assert_blinks(rig: &Rig, from: u64, led: fn(&Leds) -> bool, [on, off]: [u64; 2], count: usize) {
    let intervals = intervals(rig, from, led);
    assert!(intervals.len() >= 2 * count, "{intervals:?}");
    for (lit, time) in intervals {
        let nominal = 1000 * if lit { on } else { off };
        assert!(time.abs_diff(nominal) <= PRECISION, "{lit} for {time} us");
    }
}

/// Every frame of the sensor is destroyed until it is bus-off.
fn drive_bus_off(rig: &mut Rig) {
    rig.bus.corrupt(32, Some(Source::Device(rig.sensor)));
    rig.send(&[fsc::INCLINATION]);
    rig.wait_until(100, 200, |rig| {
        rig.device().bus_state() == Some(BusState::BusOff)
    });
}

#[test]
fn while_the_rate_is_detected_the_run_led_flickers_and_then_it_is_lit() {
    for name in MODELS {
        let mut rig = Rig::new(name, RATE);
        rig.run(3_000);
        assert_blinks(&rig, 0, |leds| leds.run, [50, 50], 20);
        assert!(!rig.device().leds().error);
        rig.bus.lead_detection();
        rig.run(100);
        rig.send(&[fsc::INCLINATION]);
        rig.boot_up();
        let changes = rig.device().led_history().len();
        rig.run(2_000);
        assert!(rig.device().led_history().len() - changes <= 1);
        let expected = Leds {
            run: true,
            error: false,
            ..Leds::default()
        };
        assert_eq!(rig.device().leds(), expected);
    }
}

#[test]
fn a_frame_that_nobody_acknowledges_goes_out_when_somebody_comes() {
    for name in MODELS {
        let mut rig = Rig::with(name, BusRate::Wire, fixed(name, RATE));
        rig.bus.close(rig.tester);
        rig.run(6_000);
        assert!(rig.log.is_empty());
        // ISO 11898-1: who is error passive and misses the acknowledge only counts no further.
        assert_eq!(rig.device().error_counters(), Some((128, 0)));
        assert_eq!(rig.device().bus_state(), Some(BusState::Passive));
        assert!(rig.device().leds().run);
        assert_blinks(&rig, 500_000, |leds| leds.error, [200, 1000], 2);

        rig.bus.open(rig.tester, Some(RATE), false);
        rig.boot_up();
        rig.poll();
        assert_eq!(rig.bus.disturbed(Source::Adapter(rig.tester)), 0);
        // Each frame that goes out counts one down, until the warning is over (96).
        for _ in 0..40 {
            rig.poll();
        }
        rig.run(10);
        assert_eq!(rig.device().bus_state(), Some(BusState::Active));
        let expected = Leds {
            run: true,
            error: false,
            ..Leds::default()
        };
        assert_eq!(rig.device().leds(), expected);
    }
}

#[test]
fn without_recovery_a_sensor_stays_bus_off_until_it_is_restarted() {
    for name in MODELS {
        let mut rig = Rig::booted(name, RATE);
        drive_bus_off(&mut rig);
        rig.run(10);
        let bus_off = Leds {
            run: true,
            error: true,
            ..Leds::default()
        };
        assert_eq!(rig.device().leds(), bus_off);
        let changes = rig.device().led_history().len();
        for _ in 0..100 {
            rig.send(&[fsc::INCLINATION]);
            rig.run(20);
        }
        assert!(rig.frames().is_empty(), "silent");
        assert_eq!(rig.bus.queued(rig.tester), 0);
        assert_eq!(rig.device().bus_state(), Some(BusState::BusOff));
        assert_eq!(rig.device().led_history().len(), changes);
        rig.power_cycle();
        rig.boot_up();
        rig.poll();
        assert!(!rig.device().leds().error);
    }
}

#[test]
fn with_recovery_a_sensor_comes_back_after_128_times_11_recessive_bits() {
    for name in MODELS {
        let mut rig = Rig::booted_with(name, RATE, &[&[fsc::WRITE_BUS_OFF_RECOVERY, 1]]);
        drive_bus_off(&mut rig);
        let from = rig.bus.now().ticks();
        rig.wait_until(100, 100, |rig| {
            rig.device().bus_state() != Some(BusState::BusOff)
        });
        let took = rig.bus.now().ticks() - from;
        // The firmware notices within a sample period; the step above is 0.1 ms; 11 bits before it takes part.
        assert!(
            (RECOVERY - 100..RECOVERY + 6_500).contains(&took),
            "{took} us"
        );
        assert_eq!(rig.device().error_counters(), Some((0, 0)));
        rig.run(50);
        // What was in the mailbox is still sent, once.
        let late: Vec<u8> = rig.frames().iter().map(|frame| frame.bytes()[0]).collect();
        assert_eq!(late, [fsc::INCLINATION]);
        rig.poll();
        assert!(!rig.device().leds().error);
    }
}
