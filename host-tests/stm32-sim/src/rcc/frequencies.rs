//! The frequency of each clock (RM0008, figure 8).

use super::{CRYSTAL, HSI, PLL_FACTOR, PLL_HALVES_CRYSTAL, PLL_SOURCE, Rcc, Source};

impl Rcc {
    /// SYSCLK in Hz.
    pub fn sysclk(&self) -> u32 {
        match self.source {
            Source::Hsi => HSI,
            Source::Hse => CRYSTAL,
            Source::Pll => self.pll_frequency(),
        }
    }

    /// AHB and processor clock in Hz.
    pub fn hclk(&self) -> u32 {
        // RCC_CFGR.HPRE: there is no division by 32.
        self.sysclk()
            >> match self.cfgr >> 4 & 0xF {
                code @ 0b1000..=0b1011 => code - 7,
                code @ 0b1100..=0b1111 => code - 6,
                _ => 0,
            }
    }

    /// APB1 clock in Hz: the clock of the CAN controller.
    pub fn pclk1(&self) -> u32 {
        self.hclk() >> apb_shift(self.cfgr >> 8)
    }

    /// The clock of the timers on APB1 in Hz: twice that of the bus when the APB1 prescaler is not 1 (RM0008, figure 8).
    pub fn timer_clock(&self) -> u32 {
        let shift = apb_shift(self.cfgr >> 8);
        self.hclk() >> shift.saturating_sub(1)
    }

    /// APB2 clock in Hz: the clock of SPI1.
    pub fn pclk2(&self) -> u32 {
        self.hclk() >> apb_shift(self.cfgr >> 11)
    }

    pub(super) fn pll_frequency(&self) -> u32 {
        let input = match (self.cfgr & PLL_SOURCE, self.cfgr & PLL_HALVES_CRYSTAL) {
            (0, _) => HSI / 2,
            (_, 0) => CRYSTAL,
            _ => CRYSTAL / 2,
        };
        // PLLMUL: 0000 is times 2; both 1110 and 1111 are times 16.
        input * (((self.cfgr & PLL_FACTOR) >> 18).min(14) + 2)
    }
}

/// An APB prescaler (RCC_CFGR.PPRE1, PPRE2) as a shift.
fn apb_shift(code: u32) -> u32 {
    match code & 0b111 {
        code @ 0b100..=0b111 => code - 3,
        _ => 0,
    }
}
