//! The frequency of each clock (RM0008, figure 8; RM0390, figure 14).

use super::{CRYSTAL, PLL_FACTOR, PLL_HALVES_CRYSTAL, PLL_SOURCE, Rcc, Source};
use crate::chip::Chip;
use crate::violation::Violations;

/// PLLSRC in RCC_PLLCFGR: HSE.
const PLLCFGR_SOURCE: u32 = 1 << 22;

impl Rcc {
    /// The frequency of SYSCLK in Hz.
    pub fn sysclk(&self) -> u32 {
        match self.source {
            Source::Hsi => self.chip.facts().hsi,
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
        self.hclk() >> apb_shift(self.cfgr >> self.layout.apb1_at)
    }

    /// The clock of the timers on APB1 in Hz: twice that of the bus when the APB1 prescaler is not 1 (RM0008, figure 8; RM0390,
    /// RCC_DCKCFGR.TIMPRE after a reset).
    pub fn timer_clock(&self) -> u32 {
        let shift = apb_shift(self.cfgr >> self.layout.apb1_at);
        self.hclk() >> shift.saturating_sub(1)
    }

    /// The frequency of APB2 in Hz.
    pub fn pclk2(&self) -> u32 {
        self.hclk() >> apb_shift(self.cfgr >> self.layout.apb2_at)
    }

    /// The clock of the converter on the STM32F103, divided by RCC_CFGR.ADCPRE, in Hz. On the STM32F446 the clock of its bus, which the
    /// converter divides itself.
    pub fn adc_clock(&self) -> u32 {
        match self.chip {
            Chip::F103 => self.pclk2() / (2 * ((self.cfgr >> 14 & 0b11) + 1)),
            Chip::F446 => self.pclk2(),
        }
    }

    /// True when MCO of the STM32F103 has a clock (RCC_CFGR.MCO).
    pub fn outputs_clock(&self) -> bool {
        self.cfgr >> 24 & 0b111 != 0
    }

    /// True when the PLL runs from HSE.
    pub(super) fn pll_takes_hse(&self) -> bool {
        match self.chip {
            Chip::F103 => self.cfgr & PLL_SOURCE != 0,
            Chip::F446 => self.pll_config & PLLCFGR_SOURCE != 0,
        }
    }

    pub(super) fn pll_frequency(&self) -> u32 {
        match self.chip {
            Chip::F103 => self.pll_by_factor(),
            // PLLP.
            Chip::F446 => {
                let divider = 2 * ((self.pll_config >> 16 & 0b11) + 1);
                (self.oscillator_frequency() / u64::from(divider)) as u32
            }
        }
    }

    /// The input of the PLL's oscillator in Hz: 1 to 2 MHz (RCC_PLLCFGR.PLLM). Only on the STM32F446.
    fn oscillator_input(&self) -> u32 {
        let source = match self.pll_takes_hse() {
            true => CRYSTAL,
            false => self.chip.facts().hsi,
        };
        source / (self.pll_config & 0x3F).max(1)
    }

    /// The PLL's oscillator in Hz: 100 to 432 MHz (RCC_PLLCFGR.PLLN). Only on the STM32F446.
    fn oscillator_frequency(&self) -> u64 {
        u64::from(self.oscillator_input()) * u64::from(self.pll_config >> 6 & 0x1FF)
    }

    /// A write to RCC_PLLCFGR (RM0390, section 6.3.2).
    pub(super) fn write_pll(&mut self, value: u32, violations: &mut Violations) {
        if self.cr & super::PLL_ON != 0 {
            violations.add("RCC_PLLCFGR", "the PLL is set up while it runs");
            return;
        }
        self.pll_config = value;
    }

    /// The limits of the PLL, when it is switched on, and of the clocks.
    pub(super) fn check_limits(&self, violations: &mut Violations) {
        let limits = &self.layout.limits;
        for (clock, most, reason) in [
            (self.pclk1(), limits.pclk1, limits.pclk1_reason),
            (self.pclk2(), limits.pclk2, limits.pclk2_reason),
            (self.sysclk(), limits.sysclk, limits.sysclk_reason),
        ] {
            violations.check(clock > most, "RCC_CFGR", reason);
        }
        if self.chip == Chip::F446 && self.cr & super::PLL_ON != 0 {
            violations.check(
                !(1_000_000..=2_000_000).contains(&self.oscillator_input())
                    || !(100_000_000..=432_000_000).contains(&self.oscillator_frequency()),
                "RCC_PLLCFGR",
                "the PLL needs an input of 1 to 2 MHz and an oscillator of 100 to 432 MHz",
            );
        }
    }

    /// The PLL of the STM32F103.
    fn pll_by_factor(&self) -> u32 {
        let input = match (self.cfgr & PLL_SOURCE, self.cfgr & PLL_HALVES_CRYSTAL) {
            (0, _) => self.chip.facts().hsi / 2,
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
