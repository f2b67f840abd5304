//! A CAN controller that works no longer, after the boot: the sensor heals it or restarts, and does not wait for it without end.

use crate::rig::*;
use bench::BusRate;
use plumbline::can::BitRate;
use stm32_sim::bxcan::Silicon;
use stm32_sim::rcc::ResetCause;

const RATE: BitRate = BitRate::K500;

const CAN_IER: u32 = 0x4000_6414;

/// The longest time in ms without an answer of a sensor that continues to work or restarts by itself.
const LONGEST: u64 = 2_000;

/// A sensor that runs, and gets another CAN controller then. A disturbance makes it change the mode.
fn disturbed(silicon: Silicon) -> Rig {
    let mut rig = Rig::booted("is2", RATE);
    rig.io().0.be_lenient();
    rig.io().0.can.set_silicon(silicon);
    assert!(rig.microcontroller_mut().disturb(CAN_IER, 1 << 1));
    rig
}

/// After a restart it waits for the controller in the boot, and the watchdog resets it until the controller works again.
#[test]
pub fn controller_that_acknowledges_no_mode_any_more_restarts_the_sensor() {
    let mut rig = disturbed(Silicon {
        mode: u32::MAX,
        ..silicon().can
    });
    rig.expect_reset(ResetCause::Software);
    rig.wait_until(1000, LONGEST, |rig| rig.device().boots() == 2);
    rig.assert_safe_at_reset();
    rig.expect_reset(ResetCause::Watchdog);
    rig.wait_until(1000, 4_000, |rig| rig.device().boots() == 3);
    rig.io().0.can.set_silicon(silicon().can);
    rig.frames();
    rig.boot_up();
    rig.poll();
}

/// The bus is recessive, so nothing but the controller prevents the join.
#[test]
pub fn controller_that_never_joins_a_recessive_bus_restarts_the_sensor() {
    let deaf = Silicon {
        joins: false,
        ..silicon().can
    };
    let mut rig = disturbed(deaf);
    for boots in 2..4 {
        rig.expect_reset(ResetCause::Software);
        rig.wait_until(1000, LONGEST, |rig| rig.device().boots() == boots);
        rig.assert_safe_at_reset();
    }
    rig.io().0.can.set_silicon(silicon().can);
    rig.frames();
    rig.boot_up();
    rig.poll();
}

/// A dominant bus is no fault of the sensor. The error LED shows it as that of a sensor on the bus, whose counter reaches the warning limit.
#[test]
pub fn dominant_bus_at_the_start_blinks_the_error_led_without_a_restart() {
    let mut rig = Rig::with("is2", BusRate::Wire, fixed("is2", RATE));
    let tester = rig.tester;
    rig.bus.open(tester, Some(RATE), false);
    rig.bus.hold_dominant(ms(5_000));
    (0..5_000).for_each(|_| rig.run(1));
    let lit = |rig: &Rig| {
        let history = rig.device().led_history().iter();
        history.filter(|(_, leds)| leds.error && leds.run).count()
    };
    // 200 ms on, 1000 ms off, from 0.2 s on.
    let blinks = lit(&rig);
    assert!((4..=5).contains(&blinks), "{blinks}");
    rig.boot_up();
    rig.poll();
    rig.run(1_500);
    let blinks = lit(&rig);
    rig.run(1_500);
    assert_eq!(lit(&rig), blinks);
    assert!(!rig.device().leds().error);
}
