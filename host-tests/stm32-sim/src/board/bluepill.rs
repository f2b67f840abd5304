//! Blue Pill.

use super::{Facts, Pins, Spi};
use crate::chip::Chip;
use crate::gpio::{Pin, PortName};

/// The facts of the board.
pub const FACTS: Facts = Facts {
    name: "bluepill",
    target: "thumbv7m-none-eabi",
    microcontroller: "STM32F103C8",
    chip: Chip::F103,
    flash: 64 * 1024,
    #[expect(clippy::single_range_in_vec_init, reason = "one area of addresses")]
    program: &[0x0800_0000..0x0800_F800],
    // The last two pages.
    parameters: 0x0800_F800..0x0801_0000,
    // The pages of the program and of the boot record behind a bootloader.
    slot: 0x0800_2000..0x0800_F800,
    has_external_clock: false,
    spi: Spi::Spi1,
    supply_channel: 0,
    pins: Pins {
        pulses: Pin(PortName::B, 8),
        receive: Pin(PortName::B, 8),
        transmit: Pin(PortName::B, 9),
        select: Pin(PortName::A, 4),
        run: (Pin(PortName::C, 13), false),
        error: Pin(PortName::B, 12),
        module_green: Pin(PortName::B, 13),
        module_red: Pin(PortName::B, 14),
        heater: Pin(PortName::B, 0),
        termination: Pin(PortName::B, 1),
        supply: Pin(PortName::A, 0),
    },
};
