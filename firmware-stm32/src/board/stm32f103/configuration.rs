//! The registers that only the boot changes.

use crate::board::registers::Register;
use crate::board::{SPI_ADDRESS, SPI_PULL};

/// The registers of the [`Configuration`](crate::board::Configuration).
pub(in crate::board) const REGISTERS: [Register; 28] = [
    // RCC: the resets of APB2 and APB1, the enables, the oscillators without their ready flags, the clock tree without SWS. The main loop
    // switches TIM4 on.
    Register::new(0x4002_100C, !0),
    Register::new(0x4002_1010, !0),
    Register::new(0x4002_1014, !0),
    Register::new(0x4002_1018, !0),
    Register::new(0x4002_101C, !(1 << 2)),
    // Fixed: HSEON, HSEBYP, PLLON; PLLSRC, PLLXTPRE, PLLMUL.
    Register::new(0x4002_1000, 0x010D_00F9).with_fixed(0x0105_0000),
    Register::new(0x4002_1004, !0b1100).with_fixed(0x003F_0000),
    // FLASH_ACR without PRFTBS. Fixed above 24 MHz: PRFTBE (PM0075).
    Register::new(0x4002_2000, 0x1F).with_fixed(1 << 4),
    // PWR_CR: the voltage detector.
    Register::new(0x4000_7000, 0xF0),
    // AFIO_MAPR without SWJ_CFG, which cannot be read. Written as 000, the debug port stays on.
    Register::new(0x4001_0004, 0x00FF_FFFF).with_others(0),
    // GPIO A, B, C: modes without that of TXD; pull-ups of the accelerometer's output and of RXD, level of TXD.
    Register::new(0x4001_0800, !0),
    Register::new(0x4001_0804, !0),
    SPI_PULL,
    Register::new(0x4001_0C00, !0),
    Register::new(0x4001_0C04, !0xF0),
    Register::new(0x4001_0C0C, 0b11 << 8),
    Register::new(0x4001_1000, !0),
    Register::new(0x4001_1004, !0),
    // TIM3: CR2, SMCR, CCMR2, CCER, PSC, ARR, CR1.
    Register::new(0x4000_0404, 0xFFFF),
    Register::new(0x4000_0408, 0xFFFF),
    Register::new(0x4000_041C, 0xFFFF),
    Register::new(0x4000_0420, 0xFFFF),
    Register::new(0x4000_0428, 0xFFFF),
    Register::new(0x4000_042C, 0xFFFF),
    Register::new(0x4000_0400, 0xFFFF),
    // SPI: CR1, CR2, and I2SCFGR, which SPI1 does not have: it reads as 0 there.
    Register::new(SPI_ADDRESS, 0xFFFF),
    Register::new(SPI_ADDRESS + 4, 0xFFFF),
    Register::new(SPI_ADDRESS + 0x1C, 0xFFFF),
];
