//! Dips of the supply: the flash is not programmed or erased below the level of the detector, and the parameters stay valid. The
//! flash needs 2.0 V on the Blue Pill (DS5319), and 2.7 V for words on the Nucleo (DS10693).

use crate::memory::save_until_erased;
use crate::rig::*;
use bench::BusRate;
use plumbline::can::BitRate;
use stm32_sim::chip::Chip;
use stm32_sim::flash::Times;
use stm32_sim::pwr::Part;
use stm32_sim::rcc::ResetCause;

const RATE: BitRate = BitRate::K500;

/// A supply in mV at which the flash of every part can be programmed, but the firmware does not program, because the detector of every part
/// reports it. The brown-out reset of the Nucleo can begin below it.
fn low() -> u32 {
    match chip() {
        Chip::F103 => 2500,
        Chip::F446 => 2750,
    }
}

/// Sets the supply, in mV, within this time in microseconds.
fn supply(rig: &mut Rig, millivolts: u32, us: u64) {
    let (io, now) = rig.io();
    io.pwr.ramp(now, millivolts, us * 1_000_000);
}

#[test]
pub fn save_at_a_low_supply_is_refused_and_changes_nothing() {
    let mut rig = Rig::booted("is2", RATE);
    rig.io().0.pwr.set_part(Part::Lowest);
    rig.write_time(777);
    supply(&mut rig, low(), 0);
    let before = rig.flash().bytes().to_vec();
    let errors = status::CMD_PARAM_ERROR | status::EEPROM_ERROR;
    assert_eq!(rig.request(&fsc::SAVE), [fsc::SAVE[0], errors]);
    assert_eq!(rig.flash().bytes(), before);
    supply(&mut rig, 3300, 0);
    // Table 14: the errors stay until the status is read.
    rig.request(&[fsc::STATUS]);
    rig.save();
    rig.power_cycle();
    rig.boot_up();
    assert_eq!(rig.read_time(), 777);
}

#[test]
pub fn save_that_must_erase_at_a_low_supply_erases_nothing() {
    let mut rig = Rig::booted("is2", RATE);
    rig.io().0.pwr.set_part(Part::Lowest);
    save_until_erased(&mut rig);
    for _ in 1..save_until_erased(&mut rig) {
        rig.save();
    }
    supply(&mut rig, low(), 0);
    let before = rig.flash().bytes().to_vec();
    let errors = status::CMD_PARAM_ERROR | status::EEPROM_ERROR;
    assert_eq!(rig.request(&fsc::SAVE), [fsc::SAVE[0], errors]);
    assert_eq!(rig.flash().bytes(), before);
    supply(&mut rig, 3300, 0);
    rig.request(&[fsc::STATUS]);
    let erased = rig.flash().erased();
    rig.save();
    assert!(rig.flash().erased() > erased, "this save erases a page");
}

/// The supply falls from 3.3 V to 0 V in 6 ms: from the level of the detector to the limit of the flash in 1.2 ms on the Blue Pill.
/// On the Nucleo it takes 0.18 ms to the brown-out reset, and 0.27 ms to the limit without it.
#[test]
pub fn save_ends_before_the_supply_is_too_low() {
    let brown_outs: &[bool] = match chip() {
        Chip::F103 => &[false],
        Chip::F446 => &[true, false],
    };
    for part in [Part::Lowest, Part::Typical, Part::Highest] {
        for brown_out in brown_outs {
            save_ends_in_time(part, *brown_out);
        }
    }
}

fn save_ends_in_time(part: Part, brown_out: bool) {
    let mut rig = Rig::booted("is2", RATE);
    let (io, _) = rig.io();
    io.flash.set_times(Times::longest(chip()));
    io.pwr.set_part(part);
    if !brown_out {
        io.pwr.disable_brown_out();
    }
    let mut old = rig.read_time();
    // The detector reports after 0.6 to 1.2 ms.
    for wait in (0..1_500).step_by(125) {
        let new = 1000 + wait;
        rig.write_time(new);
        supply(&mut rig, 0, 6_000);
        rig.run_us(u64::from(wait));
        rig.send(&fsc::SAVE);
        rig.run(10);
        assert!(rig.device().is_on(), "the power is not cut in an operation");
        rig.frames();
        rig.expect_reset(ResetCause::PowerOn);
        supply(&mut rig, 3300, 1_000);
        rig.boot_up();
        let value = rig.read_time();
        assert!(
            value == old || value == new,
            "{value} after {wait} us, {part:?}"
        );
        old = value;
    }
}

#[test]
pub fn sensor_starts_when_the_supply_is_high_enough_to_erase() {
    let mut rig = Rig::with("is2", BusRate::Fixed(RATE), fixed("is2", RATE));
    rig.io().0.pwr.set_part(Part::Lowest);
    supply(&mut rig, low(), 0);
    rig.run(10_000);
    assert!(rig.log.is_empty());
    assert!(rig.device().leds().error);
    supply(&mut rig, 3300, 100);
    rig.boot_up();
    rig.poll();
    assert_eq!(rig.device().boots(), 1);
}
