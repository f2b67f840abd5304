//! Debug support (RM0008, section 31.16; RM0390, section 33.16): the selection of the peripherals that stop while a debugger halts the
//! processor.
//!
//! On the STM32F103 a program can use DBGMCU_CR only while a debugger is connected (ES096, "Debug registers cannot be read by user
//! software", and ST's stm32f1xx_hal.c). Otherwise DBGMCU_IDCODE and DBGMCU_CR read 0, and in this model a write has no effect. A
//! power-on reset clears the registers, a system reset does not.

use super::chip::Chip;
use super::io::AccessError;
use super::silicon::Silicon;

/// The first address of the registers.
pub const BASE: u32 = 0xE004_2000;

/// The bits of DBGMCU_CR, and on the STM32F446 of DBGMCU_APB1_FZ and DBGMCU_APB2_FZ.
const F103_BITS: [u32; 3] = [0x7E3F_FFE7, 0, 0];
const F446_BITS: [u32; 3] = [0x0000_00E7, 0x07E0_1DFF, 0x0007_0003];

/// The registers of the debug support.
#[derive(Clone, Copy, Debug)]
pub struct Dbgmcu {
    chip: Chip,
    /// DBGMCU_IDCODE: device and revision.
    identity: u32,
    /// A program can read the registers without a debugger.
    reads: bool,
    /// A program can write the registers without a debugger.
    writes: bool,
    /// A debugger is connected.
    connected: bool,
    /// DBGMCU_CR, and on the STM32F446 DBGMCU_APB1_FZ and DBGMCU_APB2_FZ.
    registers: [u32; 3],
}

impl Dbgmcu {
    /// After power-on, before [`set_silicon`](Self::set_silicon).
    pub fn new(chip: Chip) -> Self {
        Self {
            chip,
            identity: 0,
            reads: false,
            writes: false,
            connected: false,
            registers: [0; 3],
        }
    }

    /// A power-on reset; other resets do not change the registers.
    pub fn power_on(&mut self) {
        self.registers = [0; 3];
    }

    /// Selects the behaviour in which chips differ.
    pub fn set_silicon(&mut self, silicon: &Silicon) {
        (self.identity, self.reads) = (silicon.identity, silicon.debug_reads);
        self.writes = silicon.debug_writes;
    }

    /// Connects a debugger.
    pub fn connect(&mut self) {
        self.connected = true;
    }

    /// Disconnects the debugger.
    pub fn disconnect(&mut self) {
        self.connected = false;
    }

    /// True while a debugger is connected.
    pub fn is_connected(&self) -> bool {
        self.connected
    }

    /// True if the clocks of the debug port run in sleep mode.
    pub fn runs_in_sleep(&self) -> bool {
        self.registers[0] & 1 != 0
    }

    /// True if the watchdog stops while the processor is halted.
    pub fn stops_watchdog(&self) -> bool {
        match self.chip {
            Chip::F103 => self.registers[0] >> 8 & 1 != 0,
            Chip::F446 => self.registers[1] >> 12 & 1 != 0,
        }
    }

    /// True if TIM3 stops while the processor is halted, and its outputs are disabled.
    pub fn stops_tim3(&self) -> bool {
        match self.chip {
            Chip::F103 => self.registers[0] >> 12 & 1 != 0,
            Chip::F446 => self.registers[1] >> 1 & 1 != 0,
        }
    }

    /// Reads the register at `offset`.
    pub fn read(&self, offset: u32) -> Result<u32, AccessError> {
        let value = match (self.chip, offset) {
            (_, 0x00) => self.identity,
            (_, 0x04) | (Chip::F446, 0x08 | 0x0C) => self.registers[offset as usize / 4 - 1],
            _ => return Err(AccessError::Unmapped),
        };
        Ok(if self.reads || self.connected {
            value
        } else {
            0
        })
    }

    /// Writes the register at `offset`.
    pub fn write(&mut self, offset: u32, value: u32) -> Result<(), AccessError> {
        match (self.chip, offset) {
            (_, 0x00) => return Err(AccessError::Refused("DBGMCU_IDCODE is read-only")),
            (_, 0x04) | (Chip::F446, 0x08 | 0x0C) if !self.writes && !self.connected => {}
            (_, 0x04) | (Chip::F446, 0x08 | 0x0C) => {
                let number = offset as usize / 4 - 1;
                let bits = match self.chip {
                    Chip::F103 => F103_BITS,
                    Chip::F446 => F446_BITS,
                };
                self.registers[number] = value & bits[number];
            }
            _ => return Err(AccessError::Unmapped),
        }
        Ok(())
    }
}
