//! Failures of the crystal and of the PLL, and the clock security system (RM0008, section 7.2.7).
//!
//! If the security system is on, a failure of a running HSE raises NMI until the firmware writes CSSC. It switches HSE off. If
//! SYSCLK comes from HSE, directly or through the PLL, it also switches SYSCLK to HSI and the PLL off. Without the security
//! system, SYSCLK stops: the pins keep their levels, and only the watchdog, which has its own clock, ends this state.

use super::{HSE_ON, HSI_ON, PLL_ON, Picoseconds, Rcc, SECURITY_ON, SOURCE, Source};
use crate::violation::Violations;

// RCC_CIR.
const FAILURE: u32 = 1 << 7;
const ENABLES: u32 = 0x1F << 8;
const CLEAR_FAILURE: u32 = 1 << 23;

impl Rcc {
    /// Mounts a crystal in place of the clock from the ST-LINK, which has no supply.
    pub fn mount_crystal(&mut self) {
        self.has_crystal = true;
    }

    /// Breaks the crystal (it no longer starts; if running, it continues) or repairs it.
    pub fn break_crystal(&mut self, broken: bool) {
        self.crystal_broken = broken;
        if !broken {
            self.crystal_stops = None;
        }
    }

    /// Breaks the crystal at this time, also if it runs.
    pub fn stop_crystal(&mut self, time: Picoseconds) {
        self.crystal_stops = Some(time);
    }

    /// Breaks the PLL (it does not lock when it is switched on) or repairs it.
    pub fn break_pll(&mut self, broken: bool) {
        self.pll_broken = broken;
    }

    /// The level of NMI: a failure is detected and not cleared.
    pub fn nmi(&self) -> bool {
        self.failure
    }

    /// Stops SYSCLK until the next reset.
    pub fn stop(&mut self) {
        self.stopped = true;
    }

    /// True if SYSCLK has stopped, until the next reset.
    pub fn is_stopped(&self) -> bool {
        self.stopped
    }

    /// The value of RCC_CIR.
    pub(super) fn interrupts(&self) -> u32 {
        if self.failure { FAILURE } else { 0 }
    }

    pub(super) fn write_interrupts(&mut self, value: u32, violations: &mut Violations) {
        violations.check(value & ENABLES != 0, "RCC_CIR", "interrupt not modelled");
        if value & CLEAR_FAILURE != 0 {
            self.failure = false;
        }
    }

    /// HSE has stopped.
    pub(super) fn lose_hse(&mut self) {
        if self.hse.is_none() {
            return;
        }
        let through_pll = self.pll_takes_hse();
        let in_use = match self.source {
            Source::Hsi => false,
            Source::Hse => true,
            Source::Pll => through_pll,
        };
        if self.cr & SECURITY_ON == 0 {
            self.hse = Some(Picoseconds::MAX);
            self.stopped = in_use;
            return;
        }
        self.failure = true;
        self.hse = None;
        self.cr &= !HSE_ON;
        if in_use {
            self.cr |= HSI_ON;
            self.hsi = self.hsi.or(Some(0));
            self.source = Source::Hsi;
            self.cfgr &= !SOURCE;
        }
        if through_pll {
            self.cr &= !PLL_ON;
            self.pll = None;
        }
    }
}
