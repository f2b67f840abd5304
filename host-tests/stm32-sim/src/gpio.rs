//! General-purpose I/Os, ports A to E (RM0008, chapter 9; RM0390, chapter 7).
//!
//! | STM32F103 | STM32F446 | register | |
//! |---|---|---|---|
//! | 00h, 04h | | GPIOx_CRL, GPIOx_CRH | four bits per pin: CNF, MODE |
//! | | 00h, 04h | GPIOx_MODER, GPIOx_OTYPER | mode, open drain |
//! | | 08h, 0Ch | GPIOx_OSPEEDR, GPIOx_PUPDR | speed, pulls |
//! | 08h | 10h | GPIOx_IDR | levels |
//! | 0Ch | 14h | GPIOx_ODR | outputs, and on the STM32F103 the direction of the pulls |
//! | 10h | 18h | GPIOx_BSRR | set and reset bits of ODR |
//! | 14h | | GPIOx_BRR | reset bits of ODR |
//! | 18h | 1Ch | GPIOx_LCKR | locks modes until the next reset |
//! | | 20h, 24h | GPIOx_AFRL, GPIOx_AFRH | four bits per pin: alternate function |

mod f446;

use super::chip::Chip;
use super::io::AccessError;
use super::violation::Violations;

/// The letter of a port.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum PortName {
    /// Port A: PA0 to PA15.
    A,
    /// Port B: PB0 to PB15.
    B,
    /// Port C: PC0 to PC15.
    C,
    /// Port D: PD0 to PD15.
    D,
    /// Port E: PE0 to PE15.
    E,
}

/// A pin: `Pin(PortName::B, 9)` is PB9.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Pin(pub PortName, pub u8);

/// The configuration of a pin (RM0008, table 20; RM0390, table 23).
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum PinMode {
    /// Analog input: the pin is not read.
    Analog,
    /// Input without pull-up or pull-down.
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
    /// CNF 11 with MODE 00; PUPD 11.
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

/// The mode registers of a port.
#[derive(Clone, Copy, Debug)]
enum Modes {
    /// GPIOx_CRL and GPIOx_CRH.
    F103(u64),
    F446(f446::Modes),
}

#[derive(Clone, Copy, Debug)]
struct Port {
    modes: Modes,
    output: u16,
    lock: Lock,
    /// The levels that the board drives, if it does.
    driven: u16,
    outside: u16,
}

impl Port {
    /// After a reset. On the STM32F103 all pins are floating inputs.
    fn new(chip: Chip, name: PortName) -> Self {
        Self {
            modes: match chip {
                Chip::F103 => Modes::F103(0x4444_4444_4444_4444),
                Chip::F446 => Modes::F446(f446::Modes::new(name)),
            },
            output: 0,
            lock: Lock::Open,
            driven: 0,
            outside: 0,
        }
    }

    fn mode(&self, pin: u8) -> PinMode {
        let code = match &self.modes {
            Modes::F103(modes) => modes >> (4 * pin) & 0xF,
            Modes::F446(modes) => return modes.mode(pin),
        };
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

    /// Writes the mode register at `offset`. The fields of locked pins do not change.
    fn set_modes(&mut self, offset: u32, value: u32) {
        let locked = match self.lock {
            Lock::Locked(pins) => pins,
            _ => 0,
        };
        match &mut self.modes {
            Modes::F103(modes) => {
                let shift = 8 * offset;
                let kept = u64::from(fields(locked >> (2 * offset) & 0xFF, 4)) << shift;
                let value = u64::from(value) << shift & !kept;
                *modes = *modes & (kept | !(0xFFFF_FFFF << shift)) | value;
            }
            Modes::F446(modes) => modes.write(offset, value, locked),
        }
    }

    /// The offset that the register at `offset` has on the STM32F103; None for mode registers.
    fn common(&self, offset: u32) -> Option<u32> {
        match (&self.modes, offset) {
            (Modes::F103(_), 0x00 | 0x04) => None,
            (Modes::F103(_), _) => Some(offset),
            (Modes::F446(_), 0x10 | 0x14 | 0x18) => Some(offset - 0x08),
            (Modes::F446(_), 0x1C) => Some(0x18),
            (Modes::F446(_), _) => None,
        }
    }

    fn read(&mut self, offset: u32) -> Result<u32, AccessError> {
        let Some(common) = self.common(offset) else {
            return match &self.modes {
                Modes::F103(modes) => Ok((modes >> (8 * offset)) as u32),
                Modes::F446(modes) => modes.read(offset),
            };
        };
        Ok(match common {
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
        let Some(common) = self.common(offset) else {
            if let Modes::F446(modes) = &self.modes {
                modes.read(offset)?;
            }
            self.set_modes(offset, value);
            return Ok(());
        };
        match common {
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

/// A mask with a field of `width` bits for each of these pins.
fn fields(pins: u16, width: u32) -> u32 {
    (0..32 / width)
        .filter(|pin| pins >> pin & 1 != 0)
        .fold(0, |mask, pin| mask | ((1 << width) - 1) << (width * pin))
}

/// The five ports with their registers.
#[derive(Debug)]
pub struct Gpio {
    chip: Chip,
    ports: [Port; 5],
}

impl Gpio {
    /// After a reset, without connections.
    pub fn new(chip: Chip) -> Self {
        use PortName::{A, B, C, D, E};
        Self {
            chip,
            ports: [A, B, C, D, E].map(|name| Port::new(chip, name)),
        }
    }

    /// The number of the alternate function of a pin; None when the pin has none. The STM32F103 does not number them.
    pub fn alternate(&self, Pin(port, pin): Pin) -> Option<u8> {
        match &self.ports[port as usize].modes {
            Modes::F103(_) => None,
            Modes::F446(modes) => modes.alternate(pin),
        }
    }

    /// The highest frequency of an output in Hz, by its speed (RM0008, GPIOx_CRL; DS10693, I/O AC characteristics, 50 pF, 2.7 V and
    /// more); 0 for an input.
    pub fn highest_frequency(&self, Pin(port, pin): Pin) -> u32 {
        match &self.ports[port as usize].modes {
            Modes::F103(modes) => {
                [0, 10_000_000, 2_000_000, 50_000_000][(modes >> (4 * pin) & 0b11) as usize]
            }
            Modes::F446(modes) => {
                [4_000_000, 25_000_000, 50_000_000, 100_000_000][usize::from(modes.speed(pin))]
            }
        }
    }

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
            ..Port::new(self.chip, name)
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
        let port = &mut self.ports[name as usize];
        let changes_modes = port.common(offset).is_none();
        port.write(offset, value)?;
        let is_reserved = |pin| self.mode(Pin(name, pin)) == PinMode::Reserved;
        violations.check(
            changes_modes && (0..16).any(is_reserved),
            "GPIOx",
            "the mode of a pin is reserved",
        );
        // MODE 10 is 2 MHz (RM0008, section 5.1.2).
        let fast = |pin: u8| match &self.ports[name as usize].modes {
            Modes::F103(modes) => matches!(modes >> (4 * pin) & 0b11, 0b01 | 0b11),
            Modes::F446(modes) => modes.mode(pin) == PinMode::PushPull && modes.speed(pin) > 0,
        };
        violations.check(
            changes_modes && name == PortName::C && (13..16).any(fast),
            "GPIOC",
            "PC13 to PC15 are limited to 2 MHz",
        );
        Ok(())
    }
}

#[cfg(test)]
mod tests;
