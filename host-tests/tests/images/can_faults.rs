//! Faults and delays of the real CAN controller: the sensor comes back by itself or is silent, and is never dominant.

use crate::rig::*;
use bench::{BusRate, Source};
use can_wire::protocol::Protocol;
use plumbline::can::BitRate;
use plumbline::node::{BusMode, BusState};
use stm32_sim::bxcan::{ResetTime, Silicon};
use stm32_sim::gpio::PinMode;
use stm32_sim::rcc::ResetCause;

/// The bit rate of the bus. The search begins at another one.
const RATE: BitRate = BitRate::K500;

/// The longest time of the detection in ms, with a frame every 20 ms.
const DETECTION_LIMIT: u32 = 1_000;

/// A sensor that detects the bit rate, on this chip. The tester sends at [`RATE`].
fn detecting(silicon: Silicon) -> Rig {
    let mut rig = Rig::with("is2", BusRate::Wire, blank());
    rig.io().0.can.set_silicon(silicon);
    // The registers get their values by a reset.
    rig.power_cycle();
    let tester = rig.tester;
    rig.bus.open(tester, Some(RATE), false);
    // Acknowledges the frames of the tester.
    let other = rig.bus.adapter();
    rig.bus.open(other, Some(RATE), false);
    rig.run(200);
    rig
}

/// Sends a frame every 20 ms until the sensor takes part. Until then its pin is recessive, and a port output.
#[track_caller]
fn detect(rig: &mut Rig) {
    let disturbed = rig.bus.disturbed(Source::Adapter(rig.tester));
    for ms in 0.. {
        assert!(ms < DETECTION_LIMIT, "the bit rate is not detected");
        if rig.device().mode() == Some(BusMode::Normal) {
            break;
        }
        let gpio = &rig.microcontroller().io().gpio;
        if rig.device().mode() == Some(BusMode::Listen) {
            assert_eq!(gpio.mode(board().facts().pins.transmit), PinMode::PushPull);
        }
        assert!(!rig.device().is_dominant(), "it is silent");
        if ms % 20 == 0 {
            rig.bus.send(rig.tester, data(0x1A5, &[ms as u8]));
        }
        rig.run(1);
    }
    let gpio = &rig.microcontroller().io().gpio;
    assert_eq!(
        gpio.mode(board().facts().pins.transmit),
        PinMode::AlternatePushPull
    );
    rig.boot_up();
    assert_eq!(rig.bus.disturbed(Source::Adapter(rig.tester)), disturbed);
}

/// It answers each of a few polls once, and has disturbed nothing. The error LED was off since the start.
#[track_caller]
fn assert_works(rig: &mut Rig) {
    let disturbed = rig.bus.disturbed(Source::Adapter(rig.tester));
    for _ in 0..3 {
        rig.poll();
        rig.run(10);
    }
    assert!(rig.frames().is_empty(), "one answer for each poll");
    assert_eq!(rig.bus.disturbed(Source::Adapter(rig.tester)), disturbed);
    assert_eq!(rig.device().bus_state(), Some(BusState::Active));
    let lit = rig
        .device()
        .led_history()
        .iter()
        .any(|(_, leds)| leds.error);
    assert!(!lit, "the error LED");
}

#[test]
pub fn reset_of_controller_can_take_any_time() {
    let cycles = [1, 10, 1_000, 40_000, 320_000, 1_600_000, 6_400_000];
    let reads = [1, 2, 100];
    let times = cycles.map(ResetTime::Cycles).into_iter();
    let times = times.chain(reads.map(ResetTime::Reads));
    for reset in times.chain([ResetTime::Endless]) {
        println!("{reset:?}");
        let mut rig = detecting(Silicon {
            reset,
            ..silicon().can
        });
        detect(&mut rig);
        assert_works(&mut rig);
    }
}

/// The boot waits without a limit for initialization mode, so the watchdog must run before.
#[test]
pub fn watchdog_resets_the_chip_if_the_can_controller_acknowledges_no_mode() {
    let mut rig = Rig::with("is2", BusRate::Fixed(RATE), fixed("is2", RATE));
    rig.io().0.can.set_silicon(Silicon {
        mode: u32::MAX,
        ..silicon().can
    });
    for resets in 2..4 {
        rig.expect_reset(ResetCause::Watchdog);
        rig.wait_until(1000, 4_000, |rig| {
            rig.microcontroller().resets().len() == resets
        });
        rig.assert_safe_at_reset();
    }
    assert_eq!(rig.frames(), []);
    // A part that works again is used again.
    rig.io().0.can.set_silicon(silicon().can);
    rig.boot_up();
    rig.poll();
}

#[test]
fn changes_of_mode_can_take_any_time() {
    for mode in [0, 1, 100, 40_000, 320_000] {
        println!("{mode} cycles");
        let mut rig = detecting(Silicon {
            mode,
            ..silicon().can
        });
        detect(&mut rig);
        assert_works(&mut rig);
    }
}

#[test]
fn frame_is_received_once_when_release_of_mailbox_takes_time() {
    for release in [0, 1, 2, 3, 5, 10, 100] {
        println!("{release} cycles");
        let mut rig = detecting(Silicon {
            release,
            ..silicon().can
        });
        detect(&mut rig);
        assert_works(&mut rig);
        // Three frames back to back.
        for _ in 0..3 {
            rig.send(&[fsc::INCLINATION]);
        }
        rig.run(20);
        assert_eq!(rig.frames().len(), 3);
    }
}

#[test]
fn bus_errors_during_bit_rate_detection_are_not_reported() {
    let mut rig = detecting(silicon().can);
    // The receive error counter reaches its maximum.
    rig.bus.hold_dominant(ms(5));
    rig.run(20);
    let counters = rig.device().error_counters();
    assert!(counters.is_some_and(|(_, receive)| receive >= 128));
    detect(&mut rig);
    assert_eq!(rig.device().error_counters(), Some((0, 0)));
    assert_works(&mut rig);
}

#[test]
pub fn transmit_output_that_locks_in_silent_mode_never_reaches_the_bus() {
    for uses in [0, 1, 2] {
        let mut rig = detecting(Silicon {
            lock_after: Some(uses),
            ..silicon().can
        });
        for start in 0..4 {
            println!("locks after {uses}, start {start}");
            detect(&mut rig);
            assert!(!rig.microcontroller().can().is_locked());
            assert_works(&mut rig);
            rig.expect_reset(ResetCause::Software);
            rig.send(&fsc::RESET);
            rig.run(300);
            rig.frames();
        }
    }
}

#[test]
pub fn filters_do_not_depend_on_can2sb() {
    for filter_master in [0, 0x3F00, 0x2A1C_0E00] {
        let mut rig = detecting(Silicon {
            filter_master,
            ..silicon().can
        });
        detect(&mut rig);
        assert_works(&mut rig);
    }
}

/// The time in ms in which the watchdog with the fastest oscillator ends.
const WATCHDOG: u64 = 1_500;

/// The comparison ten times a second finds it. The controller is set twice, and then its value is no disturbance. It is not reset for it
/// again, so no poll is lost, and a later disturbance ends at once.
#[test]
pub fn value_that_the_controller_does_not_take_leads_to_one_reset_of_it() {
    const CAN_IER: u32 = 0x4000_6414;
    let mut rig = Rig::booted("is2", RATE);
    rig.io().0.be_lenient();
    let silicon = Silicon {
        timing_reads: !(0b11 << 24),
        ..silicon().can
    };
    let sets = |rig: &Rig| rig.microcontroller().can().btr_history().len();
    let before = sets(&rig);
    rig.io().0.can.set_silicon(silicon);
    rig.run(200);
    assert_eq!(sets(&rig) - before, 2);
    rig.frames();
    for _ in 0..100 {
        rig.send(&[fsc::INCLINATION]);
        rig.run(50);
    }
    assert_eq!(sets(&rig) - before, 2);
    assert_eq!(rig.frames().len(), 100);
    for bit in 0..2 {
        let sensor = rig.microcontroller_mut();
        let value = sensor.configured(CAN_IER);
        assert!(sensor.disturb(CAN_IER, 1 << bit));
        rig.run(120);
        assert_eq!(rig.microcontroller_mut().configured(CAN_IER), value);
    }
    rig.poll();
    std::mem::forget(rig);
}

/// As [`hold`], for so long that a main loop that waits for the bus would be restarted.
fn outlast(rig: &mut Rig) {
    let [_, _, highest] = chip().facts().lsi;
    rig.io().0.iwdg.set_lsi(highest);
    hold(rig, WATCHDOG);
}

/// Holds the wire dominant; the sensor is not dominant for longer than its error flags, and does not restart.
fn hold(rig: &mut Rig, time: u64) {
    rig.bus.hold_dominant(ms(time));
    rig.run(time);
    assert!(!rig.device().is_dominant());
}

#[test]
fn dominant_bus_during_bit_rate_detection_only_delays_the_start() {
    for reset in [ResetTime::Cycles(64), ResetTime::Endless] {
        let mut rig = detecting(Silicon {
            reset,
            ..silicon().can
        });
        for phase in [10, 40, 80, 100, 110] {
            // The wire becomes dominant in or after a frame, and the frame makes the sensor change the bit rate.
            rig.bus.send(rig.tester, data(0x1A5, &[0x55]));
            rig.run_us(phase);
            rig.bus.hold_dominant(ms(100));
            rig.bus.close(rig.tester);
            rig.run(100);
            assert_eq!(rig.device().mode(), Some(BusMode::Listen));
            assert!(!rig.device().is_dominant());
            let tester = rig.tester;
            rig.bus.open(tester, Some(RATE), false);
        }
        outlast(&mut rig);
        detect(&mut rig);
        rig.poll();
        assert_eq!(rig.device().bus_state(), Some(BusState::Active));
    }
}

#[test]
fn dominant_bus_while_joining_at_a_fixed_rate_only_delays_the_start() {
    let mut rig = Rig::with("is2", BusRate::Wire, fixed("is2", RATE));
    let tester = rig.tester;
    rig.bus.open(tester, Some(RATE), false);
    outlast(&mut rig);
    assert!(rig.log.is_empty());
    rig.boot_up();
    rig.poll();
}

/// The recovery from bus-off enters initialization mode, for which the controller waits for the end of a frame.
#[test]
fn dominant_bus_during_recovery_from_bus_off_only_delays_the_recovery() {
    for reset in [
        ResetTime::Cycles(64),
        ResetTime::Reads(1),
        ResetTime::Endless,
    ] {
        for delay in [0, 500, 2_000, 5_000, 6_000, 20_000] {
            let mut rig = Rig::booted_with("is2", RATE, &[&[fsc::WRITE_BUS_OFF_RECOVERY, 1]]);
            rig.io().0.can.set_silicon(Silicon {
                reset,
                ..silicon().can
            });
            rig.bus.corrupt(32, Some(Source::Device(rig.sensor)));
            rig.send(&[fsc::INCLINATION]);
            rig.wait_until(50, 200, |rig| {
                rig.device().bus_state() == Some(BusState::BusOff)
            });
            rig.run_us(delay);
            if delay == 5_000 {
                outlast(&mut rig);
            } else {
                hold(&mut rig, 100);
            }
            rig.run(100);
            rig.frames();
            rig.poll();
        }
    }
}

/// Another COB-ID begins with initialization mode, for which the controller waits for the end of a frame.
#[test]
fn dominant_bus_while_leaving_the_bus_only_delays_the_change() {
    const BOOT_UP: u16 = 0x70A;
    // SDO: the COB-ID of the SYNC (1005h) is 81h.
    let request = data(0x60A, &[0x23, 0x05, 0x10, 0, 0x81, 0, 0, 0]);
    let reply = data(0x58A, &[0x60, 0x05, 0x10, 0, 0, 0, 0, 0]);
    let resets = [
        ResetTime::Cycles(64),
        ResetTime::Reads(1),
        ResetTime::Endless,
    ];
    for reset in resets {
        for phase in [0, 10, 20, 40, 100, 1_000] {
            let mut rig = Rig::with("jn2101", BusRate::Wire, blank());
            let tester = rig.tester;
            rig.bus.open(tester, Some(BitRate::K125), false);
            rig.expect(BOOT_UP, 1_000);
            rig.io().0.can.set_silicon(Silicon {
                reset,
                ..silicon().can
            });
            rig.bus.send(tester, request);
            rig.wait_until(10, 10, |rig| rig.bus.queued(rig.tester) == 0);
            rig.run_us(phase);
            hold(&mut rig, 100);
            if phase < 100 {
                // It has left the bus although the frame has not ended.
                let joins = rig.device().protocol().map(Protocol::is_joining);
                assert_eq!(joins, Some(true), "{reset:?}, {phase} us");
            }
            rig.run(300);
            assert!(
                rig.frames().contains(&reply),
                "{reset:?}, {phase} us after the request"
            );
        }
    }
}
