//! A disturbance inverts one bit of the configuration. The sensor restores the bit or restarts, and answers again within a limited time.

mod left_out;

use crate::detection::Traffic;
use crate::rig::*;
use bench::{BusRate, Source};
use host_tests::effort;
use plumbline::can::BitRate;
use plumbline::node::BusState;
use std::collections::BTreeMap;
use std::ops::Range;
use stm32_sim::board::Board;
use stm32_sim::chip::Chip;

/// The longest time without an answer in ms: of a sensor that continues to work, and after a reset by the watchdog with the slowest
/// oscillator.
const LONGEST: u64 = 2_000;
const WITH_WATCHDOG: u64 = 3_600;

/// The addresses of the CAN controller, of the converter, of the system control space.
const CAN: Range<u32> = 0x4000_6400..0x4000_6800;
const CONVERTER: Range<u32> = 0x4001_2000..0x4001_2800;
const CORE: Range<u32> = 0xE000_E000..0xE000_F000;

/// A sensor that runs, and answers polls.
fn running() -> Rig {
    let mut rig = Rig::booted("is2tk", BitRate::M1);
    rig.microcontroller_mut().take_faults();
    rig.io().0.be_lenient();
    rig
}

/// The bits that a test has inverted, by the address of their register.
type Inverted = BTreeMap<u32, u32>;

/// Inverts a bit. Returns the value of the register before; None if the register does not have this bit, or the simulated chip not the new
/// value.
fn invert(rig: &mut Rig, address: u32, bit: u32) -> Option<u32> {
    let sensor = rig.microcontroller_mut();
    let before = sensor.configured(address)?;
    sensor.disturb(address, 1 << bit).then_some(before)
}

/// Polls until there is an answer, and the register has its value again if `restored`.
fn recover(
    rig: &mut Rig,
    address: u32,
    bit: u32,
    before: u32,
    restored: bool,
) -> Result<(), String> {
    let starts = rig.device().boots();
    for ms in (0..WITH_WATCHDOG).step_by(50) {
        let before_poll = rig.device().boots();
        rig.frames();
        rig.send(&[fsc::INCLINATION]);
        rig.run(50);
        let restarted = rig.device().boots() > starts;
        // An answer before a restart does not count.
        let answers = rig.device().boots() == before_poll
            && rig
                .frames()
                .iter()
                .any(|frame| frame.bytes()[0] == fsc::INCLINATION);
        let value = rig.microcontroller_mut().configured(address);
        let is_restored = value.is_some_and(|value| (value ^ before) >> bit & 1 == 0);
        if answers && (is_restored || !restored) {
            return if ms <= LONGEST || restarted {
                Ok(())
            } else {
                Err(format!("{ms} ms"))
            };
        }
    }
    Err("no answer, or not restored".to_owned())
}

/// The bits without an effect on the sensor, which nothing restores: addresses, bits.
fn unused() -> Vec<(Range<u32>, u32)> {
    let spi = board().facts().spi.base();
    let mut all = vec![
        // TIM3: the other channels than that of the heater.
        (0x4000_0418..0x4000_041C, !0),
        (0x4000_0434..0x4000_043C, !0),
        (0x4000_0440..0x4000_0444, !0),
        // CAN_MCR.DBF: without an effect while a debugger halts the processor, because DBG_CAN_STOP is 0.
        (0x4000_6400..0x4000_6404, 1 << 16),
        // The other filter banks than those of this product.
        (0x4000_6648..0x4000_6720, !0),
        // SPI_CRCPR.
        (spi + 0x10..spi + 0x14, !0),
        // The other interrupts than those of CAN (19, 20) and TIM4 (30): a bit of each has no effect while nothing requests it.
        (0xE000_E100..0xE000_E104, !(0b11 << 19)),
        (0xE000_E104..0xE000_E180, !0),
        (0xE000_E400..0xE000_E410, !0),
        (0xE000_E418..0xE000_E41C, !0),
        (0xE000_E420..0xE000_E500, !0),
        // SHPR1, SHPR2, SHCSR: without their handlers, all faults are hard faults.
        (0xE000_ED18..0xE000_ED20, !0),
        (0xE000_ED24..0xE000_ED28, !0),
    ];
    all.extend(match board().chip() {
        Chip::F103 => vec![
            // AFIO_MAPR.SWJ_CFG: the debug port; it cannot be read. AFIO_EXTICR1 to AFIO_EXTICR4.
            (0x4001_0004..0x4001_0008, 0b111 << 24),
            (0x4001_0008..0x4001_0018, !0),
            // PWR_CR: modes of the processor's sleep, the backup domain.
            (0x4000_7000..0x4000_7004, !0xF0),
            // RCC: HSEBYP, with which HSE goes on or causes an NMI; the clocks of ADC1 and TIM4; LSION, because the watchdog keeps LSI on.
            (0x4002_1000..0x4002_1004, 1 << 18),
            (0x4002_1018..0x4002_101C, 1 << 9),
            (0x4002_101C..0x4002_1020, 1 << 2),
            (0x4002_1024..0x4002_1028, 1),
            // FLASH_ACR.PRFTBE: the processor is slower.
            (0x4002_2000..0x4002_2004, 1 << 4),
        ],
        Chip::F446 => vec![
            // CAN: the filter banks of CAN2.
            (0x4000_6600..0x4000_6620, 0x0FFF_C000),
            // GPIOA_AFRL, GPIOC_OSPEEDR, GPIOC_AFRL, GPIOC_AFRH.
            (0x4002_0020..0x4002_0024, !0),
            (0x4002_0808..0x4002_080C, !0),
            (0x4002_0820..0x4002_0828, !0),
            // RCC as on the STM32F103, and the clocks of other peripherals than the timers.
            (0x4002_3800..0x4002_3804, 1 << 18),
            (0x4002_3844..0x4002_3848, 1 << 8),
            (0x4002_3840..0x4002_3844, 1 << 2),
            (0x4002_3874..0x4002_3878, 1),
            (0x4002_388C..0x4002_3890, !(1 << 24)),
            // PWR_CR: modes of the processor's sleep, the backup domain, ADCDC1.
            (0x4000_7000..0x4000_7004, 0xC_2F03),
            // DBGMCU_APB2_FZ.
            (0xE004_200C..0xE004_2010, !0),
        ],
    });
    // GPIOx_ODR: pins that are not outputs and have no resistor, or have another function.
    all.extend(match board() {
        Board::BluePill => [
            (0x4001_080C..0x4001_0810, !(1 << 4 | 1 << 6)),
            (0x4001_0C0C..0x4001_0C10, !0x7302),
            (0x4001_100C..0x4001_1010, !(1 << 13)),
        ],
        Board::NucleoF103 => [
            (0x4001_080C..0x4001_0810, !(1 << 5)),
            (0x4001_0C0C..0x4001_0C10, !0x5702),
            (0x4001_100C..0x4001_1010, !(0b11 << 6)),
        ],
        Board::NucleoF446 => [
            (0x4002_0014..0x4002_0018, !(1 << 5 | 1 << 12)),
            (0x4002_0414..0x4002_0418, !0x1402),
            (0x4002_0814..0x4002_0818, !(0b11 << 6)),
        ],
    });
    all
}

/// Inverts each bit of these configuration registers, one after the other. With those without an effect, a normal run of the
/// tests waits once in each register.
fn each_bit(within: impl Fn(u32) -> bool) -> Inverted {
    let mut rig = running();
    let mut inverted = Inverted::new();
    let registers = rig.microcontroller_mut().configuration();
    let unused = unused();
    let mut failures = Vec::new();
    for address in registers.into_iter().filter(|address| within(*address)) {
        let without_effect = unused.iter().find(|(range, _)| range.contains(&address));
        let without_effect = without_effect.map_or(0, |(_, bits)| *bits);
        let mut left = effort::choose(1, 32);
        for bit in 0..32 {
            let Some(before) = invert(&mut rig, address, bit) else {
                continue;
            };
            *inverted.entry(address).or_default() |= 1 << bit;
            let has_effect = without_effect >> bit & 1 == 0;
            if !has_effect && left == 0 {
                invert(&mut rig, address, bit);
                continue;
            }
            if let Err(error) = recover(&mut rig, address, bit, before, has_effect) {
                failures.push(format!("{address:#x}, bit {bit}: {error}"));
                // The disturbances are violations of the manual, and some have restarted the sensor.
                std::mem::forget(std::mem::replace(&mut rig, running()));
            } else if !has_effect {
                invert(&mut rig, address, bit);
                left -= 1;
            }
        }
    }
    std::mem::forget(rig);
    assert!(failures.is_empty(), "{}", failures.join("\n"));
    inverted
}

#[test]
pub fn disturbed_bits_of_the_can_controller_are_restored() {
    let inverted = each_bit(|address| CAN.contains(&address));
    left_out::check(&inverted, left_out::can());
}

/// The controller waits for the end of a dominant level, so nothing but the comparison restores it.
#[test]
#[ignore = "sweeps over faults of the chip: `.ci/long ignored`"]
pub fn disturbed_bits_of_a_can_controller_that_joins_the_bus_are_restored() {
    // RCC_APB1RSTR.CAN(1)RST.
    let reset = match chip() {
        Chip::F103 => 0x4002_1010,
        Chip::F446 => 0x4002_3820,
    };
    let rate = BitRate::M1;
    let mut rig = Rig::with("is2tk", BusRate::Fixed(rate), fixed("is2tk", rate));
    rig.io().0.be_lenient();
    rig.bus.hold_dominant(ms(600));
    rig.run(500);
    let unused = unused();
    let mut registers = rig.microcontroller_mut().configuration();
    registers.retain(|address| CAN.contains(address));
    let all = registers.into_iter().map(|address| (address, !0));
    for (address, bits) in all.chain([(reset, 1 << 25)]) {
        let row = unused.iter().find(|(range, _)| range.contains(&address));
        let bits = bits & !row.map_or(0, |(_, bits)| *bits);
        let bits = (0..32).filter(|bit| bits >> bit & 1 != 0);
        for bit in bits.step_by(effort::choose(3, 1)) {
            if let Some(before) = invert(&mut rig, address, bit) {
                rig.bus.hold_dominant(ms(200));
                rig.run(120);
                let sensor = rig.microcontroller_mut();
                let value = sensor.configured(address);
                assert_eq!(value, Some(before), "{address:#x}, bit {bit}");
                let status = sensor.configured(CAN.start + 4).expect("CAN_MSR");
                assert_eq!(status & 0b11, 0b01, "it still joins");
            }
        }
    }
    assert_eq!(rig.device().boots(), 1, "without a restart");
    // The resets have discarded the boot-up messages.
    rig.run(300);
    rig.poll();
    std::mem::forget(rig);
}

#[test]
pub fn disturbed_bits_of_the_processor_are_restored() {
    let inverted = each_bit(|address| CORE.contains(&address));
    assert_eq!(inverted, left_out::of_the_processor());
}

#[test]
#[ignore = "sweeps over faults of the chip: `.ci/long ignored`"]
pub fn disturbed_bits_of_clocks_pins_and_timers_are_restored() {
    let inverted = each_bit(|address| !CAN.contains(&address) && !CORE.contains(&address));
    left_out::check(&inverted, &left_out::others());
}

/// While the sensor detects the bit rate: TIM4 with its interrupt, and the level of TXD.
#[test]
pub fn disturbed_bits_of_the_detection_are_restored() {
    const TIM4: Range<u32> = 0x4000_0800..0x4000_0C00;
    let others = [
        (0xE000_E100, 1 << 30),
        match chip() {
            Chip::F103 => (0x4001_0C0C, 1 << 9),
            Chip::F446 => (0x4002_0014, 1 << 12),
        },
    ];
    let mut rig = Rig::with("is2", BusRate::Wire, blank());
    rig.io().0.be_lenient();
    rig.run(300);
    let mut registers = rig.microcontroller_mut().configuration();
    registers.retain(|address| TIM4.contains(address));
    assert_eq!(registers.len(), 8, "{registers:X?}");
    let all = registers.into_iter().map(|address| (address, !0));
    for (address, bits) in all.chain(others) {
        for bit in (0..32).filter(|bit| bits >> bit & 1 != 0) {
            if let Some(before) = invert(&mut rig, address, bit) {
                rig.run(120);
                let value = rig.microcontroller_mut().configured(address);
                assert_eq!(value, Some(before), "{address:#x}, bit {bit}");
            }
        }
    }
    assert_eq!(rig.device().boots(), 1, "without a restart");
    let mut traffic = Traffic::at(&mut rig, BitRate::K500);
    for _ in 0..500 {
        traffic.millisecond(&mut rig);
    }
    assert_eq!(rig.frames().len(), 2, "the boot-up messages");
    std::mem::forget(rig);
}

/// Some bits of SPI_CR1 let the master receive without end. The last byte and the overrun flag stay after this mode.
#[test]
pub fn accelerometer_measures_again_after_each_disturbed_bit_of_its_spi() {
    let control = board().facts().spi.base();
    let mut rig = Rig::booted("is2", BitRate::M1);
    rig.io().0.be_lenient();
    for bit in 0..16 {
        if invert(&mut rig, control, bit).is_none() {
            continue;
        }
        // The fault is reported after 100 ms, and ends 130 ms after that of the SPI.
        rig.run(400);
        let measures = |rig: &mut Rig| {
            rig.frames();
            rig.send(&[fsc::INCLINATION]);
            rig.run(100);
            let frames = rig.frames();
            frames
                .iter()
                .any(|frame| frame.bytes()[..2] == [fsc::INCLINATION, 0])
        };
        let measures = (0..WITH_WATCHDOG).step_by(100).any(|_| measures(&mut rig));
        assert!(measures, "bit {bit}");
    }
    std::mem::forget(rig);
}

/// What AFIO_MAPR.SWJ_CFG reads as is undefined, so it must not be written back.
#[test]
pub fn restored_mapping_of_pins_keeps_the_debug_port_on() {
    const AFIO_MAPR: u32 = 0x4001_0004;
    const CAN_REMAP: u32 = 14;
    let mut rig = running();
    let starts = rig.device().boots();
    let before = invert(&mut rig, AFIO_MAPR, CAN_REMAP).expect("a register");
    recover(&mut rig, AFIO_MAPR, CAN_REMAP, before, true).expect("restored");
    assert_eq!(rig.device().boots(), starts, "without a restart");
    assert_eq!(rig.io().0.afio.debug_port(), 0);
    std::mem::forget(rig);
}

#[test]
pub fn disturbed_bits_of_the_converter_are_restored() {
    let mut rig = Rig::with("jn2101", BusRate::Fixed(BitRate::K125), blank());
    rig.io().0.be_lenient();
    rig.run(500);
    let registers = rig.microcontroller_mut().configuration();
    // The second register of the sequence, SQR2, has no effect: the sequence has one channel.
    let is_used = |it: &u32| CONVERTER.contains(it) && it & 0xFF != 0x30;
    for address in registers.into_iter().filter(is_used) {
        for bit in 0..32 {
            let Some(before) = invert(&mut rig, address, bit) else {
                continue;
            };
            rig.run(10);
            let value = rig.microcontroller_mut().configured(address);
            assert_eq!(value, Some(before), "{address:#x}, bit {bit}");
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

/// A wrong factor of the PLL is a wrong bit time and a wrong period. While the PLL runs, a program cannot write it.
#[test]
pub fn disturbed_pll_in_the_boot_restarts_the_sensor() {
    let (address, bit) = match chip() {
        // PLLMUL in RCC_CFGR: 9 instead of 8. PLLN in RCC_PLLCFGR: 129 instead of 128.
        Chip::F103 => (0x4002_1004, 18),
        Chip::F446 => (0x4002_3804, 6),
    };
    let mut rig = Rig::with(
        "is2tk",
        BusRate::Fixed(BitRate::M1),
        fixed("is2tk", BitRate::M1),
    );
    let ticked = rig.microcontroller().image().address_of("TICKED");
    let ticked = ticked.expect("the time of the last interrupt");
    rig.wait_until(100, 100, |rig| {
        rig.microcontroller().core().word(ticked) == Some(1000)
    });
    assert_eq!(rig.device().mode(), None, "in the boot");
    let before = invert(&mut rig, address, bit).expect("a register");
    recover(&mut rig, address, bit, before, true).expect("restored");
    assert_eq!(rig.device().boots(), 2);
    std::mem::forget(rig);
}

/// The firmware compares with constants, so what the boot finds does not count.
#[test]
pub fn bits_disturbed_in_the_boot_are_restored() {
    // RCC_CFGR. IWDG_RLR: the time of the watchdog. AFIO_MAPR: the pins of CAN. GPIOB_CRL: the mode of PB1. GPIOB_OTYPER: PB10.
    // GPIOB_OSPEEDR: PB3.
    let (clocks, bits) = match chip() {
        Chip::F103 => (0x4002_1004, [(0x4001_0004, 14), (0x4001_0C00, 4)]),
        Chip::F446 => (0x4002_3808, [(0x4002_0404, 10), (0x4002_0408, 6)]),
    };
    let bits = bits.into_iter().chain([(0x4000_3008, 0)]);
    let rate = BitRate::M1;
    let mut expected = running();
    for (address, bit) in bits {
        let mut rig = Rig::with("is2tk", BusRate::Fixed(rate), fixed("is2tk", rate));
        rig.io().0.be_lenient();
        // SWS: the PLL runs.
        while rig.microcontroller_mut().configured(clocks).unwrap_or(0) & 0b1000 == 0 {
            rig.run_us(1);
        }
        invert(&mut rig, address, bit).expect("a register");
        rig.boot_up();
        let value = |rig: &mut Rig| rig.microcontroller_mut().configured(address);
        let value = [&mut rig, &mut expected].map(value);
        assert_eq!(value[0], value[1], "{address:#x}, bit {bit}");
        std::mem::forget(rig);
    }
    std::mem::forget(expected);
}

/// With a wrong bit rate, a sensor can go bus-off before the comparison. Its parameter forbids the recovery from a bus-off with another cause.
#[test]
pub fn bus_off_by_a_disturbed_bit_rate_ends_without_recovery() {
    const CAN_BTR: u32 = 0x4000_641C;
    let cyclic: [&[u8]; 2] = [
        &[fsc::WRITE_CYCLIC_TIME, 5, 0],
        &[fsc::WRITE_CYCLIC_MODE, 1],
    ];
    let mut rig = Rig::booted_with("is2", BitRate::M1, &cyclic);
    rig.io().0.be_lenient();
    // SJW: the simulated wire corrupts the frames of a sensor at its rate only.
    for bit in [24, 25] {
        rig.run(200);
        let before = invert(&mut rig, CAN_BTR, bit).expect("a register");
        // The next comparison must come after the bus-off, so the disturbance is just after one.
        while rig.microcontroller_mut().configured(CAN_BTR) != Some(before) {
            rig.run(1);
        }
        rig.run(20);
        rig.frames();
        invert(&mut rig, CAN_BTR, bit).expect("a register");
        rig.bus.corrupt(32, Some(Source::Device(rig.sensor)));
        rig.wait_until(100, 1000, |rig| {
            rig.device().bus_state() == Some(BusState::BusOff)
        });
        rig.run(LONGEST);
        let now = rig.microcontroller_mut().configured(CAN_BTR);
        assert_eq!(now, Some(before), "bit {bit}");
        rig.frames();
        rig.run(100);
        let sent = rig.frames().len();
        assert!((19..=21).contains(&sent), "bit {bit}: {sent} frames");
    }
    std::mem::forget(rig);
}
