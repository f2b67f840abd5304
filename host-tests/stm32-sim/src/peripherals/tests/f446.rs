//! The peripherals of the STM32F446 on a Nucleo.

use super::*;

const SPI2: u32 = 0x4000_3800;
const CAN1: u32 = 0x4000_6400;
const GPIOA: u32 = 0x4002_0000;
const GPIOB: u32 = 0x4002_0400;
const GPIOC: u32 = 0x4002_0800;
const ADC1: u32 = 0x4001_2000;
const RCC: u32 = 0x4002_3800;
const AHB1ENR: u32 = RCC + 0x30;
const APB1ENR: u32 = RCC + 0x40;
const DBGMCU: u32 = 0xE004_2000;

/// Chip select PB12 high, SPI2 on PB13 to PB15 at full speed, PCLK1 / 2.
fn with_spi() -> Bench {
    let mut bench = Bench::of(Board::NucleoF446);
    bench.write(AHB1ENR, 0x0010_0002);
    bench.write(APB1ENR, 1 << 14);
    bench.write(GPIOB + 0x18, 1 << 12);
    bench.write(GPIOB + 0x24, 0x5550_0000);
    bench.write(GPIOB + 0x08, 0xFC00_00C0);
    bench.write(GPIOB, 0xA900_0280);
    bench.write(SPI2, 0x0344);
    bench
}

fn exchange(bench: &mut Bench, byte: u8) -> u8 {
    bench.put(SPI2 + 0x0C, Width::Byte, byte.into()).unwrap();
    while bench.read(SPI2 + 0x08).unwrap() & 1 == 0 {}
    bench.get(SPI2 + 0x0C, Width::Byte).unwrap() as u8
}

/// Reads WHO_AM_I of the accelerometer over the SPI.
fn who_am_i(bench: &mut Bench) -> u8 {
    exchange(bench, 0x8F);
    exchange(bench, 0)
}

#[test]
fn accelerometer_answers_through_spi2_and_pins() {
    for (register, value, answer) in [
        (GPIOB + 0x08, 0xFC00_00C0, 0x6B),
        // PB14 is the alternate function 6.
        (GPIOB + 0x24, 0x5650_0000, 0xFF),
        // PB13 is an output.
        (GPIOB, 0xA500_0280, 0xFF),
    ] {
        let mut bench = with_spi();
        bench.write(register, value);
        bench.write(GPIOB + 0x18, 1 << 28);
        assert_eq!(who_am_i(&mut bench), answer);
        bench.write(GPIOB + 0x18, 1 << 12);
        assert_eq!(bench.reasons(), [""; 0]);
    }
}

/// Pins with low speed permit up to 4 MHz (DS10693); SCK has 8 MHz.
#[test]
fn slow_pins_of_spi2_read_a_wrong_last_bit() {
    let mut bench = with_spi();
    bench.write(GPIOB + 0x08, 0x0000_00C0);
    bench.write(GPIOB + 0x18, 1 << 28);
    // FIFO_CTRL1 is written and read.
    exchange(&mut bench, 0x07);
    exchange(&mut bench, 0x05);
    bench.write(GPIOB + 0x18, 1 << 12);
    bench.write(GPIOB + 0x18, 1 << 28);
    exchange(&mut bench, 0x87);
    assert_eq!(exchange(&mut bench, 0), 0x04);
    let slow = "the pins of the SPI are too slow for its clock";
    assert!(bench.reasons().iter().all(|reason| *reason == slow));
    assert_eq!(bench.reasons().len(), 4);
}

#[test]
fn peripheral_without_clock_does_not_answer() {
    let mut bench = Bench::of(Board::NucleoF446);
    for (address, name, enable, bit) in [
        (CAN1, "CAN1", APB1ENR, 25),
        (GPIOA, "GPIO", AHB1ENR, 0),
        (GPIOB, "GPIO", AHB1ENR, 1),
        (SPI2, "SPI2", APB1ENR, 14),
        (ADC1, "ADC1", RCC + 0x44, 8),
        (0x4000_0400, "TIM3", APB1ENR, 1),
        (0x4000_0800, "TIM4", APB1ENR, 2),
    ] {
        assert_eq!(bench.read(address), Err(AccessError::Unclocked(name)));
        bench.write(enable, 1 << bit);
        assert!(bench.read(address).is_ok(), "{name}");
    }
    // Peripherals of the STM32F103: AFIO, GPIOA, SPI1, RCC, flash.
    for address in [
        0x4001_0000,
        0x4001_0800,
        0x4001_3000,
        0x4002_1400,
        0x4002_2000,
    ] {
        assert_eq!(
            bench.read(address),
            Err(AccessError::Unmapped),
            "{address:08X}h"
        );
    }
}

#[test]
fn can_is_connected_with_alternate_function_9() {
    let mut bench = Bench::of(Board::NucleoF446);
    bench.write(AHB1ENR, 0x0010_0001);
    bench.write(APB1ENR, 1 << 25);
    bench.write(GPIOA, 0xAA80_0000);
    assert!(!bench.io.can_is_connected(), "alternate function 0");
    bench.write(GPIOA + 0x24, 0x0009_9000);
    assert!(bench.io.can_is_connected());
    assert_eq!(bench.read(CAN1 + 0x200), Ok(0x2A1C_0E01));
    bench.write(CAN1 + 0x200, 0x2A1C_1C01);
    assert_eq!(bench.read(CAN1 + 0x200), Ok(0x2A1C_1C01));
    assert_eq!(bench.io.can.violations(), []);
}

#[test]
fn transmit_pin_belongs_to_port_or_can_controller() {
    let mut bench = Bench::of(Board::NucleoF446);
    bench.write(AHB1ENR, 0x0010_0001);
    bench.write(APB1ENR, 1 << 25);
    bench.write(GPIOA + 0x24, 0x0009_9000);
    assert!(!bench.io.transmits_dominant(), "an input: pulled up");
    bench.io.can.take_changed();
    // A port output that is low, then high.
    bench.write(GPIOA, 0xA980_0000);
    assert!(bench.io.transmits_dominant());
    assert!(bench.io.can.take_changed(), "the wire has changed");
    bench.write(GPIOA + 0x18, 1 << 12);
    assert!(!bench.io.transmits_dominant());
    assert!(bench.io.can.take_changed());
    // The controller, recessive.
    bench.write(GPIOA, 0xAA80_0000);
    assert!(!bench.io.transmits_dominant());
    assert!(!bench.io.can.take_changed());
}

#[test]
fn debug_registers_are_kept_in_a_reset() {
    let mut bench = Bench::of(Board::NucleoF446);
    assert_eq!(bench.read(DBGMCU), Ok(0x1000_6421));
    bench.write(DBGMCU + 0x08, 1 << 12);
    let cycle = bench.cycle;
    bench.io.reset(cycle, ResetCause::Software);
    assert_eq!(bench.read(DBGMCU + 0x08), Ok(1 << 12));
}

#[test]
fn converter_measures_supply_of_scene_through_pc0() {
    let mut bench = Bench::of(Board::NucleoF446);
    bench.write(AHB1ENR, 0x0010_0004);
    bench.write(RCC + 0x44, 1 << 8);
    bench.write(GPIOC, 0b11);
    bench.write(ADC1 + 0x0C, 0b111);
    bench.write(ADC1 + 0x34, 10);
    bench.write(ADC1 + 0x08, 1);
    bench.cycle += 100;
    bench.write(ADC1 + 0x08, 1 << 30 | 1);
    assert_eq!(bench.read(ADC1 + 0x300), Ok(0x10));
    bench.cycle += 2000;
    assert_eq!(bench.read(ADC1 + 0x300), Ok(0x12));
    assert_eq!(bench.read(ADC1 + 0x4C), Ok(1896));
    assert_eq!(bench.reasons(), [""; 0]);
}

#[test]
fn input_with_two_pins_is_a_violation() {
    let mut bench = Bench::of(Board::NucleoF446);
    bench.write(AHB1ENR, 0x0010_0003);
    // CAN1_RX at PA11, and at PB8.
    bench.write(GPIOA + 0x24, 9 << 12);
    bench.write(GPIOA, 0xA880_0000);
    bench.write(GPIOB + 0x24, 9);
    assert_eq!(bench.reasons(), [""; 0]);
    bench.write(GPIOB, 0x0002_0280);
    assert_eq!(bench.reasons(), ["the input has two pins"]);
}
