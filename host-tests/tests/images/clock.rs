//! Failures of the crystal (it does not start, or it stops) and of the PLL.

use crate::rig::*;
use bench::BusRate;
use plumbline::can::BitRate;
use stm32_sim::rcc::ResetCause;

const RATE: BitRate = BitRate::K500;

/// Stops the crystal while the sensor drives the bus dominant.
fn stop_crystal_in_a_frame(rig: &mut Rig) {
    rig.send(&[fsc::INCLINATION]);
    rig.wait_until(1, 10, |rig| rig.device().is_dominant());
    let (io, now) = rig.io();
    io.rcc.stop_crystal(now);
}

#[test]
pub fn bus_is_recessive_after_crystal_stops_in_a_frame() {
    let mut rig = Rig::booted("is2", RATE);
    stop_crystal_in_a_frame(&mut rig);
    rig.expect_reset(ResetCause::Software);
    // The first 20 us are for NMI and some instructions at 8 MHz.
    for _ in 0..10_000 {
        rig.run_us(20);
        assert!(!rig.device().is_dominant(), "dominant at {}", rig.bus.now());
    }
}

#[test]
pub fn sensor_restarts_when_stopped_crystal_oscillates_again() {
    let mut rig = Rig::booted("is2", RATE);
    stop_crystal_in_a_frame(&mut rig);
    rig.expect_reset(ResetCause::Software);
    rig.run(5_000);
    assert_eq!(
        rig.device().boots(),
        2,
        "one restart, no resets by the watchdog"
    );
    assert!(rig.device().leds().error);
    rig.frames();
    rig.io().0.rcc.break_crystal(false);
    rig.boot_up();
    rig.poll();
    assert!(!rig.device().leds().error);
}

#[test]
pub fn heater_is_off_after_crystal_stops() {
    let mut rig = Rig::booted("is2tk", BitRate::K50);
    rig.run(500);
    assert!(rig.microcontroller().heater() > 0);
    let (io, now) = rig.io();
    io.rcc.stop_crystal(now);
    rig.expect_reset(ResetCause::Software);
    rig.run_us(20);
    assert_eq!(rig.microcontroller().heater(), 0);
    rig.run(3_000);
    assert_eq!(rig.microcontroller().heater(), 0);
}

/// The log message before the reset can take long, so the outputs must be safe before it. The crystal stops at different phases of the
/// instructions.
#[test]
pub fn bus_is_recessive_and_heater_off_before_the_reset() {
    for phase in 0..8 {
        let mut rig = Rig::booted("is2tk", RATE);
        rig.run(500);
        assert!(rig.microcontroller().heater() > 0);
        stop_crystal_in_a_frame(&mut rig);
        let (io, now) = rig.io();
        io.rcc.stop_crystal(now + phase * 125_000);
        rig.expect_reset(ResetCause::Software);
        rig.run_us(20);
        assert_eq!(rig.device().boots(), 2, "phase {phase}");
        rig.assert_safe_at_reset();
    }
}

#[test]
pub fn sensor_without_a_crystal_shows_the_error_led_and_stays_off_the_bus() {
    let mut rig = Rig::with("is2", BusRate::Fixed(RATE), fixed("is2", RATE));
    let [_, _, highest] = chip().facts().lsi;
    let (io, _) = rig.io();
    io.iwdg.set_lsi(highest);
    io.rcc.break_crystal(true);
    rig.run(1_000);
    assert!(rig.device().leds().error);
    rig.run(4_000);
    assert!(rig.device().leds().error);
    assert_eq!(rig.device().boots(), 1, "no reset");
    assert!(rig.log.is_empty());
    rig.io().0.rcc.break_crystal(false);
    rig.boot_up();
    rig.poll();
}

/// The boot waits without a limit for the PLL. The watchdog counts from FFFh until its first reload (RM0008 and RM0390, description of
/// IWDG).
#[test]
pub fn watchdog_resets_the_chip_within_its_period_if_the_pll_does_not_lock() {
    let mut rig = Rig::with("is2", BusRate::Fixed(RATE), fixed("is2", RATE));
    rig.io().0.rcc.break_pll(true);
    for resets in 2..4 {
        let from = rig.bus.now().ticks();
        rig.expect_reset(ResetCause::Watchdog);
        rig.wait_until(1000, 2_010, |rig| {
            rig.microcontroller().resets().len() == resets
        });
        assert!(rig.bus.now().ticks() - from > 1_980_000);
    }
    assert_eq!(rig.frames(), []);
    rig.io().0.rcc.break_pll(false);
    rig.boot_up();
    rig.poll();
}

#[test]
pub fn crystal_that_starts_after_a_second_is_used() {
    let mut rig = Rig::with("is2", BusRate::Fixed(RATE), fixed("is2", RATE));
    rig.io().0.rcc.break_crystal(true);
    rig.run(1_000);
    rig.io().0.rcc.break_crystal(false);
    rig.boot_up();
    // Until the first measurement.
    rig.run(60);
    assert_eq!(rig.poll()[1], 0);
    assert!(!rig.device().leds().error);
}

/// Without supply, the ST-LINK of a Nucleo outputs no clock. The second attempt starts X3, if it is mounted.
fn nucleo_without_usb_starts_with_its_crystal() {
    let mut rig = Rig::with("is2", BusRate::Fixed(RATE), fixed("is2", RATE));
    rig.io().0.rcc.mount_crystal();
    rig.run(400);
    assert!(rig.log.is_empty());
    rig.boot_up();
    rig.run(60);
    assert_eq!(rig.poll()[1], 0);
    assert!(!rig.device().leds().error);
}

#[test]
#[ignore = "another board: `.ci/long ignored`"]
fn nucleo_f446_without_usb_starts_with_its_crystal() {
    on_the_nucleo(nucleo_without_usb_starts_with_its_crystal);
}

#[test]
#[ignore = "another board: `.ci/long ignored`"]
fn nucleo_f103_without_usb_starts_with_its_crystal() {
    on_the_nucleo_f103(nucleo_without_usb_starts_with_its_crystal);
}
