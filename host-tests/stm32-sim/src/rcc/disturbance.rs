//! Disturbances of the bits that a program cannot write while the clock that they select is in use.
//!
//! Assumption: a change of the PLL takes effect at once. The manuals do not say so.

use super::layout::Register;
use super::{CR_WRITABLE, HSE_BYPASS, HSE_ON, HSI_ON, PLL_ON, Rcc, SOURCE_STATUS, Source};

impl Rcc {
    /// Inverts bits of RCC_CR, RCC_CFGR or RCC_PLLCFGR. False if the register does not have all of them; None for another register.
    pub fn disturb(&mut self, cycle: u64, offset: u32, bits: u32) -> Option<bool> {
        let register = self.layout.register(offset).ok()?;
        let missing = match register {
            Register::Cr => !CR_WRITABLE,
            Register::Cfgr => self.layout.reserved(register) | SOURCE_STATUS,
            Register::PllCfgr => self.layout.reserved(register),
            _ => return None,
        };
        if bits & missing != 0 {
            return Some(false);
        }
        match register {
            Register::Cr => self.disturb_control(bits),
            Register::Cfgr => self.cfgr ^= bits,
            _ => self.disturb_pll(bits),
        }
        self.settle(cycle);
        Some(true)
    }

    /// With a factor of 0 (PLLN), the PLL has no output.
    fn disturb_pll(&mut self, bits: u32) {
        self.pll_config ^= bits;
        if self.pll_frequency() == 0 {
            self.pll_config ^= bits;
            self.stopped |= self.source == Source::Pll;
        }
    }

    /// An oscillator in use can only be switched off: each of them runs.
    fn disturb_control(&mut self, bits: u32) {
        self.cr ^= bits;
        if bits & (HSE_ON | HSE_BYPASS) != 0 {
            // With the other kind of clock, HSE has none.
            self.lose_hse();
        }
        if bits & HSI_ON != 0 {
            self.hsi = None;
            self.stopped |= self.source == Source::Hsi;
        }
        if bits & PLL_ON != 0 {
            self.pll = None;
            self.stopped |= self.source == Source::Pll;
        }
    }
}
