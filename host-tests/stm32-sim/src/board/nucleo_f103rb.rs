//! Nucleo-F103RB.

use super::{Facts, Pins, Spi};
use crate::chip::Chip;
use crate::gpio::{Pin, PortName};

/// The facts of the board.
pub const FACTS: Facts = Facts {
    name: "nucleo-f103rb",
    target: "thumbv7m-none-eabi",
    microcontroller: "STM32F103RB",
    chip: Chip::F103,
    flash: 128 * 1024,
    #[expect(clippy::single_range_in_vec_init, reason = "one area of addresses")]
    program: &[0x0800_0000..0x0801_F800],
    // The last two pages.
    parameters: 0x0801_F800..0x0802_0000,
    // The pages of the program, of a download and of the boot record behind a bootloader.
    slot: 0x0800_2000..0x0801_F400,
    has_external_clock: true,
    spi: Spi::Spi2,
    supply_channel: 10,
    pins: Pins {
        pulses: Pin(PortName::B, 8),
        receive: Pin(PortName::B, 8),
        transmit: Pin(PortName::B, 9),
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
