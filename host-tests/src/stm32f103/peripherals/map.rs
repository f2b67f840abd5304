//! Which address is whose, and what switches its clock on.

use super::super::dbgmcu;
use super::super::gpio::PortName;
use super::super::io::AccessError;
use super::super::rcc::Gate;

/// A peripheral.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Module {
    Signature,
    Tim3,
    Iwdg,
    Can,
    Afio,
    Gpio(PortName),
    Spi1,
    Rcc,
    Flash,
    Dbgmcu,
}

/// First address, length, what is there.
pub(super) const MAP: [(u32, u32, Module); 14] = [
    (0x1FFF_F000, 0x1000, Module::Signature),
    (0x4000_0400, 0x400, Module::Tim3),
    (0x4000_3000, 0x400, Module::Iwdg),
    (0x4000_6400, 0x400, Module::Can),
    (0x4001_0000, 0x400, Module::Afio),
    (0x4001_0800, 0x400, Module::Gpio(PortName::A)),
    (0x4001_0C00, 0x400, Module::Gpio(PortName::B)),
    (0x4001_1000, 0x400, Module::Gpio(PortName::C)),
    (0x4001_1400, 0x400, Module::Gpio(PortName::D)),
    (0x4001_1800, 0x400, Module::Gpio(PortName::E)),
    (0x4001_3000, 0x400, Module::Spi1),
    (0x4002_1000, 0x400, Module::Rcc),
    (0x4002_2000, 0x400, Module::Flash),
    (dbgmcu::BASE, 0x400, Module::Dbgmcu),
];

impl Module {
    /// The module at an address, and the offset in it.
    pub(super) fn at(address: u32) -> Result<(Self, u32), AccessError> {
        MAP.iter()
            .find_map(|&(base, length, module)| {
                let offset = address.checked_sub(base)?;
                (offset < length).then_some((module, offset))
            })
            .ok_or(AccessError::Unmapped)
    }

    /// Where its clock is switched on; None: it always has one.
    pub(super) fn gate(self) -> Option<Gate> {
        match self {
            Self::Tim3 => Some(Gate::Apb1(1)),
            Self::Can => Some(Gate::Apb1(25)),
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
            Self::Iwdg => "IWDG",
            Self::Can => "CAN",
            Self::Afio => "AFIO",
            Self::Gpio(_) => "GPIO",
            Self::Spi1 => "SPI1",
            Self::Rcc => "RCC",
            Self::Flash => "FLASH",
            Self::Dbgmcu => "DBGMCU",
        }
    }

    /// True when its registers are accessed by words only, by the manual or in this model.
    pub(super) fn takes_words_only(self) -> bool {
        !matches!(self, Self::Signature | Self::Iwdg | Self::Spi1)
    }
}
