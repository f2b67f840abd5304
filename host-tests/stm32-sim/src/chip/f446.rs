//! STM32F446. The address map is that of RM0390, table 1, the clock gates those of section 6.3.

use super::{Facts, Module};
use crate::cortex_m::Model;
use crate::flash::Times;
use crate::gpio::PortName;
use crate::pwr::Limits;
use crate::rcc::Gate;
use bench::Geometry;

/// The numbers of the STM32F446.
pub const FACTS: Facts = Facts {
    processor: Model::CortexM4,
    // RM0390, section 2.2.3: SRAM1 and SRAM2 follow each other.
    ram: 128 * 1024,
    geometry: Geometry::STM32F446,
    slot_page: 128 * 1024,
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
    // DS10693, flash memory programming; the times to erase are those of a sector of 16 KiB and of 128 KiB. The datasheet gives no shortest times.
    flash_times: [
        Times::of(16_000, [400, 300, 250], [2000, 1300, 1000]),
        Times::of(16_000, [400, 300, 250], [2000, 1300, 1000]),
        Times::of(100_000, [800, 600, 500], [4000, 2600, 2000]),
    ],
    // RM0390, chapter 3, does not require HSI.
    flash_needs_hsi: false,
    hsi: 16_000_000,
    // DS10693, table of LSI characteristics.
    lsi: [17_000, 32_000, 47_000],
    // RM0390, chapter 34.
    flash_size_at: 0x1FFF_7A22,
    unique_id_at: 0x1FFF_7A10,
};

/// The peripherals whose address is not the same on both chips.
pub(super) fn module(base: u32) -> Option<Module> {
    Some(match base {
        0x1FFF_7800 => Module::Signature,
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
        Module::Adc => Some(Gate::Apb2(8)),
        Module::Crc => Some(Gate::Ahb1(12)),
        _ => None,
    }
}
