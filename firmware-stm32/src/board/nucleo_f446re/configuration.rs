//! The registers that only the boot changes.

use crate::board::registers::Register;

/// The registers of the [configuration](crate::board::restore).
pub(in crate::board) const REGISTERS: [Register; 44] = [
    // RCC: the resets of AHB1, APB1 and APB2, the enables, the oscillators without their ready flags, the clock tree without SWS. ADC1 and
    // TIM4 are switched on by their users.
    Register::new(0x4002_3810, !0, 0),
    Register::new(0x4002_3820, !0, 0),
    Register::new(0x4002_3824, !0, 0),
    Register::new(0x4002_3830, !0, 0x0030_0007),
    Register::new(0x4002_3840, !(1 << 2), 0x1200_4002),
    Register::new(0x4002_3844, !(1 << 8), 0),
    // The clocks in sleep mode of AHB1, APB1 and APB2: without that of CAN, the sensor is mute while the core sleeps.
    Register::new(0x4002_3850, !0, 0x7E67_91FF),
    Register::new(0x4002_3860, !0, 0x36FE_C9FF),
    Register::new(0x4002_3864, !0, 0x0007_5F33),
    // RCC_CR: HSEON and PLLON; CSSON, HSITRIM, HSION. Not HSEBYP: which oscillator has started is not a constant, and HSE that stops causes an
    // NMI. RCC_PLLCFGR, RCC_CFGR.
    Register::new(0x4002_3800, 0x0101_0000, 0x0101_0000).fixed(),
    Register::new(0x4002_3800, 0x0008_00F9, 0x0008_0081),
    Register::new(0x4002_3804, !0, 0x2640_2004).fixed(),
    Register::new(0x4002_3808, !0b1100, 0x9402),
    // RCC_DCKCFGR: TIMPRE, which selects the clock of the timers.
    Register::new(0x4002_388C, 1 << 24, 0),
    // FLASH_ACR.
    Register::new(0x4002_3C00, 0x1F0F, 0x704),
    // PWR_CR: VOS, ODEN, ODSWEN; the voltage detector.
    Register::new(0x4000_7000, 0x3_C000, 0xC000).fixed(),
    Register::new(0x4000_7000, 0xF0, 0xD0),
    // GPIO A, B, C: modes without that of TXD, speeds, pulls, alternate functions.
    Register::new(0x4002_0000, !(0b11 << 24), 0xA880_0400),
    Register::new(0x4002_0008, !0, 0x0D00_0000),
    Register::new(0x4002_000C, !0, 0x6440_0000),
    Register::new(0x4002_0024, !0, 0x0009_9000),
    Register::new(0x4002_0400, !0, 0xA912_0286),
    Register::new(0x4002_0408, !0, 0xCC00_00C0),
    Register::new(0x4002_040C, !0, 0x1001_0100),
    Register::new(0x4002_0420, !0, 2),
    Register::new(0x4002_0424, !0, 0x5550_0002),
    Register::new(0x4002_0800, !0, 0x5003),
    Register::new(0x4002_080C, !0, 0),
    // TIM3: CR2, SMCR, CCMR2, CCER, PSC, ARR, CR1.
    Register::new(0x4000_0404, 0xFFFF, 0),
    Register::new(0x4000_0408, 0xFFFF, 0),
    Register::new(0x4000_041C, 0xFFFF, 0x68),
    Register::new(0x4000_0420, 0xFFFF, 0x100),
    Register::new(0x4000_0428, 0xFFFF, 0x3F),
    Register::new(0x4000_042C, 0xFFFF, 0x3E7),
    Register::new(0x4000_0400, 0xFFFF, 0x81),
    // SPI2: CR1, CR2, I2SCFGR.
    Register::new(0x4000_3800, 0xFFFF, 0x35C),
    Register::new(0x4000_3804, 0xFFFF, 0),
    Register::new(0x4000_381C, 0xFFFF, 0),
    // GPIO A, B, C: the outputs are push-pull. GPIOA: TXD is recessive until the controller has it.
    Register::new(0x4002_0004, 0xFFFF, 0),
    Register::new(0x4002_0404, 0xFFFF, 0),
    Register::new(0x4002_0804, 0xFFFF, 0),
    Register::new(0x4002_0014, 1 << 12, 0x1000),
    // CPACR: the floating-point unit. MPU_CTRL: the MPU is off.
    Register::new(0xE000_ED88, !0, 0x00F0_0000),
    Register::new(0xE000_ED94, 0b111, 0),
];
