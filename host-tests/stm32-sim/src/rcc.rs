//! Reset and clock control (RM0008, chapter 7; RM0390, chapter 6).
//!
//! | STM32F103 | STM32F446 | register | |
//! |---|---|---|---|
//! | 00h | 00h | RCC_CR | oscillators and PLL, with their ready flags |
//! | | 04h | RCC_PLLCFGR | PLL |
//! | 04h | 08h | RCC_CFGR | source and prescalers; on the STM32F103 also the PLL |
//! | 08h | 0Ch | RCC_CIR | clock interrupts: only that of the clock security system |
//! | 0Ch, 10h | 24h, 20h | RCC_APB2RSTR, RCC_APB1RSTR | peripheral resets |
//! | | 10h | RCC_AHB1RSTR | peripheral resets |
//! | 14h | 30h | RCC_AHBENR, RCC_AHB1ENR | peripheral clocks |
//! | 18h, 1Ch | 44h, 40h | RCC_APB2ENR, RCC_APB1ENR | peripheral clocks |
//! | 24h | 74h | RCC_CSR | reset flags, LSI |
//! | | 50h, 60h, 64h | RCC_AHB1LPENR, RCC_APB1LPENR, RCC_APB2LPENR | clocks in sleep mode: stored, without effect |
//! | | 8Ch | RCC_DCKCFGR | clocks of I2S and SAI: stored, without effect; TIMPRE is not modelled |
//!
//! All other registers, among them RCC_BDCR, are not modelled.

mod disturbance;
mod failure;
mod frequencies;
mod layout;

#[cfg(test)]
mod tests;

use super::chip::Chip;
use super::io::AccessError;
use super::timebase::{MICROSECOND, Picoseconds, Timebase};
use super::violation::Violations;
use layout::{Layout, Register, SLEEP_RESET, SLEEP_WRITABLE};

/// The crystal on the Blue Pill, and the clock from the ST-LINK on a Nucleo, in Hz.
pub const CRYSTAL: u32 = 8_000_000;

/// The time until HSE is ready: a crystal (DS5319, typical), or a clock from outside.
const CRYSTAL_STARTUP: Picoseconds = 2000 * MICROSECOND;
const CLOCK_STARTUP: Picoseconds = 2 * MICROSECOND;

// Start-up times (DS5319, tables of oscillator characteristics and PLL; those of DS10693 are similar): maximum for HSI and PLL,
// typical and maximum for LSI.
const HSI_STARTUP: Picoseconds = 2 * MICROSECOND;
const PLL_LOCK: Picoseconds = 200 * MICROSECOND;
const LSI_STARTUP: Picoseconds = 85 * MICROSECOND;

// RCC_CR.
const HSI_ON: u32 = 1 << 0;
const HSI_READY: u32 = 1 << 1;
const HSI_TRIM: u32 = 0x1F << 3;
const HSE_ON: u32 = 1 << 16;
const HSE_READY: u32 = 1 << 17;
const HSE_BYPASS: u32 = 1 << 18;
const SECURITY_ON: u32 = 1 << 19;
const PLL_ON: u32 = 1 << 24;
const PLL_READY: u32 = 1 << 25;
const CR_WRITABLE: u32 = HSI_ON | HSI_TRIM | HSE_ON | HSE_BYPASS | SECURITY_ON | PLL_ON;
/// HSI on, its trimming at the middle value.
const CR_RESET: u32 = 0x81;

// RCC_CFGR.
const SOURCE: u32 = 0b11;
const SOURCE_STATUS: u32 = 0b11 << 2;
const PLL_SOURCE: u32 = 1 << 16;
const PLL_HALVES_CRYSTAL: u32 = 1 << 17;
const PLL_FACTOR: u32 = 0xF << 18;

// RCC_CSR.
const LSI_ON: u32 = 1 << 0;
const LSI_READY: u32 = 1 << 1;
const REMOVE_FLAGS: u32 = 1 << 24;
const PIN_RESET: u32 = 1 << 26;
const POWER_ON_RESET: u32 = 1 << 27;
const SOFTWARE_RESET: u32 = 1 << 28;
const WATCHDOG_RESET: u32 = 1 << 29;
/// Bit 25 is BORRSTF, only on the STM32F446.
const RESET_FLAGS: u32 = 0xFE00_0000;

/// TIMPRE in RCC_DCKCFGR.
const TIMER_PRESCALER: u32 = 1 << 24;

/// The cause of a reset of the microcontroller.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum ResetCause {
    /// The supply was switched on.
    PowerOn,
    /// A low level at the pin NRST.
    Pin,
    /// The program: SYSRESETREQ of the processor.
    Software,
    /// The supply was below the brown-out level of the STM32F446, or for a moment below that of power-down of the STM32F103.
    BrownOut,
    /// The independent watchdog was not fed in time.
    Watchdog,
}

/// The clock enable bit of a peripheral; it is also the reset bit.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Gate {
    /// RCC_AHB1ENR and RCC_AHB1RSTR of the STM32F446.
    Ahb1(u8),
    /// A bit of RCC_APB1ENR and RCC_APB1RSTR.
    Apb1(u8),
    /// A bit of RCC_APB2ENR and RCC_APB2RSTR.
    Apb2(u8),
}

/// The source of SYSCLK, numbered as in RCC_CFGR.SW.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Source {
    Hsi = 0,
    Hse = 1,
    Pll = 2,
}

/// An oscillator: off, or on and ready from a given time.
type Oscillator = Option<Picoseconds>;

/// RCC, with the time base of its clocks.
#[derive(Debug)]
pub struct Rcc {
    chip: Chip,
    layout: &'static Layout,
    timebase: Timebase,
    cr: u32,
    cfgr: u32,
    /// RCC_PLLCFGR, only on the STM32F446.
    pll_config: u32,
    /// RCC_DCKCFGR, only on the STM32F446.
    dedicated_clocks: u32,
    /// The clocks in sleep mode, only on the STM32F446.
    sleep: [u32; 3],
    source: Source,
    hsi: Oscillator,
    hse: Oscillator,
    pll: Oscillator,
    lsi: Oscillator,
    ahb_reset: u32,
    /// LSI, as switched on by the watchdog.
    watchdog_lsi: Oscillator,
    apb1_reset: u32,
    apb2_reset: u32,
    ahb_enable: u32,
    apb1_enable: u32,
    apb2_enable: u32,
    reset_flags: u32,
    lsi_on: bool,
    crystal_broken: bool,
    /// The PLL does not lock.
    pll_broken: bool,
    /// The board has a crystal in place of its clock.
    has_crystal: bool,
    /// HSE is a clock from outside, for example from the ST-LINK (UM1724, "OSC clock"): it needs HSEBYP.
    has_external_clock: bool,
    /// When the crystal stops.
    crystal_stops: Option<Picoseconds>,
    /// CSSF: the clock security system has detected a failure of HSE.
    failure: bool,
    /// SYSCLK has stopped.
    stopped: bool,
}

impl Rcc {
    /// After power-on at cycle 0. HSE is a clock from outside, or a crystal.
    pub fn new(chip: Chip, has_external_clock: bool) -> Self {
        let layout = Layout::of(chip);
        Self {
            chip,
            layout,
            pll_config: layout.pll_reset,
            dedicated_clocks: 0,
            sleep: SLEEP_RESET,
            timebase: Timebase::new(chip.facts().hsi),
            cr: CR_RESET,
            cfgr: 0,
            source: Source::Hsi,
            hsi: Some(0),
            hse: None,
            pll: None,
            lsi: None,
            ahb_reset: 0,
            watchdog_lsi: None,
            apb1_reset: 0,
            apb2_reset: 0,
            ahb_enable: layout.ahb_enable_reset,
            apb1_enable: 0,
            apb2_enable: 0,
            reset_flags: layout.power_on_flags,
            lsi_on: false,
            crystal_broken: false,
            pll_broken: false,
            has_crystal: false,
            has_external_clock,
            crystal_stops: None,
            failure: false,
            stopped: false,
        }
    }

    /// A reset at `cycle`; time continues. The flags in RCC_CSR accumulate until the firmware clears them (RMVF) or the supply is
    /// switched on; every internal reset also drives the NRST pin.
    pub fn reset(&mut self, cycle: u64, cause: ResetCause) {
        let mut timebase = self.timebase;
        timebase.set_frequency(cycle, self.chip.facts().hsi);
        let flags = match cause {
            ResetCause::PowerOn => self.layout.power_on_flags,
            ResetCause::BrownOut => self.reset_flags | self.layout.brown_out_flags,
            ResetCause::Pin => self.reset_flags | PIN_RESET,
            ResetCause::Software => self.reset_flags | PIN_RESET | SOFTWARE_RESET,
            ResetCause::Watchdog => self.reset_flags | PIN_RESET | WATCHDOG_RESET,
        };
        *self = Self {
            timebase,
            reset_flags: flags,
            crystal_broken: self.crystal_broken,
            pll_broken: self.pll_broken,
            has_crystal: self.has_crystal,
            crystal_stops: self.crystal_stops,
            ..Self::new(self.chip, self.has_external_clock)
        };
    }

    /// `cycle` begins at `time`: the power was off until then.
    pub fn go_on(&mut self, cycle: u64, time: Picoseconds) {
        self.timebase.go_on(cycle, time);
    }

    /// The watchdog has been started, which switches LSI on without LSION (RM0008, section 19.3).
    pub fn watchdog_runs(&mut self, now: Picoseconds) {
        switch(&mut self.watchdog_lsi, true, now, LSI_STARTUP);
    }

    /// The conversion from cycles to time.
    pub fn timebase(&self) -> &Timebase {
        &self.timebase
    }

    /// True when HSI runs, without which the flash cannot be programmed or erased (PM0075, section 2.3).
    pub fn hsi_is_on(&self) -> bool {
        self.cr & HSI_ON != 0
    }

    /// True when the peripheral of this gate has a clock.
    pub fn is_clocked(&self, gate: Gate) -> bool {
        match gate {
            Gate::Ahb1(bit) => self.ahb_enable >> bit & 1 != 0,
            Gate::Apb1(bit) => self.apb1_enable >> bit & 1 != 0,
            Gate::Apb2(bit) => self.apb2_enable >> bit & 1 != 0,
        }
    }

    /// True while the firmware holds the peripheral of this gate in reset.
    pub fn is_in_reset(&self, gate: Gate) -> bool {
        match gate {
            Gate::Ahb1(bit) => self.ahb_reset >> bit & 1 != 0,
            Gate::Apb1(bit) => self.apb1_reset >> bit & 1 != 0,
            Gate::Apb2(bit) => self.apb2_reset >> bit & 1 != 0,
        }
    }

    /// The cycle at which the clock changes without an access: a selected source becomes ready, or the crystal stops.
    pub fn next_event(&self) -> Option<u64> {
        [self.next_switch(), self.crystal_stops]
            .into_iter()
            .flatten()
            .min()
            .map(|time| self.timebase.cycle_at(time))
    }

    /// When the selected source becomes ready.
    fn next_switch(&self) -> Option<Picoseconds> {
        let chosen = self.chosen()?;
        let ready = self.oscillator(chosen)?;
        (chosen != self.source && ready != Picoseconds::MAX).then_some(ready)
    }

    /// The cycle up to which all registers keep their values, from `cycle` on, without an access or an event.
    pub fn constant_until(&self, cycle: u64) -> u64 {
        let now = self.timebase.time_at(cycle);
        let oscillators = [self.hsi, self.hse, self.pll, self.lsi, self.watchdog_lsi];
        let ready = oscillators.into_iter().flatten();
        let next = ready
            .filter(|time| (now + 1..Picoseconds::MAX).contains(time))
            .min();
        next.map_or(u64::MAX, |time| self.timebase.cycle_at(time))
    }

    /// Reads the register at `offset`.
    pub fn read(&mut self, cycle: u64, offset: u32) -> Result<u32, AccessError> {
        self.settle(cycle);
        let now = self.timebase.time_at(cycle);
        let ready = |oscillator: Oscillator, flag| match oscillator {
            Some(from) if from <= now => flag,
            _ => 0,
        };
        Ok(match self.layout.register(offset)? {
            Register::Cr => {
                self.cr
                    | ready(self.hsi, HSI_READY)
                    | ready(self.hse, HSE_READY)
                    | ready(self.pll, PLL_READY)
            }
            Register::PllCfgr => self.pll_config,
            Register::Cfgr => self.cfgr | (self.source as u32) << 2,
            Register::Cir => self.interrupts(),
            Register::AhbReset => self.ahb_reset,
            Register::Apb2Reset => self.apb2_reset,
            Register::Apb1Reset => self.apb1_reset,
            Register::AhbEnable => self.ahb_enable,
            Register::Apb2Enable => self.apb2_enable,
            Register::Apb1Enable => self.apb1_enable,
            Register::DedicatedClocks => self.dedicated_clocks,
            Register::Sleep(bus) => self.sleep[bus],
            Register::Csr => {
                let ready = ready(self.lsi, LSI_READY) | ready(self.watchdog_lsi, LSI_READY);
                self.reset_flags | u32::from(self.lsi_on) | ready
            }
        })
    }

    /// Writes the register at `offset`.
    pub fn write(
        &mut self,
        cycle: u64,
        offset: u32,
        value: u32,
        violations: &mut Violations,
    ) -> Result<(), AccessError> {
        self.settle(cycle);
        let register = self.layout.register(offset)?;
        let value = self.layout.defined(register, value, violations);
        match register {
            Register::Cr => self.write_cr(cycle, value, violations),
            Register::PllCfgr => self.write_pll(value, violations),
            Register::Cfgr => self.write_cfgr(value, violations),
            Register::Cir => self.write_interrupts(value, violations),
            Register::AhbReset => self.ahb_reset = value,
            Register::Apb2Reset => self.apb2_reset = value,
            Register::Apb1Reset => self.apb1_reset = value,
            Register::AhbEnable => self.ahb_enable = value,
            Register::Apb2Enable => self.apb2_enable = value,
            Register::Apb1Enable => self.apb1_enable = value,
            Register::DedicatedClocks => {
                violations.check(value & TIMER_PRESCALER != 0, "RCC_DCKCFGR", "not modelled");
                self.dedicated_clocks = value;
            }
            Register::Sleep(bus) => {
                let writable = SLEEP_WRITABLE[bus];
                self.sleep[bus] = value & writable | SLEEP_RESET[bus] & !writable;
            }
            Register::Csr => self.write_csr(cycle, value),
        }
        self.settle(cycle);
        self.check_limits(violations);
        Ok(())
    }

    fn write_cr(&mut self, cycle: u64, value: u32, violations: &mut Violations) {
        // A clock that is a source of SYSCLK, directly or through the PLL, cannot be switched off.
        let pll_source = if self.pll_takes_hse() { HSE_ON } else { HSI_ON };
        let in_use = match self.source {
            Source::Hsi => HSI_ON,
            Source::Hse => HSE_ON,
            Source::Pll => PLL_ON | pll_source,
        };
        violations.check(
            value & in_use != in_use,
            "RCC_CR",
            "the clock in use is switched off",
        );
        violations.check(
            self.cr & HSE_ON != 0 && (self.cr ^ value) & HSE_BYPASS != 0,
            "RCC_CR",
            "HSEBYP is changed while HSE is on",
        );
        self.cr = value & CR_WRITABLE | in_use;
        violations.check(
            self.cr & PLL_ON != 0 && self.cr & pll_source == 0,
            "RCC_CR",
            "the PLL is switched on without its source",
        );
        let now = self.timebase.time_at(cycle);
        let bypassed = self.cr & HSE_BYPASS != 0;
        let missing =
            self.crystal_broken || bypassed != (self.has_external_clock && !self.has_crystal);
        let hse_startup = match (missing, self.hse) {
            (true, None) => Picoseconds::MAX - now,
            _ if bypassed => CLOCK_STARTUP,
            _ => CRYSTAL_STARTUP,
        };
        switch(&mut self.hsi, self.cr & HSI_ON != 0, now, HSI_STARTUP);
        switch(&mut self.hse, self.cr & HSE_ON != 0, now, hse_startup);
        let source_ready = if pll_source == HSE_ON {
            self.hse
        } else {
            self.hsi
        };
        let lock = source_ready.filter(|_| !self.pll_broken);
        let lock = lock.map_or(Picoseconds::MAX, |ready| {
            ready.max(now).saturating_add(PLL_LOCK)
        });
        switch(&mut self.pll, self.cr & PLL_ON != 0, now, lock - now);
    }

    fn write_cfgr(&mut self, value: u32, violations: &mut Violations) {
        let mut value = value & !SOURCE_STATUS;
        let pll_bits = self.layout.pll_bits_in_cfgr;
        if self.cr & PLL_ON != 0 && (value ^ self.cfgr) & pll_bits != 0 {
            violations.add("RCC_CFGR", "the PLL is set up while it runs");
            value = value & !pll_bits | self.cfgr & pll_bits;
        }
        violations.check(value & SOURCE == 0b11, "RCC_CFGR", "SW: 11 is not allowed");
        self.cfgr = value;
    }

    fn write_csr(&mut self, cycle: u64, value: u32) {
        if value & REMOVE_FLAGS != 0 {
            self.reset_flags &= !RESET_FLAGS;
        }
        self.lsi_on = value & LSI_ON != 0;
        let now = self.timebase.time_at(cycle);
        switch(&mut self.lsi, self.lsi_on, now, LSI_STARTUP);
    }

    /// The source that the firmware has selected in RCC_CFGR.SW.
    fn chosen(&self) -> Option<Source> {
        match self.cfgr & SOURCE {
            0 => Some(Source::Hsi),
            1 => Some(Source::Hse),
            2 => Some(Source::Pll),
            _ => None,
        }
    }

    fn oscillator(&self, source: Source) -> Oscillator {
        match source {
            Source::Hsi => self.hsi,
            Source::Hse => self.hse,
            Source::Pll => self.pll,
        }
    }

    /// Switches the clock once the selected source is ready (RM0008, section 7.2.6); from then on HCLK determines the length of
    /// cycles.
    pub fn settle(&mut self, cycle: u64) {
        let now = self.timebase.time_at(cycle);
        if self.crystal_stops.take_if(|at| *at <= now).is_some() {
            self.crystal_broken = true;
            self.lose_hse();
        }
        let ready = |source| self.oscillator(source).is_some_and(|ready| ready <= now);
        if let Some(chosen) = self.chosen().filter(|source| ready(*source)) {
            self.source = chosen;
        }
        if self.hclk() != self.timebase.frequency() {
            self.timebase.set_frequency(cycle, self.hclk());
        }
    }
}

/// Switches an oscillator; no effect if it is already on.
fn switch(oscillator: &mut Oscillator, on: bool, now: Picoseconds, startup: Picoseconds) {
    *oscillator = match (on, *oscillator) {
        (false, _) => None,
        (true, None) => Some(now + startup),
        (true, running) => running,
    };
}
