//! General-purpose I/Os, ports A to E (RM0008, chapter 9).
//!
//! | offset | register | |
//! |---|---|---|
//! | 00h, 04h | GPIOx_CRL, GPIOx_CRH | four bits per pin: CNF, MODE |
//! | 08h | GPIOx_IDR | levels |
//! | 0Ch | GPIOx_ODR | outputs, and the direction of the pulls |
//! | 10h, 14h | GPIOx_BSRR, GPIOx_BRR | set and reset bits of ODR |
//! | 18h | GPIOx_LCKR | locks modes until the next reset |

use super::io::AccessError;
use super::violation::Violations;

/// The ports of the STM32F103x8.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum PortName {
    /// Port A.
    A,
    /// Port B.
    B,
    /// Port C.
    C,
    /// Port D.
    D,
    /// Port E.
    E,
}

/// A pin: `Pin(PortName::B, 9)` is PB9.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Pin(pub PortName, pub u8);

/// The configuration of a pin (RM0008, table 20).
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum PinMode {
    /// Analog input.
    Analog,
    /// Floating input.
    Floating,
    /// Input with a pull-up (true) or pull-down.
    Pulled(bool),
    /// The port drives it: high and low.
    PushPull,
    /// The port drives it: low only.
    OpenDrain,
    /// A peripheral drives it: high and low.
    AlternatePushPull,
    /// A peripheral drives it: low only.
    AlternateOpenDrain,
    /// CNF 11 with MODE 00.
    Reserved,
}

impl PinMode {
    /// True for the modes that read the level as a digital input.
    pub fn is_digital_input(self) -> bool {
        matches!(self, Self::Floating | Self::Pulled(_))
    }
}

/// The state of the lock sequence of a port: LCKK written 1, then 0, each with the same pins (RM0008, section 9.2.7).
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Lock {
    Open,
    One(u16),
    Zero(u16),
    Locked(u16),
}

#[derive(Clone, Copy, Debug)]
struct Port {
    modes: u64,
    output: u16,
    lock: Lock,
    /// The levels that the board drives, if it does.
    driven: u16,
    outside: u16,
}

impl Port {
    /// All pins are floating inputs.
    const RESET: Self = Self {
        modes: 0x4444_4444_4444_4444,
        output: 0,
        lock: Lock::Open,
        driven: 0,
        outside: 0,
    };

    fn mode(&self, pin: u8) -> PinMode {
        let code = self.modes >> (4 * pin) & 0xF;
        match (code & 0b11, code >> 2) {
            (0, 0b00) => PinMode::Analog,
            (0, 0b01) => PinMode::Floating,
            (0, 0b10) => PinMode::Pulled(self.output >> pin & 1 != 0),
            (0, _) => PinMode::Reserved,
            (_, 0b00) => PinMode::PushPull,
            (_, 0b01) => PinMode::OpenDrain,
            (_, 0b10) => PinMode::AlternatePushPull,
            _ => PinMode::AlternateOpenDrain,
        }
    }

    fn output(&self, pin: u8) -> Option<bool> {
        let high = self.output >> pin & 1 != 0;
        match self.mode(pin) {
            PinMode::PushPull => Some(high),
            PinMode::OpenDrain => (!high).then_some(false),
            _ => None,
        }
    }

    /// The bit in GPIOx_IDR; a pin that is not driven is low.
    fn level(&self, pin: u8) -> bool {
        let outside = (self.driven >> pin & 1 != 0).then_some(self.outside >> pin & 1 != 0);
        match self.mode(pin) {
            PinMode::Analog | PinMode::Reserved => false,
            PinMode::Pulled(up) => outside.unwrap_or(up),
            _ => self.output(pin).or(outside).unwrap_or(false),
        }
    }

    fn set_modes(&mut self, modes: u64) {
        let locked = match self.lock {
            Lock::Locked(pins) => (0..16)
                .filter(|pin| pins >> pin & 1 != 0)
                .fold(0, |mask, pin| mask | 0xF_u64 << (4 * pin)),
            _ => 0,
        };
        self.modes = modes & !locked | self.modes & locked;
    }

    fn read(&mut self, offset: u32) -> Result<u32, AccessError> {
        Ok(match offset {
            0x00 => self.modes as u32,
            0x04 => (self.modes >> 32) as u32,
            0x08 => (0..16).fold(0, |levels, pin| levels | u32::from(self.level(pin)) << pin),
            0x0C => self.output.into(),
            // Write-only registers.
            0x10 | 0x14 => 0,
            0x18 => match self.lock {
                Lock::Locked(pins) => u32::from(pins) | 1 << 16,
                Lock::One(pins) | Lock::Zero(pins) => pins.into(),
                Lock::Open => 0,
            },
            _ => return Err(AccessError::Unmapped),
        })
    }

    fn write(&mut self, offset: u32, value: u32) -> Result<(), AccessError> {
        let half = value as u16;
        match offset {
            0x00 => self.set_modes(self.modes & !0xFFFF_FFFF | u64::from(value)),
            0x04 => self.set_modes(self.modes & 0xFFFF_FFFF | u64::from(value) << 32),
            0x08 => return Err(AccessError::Refused("GPIOx_IDR is read-only")),
            0x0C => self.output = half,
            // Set has priority over reset.
            0x10 => self.output = self.output & !((value >> 16) as u16) | half,
            0x14 => self.output &= !half,
            0x18 => {
                self.lock = match (self.lock, value >> 16 & 1 != 0) {
                    (locked @ Lock::Locked(_), _) => locked,
                    (Lock::One(pins), false) if pins == half => Lock::Zero(pins),
                    (Lock::Zero(pins), true) if pins == half => Lock::Locked(pins),
                    (_, true) => Lock::One(half),
                    _ => Lock::Open,
                }
            }
            _ => return Err(AccessError::Unmapped),
        }
        Ok(())
    }
}

/// The five ports.
#[derive(Debug)]
pub struct Gpio {
    ports: [Port; 5],
}

impl Default for Gpio {
    /// After a reset, without connections.
    fn default() -> Self {
        Self {
            ports: [Port::RESET; 5],
        }
    }
}

impl Gpio {
    /// The configuration of a pin.
    pub fn mode(&self, Pin(port, pin): Pin) -> PinMode {
        self.ports[port as usize].mode(pin)
    }

    /// The level that the port drives; None for an input, an alternate function and an open drain that is off.
    pub fn output(&self, Pin(port, pin): Pin) -> Option<bool> {
        self.ports[port as usize].output(pin)
    }

    /// The level that the firmware sees on a pin.
    pub fn level(&self, Pin(port, pin): Pin) -> bool {
        self.ports[port as usize].level(pin)
    }

    /// Sets the level that the board drives; None: not driven.
    pub fn drive(&mut self, Pin(port, pin): Pin, level: Option<bool>) {
        let port = &mut self.ports[port as usize];
        let set = |bits: u16, on: bool| bits & !(1 << pin) | u16::from(on) << pin;
        port.driven = set(port.driven, level.is_some());
        port.outside = set(port.outside, level == Some(true));
    }

    /// Resets one port; the levels that the board drives stay.
    pub fn reset(&mut self, name: PortName) {
        let port = &mut self.ports[name as usize];
        *port = Port {
            driven: port.driven,
            outside: port.outside,
            ..Port::RESET
        };
    }

    /// Reads the register at `offset` of a port.
    pub fn read(&mut self, name: PortName, offset: u32) -> Result<u32, AccessError> {
        self.ports[name as usize].read(offset)
    }

    /// Writes the register at `offset` of a port.
    pub fn write(
        &mut self,
        name: PortName,
        offset: u32,
        value: u32,
        violations: &mut Violations,
    ) -> Result<(), AccessError> {
        self.ports[name as usize].write(offset, value)?;
        let is_reserved = |pin| self.mode(Pin(name, pin)) == PinMode::Reserved;
        violations.check(
            offset <= 0x04 && (0..16).any(is_reserved),
            "GPIOx_CRL/CRH",
            "CNF 11 with MODE 00 is reserved",
        );
        // MODE 10 is 2 MHz (RM0008, section 5.1.2).
        let fast = |pin: u8| {
            matches!(
                self.ports[name as usize].modes >> (4 * pin) & 0b11,
                0b01 | 0b11
            )
        };
        violations.check(
            offset == 0x04 && name == PortName::C && (13..16).any(fast),
            "GPIOC_CRH",
            "PC13 to PC15 are limited to 2 MHz",
        );
        Ok(())
    }
}

#[cfg(test)]
mod tests;
