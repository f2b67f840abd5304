//! The board around the microcontroller: a Blue Pill wired as the README says.

use super::afio::Afio;
use super::gpio::{Gpio, Pin, PinMode, PortName};
use super::timer::Timer;
use plumbline::node::Leds;

/// The run LED, lit when low.
const RUN: Pin = Pin(PortName::C, 13);

/// The error LED, lit when high.
const ERROR: Pin = Pin(PortName::B, 12);

/// The module status LED's two colours, lit when high.
const MODULE_GREEN: Pin = Pin(PortName::B, 13);
const MODULE_RED: Pin = Pin(PortName::B, 14);

/// The heater's switch, on when high.
const HEATER: Pin = Pin(PortName::B, 0);

/// The channel of TIM3 on it (RM0008, table 43).
const HEATER_CHANNEL: usize = 3;

/// The switch of the terminating resistor, on when high.
const TERMINATION: Pin = Pin(PortName::B, 1);

/// What the LEDs show; a pin that drives nothing lets its LED go dark.
pub(super) fn leds(gpio: &Gpio) -> Leds {
    Leds {
        run: gpio.output(RUN) == Some(false),
        error: gpio.output(ERROR) == Some(true),
        module_green: gpio.output(MODULE_GREEN) == Some(true),
        module_red: gpio.output(MODULE_RED) == Some(true),
    }
}

/// Whether the terminating resistor is connected; a resistor to ground holds the switch's input.
pub(super) fn terminated(gpio: &Gpio) -> bool {
    gpio.output(TERMINATION) == Some(true)
}

/// The part of the time in permille in which the heater is on; a resistor to ground holds the switch's input.
pub(super) fn heater(gpio: &Gpio, afio: &Afio, tim3: &Timer) -> u16 {
    match gpio.mode(HEATER) {
        PinMode::AlternatePushPull if afio.tim3_channels_3_and_4_are_on_pb0_and_pb1() => {
            tim3.duty(HEATER_CHANNEL).unwrap_or(0)
        }
        _ if gpio.output(HEATER) == Some(true) => 1000,
        _ => 0,
    }
}
