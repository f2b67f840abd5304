//! The interrupt controller (ARM ARM B3.4): the lines from the peripherals and the registers at 0xE000_E100.

use super::exceptions::{Exceptions, FIRST_INTERRUPT, only};

/// The interrupt lines, which are levels.
#[derive(Clone, Debug, Default)]
pub struct Nvic {
    /// The lines that are high, by exception number.
    lines: u128,
}

/// Converts a register with a bit for each of 32 interrupts, word `index`, to a set of exceptions.
fn bits_of_word(exceptions: &Exceptions, index: u32, value: u32) -> u128 {
    let every_interrupt = (only(exceptions.interrupts) - 1) << FIRST_INTERRUPT;
    let shift = u32::from(FIRST_INTERRUPT) + 32 * index;
    u128::from(value).checked_shl(shift).unwrap_or(0) & every_interrupt
}

/// The 32 interrupts of word `index` in a set of exceptions.
fn word_of_bits(index: u32, set: u128) -> u32 {
    let shift = u32::from(FIRST_INTERRUPT) + 32 * index;
    set.checked_shr(shift).unwrap_or(0) as u32
}

impl Nvic {
    /// Sets a line. A rising line makes its interrupt pending; a falling line does not clear it.
    pub fn set_line(&mut self, exceptions: &mut Exceptions, interrupt: u8, high: bool) {
        let line = only(FIRST_INTERRUPT + u16::from(interrupt));
        if !high {
            self.lines &= !line;
        } else if self.lines & line == 0 {
            self.lines |= line;
            exceptions.pending |= line;
        }
    }

    /// Makes the interrupts of high lines pending again if not active: after a handler has returned or software has cleared them.
    pub fn sample(&self, exceptions: &mut Exceptions) {
        exceptions.pending |= self.lines & !exceptions.active;
    }

    /// Reads a word of 0xE000_E100..0xE000_E4F0.
    pub fn read(&self, exceptions: &Exceptions, address: u32) -> u32 {
        let index = address >> 2 & 0x1F;
        match address & 0xFFF {
            0x100..0x200 => word_of_bits(index, exceptions.enabled),
            0x200..0x300 => word_of_bits(index, exceptions.pending),
            0x300..0x380 => word_of_bits(index, exceptions.active),
            0x400..0x500 => u32::from_le_bytes(std::array::from_fn(|lane| {
                exceptions.priority(priority_owner(address & !3) + lane as u16)
            })),
            _ => 0,
        }
    }

    /// Writes a word of the registers with one bit per interrupt.
    pub fn write(&self, exceptions: &mut Exceptions, address: u32, value: u32) {
        let bits = bits_of_word(exceptions, address >> 2 & 0x1F, value);
        match address & 0xF80 {
            0x100 => exceptions.enabled |= bits,
            0x180 => exceptions.enabled &= !bits,
            0x200 => exceptions.pending |= bits,
            0x280 => {
                exceptions.pending &= !bits;
                self.sample(exceptions);
            }
            _ => {}
        }
    }

    /// STIR: makes the interrupt with this number pending.
    pub fn trigger(&self, exceptions: &mut Exceptions, value: u32) {
        let interrupt = (value & 0x1FF) as u16;
        if interrupt < exceptions.interrupts {
            exceptions.pending |= only(FIRST_INTERRUPT + interrupt);
        }
    }
}

/// The exception whose priority is the byte at this address of IPR.
pub fn priority_owner(address: u32) -> u16 {
    FIRST_INTERRUPT + (address & 0xFF) as u16
}
