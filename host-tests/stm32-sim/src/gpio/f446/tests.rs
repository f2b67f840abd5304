use crate::chip::Chip;
use crate::gpio::{Gpio, Pin, PinMode, PortName};
use crate::violation::Violations;

fn write(gpio: &mut Gpio, name: PortName, offset: u32, value: u32) -> usize {
    let mut violations = Violations::default();
    gpio.write(name, offset, value, &mut violations).unwrap();
    violations.list().len()
}

#[test]
fn reset_values_match_manual() {
    // RM0390, section 7.4.
    let mut gpio = Gpio::new(Chip::F446);
    for (name, moder, ospeedr, pupdr) in [
        (PortName::A, 0xA800_0000, 0x0C00_0000, 0x6400_0000),
        (PortName::B, 0x0000_0280, 0x0000_00C0, 0x0000_0100),
        (PortName::C, 0, 0, 0),
    ] {
        let values = [0x00, 0x04, 0x08, 0x0C, 0x14, 0x1C, 0x20, 0x24];
        let read = values.map(|offset| gpio.read(name, offset).unwrap());
        assert_eq!(read, [moder, 0, ospeedr, pupdr, 0, 0, 0, 0], "{name:?}");
    }
    // The debug port: SWDIO has a pull-up, SWCLK a pull-down.
    assert_eq!(gpio.read(PortName::A, 0x10), Ok(0));
    assert_eq!(gpio.alternate(Pin(PortName::A, 13)), Some(0));
}

#[test]
fn modes_match_manual() {
    // RM0390, table 23: MODER, OTYPER, PUPDR.
    for (moder, otyper, pupdr, mode) in [
        (0b00, 0, 0b00, PinMode::Floating),
        (0b00, 0, 0b01, PinMode::Pulled(true)),
        (0b00, 0, 0b10, PinMode::Pulled(false)),
        (0b01, 0, 0b00, PinMode::PushPull),
        (0b01, 1, 0b01, PinMode::OpenDrain),
        (0b10, 0, 0b01, PinMode::AlternatePushPull),
        (0b10, 1, 0b00, PinMode::AlternateOpenDrain),
        (0b11, 0, 0b00, PinMode::Analog),
    ] {
        let mut gpio = Gpio::new(Chip::F446);
        for (offset, value) in [
            (0x00, moder << 18),
            (0x04, otyper << 9),
            (0x0C, pupdr << 18),
        ] {
            assert_eq!(write(&mut gpio, PortName::C, offset, value), 0);
        }
        assert_eq!(gpio.mode(Pin(PortName::C, 9)), mode);
    }
    let mut gpio = Gpio::new(Chip::F446);
    assert_eq!(write(&mut gpio, PortName::C, 0x0C, 0b11), 1, "reserved");
}

#[test]
fn output_speed_and_alternate_function_follow_registers() {
    let mut gpio = Gpio::new(Chip::F446);
    let pin = Pin(PortName::B, 13);
    write(&mut gpio, PortName::B, 0x00, 0x0400_0280);
    write(&mut gpio, PortName::B, 0x18, 1 << 13);
    assert_eq!(gpio.output(pin), Some(true));
    assert_eq!(gpio.read(PortName::B, 0x10), Ok(1 << 13), "PB13 is high");
    write(&mut gpio, PortName::B, 0x18, 1 << 29);
    assert_eq!(gpio.output(pin), Some(false));
    write(&mut gpio, PortName::B, 0x24, 0x0050_0000);
    assert_eq!(gpio.alternate(pin), None, "MODER selects an output");
    write(&mut gpio, PortName::B, 0x00, 0x0800_0280);
    assert_eq!((gpio.alternate(pin), gpio.output(pin)), (Some(5), None));
    assert_eq!(gpio.highest_frequency(pin), 4_000_000);
    write(&mut gpio, PortName::B, 0x08, 0x0C00_00C0);
    assert_eq!(gpio.highest_frequency(pin), 100_000_000);
}

#[test]
fn locked_pin_keeps_its_mode() {
    let mut gpio = Gpio::new(Chip::F446);
    for value in [1 << 16 | 1 << 9, 1 << 9, 1 << 16 | 1 << 9] {
        write(&mut gpio, PortName::C, 0x1C, value);
    }
    for (offset, kept) in [
        (0x00, 0b11 << 18),
        (0x04, 1 << 9),
        (0x08, 0b11 << 18),
        (0x24, 0xF0),
    ] {
        write(&mut gpio, PortName::C, offset, u32::MAX);
        let all = if offset == 0x04 { 0xFFFF } else { u32::MAX };
        assert_eq!(
            gpio.read(PortName::C, offset),
            Ok(all & !kept),
            "{offset:02X}h"
        );
    }
}
