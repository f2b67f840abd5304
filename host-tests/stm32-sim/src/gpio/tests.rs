use super::*;

fn write(gpio: &mut Gpio, name: PortName, offset: u32, value: u32) {
    let mut violations = Violations::default();
    gpio.write(name, offset, value, &mut violations).unwrap();
    assert!(violations.list().is_empty());
}

#[test]
fn reset_values() {
    let mut gpio = Gpio::new(Chip::F103);
    for (offset, value) in [
        (0, 0x4444_4444),
        (4, 0x4444_4444),
        (8, 0),
        (12, 0),
        (16, 0),
        (20, 0),
        (24, 0),
    ] {
        assert_eq!(gpio.read(PortName::A, offset), Ok(value));
    }
}

#[test]
fn modes_match_manual() {
    // RM0008, table 20: CNF, MODE
    for (code, mode) in [
        (0b0000, PinMode::Analog),
        (0b0100, PinMode::Floating),
        (0b1000, PinMode::Pulled(false)),
        (0b0001, PinMode::PushPull),
        (0b0110, PinMode::OpenDrain),
        (0b1011, PinMode::AlternatePushPull),
        (0b1111, PinMode::AlternateOpenDrain),
    ] {
        let mut gpio = Gpio::new(Chip::F103);
        write(&mut gpio, PortName::B, 0x04, 0x4444_4404 | code << 4);
        assert_eq!(gpio.mode(Pin(PortName::B, 9)), mode);
    }
    let mut gpio = Gpio::new(Chip::F103);
    write(&mut gpio, PortName::A, 0x00, 0x4444_4448);
    write(&mut gpio, PortName::A, 0x10, 1);
    assert_eq!(gpio.mode(Pin(PortName::A, 0)), PinMode::Pulled(true));
}

#[test]
fn set_has_priority_over_reset() {
    let mut gpio = Gpio::new(Chip::F103);
    write(&mut gpio, PortName::A, 0x0C, 0b0101);
    write(&mut gpio, PortName::A, 0x10, 0b0111 << 16 | 0b1100);
    assert_eq!(gpio.read(PortName::A, 0x0C), Ok(0b1100));
    write(&mut gpio, PortName::A, 0x14, 0b0100);
    assert_eq!(gpio.read(PortName::A, 0x0C), Ok(0b1000));
}

#[test]
fn level_follows_mode_pull_and_board() {
    let mut gpio = Gpio::new(Chip::F103);
    let pin = Pin(PortName::A, 3);
    // Pull-up, then the board drives it low.
    write(&mut gpio, PortName::A, 0x00, 0x4444_8444);
    write(&mut gpio, PortName::A, 0x0C, 1 << 3);
    assert_eq!(gpio.read(PortName::A, 0x08), Ok(1 << 3));
    gpio.drive(pin, Some(false));
    assert!(!gpio.level(pin));
    // An open drain releases the pin when its output is 1.
    write(&mut gpio, PortName::A, 0x00, 0x4444_5444);
    assert_eq!((gpio.output(pin), gpio.level(pin)), (None, false));
    gpio.drive(pin, Some(true));
    assert!(gpio.level(pin));
    write(&mut gpio, PortName::A, 0x14, 1 << 3);
    assert_eq!((gpio.output(pin), gpio.level(pin)), (Some(false), false));
}

#[test]
fn lock_sequence_locks_mode_but_not_output() {
    let mut gpio = Gpio::new(Chip::F103);
    let pins = 1 << 0;
    // Another value in between restarts the sequence.
    for value in [pins | 1 << 16, 0b10, pins | 1 << 16, pins] {
        write(&mut gpio, PortName::C, 0x18, value);
    }
    assert_eq!(gpio.read(PortName::C, 0x18), Ok(pins));
    write(&mut gpio, PortName::C, 0x18, pins | 1 << 16);
    assert_eq!(gpio.read(PortName::C, 0x18), Ok(pins | 1 << 16));
    write(&mut gpio, PortName::C, 0x00, 0x4444_4433);
    assert_eq!(gpio.read(PortName::C, 0x00), Ok(0x4444_4434));
    write(&mut gpio, PortName::C, 0x0C, 1);
    assert_eq!(gpio.read(PortName::C, 0x0C), Ok(1));
    gpio.reset(PortName::C);
    write(&mut gpio, PortName::C, 0x00, 0x4444_4433);
    assert_eq!(gpio.read(PortName::C, 0x00), Ok(0x4444_4433));
}

#[test]
fn reserved_mode_is_violation() {
    let mut gpio = Gpio::new(Chip::F103);
    let mut violations = Violations::default();
    gpio.write(PortName::E, 0x00, 0x4444_444C, &mut violations)
        .unwrap();
    assert_eq!(violations.list().len(), 1);
}
