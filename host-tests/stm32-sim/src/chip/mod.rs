//! The two microcontrollers: their differences as tables. Registers that differ are in the modules of the peripherals.
//!
//! | | [`f103`] | [`f446`] |
//! |---|---|---|
//! | microcontroller | STM32F103x8, STM32F103xB | STM32F446 |
//! | processor | Cortex-M3 | Cortex-M4 with the DSP extension |
//! | manuals | RM0008, PM0075 (flash), DS5319 | RM0390, PM0214 (processor), DS10693 |

pub mod f103;
pub mod f446;

use super::cortex_m::Model;
use super::dbgmcu;
use super::flash::Times;
use super::pwr::Limits;
use super::rcc::Gate;
use bench::Geometry;
use std::ops::Range;

/// A microcontroller.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub enum Chip {
    /// STM32F103.
    F103,
    /// STM32F446.
    F446,
}

/// The facts of a microcontroller that are numbers.
#[derive(Debug)]
pub struct Facts {
    /// The model and the revision of the processor.
    pub processor: Model,
    /// The RAM in bytes.
    pub ram: usize,
    /// The pages of the parameters.
    pub geometry: Geometry,
    /// The size of the pages that a bootloader can change, in bytes.
    pub slot_page: usize,
    /// The limits and thresholds of the supply.
    pub supply: Limits,
    /// The times of the flash: shortest, typical, longest.
    pub flash_times: [Times; 3],
    /// True if programming and erasing the flash need HSI.
    pub flash_needs_hsi: bool,
    /// The internal oscillator HSI in Hz.
    pub hsi: u32,
    /// The internal oscillator LSI in Hz: lowest, typical, highest.
    pub lsi: [u32; 3],
    /// The address of the flash size in the electronic signature.
    pub flash_size_at: u32,
    /// The address of the unique device identifier.
    pub unique_id_at: u32,
}

/// A peripheral with its own range of addresses.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Module {
    /// Electronic signature: flash size and unique identifier.
    Signature,
    /// TIM3, which drives the heater.
    Tim3,
    /// TIM4, which measures the bit time.
    Tim4,
    /// The CRC calculation unit.
    Crc,
    /// The independent watchdog (IWDG).
    Iwdg,
    /// Power control (PWR), with the detector of the supply.
    Pwr,
    /// The analog-to-digital converter ADC1.
    Adc,
    /// The CAN controller: CAN, or CAN1.
    Can,
    /// Alternate functions of the STM32F103.
    Afio,
    /// The GPIO port with this letter.
    Gpio(super::gpio::PortName),
    /// The SPI at the accelerometer: SPI1, or SPI2.
    Spi,
    /// Reset and clock control (RCC).
    Rcc,
    /// The interface that erases and programs the flash.
    Flash,
    /// Debug support (DBGMCU).
    Dbgmcu,
}

impl Chip {
    /// Both chips, in the order of the boards.
    pub const ALL: [Self; 2] = [Self::F103, Self::F446];

    /// The numbers of this chip.
    #[inline]
    pub const fn facts(self) -> &'static Facts {
        match self {
            Self::F103 => &f103::FACTS,
            Self::F446 => &f446::FACTS,
        }
    }

    /// The peripheral in the 1 KiB that begin at this address, without the SPI.
    pub(super) fn module(self, base: u32) -> Option<Module> {
        match (base, self) {
            (0x4000_0400, _) => Some(Module::Tim3),
            (0x4000_0800, _) => Some(Module::Tim4),
            (0x4000_3000, _) => Some(Module::Iwdg),
            (0x4000_6400, _) => Some(Module::Can),
            (0x4000_7000, _) => Some(Module::Pwr),
            (dbgmcu::BASE, _) => Some(Module::Dbgmcu),
            (0x4002_3000, _) => Some(Module::Crc),
            (_, Self::F103) => f103::module(base),
            (_, Self::F446) => f446::module(base),
        }
    }

    /// The clock gate of a peripheral, without the SPI; None: it always has a clock.
    pub(super) fn gate(self, module: Module) -> Option<Gate> {
        match (module, self) {
            (Module::Tim3, _) => Some(Gate::Apb1(1)),
            (Module::Tim4, _) => Some(Gate::Apb1(2)),
            (Module::Can, _) => Some(Gate::Apb1(25)),
            (Module::Pwr, _) => Some(Gate::Apb1(28)),
            (_, Self::F103) => f103::gate(module),
            (_, Self::F446) => f446::gate(module),
        }
    }

    /// The clock gate of the DMA controller DMA1.
    pub(super) fn dma(self) -> Gate {
        match self {
            Self::F103 => Gate::Ahb1(0),
            Self::F446 => Gate::Ahb1(21),
        }
    }

    /// The name of a peripheral; the board has that of the SPI.
    pub(super) fn name_of(self, module: Module) -> &'static str {
        match (module, self) {
            (Module::Signature, _) => "electronic signature",
            (Module::Tim3, _) => "TIM3",
            (Module::Tim4, _) => "TIM4",
            (Module::Crc, _) => "CRC",
            (Module::Iwdg, _) => "IWDG",
            (Module::Pwr, _) => "PWR",
            (Module::Adc, _) => "ADC1",
            (Module::Can, Self::F103) => "CAN",
            (Module::Can, Self::F446) => "CAN1",
            (Module::Afio, _) => "AFIO",
            (Module::Gpio(_), _) => "GPIO",
            (Module::Spi, _) => "SPI",
            (Module::Rcc, _) => "RCC",
            (Module::Flash, _) => "FLASH",
            (Module::Dbgmcu, _) => "DBGMCU",
        }
    }

    pub(super) fn ram(self) -> Range<u32> {
        const START: u32 = 0x2000_0000;
        START..START + self.facts().ram as u32
    }
}

impl Module {
    /// The peripherals of RCC's reset registers.
    pub(super) const WITH_RESET: [Self; 12] = {
        use super::gpio::PortName as P;
        [
            Self::Tim3,
            Self::Tim4,
            Self::Pwr,
            Self::Adc,
            Self::Can,
            Self::Afio,
            Self::Gpio(P::A),
            Self::Gpio(P::B),
            Self::Gpio(P::C),
            Self::Gpio(P::D),
            Self::Gpio(P::E),
            Self::Spi,
        ]
    };
}
