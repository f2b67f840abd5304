//! The board around the microcontroller: a Blue Pill wired as the README says.

use super::gpio::{Gpio, Pin, PortName};
use plumbline::node::Leds;

/// The run LED, lit when low.
const RUN: Pin = Pin(PortName::C, 13);

/// The error LED, lit when high.
const ERROR: Pin = Pin(PortName::B, 12);

/// What the LEDs show; a pin that drives nothing lets its LED go dark.
pub(super) fn leds(gpio: &Gpio) -> Leds {
    Leds {
        run: gpio.output(RUN) == Some(false),
        error: gpio.output(ERROR) == Some(true),
    }
}
