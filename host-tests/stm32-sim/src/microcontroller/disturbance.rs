//! Disturbances: a bit of a configuration register is inverted.

use super::Microcontroller;
use crate::cortex_m::disturbance::SYSTEM;
use crate::io::{Io, Width};
use crate::rcc::ResetCause;

impl Microcontroller {
    /// The addresses of the configuration registers: those of the processor, and of the peripherals that have a clock.
    pub fn configuration(&mut self) -> Vec<u32> {
        let cycle = self.core.cycle();
        let mut all = self.io.configuration(cycle);
        all.extend(self.core.configuration());
        all
    }

    /// The value of such a register.
    pub fn configured(&mut self, address: u32) -> Option<u32> {
        if SYSTEM.contains(&address) {
            return self.core.peek(address);
        }
        let cycle = self.core.cycle();
        self.io.read(cycle, address, Width::Word).ok()
    }

    /// Inverts bits of such a register. False if the register does not have all of them, or the model not the new value.
    pub fn disturb(&mut self, address: u32, bits: u32) -> bool {
        if SYSTEM.contains(&address) {
            return self.core.disturb(address, bits);
        }
        let cycle = self.core.cycle();
        self.io_mut().disturb(cycle, address, bits)
    }

    /// Resets it, as a short low level at NRST does.
    pub fn reset_by_pin(&mut self) {
        self.reset(ResetCause::Pin);
    }

    /// Resets it, as a supply does that is low for a moment.
    pub fn reset_by_low_supply(&mut self) {
        self.reset(ResetCause::BrownOut);
    }
}
