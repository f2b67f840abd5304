//! Disturbances: the configuration registers of the peripherals, of which one inverts bits.

use super::Peripherals;
use super::access::AREA;
use crate::chip::{Chip, Module};
use crate::dbgmcu;
use crate::io::{Io, Width};

impl Peripherals {
    /// The addresses of the configuration registers of the peripherals that have a clock: all that are modelled and can be read, except
    /// states, data and commands.
    pub fn configuration(&mut self, cycle: u64) -> Vec<u32> {
        let areas = (0x4000_0000..0x4003_0000).step_by(AREA as usize);
        let mut all: Vec<u32> = areas
            .chain([dbgmcu::BASE])
            .flat_map(|base| (base..base + AREA).step_by(4))
            .collect();
        all.retain(|address| {
            let Ok((module, offset)) = self.module_at(*address) else {
                return false;
            };
            self.check_clock(module).is_ok()
                && self.is_configuration(module, offset)
                && self.read(cycle, *address, Width::Word).is_ok()
        });
        all
    }

    /// Inverts bits of a configuration register. False if the register does not have all of them, or the model not the new value. A
    /// protection against writes of a program has no effect.
    pub fn disturb(&mut self, cycle: u64, address: u32, bits: u32) -> bool {
        let Ok((module, offset)) = self.module_at(address) else {
            return false;
        };
        let Ok(value) = self.read(cycle, address, Width::Word) else {
            return false;
        };
        self.changed = true;
        self.touched = true;
        let now = self.now(cycle);
        match module {
            Module::Can => self.can.disturb(now, offset, bits),
            Module::Afio => self.afio.disturb(offset, bits),
            Module::Iwdg => self.iwdg.disturb(now, offset, bits),
            Module::Tim3 => self.tim3.disturb(offset, bits),
            Module::Pwr => {
                let done = self.pwr.disturb(offset, bits);
                if self.pwr.stops_flash() {
                    self.rcc.stop();
                }
                done
            }
            Module::Rcc => {
                self.advance_spi(cycle);
                let done = self.rcc.disturb(cycle, offset, bits);
                self.can.disturb_clock(self.rcc.pclk1());
                done.unwrap_or_else(|| self.write_inverted(cycle, address, value, bits))
            }
            Module::Spi if self.chip == Chip::F446 && (offset, bits) == (0x04, 1 << 4) => {
                self.spi.disturb_frame_format();
                true
            }
            _ => self.write_inverted(cycle, address, value, bits),
        }
    }

    /// Inverts bits by a write. False if they are not inverted after it.
    fn write_inverted(&mut self, cycle: u64, address: u32, value: u32, bits: u32) -> bool {
        let written = self.write(cycle, address, Width::Word, value ^ bits);
        let read = self.read(cycle, address, Width::Word);
        written.is_ok() && read.is_ok_and(|read| (read ^ value) & bits == bits)
    }

    fn is_configuration(&self, module: Module, offset: u32) -> bool {
        match module {
            // The bootloader resets the unit before each calculation.
            Module::Signature | Module::Crc => false,
            // IWDG_PR, IWDG_RLR. No value stops the watchdog.
            Module::Iwdg => matches!(offset, 0x04 | 0x08),
            // SR, EGR, CNT, and what TIM4 has captured.
            Module::Tim3 => !matches!(offset, 0x10 | 0x14 | 0x24),
            Module::Tim4 => !matches!(offset, 0x10 | 0x14 | 0x24 | 0x34..=0x40),
            Module::Can => self.can.is_configuration(offset),
            // CSR.
            Module::Pwr => offset != 0x04,
            // SR, DR, CSR.
            Module::Adc => !matches!(offset, 0x00 | 0x4C | 0x300),
            Module::Afio | Module::Rcc | Module::Dbgmcu => true,
            // IDR, BSRR, BRR, and LCKR, which a sequence of writes changes.
            Module::Gpio(_) => match self.chip {
                Chip::F103 => !matches!(offset, 0x08 | 0x10..=0x18),
                Chip::F446 => !matches!(offset, 0x10 | 0x18 | 0x1C),
            },
            // SR, DR.
            Module::Spi => !matches!(offset, 0x08 | 0x0C),
            // All except ACR: each operation writes CR, and is locked in between.
            Module::Flash => offset == 0,
        }
    }
}
