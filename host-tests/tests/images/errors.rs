//! Fault confinement (ISO 11898-1) as in the manual: no acknowledge, bus-off, and the LEDs (table 12).

use crate::rig::*;
use bench::{BusRate, Source};
use plumbline::can::BitRate;
use plumbline::node::{BusState, Leds};

const RATE: BitRate = BitRate::K125;

/// The recovery from bus-off: 128 times 11 recessive bits, in microseconds.
const RECOVERY: u64 = 128 * 11 * 8;

/// Maximum time error of the LEDs, in microseconds.
const PRECISION: u64 = 2_000;

/// The times in microseconds between the changes of an LED after the time `from` (in microseconds).
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

/// An LED has blinked at least `count` times, on for `on` and off for `off` milliseconds.
#[track_caller]
fn assert_blinks(rig: &Rig, from: u64, led: fn(&Leds) -> bool, [on, off]: [u64; 2], count: usize) {
    let intervals = intervals(rig, from, led);
    assert!(intervals.len() >= 2 * count, "{intervals:?}");
    for (lit, time) in intervals {
        let nominal = 1000 * if lit { on } else { off };
        assert!(time.abs_diff(nominal) <= PRECISION, "{lit} for {time} us");
    }
}

/// Destroys every frame of the sensor until it is bus-off.
fn drive_bus_off(rig: &mut Rig) {
    rig.bus.corrupt(32, Some(Source::Device(rig.sensor)));
    rig.send(&[fsc::INCLINATION]);
    rig.wait_until(100, 200, |rig| {
        rig.device().bus_state() == Some(BusState::BusOff)
    });
}

#[test]
pub fn run_led_flickers_during_detection_and_is_on_afterwards() {
    let mut rig = Rig::new("is2", RATE);
    // In steps: the simulator notes a change of an LED at the end of its run.
    (0..3_000).for_each(|_| rig.run(1));
    // From the first reading on.
    assert_blinks(&rig, 50_000, |leds| leds.run, [50, 50], 20);
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

#[test]
fn frame_without_acknowledge_is_repeated_until_a_node_acknowledges_it() {
    let mut rig = Rig::with("is2", BusRate::Wire, fixed("is2", RATE));
    rig.bus.close(rig.tester);
    rig.run(4_500);
    assert!(rig.log.is_empty());
    // ISO 11898-1: an error-passive node does not count a missing acknowledge.
    assert_eq!(rig.device().error_counters(), Some((128, 0)));
    assert_eq!(rig.device().bus_state(), Some(BusState::Passive));
    assert!(rig.device().leds().run);
    assert_blinks(&rig, 500_000, |leds| leds.error, [200, 1000], 2);

    rig.bus.open(rig.tester, Some(RATE), false);
    rig.boot_up();
    rig.poll();
    assert_eq!(rig.bus.disturbed(Source::Adapter(rig.tester)), 0);
    // Each sent frame decrements the error counter, until it is below the warning limit (96).
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

#[test]
pub fn sensor_without_recovery_stays_bus_off_until_a_restart() {
    let mut rig = Rig::booted("is2", RATE);
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
    assert!(rig.frames().is_empty(), "bus-off");
    assert_eq!(rig.bus.queued(rig.tester), 0);
    assert_eq!(rig.device().bus_state(), Some(BusState::BusOff));
    assert_eq!(rig.device().led_history().len(), changes);
    rig.power_cycle();
    rig.boot_up();
    rig.poll();
    assert!(!rig.device().leds().error);
}

#[test]
fn sensor_with_recovery_is_active_after_128_times_11_recessive_bits() {
    let mut rig = Rig::booted_with("is2", RATE, &[&[fsc::WRITE_BUS_OFF_RECOVERY, 1]]);
    drive_bus_off(&mut rig);
    let from = rig.bus.now().ticks();
    rig.wait_until(100, 100, |rig| {
        rig.device().bus_state() != Some(BusState::BusOff)
    });
    let took = rig.bus.now().ticks() - from;
    // The firmware detects bus-off within a sample period, the step above is 0.1 ms, and the node first waits for 11 bits.
    assert!(
        (RECOVERY - 100..RECOVERY + 6_500).contains(&took),
        "{took} us"
    );
    assert_eq!(rig.device().error_counters(), Some((0, 0)));
    rig.run(50);
    // The frame in the mailbox is still sent, once.
    let late: Vec<u8> = rig.frames().iter().map(|frame| frame.bytes()[0]).collect();
    assert_eq!(late, [fsc::INCLINATION]);
    rig.poll();
    assert!(!rig.device().leds().error);
}
