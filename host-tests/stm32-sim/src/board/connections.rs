//! The connections of the pins of a board with the peripherals of its microcontroller.

use super::{Board, Spi};
use crate::afio::Afio;
use crate::chip::Chip;
use crate::gpio::{Gpio, Pin, PinMode, PortName};
use crate::timer::Timer;
use plumbline::node::Leds;

/// The channel of TIM3 at PB0 (RM0008, table 43; DS10693, alternate functions).
pub const HEATER_CHANNEL: usize = 3;

/// The pins of peripherals on the Nucleo-F446RE with their alternate functions (DS10693, alternate functions).
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
pub fn leds(board: Board, gpio: &Gpio) -> Leds {
    let pins = &board.facts().pins;
    let (run, on) = pins.run;
    Leds {
        run: gpio.output(run) == Some(on),
        error: gpio.output(pins.error) == Some(true),
        module_green: gpio.output(pins.module_green) == Some(true),
        module_red: gpio.output(pins.module_red) == Some(true),
    }
}

/// True when the terminating resistor is connected; a pull-down keeps the switch off.
pub fn terminated(board: Board, gpio: &Gpio) -> bool {
    gpio.output(board.facts().pins.termination) == Some(true)
}

/// The duty of the heater in permille; a pull-down keeps the switch off.
pub fn heater(board: Board, gpio: &Gpio, afio: &Afio, tim3: &Timer) -> u16 {
    let pin = board.facts().pins.heater;
    let is_channel = match board.chip() {
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
pub fn can_receives(board: Board, afio: &Afio, gpio: &Gpio) -> bool {
    match board.chip() {
        Chip::F103 => afio.can_receives(gpio),
        Chip::F446 => has_function(gpio, nucleo::CAN_RX),
    }
}

/// True when TXD is connected to the CAN controller.
pub fn can_drives(board: Board, afio: &Afio, gpio: &Gpio) -> bool {
    let pin = board.facts().pins.transmit;
    match board.chip() {
        Chip::F103 => afio.can_drives(gpio),
        Chip::F446 => {
            has_function(gpio, (pin, nucleo::CAN_TX))
                && gpio.mode(pin) == PinMode::AlternatePushPull
        }
    }
}

/// True when the SPI is connected to the accelerometer.
pub fn spi_is_connected(board: Board, afio: &Afio, gpio: &Gpio) -> bool {
    match board.chip() {
        Chip::F103 => match board.facts().spi {
            Spi::Spi1 => afio.spi1_is_connected(gpio),
            Spi::Spi2 => spi2_is_connected(gpio),
        },
        Chip::F446 => nucleo::SPI.into_iter().all(|pin| has_function(gpio, pin)),
    }
}

/// True when channel 3 of TIM4 is connected to RXD (RM0008, table 44).
pub fn pulses_are_connected(board: Board, gpio: &Gpio) -> bool {
    let pin = board.facts().pins.pulses;
    match board.chip() {
        Chip::F103 => gpio.mode(pin).is_digital_input(),
        Chip::F446 => has_function(gpio, (pin, nucleo::TIM4_CHANNEL_3)),
    }
}

/// True when the clock of the SPI is slow enough for the speed of its pins. At low speed the edges of SCK at a pin of the STM32F446 are
/// late, and the last bit of a transfer is wrong (stm32f4xx-hal, issue 564).
pub fn spi_pins_are_fast_enough(board: Board, gpio: &Gpio, clock: u32) -> bool {
    let outputs = match board.facts().spi {
        Spi::Spi1 => [Pin(PortName::A, 5), Pin(PortName::A, 7)],
        Spi::Spi2 => [Pin(PortName::B, 13), Pin(PortName::B, 15)],
    };
    outputs
        .into_iter()
        .all(|pin| clock <= gpio.highest_frequency(pin))
}

/// True when SPI2 of the STM32F103 has its pins: PB13 and PB15, alternate-function push-pull outputs, and PB14, an input (RM0008, table 25).
fn spi2_is_connected(gpio: &Gpio) -> bool {
    let pin = |number| gpio.mode(Pin(PortName::B, number));
    let is_output = |number| pin(number) == PinMode::AlternatePushPull;
    is_output(13) && is_output(15) && pin(14).is_digital_input()
}

fn has_function(gpio: &Gpio, (pin, function): (Pin, u8)) -> bool {
    gpio.alternate(pin) == Some(function)
}
