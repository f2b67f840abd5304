//! The differences of the RCC of the two microcontrollers: register map, positions of fields, limits.

use super::{PIN_RESET, PLL_FACTOR, PLL_HALVES_CRYSTAL, PLL_SOURCE, POWER_ON_RESET};
use crate::chip::Chip;
use crate::io::AccessError;
use crate::violation::Violations;

#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Register {
    Cr,
    PllCfgr,
    Cfgr,
    Cir,
    AhbReset,
    Apb1Reset,
    Apb2Reset,
    AhbEnable,
    Apb1Enable,
    Apb2Enable,
    Csr,
    /// RCC_DCKCFGR (STM32F446).
    DedicatedClocks,
    /// RCC_AHB1LPENR, RCC_APB1LPENR and RCC_APB2LPENR (STM32F446).
    Sleep(usize),
}

/// The clocks in sleep mode after a reset, all of them on, and the bits that can be written (STM32F446, from the SVD).
pub(super) const SLEEP_RESET: [u32; 3] = [0x7E67_91FF, 0x36FE_C9FF, 0x0007_5F33];
pub(super) const SLEEP_WRITABLE: [u32; 3] = [0x6067_90FF, 0x3FFF_C9FF, 0x00C7_7F33];

/// The reserved bits of the registers that are checked for them.
#[derive(Debug)]
struct Reserved {
    cfgr: u32,
    ahb_reset: u32,
    ahb_enable: u32,
    apb1: u32,
    apb2_reset: u32,
    apb2_enable: u32,
    pll: u32,
    dedicated: u32,
}

/// The highest clocks in Hz, and the reasons of the violations.
#[derive(Debug)]
pub(super) struct Limits {
    pub(super) sysclk: u32,
    pub(super) sysclk_reason: &'static str,
    pub(super) pclk1: u32,
    pub(super) pclk1_reason: &'static str,
    pub(super) pclk2: u32,
    pub(super) pclk2_reason: &'static str,
}

/// The RCC of a microcontroller.
#[derive(Debug)]
pub(super) struct Layout {
    registers: &'static [(u32, Register)],
    /// The lowest bit of PPRE1 in RCC_CFGR.
    pub(super) apb1_at: u32,
    /// The lowest bit of PPRE2.
    pub(super) apb2_at: u32,
    /// The bits of the PLL in RCC_CFGR.
    pub(super) pll_bits_in_cfgr: u32,
    /// The value of RCC_PLLCFGR after a reset.
    pub(super) pll_reset: u32,
    /// RCC_AHBENR, or RCC_AHB1ENR, after a reset.
    pub(super) ahb_enable_reset: u32,
    /// The flags in RCC_CSR after power-on.
    pub(super) power_on_flags: u32,
    /// The flags that a low supply sets.
    pub(super) brown_out_flags: u32,
    pub(super) limits: Limits,
    reserved: Reserved,
}

/// BORRSTF in RCC_CSR of the STM32F446.
const BROWN_OUT_RESET: u32 = 1 << 25;

impl Layout {
    pub(super) fn of(chip: Chip) -> &'static Self {
        match chip {
            Chip::F103 => &F103,
            Chip::F446 => &F446,
        }
    }

    /// The bits of a write that are not reserved; a reserved bit that is set is a violation.
    pub(super) fn defined(
        &self,
        register: Register,
        value: u32,
        violations: &mut Violations,
    ) -> u32 {
        let name = match register {
            Register::Cfgr => "RCC_CFGR",
            Register::AhbReset => "RCC_AHB1RSTR",
            Register::AhbEnable => "RCC_AHBENR",
            Register::Apb1Reset => "RCC_APB1RSTR",
            Register::Apb1Enable => "RCC_APB1ENR",
            Register::Apb2Reset => "RCC_APB2RSTR",
            Register::Apb2Enable => "RCC_APB2ENR",
            Register::PllCfgr => "RCC_PLLCFGR",
            Register::DedicatedClocks => "RCC_DCKCFGR",
            _ => return value,
        };
        let reserved = self.reserved(register);
        violations.check(value & reserved != 0, name, "reserved bits are written");
        value & !reserved
    }

    /// The reserved bits of a register that is checked for them; otherwise none.
    pub(super) fn reserved(&self, register: Register) -> u32 {
        match register {
            Register::Cfgr => self.reserved.cfgr,
            Register::AhbReset => self.reserved.ahb_reset,
            Register::AhbEnable => self.reserved.ahb_enable,
            Register::Apb1Reset | Register::Apb1Enable => self.reserved.apb1,
            Register::Apb2Reset => self.reserved.apb2_reset,
            Register::Apb2Enable => self.reserved.apb2_enable,
            Register::PllCfgr => self.reserved.pll,
            Register::DedicatedClocks => self.reserved.dedicated,
            _ => 0,
        }
    }

    /// The register at an offset.
    pub(super) fn register(&self, offset: u32) -> Result<Register, AccessError> {
        let found = self.registers.iter().find(|(at, _)| *at == offset);
        found
            .map(|(_, register)| *register)
            .ok_or(AccessError::Refused("RCC: register not modelled"))
    }
}

/// The registers of the STM32F103 (RM0008, section 7.3).
static F103: Layout = Layout {
    registers: &[
        (0x00, Register::Cr),
        (0x04, Register::Cfgr),
        (0x08, Register::Cir),
        (0x0C, Register::Apb2Reset),
        (0x10, Register::Apb1Reset),
        (0x14, Register::AhbEnable),
        (0x18, Register::Apb2Enable),
        (0x1C, Register::Apb1Enable),
        (0x24, Register::Csr),
    ],
    apb1_at: 8,
    apb2_at: 11,
    pll_bits_in_cfgr: PLL_SOURCE | PLL_HALVES_CRYSTAL | PLL_FACTOR,
    pll_reset: 0,
    // Clocks of SRAM and flash interface in sleep mode.
    ahb_enable_reset: 0x14,
    power_on_flags: PIN_RESET | POWER_ON_RESET,
    brown_out_flags: PIN_RESET | POWER_ON_RESET,
    limits: Limits {
        sysclk: 72_000_000,
        sysclk_reason: "SYSCLK above 72 MHz",
        pclk1: 36_000_000,
        pclk1_reason: "PCLK1 above 36 MHz",
        pclk2: 72_000_000,
        pclk2_reason: "PCLK2 above 72 MHz",
    },
    // These bits are reserved on every STM32F103.
    reserved: Reserved {
        cfgr: 0xF880_0000,
        ahb_reset: 0xFFFF_FAA8,
        ahb_enable: 0xFFFF_FAA8,
        apb1: 0xC501_3600,
        apb2_reset: 0xFFC7_0002,
        apb2_enable: 0xFFC7_0002,
        pll: 0,
        dedicated: 0,
    },
};

/// The registers of the STM32F446 (RM0390, section 6.3).
static F446: Layout = Layout {
    registers: &[
        (0x00, Register::Cr),
        (0x04, Register::PllCfgr),
        (0x08, Register::Cfgr),
        (0x0C, Register::Cir),
        (0x10, Register::AhbReset),
        (0x20, Register::Apb1Reset),
        (0x24, Register::Apb2Reset),
        (0x30, Register::AhbEnable),
        (0x40, Register::Apb1Enable),
        (0x44, Register::Apb2Enable),
        (0x50, Register::Sleep(0)),
        (0x60, Register::Sleep(1)),
        (0x64, Register::Sleep(2)),
        (0x74, Register::Csr),
        (0x8C, Register::DedicatedClocks),
    ],
    apb1_at: 10,
    apb2_at: 13,
    pll_bits_in_cfgr: 0,
    pll_reset: 0x2400_3010,
    ahb_enable_reset: 0x0010_0000,
    power_on_flags: BROWN_OUT_RESET | PIN_RESET | POWER_ON_RESET,
    brown_out_flags: BROWN_OUT_RESET | PIN_RESET,
    // DS10693: at scale 1 without over-drive, the reset value of PWR_CR.VOS, SYSCLK is at most 168 MHz.
    limits: Limits {
        sysclk: 168_000_000,
        sysclk_reason: "SYSCLK above 168 MHz, without over-drive",
        pclk1: 45_000_000,
        pclk1_reason: "PCLK1 above 45 MHz",
        pclk2: 90_000_000,
        pclk2_reason: "PCLK2 above 90 MHz",
    },
    reserved: Reserved {
        cfgr: 0x0080_0300,
        ahb_reset: 0xDF9F_EF00,
        ahb_enable: 0x9F8B_EF00,
        apb1: 0xC000_3600,
        apb2_reset: 0xFF38_86CC,
        apb2_enable: 0xFF38_80CC,
        pll: 0x80BC_8000,
        dedicated: 0xE00F_E0E0,
    },
};
