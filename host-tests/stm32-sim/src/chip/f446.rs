//! STM32F446RE on a Nucleo-F446RE. The address map is that of RM0390, table 1, the clock gates those of section 6.3.

use super::{Board, Facts, Module};
use crate::cortex_m::{MemorySizes, Model};
use crate::flash::Times;
use crate::gpio::{Pin, PortName};
use crate::pwr::Limits;
use crate::rcc::Gate;
use bench::Geometry;

/// The numbers of the STM32F446RE and of the Nucleo-F446RE.
pub const FACTS: Facts = Facts {
    name: "STM32F446RE",
    processor: Model::CortexM4,
    // RM0390, sections 2.2.3 and 2.2.4: SRAM1 and SRAM2 follow each other.
    memory: MemorySizes {
        flash: 512 * 1024,
        ram: 128 * 1024,
    },
    program: &[0x0800_0000..0x0800_8000, 0x0801_0000..0x0808_0000],
    // Sectors 2 and 3 (RM0390, table 5).
    parameters: 0x0800_8000..0x0801_0000,
    geometry: Geometry::STM32F446,
    // DS10693, embedded reset and power control block characteristics; RM0390, section 3.6.2, program/erase parallelism.
    supply: Limits {
        power_down: ([1600, 1680, 1760], 40),
        // Level 3.
        brown_out: Some(([2750, 2830, 2880], 100)),
        detector: [
            [1980, 2040, 2080],
            [2130, 2190, 2250],
            [2290, 2350, 2390],
            [2440, 2510, 2560],
            [2590, 2660, 2710],
            [2650, 2840, 2920],
            [2850, 2930, 2990],
            [2950, 3030, 3090],
        ],
        detector_hysteresis: 100,
        programming: [1800, 2100, 2700],
    },
    // DS10693, flash memory programming; the time to erase is that of a sector of 16 KiB. The datasheet gives no shortest times.
    flash_times: [
        Times::of(16_000, [400, 300, 250]),
        Times::of(16_000, [400, 300, 250]),
        Times::of(100_000, [800, 600, 500]),
    ],
    // RM0390, chapter 3, does not require HSI.
    flash_needs_hsi: false,
    hsi: 16_000_000,
    // DS10693, table of LSI characteristics.
    lsi: [17_000, 32_000, 47_000],
    // RM0390, table 38.
    spi_interrupt: 36,
    // RM0390, chapter 34.
    flash_size_at: 0x1FFF_7A22,
    unique_id_at: 0x1FFF_7A10,
    board: Board {
        pulses: Pin(PortName::B, 8),
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

/// The peripherals whose address is not the same on both chips.
pub(super) fn module(base: u32) -> Option<Module> {
    Some(match base {
        0x1FFF_7800 => Module::Signature,
        0x4000_3800 => Module::Spi,
        0x4001_2000 => Module::Adc,
        0x4002_0000 => Module::Gpio(PortName::A),
        0x4002_0400 => Module::Gpio(PortName::B),
        0x4002_0800 => Module::Gpio(PortName::C),
        0x4002_0C00 => Module::Gpio(PortName::D),
        0x4002_1000 => Module::Gpio(PortName::E),
        0x4002_3800 => Module::Rcc,
        0x4002_3C00 => Module::Flash,
        _ => return None,
    })
}

/// The clock gates that are not the same on both chips.
pub(super) fn gate(module: Module) -> Option<Gate> {
    match module {
        Module::Gpio(port) => Some(Gate::Ahb1(port as u8)),
        Module::Spi => Some(Gate::Apb1(14)),
        Module::Adc => Some(Gate::Apb2(8)),
        _ => None,
    }
}
