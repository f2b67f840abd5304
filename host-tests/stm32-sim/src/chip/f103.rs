//! STM32F103, a medium-density device. The address map is that of RM0008, table 3, the clock gates those of section 7.3.

use super::{Facts, Module};
use crate::cortex_m::Model;
use crate::flash::Times;
use crate::gpio::PortName;
use crate::pwr::Limits;
use crate::rcc::Gate;
use bench::Geometry;

/// The numbers of the STM32F103x8 and the STM32F103xB.
pub const FACTS: Facts = Facts {
    processor: Model::CortexM3,
    // DS5319, figure 11.
    ram: 20 * 1024,
    geometry: Geometry::STM32F103,
    slot_page: 1024,
    // DS5319, embedded reset and power control block characteristics, and flash memory characteristics (Vprog).
    supply: Limits {
        power_down: ([1800, 1880, 1960], 40),
        brown_out: None,
        detector: [
            [2000, 2080, 2160],
            [2090, 2180, 2270],
            [2180, 2280, 2380],
            [2280, 2380, 2480],
            [2370, 2480, 2590],
            [2470, 2580, 2690],
            [2560, 2680, 2800],
            [2660, 2780, 2900],
        ],
        detector_hysteresis: 100,
        programming: [2000; 3],
    },
    // DS5319, flash memory characteristics. The datasheet gives no typical time of an erase.
    flash_times: [
        Times::of(40_000, [20; 3], [20; 3]),
        Times::of(52_500, [30; 3], [30; 3]),
        Times::of(70_000, [40; 3], [40; 3]),
    ],
    // PM0075, section 2.3.
    flash_needs_hsi: true,
    hsi: 8_000_000,
    // DS5319, table 25.
    lsi: [30_000, 40_000, 60_000],
    // RM0008, chapter 30.
    flash_size_at: 0x1FFF_F7E0,
    unique_id_at: 0x1FFF_F7E8,
};

/// The peripherals whose address is not the same on both chips.
pub(super) fn module(base: u32) -> Option<Module> {
    Some(match base {
        0x1FFF_F000..0x2000_0000 => Module::Signature,
        0x4001_0000 => Module::Afio,
        0x4001_0800 => Module::Gpio(PortName::A),
        0x4001_0C00 => Module::Gpio(PortName::B),
        0x4001_1000 => Module::Gpio(PortName::C),
        0x4001_1400 => Module::Gpio(PortName::D),
        0x4001_1800 => Module::Gpio(PortName::E),
        0x4001_2400 => Module::Adc,
        0x4002_1000 => Module::Rcc,
        0x4002_2000 => Module::Flash,
        _ => return None,
    })
}

/// The clock gates that are not the same on both chips.
pub(super) fn gate(module: Module) -> Option<Gate> {
    match module {
        Module::Afio => Some(Gate::Apb2(0)),
        Module::Gpio(port) => Some(Gate::Apb2(2 + port as u8)),
        Module::Adc => Some(Gate::Apb2(9)),
        Module::Crc => Some(Gate::Ahb1(6)),
        _ => None,
    }
}
