//! A disturbance inverts one bit of the configuration. The sensor restores the bit or restarts, and answers again within a limited time.

use crate::rig::*;
use plumbline::can::BitRate;
use stm32_sim::chip::Chip;
use stm32_sim::io::{Io, Width};

/// The bits of a configuration register.
type Bits = (u32, u32);

/// The longest time without an answer in ms: of a sensor that continues to work, and after a reset by the watchdog with the slowest
/// oscillator.
const LONGEST: u64 = 2_000;
const WITH_WATCHDOG: u64 = 3_600;

/// The CAN controller: MCR, IER, BTR, FMR, FM1R, FS1R, FFA1R, FA1R, two banks.
const CAN: u32 = 0x4000_6400;
const CAN_REGISTERS: [Bits; 12] = [
    (0x000, 0x807F),
    (0x014, 0x0003_8F7F),
    (0x01C, 0x837F_03FF),
    (0x200, 1),
    (0x204, 0x3FFF),
    (0x20C, 0x3FFF),
    (0x214, 0x3FFF),
    (0x21C, 0x3FFF),
    (0x240, !0),
    (0x244, !0b1000),
    (0x248, !0),
    (0x24C, !0b1000),
];

/// Clocks, pins, timer of the heater, SPI, voltage detector.
fn others() -> Vec<Bits> {
    match chip() {
        Chip::F103 => vec![
            (0x4002_1000, 1 << 19 | 1),
            (0x4002_1004, 0x0000_3FF3),
            (0x4002_100C, 0x0000_123D),
            (0x4002_1010, 0x1200_4006),
            (0x4002_1014, 0x15),
            (0x4002_1018, 0x0000_123D),
            (0x4002_101C, 0x1200_4002),
            (0x4002_2000, 0x17),
            (0x4000_7000, 0xF0),
            (0x4001_0004, 0x6C01),
            (0x4001_0800, !0),
            (0x4001_0C00, !0),
            (0x4001_0C04, !0),
            (0x4001_1000, !0),
            (0x4001_1004, !0),
            (0x4000_0400, 0x81),
            (0x4000_041C, 0x0078),
            (0x4000_0420, 0x0100),
            (0x4000_0428, 0xFFFF),
            (0x4000_042C, 0xFFFF),
            (board().facts().spi.base(), 0x007F),
        ],
        Chip::F446 => vec![
            (0x4002_3808, 0x0000_FCF3),
            (0x4002_3830, 0x0020_0007),
            (0x4002_3840, 0x1200_4002),
            (0x4002_3850, 0x0020_8007),
            (0x4002_3860, 0x1200_4006),
            (0x4002_388C, 1 << 24),
            (0x4002_0000, !0),
            (0x4002_000C, !0),
            (0x4002_0024, !0),
            (0x4002_0400, !0),
            (0x4002_0408, !0),
            (0x4002_0424, !0),
            (0x4000_0420, 0x0100),
            (0x4000_3800, 0x007F),
        ],
    }
}

/// The converter of the supply: CR1, CR2 without the bits that start something, SMPR1, SMPR2, SQR1, SQR3, and CCR.
fn converter() -> Vec<Bits> {
    match chip() {
        Chip::F103 => vec![
            (0x4001_2404, 0x00C0_FFFF),
            (0x4001_2408, 0x001E_0903),
            (0x4001_240C, 0x00FF_FFFF),
            (0x4001_2410, 0x3FFF_FFFF),
            (0x4001_242C, 0x00F0_0000),
            (0x4001_2434, 0x1F),
        ],
        Chip::F446 => vec![
            (0x4001_2004, 0x07C0_FFFF),
            (0x4001_2008, 0x0F03),
            (0x4001_200C, 0x07FF_FFFF),
            (0x4001_2010, 0x3FFF_FFFF),
            (0x4001_202C, 0x00F0_0000),
            (0x4001_2034, 0x1F),
            (0x4001_2304, 0x0003_0000),
        ],
    }
}

/// A sensor that runs, and answers polls.
fn running() -> Rig {
    let mut rig = Rig::booted("is2tk", BitRate::M1);
    rig.microcontroller_mut().take_faults();
    rig.io().0.be_lenient();
    rig
}

/// Inverts a bit. Returns what reads the register; None if the model does not have the new value.
fn invert(rig: &mut Rig, address: u32, bit: u32) -> Option<u32> {
    let cycle = rig.microcontroller().core().cycle();
    let (io, now) = rig.io();
    let before = io.read(cycle, address, Width::Word).ok()?;
    let done = if address & !0x3FF == CAN {
        io.can.disturb(now, address - CAN, 1 << bit)
    } else {
        io.write(cycle, address, Width::Word, before ^ 1 << bit)
            .is_ok()
    };
    done.then_some(before)
}

/// Polls until there is an answer, and the register has its value again.
#[track_caller]
fn recover(rig: &mut Rig, address: u32, bit: u32, before: u32) {
    let starts = rig.device().boots();
    for ms in (0..WITH_WATCHDOG).step_by(50) {
        let restarted = rig.device().boots() > starts;
        rig.frames();
        rig.send(&[fsc::INCLINATION]);
        rig.run(50);
        let answers = rig
            .frames()
            .iter()
            .any(|frame| frame.bytes()[0] == fsc::INCLINATION);
        let cycle = rig.microcontroller().core().cycle();
        let value = rig.io().0.read(cycle, address, Width::Word);
        let is_restored = value.is_ok_and(|value| (value ^ before) >> bit & 1 == 0);
        if answers && is_restored {
            assert!(
                ms <= LONGEST || restarted,
                "{address:#x}, bit {bit}: {ms} ms"
            );
            return;
        }
    }
    panic!("{address:#x}, bit {bit}: the sensor does not answer, or does not restore the register");
}

fn each_bit(registers: &[Bits]) {
    let mut rig = running();
    for &(address, bits) in registers {
        for bit in (0..32).filter(|bit| bits >> bit & 1 != 0) {
            if let Some(before) = invert(&mut rig, address, bit) {
                recover(&mut rig, address, bit, before);
            }
        }
    }
    // The disturbances are violations of the manual, and some have restarted the sensor.
    std::mem::forget(rig);
}

#[test]
pub fn disturbed_bits_of_the_can_controller_are_restored() {
    let registers = CAN_REGISTERS.map(|(offset, bits)| (CAN + offset, bits));
    each_bit(&registers);
}

#[test]
pub fn disturbed_bits_of_clocks_pins_and_timers_are_restored() {
    each_bit(&others());
}

/// What AFIO_MAPR.SWJ_CFG reads as is undefined, so it must not be written back.
#[test]
pub fn restored_mapping_of_pins_keeps_the_debug_port_on() {
    const AFIO_MAPR: u32 = 0x4001_0004;
    const CAN_REMAP: u32 = 14;
    let mut rig = running();
    let starts = rig.device().boots();
    let before = invert(&mut rig, AFIO_MAPR, CAN_REMAP).expect("a register");
    recover(&mut rig, AFIO_MAPR, CAN_REMAP, before);
    assert_eq!(rig.device().boots(), starts, "without a restart");
    assert_eq!(rig.io().0.afio.debug_port(), 0);
    std::mem::forget(rig);
}

#[test]
pub fn disturbed_bits_of_the_converter_are_restored() {
    let mut rig = Rig::with("jn2101", bench::BusRate::Fixed(BitRate::K125), blank());
    rig.io().0.be_lenient();
    rig.run(500);
    for (address, bits) in converter() {
        for bit in (0..32).filter(|bit| bits >> bit & 1 != 0) {
            let Some(before) = invert(&mut rig, address, bit) else {
                continue;
            };
            rig.run(10);
            let cycle = rig.microcontroller().core().cycle();
            let value = rig.io().0.read(cycle, address, Width::Word);
            assert_eq!(value, Ok(before), "{address:#x}, bit {bit}");
        }
    }
    std::mem::forget(rig);
}

#[test]
pub fn disturbed_power_of_the_heater_is_restored() {
    const TIM3_CCR3: u32 = 0x4000_043C;
    let mut rig = running();
    rig.run(500);
    for bit in 5..10 {
        let power = rig.microcontroller().heater();
        invert(&mut rig, TIM3_CCR3, bit).expect("a register");
        rig.run(10);
        let now = rig.microcontroller().heater();
        assert!(now.abs_diff(power) < 20, "bit {bit}: {power}, then {now}");
    }
}
