//! The two microcontrollers on their boards: their differences as tables. Registers that differ are in the modules of the peripherals.
//!
//! | | [`f103`] | [`f446`] |
//! |---|---|---|
//! | microcontroller, board | STM32F103C8, Blue Pill | STM32F446RE, Nucleo-F446RE |
//! | processor | Cortex-M3 | Cortex-M4 with the DSP extension |
//! | manuals | RM0008, PM0075 (flash), DS5319 | RM0390, PM0214 (processor), DS10693 |

pub mod f103;
pub mod f446;

use super::cortex_m::{MemorySizes, Model};
use super::dbgmcu;
use super::flash::Times;
use super::gpio::Pin;
use super::pwr::Limits;
use super::rcc::Gate;
use bench::Geometry;
use std::ops::Range;

/// A microcontroller on its board.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub enum Chip {
    /// STM32F103C8 on a Blue Pill.
    F103,
    /// STM32F446RE on a Nucleo-F446RE.
    F446,
}

/// The facts of a microcontroller and its board that are numbers.
#[derive(Debug)]
pub struct Facts {
    /// The name of the microcontroller.
    pub name: &'static str,
    /// The processor.
    pub processor: Model,
    /// Flash and RAM.
    pub memory: MemorySizes,
    /// The flash of the program.
    pub program: &'static [Range<u32>],
    /// The flash of the parameters.
    pub parameters: Range<u32>,
    /// The pages of the parameters.
    pub geometry: Geometry,
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
    /// The interrupt of the SPI at the accelerometer.
    pub spi_interrupt: u8,
    /// The address of the flash size in the electronic signature.
    pub flash_size_at: u32,
    /// The address of the unique device identifier.
    pub unique_id_at: u32,
    /// The pins of the board.
    pub board: Board,
}

/// The pins of a board as in the README.
#[derive(Debug)]
pub struct Board {
    /// RXD of the CAN transceiver at the timer of the bit rate detection.
    pub pulses: Pin,
    /// TXD of the CAN transceiver.
    pub transmit: Pin,
    /// Chip select of the accelerometer.
    pub select: Pin,
    /// The run LED, and its level when it is on.
    pub run: (Pin, bool),
    /// The error LED, on when high.
    pub error: Pin,
    /// The green module LED, on when high.
    pub module_green: Pin,
    /// The red module LED, on when high.
    pub module_red: Pin,
    /// The switch of the heater, on when high.
    pub heater: Pin,
    /// The switch of the terminating resistor, on when high.
    pub termination: Pin,
    /// The divider of the sensor's supply.
    pub supply: Pin,
}

/// A peripheral.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Module {
    /// Electronic signature.
    Signature,
    /// TIM3.
    Tim3,
    /// TIM4.
    Tim4,
    /// The independent watchdog.
    Iwdg,
    /// Power control.
    Pwr,
    /// The analog-to-digital converter ADC1.
    Adc,
    /// The CAN controller: CAN, or CAN1.
    Can,
    /// Alternate functions of the STM32F103.
    Afio,
    /// A GPIO port.
    Gpio(super::gpio::PortName),
    /// The SPI at the accelerometer: SPI1, or SPI2.
    Spi,
    /// Reset and clock control.
    Rcc,
    /// The flash interface.
    Flash,
    /// Debug support.
    Dbgmcu,
}

impl Chip {
    /// Both chips.
    pub const ALL: [Self; 2] = [Self::F103, Self::F446];

    /// The numbers of this chip and its board.
    #[inline]
    pub const fn facts(self) -> &'static Facts {
        match self {
            Self::F103 => &f103::FACTS,
            Self::F446 => &f446::FACTS,
        }
    }

    /// The peripheral in the 1 KiB that begin at this address.
    pub(super) fn module(self, base: u32) -> Option<Module> {
        match (base, self) {
            (0x4000_0400, _) => Some(Module::Tim3),
            (0x4000_0800, _) => Some(Module::Tim4),
            (0x4000_3000, _) => Some(Module::Iwdg),
            (0x4000_6400, _) => Some(Module::Can),
            (0x4000_7000, _) => Some(Module::Pwr),
            (dbgmcu::BASE, _) => Some(Module::Dbgmcu),
            (_, Self::F103) => f103::module(base),
            (_, Self::F446) => f446::module(base),
        }
    }

    /// The clock gate of a peripheral; None: it always has a clock.
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

    /// The name of a peripheral.
    pub(super) fn name_of(self, module: Module) -> &'static str {
        match (module, self) {
            (Module::Signature, _) => "electronic signature",
            (Module::Tim3, _) => "TIM3",
            (Module::Tim4, _) => "TIM4",
            (Module::Iwdg, _) => "IWDG",
            (Module::Pwr, _) => "PWR",
            (Module::Adc, _) => "ADC1",
            (Module::Can, Self::F103) => "CAN",
            (Module::Can, Self::F446) => "CAN1",
            (Module::Afio, _) => "AFIO",
            (Module::Gpio(_), _) => "GPIO",
            (Module::Spi, Self::F103) => "SPI1",
            (Module::Spi, Self::F446) => "SPI2",
            (Module::Rcc, _) => "RCC",
            (Module::Flash, _) => "FLASH",
            (Module::Dbgmcu, _) => "DBGMCU",
        }
    }

    /// The RAM.
    pub(super) fn ram(self) -> Range<u32> {
        const START: u32 = 0x2000_0000;
        START..START + self.facts().memory.ram as u32
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
