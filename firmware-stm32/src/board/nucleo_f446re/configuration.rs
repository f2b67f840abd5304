//! The registers that only the boot changes.

use crate::board::registers::Register;

/// The registers of the [`Configuration`](crate::board::Configuration).
pub(in crate::board) const REGISTERS: [Register; 42] = [
    // RCC: the resets of AHB1, APB1 and APB2, the enables, the oscillators without their ready flags, the clock tree without SWS. The main
    // loop switches TIM4 on.
    Register::new(0x4002_3810, !0),
    Register::new(0x4002_3820, !0),
    Register::new(0x4002_3824, !0),
    Register::new(0x4002_3830, !0),
    Register::new(0x4002_3840, !(1 << 2)),
    Register::new(0x4002_3844, !0),
    // The clocks in sleep mode of AHB1, APB1 and APB2: without that of CAN, the sensor is mute while the core sleeps.
    Register::new(0x4002_3850, !0),
    Register::new(0x4002_3860, !0),
    Register::new(0x4002_3864, !0),
    // Fixed: HSEON, HSEBYP, PLLON; RCC_PLLCFGR.
    Register::new(0x4002_3800, 0x010D_00F9).with_fixed(0x0105_0000),
    Register::new(0x4002_3804, !0).with_fixed(!0),
    Register::new(0x4002_3808, !0b1100),
    // RCC_DCKCFGR: TIMPRE, which selects the clock of the timers.
    Register::new(0x4002_388C, 1 << 24),
    // FLASH_ACR.
    Register::new(0x4002_3C00, 0x1F0F),
    // PWR_CR: the voltage detector. Fixed: VOS, ODEN, ODSWEN.
    Register::new(0x4000_7000, 0x3_C0F0).with_fixed(0x3_C000),
    // GPIO A, B, C: modes without that of TXD, speeds, pulls, alternate functions.
    Register::new(0x4002_0000, !(0b11 << 24)),
    Register::new(0x4002_0008, !0),
    Register::new(0x4002_000C, !0),
    Register::new(0x4002_0024, !0),
    Register::new(0x4002_0400, !0),
    Register::new(0x4002_0408, !0),
    Register::new(0x4002_040C, !0),
    Register::new(0x4002_0420, !0),
    Register::new(0x4002_0424, !0),
    Register::new(0x4002_0800, !0),
    Register::new(0x4002_080C, !0),
    // TIM3: CR2, SMCR, CCMR2, CCER, PSC, ARR, CR1.
    Register::new(0x4000_0404, 0xFFFF),
    Register::new(0x4000_0408, 0xFFFF),
    Register::new(0x4000_041C, 0xFFFF),
    Register::new(0x4000_0420, 0xFFFF),
    Register::new(0x4000_0428, 0xFFFF),
    Register::new(0x4000_042C, 0xFFFF),
    Register::new(0x4000_0400, 0xFFFF),
    // SPI2: CR1, CR2, I2SCFGR.
    Register::new(0x4000_3800, 0xFFFF),
    Register::new(0x4000_3804, 0xFFFF),
    Register::new(0x4000_381C, 0xFFFF),
    // GPIO A, B, C: the outputs are push-pull. GPIOA: TXD is recessive until the controller has it.
    Register::new(0x4002_0004, 0xFFFF),
    Register::new(0x4002_0404, 0xFFFF),
    Register::new(0x4002_0804, 0xFFFF),
    Register::new(0x4002_0014, 1 << 12),
    // CPACR: the floating-point unit. MPU_CTRL: the MPU is off.
    Register::new(0xE000_ED88, !0),
    Register::new(0xE000_ED94, 0b111),
];
