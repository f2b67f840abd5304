//! The board around the microcontroller, wired as in the README: the connections of its pins.

use super::afio::Afio;
use super::chip::Chip;
use super::gpio::{Gpio, Pin, PinMode, PortName};
use super::timer::Timer;
use plumbline::node::Leds;

/// The channel of TIM3 at PB0 (RM0008, table 43; DS10693, alternate functions).
pub(super) const HEATER_CHANNEL: usize = 3;

/// The pins of peripherals on the Nucleo with their alternate functions (DS10693, alternate functions).
mod nucleo {
    use super::{Pin, PortName};

    pub const CAN_RX: (Pin, u8) = (Pin(PortName::A, 11), 9);
    pub const CAN_TX: u8 = 9;
    pub const SPI: [(Pin, u8); 3] = [
        (Pin(PortName::B, 13), 5),
        (Pin(PortName::B, 14), 5),
        (Pin(PortName::B, 15), 5),
    ];
    pub const TIM4_CHANNEL_3: u8 = 2;
    pub const TIM3_CHANNEL_3: u8 = 2;
}

/// The state of the LEDs; an LED at a pin that is not an output is off.
pub(super) fn leds(chip: Chip, gpio: &Gpio) -> Leds {
    let board = &chip.facts().board;
    let (run, on) = board.run;
    Leds {
        run: gpio.output(run) == Some(on),
        error: gpio.output(board.error) == Some(true),
        module_green: gpio.output(board.module_green) == Some(true),
        module_red: gpio.output(board.module_red) == Some(true),
    }
}

/// True when the terminating resistor is connected; a pull-down keeps the switch off.
pub(super) fn terminated(chip: Chip, gpio: &Gpio) -> bool {
    gpio.output(chip.facts().board.termination) == Some(true)
}

/// The duty of the heater in permille; a pull-down keeps the switch off.
pub(super) fn heater(chip: Chip, gpio: &Gpio, afio: &Afio, tim3: &Timer) -> u16 {
    let pin = chip.facts().board.heater;
    let is_channel = match chip {
        Chip::F103 => afio.tim3_channels_3_and_4_are_on_pb0_and_pb1(),
        Chip::F446 => gpio.alternate(pin) == Some(nucleo::TIM3_CHANNEL_3),
    };
    match gpio.mode(pin) {
        PinMode::AlternatePushPull if is_channel => tim3.duty(HEATER_CHANNEL).unwrap_or(0),
        _ if gpio.output(pin) == Some(true) => 1000,
        _ => 0,
    }
}

/// True when RXD is connected to the CAN controller.
pub(super) fn can_receives(chip: Chip, afio: &Afio, gpio: &Gpio) -> bool {
    match chip {
        Chip::F103 => afio.can_receives(gpio),
        Chip::F446 => has_function(gpio, nucleo::CAN_RX),
    }
}

/// True when TXD is connected to the CAN controller.
pub(super) fn can_drives(chip: Chip, afio: &Afio, gpio: &Gpio) -> bool {
    let pin = chip.facts().board.transmit;
    match chip {
        Chip::F103 => afio.can_drives(gpio),
        Chip::F446 => {
            has_function(gpio, (pin, nucleo::CAN_TX))
                && gpio.mode(pin) == PinMode::AlternatePushPull
        }
    }
}

/// True when the SPI is connected to the accelerometer.
pub(super) fn spi_is_connected(chip: Chip, afio: &Afio, gpio: &Gpio) -> bool {
    match chip {
        Chip::F103 => afio.spi1_is_connected(gpio),
        Chip::F446 => nucleo::SPI.into_iter().all(|pin| has_function(gpio, pin)),
    }
}

/// True when channel 3 of TIM4 is connected to RXD (RM0008, table 44).
pub(super) fn pulses_are_connected(chip: Chip, gpio: &Gpio) -> bool {
    let pin = chip.facts().board.pulses;
    match chip {
        Chip::F103 => gpio.mode(pin).is_digital_input(),
        Chip::F446 => has_function(gpio, (pin, nucleo::TIM4_CHANNEL_3)),
    }
}

/// True when the clock of the SPI is slow enough for the speed of its pins. At low speed the edges of SCK at a pin of the STM32F446 are
/// late, and the last bit of a transfer is wrong (stm32f4xx-hal, issue 564).
pub(super) fn spi_pins_are_fast_enough(chip: Chip, gpio: &Gpio, clock: u32) -> bool {
    let outputs = match chip {
        Chip::F103 => [Pin(PortName::A, 5), Pin(PortName::A, 7)],
        Chip::F446 => [nucleo::SPI[0].0, nucleo::SPI[2].0],
    };
    outputs
        .into_iter()
        .all(|pin| clock <= gpio.highest_frequency(pin))
}

fn has_function(gpio: &Gpio, (pin, function): (Pin, u8)) -> bool {
    gpio.alternate(pin) == Some(function)
}
