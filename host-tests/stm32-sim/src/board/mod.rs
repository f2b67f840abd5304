//! The boards around the microcontroller, wired as in the README: [`Facts`], and the connections of their pins (`connections.rs`).

mod bluepill;
mod connections;
mod nucleo_f103rb;
mod nucleo_f446re;

use super::chip::{Chip, Module};
use super::cortex_m::MemorySizes;
use super::gpio::Pin;
use super::rcc::Gate;
pub(super) use connections::*;
use std::ops::Range;

/// A board with its microcontroller.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub enum Board {
    /// Blue Pill: STM32F103C8.
    BluePill,
    /// Nucleo-F103RB: STM32F103RB.
    NucleoF103,
    /// Nucleo-F446RE: STM32F446RE.
    NucleoF446,
}

/// The facts of a board.
#[derive(Debug)]
pub struct Facts {
    /// The name: the feature of the firmware, which its ELF file also contains.
    pub name: &'static str,
    /// The target of the compiler.
    pub target: &'static str,
    /// The name of the microcontroller.
    pub microcontroller: &'static str,
    /// The microcontroller.
    pub chip: Chip,
    /// The flash in bytes.
    pub flash: usize,
    /// The flash of the program.
    pub program: &'static [Range<u32>],
    /// The flash of the parameters.
    pub parameters: Range<u32>,
    /// The flash that a bootloader can change: its program and its boot record.
    pub slot: Range<u32>,
    /// HSE is a clock from the ST-LINK; otherwise a crystal.
    pub has_external_clock: bool,
    /// The SPI at the accelerometer.
    pub spi: Spi,
    /// The channel of the converter at the divider of the supply.
    pub supply_channel: u32,
    /// The pins.
    pub pins: Pins,
}

/// An SPI of the microcontroller.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Spi {
    /// SPI1, on APB2.
    Spi1,
    /// SPI2, on APB1.
    Spi2,
}

impl Spi {
    /// The address (RM0008, table 3; RM0390, table 1).
    pub const fn base(self) -> u32 {
        match self {
            Self::Spi1 => 0x4001_3000,
            Self::Spi2 => 0x4000_3800,
        }
    }

    /// The clock gate (RM0008, section 7.3; RM0390, section 6.3).
    const fn gate(self) -> Gate {
        match self {
            Self::Spi1 => Gate::Apb2(12),
            Self::Spi2 => Gate::Apb1(14),
        }
    }

    /// The interrupt (RM0008, table 63; RM0390, table 38).
    pub(super) const fn interrupt(self) -> u8 {
        match self {
            Self::Spi1 => 35,
            Self::Spi2 => 36,
        }
    }
}

/// The pins of a board as in the README.
#[derive(Debug)]
pub struct Pins {
    /// RXD of the CAN transceiver at the timer of the bit rate detection.
    pub pulses: Pin,
    /// RXD of the CAN transceiver at the CAN controller.
    pub receive: Pin,
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

impl Board {
    /// All boards.
    pub const ALL: [Self; 3] = [Self::BluePill, Self::NucleoF103, Self::NucleoF446];

    /// The facts of this board.
    #[inline]
    pub const fn facts(self) -> &'static Facts {
        match self {
            Self::BluePill => &bluepill::FACTS,
            Self::NucleoF103 => &nucleo_f103rb::FACTS,
            Self::NucleoF446 => &nucleo_f446re::FACTS,
        }
    }

    /// The microcontroller.
    pub const fn chip(self) -> Chip {
        self.facts().chip
    }

    /// The board of this name.
    pub fn find(name: &str) -> Option<Self> {
        let mut all = Self::ALL.into_iter();
        all.find(|board| board.facts().name == name)
    }

    /// Flash and RAM.
    pub(super) fn memory(self) -> MemorySizes {
        MemorySizes {
            flash: self.facts().flash,
            ram: self.chip().facts().ram,
            ram_repeats: false,
        }
    }

    /// The peripheral in the 1 KiB that begin at this address. Of the SPIs, only the one at the accelerometer is modelled.
    pub(super) fn module(self, base: u32) -> Option<Module> {
        if base == self.facts().spi.base() {
            return Some(Module::Spi);
        }
        self.chip().module(base)
    }

    /// The name of a peripheral.
    pub(super) fn name_of(self, module: Module) -> &'static str {
        match (module, self.facts().spi) {
            (Module::Spi, Spi::Spi1) => "SPI1",
            (Module::Spi, Spi::Spi2) => "SPI2",
            _ => self.chip().name_of(module),
        }
    }

    /// The clock gate of a peripheral; None: it always has a clock.
    pub(super) fn gate(self, module: Module) -> Option<Gate> {
        if module == Module::Spi {
            return Some(self.facts().spi.gate());
        }
        self.chip().gate(module)
    }
}
