//! The address map, and the clock gate of each peripheral.

use super::super::dbgmcu;
use super::super::gpio::PortName;
use super::super::io::AccessError;
use super::super::rcc::Gate;

/// A peripheral.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Module {
    Signature,
    Tim3,
    Tim4,
    Iwdg,
    Can,
    Pwr,
    Afio,
    Gpio(PortName),
    Spi1,
    Rcc,
    Flash,
    Dbgmcu,
}

impl Module {
    /// All modules.
    pub(super) const ALL: [Self; 16] = [
        Self::Signature,
        Self::Tim3,
        Self::Tim4,
        Self::Iwdg,
        Self::Can,
        Self::Pwr,
        Self::Afio,
        Self::Gpio(PortName::A),
        Self::Gpio(PortName::B),
        Self::Gpio(PortName::C),
        Self::Gpio(PortName::D),
        Self::Gpio(PortName::E),
        Self::Spi1,
        Self::Rcc,
        Self::Flash,
        Self::Dbgmcu,
    ];

    /// The module at an address, and the offset in its 1 KiB.
    pub(super) fn at(address: u32) -> Result<(Self, u32), AccessError> {
        const SIZE: u32 = 0x400;
        let module = match address & !(SIZE - 1) {
            0x1FFF_F000..0x2000_0000 => Self::Signature,
            0x4000_0400 => Self::Tim3,
            0x4000_0800 => Self::Tim4,
            0x4000_3000 => Self::Iwdg,
            0x4000_6400 => Self::Can,
            0x4000_7000 => Self::Pwr,
            0x4001_0000 => Self::Afio,
            0x4001_0800 => Self::Gpio(PortName::A),
            0x4001_0C00 => Self::Gpio(PortName::B),
            0x4001_1000 => Self::Gpio(PortName::C),
            0x4001_1400 => Self::Gpio(PortName::D),
            0x4001_1800 => Self::Gpio(PortName::E),
            0x4001_3000 => Self::Spi1,
            0x4002_1000 => Self::Rcc,
            0x4002_2000 => Self::Flash,
            dbgmcu::BASE => Self::Dbgmcu,
            _ => return Err(AccessError::Unmapped),
        };
        Ok((module, address % SIZE))
    }

    /// Its clock gate; None: it always has a clock.
    pub(super) fn gate(self) -> Option<Gate> {
        match self {
            Self::Tim3 => Some(Gate::Apb1(1)),
            Self::Tim4 => Some(Gate::Apb1(2)),
            Self::Can => Some(Gate::Apb1(25)),
            Self::Pwr => Some(Gate::Apb1(28)),
            Self::Afio => Some(Gate::Apb2(0)),
            Self::Gpio(port) => Some(Gate::Apb2(2 + port as u8)),
            Self::Spi1 => Some(Gate::Apb2(12)),
            _ => None,
        }
    }

    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Signature => "electronic signature",
            Self::Tim3 => "TIM3",
            Self::Tim4 => "TIM4",
            Self::Iwdg => "IWDG",
            Self::Can => "CAN",
            Self::Pwr => "PWR",
            Self::Afio => "AFIO",
            Self::Gpio(_) => "GPIO",
            Self::Spi1 => "SPI1",
            Self::Rcc => "RCC",
            Self::Flash => "FLASH",
            Self::Dbgmcu => "DBGMCU",
        }
    }

    /// True when its registers require word accesses, by the manual or in this model.
    pub(super) fn takes_words_only(self) -> bool {
        !matches!(self, Self::Signature | Self::Iwdg | Self::Spi1)
    }
}
