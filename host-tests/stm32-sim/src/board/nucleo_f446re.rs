//! Nucleo-F446RE.

use super::{Facts, Pins, Spi};
use crate::chip::Chip;
use crate::gpio::{Pin, PortName};

/// The facts of the board.
pub const FACTS: Facts = Facts {
    name: "nucleo-f446re",
    target: "thumbv7em-none-eabihf",
    microcontroller: "STM32F446RE",
    chip: Chip::F446,
    // RM0390, section 2.2.4.
    flash: 512 * 1024,
    program: &[0x0800_0000..0x0800_8000, 0x0801_0000..0x0808_0000],
    // Sectors 2 and 3 (RM0390, table 5).
    parameters: 0x0800_8000..0x0801_0000,
    // Sectors 5 to 7: a program, a download and the boot record behind a bootloader.
    slot: 0x0802_0000..0x0808_0000,
    has_external_clock: true,
    spi: Spi::Spi2,
    supply_channel: 10,
    pins: Pins {
        pulses: Pin(PortName::B, 8),
        receive: Pin(PortName::A, 11),
        transmit: Pin(PortName::A, 12),
        select: Pin(PortName::B, 12),
        run: (Pin(PortName::A, 5), true),
        error: Pin(PortName::B, 10),
        module_green: Pin(PortName::C, 6),
        module_red: Pin(PortName::C, 7),
        heater: Pin(PortName::B, 0),
        termination: Pin(PortName::B, 1),
        supply: Pin(PortName::C, 0),
    },
};
