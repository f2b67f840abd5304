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

    /// Inverts bits of a configuration register. False if the register does not have all of them, or the model not the new value.
    pub fn disturb(&mut self, cycle: u64, address: u32, bits: u32) -> bool {
        let Ok((module, offset)) = self.module_at(address) else {
            return false;
        };
        let Ok(value) = self.read(cycle, address, Width::Word) else {
            return false;
        };
        let done = match module {
            Module::Can => {
                self.changed = true;
                self.touched = true;
                let now = self.now(cycle);
                self.can.disturb(now, offset, bits)
            }
            Module::Afio => self.afio.disturb(offset, bits),
            Module::Iwdg => {
                self.changed = true;
                self.touched = true;
                let now = self.now(cycle);
                self.iwdg.disturb(now, offset, bits)
            }
            _ => self
                .write(cycle, address, Width::Word, value ^ bits)
                .is_ok(),
        };
        done && self.read(cycle, address, Width::Word) == Ok(value ^ bits)
    }

    fn is_configuration(&self, module: Module, offset: u32) -> bool {
        match module {
            Module::Signature => false,
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
