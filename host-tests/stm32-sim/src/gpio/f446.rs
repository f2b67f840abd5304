//! The mode registers of a port of the STM32F446 (RM0390, section 7.4).

use super::{PinMode, PortName, fields};
use crate::io::AccessError;

/// The mode registers of a port.
#[derive(Clone, Copy, Debug)]
pub(super) struct Modes {
    mode: u32,
    open_drain: u32,
    speed: u32,
    pull: u32,
    /// GPIOx_AFRL, GPIOx_AFRH.
    alternate: [u32; 2],
}

impl Modes {
    /// After a reset: the pins of the debug port are an alternate function with pulls, all others are floating inputs.
    pub(super) fn new(name: PortName) -> Self {
        let (mode, speed, pull) = match name {
            PortName::A => (0xA800_0000, 0x0C00_0000, 0x6400_0000),
            PortName::B => (0x0000_0280, 0x0000_00C0, 0x0000_0100),
            _ => (0, 0, 0),
        };
        Self {
            mode,
            open_drain: 0,
            speed,
            pull,
            alternate: [0; 2],
        }
    }

    /// RM0390, table 23.
    pub(super) fn mode(&self, pin: u8) -> PinMode {
        let open_drain = self.open_drain >> pin & 1 != 0;
        match (two(self.mode, pin), two(self.pull, pin)) {
            (_, 0b11) => PinMode::Reserved,
            (0b00, 0b00) => PinMode::Floating,
            (0b00, pull) => PinMode::Pulled(pull == 0b01),
            (0b01, _) if open_drain => PinMode::OpenDrain,
            (0b01, _) => PinMode::PushPull,
            (0b10, _) if open_drain => PinMode::AlternateOpenDrain,
            (0b10, _) => PinMode::AlternatePushPull,
            _ => PinMode::Analog,
        }
    }

    pub(super) fn alternate(&self, pin: u8) -> Option<u8> {
        let word = self.alternate[usize::from(pin / 8)];
        let function = (word >> (4 * (pin % 8)) & 0xF) as u8;
        (two(self.mode, pin) == 0b10).then_some(function)
    }

    pub(super) fn speed(&self, pin: u8) -> u8 {
        two(self.speed, pin)
    }

    pub(super) fn read(&self, offset: u32) -> Result<u32, AccessError> {
        Ok(match offset {
            0x00 => self.mode,
            0x04 => self.open_drain,
            0x08 => self.speed,
            0x0C => self.pull,
            0x20 => self.alternate[0],
            0x24 => self.alternate[1],
            _ => return Err(AccessError::Unmapped),
        })
    }

    /// Writes a register, except the fields of locked pins.
    pub(super) fn write(&mut self, offset: u32, value: u32, locked: u16) {
        let (register, kept) = match offset {
            0x00 => (&mut self.mode, fields(locked, 2)),
            0x04 => (&mut self.open_drain, u32::from(locked)),
            0x08 => (&mut self.speed, fields(locked, 2)),
            0x0C => (&mut self.pull, fields(locked, 2)),
            0x20 => (&mut self.alternate[0], fields(locked & 0xFF, 4)),
            _ => (&mut self.alternate[1], fields(locked >> 8, 4)),
        };
        let value = if offset == 0x04 {
            value & 0xFFFF
        } else {
            value
        };
        *register = *register & kept | value & !kept;
    }
}

/// The two bits of a pin.
fn two(register: u32, pin: u8) -> u8 {
    (register >> (2 * pin) & 0b11) as u8
}

#[cfg(test)]
mod tests;
