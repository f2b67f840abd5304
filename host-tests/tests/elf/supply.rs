//! Dips of the supply: the flash is not programmed or erased below the level of the detector (DS5319: it needs 2.0 V), and the
//! parameters stay valid.

use crate::rig::*;
use bench::BusRate;
use plumbline::can::BitRate;
use stm32_sim::rcc::ResetCause;

const RATE: BitRate = BitRate::K500;

/// Sets the supply, in mV, within this time in microseconds.
fn supply(rig: &mut Rig, millivolts: u32, us: u64) {
    let (io, now) = rig.io();
    io.pwr.ramp(now, millivolts, us * 1_000_000);
}

fn write_time(rig: &mut Rig, value: u16) {
    let [low, high] = value.to_le_bytes();
    rig.write(&[fsc::WRITE_CYCLIC_TIME, low, high]);
}

fn read_time(rig: &mut Rig) -> u16 {
    let reply = rig.request(&[fsc::READ_CYCLIC_TIME]);
    u16::from_le_bytes([reply[2], reply[3]])
}

#[test]
fn save_at_a_low_supply_is_refused_and_changes_nothing() {
    for name in MODELS {
        let mut rig = Rig::booted(name, RATE);
        write_time(&mut rig, 777);
        supply(&mut rig, 2500, 0);
        let before = rig.flash().bytes().to_vec();
        let errors = status::CMD_PARAM_ERROR | status::EEPROM_ERROR;
        assert_eq!(rig.request(&fsc::SAVE), [fsc::SAVE[0], errors], "{name}");
        assert_eq!(rig.flash().bytes(), before, "{name}");
        supply(&mut rig, 3300, 0);
        // Table 14: the errors stay until the status is read.
        rig.request(&[fsc::STATUS]);
        rig.save();
        rig.power_cycle();
        rig.boot_up();
        assert_eq!(read_time(&mut rig), 777, "{name}");
    }
}

/// The supply falls from 3.3 V to 0 V in 6 ms, from the level of the detector to the limit of the flash in 1.2 ms.
#[test]
fn save_ends_before_the_supply_is_too_low() {
    let mut rig = Rig::booted("is2", RATE);
    let mut old = read_time(&mut rig);
    for wait in (0..3_000).step_by(250) {
        let new = 1000 + wait;
        write_time(&mut rig, new);
        supply(&mut rig, 0, 6_000);
        rig.run_us(u64::from(wait));
        rig.send(&fsc::SAVE);
        rig.run(10);
        assert!(rig.device().is_on(), "the power is not cut in an operation");
        rig.frames();
        rig.expect_reset(ResetCause::PowerOn);
        supply(&mut rig, 3300, 1_000);
        rig.boot_up();
        let value = read_time(&mut rig);
        assert!(value == old || value == new, "{value} after {wait} us");
        old = value;
    }
}

#[test]
fn sensor_starts_when_the_supply_is_high_enough_to_erase() {
    let mut rig = Rig::with("is2", BusRate::Fixed(RATE), fixed("is2", RATE));
    supply(&mut rig, 2500, 0);
    rig.run(10_000);
    assert!(rig.log.is_empty());
    assert!(rig.device().leds().error);
    supply(&mut rig, 3300, 100);
    rig.boot_up();
    rig.poll();
    assert_eq!(rig.device().boots(), 1);
}
