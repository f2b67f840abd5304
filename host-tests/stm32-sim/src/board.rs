//! The board around the microcontroller: a Blue Pill wired as in the README.

use super::afio::Afio;
use super::gpio::{Gpio, Pin, PinMode, PortName};
use super::timer::Timer;
use plumbline::node::Leds;

/// The run LED, on when low.
const RUN: Pin = Pin(PortName::C, 13);

/// The error LED, on when high.
const ERROR: Pin = Pin(PortName::B, 12);

/// The two colours of the module status LED, on when high.
const MODULE_GREEN: Pin = Pin(PortName::B, 13);
const MODULE_RED: Pin = Pin(PortName::B, 14);

/// The switch of the heater, on when high.
const HEATER: Pin = Pin(PortName::B, 0);

/// The channel of TIM3 at this pin (RM0008, table 43).
const HEATER_CHANNEL: usize = 3;

/// The switch of the terminating resistor, on when high.
const TERMINATION: Pin = Pin(PortName::B, 1);

/// The state of the LEDs; an LED at a pin that is not an output is off.
pub(super) fn leds(gpio: &Gpio) -> Leds {
    Leds {
        run: gpio.output(RUN) == Some(false),
        error: gpio.output(ERROR) == Some(true),
        module_green: gpio.output(MODULE_GREEN) == Some(true),
        module_red: gpio.output(MODULE_RED) == Some(true),
    }
}

/// True when the terminating resistor is connected; a pull-down keeps the switch off.
pub(super) fn terminated(gpio: &Gpio) -> bool {
    gpio.output(TERMINATION) == Some(true)
}

/// The duty of the heater in permille; a pull-down keeps the switch off.
pub(super) fn heater(gpio: &Gpio, afio: &Afio, tim3: &Timer) -> u16 {
    match gpio.mode(HEATER) {
        PinMode::AlternatePushPull if afio.tim3_channels_3_and_4_are_on_pb0_and_pb1() => {
            tim3.duty(HEATER_CHANNEL).unwrap_or(0)
        }
        _ if gpio.output(HEATER) == Some(true) => 1000,
        _ => 0,
    }
}
